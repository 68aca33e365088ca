//! What came of a sweep: means over seeds with their intervals, and paired differences to a baseline.

use super::{
    cell::Cell,
    figures::{Figure, at_path, headline_figures},
    folder::Sweep,
    plan::{described, shown},
    record::{CellRow, Hole, SweepRecord, SweepRow},
};
use crate::{
    error::{Error, Result},
    score::{MeanInterval, PairedT, holm},
    storage,
};
use rayon::prelude::*;
use serde_json::{Map, Value};
use std::{
    collections::{BTreeMap, HashMap},
    path::Path,
};

/// What is to be collected.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Collected {
    /// Figures by their paths in a cell's record, or by their names among the headline figures; none: those of the sweep file, else the
    /// headline figures.
    pub metrics: Vec<String>,
    /// Keys that are averaged over as seeds are.
    pub over: Vec<String>,
    /// Keys with values, as a reader writes them, that others are held against; empty: as the sweep file says.
    pub baseline: Vec<(String, String)>,
    /// Are cells without a result left out? Else they are an error.
    pub with_holes: bool,
}

/// A cell's figures, read from its result.
struct ReadCell<'a> {
    cell: &'a Cell,
    lossy: bool,
    figures: Vec<Figure>,
    /// Paths that the record does not have.
    absent: Vec<String>,
}

/// Collects the results of a sweep.
///
/// # Errors
/// Where a cell has no result, and holes are not allowed; where a result is not what it is called; a usage error where a figure is in no
/// record, or a key or value of the baseline is none of the sweep's.
pub fn collect_results(sweep: &Sweep, wanted: &Collected) -> Result<SweepRecord> {
    let plan = &sweep.plan;
    if let Some(key) = wanted.over.iter().find(|key| !plan.keys.contains(key)) {
        return Err(unknown_key("--over", key, &plan.keys));
    }
    let mut cells = sweep.cells()?;
    cells.sort_by_key(|cell| cell.number);
    let done = sweep.done()?;
    let is_hole = |cell: &&Cell| !done.contains(&cell.name);
    let holes: Vec<Hole> = cells
        .iter()
        .filter(is_hole)
        .map(|cell| Hole {
            cell: cell.name.clone(),
            what: described(&cell.keys, cell.seed),
        })
        .collect();
    if !holes.is_empty() && !wanted.with_holes {
        return Err(Error::file(
            sweep.folder(),
            holes_in_words(&holes, cells.len()),
        ));
    }
    if holes.len() == cells.len() {
        return Err(Error::file(sweep.folder(), "no cell has a result"));
    }
    let metrics = match wanted.metrics.is_empty() {
        true => &plan.metrics,
        false => &wanted.metrics,
    };
    let read: Vec<ReadCell> = cells
        .par_iter()
        .filter(|cell| done.contains(&cell.name))
        .map(|cell| read(sweep, cell, metrics))
        .collect::<Result<_>>()?;
    let figures = figure_names(&read, metrics)?;
    let keys: Vec<String> = plan.keys.clone();
    let keys: Vec<String> = keys
        .into_iter()
        .filter(|k| !wanted.over.contains(k))
        .collect();
    let rows = rows(sweep, wanted, &cells, &read, &keys, &figures)?;
    let values = |cell: &Cell, keys: &[String]| -> Vec<String> {
        let value = |key| cell.keys.get(key).map_or(String::new(), shown);
        keys.iter().map(value).collect()
    };
    let by_cell = read.iter().map(|read| CellRow {
        cell: read.cell.name.clone(),
        values: values(read.cell, &plan.keys),
        seed: read.cell.seed,
        lossy: read.lossy,
        figures: figures.iter().map(|name| read.figure(name)).collect(),
    });
    Ok(SweepRecord {
        version: plan.version.clone(),
        command: plan.base.command.name().to_string(),
        by_cell: by_cell.collect(),
        cell_keys: plan.keys.clone(),
        over: wanted.over.clone(),
        cells: cells.len(),
        keys,
        figures,
        rows,
        holes,
    })
}

impl ReadCell<'_> {
    fn figure(&self, name: &str) -> Option<f64> {
        let found = self.figures.iter().find(|(known, _)| known == name);
        found.and_then(|(_, value)| *value)
    }
}

