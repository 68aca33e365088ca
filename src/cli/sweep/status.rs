//! `ballmark sweep status`.

use super::in_a_line;
use crate::{
    cli::{Outcome, files::in_json, print},
    error::Result,
    experiment::sweep::{Status, Sweep},
    report::{Cell, Table},
};
use std::path::PathBuf;

/// Say how many cells of a sweep are done, running, failed and missing.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark sweep plan configs/sweeps/corridor-small.toml -o sweep
  ballmark sweep status sweep")]
pub struct Arguments {
    /// The sweep's folder.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// One JSON object instead of a table, with the names of the cells.
    #[arg(long)]
    json: bool,
}

/// Cells of a kind that the table names.
const NAMED: usize = 20;

pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let sweep = Sweep::open(&arguments.folder)?;
    let status = Status::of(&sweep)?;
    if arguments.json {
        print(&(in_json(&status)? + "\n"))?;
        return Ok(Outcome::Done);
    }
    let mut table = Table::new(["cells", "done", "running", "failed", "missing"]);
    let counts = [
        status.cells,
        status.done,
        status.running.len(),
        status.failed.len(),
        status.missing.len(),
    ];
    table.row(counts.map(|count| Cell::Count(count as u64)));
    for running in status.running.iter().take(NAMED) {
        table.caption(format!(
            "running: {} ({}), process {}",
            running.cell, running.what, running.process
        ));
    }
    for failed in status.failed.iter().take(NAMED) {
        let why = in_a_line(&failed.why);
        table.caption(format!("failed: {} ({}): {why}", failed.cell, failed.what));
    }
    let unnamed = [status.running.len(), status.failed.len()];
    let unnamed: usize = unnamed.into_iter().map(|n| n.saturating_sub(NAMED)).sum();
    if unnamed > 0 {
        table.caption(format!("and {unnamed} more: --json"));
    }
    if status.of_other_plans > 0 {
        table.caption(format!(
            "besides, results of {} cells that the plan does not have: of a plan before",
            status.of_other_plans
        ));
    }
    print(&table.text())?;
    Ok(Outcome::Done)
}
