//! A share of the snapshots on their way through the layers and back.

use crate::detector::net::{Activation, Convolution, Layer, Weights};
use ndarray::{
    Array1, Array2, ArrayBase, ArrayView2, ArrayViewMut2, Axis, Data, Ix2, linalg::general_mat_mul,
};

/// What is kept of some snapshots between forward and backward.
#[derive(Debug, Default)]
pub(super) struct Share {
    snapshots: usize,
    layers: Vec<Passed>,
}

/// One layer: what came in and went out, and the slopes that came back.
#[derive(Debug, Default)]
struct Passed {
    /// What its weights multiply, `[row, input]`: a row a snapshot, or one a direction of each where it is a convolution.
    input: Array2<f32>,
    /// What it answers, through the activation function, `[row, output]`.
    output: Array2<f32>,
    /// ∂E/∂sum, `[row, output]`.
    slope: Array2<f32>,
    /// ∂E/∂input, `[row, input]`.
    input_slope: Array2<f32>,
    /// ∂E/∂weight, `[input, output]`, and ∂E/∂bias.
    weight: Array2<f32>,
    bias: Array1<f32>,
}

impl Share {
    pub(super) fn snapshots(&self) -> usize {
        self.snapshots
    }

    pub(super) fn forward(
        &mut self,
        weights: &Weights,
        matrices: &[Array2<f32>],
        inputs: ArrayView2<f32>,
        mut out: ArrayViewMut2<f32>,
    ) {
        self.snapshots = inputs.nrows();
        self.layers.resize_with(matrices.len(), Passed::default);
        for (l, matrix) in matrices.iter().enumerate() {
            let (before, rest) = self.layers.split_at_mut(l);
            let layer = &mut rest[0];
            match (weights.convolutions.get(l), before.last()) {
                (Some(c), None) => {
                    let directions = by_direction(&inputs, c);
                    gather(c, self.snapshots, &directions, &mut layer.input);
                }
                (Some(c), Some(before)) => {
                    gather(c, self.snapshots, &before.output, &mut layer.input);
                }
                (None, None) => copy(&inputs, &mut layer.input),
                (None, Some(before)) => {
                    let shape = (self.snapshots, matrix.nrows());
                    copy(&reshaped(&before.output, shape), &mut layer.input);
                }
            }
            sized(&mut layer.output, (layer.input.nrows(), matrix.ncols()));
            let bias = weights.layers[l].bias.iter();
            for (mut column, &bias) in layer.output.columns_mut().into_iter().zip(bias) {
                column.fill(bias);
            }
            general_mat_mul(1.0, &layer.input, matrix, 1.0, &mut layer.output);
            let activation = match l + 1 == matrices.len() {
                true => Activation::Sigmoid, // probabilities
                false => weights.activation,
            };
            layer.output.mapv_inplace(|sum| activation.of(sum));
        }
        if let Some(last) = self.layers.last() {
            out.assign(&last.output);
        }
    }

    pub(super) fn backward(
        &mut self,
        weights: &Weights,
        matrices: &[Array2<f32>],
        slope: ArrayView2<f32>,
    ) {
        if let Some(last) = self.layers.last_mut() {
            copy(&slope, &mut last.slope);
        }
        for l in (0..matrices.len()).rev() {
            let (before, rest) = self.layers.split_at_mut(l);
            let layer = &mut rest[0];
            let activation = match l + 1 == matrices.len() {
                true => Activation::Sigmoid,
                false => weights.activation,
            };
            layer.slope.zip_mut_with(&layer.output, |slope, &out| {
                *slope *= activation.slope_at(out)
            });
            sized(&mut layer.weight, matrices[l].dim());
            general_mat_mul(1.0, &layer.input.t(), &layer.slope, 0.0, &mut layer.weight);
            layer.bias = layer.slope.sum_axis(Axis(0));
            let Some(before) = before.last_mut() else {
                continue; // inputs need no slope
            };
            sized(&mut layer.input_slope, layer.input.dim());
            general_mat_mul(
                1.0,
                &layer.slope,
                &matrices[l].t(),
                0.0,
                &mut layer.input_slope,
            );
            match weights.convolutions.get(l) {
                Some(c) => scatter(c, self.snapshots, &layer.input_slope, &mut before.slope),
                None => copy(
                    &reshaped(&layer.input_slope, before.output.dim()),
                    &mut before.slope,
                ),
            }
        }
    }

