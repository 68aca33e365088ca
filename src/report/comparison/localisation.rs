//! Localisation trials: for each dataset just the tables and pictures that `ballmark localise` makes.

use super::{Picture, Reader, Sheet};
use crate::{
    error::Result,
    experiment::{
        compare::{ComparisonRecord, Outcome},
        localisation::Record,
    },
    report::localisation as tables,
};

/// The record of each dataset that has one: the dataset's number, the end of its files' names, and the record.
pub(super) fn records(record: &ComparisonRecord) -> Vec<(usize, String, &Record)> {
    let Some(section) = &record.localisation else {
        return Vec::new();
    };
    let names = record.file_names();
    let done = section.records.iter().enumerate();
    let done = done.filter_map(|(dataset, outcome)| match outcome {
        Outcome::Done(record) => Some((dataset, record)),
        _ => None,
    });
    done.map(|(dataset, localised)| {
        let ending = match record.datasets.len() {
            1 => String::new(),
            _ => format!("-{}", names[dataset]),
        };
        (dataset, ending, localised)
    })
    .collect()
}

/// A table to look at a dataset, and others for programs.
pub(super) fn sheets(record: &ComparisonRecord) -> Vec<Sheet> {
    let sheets = records(record)
        .into_iter()
        .map(|(dataset, ending, record_of)| {
            let title = |what: &str| format!("{what}: {}", record.datasets[dataset].name);
            let sheet = |name: &str, what: &str, table, reader| Sheet {
                name: format!("{name}{ending}"),
                title: title(what),
                table,
                reader,
            };
            [
                sheet(
                    "localisation",
                    "Localisation on unseen runs",
                    tables::table(record_of),
                    Reader::Everyone,
                ),
                sheet(
                    "localisation-figures",
                    "All figures",
                    tables::figures(record_of),
                    Reader::Programs,
                ),
                sheet(
                    "error-by-distance",
                    "Mean error by distance",
                    tables::curves(record_of),
                    Reader::Programs,
                ),
                sheet(
                    "risk-coverage",
                    "Error that is left where the least sure trials are rejected",
                    tables::risk_coverage(record_of),
                    Reader::Programs,
                ),
                sheet(
                    "paired-trials",
                    "Every other system against the first, over the same trials",
                    tables::paired(record_of),
                    Reader::Programs,
                ),
                sheet(
                    "correction",
                    "Prediction and correction",
                    tables::correction(record_of),
                    Reader::Everyone,
                ),
                sheet(
                    "correction-figures",
                    "Prediction and correction, all figures",
                    tables::correction_figures(record_of),
                    Reader::Programs,
                ),
                sheet(
                    "confidence-figures",
                    "Is it lost, and does it know?",
                    tables::confidence_figures(record_of),
                    Reader::Programs,
                ),
            ]
        });
    sheets.flatten().collect()
}

/// The curves of each dataset, from a start anywhere and from a known one.
pub(super) fn pictures(record: &ComparisonRecord) -> Result<Vec<Picture>> {
    let mut pictures = Vec::new();
    for (dataset, ending, localised) in records(record) {
        let name = &record.datasets[dataset].name;
        for (file, start, known) in [
            ("error-by-distance", "start anywhere", false),
            ("tracking-error", "start known", true),
        ] {
            let title = format!("{name}: {start}");
            let plot = tables::error_plot(&title, localised, known)?;
            pictures.push((format!("{file}{ending}"), plot));
        }
        let plot = tables::found_plot(&format!("{name}: start anywhere"), localised)?;
        pictures.push((format!("found-by-distance{ending}"), plot));
        let plot = tables::risk_coverage_plot(&format!("{name}: start anywhere"), localised)?;
        pictures.push((format!("risk-coverage{ending}"), plot));
    }
    Ok(pictures)
}
