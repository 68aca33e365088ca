//! One snapshot, one prior: how much less error, on snapshots that training never saw.
//!
//! Truths are unseen snapshots at places that training saw; candidates are the training places; P(f|ξ) comes from
//! training snapshots only. Training error flatters; this is the number that counts.

use crate::{
    belief::{GridMap, Places, Uncertainty},
    error::Result,
    learning::{
        objective::{equal_weights, evaluate},
        prior_operator::PriorOperator,
        trainer::Score,
    },
    localiser::kernel::mean_squares,
};
use ndarray::{Array2, ArrayView1, ArrayView2};
use rayon::prelude::*;

/// Bandwidths h that the kernel is tuned over, in units of the inputs' deviation.
const BANDWIDTHS: [f64; 10] = [0.01, 0.02, 0.04, 0.08, 0.12, 0.16, 0.24, 0.32, 0.64, 1.28];

/// Those of some truths whose prior admits at least two candidates: the others have no error to reduce.
pub fn counted(
    uncertainty: Uncertainty,
    all: &Places,
    truths: &[usize],
    candidates: &Places,
) -> Vec<usize> {
    let sizes = PriorOperator::new(uncertainty, &all.select(truths), candidates).window_sizes();
    truths
        .iter()
        .copied()
        .zip(sizes)
        .filter(|(_, size)| *size > 1)
        .map(|(k, _)| k)
        .collect()
}

/// Error reduction by stochastic features, exactly: the expectation over all outcomes f (Thrun 1998, eq. 36).
///
/// `answers` are P(f_i = 1 | s) of the truths `[truth, feature]`, `map` is P(f_i = 1 | ξ) of the candidates.
///
/// # Errors
/// Where there are too many features for 2^n outcomes.
pub fn by_features(
    uncertainty: Uncertainty,
    (truths, answers): (&Places, ArrayView2<f64>),
    (candidates, map): (&Places, &GridMap),
) -> Result<Score> {
    let prior = PriorOperator::new(uncertainty, truths, candidates);
    let e = evaluate(
        &prior,
        answers,
        map.probability(),
        equal_weights(truths.len()).view(),
    )?;
    Ok(Score {
        prior_error_m: e.prior_error_m,
        posterior_error_m: e.posterior_error_m,
        error_reduction: e.error_reduction(),
        snapshots: truths.len(),
    })
}

/// Error reduction by any likelihood: `log_likelihood(truth)` gives ln P(s | candidate) of every candidate.
pub fn by_likelihood(
    uncertainty: Uncertainty,
    truths: &Places,
    candidates: &Places,
    log_likelihood: impl Fn(usize) -> Vec<f64> + Sync,
) -> Score {
    let errors: Vec<(f64, f64)> = (0..truths.len())
        .into_par_iter()
        .map(|truth| {
            let admitted: Vec<usize> = (0..candidates.len())
                .filter(|&c| uncertainty.admits(truths, truth, candidates, c))
                .collect();
            let l = log_likelihood(truth);
            // The largest among the candidates, or under a narrow prior all of them might underflow.
            let best = admitted
                .iter()
                .map(|&c| l[c])
                .fold(f64::NEG_INFINITY, f64::max);
            let (mut mass, mut error, mut prior) = (0.0, 0.0, 0.0);
            for &c in &admitted {
                let (weight, e) = ((l[c] - best).exp(), truths.distance_m(truth, candidates, c));
                mass += weight;
                error += weight * e;
                prior += e;
            }
            (error / mass, prior / admitted.len() as f64)
        })
        .collect();
    let n = truths.len().max(1) as f64;
    let posterior_error_m = errors.iter().map(|e| e.0).sum::<f64>() / n;
    let prior_error_m = errors.iter().map(|e| e.1).sum::<f64>() / n;
    Score {
        prior_error_m,
        posterior_error_m,
        error_reduction: 1.0 - posterior_error_m / prior_error_m,
        snapshots: truths.len(),
    }
}

/// Error reduction by bits that are taken as certain, of any number: mean field, exact where every answer is 0 or 1.
pub fn by_bits(
    uncertainty: Uncertainty,
    (truths, answers): (&Places, ArrayView2<f64>),
    (candidates, map): (&Places, &GridMap),
) -> Score {
    let m = map.probability();
    let slope: Array2<f64> = m.mapv(|m| m.ln() - (1.0 - m).ln());
    let offset: Vec<f64> = m
        .rows()
        .into_iter()
        .map(|row| row.iter().map(|m| (1.0 - m).ln()).sum())
        .collect();
    by_likelihood(uncertainty, truths, candidates, |truth| {
        let g: ArrayView1<f64> = answers.row(truth);
        slope
            .rows()
            .into_iter()
            .zip(&offset)
            .map(|(row, offset)| row.dot(&g) + offset)
            .collect()
    })
}

/// Error reduction by the raw-scan kernel of bandwidth h.
pub fn by_kernel(
    uncertainty: Uncertainty,
    (truths, inputs): (&Places, ArrayView2<f32>),
    (candidates, training): (&Places, ArrayView2<f32>),
    bandwidth: f64,
) -> Score {
    let square = mean_squares(inputs, training);
    let weight = -0.5 / (bandwidth * bandwidth);
    by_likelihood(uncertainty, truths, candidates, |truth| {
        square
            .row(truth)
            .iter()
            .map(|&d| f64::from(d) * weight)
            .collect()
    })
}

/// The bandwidth of least error on the validation part, given as places and inputs; in the middle of the range where
/// nothing can be validated.
pub fn tuned_bandwidth(
    uncertainty: Uncertainty,
    validation: (&Places, ArrayView2<f32>),
    training: (&Places, ArrayView2<f32>),
) -> f64 {
    let mut best = (BANDWIDTHS[BANDWIDTHS.len() / 2], f64::INFINITY);
    if !validation.0.is_empty() {
        for h in BANDWIDTHS {
            let error = by_kernel(uncertainty, validation, training, h).posterior_error_m;
            if error < best.1 {
                best = (h, error);
            }
        }
    }
    best.0
}
