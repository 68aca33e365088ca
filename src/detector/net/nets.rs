//! The networks as tensors: what they answer, and what their weights are learned through.

use super::{
    config::Activation,
    convolution::Convolution,
    weights::{Layer, Weights},
};
use crate::error::{Error, Result};
use burn::tensor::{Device, Tensor, TensorData, activation};
use ndarray::Array3;

/// The networks as Burn tensors on a device: weights `[filter, input, output]`, biases `[filter, 1, output]`; a layer of
/// the trunk is a layer of one filter.
#[derive(Debug, Clone)]
pub struct Nets {
    /// One a layer.
    pub weight: Vec<Tensor<3>>,
    /// One a layer.
    pub bias: Vec<Tensor<3>>,
    /// The first layers, where they are convolutions.
    pub convolutions: Vec<Convolution>,
    /// How many of the layers, counted from the inputs, are shared: convolutions and trunk.
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
            convolutions: weights.convolutions.clone(),
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
            convolutions: self.convolutions.clone(),
            trunk: self.trunk,
            activation: self.activation,
        })
    }

    /// g_i(s) of every snapshot: `[snapshot, input]` → `[snapshot, feature]`.
    pub fn forward(&self, input: Tensor<2>) -> Tensor<2> {
        let mut input = self.convolve(input);
        let (trunk, own) = self.weight.split_at(self.trunk);
        let (trunk_bias, own_bias) = self.bias.split_at(self.trunk);
        let dense = self.convolutions.len();
        let (trunk, trunk_bias) = (&trunk[dense..], &trunk_bias[dense..]);
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

    /// What the convolutions find, `[snapshot, position · number]`; the inputs themselves where there are none.
    fn convolve(&self, input: Tensor<2>) -> Tensor<2> {
        let Some(first) = self.convolutions.first() else {
            return input;
        };
        let [snapshots, width] = input.dims();
        // Inputs are ordered by statistic, then by sector.
        let mut found = input
            .reshape([snapshots, first.inputs, first.positions])
            .swap_dims(1, 2);
        debug_assert_eq!(width, first.inputs * first.positions);
        let layers = self.weight.iter().zip(&self.bias);
        for (layer, (weight, bias)) in self.convolutions.iter().zip(layers) {
            found = self.activate(layer.forward(found, weight.clone(), bias.clone()));
        }
        let [_, positions, numbers] = found.dims();
        found.reshape([snapshots, positions * numbers])
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
