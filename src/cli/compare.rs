//! `ballmark compare`: any systems on any datasets, each asked the same.

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
    experiment::compare::{
        CompareConfig, Comparison, ComparisonRecord, Folders, HandMade, compare,
    },
    experiment::sensor_models::Landmarks,
    localiser, recogniser,
    report::{
        Page,
        comparison::{
            Sheet, caption_lines, comparison_parts, comparison_summary, pictures, sheets,
        },
    },
    storage,
};
use std::path::{Path, PathBuf};

/// Compare any systems on any datasets: the same questions to all, one table each.
///
/// The configuration names [[dataset]]s (a `file`, or a `world` to be simulated at once) and [[system]]s (any recogniser or
/// localiser by its `kind`, with its constants, and the hand-made landmarks `door` and `ceiling_light`). The first lap maps
/// and the rest tests, unless [protocol] says otherwise. Each of [standard], [localisation], [recognition], [error_reduction] and
/// [landmarks] that is there makes a table. BaLL's filters are trained on the mapping part alone.
#[derive(Debug, clap::Args)]
#[command(after_long_help = help())]
pub struct Arguments {
    /// What is compared with what; file names in it are relative to it.
    #[arg(value_name = "C.toml", required_unless_present = "redraw")]
    config: Option<PathBuf>,
    /// Folder for a page to look at (index.html), the record (JSON), the tables (text, CSV, Markdown, LaTeX), the pictures (SVG, PNG), the
    /// trained models and the resolved configuration.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// The one seed of the run, in place of the configuration's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Few trials, resamples and steps of training only: does it work here? The figures mean little.
    #[arg(long)]
    toy: bool,
    /// Draw page, tables and pictures again from this record (`comparison.json`), without the data. The page has the player where
    /// the record's `player.json` lies beside it. From several records, their systems stand side by side where all were measured on the
    /// same protocol.
    #[arg(long, value_name = "RECORD.json", num_args = 1.., conflicts_with_all = ["config", "seed", "toy"])]
    redraw: Vec<PathBuf>,
    /// With several records: side by side also where their protocols differ. Such figures can't be compared.
    #[arg(long, requires = "redraw")]
    mixed: bool,
    /// One JSON object, the whole record, instead of tables.
    #[arg(long)]
    json: bool,
}

/// All kinds of systems, by what they can be asked, and an example.
fn help() -> String {
    let recognisers = recogniser::Kind::ALL.iter().map(|kind| kind.name());
    let localisers = localiser::Kind::ALL.iter().map(|kind| kind.name());
    let listed = |names: &mut dyn Iterator<Item = &'static str>| -> String {
        names.collect::<Vec<_>>().join(", ")
    };
    format!(
        "\
Kinds of recognisers (every section but [landmarks]): {}.

Kinds of localisers ([standard], [localisation]): {}, monte_carlo.

Sensor models of the grid Bayes filter (kind = \"bayes\", landmarks = one or several; [standard], [localisation]): {}.

Landmarks chosen by people ([localisation], [error_reduction], [landmarks]): {}.

Kinds of one's own: a program that uses the library registers them (examples/own_recogniser.rs).

A system that fails on a dataset says so in its cell, with the reason below the table; the others go on.

Exit status: 0 done, 1 nothing could be compared, 2 the call or the configuration is wrong, 3 done, but some cells failed.

Example:
  ballmark compare configs/compare-duckett1998-b.toml --toy --out b",
        listed(&mut recognisers.into_iter()),
        listed(&mut localisers.into_iter()),
        listed(&mut Landmarks::NAMES.into_iter()),
        listed(&mut HandMade::NAMES.into_iter()),
    )
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let out = arguments.out.as_deref();
    if let Some(folder) = out {
        make_writable(folder)?;
    }
    let comparison = match (arguments.redraw.split_first(), &arguments.config) {
        (Some((first, others)), _) => {
            let join = |joined: Comparison, file: &PathBuf| {
                joined
                    .joined(read(file)?, arguments.mixed)
                    .map_err(|fault| fault.in_file(file))
            };
            others.iter().try_fold(read(first)?, join)?
        }
        (None, Some(config)) => compared(config, arguments.seed, arguments.toy, out)?,
        (None, None) => return Err(Error::usage("no configuration; expected C.toml")), // clap sees to it
    };
    let is_new = arguments.redraw.is_empty();
    tell(
        &comparison,
        sheets(&comparison),
        is_new,
        out,
        arguments.json,
    )
}

/// Prints the tables, or the record as JSON, and writes everything to a folder: the record too, where it `is_new`.
pub(super) fn tell(
    comparison: &Comparison,
    sheets: Vec<Sheet>,
    is_new: bool,
    out: Option<&Path>,
    json: bool,
) -> Result<Outcome> {
    let record = &comparison.record;
    let failures = record.failures();
    if !record.any_done() {
        let why = failures.first().map_or("nobody was asked", |[.., why]| why);
        return Err(Error::work(format!("nothing could be compared: {why}")));
    }
    if let Some(folder) = out {
        if is_new {
            write_json(&folder.join("comparison.json"), comparison)?;
            write_json(&folder.join(CONFIG), &resolved(record))?;
            let beliefs = comparison.beliefs();
            if beliefs.iter().any(Option::is_some) {
                write_json(&folder.join(PLAYER), &beliefs)?;
            }
        }
        write_tables(folder, comparison, &sheets)?;
    }
    if json {
        print(&(in_json(comparison)? + "\n"))?;
    } else {
        print(&text(record, &sheets))?;
    }
    for line in failure_lines(&failures) {
        warn(&line);
    }
    Ok(match failures.is_empty() {
        true => Outcome::Done,
        false => Outcome::Lossy,
    })
}

