//! `ballmark reproduce`: a paper's experiment on simulated worlds, its tables and ours side by side.

use super::{
    Outcome,
    compare::{compared, make_writable, tell},
};
use crate::{
    error::{Error, Result},
    experiment::reproduce::Paper,
    report::{comparison, reproduction},
};
use std::path::PathBuf;

/// Reproduce a paper's tables on simulated worlds, ours beside the paper's.
///
/// duckett1998: evidence-based localisation, a landmark classifier and dead reckoning in six environments (Table 2, Fig. 6).
/// duckett2000: six landmark recognition systems in four environments (Tables 2 and 3, Fig. 6). The papers' recordings are
/// lost; the worlds were built from what the papers tell, and nothing was tuned to their figures.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark reproduce duckett1998 --toy")]
pub struct Arguments {
    /// duckett1998 or duckett2000.
    #[arg(value_name = "PAPER")]
    paper: Paper,
    /// Folder for the record (JSON), the tables (CSV, Markdown, LaTeX), the pictures (SVG) and the resolved configuration.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The one seed of the run: worlds, learning, permutations, resamples.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Few trials and resamples only: does it work here? The figures mean little.
    #[arg(long)]
    toy: bool,
    /// One JSON object, the whole record, instead of tables.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let out = arguments.out.as_deref();
    if let Some(folder) = out {
        make_writable(folder)?;
    }
    let unpacked = tempfile::tempdir()
        .map_err(|e| Error::io("cannot make a temporary folder", std::env::temp_dir(), e))?;
    let paper = arguments.paper;
    paper.unpack(unpacked.path())?;
    let config = unpacked.path().join(paper.configuration());
    let comparison = compared(&config, arguments.seed, arguments.toy, out)?;
    let mut sheets = reproduction::sheets(paper, &comparison.record);
    sheets.extend(comparison::sheets(&comparison));
    tell(&comparison, sheets, true, out, arguments.json)
}
