//! `ballmark reproduce`: a paper's experiment on simulated worlds, its tables and ours side by side.

use super::{
    Outcome,
    compare::{compared, in_json, make_writable, sheets_text, tell, write_json, write_sheets},
    localise::write_text,
    print,
    progress::Progress,
};
use crate::{
    error::{Error, Result},
    experiment::{
        reproduce::Paper,
        ruizmayor2006::{self, Ruizmayor2006Config},
        thrun1998::{self, Thrun1998Config},
    },
    report::{
        self,
        comparison::{self, Sheet},
        reproduction,
    },
};
use std::path::{Path, PathBuf};

/// Reproduce a paper's tables on simulated worlds, ours beside the paper's.
///
/// thrun1998: one to four learned features, doors and ceiling lights on three data sets, by one snapshot and from a start anywhere
/// (Table 3, Figs. 3 to 8, readings for one bit). duckett1998: evidence-based localisation, a landmark classifier and dead reckoning in six environments (Table 2, Fig. 6).
/// duckett2000: six landmark recognition systems in four environments (Tables 2 and 3, Fig. 6). ruizmayor2006: what a correction by a local
/// search makes of priors that are off (Figs. 7 to 9). The papers' recordings are
/// lost; the worlds were built from what the papers tell, and nothing was tuned to their figures.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark reproduce duckett1998 --toy")]
pub struct Arguments {
    /// thrun1998, duckett1998, duckett2000 or ruizmayor2006.
    #[arg(value_name = "PAPER")]
    paper: Paper,
    /// Folder for the record (JSON), the tables (CSV, Markdown, LaTeX), the pictures (SVG) and the resolved configuration.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The one seed of the run: worlds, learning, permutations, resamples.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Few trials and resamples only: does it work here? The figures mean little.
    #[arg(long, visible_alias = "quick")]
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
    let paper = arguments.paper;
    let unpacked = tempfile::tempdir()
        .map_err(|e| Error::io("cannot make a temporary folder", std::env::temp_dir(), e))?;
    paper.unpack(unpacked.path())?;
    let Some(configuration) = paper.configuration() else {
        return match paper {
            Paper::Ruizmayor2006 => ruizmayor2006(&arguments, unpacked.path(), out),
            _ => thrun1998(&arguments, out),
        };
    };
    let config = unpacked.path().join(configuration);
    let comparison = compared(&config, arguments.seed, arguments.toy, out)?;
    let mut sheets = reproduction::sheets(paper, &comparison.record);
    sheets.extend(comparison::sheets(&comparison));
    tell(&comparison, sheets, true, out, arguments.json)
}

fn thrun1998(arguments: &Arguments, out: Option<&Path>) -> Result<Outcome> {
    let config = Thrun1998Config::default();
    let config = Thrun1998Config {
        seed: arguments.seed.unwrap_or(config.seed),
        ..if arguments.toy { config.toy() } else { config }
    };
    let mut progress: Option<Progress> = None;
    let record = thrun1998::run(&config, &mut |done, all, next| {
        let bar = progress.get_or_insert_with(|| Progress::new("reproducing", all));
        bar.at(done, next);
    });
    if let Some(bar) = progress {
        bar.done();
    }
    let record = record?;
    let sheets = report::thrun1998::sheets(&record);
    let pictures = report::thrun1998::pictures(&record)?;
    write_and_print(
        "thrun1998",
        (&record, &record.config),
        (&sheets, pictures),
        out,
        arguments.json,
    )
}

fn ruizmayor2006(arguments: &Arguments, worlds: &Path, out: Option<&Path>) -> Result<Outcome> {
    let config = Ruizmayor2006Config::default();
    let config = Ruizmayor2006Config {
        seed: arguments.seed.unwrap_or(config.seed),
        ..if arguments.toy { config.toy() } else { config }
    };
    let mut progress: Option<Progress> = None;
    let record = ruizmayor2006::run(&config, worlds, &mut |done, all, next| {
        let bar = progress.get_or_insert_with(|| Progress::new("reproducing", all));
        bar.at(done, next);
    });
    if let Some(bar) = progress {
        bar.done();
    }
    let record = record?;
    let sheets = report::ruizmayor2006::sheets(&record);
    let pictures = report::ruizmayor2006::pictures(&record)?;
    write_and_print(
        "ruizmayor2006",
        (&record, &record.config),
        (&sheets, pictures),
        out,
        arguments.json,
    )
}

/// Prints the tables, or the record as JSON, and writes everything to a folder.
fn write_and_print(
    name: &str,
    (record, config): (&impl serde::Serialize, &impl serde::Serialize),
    (sheets, pictures): (&[Sheet], Vec<(String, String)>),
    out: Option<&Path>,
    json: bool,
) -> Result<Outcome> {
    if let Some(folder) = out {
        write_json(&folder.join(format!("{name}.json")), record)?;
        write_json(&folder.join("config.json"), config)?;
        write_sheets(folder, sheets, &[])?;
        for (name, svg) in pictures {
            write_text(&folder.join(format!("{name}.svg")), &svg)?;
        }
    }
    match json {
        true => print(&(in_json(record)? + "\n"))?,
        false => print(&sheets_text(sheets))?,
    }
    Ok(Outcome::Done)
}
