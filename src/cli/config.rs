//! Configuration files: one TOML an experiment, a section a command.

use crate::{
    error::{Error, Result},
    experiment::localisation::LocaliseConfig,
    learning::{
        Recipe,
        recipe::{FORMER_KEYS, Named},
    },
    storage,
};
use serde::Deserialize;
use std::path::Path;

/// An experiment: what is trained how, and how it is localised with. Every key has a default; an unknown one is an error.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Experiment {
    /// What holds for `train` where this is silent.
    pub recipe: Named,
    /// For `train`.
    pub train: Recipe,
    /// For `localise`.
    pub localise: LocaliseConfig,
}

impl Experiment {
    /// Reads a configuration; without a file it is the default one. A `recipe` given here stands before the file's own.
    ///
    /// # Errors
    /// Where the file is no TOML, or a key is unknown or of the wrong type: the call is wrong. The message names the line.
    pub fn read(path: Option<&Path>, recipe: Option<Named>) -> Result<Self> {
        let Some(path) = path else {
            return Ok(Self {
                train: recipe.unwrap_or_default().recipe(),
                ..Self::default()
            });
        };
        let bytes = storage::read_file(path)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            Error::usage(format!("{}: not UTF-8 text; expected TOML", path.display()))
        })?;
        let mut experiment: Self = toml::from_str(&text).map_err(|e| {
            let before = e.span().map_or(0, |span| span.start.min(text.len()));
            let line = 1 + text.bytes().take(before).filter(|b| *b == b'\n').count();
            let fault = e.message().replace('\n', " ");
            Error::usage(format!("{}: line {line}: {fault}", path.display()))
        })?;
        let named = recipe.unwrap_or(experiment.recipe);
        // The text is sound: what it says of training is now put over what the named recipe says.
        let merged = || -> std::result::Result<Recipe, toml::de::Error> {
            let mut keys =
                toml::Value::try_from(named.recipe()).map_err(serde::de::Error::custom)?;
            let mut table: toml::Table = toml::from_str(&text)?;
            if let Some(train) = table.get_mut("train") {
                with_current_names(train);
                put_over(&mut keys, train);
            }
            keys.try_into()
        };
        experiment.train =
            merged().map_err(|e| Error::usage(format!("{}: {}", path.display(), e.message())))?;
        Ok(experiment)
    }
}

/// Gives the keys of `[train]` that had another name in the version before their names of now.
fn with_current_names(train: &mut toml::Value) {
    let Some(descent) = train.get_mut("descent").and_then(|d| d.as_table_mut()) else {
        return;
    };
    for (former, current) in FORMER_KEYS {
        if let Some(value) = descent.remove(former) {
            descent.entry(current).or_insert(value);
        }
    }
}

/// Puts the keys of one table over those of another, table by table.
fn put_over(under: &mut toml::Value, over: &toml::Value) {
    match (under, over) {
        (toml::Value::Table(under), toml::Value::Table(over)) => {
            for (key, value) in over {
                match under.get_mut(key) {
                    Some(place) => put_over(place, value),
                    None => {
                        under.insert(key.clone(), value.clone());
                    }
                }
            }
        }
        (under, over) => *under = over.clone(),
    }
}
