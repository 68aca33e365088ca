//! In the plane a window admits a few candidates a truth: rows that hold only those.

use crate::belief::{Places, Uncertainty};
use ndarray::{Array2, ArrayView2, Axis};
use rayon::prelude::*;

/// Only the admitted candidates of every truth, with belief and error, stored by rows and by columns.
pub struct SparseRows {
    forward: Vec<Vec<Entry>>,
    backward: Vec<Vec<Entry>>,
}

struct Entry {
    index: usize,
    belief: f64,
    error_times_belief: f64,
}

impl SparseRows {
    pub(super) fn new(
        uncertainty: Uncertainty,
        truths: &Places,
        candidates: &Places,
        error_m: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let forward: Vec<Vec<Entry>> = (0..truths.len())
            .into_par_iter()
            .map(|truth| {
                let admitted: Vec<usize> = (0..candidates.len())
                    .filter(|&c| uncertainty.admits(truths, truth, candidates, c))
                    .collect();
                let belief = 1.0 / admitted.len().max(1) as f64;
                let entry = |index| Entry {
                    index,
                    belief,
                    error_times_belief: belief * error_m(truth, index),
                };
                admitted.into_iter().map(entry).collect()
            })
            .collect();
        let mut backward: Vec<Vec<Entry>> = (0..candidates.len()).map(|_| Vec::new()).collect();
        for (index, row) in forward.iter().enumerate() {
            for &Entry {
                index: candidate,
                belief,
                error_times_belief,
            } in row
            {
                backward[candidate].push(Entry {
                    index,
                    belief,
                    error_times_belief,
                });
            }
        }
        Self { forward, backward }
    }

    /// Candidates that the prior of every truth admits.
    pub(super) fn window_sizes(&self) -> Vec<usize> {
        self.forward.iter().map(Vec::len).collect()
    }

    pub(super) fn candidates(&self) -> usize {
        self.backward.len()
    }

    pub(super) fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        let mut n = Array2::zeros((self.forward.len(), map.ncols()));
        let mut d = Array2::zeros(n.raw_dim());
        n.axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(d.axis_iter_mut(Axis(0)))
            .zip(&self.forward)
            .for_each(|((mut n, mut d), row)| {
                for entry in row {
                    let candidate = map.row(entry.index);
                    n.scaled_add(entry.error_times_belief, &candidate);
                    d.scaled_add(entry.belief, &candidate);
                }
            });
        (n, d)
    }

    pub(super) fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        let mut out = Array2::zeros((self.backward.len(), u.ncols()));
        out.axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(&self.backward)
            .for_each(|(mut out, column)| {
                for entry in column {
                    out.scaled_add(entry.error_times_belief, &u.row(entry.index));
                    out.scaled_add(-entry.belief, &v.row(entry.index));
                }
            });
        out
    }
}
