//! The map inside the objective: from activations of snapshots to P(f|ξ) of places, and back.

use crate::{
    belief::{MapConfig, Nearness, Neighbours, Places},
    error::Result,
};
use ndarray::{Array2, ArrayView2};

/// P(f_i|ξ) of every training place as [`crate::belief::FeatureMap`] has it: the mean activation over its nearest
/// training snapshots (Thrun 1998, 5.1.6), kept off 0 and 1.
pub struct Smoothing {
    neighbours: Neighbours,
    unmodelled_probability: f64,
}

impl Smoothing {
    /// The map of some places from the snapshots taken there, all of them where there are fewer than neighbours wanted.
    ///
    /// # Errors
    /// Where there is no place.
    pub fn new(config: &MapConfig, places: &Places) -> Result<Self> {
        let nearness = Nearness {
            k: config.nearness.k.min(places.len()),
            ..config.nearness.clone()
        };
        Ok(Self {
            neighbours: Neighbours::find(places, places, &nearness)?,
            unmodelled_probability: config.unmodelled_probability,
        })
    }

    /// From activations `[snapshot, feature]` to the map `[place, feature]`.
    pub fn apply(&self, activation: ArrayView2<f64>) -> Array2<f64> {
        let mut map = Array2::zeros(activation.raw_dim());
        let chance = self.unmodelled_probability;
        for (place, mut probability) in map.rows_mut().into_iter().enumerate() {
            for &k in self.neighbours.of(place) {
                probability += &activation.row(k);
            }
            let share = 1.0 / self.neighbours.k() as f64;
            probability.mapv_inplace(|sum| (1.0 - chance) * sum * share + 0.5 * chance);
        }
        map
    }

    /// The transpose: from ∂E/∂map to ∂E/∂activation.
    pub fn back(&self, gradient: ArrayView2<f64>) -> Array2<f64> {
        let mut out = Array2::zeros(gradient.raw_dim());
        let share = (1.0 - self.unmodelled_probability) / self.neighbours.k() as f64;
        for (place, slope) in gradient.rows().into_iter().enumerate() {
            for &k in self.neighbours.of(place) {
                out.row_mut(k).scaled_add(share, &slope);
            }
        }
        out
    }
}
