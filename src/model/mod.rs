//! A trained model: what the robot needs to recognise and to localise, as one file.
//!
//! The file is a list of named arrays and one JSON text, in either of two containers that everything reads:
//! [`safetensors`] and [`npz`]. Names and shapes:
//!
//! | array | shape | what |
//! |---|---|---|
//! | `filter.trunk.{layer}.weight` | `[out, in]` f32 | layers that all networks share, from the input; often none |
//! | `filter.trunk.{layer}.bias` | `[out]` f32 | |
//! | `filter.{i}.{layer}.weight` | `[out, in]` f32 | network of feature i, layers from trunk (or input) to output |
//! | `filter.{i}.{layer}.bias` | `[out]` f32 | |
//! | `input.mean`, `input.deviation` | `[inputs]` f32 | normalisation of the pooled values |
//! | `map.pose` | `[K, 3]` f64 | training places: m, m, rad |
//! | `map.route` | `[K]` f64 | their coordinate along the route, where they have one |
//! | `map.activation` | `[K, n]` f32 | raw activations there |
//!
//! The JSON (metadata key `ballmark`, array `meta` in `.npz`) holds [`Header`].

mod arrays;
mod layout;
pub mod npz;
pub mod safetensors;
pub mod seen;

use crate::{
    belief::{FeatureMap, OdometryMotion, Places, Uncertainty},
    detector::{
        device,
        input::Input,
        net::{Activation, NetDetector, Weights},
    },
    error::{Error, Result},
    geometry::Pose,
    learning::{
        Recipe, error_reduction::ErrorReduction, trainer::Trained, training_set::TrainingSet,
    },
    recording::{Channel, Recording},
    storage,
};
use ndarray::Array2;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Everything about a model that is not an array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Version of this crate that trained it.
    pub crate_version: String,
    /// The resolved configuration, seed and all.
    pub recipe: Recipe,
    /// Prior uncertainty that the filters are for.
    pub prior: Uncertainty,
    /// Sensors of the recording it was trained on.
    pub channels: Vec<Channel>,
    /// SHA-256 of the dataset file it was trained on, where it came from a file.
    pub dataset_sha256: Option<String>,
    /// Preprocessing; its mean and deviation stand in the arrays.
    pub input: Input,
    /// Activation of the hidden units.
    pub activation: Activation,
    /// How far the odometry of the training part can be trusted.
    pub motion: OdometryMotion,
    /// Expected errors reached.
    pub scores: Scores,
}

/// Expected errors of a model on the parts of the recording it was trained on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scores {
    /// On the training part, with the map that localisation uses.
    pub train: ErrorReduction,
    /// On the validation part; none where no validation snapshot lies at a place seen in training.
    pub validation: Option<ErrorReduction>,
}

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
    /// Puts together what training gave.
    pub fn new(
        recipe: &Recipe,
        recording: &Recording,
        training_set: &TrainingSet<'_>,
        trained: Trained,
    ) -> Self {
        let at = |k: &usize| recording.poses()[*k];
        Self {
            header: Header {
                crate_version: env!("CARGO_PKG_VERSION").to_string(),
                recipe: recipe.clone(),
                prior: recipe.uncertainty,
                channels: recording.channels().to_vec(),
                dataset_sha256: recording.columns().dataset_sha256.clone(),
                input: training_set.input.clone(),
                activation: trained.weights.activation,
                motion: OdometryMotion::fitted(recording, &training_set.snapshots),
                scores: Scores {
                    train: trained.train,
                    validation: trained.validation,
                },
            },
            weights: trained.weights,
            pose: training_set.snapshots.iter().map(at).collect(),
            route_m: recording
                .route_m()
                .map(|route| training_set.snapshots.iter().map(|&k| route[k]).collect()),
            activation: trained.activation,
        }
    }

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

    /// Reads a model from a `.safetensors` or `.npz` file; which of the two, its content tells.
    ///
    /// # Errors
    /// Where the file is neither, is damaged, or lacks an array; the message names it.
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(path, &storage::read_file(path)?)
    }

    /// Reads a model from the bytes of its file; `path` is for messages only.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        if bytes.is_empty() {
            return Err(Error::file(
                path,
                format!("the file is empty; expected {}", arrays::EXPECTED),
            ));
        }
        let (meta, arrays) = if bytes.starts_with(b"PK") {
            npz::read(path, bytes)?
        } else {
            safetensors::read(path, bytes)?
        };
        layout::model(path, &meta, &arrays)
    }

    /// Is this a name that [`Model::write`] knows a container for, and could a file be made there? Asked before the
    /// work, not after it.
    ///
    /// # Errors
    /// Where its ending is neither `.safetensors` nor `.npz` (the call is wrong), or its folder is none.
    pub fn check_name(path: &Path) -> Result<()> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("safetensors" | "npz") => storage::check_target(path).map(|_| ()),
            _ => Err(Error::usage(format!(
                "{}: no such model format; expected a name ending in .safetensors or .npz",
                path.display()
            ))),
        }
    }

    /// Writes the model, whole or not at all; the container follows from the file name's ending.
    ///
    /// # Errors
    /// Where the ending is neither `.safetensors` nor `.npz` (a wrong call), or the file can't be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        Self::check_name(path)?;
        if path.extension().is_some_and(|e| e == "npz") {
            npz::write(path, &self.meta()?, &layout::arrays(self, path))
        } else {
            safetensors::write(path, &self.meta()?, &layout::arrays(self, path))
        }
    }

    fn meta(&self) -> Result<String> {
        serde_json::to_string(&self.header).map_err(|e| Error::work(format!("model header: {e}")))
    }
}

#[cfg(test)]
mod tests;
