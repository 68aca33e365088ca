//! What sensor models said of single snapshots, as it is kept for products of several.

use crate::{
    error::{Error, Result},
    learning::error_reduction::ErrorReduction,
};
use ndarray::Array2;
use std::sync::Arc;

/// What a sensor model says of single snapshots, and how far it is to be believed: all that a product of several asks of each.
#[derive(Debug)]
pub struct SingleSnapshots {
    /// ln P(s | candidate) of the unseen snapshots at places that training saw, `[snapshot, candidate]`, less the largest of each.
    pub(super) on_run: Array2<f32>,
    /// The same of those of the validation part.
    pub(super) on_validation: Array2<f32>,
    /// Of every prior, the power of least error on the validation part; empty where nothing can be validated.
    pub(super) powers: Vec<f64>,
}

/// What one snapshot of the unseen part says under every prior, and the evidence behind it, where it is kept.
#[derive(Debug, Default)]
pub struct Judged {
    /// One a prior.
    pub held_out: Vec<ErrorReduction>,
    /// For products; none of the exact objective, which has no likelihood, nor where it is too much to keep.
    pub evidence: Option<Arc<SingleSnapshots>>,
}

/// ln P(s | candidate) of a row, by all factors to their powers.
pub(super) fn together(
    factors: &[&SingleSnapshots],
    powers: &[f64],
    row: usize,
    of: fn(&SingleSnapshots) -> &Array2<f32>,
) -> Vec<f64> {
    let mut sum = vec![0.0; factors.first().map_or(0, |factor| of(factor).ncols())];
    for (factor, power) in factors.iter().zip(powers) {
        for (sum, l) in sum.iter_mut().zip(of(factor).row(row)) {
            *sum += power * f64::from(*l);
        }
    }
    sum
}

/// Rows of logarithms as they are kept: less the largest of each, so that f32 is fine enough.
pub(super) fn table(rows: &[Vec<f64>], width: usize) -> Result<Array2<f32>> {
    let kept = rows.iter().flat_map(|row| {
        let largest = row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        row.iter().map(move |l| (l - largest) as f32)
    });
    Array2::from_shape_vec((rows.len(), width), kept.collect())
        .map_err(|e| Error::work(format!("evidence of single snapshots: {e}")))
}