/// A line a reason: what several cells of a dataset fail of is one line.
fn failure_lines(failures: &[[&str; 4]]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    let mut done: Vec<[&str; 2]> = Vec::new();
    for &[_, _, dataset, why] in failures {
        if done.contains(&[dataset, why]) {
            continue;
        }
        done.push([dataset, why]);
        let alike = failures.iter().filter(|f| f[2..] == [dataset, why]);
        let (mut sections, mut systems): (Vec<String>, Vec<&str>) = (Vec::new(), Vec::new());
        for [section, system, ..] in alike {
            let section = format!("[{section}]");
            if !sections.contains(&section) {
                sections.push(section);
            }
            if !systems.contains(system) {
                systems.push(system);
            }
        }
        let (sections, systems) = (sections.join(" "), systems.join(", "));
        lines.push(format!("failed: {sections} {systems} on {dataset}: {why}"));
    }
    lines
}

/// Compares as a file says, but for another seed, or at toy size.
pub(super) fn compared(
    file: &Path,
    seed: Option<u64>,
    toy: bool,
    out: Option<&Path>,
) -> Result<Comparison> {
    let mut config = CompareConfig::read(file)?;
    config.seed = seed.unwrap_or(config.seed);
    if toy {
        config.shrink_to_toy();
    }
    let kept = out.map(|folder| folder.join("models"));
    let temporary;
    let models = match &kept {
        Some(folder) => folder,
        None => {
            temporary = tempfile::tempdir().map_err(|e| {
                Error::io("cannot make a temporary folder", std::env::temp_dir(), e)
            })?;
            temporary.path()
        }
    };
    let folders = Folders {
        configuration: file.parent().unwrap_or(Path::new("")),
        models,
        keeps_beliefs: out.is_some(),
    };
    let mut progress: Option<Progress> = None;
    let compared = compare(&config, folders, &mut |at| {
        let bar = progress.get_or_insert_with(|| Progress::new("comparing", at.all));
        bar.at(at.done, at.now);
    });
    if let Some(bar) = progress {
        bar.done();
    }
    compared
}

fn read(file: &Path) -> Result<Comparison> {
    let expected = "expected `comparison.json` of `ballmark compare` of this version";
    let wrong = |fault: String| Error::file(file, format!("{fault}; {expected}"));
    let read = serde_json::from_slice(&storage::read_file(file)?);
    let mut comparison: Comparison = read.map_err(|e| wrong(e.to_string()))?;
    comparison.check().map_err(wrong)?;
    let player = file.with_file_name(PLAYER);
    if player.is_file() {
        let wrong = |fault: String| {
            Error::file(
                &player,
                format!("{fault}; expected what a comparison wrote beside its record"),
            )
        };
        let beliefs = serde_json::from_slice(&storage::read_file(&player)?);
        let beliefs = beliefs.map_err(|e| wrong(e.to_string()))?;
        comparison.set_beliefs(beliefs).map_err(wrong)?;
    }
    Ok(comparison)
}

/// What was compared, to the last constant.
fn resolved(record: &ComparisonRecord) -> serde_json::Value {
    let datasets = record.datasets.iter();
    let checksums = datasets.map(|d| (d.name.clone(), serde_json::json!(d.sha256)));
    serde_json::json!({
        "crate_version": record.version,
        "seed": record.seed,
        "dataset_sha256": checksums.collect::<serde_json::Map<_, _>>(),
        "compare": record.config,
    })
}

/// Every table in every format, every picture, and the page.
fn write_tables(folder: &Path, comparison: &Comparison, sheets: &[Sheet]) -> Result<()> {
    let pictures = pictures(comparison)?; // one that can't be drawn is an error before anything is written
    write_sheets(folder, sheets, &caption_lines(&comparison.record))?;
    for (name, svg) in pictures {
        write_picture(&folder.join(name), &svg)?;
    }
    let names: Vec<&str> = comparison
        .record
        .datasets
        .iter()
        .map(|d| d.name.as_str())
        .collect();
    let content = Page {
        title: format!("Comparison on {}", names.join(", ")),
        summary: comparison_summary(comparison),
        parts: comparison_parts(comparison, &caption_lines(&comparison.record))?,
        config: vec![(
            "Configuration, resolved".into(),
            format!("{:#}\n", resolved(&comparison.record)),
        )],
        ..Page::default()
    };
    write_page(folder, &content)
}

/// What the beliefs of a comparison are called, one entry a dataset.
const PLAYER: &str = "player.json";

/// For the terminal: the tables that can be looked at, and once what holds for all of them.
fn text(record: &ComparisonRecord, sheets: &[Sheet]) -> String {
    sheets_text(sheets) + &caption_lines(record).join("\n") + "\n"
}
