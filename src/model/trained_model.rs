//! A trained set of filters and its map, in memory.

use super::{header::Header, visits::Visits};
use crate::{
    belief::{CodeMap, FeatureMap, Grid, Places, thinning::thinned_snapshots},
    detector::{
        device,
        net::{NetDetector, Weights},
        rendered::{AtPoses, RenderedInputs, SensedMap},
    },
    error::Result,
    geometry::Pose,
    mapping::OccupancyMap,
    recording::Recording,
};
use ndarray::{Array2, ArrayView2};

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
    /// Where scans are rendered, where the map is filled from that: what [`Header::occupancy`] describes.
    pub occupancy: Option<OccupancyMap>,
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

    /// Which snapshots of the recording that the model learned from its places are, given those that training descended on: all of them,
    /// or of a long log so many as its map may have ([`MapConfig::most_places`](crate::belief::MapConfig)).
    pub fn mapped_of(&self, recording: &Recording, training: &[usize]) -> Vec<usize> {
        if self.pose.len() == training.len() {
            return training.to_vec();
        }
        thinned_snapshots(
            &Places::of(recording),
            training,
            self.header.recipe.map.most_places,
        )
    }

    /// What the networks are fed at any pose of the occupancy map; none where the map is filled from visits.
    pub fn rendered_inputs(&self) -> Option<Result<RenderedInputs>> {
        let (map, of) = self
            .occupancy
            .as_ref()
            .zip(self.header.occupancy.as_ref())?;
        let sensed = SensedMap {
            map: map.clone(),
            sensors: of.sensors.clone(),
        };
        let header = &self.header;
        Some(RenderedInputs::new(
            &sensed,
            &header.channels,
            &header.input,
        ))
    }

    /// P(f_i = 1 | ξ) at some poses, `[pose, feature]`, and whether the map says what is to be seen there: of the scans that are
    /// rendered there, and where the robot has been, as much of what was seen then. None where the map is filled from visits alone.
    ///
    /// # Errors
    /// Where the networks fail.
    pub fn at_every_pose(&self, poses: &[Pose]) -> Result<Option<AtPoses>> {
        let Some(mut at) = self.as_rendered(poses)? else {
            return Ok(None);
        };
        let visits = Visits::new(&self.pose);
        for (pose, mut values) in poses.iter().zip(at.values.rows_mut()) {
            let here = visits.at(pose);
            if !here.is_empty() {
                let weight = 0.5 / here.len() as f32;
                values *= 0.5;
                for k in here {
                    values.scaled_add(weight, &self.activation.row(k));
                }
            }
        }
        let unmodelled = self.header.recipe.map.unmodelled_when_rendered as f32;
        at.values
            .mapv_inplace(|m| (1.0 - unmodelled) * m + 0.5 * unmodelled);
        Ok(Some(at))
    }

    /// What the networks answer to the scans that are rendered at some poses.
    pub(super) fn as_rendered(&self, poses: &[Pose]) -> Result<Option<AtPoses>> {
        let Some(rendered) = self.rendered_inputs() else {
            return Ok(None);
        };
        let detector = self.detector();
        let answer = |inputs: ArrayView2<f32>| detector.respond(inputs);
        rendered?.at_as(poses, self.features(), answer).map(Some)
    }

    /// The map of every cell of a grid, for the filter: as probabilities, or rounded to bits, which are worth what the training
    /// part shows. None where the map is filled from visits, or the grid lies along a route.
    ///
    /// # Errors
    /// As [`Model::at_every_pose`].
    pub fn code_map(&self, grid: &Grid, as_bits: bool) -> Result<Option<CodeMap>> {
        let Places::Plane(cells) = &**grid.places() else {
            return Ok(None);
        };
        let Some(at_cells) = self.at_every_pose(cells)? else {
            return Ok(None);
        };
        let (probability, seen) = (at_cells.values.view(), &at_cells.seen);
        if !as_bits {
            return CodeMap::probabilities(probability, seen).map(Some);
        }
        // Not what was seen there: every example would speak for itself.
        let Some(at_training) = self.as_rendered(&self.pose)? else {
            return Ok(None);
        };
        let examples = (self.activation.view(), at_training.values.view());
        CodeMap::bits(probability, seen, examples).map(Some)
    }

    /// P(f|ξ) as the recipe reads it off the visits of the training places.
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
