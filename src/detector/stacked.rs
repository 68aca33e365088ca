//! n small networks as one: forward and backward by hand, for the shapes that training is mostly about.
//!
//! Networks side by side are one network whose first layer is `[input, filter·unit]` and whose later layers are zero but
//! for a block a filter on the diagonal. Six units a filter are no work worth a matrix product of their own, so the
//! zeros are multiplied too: at 4 × (164 → 6 → 1) they are one product in fifty. In return a layer is one call of
//! `kernel::product` forward, one of `kernel::outer` for ∂E/∂weights and one of `product` for ∂E/∂inputs, all at the
//! speed of the machine's registers.
//!
//! Snapshots are cut into chunks that stay in the nearest caches, and chunks are dealt to shares, which are what
//! threads work on. Neither depends on the number of threads, and a gradient is the sum over shares in their order: so
//! the same bits come back from one thread or many. The objective between the two halves is not differentiated here: it
//! hands in ∂E/∂g (see `learning::objective`).
//!
//! The same numbers as [`Nets::forward`](super::net::Nets::forward) and Burn's automatic differentiation of it, to rounding.

mod activation;
mod kernel;
mod share;

use super::net::{Activation, Layer, Weights};
use crate::{
    error::{Error, Result},
    simd,
};
use kernel::{BLOCK, STEP};
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use rayon::prelude::*;
use share::{Backward, CHUNK, Forward, Share, Source, add};

/// About as many snapshots are a share, where that does not make more shares than there will ever be threads for: every
/// share has a gradient of its own, to be summed.
const SHARE: usize = 10 * CHUNK;
const MAX_SHARES: usize = 64;

/// Most weights, zeros between the blocks included. Wider layers no longer stay in a core's own cache, and Burn's matrix
/// product, which is cut to fit caches, does better.
const MAX_WEIGHTS: usize = 1 << 16;

/// Noise added to the inputs as they are read: x + `deviation` · bank\[(`start` + `position`) mod length\], where `position`
/// counts the inputs of all snapshots in row order.
#[derive(Debug, Clone, Copy)]
pub struct Noise<'a> {
    /// Normally distributed numbers, deviation 1; not empty.
    pub bank: &'a [f32],
    /// Where reading starts.
    pub start: usize,
    /// In units of the inputs.
    pub deviation: f32,
}

/// Forward and backward of n stacked networks, with buffers kept from step to step.
///
/// ```
/// use ballmark::{detector::{net::{NetConfig, Weights}, stacked::Stacked}, seed::Seed};
/// use ndarray::{Array2, array};
///
/// let weights = Weights::random(&NetConfig::thrun1998(), 3, 2, &mut Seed(1).stream("doc"));
/// let inputs = array![[0.5, -1.0, 2.0], [0.0, 1.0, 0.0]]; // [snapshot, input]
/// assert!(Stacked::fits(&weights));
/// let mut stacked = Stacked::new(&weights);
/// let mut activation = Array2::zeros((2, 2)); // [snapshot, feature]
/// stacked.forward(&weights, inputs.view(), None, activation.view_mut())?;
/// assert!(activation.iter().all(|g| (0.0..1.0).contains(g)));
///
/// let slope = Array2::ones((2, 2)); // ∂E/∂g of E = Σ g
/// let mut gradient = weights.clone();
/// stacked.backward(inputs.view(), None, slope.view(), &mut gradient)?;
/// let output_bias = &gradient.layers[1].bias; // Σ over snapshots of g (1 − g)
/// let expected = activation.column(0).fold(0.0, |sum, g| sum + g * (1.0 - g));
/// assert!((output_bias[[0, 0]] - expected).abs() < 1e-6);
/// # ballmark::Result::Ok(())
/// ```
#[derive(Debug)]
pub struct Stacked {
    activation: Activation,
    features: usize,
    layers: Vec<Block>,
    shares: Vec<Share>,
    snapshots: usize,
}

/// One layer of all filters as one matrix.
#[derive(Debug)]
struct Block {
    /// Inputs and outputs of one filter.
    inputs: usize,
    outputs: usize,
    /// Whether every filter has inputs of its own, as all but first layers have.
    diagonal: bool,
    /// Outputs of all filters.
    width_out: usize,
    /// Length of a row of all filters' inputs filled up with zeros, and of their outputs.
    stride_in: usize,
    stride_out: usize,
    /// `[input of any filter, stride_out]`, `[stride_out]`.
    weight: Vec<f32>,
    bias: Vec<f32>,
    /// `[output of any filter, stride_in]`; empty for the first layer, whose inputs need no gradient.
    transposed: Vec<f32>,
}

