//! `ballmark reproduce`: a paper's experiment on simulated worlds, its tables and ours side by side.

use super::{
    Outcome,
    files::{in_json, make_writable, write_json},
    page::{CONFIG, write_page},
    picture::write_picture,
    print,
    progress::Progress,
    sheets::{sheets_text, write_sheets},
    warn,
};
use crate::{
    error::{Error, Result},
    experiment::{
        over_seeds::{self, Reproduction, Seeds},
        reproduce::Paper,
        ruizmayor2006::{self, Ruizmayor2006Config},
        thrun1998::{self, Thrun1998Config},
    },
    report::{
        self, Page,
        comparison::{Sheet, sheet_parts},
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
///
/// The two of Duckett & Nehmzow are played with ten seeds, side by side: figures are means with 95 % intervals, and whether the
/// paper's agree is worked out from them. For one seed in detail: ballmark compare configs/duckett1998.toml.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark reproduce ruizmayor2006 --quick")]
pub struct Arguments {
    /// thrun1998, duckett1998, duckett2000 or ruizmayor2006.
    #[arg(value_name = "PAPER", required_unless_present = "redraw")]
    paper: Option<Paper>,
    /// Folder for a page to look at (index.html), the record (JSON), the tables (text, CSV, Markdown, LaTeX), the pictures (SVG)
    /// and the resolved configuration.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The one seed of the run, or the first of ten: worlds, learning, permutations, resamples.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Few trials and resamples only, three seeds, and of duckett2000 environments A and B: does it work here? The figures mean
    /// little.
    #[arg(long, visible_alias = "quick")]
    toy: bool,
    /// Draw tables and pictures again from this record of duckett1998 or duckett2000.
    #[arg(long, value_name = "RECORD.json", conflicts_with_all = ["paper", "seed", "toy"])]
    redraw: Option<PathBuf>,
    /// One JSON object, the whole record, instead of tables.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let out = arguments.out.as_deref();
    if let Some(folder) = out {
        make_writable(folder)?;
    }
    if let Some(record) = &arguments.redraw {
        return tell(&Reproduction::read(record)?, false, out, arguments.json);
    }
    match arguments.paper {
        Some(Paper::Thrun1998) => thrun1998(&arguments, out),
        Some(Paper::Ruizmayor2006) => {
            let unpacked = unpacked(Paper::Ruizmayor2006)?;
            ruizmayor2006(&arguments, unpacked.path(), out)
        }
        Some(paper) => over_seeds(paper, &arguments, out),
        None => Err(Error::usage("no paper; expected PAPER")), // clap sees to it
    }
}

/// The paper's files in a folder that goes with the last use of it.
fn unpacked(paper: Paper) -> Result<tempfile::TempDir> {
    let folder = tempfile::tempdir()
        .map_err(|e| Error::io("cannot make a temporary folder", std::env::temp_dir(), e))?;
    paper.unpack(folder.path())?;
    Ok(folder)
}

/// A paper whose experiment is a comparison, with several seeds.
fn over_seeds(paper: Paper, arguments: &Arguments, out: Option<&Path>) -> Result<Outcome> {
    let seeds = Seeds::default();
    let seeds = Seeds {
        first: arguments.seed.unwrap_or(seeds.first),
        ..if arguments.toy { seeds.toy() } else { seeds }
    };
    let unpacked = unpacked(paper)?;
    let mut progress: Option<Progress> = None;
    let reproduced = over_seeds::reproduce(paper, &seeds, unpacked.path(), &mut |at| {
        let bar = progress.get_or_insert_with(|| Progress::new("reproducing", at.all));
        bar.at(at.done, at.now);
    });
    if let Some(bar) = progress {
        bar.done();
    }
    tell(&reproduced?, true, out, arguments.json)
}

/// Prints the tables, or the record as JSON, and writes everything to a folder: the record too, where it `is_new`.
fn tell(
    reproduction: &Reproduction,
    is_new: bool,
    out: Option<&Path>,
    json: bool,
) -> Result<Outcome> {
    let failures = reproduction.failures();
    let mut comparisons = reproduction.comparisons.iter();
    if !comparisons.any(|comparison| comparison.record.any_done()) {
        let why = failures
            .first()
            .map_or("nobody was asked", |failure| &failure.why);
        return Err(Error::work(format!("nothing could be compared: {why}")));
    }
    let sheets = reproduction::sheets(reproduction)?;
    let captions = reproduction::caption_lines(reproduction);
    if let Some(folder) = out {
        if is_new {
            let record = format!("{}.json", reproduction.paper);
            write_json(&folder.join(record), reproduction)?;
            write_json(&folder.join(CONFIG), &resolved(reproduction))?;
        }
        write_sheets(folder, &sheets, &captions)?;
        let pictures = reproduction::pictures(reproduction)?;
        for (name, svg) in &pictures {
            write_picture(&folder.join(name), svg)?;
        }
        let title = format!("{} reproduced", reproduction.paper);
        let resolved = format!("{:#}\n", resolved(reproduction));
        write_page(
            folder,
            &content(title, &sheets, pictures, &captions, resolved),
        )?;
    }
    match json {
        true => print(&(in_json(reproduction)? + "\n"))?,
        false => print(&(sheets_text(&sheets) + &captions.join("\n") + "\n"))?,
    }
    for failure in &failures {
        let [section, system, dataset] = &failure.place;
        let seeds: Vec<String> = failure.seeds.iter().map(u64::to_string).collect();
        let (seeds, why) = (seeds.join(", "), &failure.why);
        warn(&format!(
            "failed: [{section}] {system} on {dataset} with seed {seeds}: {why}"
        ));
    }
    Ok(match failures.is_empty() {
        true => Outcome::Done,
        false => Outcome::Lossy,
    })
}

/// What was compared, to the last constant.
fn resolved(reproduction: &Reproduction) -> serde_json::Value {
    let compared = reproduction
        .comparisons
        .first()
        .map(|first| &first.record.config);
    serde_json::json!({
        "crate_version": reproduction.version,
        "paper": reproduction.paper,
        "seeds": reproduction.seeds,
        "compare": compared,
    })
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

/// What the page of a reproduction shows.
fn content(
    title: String,
    sheets: &[Sheet],
    pictures: Vec<(String, String)>,
    captions: &[String],
    resolved: String,
) -> Page {
    Page {
        title,
        summary: vec![
            "The paper's experiment on simulated worlds, its figures and ours side by side.".into(),
        ],
        parts: sheet_parts(sheets, pictures, captions),
        config: vec![("Configuration, resolved".into(), resolved)],
        ..Page::default()
    }
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
        write_json(&folder.join(CONFIG), config)?;
        write_sheets(folder, sheets, &[])?;
        for (name, svg) in &pictures {
            write_picture(&folder.join(name), svg)?;
        }
        let resolved = serde_json::to_string_pretty(config);
        let resolved = resolved.map_err(|e| Error::work(format!("configuration: {e}")))?;
        let title = format!("{name} reproduced");
        write_page(folder, &content(title, sheets, pictures, &[], resolved))?;
    }
    match json {
        true => print(&(in_json(record)? + "\n"))?,
        false => print(&sheets_text(sheets))?,
    }
    Ok(Outcome::Done)
}
