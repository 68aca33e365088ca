//! What came of a sweep as tables: a row a combination and figure.

use super::{
    Cell, Table,
    comparison::{Reader, Sheet},
};
use crate::experiment::sweep::{SweepRecord, SweepRow};

/// Holes that the caption names; all stand in `sweep-holes.csv`.
const NAMED_HOLES: usize = 10;

/// The table for readers, all its numbers for programs, every cell with its figures, and the holes where there are some.
pub fn sheets(record: &SweepRecord) -> Vec<Sheet> {
    let mut sheets = vec![
        Sheet {
            name: "sweep".into(),
            title: format!("Sweep of `{}`: means over {}", record.command, over(record)),
            table: table(record),
            reader: Reader::Everyone,
        },
        for_programs("sweep-figures", figures(record)),
        for_programs("sweep-cells", cells(record)),
    ];
    if !record.holes.is_empty() {
        let mut table = Table::new(["cell", "what"]);
        for hole in &record.holes {
            table.row([Cell::Text(hole.cell.clone()), Cell::Text(hole.what.clone())]);
        }
        sheets.push(for_programs("sweep-holes", table));
    }
    sheets
}

fn for_programs(name: &str, table: Table) -> Sheet {
    Sheet {
        name: name.into(),
        title: String::new(),
        table,
        reader: Reader::Programs,
    }
}

fn over(record: &SweepRecord) -> String {
    let keys = record.over.iter().map(String::as_str);
    std::iter::once("seeds")
        .chain(keys)
        .collect::<Vec<_>>()
        .join(", ")
}

fn table(record: &SweepRecord) -> Table {
    let keys = record.keys.iter().map(|key| short(key, &record.keys));
    let columns = ["figure", "n", "mean", "to baseline", "p (Holm)"];
    let mut table = Table::new(keys.chain(columns.map(String::from)));
    for row in &record.rows {
        let mut cells: Vec<Cell> = row.values.iter().cloned().map(Cell::Text).collect();
        cells.push(Cell::Text(row.figure.clone()));
        cells.push(Cell::Count(row.cells as u64));
        let mean = row.mean.as_ref();
        cells.push(Cell::interval(
            mean.map(|m| m.mean),
            mean.and_then(|m| m.ci95),
            3,
        ));
        let difference = row.difference.as_ref();
        cells.push(match row.is_baseline {
            true => Cell::Text("baseline".into()),
            false => Cell::interval(
                difference.map(|d| d.mean),
                difference.and_then(|d| d.ci95),
                3,
            ),
        });
        cells.push(Cell::number(row.p_holm, 3));
        table.row(cells);
    }
    captions(record, &mut table);
    table
}

fn captions(record: &SweepRecord, table: &mut Table) {
    table.caption(format!("n: cells, one each of {0}; in brackets 95 % intervals by Student's t; differences are paired by {0}", over(record)));
    table.caption(
        "p: Student's paired t-test, corrected for the number of tests of its figure (Holm 1979)",
    );
    if !record.over.is_empty() {
        table.caption("folds share what they learn from: intervals over them are somewhat too narrow (Bengio & Grandvalet 2004)");
    }
    let undefined = |row: &&SweepRow| row.undefined > 0;
    if record.rows.iter().any(|row| undefined(&row)) {
        table.caption("–: the figure is undefined in some of the cells (sweep-cells.csv)");
    }
    let lossy = record.by_cell.iter().filter(|cell| cell.lossy).count();
    if lossy > 0 {
        table.caption(format!(
            "{lossy} cells are done with losses (exit status 3)"
        ));
    }
    if !record.holes.is_empty() {
        let named = record.holes.iter().take(NAMED_HOLES);
        let named: Vec<&str> = named.map(|hole| hole.what.as_str()).collect();
        let more = match record.holes.len() - named.len() {
            0 => String::new(),
            more => format!("; and {more} more in sweep-holes.csv"),
        };
        table.caption(format!(
            "{} of {} cells have no result: {}{more}",
            record.holes.len(),
            record.cells,
            named.join("; ")
        ));
    }
    table.caption(format!("ballmark {}", record.version));
}

/// The last word of a key, where no other key ends so.
fn short(key: &str, keys: &[String]) -> String {
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_string();
    let alike = keys.iter().filter(|other| last(other) == last(key)).count();
    match alike {
        1 => last(key),
        _ => key.to_string(),
    }
}

fn figures(record: &SweepRecord) -> Table {
    let columns = [
        "figure",
        "cells",
        "undefined",
        "mean",
        "mean_low",
        "mean_high",
        "is_baseline",
        "difference",
        "difference_low",
        "difference_high",
        "pairs",
        "p",
        "p_holm",
    ];
    let keys = record.keys.iter().cloned();
    let mut table = Table::new(keys.chain(columns.map(String::from)));
    let number = |value: Option<f64>| Cell::number(value, 6);
    for row in &record.rows {
        let mut cells: Vec<Cell> = row.values.iter().cloned().map(Cell::Text).collect();
        cells.extend([
            Cell::Text(row.figure.clone()),
            Cell::Count(row.cells as u64),
            Cell::Count(row.undefined as u64),
        ]);
        let of = |mean: &Option<crate::score::MeanInterval>| {
            let ends = mean.as_ref().and_then(|m| m.ci95);
            [
                number(mean.as_ref().map(|m| m.mean)),
                number(ends.map(|ends| ends[0])),
                number(ends.map(|ends| ends[1])),
            ]
        };
        cells.extend(of(&row.mean));
        cells.push(Cell::Count(u64::from(row.is_baseline)));
        cells.extend(of(&row.difference));
        cells.push(Cell::Count(row.difference.map_or(0, |d| d.count as u64)));
        cells.extend([number(row.p), number(row.p_holm)]);
        table.row(cells);
    }
    table
}

fn cells(record: &SweepRecord) -> Table {
    let keys = record.cell_keys.iter().cloned();
    let columns = ["cell".to_string()].into_iter().chain(keys);
    let columns = columns.chain(["seed".to_string(), "lossy".to_string()]);
    let mut table = Table::new(columns.chain(record.figures.iter().cloned()));
    for cell in &record.by_cell {
        let mut row = vec![Cell::Text(cell.cell.clone())];
        row.extend(cell.values.iter().cloned().map(Cell::Text));
        row.push(cell.seed.map_or(Cell::Missing, Cell::Count));
        row.push(Cell::Count(u64::from(cell.lossy)));
        row.extend(cell.figures.iter().map(|figure| Cell::number(*figure, 6)));
        table.row(row);
    }
    table
}
