//! What a training says while it runs and when it is done.

use crate::{detector::net::Weights, learning::error_reduction::ErrorReduction};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

/// What training says while it runs.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Steps taken, of at most `most_steps`.
    pub step: usize,
    /// The recipe's limit.
    pub most_steps: usize,
    /// Error reduction on the training part at the last step.
    pub training: f64,
    /// Best error reduction on the validation part so far.
    pub validation: Option<f64>,
}

/// Why training ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StoppedBy {
    /// No better validation error for `patience` steps.
    Validation,
    /// The recipe's most steps were taken.
    Steps,
}

/// Trained weights and how they came about.
#[derive(Debug, Clone)]
pub struct Trained {
    /// The weights of the best validation error; of the last step where nothing could be validated.
    pub weights: Weights,
    /// Their activations on the training part, `[snapshot, feature]`.
    pub activation: Array2<f32>,
    /// On the training part, with the map that localisation uses.
    pub train: ErrorReduction,
    /// On the validation part.
    pub validation: Option<ErrorReduction>,
    /// Steps taken.
    pub steps: usize,
    /// Evaluations of the objective with its gradient on the way; looks at the validation part not counted.
    pub evaluations: usize,
    /// Why it ended.
    pub stopped_by: StoppedBy,
}
