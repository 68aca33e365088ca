//! The objective: the error a robot is expected to make after sensing, and its gradient (Thrun 1998, eq. 36–43).
//!
//! With P[k, f] = Π_i P(f_i | s_k) the truth's outcomes, M the same of the map's places, and the prior as the operators
//! Bel and A = e ∘ Bel,
//!
//! ```text
//! N = A·M      D = Bel·M      E = Σ_k* w_k* Σ_f P[k*, f] · N[k*, f] / D[k*, f]
//! ∂E/∂P = w ∘ N/D             ∂E/∂M = Aᵀ(w ∘ P/D) − Belᵀ(w ∘ P ∘ N/D²)
//! ```
//!
//! In Thrun's objective (eq. 42) the map is the training snapshots themselves, M = P. The printed gradient (eq. 43)
//! lacks Bel_prior in both denominators; this is the derivative of eq. 42 itself.

use super::prior_operator::PriorOperator;
use crate::error::{Error, Result};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, Axis, Zip};
use rayon::prelude::*;

/// Most features that 2^n outcomes allow.
pub const MOST_FEATURES: usize = 12;

/// P(f) under a prior counts as at least this. Saturated features would give 0/0, and running sums know a P(f) only
/// to about 1e-16 of the whole; an outcome this rare adds at most its probability times the extent to the error.
const SMALLEST_PROBABILITY: f64 = 1e-12;

/// The objective at given activations, and which way is up.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// E_prior: expected error before sensing, in metres.
    pub prior_error_m: f64,
    /// E_posterior: expected error after sensing, in metres.
    pub posterior_error_m: f64,
    /// ∂E_posterior/∂g of the truths, `[truth, feature]`.
    pub truth_gradient: Array2<f64>,
    /// ∂E_posterior/∂g of the map's places, `[candidate, feature]`.
    pub map_gradient: Array2<f64>,
}

impl Evaluation {
    /// 1 − E_posterior / E_prior (Thrun 1998, eq. 46).
    pub fn error_reduction(&self) -> f64 {
        1.0 - self.posterior_error_m / self.prior_error_m
    }
}

/// E_posterior and its gradient, for activations g of the truths `[truth, feature]` and of the map's places
/// `[candidate, feature]`, and weights P(ξ*) of the truths, which sum to 1.
///
/// The witness: two places d apart, one feature that answers .9 and .2, no idea where: E = 25/99·d.
///
/// ```
/// use ballmark::belief::{Places, Uncertainty};
/// use ballmark::learning::{objective::evaluate, prior_operator::PriorOperator};
/// use ndarray::array;
/// let places = Places::Route(vec![0.0, 99.0]);
/// let prior = PriorOperator::new(Uncertainty::Global, &places, &places);
/// let g = array![[0.9], [0.2]];
/// let e = evaluate(&prior, g.view(), g.view(), array![0.5, 0.5].view())?;
/// assert!((e.posterior_error_m - 25.0).abs() < 1e-12);
/// assert!((e.prior_error_m - 49.5).abs() < 1e-12);
/// let gradient = &e.truth_gradient + &e.map_gradient; // the map is the truths themselves
/// assert!((gradient[[0, 0]] / 99.0 + 0.7570656).abs() < 1e-7 && (gradient[[1, 0]] / 99.0 - 0.6570758).abs() < 1e-7);
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where there are more than [`MOST_FEATURES`] features.
pub fn evaluate(
    prior: &PriorOperator,
    truth: ArrayView2<f64>,
    map: ArrayView2<f64>,
    weight: ArrayView1<f64>,
) -> Result<Evaluation> {
    let n = truth.ncols();
    if n > MOST_FEATURES {
        return Err(Error::work(format!(
            "{n} features have 2^{n} outcomes; the exact objective takes at most {MOST_FEATURES}"
        )));
    }
    let p = outcomes(truth); // [truth, outcome]
    let (mut numerator, mut denominator) = prior.apply(outcomes(map).view()); // N, D: [truth, outcome]
    numerator.mapv_inplace(|n| n.max(0.0));
    denominator.mapv_inplace(|d| d.max(SMALLEST_PROBABILITY));
    let error = &numerator / &denominator; // expected error at ξ* after sensing f
    let weight = weight.insert_axis(Axis(1));
    let weighted = &error * &weight; // ∂E/∂P
    let u = &(&p * &weight) / &denominator; // w ∘ P/D
    let posterior_error_m = (&p * &weighted).sum();
    let map_side = prior.apply_transposed(u.view(), (&u * &error).view()); // ∂E/∂M
    Ok(Evaluation {
        prior_error_m: (prior.prior_error_m() * &weight.remove_axis(Axis(1))).sum(),
        posterior_error_m,
        truth_gradient: to_activations(weighted.view(), truth),
        map_gradient: to_activations(map_side.view(), map),
    })
}

