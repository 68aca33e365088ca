//! Which recording is played back, as a comparison's `[[dataset]]` says it.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A recording, from a dataset's file or simulated at once.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DatasetConfig {
    /// What tables call it; not said: as its file is called, without the ending.
    pub name: String,
    /// Dataset file, beside the TOML.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Or a world's file, beside the TOML.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub world: Option<PathBuf>,
    /// Seed of the simulation; not said: that of the comparison.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// This set of the world's runs only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
    /// This number of runs of each set, instead of the world's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<usize>,
}

impl DatasetConfig {
    /// A dataset's file, called as it is without its ending.
    pub fn file(path: impl Into<PathBuf>) -> Self {
        let file = Some(path.into());
        Self {
            file,
            ..Self::default()
        }
        .named()
    }

    /// A world's file, to be simulated at once, called as it is without its ending.
    pub fn world(path: impl Into<PathBuf>) -> Self {
        let world = Some(path.into());
        Self {
            world,
            ..Self::default()
        }
        .named()
    }

    /// With the name that it goes by.
    pub(super) fn named(mut self) -> Self {
        let path = self.file.as_ref().or(self.world.as_ref());
        if let (true, Some(stem)) = (self.name.is_empty(), path.and_then(|path| path.file_stem())) {
            self.name = stem.to_string_lossy().into_owned();
        }
        self
    }

    pub(super) fn check(&self) -> Result<()> {
        let wrong = |fault: &str| {
            let name = self.name.escape_debug();
            Err(Error::usage(format!("[[dataset]] `{name}`: {fault}")))
        };
        match (&self.file, &self.world) {
            (None, None) => wrong("neither `file` nor `world`; expected one of them"),
            (Some(_), Some(_)) => wrong("both `file` and `world`; expected one of them"),
            (Some(_), None) if self.seed.is_some() || self.set.is_some() || self.runs.is_some() => {
                wrong(
                    "`seed`, `set` and `runs` are for a `world`; expected none of them with `file`",
                )
            }
            _ => Ok(()),
        }
    }
}
