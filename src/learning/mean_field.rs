//! The wide objective: the expected error after sensing where n features are too many for 2^n outcomes.
//!
//! A robot at ξ* sends its n probabilities g(s*) themselves. Against the map m of K candidates they make the mean-field
//! log-likelihood, and with a prior that is uniform over the candidates it admits, a posterior and its expected error:
//!
//! ```text
//! L[k*, k] = Σ_j g_j(s*)·ln m_j(ξ_k) + (1 − g_j(s*))·ln(1 − m_j(ξ_k))
//! q[k*, ·] = softmax of L[k*, ·] over the admitted candidates        E = Σ_k* w_k* Σ_k q[k*, k]·e(ξ*, ξ_k)
//! R[k*, k] = ∂E/∂L = w_k*·q[k*, k]·(e(ξ*, ξ_k) − E_k*)
//! ∂E/∂g = R·(ln m − ln(1 − m))      ∂E/∂m = T/m − (r − T)/(1 − m),  T = Rᵀ·g,  r = Rᵀ·1
//! ```
//!
//! It is what [mean-field evidence](crate::belief::Evidence::MeanField) does to a uniform belief, and equals the exact
//! objective (Thrun 1998, eq. 42) where every g is 0 or 1. Cost: truths × candidates × n, no more for 256 features than
//! 2^n would ask for eight.

use super::objective::Evaluation;
use crate::belief::{Places, Uncertainty};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, Axis};
use rayon::prelude::*;
use std::borrow::Cow;

/// Most features of a wide code: 32 bytes a place when rounded.
pub const MOST_FEATURES: usize = 256;

/// Maps are kept this far from 0 and 1, whatever their own floor: f32 knows no probability nearer to 1.
const SMALLEST_PROBABILITY: f32 = 1e-6;

/// Rows that a thread takes at once.
const ROWS: usize = 16;

/// Who might be where: truths, each with a prior uncertainty of its own, and the candidates they may be mistaken for.
pub struct Priors {
    uncertainty: Vec<Uncertainty>,
    truths: Places,
    candidates: Places,
    /// e of every pair, `[truth, candidate]`, where there are not too many to keep: a step's.
    kept: Option<Array2<f32>>,
    prior_error_m: Array1<f64>,
    sizes: Vec<usize>,
}

/// Most pairs whose error is kept: 64 MiB.
const MOST_KEPT: usize = 1 << 24;

/// The error of a candidate that the prior does not admit.
const NOT_ADMITTED: f32 = f32::INFINITY;

impl Priors {
    /// One uncertainty a truth.
    ///
    /// # Panics
    /// Where there are not as many uncertainties as truths.
    pub fn new(uncertainty: Vec<Uncertainty>, truths: Places, candidates: Places) -> Self {
        assert_eq!(uncertainty.len(), truths.len(), "one uncertainty a truth");
        let (rows, columns) = (truths.len(), candidates.len());
        let mut priors = Self {
            uncertainty,
            truths,
            candidates,
            kept: None,
            prior_error_m: Array1::zeros(rows),
            sizes: vec![0; rows],
        };
        if rows.saturating_mul(columns) <= MOST_KEPT {
            let mut kept = Array2::zeros((rows, columns));
            kept.axis_iter_mut(Axis(0))
                .into_par_iter()
                .enumerate()
                .for_each(|(t, mut row)| row.assign(&ArrayView1::from(&priors.errors_m(t))));
            priors.kept = Some(kept);
        }
        let told: Vec<(f64, usize)> = (0..rows)
            .into_par_iter()
            .map(|t| {
                let errors = priors.errors_m(t);
                let admitted = errors.iter().filter(|&&e| e != NOT_ADMITTED);
                let (sum, size) =
                    admitted.fold((0.0, 0), |(sum, n), &e| (sum + f64::from(e), n + 1));
                (sum / size.max(1) as f64, size)
            })
            .collect();
        priors.prior_error_m = told.iter().map(|t| t.0).collect();
        priors.sizes = told.into_iter().map(|t| t.1).collect();
        priors
    }

    /// e(ξ*, ξ) of one truth to every candidate in metres; [`NOT_ADMITTED`] outside its prior.
    fn errors_m(&self, truth: usize) -> Cow<'_, [f32]> {
        if let Some(kept) = self
            .kept
            .as_ref()
            .and_then(|kept| kept.row(truth).to_slice())
        {
            return Cow::Borrowed(kept);
        }
        let (uncertainty, truths) = (self.uncertainty[truth], &self.truths);
        let error_m = |candidate| {
            let distance_m = truths.distance_m(truth, &self.candidates, candidate);
            let turn_rad = || truths.turn_rad(truth, &self.candidates, candidate);
            match uncertainty.admits_at(distance_m, turn_rad) {
                true => distance_m as f32,
                false => NOT_ADMITTED,
            }
        };
        Cow::Owned((0..self.candidates.len()).map(error_m).collect())
    }

    /// Expected error of every truth before sensing, in metres; 0 where nothing is admitted.
    pub fn prior_error_m(&self) -> ArrayView1<'_, f64> {
        self.prior_error_m.view()
    }

    /// Candidates that every truth's prior admits.
    pub fn window_sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Weights of the truths that sum to 1: those that have something to be mistaken for, in equal shares.
    pub fn equal_weights(&self) -> Array1<f64> {
        self.shares(|_| 1.0)
    }

    /// Weights that make the objective the mean of each truth's posterior error *as a share of its prior error*, times the
    /// mean prior error: so that a narrow window counts as much as a wide one.
    pub fn relative_weights(&self) -> Array1<f64> {
        self.shares(|t| 1.0 / self.prior_error_m[t])
    }

    fn shares(&self, of: impl Fn(usize) -> f64) -> Array1<f64> {
        let counts = |t: usize| self.sizes[t] > 1 && self.prior_error_m[t] > 0.0;
        let mut shares: Array1<f64> = (0..self.truths.len())
            .map(|t| if counts(t) { of(t) } else { 0.0 })
            .collect();
        let sum = shares.sum();
        if sum > 0.0 {
            shares /= sum;
        }
        shares
    }
}

