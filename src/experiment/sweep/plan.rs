//! From a sweep file to cells: every combination is read as the command will read it, so that what can't run is refused before anything does.

use super::{
    cell::{Base, Cell, VERSION, name},
    config::{Setting, SweepFile},
    inputs::{Input, Inputs},
};
use crate::{
    error::{Error, Result},
    toml_file::{TomlFile, put_over},
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::{collections::HashMap, path::Path};

/// What holds for all cells of a sweep: the content of `plan.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Of the program that planned, and that must run the cells.
    pub version: String,
    /// Number of cells.
    pub cells: usize,
    /// What cells start from.
    pub base: Base,
    /// Keys that cells differ in, in the order of the sweep file.
    pub keys: Vec<String>,
    /// What cells read.
    pub data: Vec<Input>,
    /// Figures that the sweep file asks for.
    pub metrics: Vec<String>,
    /// What others are held against: keys with values; empty: the first combination on the same data.
    pub baseline: Map<String, Value>,
}

/// A plan and its cells, by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// What holds for all.
    pub plan: Plan,
    /// In the order of their names.
    pub cells: Vec<Cell>,
}

/// Reads a sweep file, and makes its cells.
///
/// # Errors
/// A usage error with file, line and key where a key is unknown, a value is of the wrong type or makes no sense, two cells are the same, or an
/// option that the command needs is missing; an error that names the file where one of those that cells read is missing.
pub fn make_plan(path: &Path) -> Result<Planned> {
    let mut sweep = SweepFile::read(path)?;
    let command = sweep.config.command;
    let mut inputs = Inputs::default();
    let base = base(&sweep, &mut inputs)?;
    take_settings(&mut sweep, &mut inputs)?;
    let combinations = combinations(&sweep);
    let keys = keys(&combinations);
    for needed in command.needed() {
        let is_there = base.options.contains_key(*needed) || keys.iter().any(|key| key == needed);
        if !is_there {
            let fault = format!("no `{needed}`; `{}` needs one", command.name());
            return Err(sweep.file.locate(Error::usage(fault)));
        }
    }
    let inputs = inputs.into_all();
    let seeds: Vec<Option<u64>> = match &sweep.config.seeds {
        None => vec![None],
        Some(seeds) => seeds.iter().copied().map(Some).collect(),
    };
    let made: Vec<Result<Vec<Cell>>> = combinations
        .par_iter()
        .enumerate()
        .map(|(number, settings)| {
            let keys = as_json(settings)?;
            let call = base.call(keys.iter().map(|(key, value)| (key.as_str(), value)));
            let call = call.map_err(|fault| blamed(&sweep, &base, settings, fault))?;
            let resolved = command.resolved(&call.text);
            let mut resolved = resolved.map_err(|fault| blamed(&sweep, &base, settings, fault))?;
            let data = read_by(&call.text, &call.options, &inputs);
            let cell = |(at, seed): (usize, &Option<u64>)| {
                if let Some(seed) = seed {
                    command.put_seed(&mut resolved, *seed);
                }
                Cell {
                    name: name(command, &resolved, &call),
                    number: number * seeds.len() + at,
                    keys: keys.clone(),
                    seed: *seed,
                    data: data.clone(),
                }
            };
            Ok(seeds.iter().enumerate().map(cell).collect())
        })
        .collect();
    let mut cells = made.into_iter().collect::<Result<Vec<_>>>()?.concat();
    let mut seen: HashMap<&str, &Cell> = HashMap::new();
    for cell in &cells {
        if let Some(same) = seen.insert(&cell.name, cell) {
            let settings = &combinations[cell.number / seeds.len()];
            let differs = |setting: &&&Setting| {
                json(&setting.value).ok().as_ref() != same.keys.get(&setting.key)
            };
            let other = settings.iter().find(differs).or(settings.first());
            let line = other.map_or(1, |setting| setting.line);
            let fault = format!(
                "two cells are the same: {} and {}; what they differ in is nothing that `{}` reads",
                described(&same.keys, same.seed),
                described(&cell.keys, cell.seed),
                command.name()
            );
            return Err(sweep.file.refusal(line, fault));
        }
    }
    let baseline = baseline(&sweep)?;
    cells.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(Planned {
        plan: Plan {
            version: VERSION.to_string(),
            cells: cells.len(),
            base,
            keys: differing(keys, &combinations),
            data: inputs,
            metrics: sweep.config.metrics.clone(),
            baseline,
        },
        cells,
    })
}

