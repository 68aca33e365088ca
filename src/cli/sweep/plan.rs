//! `ballmark sweep plan`.

use crate::{
    cli::{Outcome, files::write_text, print},
    error::{Error, Result},
    experiment::sweep::{Status, Sweep, make_plan, parallel_line, slurm_script},
    storage,
};
use std::path::{Path, PathBuf};

/// Make the cells of a sweep file, having read each as its command will.
///
/// A folder that holds an earlier plan keeps its results: cells that are the same are done.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark sweep plan configs/sweeps/corridor-small.toml -o sweep")]
pub struct Arguments {
    /// The sweep file; file names in it are relative to it.
    #[arg(value_name = "S.toml")]
    file: PathBuf,
    /// Folder of the sweep; not said: called as the file is, without its ending, in the current one.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// One JSON object instead of words: folder, cells, done.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<Outcome> {
    let planned = make_plan(&arguments.file)?;
    let folder = match (&arguments.output, arguments.file.file_stem()) {
        (Some(folder), _) => folder.clone(),
        (None, Some(stem)) => PathBuf::from(stem),
        (None, None) => return Err(Error::usage("no folder; expected -o DIR")),
    };
    let text = storage::read_file(&arguments.file)?;
    let sweep = Sweep::create(&folder, &planned, &text)?;
    let script = folder.join("run.slurm");
    write_text(&script, &slurm_script(&sweep))?;
    let status = Status::of(&sweep)?;
    print(&match arguments.json {
        true => {
            let told = serde_json::json!({
                "folder": folder,
                "cells": status.cells,
                "done": status.done,
            });
            format!("{told}\n")
        }
        false => told(&sweep, &folder, &script, &status),
    })?;
    Ok(Outcome::Done)
}

/// What there is, and the ways to go on.
fn told(sweep: &Sweep, folder: &Path, script: &Path, status: &Status) -> String {
    let plan = &sweep.plan;
    let bytes: u64 = plan
        .data
        .iter()
        .flat_map(|d| &d.files)
        .map(|f| f.bytes)
        .sum();
    let keys = plan.keys.join(", ");
    let differ = match keys.is_empty() {
        true => String::new(),
        false => format!(", which differ in {keys}"),
    };
    let folder = folder.display();
    format!(
        "{} cells of `{}` in {folder}{differ}; {} done\n\
         data: {} files or sets of files, {:.1} MB\n\
         here:          ballmark sweep run {folder}\n\
         with Ray:      python examples/sweep/ray_sweep.py {folder}\n\
         with Slurm:    sbatch {}\n\
         with parallel: {}\n\
         then:          ballmark sweep collect {folder}\n",
        status.cells,
        plan.base.command.name(),
        status.done,
        plan.data.len(),
        bytes as f64 / 1e6,
        script.display(),
        parallel_line(sweep)
    )
}
