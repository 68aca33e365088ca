//! Configuration files: one TOML an experiment, a section a command.

use crate::{
    error::{Error, Result},
    experiment::global::LocaliseConfig,
    learning::Recipe,
    storage,
};
use serde::Deserialize;
use std::path::Path;

/// An experiment: what is trained how, and how it is localised with. Every key has a default; an unknown one is an error.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Experiment {
    /// For `train`.
    pub train: Recipe,
    /// For `localise`.
    pub localise: LocaliseConfig,
}

impl Experiment {
    /// Reads a configuration; without a file it is the default one.
    ///
    /// # Errors
    /// Where the file is no TOML, or a key is unknown or of the wrong type: the call is wrong. The message names the line.
    pub fn read(path: Option<&Path>) -> Result<Self> {
        let Some(path) = path else {
            return Ok(Self::default());
        };
        let bytes = storage::read_file(path)?;
        let text = String::from_utf8(bytes).map_err(|_| {
            Error::usage(format!("{}: not UTF-8 text; expected TOML", path.display()))
        })?;
        toml::from_str(&text).map_err(|e| {
            let before = e.span().map_or(0, |span| span.start.min(text.len()));
            let line = 1 + text.bytes().take(before).filter(|b| *b == b'\n').count();
            let fault = e.message().replace('\n', " ");
            Error::usage(format!("{}: line {line}: {fault}", path.display()))
        })
    }
}
