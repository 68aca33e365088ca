//! One snapshot, one prior: how much less error, on snapshots that training never saw.
//!
//! Truths are unseen snapshots at places that training saw; candidates are the training places; P(f|ξ) comes from
//! training snapshots only. Training error flatters; this is the number that counts.

use crate::{
    belief::{GridMap, Places, Uncertainty},
    error::Result,
    learning::{
        error_reduction::ErrorReduction,
        objective::{equal_weights, evaluate},
        prior_operator::PriorOperator,
    },
};
use ndarray::{Array2, ArrayView1, ArrayView2};
use rayon::prelude::*;

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
) -> Result<ErrorReduction> {
    let prior = PriorOperator::new(uncertainty, truths, candidates);
    let e = evaluate(
        &prior,
        answers,
        map.probability(),
        equal_weights(truths.len()).view(),
    )?;
    Ok(ErrorReduction {
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
) -> ErrorReduction {
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
    ErrorReduction {
        prior_error_m,
        posterior_error_m,
        error_reduction: 1.0 - posterior_error_m / prior_error_m,
        snapshots: truths.len(),
    }
}

/// Error reduction by features of any number, by mean field: exact where every answer is 0 or 1.
pub fn by_mean_field(
    uncertainty: Uncertainty,
    (truths, answers): (&Places, ArrayView2<f64>),
    (candidates, map): (&Places, &GridMap),
) -> ErrorReduction {
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

/// Error reduction by the raw-scan kernel of bandwidth h; `square` are the distances of the truths from the training
/// scans of the candidates, `[truth, candidate]`.
pub fn by_kernel(
    uncertainty: Uncertainty,
    truths: &Places,
    candidates: &Places,
    square: ArrayView2<f32>,
    bandwidth: f64,
) -> ErrorReduction {
    let weight = -0.5 / (bandwidth * bandwidth);
    by_likelihood(uncertainty, truths, candidates, |truth| {
        square
            .row(truth)
            .iter()
            .map(|&d| f64::from(d) * weight)
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        belief::{Belief, Evidence, bayes},
        geometry::Pose,
        localiser::sensor_model::least_mean_squares,
        seed::Seed,
    };
    use rand::RngExt;
    use std::sync::Arc;

    fn cases() -> Vec<(Places, Uncertainty, Array2<f64>)> {
        let mut random = Seed(6).stream("filter and objective");
        let route = Places::Route((0..40).map(|_| 20.0 * random.random::<f64>()).collect());
        let mut pose = || {
            Pose::new(
                9.0 * random.random::<f64>(),
                5.0 * random.random::<f64>(),
                6.0 * random.random::<f64>(),
            )
        };
        let plane = Places::Plane((0..40).map(|_| pose()).collect());
        let mut cases = Vec::new();
        for places in [route, plane] {
            for prior in ["2m", "5m,any", "global"] {
                for n in [1, 3] {
                    let g = Array2::from_shape_simple_fn((40, n), || random.random::<f64>());
                    cases.push((places.clone(), prior.parse().unwrap(), g));
                }
            }
        }
        cases
    }

    /// One correction by Jeffrey's rule, averaged over all truths, is what training minimises: the filter and the
    /// objective are two pages of one book.
    #[test]
    fn a_step_of_the_filter_makes_the_error_of_the_objective() {
        for (places, uncertainty, g) in cases() {
            let prior = PriorOperator::new(uncertainty, &places, &places);
            let objective = evaluate(&prior, g.view(), g.view(), equal_weights(40).view()).unwrap();
            let cells = Arc::new(places.clone());
            let map = GridMap::new(g.clone()).unwrap();
            let (mut before, mut after) = (0.0, 0.0);
            for truth in 0..40 {
                let mut belief = Belief::within(&cells, &places, truth, &uncertainty).unwrap();
                before += belief.expected_error_m(&places, truth) / 40.0;
                let mut stream = Seed(0).stream("not drawn from");
                let said = Evidence::Jeffrey
                    .log_likelihood(&g.row(truth).to_vec(), &map, &belief, &mut stream)
                    .unwrap();
                bayes::correct(&mut belief, &said).unwrap();
                after += belief.expected_error_m(&places, truth) / 40.0;
            }
            assert!(
                (before - objective.prior_error_m).abs() < 1e-12 * (1.0 + before),
                "{uncertainty}"
            );
            assert!(
                (after - objective.posterior_error_m).abs() < 1e-12 * (1.0 + after),
                "{uncertainty}"
            );
        }
    }

    #[test]
    fn certain_bits_are_judged_alike_by_both_ways() {
        // Exact sums over outcomes and mean field agree where every answer is 0 or 1, as far as the floors reach.
        for (places, uncertainty, g) in cases() {
            let bits = g.mapv(|g| if g > 0.5 { 1.0 } else { 0.0 });
            let map = GridMap::new(g.mapv(|g| 0.01 + 0.98 * g)).unwrap();
            let exact = by_features(uncertainty, (&places, bits.view()), (&places, &map)).unwrap();
            let mean_field = by_mean_field(uncertainty, (&places, bits.view()), (&places, &map));
            assert!(
                (exact.posterior_error_m - mean_field.posterior_error_m).abs() < 1e-9,
                "{exact:?} {mean_field:?}"
            );
        }
    }

    #[test]
    fn the_kernel_finds_what_looks_alike() {
        let places = Places::Route((0..20).map(f64::from).collect());
        let scans = Array2::from_shape_fn((20, 3), |(k, i)| (k * (i + 2)) as f32);
        let square = least_mean_squares(scans.view(), std::slice::from_ref(&scans));
        let by = |h: f64| by_kernel(Uncertainty::Global, &places, &places, square.view(), h);
        let (sharp, blunt) = (by(0.1), by(1e6));
        assert!(sharp.error_reduction > 0.999, "{sharp:?}");
        assert!(blunt.error_reduction.abs() < 1e-6, "{blunt:?}");
    }
}
