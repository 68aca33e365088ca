//! Trained filters as one thing that can be kept in JSON: what they are fed, and their networks as plain arrays.

use super::{
    Detector, device,
    input::Input,
    net::{Activation, Convolution, Layer, NetDetector, Weights},
};
use crate::{
    error::{Error, Result},
    recording::Channel,
};
use ndarray::{Array2, Array3, ArrayView2};
use serde::{Deserialize, Serialize};
use std::fmt;

/// A trained detector on the CPU together with what it was made from: a recogniser or localiser that works from learned
/// features holds one, and is saved with it. What is read back answers the same to the bit.
#[derive(Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct Filters {
    input: Input,
    weights: Weights,
    detector: NetDetector,
}

impl Filters {
    /// Filters of these inputs and weights, whose widths agree.
    pub fn new(input: Input, weights: Weights) -> Self {
        Self {
            detector: NetDetector::new(input.clone(), &weights, &device::cpu()),
            input,
            weights,
        }
    }

    /// Does a recording with these channels have all that the filters are fed?
    ///
    /// # Errors
    /// Where a channel is missing or has another width or unit; the message names it.
    pub fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.input.check_channels(channels)
    }
}

impl Detector for Filters {
    fn features(&self) -> usize {
        self.weights.features()
    }

    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        self.detector.detect_batch(channels, values)
    }
}

impl fmt::Debug for Filters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Filters")
            .field("input", &self.input)
            .field("weights", &self.weights)
            .finish_non_exhaustive()
    }
}

impl Clone for Filters {
    fn clone(&self) -> Self {
        Self::new(self.input.clone(), self.weights.clone())
    }
}

/// What a file holds of them.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    input: Input,
    mean: Vec<f32>,
    deviation: Vec<f32>,
    trunk: usize,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    convolutions: Vec<Convolution>,
    activation: Activation,
    layers: Vec<SavedLayer>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedLayer {
    /// Networks, inputs, outputs.
    shape: [usize; 3],
    weight: Vec<f32>,
    bias: Vec<f32>,
}

impl From<Filters> for Saved {
    fn from(filters: Filters) -> Self {
        let saved = |layer: Layer| SavedLayer {
            shape: layer.weight.dim().into(),
            weight: layer.weight.iter().copied().collect(),
            bias: layer.bias.iter().copied().collect(),
        };
        Self {
            mean: filters.input.mean.clone(),
            deviation: filters.input.deviation.clone(),
            input: filters.input,
            trunk: filters.weights.trunk,
            convolutions: filters.weights.convolutions,
            activation: filters.weights.activation,
            layers: filters.weights.layers.into_iter().map(saved).collect(),
        }
    }
}

impl TryFrom<Saved> for Filters {
    type Error = Error;

    /// The networks are built at once, so everything that they rest on is checked first.
    fn try_from(saved: Saved) -> Result<Self> {
        let mut input = saved.input;
        (input.mean, input.deviation) = (saved.mean, saved.deviation);
        input.check()?;
        let mut width = input.width();
        let features = saved.layers.last().map_or(0, |layer| layer.shape[0]);
        let mut layers = Vec::new();
        for (number, layer) in saved.layers.into_iter().enumerate() {
            let wrong = |e: &dyn fmt::Display| Error::work(format!("filters: layer {number}: {e}"));
            let [networks, inputs, outputs] = layer.shape;
            let shared = number < saved.trunk;
            let expected = if shared { 1 } else { features };
            let convolution = saved.convolutions.get(number);
            if let Some(c) = convolution {
                let fits = shared
                    && c.is_sound()
                    && c.inputs.checked_mul(c.positions) == Some(width)
                    && c.outputs == outputs;
                if !fits {
                    return Err(wrong(&format!(
                        "convolutions of {c:?}; expected {width} inputs and {outputs} outputs, in a trunk"
                    )));
                }
                width = c.width * c.inputs;
            }
            if networks != expected || inputs != width || outputs == 0 {
                return Err(wrong(&format!(
                    "shape {:?}; expected {expected} networks of {width} inputs",
                    layer.shape
                )));
            }
            width = outputs * convolution.map_or(1, Convolution::positions_out);
            layers.push(Layer {
                weight: Array3::from_shape_vec((networks, inputs, outputs), layer.weight)
                    .map_err(|e| wrong(&e))?,
                bias: Array2::from_shape_vec((networks, outputs), layer.bias)
                    .map_err(|e| wrong(&e))?,
            });
        }
        if features == 0 || width != 1 || saved.trunk >= layers.len() {
            return Err(Error::work(
                "filters: expected a last layer of one output a feature, outside the trunk",
            ));
        }
        let weights = Weights {
            layers,
            convolutions: saved.convolutions,
            trunk: saved.trunk,
            activation: saved.activation,
        };
        Ok(Self::new(input, weights))
    }
}
