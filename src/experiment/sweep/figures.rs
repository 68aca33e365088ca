//! Figures of a cell's record: the command's headline figures by name, or any other by its path.

use super::command::Command;
use serde_json::Value;

/// Headline figures of a localisation result, in the order of the table.
const LOCALISATION: [&str; 4] = [
    "converged_fraction",
    "error_at_10m_m",
    "tracked_error_m",
    "recall_1m",
];

/// A figure's name, and its value where the record has a number there: null where, say, too few robots were found for a median.
pub type Figure = (String, Option<f64>);

/// The headline figures of a command's record.
///
/// | command | figures |
/// |---|---|
/// | `train` | `validation.error_reduction`, `train.error_reduction`; of a bank for each set |
/// | `localise` | `converged_fraction`, `error_at_10m_m`, `tracked_error_m`, `recall_1m` of the model, or of each where there are several |
/// | `compare` | these of each system and dataset in `[localisation]`; U(L\|R), corrected, in `[standard]` and `[recognition]`; the error reduction at each prior; precision and recall of landmarks |
/// | `reproduce` | as `compare`, means over its seeds; of thrun1998 what filters for ±2 m take away at ±2 m; of ruizmayor2006 the share of optimal estimates and μ + σ |
///
/// ```
/// use ballmark::experiment::sweep::{Command, headline_figures};
/// let record = serde_json::json!({ "validation": { "error_reduction": 0.41 }, "train": { "error_reduction": 0.5 } });
/// let figures = headline_figures(Command::Train, &record);
/// assert_eq!(figures[0], ("validation.error_reduction".to_string(), Some(0.41)));
/// ```
pub fn headline_figures(command: Command, record: &Value) -> Vec<Figure> {
    match command {
        Command::Train => match record["sets"].as_array() {
            Some(sets) => sets
                .iter()
                .flat_map(|set| {
                    let name = set["uncertainty"].as_str().unwrap_or_default();
                    prefixed(&format!("sets.{name}"), trained(set))
                })
                .collect(),
            None => trained(record),
        },
        Command::Localise if record.get("converged_fraction").is_some() => localised(record),
        Command::Localise => elements(&record["systems"])
            .flat_map(|system| prefixed(&format!("systems.{}", name(system)), localised(system)))
            .collect(),
        Command::Compare => compared(record),
        Command::Reproduce => reproduced(record),
    }
}

/// A figure by its dotted path: a key of an object; of a list the number of an element, from 0, or its `name` (else `uncertainty`, `prior`).
/// None where the path leads nowhere.
///
/// ```
/// use ballmark::experiment::sweep::at_path;
/// let record = serde_json::json!({ "systems": [{ "name": "kernel, 0.5 m", "error_m": 2.5, "recall": null }] });
/// assert_eq!(at_path(&record, "systems.kernel, 0.5 m.error_m"), Some(Some(2.5)));
/// assert_eq!(at_path(&record, "systems.0.recall"), Some(None));
/// assert_eq!(at_path(&record, "systems.1.recall"), None);
/// ```
pub fn at_path(record: &Value, path: &str) -> Option<Option<f64>> {
    if path.is_empty() {
        return match record {
            Value::Null => Some(None),
            Value::Number(number) => Some(number.as_f64()),
            Value::Bool(truth) => Some(Some(f64::from(u8::from(*truth)))),
            _ => None,
        };
    }
    let behind = |word: &str| match path.strip_prefix(word)? {
        "" => Some(""),
        rest => rest.strip_prefix('.'),
    };
    match record {
        // The longest key first: keys may have dots in them.
        Value::Object(keys) => {
            let mut found: Vec<(&String, &Value, &str)> = keys
                .iter()
                .filter_map(|(key, value)| Some((key, value, behind(key)?)))
                .collect();
            found.sort_by_key(|(key, ..)| std::cmp::Reverse(key.len()));
            let mut found = found.into_iter();
            found.find_map(|(_, value, rest)| at_path(value, rest))
        }
        Value::Array(values) => {
            let numbered = values.iter().enumerate();
            let mut found: Vec<(usize, &Value, &str)> = numbered
                .flat_map(|(number, value)| {
                    let words = [name(value).to_string(), number.to_string()];
                    words.into_iter().filter_map(move |word| {
                        let rest = behind(&word).filter(|_| !word.is_empty())?;
                        Some((word.len(), value, rest))
                    })
                })
                .collect();
            found.sort_by_key(|(length, ..)| std::cmp::Reverse(*length));
            let mut found = found.into_iter();
            found.find_map(|(_, value, rest)| at_path(value, rest))
        }
        _ => None,
    }
}

fn name(value: &Value) -> &str {
    let words = ["name", "uncertainty", "prior"].into_iter();
    let mut words = words.filter_map(|key| value.get(key)?.as_str());
    words.next().unwrap_or("")
}

fn elements(list: &Value) -> impl Iterator<Item = &Value> {
    list.as_array().into_iter().flatten()
}

fn prefixed(prefix: &str, figures: Vec<Figure>) -> Vec<Figure> {
    let with = |(name, value)| (format!("{prefix}.{name}"), value);
    figures.into_iter().map(with).collect()
}

fn of(record: &Value, paths: &[&str]) -> Vec<Figure> {
    let figure = |path: &&str| (path.to_string(), at_path(record, path).flatten());
    paths.iter().map(figure).collect()
}

fn trained(record: &Value) -> Vec<Figure> {
    of(
        record,
        &["validation.error_reduction", "train.error_reduction"],
    )
}

