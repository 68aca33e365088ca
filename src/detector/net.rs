//! The learned detector: n small networks, one a feature, as stochastic filters (Thrun 1998, 4.1–4.2, 5.1.4).
//!
//! Thrun's networks share nothing but their inputs. Wide codes of dozens of features may stand on a common *trunk* of
//! layers instead, with a small network of its own for each feature on top.

use super::{Detector, input::Input};
use crate::{
    error::{Error, Result},
    recording::Channel,
    seed::Stream,
};
use burn::tensor::{Device, Tensor, TensorData, activation};
use ndarray::{Array2, Array3, ArrayView2};
use rand::RngExt;
use serde::{Deserialize, Serialize};

/// The shape of the networks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetConfig {
    /// Units of every layer that all networks share; none: each network sees the inputs themselves.
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

impl Default for NetConfig {
    /// A trunk of two layers of rectified units, and on it one sigmoid unit a feature.
    fn default() -> Self {
        Self {
            trunk: vec![256, 128],
            hidden: Vec::new(),
            activation: Activation::Relu,
            gain: 4.0,
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
            trunk: Vec::new(),
            hidden: vec![6],
            activation: Activation::Sigmoid,
            gain: 1.0,
        }
    }

    /// # Errors
    /// Where a layer has no units or too many, or there are too many layers.
    pub fn check(&self) -> Result<()> {
        let units = |&units: &usize| (1..=MAX_UNITS).contains(&units);
        for (key, layers) in [("trunk", &self.trunk), ("hidden", &self.hidden)] {
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
        if !(self.gain.is_finite() && self.gain > 0.0) {
            return Err(Error::usage(format!(
                "network.gain = {}: expected a positive number",
                self.gain
            )));
        }
        Ok(())
    }

    /// Shapes of all layers, `[networks, inputs, outputs]`: those of the trunk, with one network, come first.
    pub fn shapes(&self, inputs: usize, features: usize) -> Vec<[usize; 3]> {
        let mut shapes = Vec::new();
        let mut width = inputs;
        let shared = self.trunk.iter().map(|&units| (1, units));
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

/// Weights of all networks as plain arrays: what a model file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// From inputs to outputs; those of the trunk have one network only.
    pub layers: Vec<Layer>,
    /// How many of the layers, counted from the inputs, are the trunk.
    pub trunk: usize,
    /// Of the hidden units.
    pub activation: Activation,
}

/// One layer of all networks.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// `[filter, input, output]`.
    pub weight: Array3<f32>,
    /// `[filter, output]`.
    pub bias: Array2<f32>,
}

impl Weights {
    /// Small random weights, uniform in ±1/√inputs of the layer, from a seeded stream; biases likewise.
    pub fn random(config: &NetConfig, inputs: usize, features: usize, random: &mut Stream) -> Self {
        let mut layer = |[networks, inputs, outputs]: [usize; 3]| {
            let reach = 1.0 / (inputs as f32).sqrt();
            let mut draw = || random.random_range(-reach..=reach);
            Layer {
                weight: Array3::from_shape_simple_fn((networks, inputs, outputs), &mut draw),
                bias: Array2::from_shape_simple_fn((networks, outputs), &mut draw),
            }
        };
        Self {
            layers: config
                .shapes(inputs, features)
                .into_iter()
                .map(&mut layer)
                .collect(),
            trunk: config.trunk.len(),
            activation: config.activation,
        }
    }

    /// Number n of networks.
    pub fn features(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.bias.nrows())
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.weight.dim().1)
    }
}

/// The networks as Burn tensors on a device: weights `[filter, input, output]`, biases `[filter, 1, output]`; a layer of
/// the trunk is a layer of one filter.
#[derive(Debug, Clone)]
pub struct Nets {
    /// One a layer.
    pub weight: Vec<Tensor<3>>,
    /// One a layer.
    pub bias: Vec<Tensor<3>>,
    /// How many of the layers, counted from the inputs, are the trunk.
    pub trunk: usize,
    /// Of the hidden units.
    pub activation: Activation,
    /// What output units multiply their sum by.
    pub gain: f32,
}

impl Nets {
    /// Puts weights on a device.
    pub fn new(weights: &Weights, device: &Device) -> Self {
        let tensor = |shape: [usize; 3], values: Vec<f32>| {
            Tensor::from_data(TensorData::new(values, shape), device)
        };
        let (mut weight, mut bias) = (Vec::new(), Vec::new());
        for layer in &weights.layers {
            let (n, inputs, outputs) = layer.weight.dim();
            weight.push(tensor(
                [n, inputs, outputs],
                layer.weight.iter().copied().collect(),
            ));
            bias.push(tensor(
                [n, 1, outputs],
                layer.bias.iter().copied().collect(),
            ));
        }
        Self {
            weight,
            bias,
            trunk: weights.trunk,
            activation: weights.activation,
            gain: 1.0,
        }
    }

