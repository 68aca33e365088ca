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
//! Besides it the cross entropy between q and a Gaussian about ξ* may be descended ([`Priors::with_targets`]): R gains
//! w_k*·c·(q − t), t the Gaussian over the admitted candidates and c metres a nat.
//!
//! It is what [mean-field evidence](crate::belief::Evidence::MeanField) does to a uniform belief, and equals the exact
//! objective (Thrun 1998, eq. 42) where every g is 0 or 1. Cost: truths × candidates × n, no more for 256 features than
//! 2^n would cost for eight.

use super::objective::Evaluation;
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, ArrayViewMut2, Axis};
use priors::NOT_ADMITTED;
use rayon::prelude::*;

mod priors;

pub use priors::Priors;

/// Most features of a wide code: 32 bytes a place when rounded.
pub const MAX_FEATURES: usize = 256;

/// Maps are kept this far from 0 and 1, whatever their own floor: f32 knows no probability nearer to 1.
const SMALLEST_PROBABILITY: f32 = 1e-6;

/// Rows that a thread takes at once.
const ROWS: usize = 16;

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
) -> Evaluation<f32> {
    let map = LogMap::new(map);
    let mut slope = Array2::<f32>::zeros((truth.nrows(), map.m.nrows())); // R: [truth, candidate]
    let mut truth_gradient = Array2::<f32>::zeros(truth.raw_dim());
    let mut error_m = vec![0.0; truth.nrows()];
    slope
        .axis_chunks_iter_mut(Axis(0), ROWS)
        .into_par_iter()
        .zip(truth_gradient.axis_chunks_iter_mut(Axis(0), ROWS))
        .zip(error_m.par_chunks_mut(ROWS))
        .enumerate()
        .for_each(|(block, ((slope, mut gradient), error_m))| {
            let slope = map.expected_errors(priors, truth, weight, block * ROWS, slope, error_m);
            gradient.assign(&slope.dot(&map.log_odds));
        });
    let mut map_gradient = Array2::<f32>::zeros(map.m.raw_dim());
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
                let m = map.m.row(block * ROWS + row);
                for ((out, &m), &on) in gradient.iter_mut().zip(&m).zip(on.row(row)) {
                    *out = on / m - (all[row] - on) / (1.0 - m);
                }
            }
        });
    Evaluation {
        prior_error_m: weighted(priors.prior_error_m(), weight),
        posterior_error_m: weighted(ArrayView1::from(&error_m), weight),
        truth_gradient,
        map_gradient,
    }
}

/// The objective alone: no row of candidates outlives its block, however many there are.
pub fn error_m(
    priors: &Priors,
    truth: ArrayView2<f32>,
    map: ArrayView2<f32>,
    weight: ArrayView1<f64>,
) -> f64 {
    let map = LogMap::new(map);
    let mut error_m = vec![0.0; truth.nrows()];
    let blocks = error_m.par_chunks_mut(ROWS).enumerate();
    blocks.for_each(|(block, error_m)| {
        let mut slope = Array2::zeros((error_m.len(), map.m.nrows()));
        map.expected_errors(
            priors,
            truth,
            weight,
            block * ROWS,
            slope.view_mut(),
            error_m,
        );
    });
    weighted(ArrayView1::from(&error_m), weight)
}

fn weighted(error_m: ArrayView1<f64>, weight: ArrayView1<f64>) -> f64 {
    error_m.iter().zip(weight).map(|(e, w)| e * w).sum()
}

/// The logarithms of a map that the log-likelihood needs.
struct LogMap {
    /// m, kept off 0 and 1: `[candidate, feature]`.
    m: Array2<f32>,
    /// ln m − ln(1 − m).
    log_odds: Array2<f32>,
    /// ln P(all features 0), `[candidate]`.
    none: Array1<f32>,
}

impl LogMap {
    fn new(map: ArrayView2<f32>) -> Self {
        let m = map.mapv(|m| m.clamp(SMALLEST_PROBABILITY, 1.0 - SMALLEST_PROBABILITY));
        let off = m.mapv(|m| (-m).ln_1p());
        Self {
            log_odds: m.mapv(f32::ln) - &off,
            none: off.sum_axis(Axis(1)),
            m,
        }
    }

    /// A block of truths, counted from `from`: fills their rows of R and their expected errors.
    fn expected_errors<'a>(
        &self,
        priors: &Priors,
        truth: ArrayView2<f32>,
        weight: ArrayView1<f64>,
        from: usize,
        mut slope: ArrayViewMut2<'a, f32>,
        error_m: &mut [f64],
    ) -> ArrayViewMut2<'a, f32> {
        let rows = (from..from + error_m.len()).into();
        slope.assign(&truth.slice_axis(Axis(0), rows).dot(&self.log_odds.t()));
        slope += &self.none;
        for (row, (mut slope, error_m)) in slope.rows_mut().into_iter().zip(error_m).enumerate() {
            let row = from + row;
            // A row of an array in standard layout is a slice.
            let slope = slope.as_slice_mut().unwrap_or_default();
            *error_m = expected_error(
                &priors.errors_m(row),
                weight[row],
                priors.target(row),
                slope,
            );
        }
        slope
    }
}

/// One truth: from the row L to the row R, in place; returns its expected error in metres.
fn expected_error(
    errors_m: &[f32],
    weight: f64,
    target: Option<(ArrayView1<f32>, f64)>,
    row: &mut [f32],
) -> f64 {
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
    match target {
        None => {
            for (q, &error_m) in row.iter_mut().zip(errors_m) {
                if *q > 0.0 {
                    *q = (weight * f64::from(*q) / sum * (f64::from(error_m) - expected)) as f32;
                }
            }
        }
        // The cross entropy −Σ t ln q has the slope q − t, where the prior admits more than one.
        Some((target, counts_m)) => {
            for ((q, &error_m), &t) in row.iter_mut().zip(errors_m).zip(target) {
                if error_m != NOT_ADMITTED {
                    let share = f64::from(*q) / sum;
                    let slope_m =
                        share * (f64::from(error_m) - expected) + counts_m * (share - f64::from(t));
                    *q = (weight * slope_m) as f32;
                }
            }
        }
    }
    expected
}

#[cfg(test)]
mod tests;
