//! `ballmark sweep run` and `run-cell`.

use super::{in_a_line, program};
use crate::{
    cli::{Outcome, interrupt::Interrupt, print, progress::Progress, warn},
    error::{Error, Result},
    experiment::sweep::{
        Attempt, Ended, Ran, Runner, Share, Started, Sweep, available_bytes, described,
        measured_bytes, of_a_cell, run_missing,
    },
};
use std::{
    path::PathBuf,
    thread::{available_parallelism, sleep},
    time::Duration,
};

/// Run all cells of a sweep that have no result, on this machine.
///
/// Each cell is a process of its own, with one thread where there are as many cells as cores. One more is started where a core is free and
/// memory for it: what the largest cell so far took and a fifth (512 MB until one was measured), besides what those that run may still
/// grow to. A cell that fails is named, with its last lines in the sweep's folder; the others go on. Called again it does what is missing.
///
/// Exit status: 0 every cell has a result, 1 some failed.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark sweep plan configs/sweeps/corridor-small.toml -o sweep
  ballmark sweep run sweep --jobs 2")]
pub struct Arguments {
    /// The sweep's folder.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Most cells at once; not said: as many as cores.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Look for data by its SHA-256 in this folder first.
    #[arg(long, value_name = "CACHE")]
    data: Option<PathBuf>,
    /// One JSON object instead of words: cells, before, done, elsewhere, failed.
    #[arg(long)]
    json: bool,
}

/// Run one cell of a sweep, unless it has a result.
///
/// Exit status: 0 it has a result now, 1 it failed, or another process runs it, 2 there is no such cell.
#[derive(Debug, clap::Args)]
#[command(name = "run-cell")]
#[command(after_help = "Example:
  ballmark sweep plan configs/sweeps/corridor-small.toml -o sweep
  ballmark sweep run-cell sweep \\
    $(head -1 sweep/cells.jsonl | cut -c 10-25)")]
pub struct CellArguments {
    /// The sweep's folder.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The cell's name, as cells.jsonl has it.
    #[arg(value_name = "HASH")]
    cell: String,
    /// Look for data by its SHA-256 in this folder first, and where it was planned from after that.
    #[arg(long, value_name = "CACHE")]
    data: Option<PathBuf>,
    /// Keep the cell's configuration, model, output and messages in this folder; a cell that has a result is run again for them.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
}

/// How often it is tried whether a cell that seems to run elsewhere does: whoever looks how far a sweep is holds a lock for a moment.
const TRIES: usize = 20;
const BETWEEN_TRIES: Duration = Duration::from_millis(10);

pub fn run_cell(arguments: &CellArguments) -> Result<Outcome> {
    let sweep = Sweep::open(&arguments.folder)?;
    let cell = sweep.cell(&arguments.cell)?;
    let runner = Runner {
        program: program()?,
        cache: arguments.data.clone(),
        threads: None,
        keep: arguments.keep.clone(),
    };
    let interrupt = Interrupt::watched();
    let mut tries = 0;
    let attempt = loop {
        match Attempt::start(&sweep, &cell, &runner)? {
            Started::Running(attempt) => break attempt,
            Started::DoneBefore => {
                warn(&format!(
                    "note: cell {} has a result: nothing is run",
                    cell.name
                ));
                print(&format!("{}\n", sweep.result(&cell.name).display()))?;
                return Ok(Outcome::Done);
            }
            Started::Elsewhere if tries < TRIES => {
                tries += 1;
                sleep(BETWEEN_TRIES);
            }
            Started::Elsewhere => {
                return Err(Error::work(format!(
                    "cell {}: another process runs it",
                    cell.name
                )));
            }
        }
    };
    match attempt.wait(&sweep, &|| interrupt.is_set())? {
        Some(Ended::Done) => {
            print(&format!("{}\n", sweep.result(&cell.name).display()))?;
            Ok(Outcome::Done)
        }
        Some(Ended::Failed(why)) => {
            let (why, last) = why.split_once('\n').unwrap_or((&why, ""));
            last.lines().for_each(|line| warn(&format!("cell: {line}")));
            Err(Error::work(format!(
                "cell {} ({}): {why}",
                cell.name,
                described(&cell.keys, cell.seed)
            )))
        }
        None => Err(Error::cancelled(format!(
            "cell {}: cancelled; the same command runs it anew",
            cell.name
        ))),
    }
}

pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let sweep = Sweep::open(&arguments.folder)?;
    let left = sweep.plan.cells.saturating_sub(sweep.done()?.len());
    let cores = available_parallelism().map_or(1, usize::from);
    let share = Share::of(cores, arguments.jobs.map(usize::from), left);
    let stated = std::env::var("RAYON_NUM_THREADS").is_ok();
    let runner = Runner {
        program: program()?,
        cache: arguments.data.clone(),
        threads: (!stated).then_some(share.threads),
        keep: None,
    };
    if left > 0 {
        warn(&format!("note: {}", decided(&sweep, &share, cores)));
    }
    let interrupt = Interrupt::watched();
    let mut bar: Option<Progress> = None;
    let ran = run_missing(
        &sweep,
        &runner,
        share.jobs,
        &mut |at| {
            if let Some((cell, why)) = at.failed {
                let what = described(&cell.keys, cell.seed);
                let why = in_a_line(why);
                warn(&format!("failed: cell {} ({what}): {why}", cell.name));
            }
            let bar = bar.get_or_insert_with(|| Progress::new("cells", at.all));
            bar.at(at.ended, &format!("{} running", at.running));
        },
        &|| interrupt.is_set(),
    );
    if let Some(bar) = bar {
        bar.done();
    }
    told(&sweep, &ran?, arguments.json)
}

/// How many cells run at once, and why.
fn decided(sweep: &Sweep, share: &Share, cores: usize) -> String {
    let gib = |bytes: u64| bytes as f64 / f64::from(1u32 << 30);
    let measured = measured_bytes(sweep);
    let cell = gib(of_a_cell(measured));
    let how = match measured {
        Some(_) => "as measured and a fifth",
        None => "until one was measured",
    };
    let memory = match available_bytes() {
        Some(free) => format!("{:.1} GiB free, {cell:.2} GiB a cell {how}", gib(free)),
        None => "free memory unknown".to_string(),
    };
    format!(
        "at most {} at once, threads a cell: {}; {cores} cores, {memory}",
        share.jobs, share.threads
    )
}

fn told(sweep: &Sweep, ran: &Ran, json: bool) -> Result<Outcome> {
    let all = sweep.plan.cells;
    let done = ran.before + ran.done + ran.elsewhere;
    if json {
        let failed = ran.failed.iter();
        let failed: Vec<serde_json::Value> = failed
            .map(|(cell, why)| {
                serde_json::json!({
                    "cell": cell.name,
                    "what": described(&cell.keys, cell.seed),
                    "why": why,
                })
            })
            .collect();
        let told = serde_json::json!({
            "cells": all,
            "before": ran.before,
            "done": ran.done,
            "elsewhere": ran.elsewhere,
            "failed": failed,
        });
        print(&format!("{told}\n"))?;
    } else if !ran.is_cancelled && ran.failed.is_empty() {
        let elsewhere = match ran.elsewhere {
            0 => String::new(),
            count => format!(", {count} by another run"),
        };
        print(&format!(
            "{done} of {all} cells done: {} before, {} now{elsewhere}\n",
            ran.before, ran.done
        ))?;
    }
    if ran.is_cancelled {
        return Err(Error::cancelled(format!(
            "cancelled: {done} of {all} cells done; the same command goes on"
        )));
    }
    match ran.failed.first() {
        None => Ok(Outcome::Done),
        Some((cell, _)) => Err(Error::work(format!(
            "{} of {all} cells failed, {done} done; why stands in {} and others like it; the same command tries them again",
            ran.failed.len(),
            sweep.failure(&cell.name).display()
        ))),
    }
}
