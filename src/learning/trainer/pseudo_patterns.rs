//! Several steps on one evaluation of the objective (Thrun 1998, 4.4.2 item 3).
//!
//! From the outputs g and the objective's gradient there, every snapshot gets a target g − ∂E/∂g (eq. 45, whose print lacks
//! the ∂ signs), and the networks are fitted to these by backpropagation on the squared error ½ Σ (g − target)². At the
//! outputs they were made from, this error has the objective's own gradient: the first step of a series is the plain one
//! (eq. 44), of the same length, and a series of one step is plain descent to the bit.

use crate::{detector::net::values, error::Result};
use burn::tensor::Tensor;

/// Targets for the outputs of the networks that learn. Kept in two parts, since ∂E/∂g can be far smaller than g.
#[derive(Debug, Clone)]
pub struct PseudoPatterns {
    /// Outputs g at the evaluation, `[snapshot, learner]`.
    pub output: Tensor<2>,
    /// ∂E/∂g there, `[snapshot, learner]`.
    pub gradient: Tensor<2>,
}

impl PseudoPatterns {
    /// Outputs less their targets: the gradient of the squared error. `[snapshot, learner]`.
    pub fn residual(&self, output: Tensor<2>) -> Tensor<2> {
        (output - self.output.clone()) + self.gradient.clone()
    }

    /// ½ Σ (g − target)² at some outputs.
    ///
    /// # Errors
    /// Where the device does not give its data back.
    pub fn error(&self, output: Tensor<2>) -> Result<f64> {
        let residual = values(self.residual(output))?;
        let squares = residual.iter().map(|&r| f64::from(r).powi(2));
        Ok(0.5 * squares.sum::<f64>())
    }
}
