//! The learned detector: n small networks, one a feature, as stochastic filters (Thrun 1998, 4.1–4.2, 5.1.4).

use super::{Detector, input::Input};
use crate::{
    error::{Error, Result},
    recording::Recording,
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
    /// Units of every hidden layer of every network; none: a single sigmoid unit a feature.
    pub hidden: Vec<usize>,
    /// What hidden units do with their sum.
    pub activation: Activation,
}

/// Activation function of hidden units; outputs are always sigmoid, as probabilities must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Activation {
    /// 1/(1 + e^−x), as in Thrun (1998), 5.1.4.
    Sigmoid,
    /// Hyperbolic tangent.
    Tanh,
    /// max(0, x).
    Relu,
}

impl Default for NetConfig {
    /// Six hidden sigmoid units (Thrun 1998, 5.1.4).
    fn default() -> Self {
        Self {
            hidden: vec![6],
            activation: Activation::Sigmoid,
        }
    }
}

/// Most units of a hidden layer, and most hidden layers: far beyond what is trained full-batch, and small enough that a
/// slip of the keyboard does not ask for all the memory there is.
const MOST_UNITS: usize = 10_000;
const MOST_LAYERS: usize = 16;

impl NetConfig {
    /// # Errors
    /// Where a layer has no units or too many, or there are too many layers.
    pub fn check(&self) -> Result<()> {
        let units = |&units: &usize| (1..=MOST_UNITS).contains(&units);
        if let Some(wrong) = self.hidden.iter().find(|&n| !units(n)) {
            return Err(Error::usage(format!(
                "network.hidden: a layer of {wrong} units; expected 1 to {MOST_UNITS}"
            )));
        }
        if self.hidden.len() > MOST_LAYERS {
            return Err(Error::usage(format!(
                "network.hidden: {} layers; expected at most {MOST_LAYERS}",
                self.hidden.len()
            )));
        }
        Ok(())
    }
}

/// Weights of all networks as plain arrays: what a model file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// From inputs to outputs.
    pub layers: Vec<Layer>,
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
        let mut widths = vec![inputs];
        widths.extend(&config.hidden);
        widths.push(1);
        let layers = widths
            .windows(2)
            .map(|pair| {
                let reach = 1.0 / (pair[0] as f32).sqrt();
                let mut draw = || random.random_range(-reach..=reach);
                Layer {
                    weight: Array3::from_shape_simple_fn((features, pair[0], pair[1]), &mut draw),
                    bias: Array2::from_shape_simple_fn((features, pair[1]), &mut draw),
                }
            })
            .collect();
        Self {
            layers,
            activation: config.activation,
        }
    }

    /// Number n of networks.
    pub fn features(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.bias.nrows())
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.layers.first().map_or(0, |layer| layer.weight.dim().1)
    }
}

/// The networks as Burn tensors on a device: weights `[filter, input, output]`, biases `[filter, 1, output]`.
#[derive(Debug, Clone)]
pub struct Nets {
    /// One a layer.
    pub weight: Vec<Tensor<3>>,
    /// One a layer.
    pub bias: Vec<Tensor<3>>,
    /// Of the hidden units.
    pub activation: Activation,
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
            activation: weights.activation,
        }
    }

    /// Takes the weights back from the device.
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
        Ok(Weights {
            layers,
            activation: self.activation,
        })
    }

    /// g_i(s) of every snapshot: `[snapshot, input]` → `[snapshot, feature]`.
    pub fn forward(&self, input: Tensor<2>) -> Tensor<2> {
        let [k, inputs] = input.dims();
        let [n, _, first] = self.weight[0].dims();
        // All first layers at once: [snapshot, input] × [input, filter·unit].
        let stacked = self.weight[0]
            .clone()
            .permute([1, 0, 2])
            .reshape([inputs, n * first]);
        let sum = input.matmul(stacked) + self.bias[0].clone().reshape([1, n * first]);
        let mut sum = sum.reshape([k, n, first]).permute([1, 0, 2]); // [filter, snapshot, unit]
        for (weight, bias) in self.weight.iter().zip(&self.bias).skip(1) {
            let hidden = match self.activation {
                Activation::Sigmoid => activation::sigmoid(sum),
                Activation::Tanh => activation::tanh(sum),
                Activation::Relu => activation::relu(sum),
            };
            sum = hidden.matmul(weight.clone()) + bias.clone();
        }
        activation::sigmoid(sum).permute([1, 0, 2]).reshape([k, n])
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

    fn probabilities(&self, recording: &Recording) -> Result<Array2<f32>> {
        self.respond(self.input.of(recording)?.view())
    }
}
