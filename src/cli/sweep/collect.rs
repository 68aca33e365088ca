//! `ballmark sweep collect`.

use crate::{
    cli::{
        Outcome,
        files::{in_json, make_writable, write_json},
        print,
        sheets::{sheets_text, write_sheets},
        warn,
    },
    error::Result,
    experiment::sweep::{Collected, Sweep, collect_results},
    report::sweep::sheets,
};
use std::path::PathBuf;

/// Make one table of a sweep: means over seeds, 95 % intervals, paired differences to a baseline.
///
/// Figures are the headline figures of the command (train: error reductions; localise: robots found, errors after 10 m, recall; compare:
/// these of every system, and those of its other sections), or any number of a record by its dotted path. A cell without a
/// result is an error; with --holes it is left out and named.
///
/// Exit status: 0 done, 1 cells have no result, 2 the call is wrong, 3 done, but with holes.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark sweep plan configs/sweeps/corridor-small.toml -o sweep
  ballmark sweep run sweep
  ballmark sweep collect sweep --baseline features=2 --out table")]
pub struct Arguments {
    /// The sweep's folder.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Folder for the table (text, CSV, Markdown, LaTeX), all its numbers and every cell (CSV), and the record (JSON).
    #[arg(short, long, value_name = "OUT")]
    out: Option<PathBuf>,
    /// A figure instead of the headline figures, by its path in a cell's record: `validation.posterior_error_m`,
    /// `systems.kernel.recall_1m`. Of a list the number of an element from 0, or its name.
    #[arg(long, value_name = "PATH")]
    metric: Vec<String>,
    /// Average over a key as over seeds: `train.split.test_fold`, `data`. The last word of a key will do.
    #[arg(long, value_name = "KEY")]
    over: Vec<String>,
    /// Hold others against the combination with this value, all else being the same; several times for several keys. Not said: as the sweep
    /// file says, or against the first combination on the same data.
    #[arg(long, value_name = "KEY=VALUE", value_parser = pair)]
    baseline: Vec<(String, String)>,
    /// Leave out cells without a result, and name them.
    #[arg(long)]
    holes: bool,
    /// One JSON object, the whole record, instead of a table.
    #[arg(long)]
    json: bool,
}

fn pair(text: &str) -> std::result::Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("expected KEY=VALUE")?;
    Ok((key.trim().to_string(), value.trim().to_string()))
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    if let Some(folder) = &arguments.out {
        make_writable(folder)?;
    }
    let sweep = Sweep::open(&arguments.folder)?;
    // A key by its last word, where only one ends so.
    let whole = |key: String| {
        let ends = |known: &&String| known.rsplit('.').next() == Some(&key);
        let mut all = sweep.plan.keys.iter().filter(ends);
        match (sweep.plan.keys.contains(&key), all.next(), all.next()) {
            (false, Some(known), None) => known.clone(),
            _ => key,
        }
    };
    let baseline = arguments.baseline.into_iter();
    let wanted = Collected {
        metrics: arguments.metric,
        over: arguments.over.into_iter().map(whole).collect(),
        baseline: baseline.map(|(key, value)| (whole(key), value)).collect(),
        with_holes: arguments.holes,
    };
    let record = collect_results(&sweep, &wanted)?;
    let sheets = sheets(&record);
    if let Some(folder) = &arguments.out {
        write_sheets(folder, &sheets, &[])?;
        write_json(&folder.join("sweep.json"), &record)?;
    }
    print(&match arguments.json {
        true => in_json(&record)? + "\n",
        false => sheets_text(&sheets),
    })?;
    if record.holes.is_empty() {
        return Ok(Outcome::Done);
    }
    warn(&format!(
        "warning: {} of {} cells have no result and are left out",
        record.holes.len(),
        record.cells
    ));
    Ok(Outcome::Lossy)
}
