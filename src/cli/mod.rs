//! The command line: arguments in, exit status out. Results on standard output, progress and warnings on standard error.

mod adapt;
mod compare;
mod completions;
mod dataset;
mod demo;
mod export;
mod features;
mod files;
mod import;
mod interrupt;
mod lifelong;
mod localise;
mod page;
mod picture;
mod pretrain;
mod progress;
mod reproduce;
mod rerun;
mod score;
mod sheets;
mod simulate;
mod sweep;
mod terminal;
mod train;
mod trajectory;
mod trials;
mod view;

use crate::error::{Error, Result};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::{
    ffi::OsString,
    io::{self, Write},
    process::ExitCode,
};

/// Learn a robot's own landmarks, localise with them, and judge the result.
#[derive(Debug, Parser)]
#[command(name = "ballmark", version, about, arg_required_else_help = true)]
#[command(after_help = "Example:
  ballmark demo --toy --out demo-report")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    terminal: terminal::Options,
}

/// One file a command.
#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Arguments),
    Import(import::Arguments),
    Simulate(simulate::Arguments),
    Pretrain(pretrain::Arguments),
    Train(train::Arguments),
    Localise(localise::Arguments),
    Adapt(adapt::Arguments),
    Features(features::Arguments),
    Export(export::Arguments),
    Compare(compare::Arguments),
    Trials(trials::Arguments),
    Score(score::Arguments),
    Trajectory(trajectory::Arguments),
    Reproduce(reproduce::Arguments),
    Lifelong(lifelong::Arguments),
    Sweep(sweep::Arguments),
    View(view::Arguments),
    Completions(completions::Completions),
    Man(completions::Man),
}

/// How a command ended when it did not fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Done, nothing lost (exit status 0).
    Done,
    /// Done, but something in the input was dropped or damaged, each counted and named (exit status 3).
    Lossy,
}

/// Runs the command that the arguments ask for; the exit status is the one users and scripts rely on: 0 done, 1 the work
/// failed, 2 the call is wrong, 3 done but something in the input was lost.
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os().collect()))
}

/// The same with the arguments of another program that carries the command, its name the first of them.
pub fn run_with(arguments: Vec<OsString>) -> u8 {
    ignore_file_size_signal();
    let words = arguments.iter().map(|a| a.to_string_lossy().into_owned());
    let color = terminal::color_of(words);
    page::remember(&arguments);
    let command = || Arguments::command().color(color);
    let parsed = command().try_get_matches_from(arguments);
    let parsed = parsed.and_then(|matches| Arguments::from_arg_matches(&matches));
    let arguments = match parsed {
        Ok(arguments) => arguments,
        Err(e) => {
            let _ = e.print(); // help goes to standard output, and to a wrong call the answer is the status
            return u8::try_from(e.exit_code()).unwrap_or(2);
        }
    };
    terminal::choose(arguments.terminal);
    if let Some(parent) = arguments.terminal.ends_with_parent {
        sweep::end_with(parent);
    }
    let result: Result<Outcome> = match arguments.command {
        Command::Demo(arguments) => demo::run(arguments),
        Command::Import(arguments) => import::run(arguments),
        Command::Simulate(arguments) => simulate::run(arguments),
        Command::Pretrain(arguments) => pretrain::run(arguments),
        Command::Train(arguments) => train::run(arguments),
        Command::Localise(arguments) => localise::run(arguments),
        Command::Adapt(arguments) => adapt::run(arguments),
        Command::Features(arguments) => features::run(arguments),
        Command::Export(arguments) => export::run(arguments),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Trials(arguments) => trials::run(arguments),
        Command::Score(arguments) => score::run(arguments),
        Command::Trajectory(arguments) => trajectory::run(arguments),
        Command::Reproduce(arguments) => reproduce::run(arguments),
        Command::Lifelong(arguments) => lifelong::run(arguments),
        Command::Sweep(arguments) => sweep::run(arguments),
        Command::View(arguments) => view::run(&arguments),
        Command::Completions(arguments) => completions::completions(&arguments, command()),
        Command::Man(arguments) => completions::man(&arguments, command()),
    };
    match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::Lossy) => 3,
        Err(error) => {
            warn(&format!("error: {error}"));
            if error.is_usage() { 2 } else { 1 }
        }
    }
}

/// Makes a write past the user's file-size limit (`ulimit -f`) an error like a full disk. By default the signal SIGXFSZ
/// ends the process on the spot: no word to the user, and the temporary file left lying.
fn ignore_file_size_signal() {
    #[cfg(unix)]
    {
        // The flag is never read: a handler that returns is enough for the write to answer "file too large". Where it
        // can't be installed we are no worse off than without it.
        let caught = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, caught);
    }
}

/// A line on standard error, but for notes where none are wanted; that it can't be written is no error.
pub(crate) fn warn(line: &str) {
    if terminal::is_quiet() && line.starts_with("note: ") {
        return;
    }
    let _ = writeln!(io::stderr(), "{}", terminal::painted(&terminal::fit(line)));
}

/// A result, on standard output. That the reader has seen enough (`ballmark … | head -1`) is no fault: files are still
/// written, and the exit status is that of the work.
pub(crate) fn print(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    let written = out
        .write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(|e| Error::io("cannot write", "standard output", e));
    match written {
        Err(error) if error.is_broken_pipe() => Ok(()),
        other => other,
    }
}
