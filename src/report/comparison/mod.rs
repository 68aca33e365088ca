//! What a comparison gave, for readers: tables and pictures, all from the record.

mod caption;
mod contingency;
mod cost;
mod error_reduction;
mod localisation;
mod on_page;
mod recognition;
mod standard;

pub use caption::caption_lines;
pub use on_page::{comparison_parts, comparison_summary, sheet_parts};

use super::{Cell, Table};
use crate::{
    error::Result,
    experiment::compare::{Comparison, ComparisonRecord, Outcome, Section},
};

/// A table with its name.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// What its files are called, without the ending.
    pub name: String,
    /// What it shows, in words.
    pub title: String,
    /// Itself; [`caption_lines`] holds for all tables of a comparison and is not in it.
    pub table: Table,
    /// Who it is for.
    pub reader: Reader,
}

/// Who a table is for, which decides where it goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reader {
    /// Whoever looks at the terminal, and everyone below.
    Everyone,
    /// Documents, and programs: the terminal has the same elsewhere.
    Documents,
    /// Programs: it is too long to be looked at.
    Programs,
}

/// A picture as SVG, with the name of its file without the ending.
pub type Picture = (String, String);

/// All tables, in the order of the sections.
pub fn sheets(comparison: &Comparison) -> Vec<Sheet> {
    let record = &comparison.record;
    let mut sheets = standard::sheets(record);
    sheets.extend(localisation::sheets(record));
    sheets.extend(recognition::sheets(record));
    sheets.extend(cost::sheet(comparison));
    sheets.extend(error_reduction::sheet(record));
    sheets.extend(landmarks(record));
    sheets
}

/// All pictures, in the order of the sections.
///
/// # Errors
/// None with a record that was made by an experiment.
pub fn pictures(comparison: &Comparison) -> Result<Vec<Picture>> {
    let mut pictures = standard::pictures(&comparison.record)?;
    pictures.extend(localisation::pictures(&comparison.record)?);
    pictures.extend(contingency::pictures(&comparison.record)?);
    pictures.extend(cost::picture(comparison)?);
    pictures.extend(error_reduction::pictures(&comparison.record)?);
    Ok(pictures)
}

/// Hand-made landmarks against the plan, one row a dataset and landmark.
fn landmarks(record: &ComparisonRecord) -> Option<Sheet> {
    let section = record.landmarks.as_ref()?;
    let mut table = Table::new([
        "dataset",
        "landmark",
        "snapshots",
        "found",
        "false",
        "missed",
        "precision",
        "recall",
    ]);
    for (dataset, system, outcome) in by_dataset(section) {
        let mut row = who(record, dataset, system);
        match outcome {
            Outcome::Done(judged) => row.extend([
                Cell::Count(judged.snapshots as u64),
                Cell::Count(judged.true_positives as u64),
                Cell::Count(judged.false_positives as u64),
                Cell::Count(judged.missed as u64),
                Cell::number(judged.precision, 2),
                Cell::number(judged.recall, 2),
            ]),
            other => row.push(no_answer(&mut table, other)),
        }
        table.row(row);
    }
    if section
        .cells
        .iter()
        .flatten()
        .any(|cell| matches!(cell, Outcome::NotAsked))
    {
        table.caption(
            "–: a dataset without a plan, or whose camera doesn't look where such landmarks are",
        );
    }
    Some(Sheet {
        name: "landmarks".into(),
        title: "Hand-made landmarks against the plan".into(),
        table,
        reader: Reader::Everyone,
    })
}

/// All cells, dataset by dataset: number of the dataset, number of the system, what came of it.
fn by_dataset<C, T>(section: &Section<C, T>) -> impl Iterator<Item = (usize, usize, &Outcome<T>)> {
    let datasets = section.cells.first().map_or(0, Vec::len);
    (0..datasets).flat_map(move |dataset| {
        let rows = section.systems.iter().zip(&section.cells);
        rows.map(move |(&system, row)| (dataset, system, &row[dataset]))
    })
}

/// The first cells of a row: dataset and system.
fn who(record: &ComparisonRecord, dataset: usize, system: usize) -> Vec<Cell> {
    vec![
        Cell::Text(record.datasets[dataset].name.clone()),
        Cell::Text(record.systems[system].name.clone()),
    ]
}

/// What stands in place of an answer.
fn no_answer<T>(table: &mut Table, outcome: &Outcome<T>) -> Cell {
    match outcome {
        Outcome::Failed { why } => Cell::Failed(table.footnote(why)),
        _ => Cell::Missing,
    }
}

/// Who a matrix is for: over one dataset it is a column of the table that follows it.
fn reader_of_matrix(record: &ComparisonRecord) -> Reader {
    match record.datasets.len() {
        1 => Reader::Documents,
        _ => Reader::Everyone,
    }
}

/// One value a system and dataset: systems down, datasets across, their mean at the end (as Table 2 of Duckett & Nehmzow
/// 2000, turned), the mean where no value is missing.
fn matrix<C, T>(
    record: &ComparisonRecord,
    section: &Section<C, T>,
    value: impl Fn(&T) -> Option<f64>,
) -> Table {
    let names = record.datasets.iter().map(|dataset| dataset.name.clone());
    let headers = std::iter::once("system".to_string()).chain(names);
    let mut table = Table::new(headers.chain(["mean".to_string()]));
    for (&system, outcomes) in section.systems.iter().zip(&section.cells) {
        let mut row = vec![Cell::Text(record.systems[system].name.clone())];
        let mut values = Vec::new();
        for outcome in outcomes {
            row.push(match outcome {
                Outcome::Done(done) => {
                    values.extend(value(done));
                    Cell::number(value(done), 3)
                }
                other => no_answer(&mut table, other),
            });
        }
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let whole = values.len() == outcomes.len() && !values.is_empty();
        row.push(Cell::number(whole.then_some(mean), 3));
        table.row(row);
    }
    table
}

#[cfg(test)]
mod tests;
