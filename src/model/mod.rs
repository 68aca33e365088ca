//! A trained model: what the robot needs to recognise and to localise, as one file.
//!
//! The file is a list of named arrays and one JSON text, in either of two containers that everything reads:
//! [`safetensors`] and [`npz`]. Names and shapes:
//!
//! | array | shape | what |
//! |---|---|---|
//! | `filter.{i}.{layer}.weight` | `[out, in]` f32 | network of feature i, layers from input to output |
//! | `filter.{i}.{layer}.bias` | `[out]` f32 | |
//! | `input.mean`, `input.deviation` | `[inputs]` f32 | normalisation of the pooled values |
//! | `map.pose` | `[K, 3]` f64 | training places: m, m, rad |
//! | `map.route` | `[K]` f64 | their coordinate along the route, where they have one |
//! | `map.activation` | `[K, n]` f32 | raw activations there |
//!
//! The JSON (metadata key `ballmark`, array `meta` in `.npz`) holds [`Header`].

mod arrays;
pub mod npz;
pub mod safetensors;

use crate::{
    belief::{FeatureMap, OdometryMotion, Places, Uncertainty},
    detector::{
        input::Input,
        net::{Activation, Layer, NetDetector, Weights},
    },
    error::{Error, Result},
    geometry::Pose,
    learning::{
        Recipe,
        lesson::Lesson,
        trainer::{Score, Trained},
    },
    recording::{Channel, Recording},
    storage,
};
use arrays::Arrays;
use ndarray::{Array1, Array2, Array3, Axis};
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
    /// On the training part, with the map that localisation uses where the recipe has it in the objective.
    pub train: Score,
    /// On the validation part; none where no validation snapshot lies at a place seen in training.
    pub validation: Option<Score>,
}