impl Block {
    fn new(layer: &Layer, first: bool, stride_in: usize) -> Self {
        let (features, inputs, outputs) = layer.weight.dim();
        let width_in = if first { inputs } else { features * inputs };
        let width_out = features * outputs;
        let stride_out = width_out.next_multiple_of(simd::lanes().max(BLOCK));
        let transposed = if first {
            0
        } else {
            width_out.next_multiple_of(STEP) * stride_in
        };
        Self {
            inputs,
            outputs,
            diagonal: !first,
            width_out,
            stride_in,
            stride_out,
            weight: vec![0.0; width_in.next_multiple_of(STEP) * stride_out],
            bias: vec![0.0; stride_out],
            transposed: vec![0.0; transposed],
        }
    }

    /// Row of a filter's input in the matrix.
    fn row(&self, filter: usize, input: usize) -> usize {
        input
            + if self.diagonal {
                filter * self.inputs
            } else {
                0
            }
    }

    /// Takes a layer's weights over.
    fn fill(&mut self, layer: &Layer) {
        for (filter, weight) in layer.weight.outer_iter().enumerate() {
            for (input, weight) in weight.outer_iter().enumerate() {
                let (row, column) = (self.row(filter, input), filter * self.outputs);
                for (output, &weight) in weight.iter().enumerate() {
                    self.weight[row * self.stride_out + column + output] = weight;
                    if self.diagonal {
                        self.transposed[(column + output) * self.stride_in + row] = weight;
                    }
                }
            }
        }
        for (to, &bias) in self.bias.iter_mut().zip(&layer.bias) {
            *to = bias;
        }
    }

    /// Writes a gradient, in the order of this block, into one in the order of a layer.
    fn unpack(&self, weight: &[f32], bias: &[f32], layer: &mut Layer) {
        for (filter, mut to) in layer.weight.outer_iter_mut().enumerate() {
            for (input, mut to) in to.outer_iter_mut().enumerate() {
                let at = self.row(filter, input) * self.stride_out + filter * self.outputs;
                for (to, &slope) in to.iter_mut().zip(&weight[at..]) {
                    *to = slope;
                }
            }
        }
        for (to, &slope) in layer.bias.iter_mut().zip(bias) {
            *to = slope;
        }
    }
}

impl Stacked {
    /// Whether networks of this shape are trained faster here than as tensors: small ones, few enough that the zeros
    /// between their blocks stay below half of the work.
    pub fn fits(weights: &Weights) -> bool {
        if weights.trunk > 0 {
            return false;
        }
        let n = weights.features();
        let (mut own, mut stacked) = (0usize, 0usize);
        for (at, layer) in weights.layers.iter().enumerate() {
            own += layer.weight.len();
            stacked += layer.weight.len() * if at == 0 { 1 } else { n };
        }
        own > 0 && stacked <= MAX_WEIGHTS && 2 * stacked <= 3 * own
    }

    /// Room for networks of the shape of these.
    pub fn new(weights: &Weights) -> Self {
        let mut layers: Vec<Block> = Vec::new();
        for layer in &weights.layers {
            let before = layers.last().map(|block| block.stride_out);
            let stride_in = before.unwrap_or(layer.weight.dim().1.next_multiple_of(BLOCK));
            layers.push(Block::new(layer, before.is_none(), stride_in));
        }
        Self {
            activation: weights.activation,
            features: weights.features(),
            layers,
            shares: Vec::new(),
            snapshots: 0,
        }
    }

    /// g_i(s) of every snapshot: `[snapshot, input]` → `[snapshot, feature]`. What [`backward`](Self::backward) needs
    /// besides is kept.
    ///
    /// # Errors
    /// Where an array's shape is not that of the networks.
    pub fn forward(
        &mut self,
        weights: &Weights,
        inputs: ArrayView2<f32>,
        noise: Option<Noise>,
        mut out: ArrayViewMut2<f32>,
    ) -> Result<()> {
        let width = self.layers.first().map_or(0, |block| block.inputs);
        same("inputs", inputs.dim(), (inputs.nrows(), width))?;
        same("activations", out.dim(), (inputs.nrows(), self.features))?;
        self.same_shape(weights)?;
        not_empty(noise)?;
        self.share_out(inputs.nrows());
        let inputs = in_row_order(&inputs)?;
        for (block, layer) in self.layers.iter_mut().zip(&weights.layers) {
            block.fill(layer);
        }
        let Some(length) = self.shares.first().map(|share| share.snapshots) else {
            return Ok(());
        };
        let (layers, activation) = (&self.layers, self.activation);
        let rows = inputs.chunks((length * width).max(1));
        let outs = out.axis_chunks_iter_mut(Axis(0), length);
        let work: Vec<_> = self.shares.iter_mut().zip(rows).zip(outs).collect();
        let one = |(at, ((share, inputs), out))| {
            let source = Source {
                inputs,
                width,
                noise,
                position: at * length * width,
            };
            simd::run_in_registers(Forward {
                share,
                layers,
                activation,
                source,
                out,
            });
        };
        work.into_par_iter().enumerate().for_each(one);
        Ok(())
    }

