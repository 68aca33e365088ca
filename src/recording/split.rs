//! Parts to learn from, to stop learning by, and to be judged on; none of them cuts a run or a stretch of path.
//!
//! Neighbouring snapshots look alike, so a snapshot beside a training snapshot is no unseen one. The smallest thing that is
//! put on one side is therefore a *unit*: a whole run, or a stretch of so many metres of path inside a run.

use super::Recording;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// How to split, as it stands in a configuration.
///
/// Units are numbered from 0 in the order of the recording. Unit u is tested on where u mod `folds` = `test_fold`. Of the
/// others, counted on their own from 0, the last of every `validation_every` is for validation. Where the stretches of a
/// run would come to be dealt just as those of the run before, one number is left out between them.
///
/// ```
/// let config: ballmark::recording::split::SplitConfig =
///     serde_json::from_str(r#"{"unit": "10m", "folds": 5, "test_fold": 0, "validation_every": 4}"#).unwrap();
/// assert_eq!(config.unit, ballmark::recording::split::Unit::Stretch(10.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SplitConfig {
    /// What is never cut.
    pub unit: Unit,
    /// Number of folds that the units are dealt to in turn.
    pub folds: usize,
    /// The fold to test on; without it nothing is held back for testing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test_fold: Option<usize>,
    /// One unit in so many of those not tested on is for validation, where there are so many; 0: none.
    pub validation_every: usize,
}

/// What a split never cuts. Written `"runs"`, `"15m"` or `"auto"`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
#[non_exhaustive]
pub enum Unit {
    /// Whole runs where there are at least [`ENOUGH_RUNS`], else stretches of [`AUTO_STRETCH_M`].
    Auto,
    /// Whole runs.
    Runs,
    /// Stretches of so many metres of true path inside a run.
    Stretch(f64),
}

/// With so many runs, [`Unit::Auto`] keeps them whole.
pub const ENOUGH_RUNS: usize = 6;

/// Stretches of [`Unit::Auto`], in metres.
pub const AUTO_STRETCH_M: f64 = 15.0;

impl TryFrom<String> for Unit {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        let metres = |text: &str| text.strip_suffix('m')?.trim().parse::<f64>().ok();
        match text.trim() {
            "auto" => Ok(Unit::Auto),
            "runs" => Ok(Unit::Runs),
            other => metres(other).filter(|m| m.is_finite() && *m > 0.0).map(Unit::Stretch).ok_or_else(|| {
                Error::usage(format!("split: `unit` is {text:?}; expected \"runs\", \"auto\" or metres such as \"15m\""))
            }),
        }
    }
}

impl From<Unit> for String {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::Auto => "auto".into(),
            Unit::Runs => "runs".into(),
            Unit::Stretch(metres) => format!("{metres}m"),
        }
    }
}

impl Default for SplitConfig {
    /// Four folds none of which is tested on, one unit in six for validation.
    fn default() -> Self {
        Self {
            unit: Unit::Auto,
            folds: 4,
            test_fold: None,
            validation_every: 6,
        }
    }
}

/// The pass that each of some snapshots is of, counted from 0: its run, or where all are of one run, its stretch of
/// [`AUTO_STRETCH_M`].
pub fn passes(recording: &Recording, snapshots: &[usize]) -> Vec<usize> {
    let runs = recording.run_numbers(snapshots);
    if runs.iter().any(|run| *run != runs[0]) {
        return runs;
    }
    let travelled_m = recording.travelled_m();
    let stretch = |&k: &usize| (travelled_m[k] / AUTO_STRETCH_M) as usize;
    snapshots.iter().map(stretch).collect()
}

/// Indices of the snapshots of each part, ascending.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Split {
    /// To learn from; never empty.
    pub train: Vec<usize>,
    /// To stop learning by.
    pub validation: Vec<usize>,
    /// To be judged on.
    pub test: Vec<usize>,
}