/// A trained set of filters and its map.
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
    pub fn new(recipe: &Recipe, recording: &Recording, lesson: &Lesson, trained: Trained) -> Self {
        let at = |k: &usize| recording.poses()[*k];
        Self {
            header: Header {
                crate_version: env!("CARGO_PKG_VERSION").to_string(),
                recipe: recipe.clone(),
                prior: recipe.uncertainty,
                channels: recording.channels().to_vec(),
                dataset_sha256: recording.columns().dataset_sha256.clone(),
                input: lesson.input.clone(),
                activation: trained.weights.activation,
                motion: OdometryMotion::fitted(recording, &lesson.snapshots),
                scores: Scores {
                    train: trained.train,
                    validation: trained.validation,
                },
            },
            weights: trained.weights,
            pose: lesson.snapshots.iter().map(at).collect(),
            route_m: recording
                .route_m()
                .map(|route| lesson.snapshots.iter().map(|&k| route[k]).collect()),
            activation: trained.activation,
        }
    }

    /// Number n of features.
    pub fn features(&self) -> usize {
        self.weights.features()
    }

    /// The learned detector.
    pub fn detector(&self) -> NetDetector {
        NetDetector::new(self.header.input.clone(), &self.weights)
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
        let bytes = storage::read_file(path)?;
        if bytes.is_empty() {
            return Err(Error::file(
                path,
                "is empty; expected a model (.safetensors or .npz)",
            ));
        }
        let (meta, arrays) = if bytes.starts_with(b"PK") {
            npz::read(path, &bytes)?
        } else {
            safetensors::read(path, &bytes)?
        };
        Self::from_arrays(path, &meta, arrays)
    }

    /// Is this a name that [`Model::write`] knows a container for? Asked before the work, not after it.
    ///
    /// # Errors
    /// Where its ending is neither `.safetensors` nor `.npz`: the call is wrong.
    pub fn check_name(path: &Path) -> Result<()> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("safetensors" | "npz") => Ok(()),
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
            npz::write(path, &self.meta()?, &self.arrays())
        } else {
            safetensors::write(path, &self.meta()?, &self.arrays())
        }
    }

    fn meta(&self) -> Result<String> {
        serde_json::to_string(&self.header).map_err(|e| Error::work(format!("model header: {e}")))
    }

    fn arrays(&self) -> Arrays {
        let mut arrays = Arrays::default();
        for (l, layer) in self.weights.layers.iter().enumerate() {
            for i in 0..self.features() {
                // [in, out] here, [out, in] in the file, as every framework stores it
                let weight = layer.weight.index_axis(Axis(0), i);
                arrays.put_f32(
                    format!("filter.{i}.{l}.weight"),
                    weight.t().to_owned().into_dyn(),
                );
                arrays.put_f32(
                    format!("filter.{i}.{l}.bias"),
                    layer.bias.row(i).to_owned().into_dyn(),
                );
            }
        }
        let input = &self.header.input;
        arrays.put_f32(
            "input.mean".into(),
            Array1::from(input.mean.clone()).into_dyn(),
        );
        arrays.put_f32(
            "input.deviation".into(),
            Array1::from(input.deviation.clone()).into_dyn(),
        );
        let pose = |(k, axis): (usize, usize)| match (axis, &self.pose[k]) {
            (0, p) => p.x_m,
            (1, p) => p.y_m,
            (_, p) => p.heading_rad,
        };
        arrays.put_f64(
            "map.pose".into(),
            Array2::from_shape_fn((self.pose.len(), 3), pose).into_dyn(),
        );
        if let Some(route) = &self.route_m {
            arrays.put_f64("map.route".into(), Array1::from(route.clone()).into_dyn());
        }
        arrays.put_f32("map.activation".into(), self.activation.clone().into_dyn());
        arrays
    }

    fn from_arrays(path: &Path, meta: &str, arrays: Arrays) -> Result<Self> {
        let wrong = |place: &str, fault: String| Error::input(path, format!("`{place}`"), fault);
        let mut header: Header = serde_json::from_str(meta)
            .map_err(|e| wrong("ballmark", format!("not a model's header: {e}")))?;
        header.recipe.check().map_err(|e| e.in_file(path))?;
        let n = header.recipe.features;
        let hidden = header.recipe.network.hidden.len();
        let mut layers = Vec::new();
        for l in 0..=hidden {
            let mut filters = Vec::new();
            for i in 0..n {
                let name = format!("filter.{i}.{l}.weight");
                let weight = arrays.f32_2(path, &name)?;
                let bias = arrays.f32_1(path, &format!("filter.{i}.{l}.bias"))?;
                if bias.len() != weight.nrows() {
                    return Err(wrong(
                        &name,
                        format!("{} outputs, its bias has {}", weight.nrows(), bias.len()),
                    ));
                }
                filters.push((weight, bias));
            }
            let (outputs, inputs) = filters[0].0.dim();
            let expected = if l == 0 {
                None
            } else {
                layers.last().map(|layer: &Layer| layer.bias.ncols())
            };
            if expected.is_some_and(|e| e != inputs)
                || filters.iter().any(|(w, _)| w.dim() != (outputs, inputs))
            {
                return Err(wrong(
                    &format!("filter.0.{l}.weight"),
                    "its shape does not fit the other layers'".into(),
                ));
            }
            layers.push(Layer {
                weight: Array3::from_shape_fn((n, inputs, outputs), |(i, a, b)| {
                    filters[i].0[[b, a]]
                }),
                bias: Array2::from_shape_fn((n, outputs), |(i, b)| filters[i].1[b]),
            });
        }
        let unknown = |name: &&String| match name.split('.').collect::<Vec<_>>()[..] {
            ["filter", i, l, "weight" | "bias"] => {
                i.parse::<usize>().map_or(true, |i| i >= n)
                    || l.parse::<usize>().map_or(true, |l| l > hidden)
            }
            ["filter" | "set", ..] => true,
            _ => false,
        };
        if let Some(name) = arrays.names().find(unknown) {
            return Err(wrong(
                name,
                format!(
                    "a layout this version does not know; expected {n} filters of {} layers",
                    hidden + 1
                ),
            ));
        }
        header.input.mean = arrays.f32_1(path, "input.mean")?.to_vec();
        header.input.deviation = arrays.f32_1(path, "input.deviation")?.to_vec();
        let inputs = layers[0].weight.dim().1;
        if header.input.mean.len() != inputs || header.input.deviation.len() != inputs {
            return Err(wrong(
                "input.mean",
                format!("its length is not the networks' {inputs} inputs"),
            ));
        }
        if layers[hidden].bias.ncols() != 1 {
            return Err(wrong(
                &format!("filter.0.{hidden}.bias"),
                "expected one output a filter".into(),
            ));
        }
        let pose = arrays.f64_2(path, "map.pose")?;
        let activation = arrays.f32_2(path, "map.activation")?;
        if pose.ncols() != 3 || activation.dim() != (pose.nrows(), n) {
            return Err(wrong(
                "map.activation",
                format!("expected [{}, {n}] beside map.pose [K, 3]", pose.nrows()),
            ));
        }
        let route_m = match arrays.names().any(|name| name == "map.route") {
            true => Some(arrays.f64_1(path, "map.route")?.to_vec()),
            false => None,
        };
        if route_m
            .as_ref()
            .is_some_and(|route| route.len() != pose.nrows())
        {
            return Err(wrong(
                "map.route",
                format!("expected {} entries, one a place", pose.nrows()),
            ));
        }
        let activation_of_units = header.activation;
        Ok(Self {
            header,
            weights: Weights {
                layers,
                activation: activation_of_units,
            },
            pose: pose
                .rows()
                .into_iter()
                .map(|p| Pose::new(p[0], p[1], p[2]))
                .collect(),
            route_m,
            activation,
        })
    }
}
