//! In the plane without any idea where: all distances, by blocks.

use crate::belief::Places;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, Zip};
use rayon::prelude::*;

/// Every candidate for every truth. Up to some thousands of places the distances are kept; beyond, they are made block
/// by block, multiplied and dropped, so that memory grows no faster than the number of places.
pub struct Everywhere {
    truths: Places,
    candidates: Places,
    kept: Option<Array2<f64>>,
}

/// Truths handled at once.
const BLOCK: usize = 64;

/// Most distances that are kept: 200 MB.
const MOST_KEPT: usize = 25_000_000;

impl Everywhere {
    pub(super) fn new(truths: &Places, candidates: &Places) -> Self {
        let (truths, candidates) = (truths.clone(), candidates.clone());
        let kept = (truths.len() * candidates.len() <= MOST_KEPT).then(|| {
            let mut all = Array2::zeros((truths.len(), candidates.len()));
            let blocks = all
                .axis_chunks_iter_mut(Axis(0), BLOCK)
                .into_par_iter()
                .enumerate();
            blocks
                .for_each(|(block, out)| fill_distances(&truths, block * BLOCK, &candidates, out));
            all
        });
        Self {
            truths,
            candidates,
            kept,
        }
    }

    fn share(&self) -> f64 {
        1.0 / self.candidates.len().max(1) as f64
    }

    /// Candidates that the prior of every truth admits.
    pub(super) fn window_sizes(&self) -> Vec<usize> {
        vec![self.candidates.len(); self.truths.len()]
    }

    pub(super) fn candidates(&self) -> usize {
        self.candidates.len()
    }

    pub(super) fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        let kept = self.kept.as_ref().map(|all| all.view());
        let n = distances_times(&self.truths, &self.candidates, kept, map, self.share());
        let mean = map.sum_axis(Axis(0)) * self.share();
        let mut d = Array2::zeros(n.raw_dim());
        d.assign(&mean);
        (n, d)
    }

    pub(super) fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        let kept = self.kept.as_ref().map(|all| all.t());
        let mut out = distances_times(&self.candidates, &self.truths, kept, u, self.share());
        out -= &(v.sum_axis(Axis(0)) * self.share());
        out
    }
}

/// `share`·e(from, to)·rows, `[from, outcome]`.
fn distances_times(
    from: &Places,
    to: &Places,
    kept: Option<ArrayView2<f64>>,
    rows: ArrayView2<f64>,
    share: f64,
) -> Array2<f64> {
    let mut out = Array2::zeros((from.len(), rows.ncols()));
    out.axis_chunks_iter_mut(Axis(0), BLOCK)
        .into_par_iter()
        .enumerate()
        .for_each(|(block, mut out)| {
            let first = block * BLOCK;
            match &kept {
                Some(all) => {
                    let block = all.slice_axis(Axis(0), (first..first + out.nrows()).into());
                    ndarray::linalg::general_mat_mul(share, &block, &rows, 0.0, &mut out);
                }
                None => {
                    let mut block = Array2::zeros((out.nrows(), to.len()));
                    fill_distances(from, first, to, block.view_mut());
                    ndarray::linalg::general_mat_mul(share, &block, &rows, 0.0, &mut out);
                }
            }
        });
    out
}

/// e from places `first`.. to all others, `[from, to]`.
fn fill_distances(from: &Places, first: usize, to: &Places, mut out: ArrayViewMut2<f64>) {
    Zip::indexed(&mut out).for_each(|(i, j), d| *d = from.distance_m(first + i, to, j));
}
