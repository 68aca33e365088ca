//! Networks on a shared trunk, forward and backward on plain arrays: the same numbers as on tensors, to rounding, in a
//! fraction of the time.
//!
//! What tensors spend beside the numbers is a tape, fresh memory for each intermediate result, and gathering the windows of
//! convolutions anew on the way back. Here snapshots are dealt to shares by their number alone, each with memory of its own
//! that is kept from step to step; shares are worked on side by side, and what they add up to is added in their order. So the
//! bits are the same for any number of threads.

mod share;

use super::{Layer, Weights};
use crate::error::{Error, Result};
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};
use rayon::prelude::*;
use share::Share;

/// Snapshots of a share: small enough that two cores have work, large enough for matrices to be worth it.
const SHARE: usize = 64;

/// Forward and backward of networks with a trunk, with memory kept from step to step.
///
/// ```
/// use ballmark::{detector::net::{Layered, NetConfig, Weights}, seed::Seed};
/// use ndarray::{Array2, array};
///
/// let weights = Weights::random(&NetConfig::default(), 3, 2, &mut Seed(1).stream("doc"));
/// let inputs = array![[0.5, -1.0, 2.0], [0.0, 1.0, 0.0]]; // [snapshot, input]
/// assert!(Layered::fits(&weights));
/// let mut layered = Layered::default();
/// let mut activation = Array2::zeros((2, 2)); // [snapshot, feature]
/// layered.forward(&weights, inputs.view(), activation.view_mut())?;
/// assert!(activation.iter().all(|g| (0.0..1.0).contains(g)));
///
/// let slope = Array2::ones((2, 2)); // ∂E/∂g of E = Σ g
/// let mut gradient = weights.clone();
/// layered.backward(&weights, slope.view(), &mut gradient)?;
/// let output_bias = &gradient.layers[2].bias; // Σ over snapshots of g (1 − g)
/// let expected = activation.column(0).fold(0.0, |sum, g| sum + g * (1.0 - g));
/// assert!((output_bias[[0, 0]] - expected).abs() < 1e-6);
/// # ballmark::Result::Ok(())
/// ```
#[derive(Debug, Default)]
pub struct Layered {
    shares: Vec<Share>,
}

impl Layered {
    /// Whether networks of this shape are trained here: all layers but the last shared, and one unit a feature on them.
    pub fn fits(weights: &Weights) -> bool {
        weights.trunk > 0 && weights.layers.len() == weights.trunk + 1
    }

    /// g_i(s) of every snapshot: `[snapshot, input]` → `[snapshot, feature]`. What [`backward`](Self::backward) needs besides
    /// is kept.
    ///
    /// # Errors
    /// Where an array's shape is not that of the networks.
    pub fn forward(
        &mut self,
        weights: &Weights,
        inputs: ArrayView2<f32>,
        mut out: ArrayViewMut2<f32>,
    ) -> Result<()> {
        if !Self::fits(weights) {
            return Err(Error::work(
                "layered networks: expected a trunk, and one layer of one unit a feature on it",
            ));
        }
        same("inputs", inputs.dim(), (inputs.nrows(), weights.inputs()))?;
        same(
            "activations",
            out.dim(),
            (inputs.nrows(), weights.features()),
        )?;
        self.shares
            .resize_with(inputs.nrows().div_ceil(SHARE), Share::default);
        let matrices: Vec<Array2<f32>> = weights.layers.iter().map(matrix).collect();
        let outs = out.axis_chunks_iter_mut(Axis(0), SHARE);
        let inputs = inputs.axis_chunks_iter(Axis(0), SHARE);
        let work: Vec<_> = self.shares.iter_mut().zip(inputs).zip(outs).collect();
        work.into_par_iter().for_each(|((share, inputs), out)| {
            share.forward(weights, &matrices, inputs, out);
        });
        Ok(())
    }

    /// ∂E/∂weights and ∂E/∂biases at the last forward, of an objective with this slope ∂E/∂g, `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where an array's shape is not that of the networks or of the last forward.
    pub fn backward(
        &mut self,
        weights: &Weights,
        slope: ArrayView2<f32>,
        gradient: &mut Weights,
    ) -> Result<()> {
        let snapshots: usize = self.shares.iter().map(Share::snapshots).sum();
        same("slopes", slope.dim(), (snapshots, weights.features()))?;
        let matrices: Vec<Array2<f32>> = weights.layers.iter().map(matrix).collect();
        let slopes = slope.axis_chunks_iter(Axis(0), SHARE);
        let work: Vec<_> = self.shares.iter_mut().zip(slopes).collect();
        work.into_par_iter()
            .for_each(|(share, slope)| share.backward(weights, &matrices, slope));
        for (l, layer) in gradient.layers.iter_mut().enumerate() {
            layer.weight.fill(0.0);
            layer.bias.fill(0.0);
            for share in &self.shares {
                share.add_to(l, layer);
            }
        }
        Ok(())
    }
}

/// A layer's weights as one matrix, `[input, output]`; of the last layer all features' side by side.
fn matrix(layer: &Layer) -> Array2<f32> {
    let (networks, inputs, outputs) = layer.weight.dim();
    Array2::from_shape_fn((inputs, networks * outputs), |(input, column)| {
        layer.weight[[column / outputs, input, column % outputs]]
    })
}

fn same(what: &str, found: (usize, usize), expected: (usize, usize)) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(Error::work(format!(
        "layered networks: {what} of shape {found:?}; expected {expected:?}"
    )))
}

#[cfg(test)]
mod tests;