/// Keys and seed for a reader: `train.features = 4, seed 2`.
pub fn described(keys: &Map<String, Value>, seed: Option<u64>) -> String {
    let value = |(key, value): (&String, &Value)| format!("{key} = {}", shown(value));
    let words = keys.iter().map(value);
    let words = words.chain(seed.map(|seed| format!("seed {seed}")));
    let words: Vec<String> = words.collect();
    match words.is_empty() {
        true => "the only combination".to_string(),
        false => words.join(", "),
    }
}

/// A value for a reader: words without quotes, a file by its own name.
pub fn shown(value: &Value) -> String {
    match value {
        Value::String(word) => super::inputs::own_name(word).to_string(),
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(shown).collect();
            format!("[{}]", values.join(", "))
        }
        other => other.to_string(),
    }
}

/// What all cells share, checked as far as it stands alone.
fn base(sweep: &SweepFile, inputs: &mut Inputs) -> Result<Base> {
    let command = sweep.config.command;
    let config = &sweep.config;
    let mut keys = toml::Value::Table(toml::Table::new());
    let configured = config.config.is_some() || !config.base.is_empty();
    if configured && !command.is_configured() {
        let key = if config.config.is_some() {
            "config"
        } else {
            "base"
        };
        let fault = format!("`{key}`: `{}` reads no configuration", command.name());
        return Err(sweep.file.locate(Error::usage(fault)));
    }
    if let Some(name) = &config.config {
        let path = sweep.folder.join(name);
        let file = TomlFile::read(&path)?;
        keys = toml::Value::Table(file.parse()?);
        let folder = path.with_file_name("");
        let taken = inputs.take(&mut keys, "", &folder);
        taken.map_err(|fault| fault.in_file(&path))?;
    }
    let mut over = toml::Value::Table(config.base.clone());
    let taken = inputs.take(&mut over, "", &sweep.folder);
    taken.map_err(|fault| sweep.file.locate(fault.context("[base]")))?;
    put_over(&mut keys, &over);
    let mut options = Map::new();
    for (name, value) in &config.options {
        let mut value = value.clone();
        let in_options = |fault: Error| sweep.file.locate(fault.context("[options]"));
        command
            .check_option(name, &json(&value)?)
            .map_err(in_options)?;
        inputs
            .take(&mut value, name, &sweep.folder)
            .map_err(in_options)?;
        options.insert(name.clone(), json(&value)?);
    }
    match keys {
        toml::Value::Table(config) => Ok(Base {
            command,
            config,
            options,
        }),
        _ => Err(Error::work("a configuration that is no table")),
    }
}

/// Puts inputs in place of names of files in all values.
fn take_settings(sweep: &mut SweepFile, inputs: &mut Inputs) -> Result<()> {
    let (folder, file) = (sweep.folder.clone(), sweep.file.clone());
    let axes = sweep.axes.iter_mut().flatten();
    for setting in axes.chain(sweep.combinations.iter_mut().flatten()) {
        let taken = inputs.take(&mut setting.value, &setting.key, &folder);
        taken.map_err(|fault| file.refusal(setting.line, format!("{}: {fault}", setting.key)))?;
    }
    Ok(())
}

/// Every value of each key with every value of the others, the last key changing fastest.
fn combinations(sweep: &SweepFile) -> Vec<Vec<&Setting>> {
    let mut all: Vec<Vec<&Setting>> = vec![Vec::new()];
    for axis in &sweep.axes {
        all = all
            .iter()
            .flat_map(|before| {
                axis.iter()
                    .map(|setting| before.iter().copied().chain([setting]).collect())
            })
            .collect();
    }
    if !sweep.combinations.is_empty() {
        all = all
            .iter()
            .flat_map(|before| {
                sweep
                    .combinations
                    .iter()
                    .map(|more| before.iter().copied().chain(more).collect())
            })
            .collect();
    }
    all
}

/// All keys of cells, in the order of the file.
fn keys(combinations: &[Vec<&Setting>]) -> Vec<String> {
    let mut keys: Vec<String> = Vec::new();
    for setting in combinations.iter().flatten() {
        if !keys.contains(&setting.key) {
            keys.push(setting.key.clone());
        }
    }
    keys
}