/// P(f | s) = Π_i P(f_i | s) for all 2^n outcomes f; bit i of the column's number is f_i (Thrun 1998, eq. 33).
pub fn outcomes(activation: ArrayView2<f64>) -> Array2<f64> {
    let (k, n) = activation.dim();
    let mut outcomes = Array2::zeros((k, 1 << n));
    Zip::from(outcomes.rows_mut())
        .and(activation.rows())
        .par_for_each(|mut p, g| {
            p[0] = 1.0;
            for (i, &g) in g.iter().enumerate() {
                // Every outcome of the features before i, once with f_i = 1 and once with f_i = 0.
                for f in 0..1 << i {
                    p[f + (1 << i)] = p[f] * g;
                    p[f] *= 1.0 - g;
                }
            }
        });
    outcomes
}

/// ∂E/∂g_i = Σ_f ∂E/∂P[f] · (±1) · Π_{j≠i} P(f_j | s): leave-one-out products, so that g = 0 and g = 1 are fine.
fn to_activations(outcome_gradient: ArrayView2<f64>, activation: ArrayView2<f64>) -> Array2<f64> {
    let mut gradient = Array2::zeros(activation.raw_dim());
    let blocks = gradient
        .axis_chunks_iter_mut(Axis(0), ROWS)
        .into_par_iter()
        .zip(outcome_gradient.axis_chunks_iter(Axis(0), ROWS))
        .zip(activation.axis_chunks_iter(Axis(0), ROWS));
    blocks.for_each(|((mut out, dp), g)| {
        let (mut open, mut difference) = (Vec::new(), Vec::new());
        for ((mut out, dp), g) in out.rows_mut().into_iter().zip(dp.rows()).zip(g.rows()) {
            // The last feature first: what comes after it is summed over already, what comes before it still is open.
            open.clear();
            open.extend(dp);
            for i in (0..g.len()).rev() {
                let (without, with) = open.split_at(1 << i);
                difference.clear();
                difference.extend(with.iter().zip(without).map(|(w, o)| w - o));
                for j in (0..i).rev() {
                    sum_out(&mut difference, j, g[j]);
                }
                out[i] = difference[0];
                sum_out(&mut open, i, g[i]);
            }
        }
    });
    gradient
}

/// Rows that a thread takes at once.
const ROWS: usize = 128;

/// Sums over f_i, the last open feature: what is left are the outcomes of those before it.
fn sum_out(open: &mut Vec<f64>, i: usize, g: f64) {
    let (without, with) = open.split_at_mut(1 << i);
    for (o, w) in without.iter_mut().zip(&*with) {
        *o = (1.0 - g) * *o + g * w;
    }
    open.truncate(1 << i);
}

/// Equal weights P(ξ*) for `truths` places.
pub fn equal_weights(truths: usize) -> Array1<f64> {
    Array1::from_elem(truths, 1.0 / truths.max(1) as f64)
}

#[cfg(test)]
mod tests;
