//! What `--report` writes: how often each feature is seen, and the plots.

use super::column_name;
use crate::{
    belief::Uncertainty,
    cli::{
        files::{write_json, write_text},
        page::{CONFIG, call, write_page},
        picture::write_picture,
        sheets::write_sheets,
    },
    error::{Error, Result},
    experiment::protocol_record::ProtocolRecord,
    model::Header,
    recording::Recording,
    report::{
        Cell, Page, Part, Table,
        comparison::{Reader, Sheet},
    },
};
use ndarray::Array2;
use serde::Serialize;
use std::path::Path;

/// What one set of filters answered.
pub(super) struct Set<'a> {
    pub header: &'a Header,
    pub shares: Vec<Share>,
    /// What the name of each picture ends with, and itself.
    pub plots: Vec<(String, String)>,
}

/// How often a feature is seen.
#[derive(Debug, Serialize)]
pub(super) struct Share {
    feature: String,
    /// Its probability, over all snapshots.
    mean_probability: f64,
    /// Share of the snapshots at which it is more likely than not.
    above_half: f64,
}

/// The record, `features.json`.
#[derive(Serialize)]
struct Record<'a> {
    snapshots: usize,
    sets: Vec<SetRecord<'a>>,
    protocol: ProtocolRecord,
}

#[derive(Serialize)]
struct SetRecord<'a> {
    prior: Uncertainty,
    features: &'a [Share],
}

/// How often each feature is seen.
pub(super) fn shares(answers: &Array2<f32>) -> Vec<Share> {
    let columns = answers.columns().into_iter().enumerate();
    let of_column = columns.map(|(i, column)| {
        let count = column.len().max(1) as f64;
        Share {
            feature: format!("f{}", i + 1),
            mean_probability: column.iter().map(|&p| f64::from(p)).sum::<f64>() / count,
            above_half: column.iter().filter(|p| **p > 0.5).count() as f64 / count,
        }
    });
    of_column.collect()
}

/// Writes everything into a folder that exists.
///
/// # Errors
/// Where a file can't be written.
pub(super) fn write(
    folder: &Path,
    recording: &Recording,
    sets: &[Set],
    summary: String,
) -> Result<()> {
    let record = Record {
        snapshots: recording.len(),
        sets: (sets.iter())
            .map(|set| SetRecord {
                prior: set.header.prior,
                features: &set.shares,
            })
            .collect(),
        protocol: ProtocolRecord::of_recording(recording),
    };
    write_json(&folder.join("features.json"), &record)?;
    let is_bank = sets.len() > 1;
    let (mut parts, mut sheets) = (Vec::new(), Vec::new());
    for set in sets {
        let prior = set.header.prior;
        let name = match is_bank {
            true => format!("features-{}", column_name(prior)),
            false => "features".to_string(),
        };
        if is_bank {
            parts.push(Part::Heading(format!("Filters for uncertainty {prior}")));
        }
        for (ending, plot) in &set.plots {
            write_picture(&folder.join(format!("{name}{ending}")), plot)?;
        }
        let table = table(&set.shares);
        parts.push(Part::table("How often each is seen", table.clone()));
        parts.extend(pictures(recording, &set.plots));
        sheets.push(Sheet {
            name,
            title: format!("How often each feature for uncertainty {prior} is seen"),
            table,
            reader: Reader::Everyone,
        });
    }
    write_sheets(folder, &sheets, &[])?;
    let headers: Vec<&Header> = sets.iter().map(|set| set.header).collect();
    let config = match &headers[..] {
        [header] => serde_json::to_string_pretty(header),
        _ => serde_json::to_string_pretty(&headers),
    };
    let config = config.map_err(|e| Error::work(format!("the model's header: {e}")))? + "\n";
    write_text(&folder.join(CONFIG), &config)?;
    let content = Page {
        title: match sets {
            [set] => format!("Filters for uncertainty {}", set.header.prior),
            _ => format!("A bank of {} sets of filters", sets.len()),
        },
        summary: vec![summary],
        command: call(),
        parts,
        config: vec![("Model".into(), config)],
    };
    write_page(folder, &content)
}

fn pictures(recording: &Recording, plots: &[(String, String)]) -> Vec<Part> {
    let (caption, alt) = match recording.route_m() {
        Some(_) => (
            "Output of each filter along the last run.",
            "Probability that each feature is seen, along the route",
        ),
        None => (
            "Output of a filter over the plan.",
            "Probability that a feature is seen, over the plan",
        ),
    };
    let pictures = plots.iter();
    let part = |(_, picture): &(String, String)| Part::picture(caption, alt, picture.clone());
    pictures.map(part).collect()
}

fn table(shares: &[Share]) -> Table {
    let mut table = Table::new([
        "feature",
        "mean P(f = 1)",
        "P(f = 1) above ½, % of snapshots",
    ]);
    for share in shares {
        table.row([
            Cell::Text(share.feature.clone()),
            Cell::Number(share.mean_probability, 3),
            Cell::Number(100.0 * share.above_half, 1),
        ]);
    }
    table
}
