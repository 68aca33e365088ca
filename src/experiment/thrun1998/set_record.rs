//! What is known of one data set, put together from the runs that were judged on.

use crate::{
    belief::Uncertainty,
    error::{Error, Result},
    score::MeanInterval,
};
use serde::{Deserialize, Serialize};

/// What is known of one data set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SetRecord {
    /// `d1`, `d2` or `d3`.
    pub name: String,
    /// Snapshots of all its runs.
    pub snapshots: usize,
    /// E_prior with no idea where, in metres, mean over the runs that are judged on.
    pub prior_error_m: f64,
    /// One an approach, number of features, prior that it was trained for and prior that it was judged under.
    pub rows: Vec<ReductionRow>,
    /// Mean absolute correlation of two of the four features trained for ±2 m, on the runs that are judged on (T98 5.2.2).
    pub correlation: MeanInterval,
    /// What networks answer along the first run that is judged on (Figs. 7 and 8).
    pub outputs: Vec<OutputRecord>,
}

/// Error reductions of one approach under one prior, as shares.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ReductionRow {
    /// `door`, `ceiling_light`, `ball` or `kernel`.
    pub approach: String,
    /// n; 0 of a kernel.
    pub features: usize,
    /// None where nothing was trained.
    pub trained_for: Option<Uncertainty>,
    /// Under which prior it is judged.
    pub judged_at: Uncertainty,
    /// By the objective (T98 eq. 42) on the run that is judged on alone: its snapshots are truths and candidates. None of a kernel.
    pub objective: Option<MeanInterval>,
    /// By the map of the other runs: what a robot would have.
    pub held_out: Option<MeanInterval>,
}

/// What networks answer along a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OutputRecord {
    /// n.
    pub features: usize,
    /// The prior that they were trained for.
    pub trained_for: Uncertainty,
    /// Metres along the corridor, ascending.
    pub route_m: Vec<f64>,
    /// P(f_i = 1 | s), one list a feature.
    pub activation: Vec<Vec<f64>>,
}

/// Error reductions in one fold.
pub(super) struct JudgedFold {
    pub snapshots: usize,
    pub prior_error_m: f64,
    pub rows: Vec<JudgedRow>,
    pub correlation: f64,
    pub outputs: Vec<OutputRecord>,
}

/// An approach under one prior.
pub(super) struct JudgedRow {
    pub approach: &'static str,
    pub features: usize,
    pub trained_for: Option<Uncertainty>,
    pub judged_at: Uncertainty,
    pub objective: Option<f64>,
    pub held_out: Option<f64>,
}

impl SetRecord {
    /// Folds of one data set put together; all have the same rows.
    pub(super) fn of(name: &str, folds: Vec<JudgedFold>) -> Result<Self> {
        let Some(first) = folds.first() else {
            return Err(Error::work("thrun1998: no run to be judged on"));
        };
        let of_row = |row: usize| {
            let like = &first.rows[row];
            let mean = |of: fn(&JudgedRow) -> Option<f64>| {
                let values: Option<Vec<f64>> = folds.iter().map(|f| of(&f.rows[row])).collect();
                MeanInterval::of(&values?)
            };
            ReductionRow {
                approach: like.approach.into(),
                features: like.features,
                trained_for: like.trained_for,
                judged_at: like.judged_at,
                objective: mean(|row| row.objective),
                held_out: mean(|row| row.held_out),
            }
        };
        let mean = |of: fn(&JudgedFold) -> f64, what: &str| {
            let values: Vec<f64> = folds.iter().map(of).collect();
            MeanInterval::of(&values)
                .ok_or_else(|| Error::work(format!("thrun1998: {what} is no finite number")))
        };
        Ok(Self {
            name: name.into(),
            snapshots: first.snapshots,
            prior_error_m: mean(|fold| fold.prior_error_m, "the prior error")?.mean,
            rows: (0..first.rows.len()).map(of_row).collect(),
            correlation: mean(|fold| fold.correlation, "the features' correlation")?,
            outputs: first.outputs.clone(),
        })
    }

    /// The row of an approach.
    pub fn row(
        &self,
        approach: &str,
        features: usize,
        trained_for: Option<Uncertainty>,
        judged_at: Uncertainty,
    ) -> Option<&ReductionRow> {
        self.rows.iter().find(|row| {
            (row.approach.as_str(), row.features) == (approach, features)
                && (row.trained_for, row.judged_at) == (trained_for, judged_at)
        })
    }
}
