//! A robot that localises, and learns from what it sensed on the way: self-labelled snapshots update its model.
//!
//! Of the run's poses only the judge of the labels knows; the labels, and so the updated model, are the same whatever they say.

use crate::{
    belief::Places,
    error::{Error, Result},
    learning::trainer::Progress,
    localiser::self_labels::{KnownStart, SelfLabel, SelfLabelConfig, of_model},
    model::{Memory, Model, UpdateConfig, update},
    recording::Recording,
};
use serde::{Deserialize, Serialize};

/// An error of a label beyond this is a wrong label, in metres.
const WRONG_M: f64 = 1.0;

/// How a model is adapted: a configuration's section `[adapt]`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdaptConfig {
    /// Where the robot believes that it was, and what it believes of that.
    pub labels: SelfLabelConfig,
    /// What is made of it.
    pub update: UpdateConfig,
}

impl AdaptConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let checked = self.labels.check().and_then(|()| self.update.check());
        checked.map_err(|e| e.context("adapt"))
    }
}

/// Errors of some labels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LabelErrors {
    /// Half of them are below this, metres.
    pub median_m: f64,
    /// 95 of 100 are below this, metres.
    pub p95_m: f64,
    /// Share that is wrong: by more than a metre.
    pub beyond_1m: f64,
}

/// What came of labelling a run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LabelRecord {
    /// Snapshots of the run.
    pub snapshots: usize,
    /// Those whose labels were kept.
    pub kept: usize,
    /// Those that the robot believed to be beyond the map ([`SelfLabel::beyond`]), of which none is kept unless the gate is open.
    #[serde(default)]
    pub beyond: usize,
    /// Errors of the labels that were kept; none where there are none, or the truth lies in another frame than the map.
    pub errors: Option<LabelErrors>,
    /// Of all labels, kept or not.
    pub errors_of_all: Option<LabelErrors>,
}

/// A model after a run.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Adapted {
    /// The model: as it was where no label was kept.
    pub model: Model,
    /// What its map is made of; none where that was not at hand.
    pub memory: Option<Memory>,
    /// How good the labels were.
    pub labels: LabelRecord,
}

/// Lets a model label a recording by itself, and updates it with the labels that pass the gate; the first run begins at `start`,
/// where that is known. `memory` is what the model's map is made of.
///
/// # Errors
/// Where a constant makes no sense, the recording lacks a sensor of the model or its odometry never moves, and as
/// [`update`].
pub fn adapt(
    model: &Model,
    memory: Option<&Memory>,
    recording: &Recording,
    config: &AdaptConfig,
    start: Option<KnownStart>,
    on_progress: &mut dyn FnMut(Progress),
) -> Result<Adapted> {
    config.check()?;
    check_odometry(recording)?;
    let labels = of_model(model, recording, &config.labels, start)?;
    let record = judged(&labels, recording, &model.places());
    let Some(labelled) = labelled(&*model.seen_in(recording)?, &labels)? else {
        return Ok(Adapted {
            model: model.clone(),
            memory: memory.cloned(),
            labels: record,
        });
    };
    let updated = update(model, memory, &labelled, &config.update, on_progress)?;
    Ok(Adapted {
        model: updated.model,
        memory: updated.memory,
        labels: record,
    })
}

/// Those snapshots of a recording whose labels were kept, at the poses, and along the route, that the labels say; none where there
/// are none.
///
/// # Errors
/// Where a label is no place.
pub fn labelled(recording: &Recording, labels: &[SelfLabel]) -> Result<Option<Recording>> {
    let kept: Vec<usize> = (0..labels.len()).filter(|&k| labels[k].kept).collect();
    if kept.is_empty() {
        return Ok(None);
    }
    let mut columns = recording.columns().clone();
    columns.pose = labels.iter().map(|label| label.pose).collect();
    columns.route_m = labels.iter().map(|label| label.route_m).collect();
    Recording::new(columns)?.select(&kept).map(Some)
}

/// Holds labels against the truth.
pub fn judged(labels: &[SelfLabel], recording: &Recording, map: &Places) -> LabelRecord {
    let truth = recording.poses().iter();
    let route_m = recording.route_m();
    let error_m = |(k, (label, truth)): (usize, (&SelfLabel, &crate::geometry::Pose))| match map {
        Places::Plane(_) => Some(label.pose.distance_m(truth)),
        Places::Route(_) => Some((label.route_m? - route_m?[k]).abs()),
    };
    let errors_m: Option<Vec<f64>> = labels.iter().zip(truth).enumerate().map(error_m).collect();
    let errors = |of_all: bool| {
        let errors_m = errors_m.as_ref()?.iter().zip(labels);
        let asked = errors_m.filter(|(_, label)| of_all || label.kept);
        LabelErrors::of(asked.map(|(error_m, _)| *error_m).collect())
    };
    LabelRecord {
        snapshots: labels.len(),
        kept: labels.iter().filter(|label| label.kept).count(),
        beyond: labels.iter().filter(|label| label.beyond).count(),
        errors: errors(false),
        errors_of_all: errors(true),
    }
}

impl LabelErrors {
    fn of(mut errors_m: Vec<f64>) -> Option<Self> {
        errors_m.sort_by(f64::total_cmp);
        let last = errors_m.len().checked_sub(1)? as f64;
        let quantile = |q: f64| errors_m[(last * q).round() as usize];
        let wrong = errors_m.iter().filter(|m| **m > WRONG_M).count();
        Some(Self {
            median_m: quantile(0.5),
            p95_m: quantile(0.95),
            beyond_1m: wrong as f64 / errors_m.len() as f64,
        })
    }
}

/// A robot without odometry labels nothing: all its snapshots would be of one place.
fn check_odometry(recording: &Recording) -> Result<()> {
    let moved = |run: std::ops::Range<usize>| {
        let first = recording.observation(run.start).odometry;
        run.into_iter()
            .any(|k| recording.observation(k).odometry != first)
    };
    match recording.len() == 1 || recording.runs().into_iter().any(moved) {
        true => Ok(()),
        false => Err(Error::work(
            "`odometry` never moves; expected what the robot reckons that it has driven, to label by",
        )),
    }
}

#[cfg(test)]
mod tests;