/// The objective and its gradient, for activations g of the truths `[truth, feature]` and the map m at the candidates
/// `[candidate, feature]`, both probabilities, and weights of the truths that sum to 1.
///
/// ```
/// use ballmark::{belief::Places, learning::mean_field::{Priors, evaluate}};
/// use ndarray::array;
/// // Two places 10 m apart that one feature tells apart for certain.
/// let places = Places::Route(vec![0.0, 10.0]);
/// let priors = Priors::new(vec!["global".parse()?; 2], places.clone(), places);
/// let e = evaluate(&priors, array![[1.0], [0.0]].view(), array![[0.99], [0.01]].view(), priors.equal_weights().view());
/// assert!((e.prior_error_m - 5.0).abs() < 1e-9 && (e.posterior_error_m - 0.1).abs() < 1e-5);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn evaluate(
    priors: &Priors,
    truth: ArrayView2<f32>,
    map: ArrayView2<f32>,
    weight: ArrayView1<f64>,
) -> Evaluation {
    let m = map.mapv(|m| m.clamp(SMALLEST_PROBABILITY, 1.0 - SMALLEST_PROBABILITY));
    let off = m.mapv(|m| (-m).ln_1p()); // ln(1 − m), [candidate, feature]
    let log_odds = m.mapv(f32::ln) - &off;
    let none = off.sum_axis(Axis(1)); // ln P(all features 0)
    let mut slope = Array2::<f32>::zeros((truth.nrows(), map.nrows())); // R: [truth, candidate]
    let mut truth_gradient = Array2::<f64>::zeros(truth.raw_dim());
    let mut error_m = vec![0.0; truth.nrows()];
    slope
        .axis_chunks_iter_mut(Axis(0), ROWS)
        .into_par_iter()
        .zip(truth_gradient.axis_chunks_iter_mut(Axis(0), ROWS))
        .zip(error_m.par_chunks_mut(ROWS))
        .enumerate()
        .for_each(|(block, ((mut slope, mut gradient), error_m))| {
            let from = block * ROWS;
            let rows = (from..from + error_m.len()).into();
            slope.assign(&truth.slice_axis(Axis(0), rows).dot(&log_odds.t()));
            slope += &none;
            for (row, (mut slope, error_m)) in slope.rows_mut().into_iter().zip(error_m).enumerate()
            {
                let t = from + row;
                *error_m = descend(
                    &priors.errors_m(t),
                    weight[t],
                    slope.as_slice_mut().unwrap_or_default(),
                );
            }
            gradient.assign(&slope.dot(&log_odds).mapv(f64::from));
        });
    let mut map_gradient = Array2::<f64>::zeros(map.raw_dim());
    map_gradient
        .axis_chunks_iter_mut(Axis(0), ROWS)
        .into_par_iter()
        .enumerate()
        .for_each(|(block, mut gradient)| {
            let columns = (block * ROWS..block * ROWS + gradient.nrows()).into();
            let slope = slope.slice_axis(Axis(1), columns);
            let on = slope.t().dot(&truth); // T
            let all = slope.sum_axis(Axis(0)); // r
            for (row, mut gradient) in gradient.rows_mut().into_iter().enumerate() {
                let m = m.row(block * ROWS + row);
                for ((out, &m), &on) in gradient.iter_mut().zip(&m).zip(on.row(row)) {
                    *out = f64::from(on / m - (all[row] - on) / (1.0 - m));
                }
            }
        });
    let weighted = |errors: &mut dyn Iterator<Item = f64>| -> f64 {
        errors.zip(&weight).map(|(e, w)| e * w).sum()
    };
    Evaluation {
        prior_error_m: weighted(&mut priors.prior_error_m.iter().copied()),
        posterior_error_m: weighted(&mut error_m.into_iter()),
        truth_gradient,
        map_gradient,
    }
}

/// One truth: from the row L to the row R, in place; returns its expected error in metres.
fn descend(errors_m: &[f32], weight: f64, row: &mut [f32]) -> f64 {
    // Highest among the admitted only: else all of a narrow window may underflow.
    let admitted = row
        .iter()
        .zip(errors_m)
        .filter(|(_, e)| **e != NOT_ADMITTED);
    let highest = admitted.fold(f32::NEG_INFINITY, |highest, (l, _)| highest.max(*l));
    let (mut sum, mut error_sum) = (0.0, 0.0);
    for (l, &error_m) in row.iter_mut().zip(errors_m) {
        if error_m == NOT_ADMITTED {
            *l = 0.0;
            continue;
        }
        *l = (*l - highest).exp();
        sum += f64::from(*l);
        error_sum += f64::from(*l) * f64::from(error_m);
    }
    let expected = if sum > 0.0 { error_sum / sum } else { 0.0 };
    for (q, &error_m) in row.iter_mut().zip(errors_m) {
        if *q > 0.0 {
            *q = (weight * f64::from(*q) / sum * (f64::from(error_m) - expected)) as f32;
        }
    }
    expected
}

#[cfg(test)]
mod tests;
