//! The objective: the error a robot is expected to make after sensing, and its gradient (Thrun 1998, eq. 36–43).
//!
//! With P[k, f] = Π_i P(f_i | s_k) (eq. 33) the outcomes at the truths, M the same at the map's places, the prior as the
//! matrices Bel and A = e ∘ Bel, and w the weights P(ξ*) of the truths,
//!
//! ```text
//! N = A·M     D = Bel·M     ē = N/D     E = Σ_k* w_k* Σ_f P[k*, f] · ē[k*, f]                       (eq. 36, 37, 42)
//! ∂E/∂P = w ∘ ē     ∂E/∂M = Aᵀ·U − Belᵀ·(U ∘ ē),  U = w ∘ P/D                                       (eq. 40, 43)
//! ∂E/∂g_i = Σ_f ∂E/∂P[f] · (2 δ(f_i, 1) − 1) · Π_{j≠i} P(f_j | s)                                   (eq. 40, 43)
//! ```
//!
//! D is P(f) under the prior, ē[k*, f] the error expected at k* after sensing f. In Thrun's objective (eq. 42) the map is
//! the training snapshots themselves, M = P. The printed gradient lacks Bel_prior in both denominators; this is the
//! derivative of eq. 42 itself. [`mod@reference`] has these lines as dense matrices.
//!
//! A prior belief is uniform over the places it admits, so its height cancels in N/D and in U: sums over those places do
//! for products with A and Bel. `objective/passes.rs` has the three passes that [`Objective::evaluate`] makes.

mod activations;
mod evaluation;
mod kernels;
mod outcomes;
mod passes;
pub mod reference;

use super::{
    lanes::{LANES, Lanes, Real, at_least},
    prior_operator::PriorOperator,
};
use crate::error::Result;
pub use evaluation::{Evaluation, equal_weights};
use ndarray::{ArrayView1, ArrayView2};
pub use passes::Objective;

/// Most features that 2^n outcomes allow.
pub const MAX_FEATURES: usize = 12;

/// D counts as at least this, for saturated features: an outcome this rare adds at most this times the extent to the error.
const SMALLEST_PROBABILITY: f64 = 1e-12;

/// [`Objective::evaluate`] once. Two places d apart, one feature that answers .9 and .2, a global prior: E = 25/99·d.
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
/// As [`Objective::evaluate`].
pub fn evaluate(
    prior: &PriorOperator,
    truth: ArrayView2<f64>,
    map: ArrayView2<f64>,
    weight: ArrayView1<f64>,
) -> Result<Evaluation> {
    Objective::new()
        .evaluate(prior, truth, map, weight)
        .cloned()
}

impl<T: Real> Objective<T> {
    /// E_posterior and its gradient, for activations g of the truths `[truth, feature]` and of the map's places
    /// `[candidate, feature]`, and weights P(ξ*) of the truths, which sum to 1. The bits of the result depend neither on
    /// the number of threads nor on what was evaluated before.
    ///
    /// # Errors
    /// Where there is no feature or more than [`MAX_FEATURES`], or numbers of places, features and weights do not fit.
    pub fn evaluate(
        &mut self,
        prior: &PriorOperator,
        truth: ArrayView2<T>,
        map: ArrayView2<T>,
        weight: ArrayView1<f64>,
    ) -> Result<&Evaluation<T>> {
        activations::check(prior, truth, map, weight)?;
        rayon::scope(|_| {
            self.map_outcomes(prior, map); // M
            self.expected_error(prior, truth, weight); // N, D, ē, E, ∂E/∂P, U; ∂E/∂g of the truths
            self.map_gradient(prior, map); // ∂E/∂M; ∂E/∂g of the map
        });
        self.evaluation.prior_error_m = prior_error_m(prior, weight);
        Ok(&self.evaluation)
    }
}

/// E_prior = Σ_k* w_k* Σ_k A[k*, k] (eq. 21).
fn prior_error_m(prior: &PriorOperator, weight: ArrayView1<f64>) -> f64 {
    let errors_m = prior.prior_error_m().iter();
    errors_m.zip(weight).map(|(e, w)| e * w).sum()
}

/// One truth ξ*.
struct Truth {
    /// w.
    weight: f64,
    /// Σ_k A[k*, k].
    prior_error_m: f64,
    /// The least that counts as D, whose sums lack the belief's height.
    smallest_d: f64,
}

impl Truth {
    /// For sixteen outcomes f, ∂E/∂P, U and U ∘ ē; and adds to E. Both E and ∂E/∂P are counted from the prior error, so that
    /// the small difference is rounded, and not what it is the difference of; as Σ_f P = 1, ∂E/∂g is the same.
    #[inline(always)]
    fn expected_error<T: Real>(
        &self,
        [n, d]: [&Lanes<f64>; 2],
        p: &Lanes<T>,
        error_m: &mut Lanes<f64>,
    ) -> (Lanes<T>, Lanes<T>, Lanes<f64>) {
        let [mut slope, mut u, mut expected_m] = [*n; 3];
        for l in 0..LANES {
            let inverse = 1.0 / at_least(d[l], self.smallest_d);
            let above_m = (n[l] - self.prior_error_m * d[l]) * inverse; // N/D − prior error
            expected_m[l] = at_least(self.prior_error_m + above_m, 0.0); // ē = N/D
            slope[l] = self.weight * above_m; // ∂E/∂P = w ∘ ē
            u[l] = self.weight * p[l].to_f64() * inverse; // U = w ∘ P/D
            error_m[l] += p[l].to_f64() * slope[l]; // E = Σ w P ē (eq. 42)
        }
        let (slope, u) = (T::rounded(&slope), T::rounded(&u));
        // Where one place alone shows f, e − ē vanishes there: U∘ē must be that of the U that was rounded.
        for l in 0..LANES {
            expected_m[l] *= u[l].to_f64();
        }
        (slope, u, expected_m)
    }
}

/// ∂E/∂M = Aᵀ·U − Belᵀ·(U ∘ ē) of one place of the map, for sixteen outcomes.
#[inline(always)]
fn map_slope<T: Real>(a_u: &Lanes<f64>, bel_u_e: &Lanes<f64>) -> Lanes<T> {
    let mut slope = *a_u;
    for l in 0..LANES {
        slope[l] -= bel_u_e[l];
    }
    T::rounded(&slope)
}

#[cfg(test)]
mod reference_tests;
#[cfg(test)]
mod tests;
