//! All missing cells on this machine, as many at once as cores and memory have room for.

use super::{
    attempt::{Attempt, Ended, LOOKED_AT, Runner, Started},
    cell::Cell,
    folder::Sweep,
    memory::{ASSUMED_BYTES, available_bytes, fits},
    scratch::clear_left_behind,
};
use crate::error::Result;
use std::{
    collections::VecDeque,
    fs,
    path::Path,
    time::{Duration, Instant, SystemTime},
};

/// How often free memory is asked for where it stops a cell, and cells that run elsewhere are tried.
const ASKED_AGAIN: Duration = Duration::from_millis(200);
/// A cell may take more than those before it took.
const MARGIN: f64 = 1.2;

/// How many cells run at once, and how it was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Cells at once, where memory allows.
    pub jobs: usize,
    /// Threads of each.
    pub threads: usize,
}

impl Share {
    /// Cores dealt among cells: as many cells as cores with a thread each, or so many as asked for; where fewer are left, they have more
    /// threads. One thread a cell wastes nothing on waiting for others.
    ///
    /// ```
    /// use ballmark::experiment::sweep::Share;
    /// assert_eq!(Share::of(8, None, 100), Share { jobs: 8, threads: 1 });
    /// assert_eq!(Share::of(8, Some(3), 100), Share { jobs: 3, threads: 2 });
    /// assert_eq!(Share::of(8, None, 2), Share { jobs: 2, threads: 4 });
    /// ```
    pub fn of(cores: usize, jobs: Option<usize>, cells: usize) -> Self {
        let jobs = jobs.unwrap_or(cores).min(cells).max(1);
        Self {
            jobs,
            threads: (cores / jobs).max(1),
        }
    }
}

/// How far a run is.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Cells with an end, failed ones among them.
    pub ended: usize,
    /// Cells that were to be run.
    pub all: usize,
    /// Cells that run.
    pub running: usize,
    /// The cell that has just failed, and why.
    pub failed: Option<(&'a Cell, &'a str)>,
}

/// What came of a run.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Ran {
    /// Cells that had a result before.
    pub before: usize,
    /// Cells that have one now, by this run.
    pub done: usize,
    /// By another at the same time.
    pub elsewhere: usize,
    /// Those that failed, with why, by number.
    pub failed: Vec<(Cell, String)>,
    /// Was it ended before all had been tried?
    pub is_cancelled: bool,
}

/// A cell that is still to be run.
struct Waiting {
    cell: Cell,
    /// Found running elsewhere; when its failure had been written by then, if ever.
    elsewhere: Option<Option<SystemTime>>,
}

/// Runs every cell of a sweep that has no result. Each is tried once; one that another process runs is waited for, and run here if that
/// process ends without a word of it.
///
/// # Errors
/// Where the plan can't be read, or a result's folder can't be written to. What a cell fails of is in [`Ran::failed`].
pub fn run_missing(
    sweep: &Sweep,
    runner: &Runner,
    jobs: usize,
    progress: &mut dyn FnMut(Progress),
    is_cancelled: &dyn Fn() -> bool,
) -> Result<Ran> {
    clear_left_behind(sweep)?;
    let done = sweep.done()?;
    let mut cells = sweep.cells()?;
    let planned = cells.len();
    cells.retain(|cell| !done.contains(&cell.name));
    cells.sort_by_key(|cell| cell.number);
    let all = cells.len();
    let mut ran = Ran {
        before: planned - all,
        ..Ran::default()
    };
    let mut waiting: VecDeque<Waiting> = cells
        .into_iter()
        .map(|cell| Waiting {
            cell,
            elsewhere: None,
        })
        .collect();
    let mut running: Vec<Box<Attempt>> = Vec::new();
    let mut most_bytes = measured_bytes(sweep);
    let mut asked: Option<Instant> = None;
    while !waiting.is_empty() || !running.is_empty() {
        if is_cancelled() {
            ran.is_cancelled = true;
            return Ok(ran); // what runs ends with its `Attempt`
        }
        let mut failed = Vec::new();
        let mut at = 0;
        while at < running.len() {
            let ended = running[at].poll(sweep);
            if matches!(ended, Ok(None)) {
                at += 1;
                continue;
            }
            let attempt = running.swap_remove(at);
            most_bytes = most_bytes.max(Some(attempt.peak_bytes()).filter(|bytes| *bytes > 0));
            match ended {
                Ok(Some(Ended::Failed(why))) => failed.push((attempt.cell().clone(), why)),
                // Neither a result nor its failure could be written: the next may have more room.
                Err(fault) => failed.push((attempt.cell().clone(), fault.to_string())),
                Ok(_) => ran.done += 1,
            }
            asked = None;
        }
        let may_ask = asked.is_none_or(|asked| asked.elapsed() >= ASKED_AGAIN);
        if running.len() < jobs && !waiting.is_empty() && may_ask {
            let mut tried = 0;
            while running.len() < jobs && tried < waiting.len() {
                if !has_room(most_bytes, &running) {
                    break;
                }
                let Some(next) = waiting.pop_front() else {
                    break;
                };
                match started(sweep, runner, next) {
                    Next::Running(attempt) => running.push(attempt),
                    Next::Later(next) => {
                        tried += 1;
                        waiting.push_back(next);
                    }
                    Next::Done => ran.elsewhere += 1,
                    Next::Failed(cell, why) => failed.push((cell, why)),
                }
            }
            asked = (running.len() < jobs).then(Instant::now);
        }
        for (cell, why) in failed {
            ran.failed.push((cell, why));
            report(progress, &ran, all, running.len(), ran.failed.last());
        }
        report(progress, &ran, all, running.len(), None);
        std::thread::sleep(LOOKED_AT);
    }
    ran.failed.sort_by_key(|(cell, _)| cell.number);
    Ok(ran)
}