    /// Takes the weights back from the device, the gain as part of the last layer's.
    ///
    /// # Errors
    /// Where the device does not give its data back as f32.
    pub fn weights(&self) -> Result<Weights> {
        let mut layers = Vec::new();
        for (weight, bias) in self.weight.iter().zip(&self.bias) {
            let [n, inputs, outputs] = weight.dims();
            layers.push(Layer {
                weight: array3([n, inputs, outputs], values(weight.clone())?)?,
                bias: array3([n, 1, outputs], values(bias.clone())?)?.remove_axis(ndarray::Axis(1)),
            });
        }
        if let Some(last) = layers.last_mut() {
            last.weight *= self.gain;
            last.bias *= self.gain;
        }
        Ok(Weights {
            layers,
            trunk: self.trunk,
            activation: self.activation,
        })
    }

    /// g_i(s) of every snapshot: `[snapshot, input]` → `[snapshot, feature]`.
    pub fn forward(&self, input: Tensor<2>) -> Tensor<2> {
        let mut input = input;
        let (trunk, own) = self.weight.split_at(self.trunk);
        let (trunk_bias, own_bias) = self.bias.split_at(self.trunk);
        for (weight, bias) in trunk.iter().zip(trunk_bias) {
            let sum = input.matmul(weight.clone().squeeze_dim(0)) + bias.clone().squeeze_dim(0);
            input = self.activate(sum);
        }
        let [k, inputs] = input.dims();
        let [n, _, first] = own[0].dims();
        // All first layers at once: [snapshot, input] × [input, filter·unit].
        let stacked = own[0]
            .clone()
            .permute([1, 0, 2])
            .reshape([inputs, n * first]);
        let sum = input.matmul(stacked) + own_bias[0].clone().reshape([1, n * first]);
        if own.len() == 1 {
            return self.answer(sum); // one unit a feature
        }
        let mut sum = sum.reshape([k, n, first]).permute([1, 0, 2]); // [filter, snapshot, unit]
        for (weight, bias) in own.iter().zip(own_bias).skip(1) {
            sum = self.activate(sum).matmul(weight.clone()) + bias.clone();
        }
        self.answer(sum).permute([1, 0, 2]).reshape([k, n])
    }

    fn answer<const D: usize>(&self, sum: Tensor<D>) -> Tensor<D> {
        if self.gain == 1.0 {
            return activation::sigmoid(sum);
        }
        activation::sigmoid(sum.mul_scalar(self.gain))
    }

    fn activate<const D: usize>(&self, sum: Tensor<D>) -> Tensor<D> {
        match self.activation {
            Activation::Sigmoid => activation::sigmoid(sum),
            Activation::Tanh => activation::tanh(sum),
            Activation::Relu => activation::relu(sum),
        }
    }
}

/// The values of a tensor in row order.
///
/// # Errors
/// Where the device failed in its work, or holds other numbers than f32.
pub fn values<const D: usize>(tensor: Tensor<D>) -> Result<Vec<f32>> {
    tensor
        .try_into_data()
        .map_err(|e| Error::work(format!("the device failed: {e}")))?
        .try_to_vec::<f32>()
        .map_err(|e| Error::work(format!("the device's numbers are not f32: {e:?}")))
}

fn array3(shape: [usize; 3], values: Vec<f32>) -> Result<Array3<f32>> {
    Array3::from_shape_vec(shape, values)
        .map_err(|e| Error::work(format!("a tensor of unexpected size: {e}")))
}

/// The learned detector: preprocessing and networks together.
pub struct NetDetector {
    input: Input,
    nets: Nets,
    features: usize,
    device: Device,
}

impl NetDetector {
    /// A detector on a device.
    pub fn new(input: Input, weights: &Weights, device: &Device) -> Self {
        Self {
            input,
            nets: Nets::new(weights, device),
            features: weights.features(),
            device: device.clone(),
        }
    }

    /// g_i of normalised inputs, `[snapshot, input]` → `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where the device fails to give its numbers back.
    pub fn respond(&self, input: ArrayView2<f32>) -> Result<Array2<f32>> {
        let shape = [input.nrows(), input.ncols()];
        let data = TensorData::new(input.iter().copied().collect::<Vec<f32>>(), shape);
        let out = values(self.nets.forward(Tensor::from_data(data, &self.device)))?;
        Array2::from_shape_vec((shape[0], self.features), out)
            .map_err(|e| Error::work(format!("network output: {e}")))
    }
}

impl Detector for NetDetector {
    fn features(&self) -> usize {
        self.features
    }

    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        self.respond(self.input.transform_values(channels, values)?.view())
    }
}
