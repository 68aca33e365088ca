//! `ballmark sweep`: one command with many configurations, here or on many machines, and one table of what came of it.

mod collect;
mod plan;
mod run;
mod status;

use super::Outcome;
use crate::error::Result;
use std::ffi::OsString;

/// Run one command with many configurations, and make one table of it.
///
/// A sweep file names a command (train, localise, compare, reproduce), what all cells share, and keys with lists of values; every combination
/// with every seed is a cell, named by a digest of program version, configuration and data. A cell's result is one file, written
/// whole: it is never run again, and one whose inputs changed has another name. `run` does what is missing on this machine; on others it
/// is done by `run-cell`: examples/sweep/ray_sweep.py for Ray, run.slurm in the sweep's folder. docs/sweeps.md has more.
#[derive(Debug, clap::Args)]
#[command(subcommand_required = true, arg_required_else_help = true)]
#[command(after_help = "Example:
  ballmark sweep plan configs/sweeps/corridor-small.toml -o sweep
  ballmark sweep run sweep
  ballmark sweep collect sweep")]
pub struct Arguments {
    #[command(subcommand)]
    step: Step,
}

#[derive(Debug, clap::Subcommand)]
enum Step {
    Plan(plan::Arguments),
    Run(run::Arguments),
    RunCell(run::CellArguments),
    Status(status::Arguments),
    Collect(collect::Arguments),
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    match arguments.step {
        Step::Plan(arguments) => plan::run(&arguments),
        Step::Run(arguments) => run::run(&arguments),
        Step::RunCell(arguments) => run::run_cell(&arguments),
        Step::Status(arguments) => status::run(&arguments),
        Step::Collect(arguments) => collect::run(arguments),
    }
}

/// Why a cell failed, in a line: what happened, and the last line that it printed.
fn in_a_line(why: &str) -> String {
    let mut lines = why.lines();
    let first = lines.next().unwrap_or_default();
    match lines.next_back() {
        Some(last) => format!("{first}; {last}"),
        None => first.to_string(),
    }
}

/// This program, and what stands before a command's name: as the Python package carries it, the interpreter and its module.
fn program() -> Result<Vec<OsString>> {
    let program = std::env::current_exe()
        .map_err(|e| crate::Error::work(format!("cannot find this program: {e}")))?;
    let name = program.file_name().unwrap_or_default().to_string_lossy();
    Ok(match name.starts_with("python") {
        true => vec![program.into(), "-m".into(), "ballmark".into()],
        false => vec![program.into()],
    })
}

/// Ends this process when the one that started it ends, however that does.
pub(super) fn end_with(parent: u32) {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{Signal, getppid, set_parent_process_death_signal};
        let _ = set_parent_process_death_signal(Some(Signal::KILL)); // without it the command runs to its end
        let now = getppid().and_then(|now| u32::try_from(now.as_raw_nonzero().get()).ok());
        if now != Some(parent) {
            std::process::exit(1); // it ended before it could be asked for
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = parent;
}
