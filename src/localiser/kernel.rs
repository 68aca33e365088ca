//! The baseline that learns nothing: how much a scan looks like the scans that were taken near a place.

use super::SensorModel;
use crate::{
    belief::{Belief, Neighbours},
    error::Result,
    seed::Stream,
};
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

/// A nearest-neighbour kernel over raw scans: P(s|ξ) ∝ mean over the training scans s_k nearest to ξ of
/// exp(−‖s − s_k‖²/2h²), with ‖·‖² the mean square over the values. An unmapped place gets the mean of all.
pub struct KernelModel {
    /// ‖s − s_k‖², `[snapshot, training]`
    square: Array2<f32>,
    near: Neighbours,
    bandwidth: f64,
    unmodelled_probability: f64,
}

impl KernelModel {
    /// From inputs of the run to localise in and of the training part, `[snapshot, input]` both; the training places
    /// near every cell; the bandwidth h; and the share of likelihood that no scan explains.
    pub fn new(
        run: ArrayView2<f32>,
        training: ArrayView2<f32>,
        near: Neighbours,
        bandwidth: f64,
        unmodelled_probability: f64,
    ) -> Self {
        Self {
            square: mean_squares(run, training),
            near,
            bandwidth,
            unmodelled_probability,
        }
    }
}

/// Mean squared difference of every pair of rows, `[a, b]`.
pub fn mean_squares(a: ArrayView2<f32>, b: ArrayView2<f32>) -> Array2<f32> {
    let own = |rows: ArrayView2<f32>| -> Vec<f32> {
        rows.rows().into_iter().map(|row| row.dot(&row)).collect()
    };
    let (of_a, of_b, width) = (own(a), own(b), a.ncols().max(1) as f32);
    let mut square = a.dot(&b.t());
    for ((i, j), product) in square.indexed_iter_mut() {
        *product = ((of_a[i] + of_b[j] - 2.0 * *product) / width).max(0.0);
    }
    square
}

impl SensorModel for KernelModel {
    fn log_likelihood(
        &self,
        snapshot: usize,
        _belief: &Belief,
        _stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let square = self.square.row(snapshot);
        let best = square.iter().copied().fold(f32::INFINITY, f32::min);
        let weight = -0.5 / (self.bandwidth * self.bandwidth);
        let kernel: Vec<f64> = square
            .iter()
            .map(|&d| (f64::from(d - best) * weight).exp())
            .collect();
        let neutral = kernel.iter().sum::<f64>() / kernel.len() as f64;
        let floor = self.unmodelled_probability * neutral.max(f64::MIN_POSITIVE);
        Ok((0..self.near.len())
            .into_par_iter()
            .map(|cell| {
                let likelihood = if self.near.is_mapped(cell) {
                    self.near.of(cell).iter().map(|&k| kernel[k]).sum::<f64>()
                        / self.near.k() as f64
                } else {
                    neutral
                };
                ((1.0 - self.unmodelled_probability) * likelihood + floor).ln()
            })
            .collect())
    }
}