/// Those that there are: a method that failed has none.
fn localised(system: &Value) -> Vec<Figure> {
    let there = LOCALISATION.iter().copied();
    let there: Vec<&str> = there.filter(|key| system.get(key).is_some()).collect();
    of(system, &there)
}

/// Section, system and, where there are several, dataset before each figure.
fn compared(record: &Value) -> Vec<Figure> {
    let systems: Vec<&str> = elements(&record["systems"]).map(name).collect();
    let datasets: Vec<&str> = elements(&record["datasets"]).map(name).collect();
    let place = |section: &str, system: &str, dataset: usize| match datasets.len() {
        1 => format!("{section}.{system}"),
        _ => format!(
            "{section}.{system}.{}",
            datasets.get(dataset).unwrap_or(&"")
        ),
    };
    let mut all = Vec::new();
    for (dataset, outcome) in elements(&record["localisation"]["records"]).enumerate() {
        for system in elements(&outcome["done"]["results"]) {
            let place = place("localisation", name(system), dataset);
            all.extend(prefixed(&place, localised(system)));
        }
    }
    for section in ["standard", "recognition", "error_reduction", "landmarks"] {
        let asked = elements(&record[section]["systems"]);
        for (system, row) in asked.zip(elements(&record[section]["cells"])) {
            let number = system.as_u64().unwrap_or(u64::MAX) as usize;
            let system = systems.get(number).copied().unwrap_or_default();
            for (dataset, cell) in elements(row).enumerate() {
                let Some(done) = cell.get("done") else {
                    continue;
                };
                let figures = match section {
                    "standard" => of(done, &["mean_uncertainty_coefficient_corrected"]),
                    "recognition" => {
                        let judged = &done["judgement"];
                        of(judged, &["uncertainty_coefficient_corrected"])
                    }
                    "error_reduction" => elements(&done["points"])
                        .map(|point| {
                            let value = point["score"]["error_reduction"].as_f64();
                            (name(point).to_string(), value)
                        })
                        .collect(),
                    _ => of(done, &["precision", "recall"]),
                };
                all.extend(prefixed(&place(section, system, dataset), figures));
            }
        }
    }
    all
}

fn reproduced(record: &Value) -> Vec<Figure> {
    let comparisons: Vec<Vec<Figure>> = elements(&record["comparisons"]).map(compared).collect();
    if let Some(first) = comparisons.first() {
        let mean = |name: &str| {
            let of_each = comparisons.iter();
            let values = of_each.map(|figures| figures.iter().find(|f| f.0 == name)?.1);
            let values: Option<Vec<f64>> = values.collect();
            crate::score::MeanInterval::of(&values?).map(|over| over.mean)
        };
        let names = first.iter().map(|(name, _)| name);
        return names.map(|name| (name.clone(), mean(name))).collect();
    }
    let mut all = Vec::new();
    for set in elements(&record["sets"]) {
        for row in elements(&set["rows"]) {
            let word = |key: &str| row[key].as_str().unwrap_or_default();
            if word("judged_at") == "2m" && ["2m", ""].contains(&word("trained_for")) {
                let (approach, features) = (word("approach"), &row["features"]);
                let name = format!("sets.{}.{approach} {features}.held_out", name(set));
                all.push((name, row["held_out"]["mean"].as_f64()));
            }
        }
    }
    // As printed in the paper: its constants are those of the first experiment.
    if let Some(first) = elements(&record["experiments"]).next()
        && let Some(together) = elements(&first["figures"]).next()
    {
        let paths = [
            "optimal.mean",
            "merit_m.mean",
            "merit_deg.mean",
            "p95_m.mean",
        ];
        all.extend(of(together, &paths));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_training_has_its_two_figures_and_a_bank_those_of_each_set() {
        let one = json!({ "validation": null, "train": { "error_reduction": 0.5 } });
        assert_eq!(
            headline_figures(Command::Train, &one),
            [
                ("validation.error_reduction".into(), None),
                ("train.error_reduction".into(), Some(0.5))
            ]
        );
        let set = json!({ "uncertainty": "2m", "train": { "error_reduction": 0.5 } });
        let bank = headline_figures(Command::Train, &json!({ "sets": [set] }));
        assert_eq!(bank[1], ("sets.2m.train.error_reduction".into(), Some(0.5)));
        let path = "sets.2m.train.error_reduction";
        assert_eq!(at_path(&json!({ "sets": [set] }), path), Some(Some(0.5)));
    }

    #[test]
    fn a_comparison_has_figures_of_every_section() {
        let record = json!({
            "systems": [{ "name": "ball" }, { "name": "door" }],
            "datasets": [{ "name": "A" }, { "name": "B" }],
            "localisation": { "records": [
                { "done": { "results": [{ "name": "ball", "converged_fraction": 0.5, "error_at_10m_m": null }] } },
                { "failed": { "why": "no" } },
            ] },
            "error_reduction": { "systems": [0], "cells": [[
                { "done": { "points": [{ "prior": "1m", "score": { "error_reduction": 0.2 } }] } }, "not_asked",
            ]] },
            "landmarks": { "systems": [1], "cells": [["not_asked", { "done": { "precision": 0.7, "recall": 0.9 } }]] },
        });
        let names: Vec<String> = headline_figures(Command::Compare, &record)
            .into_iter()
            .map(|(name, value)| format!("{name} = {value:?}"))
            .collect();
        assert_eq!(
            names,
            [
                "localisation.ball.A.converged_fraction = Some(0.5)",
                "localisation.ball.A.error_at_10m_m = None",
                "error_reduction.ball.A.1m = Some(0.2)",
                "landmarks.door.B.precision = Some(0.7)",
                "landmarks.door.B.recall = Some(0.9)",
            ]
        );
    }
}
