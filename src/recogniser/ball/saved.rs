//! BaLL's recogniser as a file holds it: its networks as plain arrays, checked before they are built again.

use super::Ball;
use crate::{
    detector::{
        device,
        input::Input,
        net::{Activation, Layer, NetDetector, Weights},
    },
    error::{Error, Result},
};
use ndarray::{Array2, Array3};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What a file holds of it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Saved {
    input: Input,
    mean: Vec<f32>,
    deviation: Vec<f32>,
    trunk: usize,
    activation: Activation,
    layers: Vec<SavedLayer>,
    patterns: Vec<Vec<bool>>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedLayer {
    /// Networks, inputs, outputs.
    shape: [usize; 3],
    weight: Vec<f32>,
    bias: Vec<f32>,
}

impl From<Ball> for Saved {
    fn from(ball: Ball) -> Self {
        let saved = |layer: Layer| SavedLayer {
            shape: layer.weight.dim().into(),
            weight: layer.weight.iter().copied().collect(),
            bias: layer.bias.iter().copied().collect(),
        };
        Self {
            mean: ball.input.mean.clone(),
            deviation: ball.input.deviation.clone(),
            input: ball.input,
            trunk: ball.weights.trunk,
            activation: ball.weights.activation,
            layers: ball.weights.layers.into_iter().map(saved).collect(),
            patterns: ball.patterns,
        }
    }
}

impl TryFrom<Saved> for Ball {
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
            let wrong = |e: &dyn fmt::Display| Error::work(format!("ball: layer {number}: {e}"));
            let [networks, inputs, outputs] = layer.shape;
            let shared = number < saved.trunk;
            let expected = if shared { 1 } else { features };
            if networks != expected || inputs != width || outputs == 0 {
                return Err(wrong(&format!(
                    "shape {:?}; expected {expected} networks of {width} inputs",
                    layer.shape
                )));
            }
            width = outputs;
            layers.push(Layer {
                weight: Array3::from_shape_vec((networks, inputs, outputs), layer.weight)
                    .map_err(|e| wrong(&e))?,
                bias: Array2::from_shape_vec((networks, outputs), layer.bias)
                    .map_err(|e| wrong(&e))?,
            });
        }
        if features == 0 || width != 1 || saved.trunk >= layers.len() {
            return Err(Error::work(
                "ball: expected a last layer of one output a feature, outside the trunk",
            ));
        }
        let weights = Weights {
            layers,
            trunk: saved.trunk,
            activation: saved.activation,
        };
        Ok(Self {
            detector: NetDetector::new(input.clone(), &weights, &device::cpu()),
            input,
            weights,
            patterns: saved.patterns,
        })
    }
}
