//! A share of the snapshots: what one thread does with them on the way forward and back, and its buffers.

use super::{
    Block, Noise, activation,
    kernel::{self, BLOCK, Matrix, STEP},
};
use crate::{
    detector::net::Activation,
    simd::{self, RegisterKernel},
};
use macerator::Simd;
use ndarray::{ArrayView2, ArrayViewMut2};
use std::ops::Range;

/// Snapshots of a chunk: their inputs, and the weights or their gradient, fit a nearest cache together.
pub const CHUNK: usize = 32;

/// Snapshots that one thread works on at a time, and all that it needs for them.
#[derive(Debug)]
pub struct Share {
    /// Snapshots, and with those that fill up the last block.
    pub snapshots: usize,
    pub rows: usize,
    /// Inputs of every layer, `[row, stride_in]`: those of the first, noise included, of one chunk only. They are read
    /// anew on the way back: keeping them would cost more memory than all the rest, and with it more time.
    pub inputs: Vec<Vec<f32>>,
    /// g, without anything between: `[snapshot, feature]`, and some more to fill a register.
    pub outputs: Vec<f32>,
    /// Sums of the last layer, of one chunk.
    pub sums: Vec<f32>,
    /// ∂E/∂sum of a layer and of the one before it, of one chunk.
    pub slope: Vec<f32>,
    pub slope_before: Vec<f32>,
    /// This share's part of ∂E/∂weights `[stride_in, stride_out]` and ∂E/∂biases `[stride_out]`.
    pub weight: Vec<Vec<f32>>,
    pub bias: Vec<Vec<f32>>,
}

impl Share {
    /// Room for so many snapshots.
    pub fn new(layers: &[Block], snapshots: usize) -> Self {
        let rows = snapshots.next_multiple_of(BLOCK);
        let features = layers.last().map_or(0, |b| b.width_out);
        let widest = layers.iter().map(|b| b.stride_out).max().unwrap_or(0);
        let chunk = vec![0.0; rows.min(CHUNK) * widest];
        let matrix = |b: &Block| vec![0.0; b.stride_in * b.stride_out];
        Self {
            snapshots,
            rows,
            inputs: layers
                .iter()
                .enumerate()
                .map(|(at, b)| {
                    vec![0.0; if at == 0 { rows.min(CHUNK) } else { rows } * b.stride_in]
                })
                .collect(),
            outputs: vec![0.0; (rows * features).next_multiple_of(simd::lanes())],
            sums: chunk.clone(),
            slope: chunk.clone(),
            slope_before: chunk,
            weight: layers.iter().map(matrix).collect(),
            bias: layers.iter().map(|b| vec![0.0; b.stride_out]).collect(),
        }
    }
}

/// A share's way forward.
pub struct Forward<'a> {
    pub share: &'a mut Share,
    pub layers: &'a [Block],
    pub activation: Activation,
    pub source: Source<'a>,
    pub out: ArrayViewMut2<'a, f32>,
}

impl RegisterKernel for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd, const L: usize>(mut self) {
        let share = self.share;
        let features = self.out.ncols();
        for start in (0..share.rows).step_by(CHUNK) {
            let rows = start..(start + CHUNK).min(share.rows);
            let in_place = self.source.in_place(rows.clone());
            if in_place.is_none() {
                let stride = self.layers[0].stride_in;
                self.source.read(rows.clone(), stride, &mut share.inputs[0]);
            }
            for (at, block) in self.layers.iter().enumerate() {
                let stride = block.stride_out;
                let (before, after) = share.inputs.split_at_mut(at + 1);
                let inputs = match (at, in_place) {
                    (0, Some(inputs)) => inputs,
                    (0, None) => Matrix::new(&before[0], block.stride_in),
                    _ => Matrix::new(&before[at][rows.start * block.stride_in..], block.stride_in),
                };
                let sums = match after.first_mut() {
                    Some(next) => &mut next[rows.start * stride..rows.end * stride],
                    None => &mut share.sums[..rows.len() * stride],
                };
                let weight = Matrix::new(&block.weight, stride);
                kernel::product::<S, L>(inputs, weight, Some(&block.bias), sums);
                if at + 1 < self.layers.len() {
                    activation::apply::<S, L>(self.activation, sums);
                    continue;
                }
                // Of few features, whole registers would be mostly zeros.
                let outputs = share.outputs[rows.start * features..].chunks_exact_mut(features);
                for (outputs, sums) in outputs.zip(sums.chunks_exact(stride)) {
                    for (output, &sum) in outputs.iter_mut().zip(sums) {
                        *output = sum;
                    }
                }
            }
        }
        activation::apply::<S, L>(Activation::Sigmoid, &mut share.outputs);
        for (out, &g) in self.out.iter_mut().zip(&share.outputs) {
            *out = g;
        }
    }
}

