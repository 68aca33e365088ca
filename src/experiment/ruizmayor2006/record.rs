//! All that comes of it.

use super::{Ruizmayor2006Config, Worlds};
use crate::score::{MeanInterval, prediction_correction::PredictionCorrection};
use serde::Serialize;

/// All that came of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Ruizmayor2006Record {
    /// Of the crate.
    pub version: String,
    /// What was run.
    pub config: Ruizmayor2006Config,
    /// The printed constants first, then each other step in heading, then each other noise of the ranges, then the other
    /// worlds.
    pub experiments: Vec<ExperimentRecord>,
    /// Median time of a correction in seconds, one a step in heading, on one thread; priors are drawn, so that there is no time of a
    /// prediction (2.1). Records are equal whatever it is.
    pub timing: Ruizmayor2006Timing,
}

/// How long corrections took.
#[derive(Debug, Clone, Default, Serialize)]
#[non_exhaustive]
pub struct Ruizmayor2006Timing {
    /// In the order of `heading_steps_deg`.
    pub correction_s: Vec<f64>,
}

impl PartialEq for Ruizmayor2006Timing {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// One set of constants.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ExperimentRecord {
    /// s_T in degrees.
    pub heading_step_deg: f64,
    /// Standard deviation of the noise put on every range, in metres.
    pub range_noise_m: f64,
    /// In which worlds.
    pub worlds: Worlds,
    /// Poses that are compared in a correction.
    pub poses: usize,
    /// Of all repetitions together, a run a name.
    pub together: PredictionCorrection,
    /// Over the repetitions: of all three runs, then of each.
    pub figures: Vec<Figures>,
}

/// What R06 tells of its figures, each with its interval over repetitions.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Figures {
    /// `all runs`, `R1`, `R2` or `R3`.
    pub name: String,
    /// Estimates of one repetition.
    pub n: usize,
    /// The largest posterior position error, metres.
    pub largest_m: MeanInterval,
    /// And heading error, degrees.
    pub largest_deg: MeanInterval,
    /// What 95 % of the position errors stay within, metres.
    pub p95_m: MeanInterval,
    /// And of the heading errors, degrees.
    pub p95_deg: MeanInterval,
    /// Share of estimates within both maximum reachable precisions.
    pub optimal: MeanInterval,
    /// μ + σ of the position errors, metres (4-2).
    pub merit_m: MeanInterval,
    /// And of the heading errors, degrees.
    pub merit_deg: MeanInterval,
    /// C_XY, C_T and C_XYT with ≤.
    pub not_worse: [MeanInterval; 3],
    /// The same with <.
    pub better: [MeanInterval; 3],
}
