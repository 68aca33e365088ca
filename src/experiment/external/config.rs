//! What a configuration says of somebody else's localiser: `kind = "external"`.

use crate::{
    error::{Error, Result},
    registry::Constants,
};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Longest that a command may take for a trial, in seconds: a day.
const LONGEST_S: f64 = 86_400.0;

/// Which starts a localiser was asked about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Starts {
    /// Trials that start anywhere, and the same from a known start.
    #[default]
    Both,
    /// Those that start anywhere: figures of known starts stay empty.
    Unknown,
}

/// A localiser that is judged by the answers it wrote to files, or that is run for every trial.
///
/// ```
/// use ballmark::experiment::compare::CompareConfig;
/// let config = CompareConfig::parse(r#"
///     [[dataset]]
///     file = "walk.npz"
///     [[system]]
///     name = "mine"
///     kind = "external"
///     command = ["python3", "mine.py", "{trial_csv}", "{answer_tum}", "{start}"]
///     timeout_s = 60
///     [localisation]
/// "#)?;
/// assert_eq!(config.system[0].system.to_json()?["timeout_s"], 60.0);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExternalConfig {
    /// Folder of its answers: for the trial `unknown-001` the file `unknown-001.tum`, `unknown-001.csv`, or both: then the first has
    /// its answers, the second its beliefs. Empty where a `command` makes them.
    pub answers: PathBuf,
    /// A program and its arguments, run once a trial in the configuration's folder; in them `{trial_csv}`, `{trial_carmen}`,
    /// `{trial_mcap}` and `{trial_npz}` are files of what it may see, `{answer_tum}` and `{answer_csv}` those that it is to write,
    /// `{start}` is `x,y,heading` in metres and radians or `unknown`, `{trial}` the trial's name, `{seed}` a seed and `{particles}` their number. Empty: it was run before.
    pub command: Vec<String>,
    /// Seconds that the command may take for a trial.
    pub timeout_s: f64,
    /// Seconds that an answer's time stamp may differ from its snapshot's.
    pub tolerance_s: f64,
    /// Which starts it was asked about.
    pub start: Starts,
    /// Is a snapshot without an answer one of which it knows nothing? If not, it is a fault.
    pub may_be_silent: bool,
    /// What `{particles}` stands for; with `more_particles` in `[localisation]` it is asked again with more. 0: it has none. Of commands only.
    pub particles: usize,
    /// How often all trials are played once more with another `{seed}`, and once with the same: how much its answers are chance. Of
    /// commands only.
    pub repeats: usize,
    /// Folder that the command runs in: that of the configuration.
    #[serde(skip, default = "here")]
    pub folder: PathBuf,
}

fn here() -> PathBuf {
    PathBuf::from(".")
}

impl Default for ExternalConfig {
    fn default() -> Self {
        Self {
            answers: PathBuf::new(),
            command: Vec::new(),
            timeout_s: 600.0,
            tolerance_s: 0.05,
            start: Starts::default(),
            may_be_silent: false,
            particles: 0,
            repeats: 0,
            folder: here(),
        }
    }
}

/// Most repetitions: of a hundred, none says more than the others.
const MOST_REPEATS: usize = 100;

impl Constants for ExternalConfig {
    fn kind(&self) -> &str {
        "external"
    }

    fn description(&self) -> &str {
        "Somebody else's localiser, by its answers in files."
    }

    /// # Errors
    /// Where neither answers nor a command are named, or a number makes no sense.
    fn check(&self) -> Result<()> {
        let wrong =
            |key: &str, expected: &str| Err(Error::usage(format!("{key}: expected {expected}")));
        match (self.answers.as_os_str().is_empty(), self.command.is_empty()) {
            (true, true) => {
                return wrong(
                    "answers",
                    "the folder of its answers, or a `command` that makes them",
                );
            }
            (false, false) => {
                return wrong(
                    "command",
                    "either a `command` or the folder `answers` of what it said before, not both",
                );
            }
            _ => {}
        }
        if !(self.timeout_s > 0.0 && self.timeout_s <= LONGEST_S) {
            return wrong("timeout_s", "seconds above 0, up to 86400");
        }
        if !(self.tolerance_s >= 0.0 && self.tolerance_s <= 10.0) {
            return wrong("tolerance_s", "seconds from 0 to 10");
        }
        if self.repeats > MOST_REPEATS {
            return wrong("repeats", "at most 100");
        }
        let names = |placeholder| self.command.iter().any(|word| word.contains(placeholder));
        if (self.particles > 0) != names("{particles}") {
            return wrong(
                "particles",
                "their number where `{particles}` stands in the `command`, and there alone",
            );
        }
        if self.repeats > 0 && !names("{seed}") {
            return wrong(
                "repeats",
                "a `command` with `{seed}` in it, to repeat with others",
            );
        }
        Ok(())
    }

    fn particles(&mut self) -> Option<&mut usize> {
        Some(&mut self.particles).filter(|particles| **particles > 0)
    }

    fn files(&mut self) -> Vec<&mut PathBuf> {
        vec![&mut self.answers, &mut self.folder]
    }
}