/// Holes that a message names.
const NAMED_HOLES: usize = 5;

fn holes_in_words(holes: &[Hole], cells: usize) -> String {
    let named = holes.iter().take(NAMED_HOLES);
    let named: Vec<String> = named
        .map(|hole| format!("{} ({})", hole.cell, hole.what))
        .collect();
    let more = match holes.len() - named.len() {
        0 => String::new(),
        more => format!("; and {more} more"),
    };
    format!(
        "{} of {cells} cells have no result: {}{more}; expected all (`ballmark sweep run`, `status`), or --holes",
        holes.len(),
        named.join("; ")
    )
}

fn read<'a>(sweep: &Sweep, cell: &'a Cell, metrics: &[String]) -> Result<ReadCell<'a>> {
    let path = sweep.result(&cell.name);
    let result = serde_json::from_slice(&storage::read_file(&path)?);
    let result: Value = result.map_err(|e| damaged(&path, &e.to_string()))?;
    if result["cell"].as_str() != Some(&cell.name) {
        return Err(damaged(&path, "the result of another cell"));
    }
    let record = &result["record"];
    let headline = headline_figures(sweep.plan.base.command, record);
    let (mut figures, mut absent) = (Vec::new(), Vec::new());
    for name in metrics {
        let known = headline.iter().find(|(known, _)| known == name);
        match known
            .map(|(_, value)| *value)
            .or_else(|| at_path(record, name))
        {
            Some(value) => figures.push((name.clone(), value)),
            None => absent.push(name.clone()),
        }
    }
    Ok(ReadCell {
        cell,
        lossy: result["lossy"] == Value::Bool(true),
        figures: if metrics.is_empty() {
            headline
        } else {
            figures
        },
        absent,
    })
}

fn damaged(path: &Path, fault: &str) -> Error {
    let expected = "expected a cell's result as `ballmark sweep` wrote it; take it away, and run the cell again";
    Error::file(path, format!("{fault}; {expected}"))
}

/// Names of all figures, in the order that the first cells have them.
fn figure_names(read: &[ReadCell], metrics: &[String]) -> Result<Vec<String>> {
    let nowhere = |name: &&String| read.iter().all(|cell| cell.absent.contains(name));
    if let Some(name) = metrics.iter().find(nowhere) {
        return Err(Error::usage(format!(
            "--metric `{}`: no number there in any record; expected a dotted path into `record` of a file in results/",
            name.escape_debug()
        )));
    }
    let mut names: Vec<String> = Vec::new();
    let mut seen = std::collections::HashSet::new();
    for (name, _) in read.iter().flat_map(|cell| &cell.figures) {
        if seen.insert(name) {
            names.push(name.clone());
        }
    }
    match names.is_empty() {
        true => Err(Error::usage(
            "the records have no headline figures; expected --metric PATH",
        )),
        false => Ok(names),
    }
}

fn unknown_key(what: &str, key: &str, keys: &[String]) -> Error {
    Error::usage(format!(
        "{what} `{}`: cells don't differ in it; expected one of {}",
        key.escape_debug(),
        keys.join(", ")
    ))
}

/// The values of a cell's keys as JSON text: what tells combinations apart.
fn values_of(cell: &Cell, keys: &[String]) -> Vec<String> {
    let value = |key| cell.keys.get(key).map_or(String::new(), Value::to_string);
    keys.iter().map(value).collect()
}

