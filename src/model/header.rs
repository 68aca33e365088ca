//! Everything about a model that is not an array: the JSON text in its file.

use super::update_config::UpdateConfig;
use crate::{
    belief::{OdometryMotion, Uncertainty, lost::LostConfig},
    detector::{input::Input, net::Activation},
    learning::{ErrorReduction, Recipe, trainer::StoppedBy},
    mapping::RangeSensors,
    recording::Channel,
};
use serde::{Deserialize, Serialize};

/// Everything about a model that is not an array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Header {
    /// Version of this crate that trained it.
    pub crate_version: String,
    /// The resolved configuration, seed and all.
    pub recipe: Recipe,
    /// Prior uncertainty that the filters are for.
    pub prior: Uncertainty,
    /// Sensors of the recording it was trained on.
    pub channels: Vec<Channel>,
    /// SHA-256 of the dataset file it was trained on, where it came from a file.
    pub dataset_sha256: Option<String>,
    /// Preprocessing; its mean and deviation stand in the arrays.
    pub input: Input,
    /// Activation of the hidden units.
    pub activation: Activation,
    /// How far the odometry of the training part can be trusted.
    pub motion: OdometryMotion,
    /// Power that a snapshot's evidence is taken to in the Bayes filter, as tuned on whole sequences of the validation part;
    /// none where there was none, or the file is older.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence_scale: Option<f64>,
    /// When a robot with these features counts as lost, as tuned on the same sequences; none likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lost: Option<LostConfig>,
    /// Expected errors reached.
    pub scores: Scores,
    /// Where and how scans are rendered, where the map is filled from that: its cells stand in the arrays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub occupancy: Option<OccupancyHeader>,
    /// How the training went; none in files written before this was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub training: Option<TrainingRecord>,
    /// What it was updated with since, in that order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub updates: Vec<UpdateRecord>,
}

/// An occupancy map in a model, and how wide the beams are that look at it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OccupancyHeader {
    /// Edge of a cell, in metres.
    pub cell_m: f64,
    /// South-west corner of the first cell, in the frame of the training poses, in metres.
    pub origin_m: [f64; 2],
    /// The sensors that rendered scans are of.
    pub sensors: RangeSensors,
}

/// How the training of a model went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TrainingRecord {
    /// Which training it was: SHA-256 of the crate's version, the recording's content and the whole recipe.
    pub identity: String,
    /// The same without the recipe's number of steps.
    pub identity_but_for_steps: String,
    /// Steps taken.
    pub steps: usize,
    /// Evaluations of the objective with its gradient on the way.
    pub evaluations: usize,
    /// The pre-trained networks that it began with, by their file's name; none: random ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub began_with: Option<String>,
    /// Why it ended.
    pub stopped_by: StoppedBy,
    /// Step of the checkpoint, of the same training with another number of steps, that it went on from under another
    /// schedule: an unbroken training of these steps would have ended in other bits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extended_at: Option<usize>,
    /// Training snapshots, where only some of their places are in the map.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learned_from: Option<usize>,
    /// The share of the validation error that was taken away by what was learned, where random features, which are the model's, took
    /// away more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub random_better_than: Option<f64>,
}

/// An update of a model with snapshots that came after its training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct UpdateRecord {
    /// Version of this crate that made it.
    pub crate_version: String,
    /// SHA-256 of the dataset file that the snapshots are of, where they came from a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dataset_sha256: Option<String>,
    /// How it was made.
    pub config: UpdateConfig,
    /// Snapshots that came into the map.
    pub added: usize,
    /// Snapshots that went out of it.
    pub forgotten: usize,
    /// Steps of training that were taken.
    pub steps: usize,
    /// Error reduction on the stretches that were kept back of the new snapshots, before and after these steps.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub validation: Option<[f64; 2]>,
}

/// Expected errors of a model on the parts of the recording it was trained on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Scores {
    /// On the training part, with the map that localisation uses.
    pub train: ErrorReduction,
    /// On the validation part; none where no validation snapshot lies at a place seen in training.
    pub validation: Option<ErrorReduction>,
}
