//! The networks as plain arrays.

use super::{
    config::{Activation, NetConfig},
    convolution::Convolution,
};
use crate::{detector::input::InputShape, seed::Stream};
use ndarray::{Array2, Array3};
use rand::RngExt;

/// Weights of all networks as plain arrays: what a model file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// From inputs to outputs; those that are shared have one network only.
    pub layers: Vec<Layer>,
    /// The first layers, where they are convolutions.
    pub convolutions: Vec<Convolution>,
    /// How many of the layers, counted from the inputs, are shared: convolutions and trunk.
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
    pub fn random(
        config: &NetConfig,
        inputs: impl Into<InputShape>,
        features: usize,
        random: &mut Stream,
    ) -> Self {
        let inputs = inputs.into();
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
            convolutions: config.convolutions(inputs),
            trunk: config.shared_layers(inputs),
            activation: config.activation,
        }
    }

    /// Number n of networks.
    pub fn features(&self) -> usize {
        self.layers.last().map_or(0, |layer| layer.bias.nrows())
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        match self.convolutions.first() {
            Some(first) => first.positions * first.inputs,
            None => self.layers.first().map_or(0, |layer| layer.weight.dim().1),
        }
    }
}
