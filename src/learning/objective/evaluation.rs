//! What an evaluation of the objective gives.

use ndarray::{Array1, Array2};

/// The objective and its gradient at given activations.
#[derive(Debug, Clone, Default)]
pub struct Evaluation<T = f64> {
    /// E_prior: expected error before sensing, in metres.
    pub prior_error_m: f64,
    /// E_posterior: expected error after sensing, in metres.
    pub posterior_error_m: f64,
    /// ∂E_posterior/∂g of the truths, `[truth, feature]`.
    pub truth_gradient: Array2<T>,
    /// ∂E_posterior/∂g of the map's places, `[candidate, feature]`.
    pub map_gradient: Array2<T>,
}

impl<T> Evaluation<T> {
    /// 1 − E_posterior / E_prior (Thrun 1998, eq. 46).
    pub fn error_reduction(&self) -> f64 {
        1.0 - self.posterior_error_m / self.prior_error_m
    }
}

/// Equal weights P(ξ*) for `truths` places.
pub fn equal_weights(truths: usize) -> Array1<f64> {
    Array1::from_elem(truths, 1.0 / truths.max(1) as f64)
}