    /// Adds this share's part of the gradient of a layer.
    pub(super) fn add_to(&self, l: usize, layer: &mut Layer) {
        let (passed, outputs) = (&self.layers[l], layer.weight.dim().2);
        for ((network, input, output), slope) in layer.weight.indexed_iter_mut() {
            *slope += passed.weight[[input, network * outputs + output]];
        }
        for (slope, own) in layer.bias.iter_mut().zip(&passed.bias) {
            *slope += own;
        }
    }
}

/// Inputs ordered by statistic, then by sector, as a row a sector: `[snapshot · sector, statistic]`.
fn by_direction(inputs: &ArrayView2<f32>, c: &Convolution) -> Array2<f32> {
    let shape = (inputs.nrows() * c.positions, c.inputs);
    Array2::from_shape_fn(shape, |(row, number)| {
        inputs[[row / c.positions, number * c.positions + row % c.positions]]
    })
}

/// What every direction that comes out is found from, `[snapshot · position out, tap · number]`.
fn gather(c: &Convolution, snapshots: usize, from: &Array2<f32>, windows: &mut Array2<f32>) {
    let sources = c.sources();
    sized(windows, (snapshots * c.positions_out(), c.width * c.inputs));
    let (Some(from), Some(windows)) = (from.as_slice(), windows.as_slice_mut()) else {
        return; // both are in row order
    };
    let snapshot = c.positions * c.inputs;
    let into = windows.chunks_exact_mut(sources.len() * c.inputs);
    for (from, into) in from.chunks_exact(snapshot).zip(into) {
        for (&source, into) in sources.iter().zip(into.chunks_exact_mut(c.inputs)) {
            into.copy_from_slice(&from[source * c.inputs..(source + 1) * c.inputs]);
        }
    }
}

/// The way back: what windows have in common adds up.
fn scatter(c: &Convolution, snapshots: usize, windows: &Array2<f32>, to: &mut Array2<f32>) {
    let sources = c.sources();
    sized(to, (snapshots * c.positions, c.inputs));
    to.fill(0.0);
    let (Some(windows), Some(to)) = (windows.as_slice(), to.as_slice_mut()) else {
        return; // both are in row order
    };
    let snapshot = c.positions * c.inputs;
    let windows = windows.chunks_exact(sources.len() * c.inputs);
    for (to, windows) in to.chunks_exact_mut(snapshot).zip(windows) {
        for (&source, window) in sources.iter().zip(windows.chunks_exact(c.inputs)) {
            let to = &mut to[source * c.inputs..(source + 1) * c.inputs];
            to.iter_mut().zip(window).for_each(|(to, from)| *to += from);
        }
    }
}

/// Gives a matrix this shape; what it holds is to be written over.
fn sized(matrix: &mut Array2<f32>, shape: (usize, usize)) {
    if matrix.dim() != shape {
        *matrix = Array2::zeros(shape);
    }
}

fn copy<D: Data<Elem = f32>>(from: &ArrayBase<D, Ix2>, to: &mut Array2<f32>) {
    sized(to, from.dim());
    to.assign(from);
}

/// The same numbers in rows of another length.
fn reshaped(matrix: &Array2<f32>, shape: (usize, usize)) -> ArrayView2<'_, f32> {
    // In row order and of as many numbers, so this does not fail.
    matrix
        .view()
        .into_shape_with_order(shape)
        .unwrap_or_else(|_| matrix.view())
}