/// A share's inputs and the noise on them.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// `[snapshot, input]`.
    pub inputs: &'a [f32],
    pub width: usize,
    pub noise: Option<Noise<'a>>,
    /// Inputs of all snapshots before this share's.
    pub position: usize,
}

impl<'a> Source<'a> {
    /// The inputs of some rows without copying them, if a product can take them as they are.
    #[inline(always)]
    fn in_place(&self, rows: Range<usize>) -> Option<Matrix<'a>> {
        let fits = self.noise.is_none() && self.width > 0 && self.width.is_multiple_of(STEP);
        let inputs = self
            .inputs
            .get(rows.start * self.width..rows.end * self.width)?;
        match fits {
            true => Some(Matrix::new(inputs, self.width)),
            false => None,
        }
    }

    /// Copies the inputs of some rows to the front, with their noise; those of rows that are no snapshots are 0.
    #[inline(always)]
    fn read(&self, rows: Range<usize>, stride: usize, to: &mut [f32]) {
        let width = self.width.max(1);
        let snapshots = self.inputs.len() / width;
        for (row, to) in rows.zip(to.chunks_exact_mut(stride)) {
            if row >= snapshots {
                to.fill(0.0);
                continue;
            }
            let inputs = &self.inputs[row * width..(row + 1) * width];
            let Some(noise) = self.noise else {
                to[..self.width].copy_from_slice(inputs);
                continue;
            };
            let mut at = (noise.start + self.position + row * self.width) % noise.bank.len();
            let mut done = 0;
            while done < self.width {
                let end = self.width.min(done + noise.bank.len() - at);
                let noisy = inputs[done..end].iter().zip(&noise.bank[at..]);
                for (to, (x, z)) in to[done..end].iter_mut().zip(noisy) {
                    *to = x + noise.deviation * z;
                }
                (done, at) = (end, 0);
            }
        }
    }
}

/// A share's way back.
pub struct Backward<'a> {
    pub share: &'a mut Share,
    pub layers: &'a [Block],
    pub activation: Activation,
    /// As on the way forward.
    pub source: Source<'a>,
    /// ∂E/∂g of the share's snapshots.
    pub slope: ArrayView2<'a, f32>,
}

impl RegisterKernel for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd, const L: usize>(self) {
        let share = self.share;
        share.weight.iter_mut().for_each(|sum| sum.fill(0.0));
        share.bias.iter_mut().for_each(|sum| sum.fill(0.0));
        let last = self.layers.len() - 1;
        let features = self.slope.ncols();
        for start in (0..share.rows).step_by(CHUNK) {
            let rows = start..(start + CHUNK).min(share.rows);
            let slope = &mut share.slope[..rows.len() * self.layers[last].stride_out];
            slope.fill(0.0); // where no snapshot is, E has no slope
            let given = self.slope.outer_iter().skip(start);
            let outputs = share.outputs[start * features..].chunks_exact(features);
            let slopes = slope.chunks_exact_mut(self.layers[last].stride_out);
            for ((slopes, given), outputs) in slopes.zip(given).zip(outputs) {
                for ((slope, &given), &g) in slopes.iter_mut().zip(given).zip(outputs) {
                    *slope = given * g * (1.0 - g);
                }
            }
            for (at, block) in self.layers.iter().enumerate().rev() {
                let (stride_in, stride) = (block.stride_in, block.stride_out);
                let slope = &mut share.slope[..rows.len() * stride];
                if at < last {
                    let outputs = &share.inputs[at + 1][rows.start * stride..];
                    activation::slope(self.activation, outputs, slope);
                }
                for slope in slope.chunks_exact(stride) {
                    add(&mut share.bias[at], slope);
                }
                let slope = Matrix::new(slope, stride);
                let first = match at {
                    0 => {
                        self.source
                            .read(rows.clone(), stride_in, &mut share.inputs[0]);
                        0
                    }
                    _ => rows.start,
                };
                let inputs = &share.inputs[at][first * stride_in..][..rows.len() * stride_in];
                let inputs = Matrix::new(inputs, stride_in);
                kernel::outer::<S, L>(inputs, slope, &mut share.weight[at]);
                if at > 0 {
                    let transposed = Matrix::new(&block.transposed, stride_in);
                    let before = &mut share.slope_before[..rows.len() * stride_in];
                    kernel::product::<S, L>(slope, transposed, None, before);
                    std::mem::swap(&mut share.slope, &mut share.slope_before);
                }
            }
        }
    }
}

/// Adds numbers to as many others.
pub fn add(sum: &mut [f32], more: &[f32]) {
    for (sum, more) in sum.iter_mut().zip(more) {
        *sum += more;
    }
}