impl SplitConfig {
    /// Are the numbers possible, whatever the recording?
    ///
    /// # Errors
    /// A usage error that names the key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::usage(format!(
                "split: `{key}` is {value}; expected {expected}"
            )))
        };
        if let Unit::Stretch(metres) = self.unit
            && !(metres.is_finite() && metres > 0.0)
        {
            return wrong("unit", metres.to_string(), "metres above 0");
        }
        if self.folds == 0 {
            return wrong("folds", "0".into(), "at least 1");
        }
        if let Some(fold) = self.test_fold {
            if self.folds == 1 {
                return wrong(
                    "folds",
                    "1".into(),
                    "at least 2 where one of them is tested on",
                );
            }
            if fold >= self.folds {
                return wrong(
                    "test_fold",
                    fold.to_string(),
                    &format!("a fold from 0 to {}", self.folds - 1),
                );
            }
        }
        if self.validation_every == 1 {
            return wrong(
                "validation_every",
                "1".into(),
                "0 or at least 2, or nothing is left to learn from",
            );
        }
        Ok(())
    }

    /// Metres of a stretch; `None`: whole runs.
    fn stretch_m(&self, recording: &Recording) -> Option<f64> {
        match self.unit {
            Unit::Runs => None,
            Unit::Auto if recording.runs().len() >= ENOUGH_RUNS => None,
            Unit::Auto => Some(AUTO_STRETCH_M),
            Unit::Stretch(metres) => Some(metres),
        }
    }

    /// Splits a recording.
    ///
    /// # Errors
    /// Where the configuration is wrong, or the recording has too few units to learn from, or to test on where that is asked for. With too
    /// few to validate, the validation part is empty.
    ///
    /// ```
    /// # let log: Vec<u8> = (0..40).flat_map(|x| format!("FLASER 1 1.5 {x} 0 0 {x} 0 0 {x} h {x}\n").into_bytes()).collect();
    /// # let recording = ballmark::recording::format::carmen::read("walk.log".as_ref(), &log, &Default::default())?.recording;
    /// use ballmark::recording::split::{SplitConfig, Unit};
    /// // 40 snapshots, one a metre: stretches 0 to 3; 0 and 2 are fold 0.
    /// let config = SplitConfig { unit: Unit::Stretch(10.0), folds: 2, test_fold: Some(0), validation_every: 2 };
    /// let split = config.split(&recording)?;
    /// assert_eq!(split.test[10], 20);
    /// assert_eq!((split.train.len(), split.validation.len(), split.test.len()), (10, 10, 20));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn split(&self, recording: &Recording) -> Result<Split> {
        self.check()?;
        let mut split = Split::default();
        let stretch_m = self.stretch_m(recording);
        let units = units(recording, stretch_m);
        let count = units.len();
        let mut starts = recording
            .runs()
            .into_iter()
            .map(|run| run.start)
            .skip(1)
            .peekable();
        let (mut number, mut rest) = (0, 0);
        let (mut run_number, mut run_rest) = (0, 0); // at the start of the run
        for unit in units {
            if starts.next_if_eq(&unit.start).is_some() && stretch_m.is_some() {
                // Runs of the same length would all give the same piece of the building away, and nobody would learn
                // it: such a run is dealt to from the next fold on.
                number += usize::from((number - run_number) % self.folds == 0);
                rest += usize::from((rest - run_rest) % self.validation_every.max(1) == 0);
                (run_number, run_rest) = (number, rest);
            }
            let fold = number % self.folds;
            number += 1;
            let part = if self.test_fold == Some(fold) {
                &mut split.test
            } else {
                rest += 1;
                match rest % self.validation_every.max(1) {
                    0 if self.validation_every > 0 => &mut split.validation,
                    _ => &mut split.train,
                }
            };
            part.extend(unit);
        }
        for (part, asked, snapshots) in [
            ("learn from", true, &split.train),
            ("test on", self.test_fold.is_some(), &split.test),
        ] {
            if asked && snapshots.is_empty() {
                return Err(Error::work(format!(
                    "split: the recording has {count} {}, which leaves none to {part}; expected more, shorter stretches, or another split",
                    if stretch_m.is_some() {
                        "stretches"
                    } else {
                        "runs"
                    },
                )));
            }
        }
        Ok(split)
    }
}

/// The snapshots of each unit, in the order of the recording.
fn units(recording: &Recording, stretch_m: Option<f64>) -> Vec<std::ops::Range<usize>> {
    let Some(stretch_m) = stretch_m else {
        return recording.runs();
    };
    let travelled_m = recording.travelled_m();
    let mut units = Vec::new();
    for run in recording.runs() {
        let mut start = run.start;
        for k in run.start + 1..=run.end {
            let stretch = |k: usize| (travelled_m[k] / stretch_m).floor();
            if k == run.end || stretch(k) != stretch(k - 1) {
                units.push(start..k);
                start = k;
            }
        }
    }
    units
}

#[cfg(test)]
mod tests;
