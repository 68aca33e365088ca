//! How far a sweep is.

use super::{cell::Cell, folder::Sweep, lock::Lock, plan::described};
use crate::error::Result;
use serde::Serialize;

/// A cell that failed when it was last tried.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FailedCell {
    /// Its name.
    pub cell: String,
    /// Its keys and seed, for a reader.
    pub what: String,
    /// Why, with the last lines that it printed.
    pub why: String,
}

/// A cell that a process runs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RunningCell {
    /// Its name.
    pub cell: String,
    /// Its keys and seed, for a reader.
    pub what: String,
    /// Number and machine of the process, as far as it said.
    pub process: String,
}

/// How far a sweep is. Every cell is done, running, failed or missing.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Status {
    /// Cells of the plan.
    pub cells: usize,
    /// With a result.
    pub done: usize,
    /// Held by a process that lives.
    pub running: Vec<RunningCell>,
    /// Tried in vain; they are tried again by the next run.
    pub failed: Vec<FailedCell>,
    /// Names of those never tried, or whose process ended without a word.
    pub missing: Vec<String>,
    /// Results that the plan has no cell for: of a plan before.
    pub of_other_plans: usize,
}

impl Status {
    /// Looks at a sweep's folder.
    ///
    /// # Errors
    /// Where it can't be read.
    pub fn of(sweep: &Sweep) -> Result<Self> {
        let (done, failed) = (sweep.done()?, sweep.failed()?);
        let mut cells = sweep.cells()?;
        cells.sort_by_key(|cell| cell.number);
        let locked = sweep.locked()?;
        let mut status = Self {
            cells: cells.len(),
            ..Self::default()
        };
        for Cell {
            name, keys, seed, ..
        } in &cells
        {
            if done.contains(name) {
                status.done += 1;
                continue;
            }
            let holder = locked
                .contains(name)
                .then(|| Lock::holder(&sweep.lock(name)));
            let what = || described(keys, *seed);
            if let Some(process) = holder.flatten() {
                status.running.push(RunningCell {
                    cell: name.clone(),
                    what: what(),
                    process,
                });
            } else if failed.contains(name) {
                let text = std::fs::read_to_string(sweep.failure(name)).unwrap_or_default();
                let why = text.split_once('\n').map_or("", |(_, why)| why);
                status.failed.push(FailedCell {
                    cell: name.clone(),
                    what: what(),
                    why: why.trim_end().to_string(),
                });
            } else {
                status.missing.push(name.clone());
            }
        }
        status.of_other_plans = done.len() - status.done;
        Ok(status)
    }
}