fn report(
    progress: &mut dyn FnMut(Progress),
    ran: &Ran,
    all: usize,
    running: usize,
    failed: Option<&(Cell, String)>,
) {
    progress(Progress {
        ended: ran.done + ran.elsewhere + ran.failed.len(),
        all,
        running,
        failed: failed.map(|(cell, why)| (cell, why.as_str())),
    });
}

enum Next {
    Running(Box<Attempt>),
    Later(Waiting),
    Done,
    Failed(Cell, String),
}

fn started(sweep: &Sweep, runner: &Runner, next: Waiting) -> Next {
    let failure = sweep.failure(&next.cell.name);
    if let Some(before) = next.elsewhere
        && written(&failure) != before
        && !sweep.result(&next.cell.name).exists()
        && super::lock::Lock::holder(&sweep.lock(&next.cell.name)).is_none()
    {
        let why = fs::read_to_string(&failure).unwrap_or_default();
        return Next::Failed(next.cell, why.trim_end().to_string());
    }
    match Attempt::start(sweep, &next.cell, runner) {
        Ok(Started::Running(attempt)) => Next::Running(attempt),
        Ok(Started::DoneBefore) => Next::Done,
        Ok(Started::Elsewhere) => Next::Later(Waiting {
            elsewhere: next.elsewhere.or_else(|| Some(written(&failure))),
            cell: next.cell,
        }),
        Err(fault) => Next::Failed(next.cell, fault.to_string()),
    }
}

fn written(file: &Path) -> Option<SystemTime> {
    fs::metadata(file).ok()?.modified().ok()
}

fn has_room(most_bytes: Option<u64>, running: &[Box<Attempt>]) -> bool {
    let of_a_cell = of_a_cell(most_bytes);
    let held: Vec<u64> = running.iter().map(|a| a.resident_bytes()).collect();
    available_bytes().is_none_or(|available| fits(available, of_a_cell, &held))
}

/// What one more cell is taken to need, in bytes: a fifth more than the most that one was seen to take.
pub fn of_a_cell(most_bytes: Option<u64>) -> u64 {
    most_bytes.map_or(ASSUMED_BYTES, |bytes| (MARGIN * bytes as f64) as u64)
}

/// The most memory that a cell of this sweep was seen to take; none where none has run.
pub fn measured_bytes(sweep: &Sweep) -> Option<u64> {
    let times = fs::read_to_string(sweep.times()).unwrap_or_default();
    let peak = |line: &str| {
        let line: serde_json::Value = serde_json::from_str(line).ok()?;
        line["peak_bytes"].as_u64().filter(|bytes| *bytes > 0)
    };
    times.lines().filter_map(peak).max()
}