fn rows(
    sweep: &Sweep,
    wanted: &Collected,
    cells: &[Cell],
    read: &[ReadCell],
    keys: &[String],
    figures: &[String],
) -> Result<Vec<SweepRow>> {
    // Combinations in the order of the plan, and what each repetition gave.
    let mut order: Vec<Vec<String>> = Vec::new();
    let mut first: HashMap<Vec<String>, &Cell> = HashMap::new();
    for cell in cells {
        let combination = values_of(cell, keys);
        first.entry(combination.clone()).or_insert_with(|| {
            order.push(combination);
            cell
        });
    }
    type Repetition = (Vec<String>, Option<u64>);
    let mut results: HashMap<Vec<String>, BTreeMap<Repetition, &ReadCell>> = HashMap::new();
    for read in read {
        let repetition = (values_of(read.cell, &wanted.over), read.cell.seed);
        let of_combination = results.entry(values_of(read.cell, keys)).or_default();
        of_combination.insert(repetition, read);
    }
    let baselines = baselines(sweep, wanted, cells, keys, &order)?;
    let none = BTreeMap::new();
    let mut rows = Vec::new();
    for figure in figures {
        let mut of_figure = Vec::new();
        for (combination, baseline) in order.iter().zip(&baselines) {
            let own = results.get(combination).unwrap_or(&none);
            let values: Vec<Option<f64>> = own.values().map(|cell| cell.figure(figure)).collect();
            let defined: Vec<f64> = values.iter().flatten().copied().collect();
            let is_baseline = baseline.as_ref() == Some(combination);
            let against = baseline.as_ref().filter(|_| !is_baseline);
            let against = against.and_then(|baseline| results.get(baseline));
            let pairs = own.iter().filter_map(|(repetition, cell)| {
                let other = against?.get(repetition)?;
                Some((cell.figure(figure)?, other.figure(figure)?))
            });
            let (a, b): (Vec<f64>, Vec<f64>) = pairs.unzip();
            let differences: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
            let cell = first.get(combination);
            let value = |key| {
                cell.and_then(|c| c.keys.get(key))
                    .map_or(String::new(), shown)
            };
            of_figure.push(SweepRow {
                values: keys.iter().map(value).collect(),
                figure: figure.clone(),
                cells: values.len(),
                undefined: values.len() - defined.len(),
                mean: match defined.len() == values.len() {
                    true => MeanInterval::of(&defined),
                    false => None,
                },
                is_baseline,
                difference: MeanInterval::of(&differences),
                p: PairedT::of(&a, &b).map(|test| test.p),
                p_holm: None,
            });
        }
        let p: Vec<Option<f64>> = of_figure.iter().map(|row| row.p).collect();
        for (row, p_holm) in of_figure.iter_mut().zip(holm(&p)) {
            row.p_holm = p_holm;
        }
        rows.extend(of_figure);
    }
    Ok(rows)
}

/// Keys whose values are what is localised in, not how: a baseline is on the same.
const SAME_IN_BASELINE: [&str; 2] = ["data", "paper"];

/// What each combination is held against: the combination with the baseline's values and all else as it has it; where no baseline is named, the
/// first combination on the same data.
fn baselines(
    sweep: &Sweep,
    wanted: &Collected,
    cells: &[Cell],
    keys: &[String],
    order: &[Vec<String>],
) -> Result<Vec<Option<Vec<String>>>> {
    let mut named: Map<String, Value> = sweep.plan.baseline.clone();
    if !wanted.baseline.is_empty() {
        named.clear();
    }
    for (key, value) in &wanted.baseline {
        if !keys.contains(key) {
            return Err(unknown_key("--baseline", key, keys));
        }
        let mut values = cells.iter().filter_map(|cell| cell.keys.get(key));
        let found = values.find(|known| shown(known) == *value);
        let found = found.ok_or_else(|| {
            Error::usage(format!(
                "--baseline {}={}: no cell has that value",
                key.escape_debug(),
                value.escape_debug()
            ))
        })?;
        named.insert(key.clone(), found.clone());
    }
    let baseline = |combination: &Vec<String>| -> Option<Vec<String>> {
        if named.is_empty() {
            let same = |other: &&Vec<String>| {
                let mut all = keys.iter().zip(combination).zip(other.iter());
                all.all(|((key, own), other)| {
                    !SAME_IN_BASELINE.contains(&key.as_str()) || own == other
                })
            };
            return order.iter().find(same).cloned();
        }
        let value = |(key, own): (&String, &String)| {
            let named = named.get(key).map(Value::to_string);
            named.unwrap_or_else(|| own.clone())
        };
        let wanted: Vec<String> = keys.iter().zip(combination).map(value).collect();
        order.iter().find(|other| **other == wanted).cloned()
    };
    Ok(order.iter().map(baseline).collect())
}
