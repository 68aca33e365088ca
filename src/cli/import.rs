//! `ballmark import`: a log becomes a dataset.

use super::Outcome;
use crate::error::Result;
use std::path::PathBuf;

/// Turn a robot's log into a dataset.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Logs to read.
    #[arg(required = true)]
    log: Vec<PathBuf>,
}

pub fn run(_arguments: Arguments) -> Result<Outcome> {
    Ok(Outcome::Done)
}