/// Those of the keys that not all combinations have alike.
fn differing(keys: Vec<String>, combinations: &[Vec<&Setting>]) -> Vec<String> {
    let value = |combination: &[&Setting], key: &str| {
        let mut settings = combination.iter();
        settings.find(|s| s.key == key).map(|s| s.value.clone())
    };
    let differs = |key: &String| {
        let mut values = combinations.iter().map(|c| value(c, key));
        let first = values.next();
        values.any(|other| Some(other) != first)
    };
    keys.into_iter().filter(differs).collect()
}

/// The keys of the sweep file's baseline with values that some combination has.
fn baseline(sweep: &SweepFile) -> Result<Map<String, Value>> {
    let mut baseline = Map::new();
    let all = || {
        sweep
            .axes
            .iter()
            .flatten()
            .chain(sweep.combinations.iter().flatten())
    };
    let mut left = vec![(
        String::new(),
        toml::Value::Table(sweep.config.baseline.clone()),
    )];
    while let Some((path, value)) = left.pop() {
        let toml::Value::Table(table) = &value else {
            let mut found = all().filter(|setting| setting.key == path);
            let found = found.find(|s| {
                s.value == value
                    || shown(&json(&s.value).unwrap_or_default())
                        == shown(&json(&value).unwrap_or_default())
            });
            let setting = found.ok_or_else(|| {
                let fault = format!("baseline.{path} = {value}: no combination has it");
                sweep.file.locate(Error::usage(fault))
            })?;
            baseline.insert(path, json(&setting.value)?);
            continue;
        };
        for (key, value) in table {
            let path = match path.as_str() {
                "" => key.clone(),
                path => format!("{path}.{key}"),
            };
            left.push((path, value.clone()));
        }
    }
    Ok(baseline)
}

/// A fault of a combination, with the line of the key that has it alone, or else of the first.
fn blamed(sweep: &SweepFile, base: &Base, settings: &[&Setting], fault: Error) -> Error {
    let check = |settings: &[&Setting]| -> Result<()> {
        let keys = as_json(settings)?;
        let call = base.call(keys.iter().map(|(key, value)| (key.as_str(), value)))?;
        base.command.resolved(&call.text).map(drop)
    };
    if let Err(fault) = check(&[]) {
        let own = sweep.config.config.as_ref();
        let own = own.map(|name| sweep.folder.join(name));
        // By the file's own text its line is known.
        let in_own = own.and_then(|path| {
            let text = std::fs::read_to_string(&path).ok()?;
            let fault = base.command.resolved(&text).err()?;
            Some(fault.in_file(&path))
        });
        return match in_own {
            Some(fault) if sweep.config.base.is_empty() => fault,
            _ => sweep.file.locate(without_line(fault).context("[base]")),
        };
    }
    let alone = settings.iter().find_map(|setting| {
        let fault = check(&[*setting]).err()?;
        Some((*setting, fault))
    });
    match alone {
        Some((setting, fault)) => {
            let (key, value) = (&setting.key, json(&setting.value).unwrap_or_default());
            let fault = without_line(fault);
            let fault = format!("keys: {key} = {}: {fault}", shown(&value));
            sweep.file.refusal(setting.line, fault)
        }
        None => {
            let line = settings.last().map_or(1, |setting| setting.line);
            let keys = as_json(settings).unwrap_or_default();
            let fault = format!("{}: {}", described(&keys, None), without_line(fault));
            sweep.file.refusal(line, fault)
        }
    }
}

/// A fault of a text that nobody wrote: its line says nothing.
fn without_line(fault: Error) -> Error {
    let words = fault.to_string();
    let rest = words.strip_prefix("line ").and_then(|rest| {
        let (line, rest) = rest.split_once(": ")?;
        line.bytes().all(|b| b.is_ascii_digit()).then_some(rest)
    });
    match rest {
        Some(rest) => Error::usage(rest),
        None => fault,
    }
}

fn as_json(settings: &[&Setting]) -> Result<Map<String, Value>> {
    let one = |setting: &&Setting| Ok((setting.key.clone(), json(&setting.value)?));
    settings.iter().map(one).collect()
}

fn json(value: &toml::Value) -> Result<Value> {
    serde_json::to_value(value).map_err(|e| Error::work(format!("a value: {e}")))
}

/// Numbers of the inputs whose names stand in a call.
fn read_by(text: &str, options: &Map<String, Value>, inputs: &[Input]) -> Vec<usize> {
    let options = Value::Object(options.clone()).to_string();
    let named = |input: &Input| text.contains(&input.name) || options.contains(&input.name);
    let numbered = inputs.iter().enumerate();
    let read = numbered.filter(|(_, input)| named(input));
    read.map(|(number, _)| number).collect()
}
