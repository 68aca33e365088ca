//! The baseline that learns nothing: how much a scan looks like the scans that were taken near a place.

use super::{PreparedSensorModel, SensorModel, flat};
use crate::{
    belief::{Belief, Neighbours},
    detector::input::Input,
    error::{Error, Result},
    recording::{Observation, Recording},
    seed::Stream,
};
use ndarray::{Array2, ArrayView1, ArrayView2, Axis, linalg::general_mat_mul};
use rayon::prelude::*;
use std::sync::Arc;

/// A nearest-neighbour kernel over raw scans: P(s|ξ) ∝ mean over the training scans s_k nearest to ξ of
/// exp(−‖s − s_k‖²/2h²), with ‖·‖² the mean square over the values; where s_k is kept in several views, of the view most
/// like s. An unmapped place gets the mean of all.
///
/// The constant left out of ln P(z | ξ) is the distance to the most similar training scan, which depends on the observation
/// alone.
pub struct RawKernel {
    input: Input,
    /// `[training, input]`, one a view
    views: Vec<Array2<f32>>,
    weighting: Weighting,
}

impl RawKernel {
    /// `input` makes values comparable ([`Input::with_common_scale`]); `views` are the training scans as inputs,
    /// `[training, input]`, as recorded and in as many moved views as there are; `near` the training places near every cell;
    /// then the bandwidth h, and the share of likelihood that no scan explains.
    ///
    /// # Errors
    /// Where there is no view, the views are not of one shape or not as wide as the input, a neighbour is no training
    /// place, or the bandwidth isn't above 0.
    pub fn new(
        input: Input,
        views: Vec<Array2<f32>>,
        near: Arc<Neighbours>,
        bandwidth: f64,
        unmodelled_probability: f64,
    ) -> Result<Self> {
        let places = views.first().map_or(0, Array2::nrows);
        let shape = (places, input.width());
        if places == 0 || views.iter().any(|view| view.dim() != shape) {
            return Err(Error::work(format!(
                "kernel: expected views of {} inputs, all of as many places and at least one",
                shape.1
            )));
        }
        let neighbours = (0..near.len()).flat_map(|cell| near.of(cell));
        if let Some(bad) = neighbours.clone().find(|&&k| k >= places) {
            return Err(Error::work(format!(
                "kernel: neighbour {bad} is none of the {places} training places"
            )));
        }
        if !(bandwidth > 0.0 && bandwidth.is_finite()) {
            return Err(Error::work(format!(
                "kernel: a bandwidth of {bandwidth}; expected more than 0"
            )));
        }
        Ok(Self {
            input,
            views,
            weighting: Weighting {
                near,
                bandwidth,
                unmodelled_probability,
            },
        })
    }
}

impl SensorModel for RawKernel {
    /// `kernel`, or with moved views `kernel_views`.
    fn name(&self) -> &str {
        if self.views.len() > 1 {
            "kernel_views"
        } else {
            "kernel"
        }
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        let values = observation.values.insert_axis(Axis(0));
        let scan = self.input.transform_values(observation.channels, values)?;
        let square = least_mean_squares(scan.view(), &self.views);
        self.weighting.log_likelihood(square.row(0), belief)
    }

    /// All snapshots are compared with all training scans at once.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        let mut snapshots = snapshots.to_vec();
        snapshots.sort_unstable();
        snapshots.dedup();
        let scans = self.input.transform(recording)?.select(Axis(0), &snapshots);
        Ok(Box::new(PreparedKernel {
            snapshots,
            square: least_mean_squares(scans.view(), &self.views),
            weighting: self.weighting.clone(),
        }))
    }
}

/// [`RawKernel`] whose distances are known for some snapshots of a recording.
pub struct PreparedKernel {
    snapshots: Vec<usize>,
    /// ‖s − s_k‖², `[snapshot, training]`
    square: Array2<f32>,
    weighting: Weighting,
}

impl PreparedKernel {
    /// For these snapshots, in rising order. `square` are their distances from the training scans `[snapshot, training]`, as
    /// [`least_mean_squares`] gives them; the rest as for [`RawKernel::new`].
    pub fn new(
        snapshots: Vec<usize>,
        square: Array2<f32>,
        near: Arc<Neighbours>,
        bandwidth: f64,
        unmodelled_probability: f64,
    ) -> Self {
        Self {
            snapshots,
            square,
            weighting: Weighting {
                near,
                bandwidth,
                unmodelled_probability,
            },
        }
    }
}

impl PreparedSensorModel for PreparedKernel {
    fn log_likelihood(&self, snapshot: usize, belief: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
        let Ok(row) = self.snapshots.binary_search(&snapshot) else {
            return Err(Error::work(format!(
                "kernel: not prepared for snapshot {snapshot}"
            )));
        };
        self.weighting.log_likelihood(self.square.row(row), belief)
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}

/// How distances become likelihoods.
#[derive(Debug, Clone)]
struct Weighting {
    near: Arc<Neighbours>,
    bandwidth: f64,
    unmodelled_probability: f64,
}

impl Weighting {
    /// `square` is ‖s − s_k‖², `[training]`.
    fn log_likelihood(&self, square: ArrayView1<f32>, belief: &Belief) -> Result<Vec<f64>> {
        if belief.mass().len() != self.near.len() {
            return Err(Error::work(format!(
                "kernel: a belief over {} places; expected the {} cells that it was made for",
                belief.mass().len(),
                self.near.len()
            )));
        }
        let best = square.iter().copied().fold(f32::INFINITY, f32::min);
        if !best.is_finite() {
            return Ok(flat(belief)); // values past all bounds are like nothing
        }
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

/// Scans compared with all places at a time: their products fit a core's cache.
const BLOCK: usize = 64;

/// Mean squared difference of every scan `[scan, value]` and every place, `[scan, place]`: the least over the place's
/// views, each of which is given for all places, `[place, value]`.
///
/// ```
/// use ballmark::localiser::sensor_model::kernel::least_mean_squares;
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
        for ((scan, place), &found) in square.indexed_iter() {
            let apart = |view: &Array2<f32>| {
                let differences = &scans.row(scan) - &view.row(place);
                differences.mapv(|d| d * d).sum() / 7.0
            };
            let least = views.iter().map(apart).fold(f32::INFINITY, f32::min);
            assert!((found - least).abs() < 1e-6, "{found} {least}");
        }
        let one_thread = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        let alone = one_thread.install(|| least_mean_squares(scans.view(), &views));
        assert_eq!(square, alone);
    }

    #[test]
    fn a_snapshot_that_was_not_prepared_is_an_error() {
        use crate::belief::{Nearness, Places};
        let places = Places::Route(vec![0.0, 1.0]);
        let nearness = Nearness {
            k: 1,
            ..Nearness::default()
        };
        let near = Arc::new(Neighbours::find(&places, &places, &nearness).unwrap());
        let square = ndarray::array![[0.0, 1.0]];
        let model = PreparedKernel::new(vec![7], square, near, 0.5, 0.01);
        let cells = std::sync::Arc::new(places);
        let belief = Belief::uniform(&cells).unwrap();
        let mut stream = Seed(1).stream("not drawn from");
        let log_likelihood = model.log_likelihood(7, &belief, &mut stream).unwrap();
        assert!(log_likelihood[0] > log_likelihood[1]);
        let error = model.log_likelihood(6, &belief, &mut stream).unwrap_err();
        assert!(error.to_string().contains("snapshot 6"), "{error}");
    }
}