    /// ∂E/∂weights and ∂E/∂biases at the last forward, of an objective with this slope ∂E/∂g, `[snapshot, feature]`; with
    /// the inputs and the noise of then.
    ///
    /// # Errors
    /// Where an array's shape is not that of the networks or of the last forward.
    pub fn backward(
        &mut self,
        inputs: ArrayView2<f32>,
        noise: Option<Noise>,
        slope: ArrayView2<f32>,
        gradient: &mut Weights,
    ) -> Result<()> {
        let width = self.layers.first().map_or(0, |block| block.inputs);
        same("inputs", inputs.dim(), (self.snapshots, width))?;
        same("slopes", slope.dim(), (self.snapshots, self.features))?;
        not_empty(noise)?;
        let inputs = in_row_order(&inputs)?;
        self.same_shape(gradient)?;
        let Some(length) = self.shares.first().map(|share| share.snapshots) else {
            for layer in &mut gradient.layers {
                layer.weight.fill(0.0);
                layer.bias.fill(0.0);
            }
            return Ok(());
        };
        let (layers, activation) = (&self.layers, self.activation);
        let rows = inputs.chunks((length * width).max(1));
        let slopes = slope.axis_chunks_iter(Axis(0), length);
        let work: Vec<_> = self.shares.iter_mut().zip(rows).zip(slopes).collect();
        let one = |(at, ((share, inputs), slope))| {
            let source = Source {
                inputs,
                width,
                noise,
                position: at * length * width,
            };
            simd::run_in_registers(Backward {
                share,
                layers,
                activation,
                source,
                slope,
            });
        };
        work.into_par_iter().enumerate().for_each(one);
        if let Some((sum, others)) = self.shares.split_first_mut() {
            for (at, block) in self.layers.iter().enumerate() {
                for other in others.iter() {
                    add(&mut sum.weight[at], &other.weight[at]);
                    add(&mut sum.bias[at], &other.bias[at]);
                }
                block.unpack(&sum.weight[at], &sum.bias[at], &mut gradient.layers[at]);
            }
        }
        Ok(())
    }

    fn same_shape(&self, weights: &Weights) -> Result<()> {
        let expected = self
            .layers
            .iter()
            .map(|block| (self.features, block.inputs, block.outputs));
        if weights.layers.iter().map(|l| l.weight.dim()).eq(expected) {
            return Ok(());
        }
        Err(Error::work(
            "stacked networks: weights of another shape than these networks were made for",
        ))
    }

    /// Deals K snapshots to shares, by their number alone.
    fn share_out(&mut self, snapshots: usize) {
        if snapshots == self.snapshots && !self.shares.is_empty() {
            return;
        }
        let shares = snapshots.div_ceil(SHARE).clamp(1, MAX_SHARES);
        let length = snapshots.div_ceil(shares).next_multiple_of(BLOCK);
        let starts = (0..snapshots).step_by(length.max(1));
        self.shares = starts
            .map(|start| Share::new(&self.layers, length.min(snapshots - start)))
            .collect();
        self.snapshots = snapshots;
    }
}

fn not_empty(noise: Option<Noise>) -> Result<()> {
    match noise.is_some_and(|noise| noise.bank.is_empty()) {
        true => Err(Error::work("input noise: an empty bank; expected numbers")),
        false => Ok(()),
    }
}

fn same(what: &str, found: (usize, usize), expected: (usize, usize)) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(Error::work(format!(
        "stacked networks: {what} of shape {found:?}; expected {expected:?}"
    )))
}

fn in_row_order<'a>(inputs: &'a ArrayView2<f32>) -> Result<&'a [f32]> {
    inputs.as_slice().ok_or_else(|| {
        Error::work("stacked networks: inputs scattered in memory; expected them in row order")
    })
}

#[cfg(test)]
mod tests;
