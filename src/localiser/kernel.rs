//! The baseline that learns nothing: how much a scan looks like the scans that were taken near a place.

use super::SensorModel;
use crate::{
    belief::{Belief, Neighbours},
    error::{Error, Result},
    seed::Stream,
};
use ndarray::{Array2, ArrayView2, Axis, linalg::general_mat_mul};
use rayon::prelude::*;

/// A nearest-neighbour kernel over raw scans: P(s|ξ) ∝ mean over the training scans s_k nearest to ξ of
/// exp(−‖s − s_k‖²/2h²), with ‖·‖² the mean square over the values; where s_k is kept in several views, of the view most
/// like s. An unmapped place gets the mean of all.
pub struct KernelModel {
    snapshots: Vec<usize>,
    /// ‖s − s_k‖², `[snapshot, training]`
    square: Array2<f32>,
    near: Neighbours,
    bandwidth: f64,
    unmodelled_probability: f64,
}

impl KernelModel {
    /// For these snapshots of a run, in rising order. `square` are their distances from the training scans
    /// `[snapshot, training]`, as [`least_mean_squares`] gives them; `near` the training places near every cell; then the
    /// bandwidth h, and the share of likelihood that no scan explains.
    pub fn new(
        snapshots: Vec<usize>,
        square: Array2<f32>,
        near: Neighbours,
        bandwidth: f64,
        unmodelled_probability: f64,
    ) -> Self {
        Self {
            snapshots,
            square,
            near,
            bandwidth,
            unmodelled_probability,
        }
    }
}

/// Scans compared with all places at a time: their products fit a core's cache.
const BLOCK: usize = 64;

/// Mean squared difference of every scan `[scan, value]` and every place, `[scan, place]`: the least over the place's
/// views, each of which is given for all places, `[place, value]`.
///
/// ```
/// use ballmark::localiser::kernel::least_mean_squares;
/// let (scan, place) = (ndarray::array![[1.0, 2.0]], ndarray::array![[1.0, 0.0]]);
/// let from_beside = ndarray::array![[2.0, 2.0]];
/// assert_eq!(least_mean_squares(scan.view(), &[place.clone()]), ndarray::array![[2.0]]);
/// assert_eq!(least_mean_squares(scan.view(), &[place, from_beside]), ndarray::array![[0.5]]);
/// ```
pub fn least_mean_squares(scans: ArrayView2<f32>, views: &[Array2<f32>]) -> Array2<f32> {
    let own = |rows: ArrayView2<f32>| -> Vec<f32> {
        rows.rows().into_iter().map(|row| row.dot(&row)).collect()
    };
    let of_views: Vec<Vec<f32>> = views.iter().map(|view| own(view.view())).collect();
    let places = views.first().map_or(0, Array2::nrows);
    let width = scans.ncols().max(1) as f32;
    let mut square = Array2::from_elem((scans.nrows(), places), f32::INFINITY);
    square
        .axis_chunks_iter_mut(Axis(0), BLOCK)
        .into_par_iter()
        .zip(scans.axis_chunks_iter(Axis(0), BLOCK))
        .for_each(|(mut square, scans)| {
            let of_scans = own(scans);
            let mut products = Array2::zeros(square.raw_dim());
            for (view, of_view) in views.iter().zip(&of_views) {
                general_mat_mul(1.0, &scans, &view.t(), 0.0, &mut products);
                for ((mut square, products), of_scan) in square
                    .rows_mut()
                    .into_iter()
                    .zip(products.rows())
                    .zip(&of_scans)
                {
                    let both = products.iter().zip(of_view);
                    for (least, (product, of_view)) in square.iter_mut().zip(both) {
                        let sum = of_scan + of_view - 2.0 * product;
                        *least = least.min((sum / width).max(0.0));
                    }
                }
            }
        });
    square
}

impl SensorModel for KernelModel {
    fn log_likelihood(
        &self,
        snapshot: usize,
        _belief: &Belief,
        _stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let Ok(row) = self.snapshots.binary_search(&snapshot) else {
            return Err(Error::work(format!(
                "kernel: not prepared for snapshot {snapshot}"
            )));
        };
        let square = self.square.row(row);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use rand::RngExt;

    #[test]
    fn the_least_of_all_views_counts_whatever_the_blocks() {
        let mut random = Seed(1).stream("scans");
        let mut rows = |n: usize| Array2::from_shape_simple_fn((n, 7), || random.random::<f32>());
        let (scans, views) = (rows(2 * BLOCK + 3), [rows(50), rows(50), rows(50)]);
        let square = least_mean_squares(scans.view(), &views);
        for ((scan, place), &told) in square.indexed_iter() {
            let apart = |view: &Array2<f32>| {
                let differences = &scans.row(scan) - &view.row(place);
                differences.mapv(|d| d * d).sum() / 7.0
            };
            let least = views.iter().map(apart).fold(f32::INFINITY, f32::min);
            assert!((told - least).abs() < 1e-6, "{told} {least}");
        }
        let one_thread = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        let alone = one_thread.install(|| least_mean_squares(scans.view(), &views));
        assert_eq!(square, alone);
    }

    #[test]
    fn a_snapshot_that_nothing_was_prepared_for_is_told() {
        use crate::belief::{Nearness, Places};
        let places = Places::Route(vec![0.0, 1.0]);
        let nearness = Nearness {
            k: 1,
            ..Nearness::default()
        };
        let near = Neighbours::find(&places, &places, &nearness).unwrap();
        let square = ndarray::array![[0.0, 1.0]];
        let model = KernelModel::new(vec![7], square, near, 0.5, 0.01);
        let cells = std::sync::Arc::new(places);
        let belief = Belief::uniform(&cells).unwrap();
        let mut stream = Seed(1).stream("not drawn from");
        let said = model.log_likelihood(7, &belief, &mut stream).unwrap();
        assert!(said[0] > said[1]);
        let told = model.log_likelihood(6, &belief, &mut stream).unwrap_err();
        assert!(told.to_string().contains("snapshot 6"), "{told}");
    }
}
