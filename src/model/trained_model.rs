//! A trained set of filters and its map, in memory.

use super::header::Header;
use crate::{
    belief::{FeatureMap, Places},
    detector::{
        device,
        net::{NetDetector, Weights},
    },
    error::Result,
    geometry::Pose,
};
use ndarray::Array2;

/// A trained set of filters and its map.
///
/// ```no_run
/// use ballmark::{detector::Detector, model::Model, recording::npz};
/// let model = Model::read("corridor-2m.safetensors".as_ref())?;
/// let unseen = npz::read("walk.npz".as_ref())?;
/// let probability = model.detector().probabilities(&unseen)?; // P(f_i = 1 | s), [snapshot, feature]
/// model.write("corridor-2m.npz".as_ref())?; // the same to the bit, for numpy
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// What is no array.
    pub header: Header,
    /// The networks.
    pub weights: Weights,
    /// Training places in the plane.
    pub pose: Vec<Pose>,
    /// And along the route, where the recording has one.
    pub route_m: Option<Vec<f64>>,
    /// Activations there, `[place, feature]`.
    pub activation: Array2<f32>,
}

impl Model {
    /// Number n of features.
    pub fn features(&self) -> usize {
        self.weights.features()
    }

    /// The learned detector, on the CPU.
    pub fn detector(&self) -> NetDetector {
        NetDetector::new(self.header.input.clone(), &self.weights, &device::cpu())
    }

    /// The training places: along the route where there is one, else in the plane.
    pub fn places(&self) -> Places {
        match &self.route_m {
            Some(route) => Places::Route(route.clone()),
            None => Places::Plane(self.pose.clone()),
        }
    }

    /// P(f|ξ) as the recipe reads it off the training places.
    ///
    /// # Errors
    /// Where there are fewer training places than neighbours asked for.
    pub fn map(&self) -> Result<FeatureMap> {
        FeatureMap::new(
            self.places(),
            self.activation.mapv(f64::from),
            self.header.recipe.map.clone(),
        )
    }
}
