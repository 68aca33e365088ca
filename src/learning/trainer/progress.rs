//! What a training reports while it runs and when it is done.

use crate::{detector::net::Weights, learning::error_reduction::ErrorReduction};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

/// Where a training stands, given to its callback before every step and after the last.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Steps taken, those of earlier restarts included.
    pub step: usize,
    /// Most steps that the recipe allows, of all restarts together.
    pub most_steps: usize,
    /// Was the validation part judged at this very step (or would have been, where there is none)? A person who waits
    /// needs no line more often than that.
    pub judged: bool,
    /// Error reduction on the validation part when it was last judged: with the map, as in the finished model's scores.
    pub validation: Option<f64>,
    /// The best so far: the weights that will be kept.
    pub best_validation: Option<f64>,
    /// What the last step descended: the error reduction of its own draw of truths, priors and candidates. Where the
    /// truths' own snapshots are among the candidates this is far too good, and comparable with no other figure here.
    pub batch_error_reduction: f64,
}

/// Why a training ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum StoppedBy {
    /// No better validation error for `patience` steps.
    Validation,
    /// The recipe's most steps were taken.
    Steps,
    /// Nothing that holds on the validation part was learned for a quarter of the steps.
    NothingLearned,
    /// The callback answered [`Directive::Stop`](crate::learning::trainer::Directive::Stop).
    Callback,
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
    /// Evaluations of the objective with its gradient on the way; judgements of the validation part not counted.
    pub evaluations: usize,
    /// Why it ended.
    pub stopped_by: StoppedBy,
    /// Step of the checkpoint that it went on from, where it did.
    pub resumed_at: Option<usize>,
    /// Step of the checkpoint, of the same training with another number of steps, that it went on from under another
    /// schedule: an unbroken training of these steps would have ended in other bits.
    pub extended_at: Option<usize>,
}
