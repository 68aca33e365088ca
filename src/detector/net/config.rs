//! The shape of the networks, as data.

use super::convolution::{Convolution, ConvolutionConfig};
use crate::{
    detector::input::InputShape,
    error::{Error, Result},
};
use serde::{Deserialize, Serialize};

/// The shape of the networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetConfig {
    /// Convolutions over the sectors of a scan, before all other layers. They need inputs that are the sectors of one range
    /// sensor; of any other inputs they are left out.
    pub convolutions: Vec<ConvolutionConfig>,
    /// Units of the layers that stand in the place of convolutions before inputs that are no scan.
    pub dense: Vec<usize>,
    /// Units of every layer that all networks share, behind those; none: each network sees the inputs themselves.
    pub trunk: Vec<usize>,
    /// Units of every hidden layer of every network; none: a single sigmoid unit a feature.
    pub hidden: Vec<usize>,
    /// What hidden units do with their sum.
    pub activation: Activation,
    /// What output units multiply their sum by while they are trained: above 1, features start out decided, and stay
    /// nearer to bits. Becomes part of the last layer's weights when training is over.
    pub gain: f32,
}

/// Activation function of hidden units; outputs are always sigmoid, as probabilities must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Activation {
    /// 1/(1 + e^−x), as in Thrun (1998), 5.1.4.
    Sigmoid,
    /// Hyperbolic tangent.
    Tanh,
    /// max(0, x).
    Relu,
}

impl Activation {
    /// Of a unit's sum.
    pub fn of(self, sum: f32) -> f32 {
        match self {
            Activation::Sigmoid => 1.0 / (1.0 + (-sum).exp()),
            Activation::Tanh => sum.tanh(),
            Activation::Relu => sum.max(0.0),
        }
    }

    /// Its slope, where the unit answers `out`.
    pub fn slope_at(self, out: f32) -> f32 {
        match self {
            Activation::Sigmoid => out * (1.0 - out),
            Activation::Tanh => 1.0 - out * out,
            Activation::Relu => f32::from(u8::from(out > 0.0)),
        }
    }
}

impl Default for NetConfig {
    /// Three layers of convolutions over the sectors of a scan, a trunk of rectified units, and on it one sigmoid unit a
    /// feature.
    fn default() -> Self {
        let layer = |channels, width, stride| ConvolutionConfig {
            channels,
            width,
            stride,
        };
        Self {
            convolutions: vec![layer(32, 5, 1), layer(48, 5, 2), layer(64, 3, 2)],
            dense: vec![128],
            trunk: vec![64],
            hidden: Vec::new(),
            activation: Activation::Relu,
            gain: 6.0,
        }
    }
}

/// Most units of a hidden layer, and most hidden layers: far beyond what is trained full-batch, and small enough that a
/// slip of the keyboard does not ask for all the memory there is.
const MAX_UNITS: usize = 10_000;
const MAX_LAYERS: usize = 16;

impl NetConfig {
    /// Networks that share nothing, each of six hidden sigmoid units (Thrun 1998, 5.1.4).
    pub fn thrun1998() -> Self {
        Self {
            convolutions: Vec::new(),
            dense: Vec::new(),
            trunk: Vec::new(),
            hidden: vec![6],
            activation: Activation::Sigmoid,
            gain: 1.0,
        }
    }

    /// A single sigmoid unit a feature, on the inputs themselves.
    pub fn single_layer() -> Self {
        Self {
            hidden: Vec::new(),
            activation: Self::default().activation,
            ..Self::thrun1998()
        }
    }

    /// # Errors
    /// Where a layer has no units or too many, or there are too many layers.
    pub fn check(&self) -> Result<()> {
        let units = |&units: &usize| (1..=MAX_UNITS).contains(&units);
        for (key, layers) in [
            ("dense", &self.dense),
            ("trunk", &self.trunk),
            ("hidden", &self.hidden),
        ] {
            if let Some(wrong) = layers.iter().find(|&n| !units(n)) {
                return Err(Error::usage(format!(
                    "network.{key}: a layer of {wrong} units; expected 1 to {MAX_UNITS}"
                )));
            }
            if layers.len() > MAX_LAYERS {
                return Err(Error::usage(format!(
                    "network.{key}: {} layers; expected at most {MAX_LAYERS}",
                    layers.len()
                )));
            }
        }
        if self.convolutions.len() > MAX_LAYERS {
            return Err(Error::usage(format!(
                "network.convolutions: {} layers; expected at most {MAX_LAYERS}",
                self.convolutions.len()
            )));
        }
        for layer in &self.convolutions {
            let odd = layer.width % 2 == 1 && layer.width <= MAX_UNITS;
            if !(units(&layer.channels) && odd && units(&layer.stride)) {
                return Err(Error::usage(format!(
                    "network.convolutions: {} channels, {} wide, stride {}; expected 1 to {MAX_UNITS} of each, an odd width",
                    layer.channels, layer.width, layer.stride
                )));
            }
        }
        if !(self.gain.is_finite() && self.gain > 0.0) {
            return Err(Error::usage(format!(
                "network.gain = {}: expected a positive number",
                self.gain
            )));
        }
        Ok(())
    }

    /// The layers of convolutions that inputs of this shape get.
    pub fn convolutions(&self, inputs: InputShape) -> Vec<Convolution> {
        let Some(scan) = inputs.scan else {
            return Vec::new();
        };
        let (mut numbers, mut positions) = (scan.statistics, scan.sectors);
        let layer = |config: &ConvolutionConfig| {
            let layer = Convolution {
                inputs: numbers,
                positions,
                outputs: config.channels,
                width: config.width,
                stride: config.stride,
                ring: scan.ring,
            };
            (numbers, positions) = (layer.outputs, layer.positions_out());
            layer
        };
        self.convolutions.iter().map(layer).collect()
    }

    /// How many layers all networks share, of inputs of this shape: convolutions, or dense layers, and trunk.
    pub fn shared_layers(&self, inputs: InputShape) -> usize {
        self.convolutions(inputs).len() + self.dense(inputs).len() + self.trunk.len()
    }

    /// Units of the dense layers that inputs of this shape get.
    fn dense(&self, inputs: InputShape) -> &[usize] {
        match inputs.scan {
            Some(_) => &[],
            None => &self.dense,
        }
    }

    /// Shapes of all layers, `[networks, inputs, outputs]`: those that are shared, with one network, come first. A layer of
    /// convolutions has the shape of what it does in one direction.
    pub fn shapes(&self, inputs: InputShape, features: usize) -> Vec<[usize; 3]> {
        let mut shapes = Vec::new();
        let mut width = inputs.width;
        for layer in self.convolutions(inputs) {
            shapes.push([1, layer.width * layer.inputs, layer.outputs]);
            width = layer.positions_out() * layer.outputs;
        }
        let shared = self.dense(inputs).iter().chain(&self.trunk);
        let shared = shared.map(|&units| (1, units));
        let own = self
            .hidden
            .iter()
            .chain(&[1])
            .map(|&units| (features, units));
        for (networks, units) in shared.chain(own) {
            shapes.push([networks, width, units]);
            width = units;
        }
        shapes
    }
}
