//! `ballmark trajectory --config`: several runs, and what a reader must know of them.

use crate::{
    error::{Error, Result},
    score::prediction_correction::{FrameworkReport, RunConditions},
    toml_file::TomlFile,
};
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

/// An experiment of one run or more.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrajectoryExperiment {
    /// The experiments framework report (R06 3.1): what holds for all runs. Whatever is not stated is printed as missing.
    pub framework: FrameworkReport,
    /// The runs, as `[[run]]`; without any EST and REF are named in the call.
    pub run: Vec<RunConfig>,
}

/// A run: its files, beside the TOML, and its conditions.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RunConfig {
    /// What tables call it; not said: as the file of its estimate is called, without the ending.
    pub name: String,
    /// Estimated poses.
    pub estimate: PathBuf,
    /// The true poses.
    pub reference: PathBuf,
    /// Estimates before correction. Not said: they are not known.
    pub prior: Option<PathBuf>,
    /// The run conditions report (R06 3.2), as `[run.conditions]`.
    pub conditions: RunConditions,
}

impl TrajectoryExperiment {
    /// Reads one, its files found.
    ///
    /// # Errors
    /// A usage error where it is no TOML, a key is unknown, or a run lacks a file or has a name twice.
    pub fn read(path: &Path) -> Result<Self> {
        let file = TomlFile::read(path)?;
        let mut config: Self = file.parse()?;
        let folder = path.with_file_name("");
        let mut names = BTreeSet::new();
        for (number, run) in config.run.iter_mut().enumerate() {
            let wrong = |fault: String| {
                file.locate(Error::usage(format!("[[run]] {}: {fault}", number + 1)))
            };
            for (key, name) in [("estimate", &run.estimate), ("reference", &run.reference)] {
                if name.as_os_str().is_empty() {
                    return Err(wrong(format!("no `{key}`; expected a file of poses")));
                }
            }
            if run.name.trim().is_empty() {
                let stem = run.estimate.file_stem().unwrap_or_default();
                run.name = stem.to_string_lossy().into_owned();
            }
            if !names.insert(run.name.clone()) {
                return Err(wrong(format!(
                    "`name` is `{}`, as another run's; expected a name of its own for each",
                    run.name.escape_debug()
                )));
            }
            for name in [&mut run.estimate, &mut run.reference]
                .into_iter()
                .chain(&mut run.prior)
            {
                *name = folder.join(&name);
            }
        }
        Ok(config)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<TrajectoryExperiment> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("runs.toml");
        std::fs::write(&path, text).unwrap();
        TrajectoryExperiment::read(&path)
    }

    #[test]
    fn files_are_beside_the_configuration_and_name_their_runs() {
        let config = read(
            "[framework]\nrobot = 'r'\n[[run]]\nestimate = 'a/est.tum'\nreference = 'ref.tum'\n[run.conditions]\nplace = 'hall'",
        )
        .unwrap();
        let run = &config.run[0];
        assert_eq!(run.name, "est");
        assert!(run.estimate.is_absolute() && run.estimate.ends_with("a/est.tum"));
        assert_eq!(
            (run.prior.as_ref(), run.conditions.place.as_deref()),
            (None, Some("hall"))
        );
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, parts) in [
            (
                "[[run]]\nreference = 'r'",
                &["line 1", "[[run]] 1", "`estimate`"][..],
            ),
            (
                "[[run]]\nestimate = 'e'\nreference = 'r'\n[[run]]\nestimate = 'e'\nreference = 'q'",
                &["[[run]] 2", "`e`", "as another run's"],
            ),
            (
                "[framework]\nrobots = 'r'",
                &["line 2", "unknown field `robots`"],
            ),
            ("[[run]]\nestimate = 3", &["line 2", "invalid type"]),
        ] {
            let error = read(text).unwrap_err();
            for part in parts {
                let message = error.to_string();
                assert!(
                    error.is_usage() && message.contains(part),
                    "{part} in {message}"
                );
            }
        }
    }
}
