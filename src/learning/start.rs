//! Networks that a training begins with, in place of random ones: pre-trained on other buildings.

use super::recipe::Recipe;
use crate::{
    detector::{
        input::Input,
        net::{Layer, Weights},
    },
    error::{Error, Result},
    geometry::wrapped,
    recording::Channel,
};

/// Views that differ by less than this are one, in radians: 180° in 181 beams, or in 360.
const SAME_VIEW_RAD: f64 = 0.1;

/// Networks that have learned already, and what they are fed.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// How readings became inputs; its constants stay.
    pub input: Input,
    /// The networks, the gain within the last layer.
    pub weights: Weights,
    /// The sensors that they learned with.
    pub channels: Vec<Channel>,
}

impl Start {
    /// The inputs of a recording as these networks are used to them: `fitted`, with the constants that they learned with.
    ///
    /// # Errors
    /// Where the sensors don't fit: another view, other sectors, or more than one sensor.
    pub fn input_for(&self, fitted: Input, channels: &[Channel]) -> Result<Input> {
        let (own, other) = (self.input.shape(), fitted.shape());
        if own != other || own.scan.is_none() {
            return Err(Error::work(format!(
                "the pre-trained networks work from {}, these sensors give {}; expected the sectors of one range sensor of the \
                 same kind",
                self.input.describe(),
                fitted.describe()
            )));
        }
        let view = |input: &Input, channels: &[Channel]| {
            let name = input.channel_names().next().map(String::from);
            channels
                .iter()
                .find(|channel| Some(&channel.name) == name.as_ref())
                .and_then(view_rad)
        };
        match (view(&self.input, &self.channels), view(&fitted, channels)) {
            (Some(own), Some(other)) if (own - other).abs() < SAME_VIEW_RAD => {
                Ok(fitted.with_constants_of(&self.input))
            }
            (own, other) => {
                let degrees = |view: Option<f64>| match view {
                    Some(rad) => format!("{:.0}°", rad.to_degrees()),
                    None => "an unknown angle".to_string(),
                };
                Err(Error::work(format!(
                    "the pre-trained networks see {}, this sensor {}; expected the same from the first beam to the last",
                    degrees(own),
                    degrees(other)
                )))
            }
        }
    }

    /// The weights that a recipe begins with: all of them, or where it has another number of features those that are shared,
    /// with `random` ones on top.
    ///
    /// # Errors
    /// Where the recipe's networks have another shape.
    pub fn weights_for(&self, recipe: &Recipe, mut random: Weights) -> Result<Weights> {
        let same = |(own, other): (&Layer, &Layer)| own.weight.dim() == other.weight.dim();
        let shared = random.trunk;
        let fits = self.weights.trunk == shared
            && self.weights.convolutions == random.convolutions
            && self.weights.activation == random.activation
            && self.weights.layers.len() == random.layers.len()
            && self.weights.layers[..shared]
                .iter()
                .zip(&random.layers)
                .all(same);
        if !fits {
            return Err(Error::work(
                "the pre-trained networks have other layers than the recipe (network); expected the same",
            ));
        }
        let whole = self.weights.layers.iter().zip(&random.layers).all(same);
        let kept = if whole { random.layers.len() } else { shared };
        random.layers[..kept].clone_from_slice(&self.weights.layers[..kept]);
        if whole && let Some(last) = random.layers.last_mut() {
            last.weight /= recipe.network.gain; // training multiplies by it
            last.bias /= recipe.network.gain;
        }
        Ok(random)
    }
}

/// From the first beam to the last, in radians.
fn view_rad(channel: &Channel) -> Option<f64> {
    let bearing_rad = channel.bearing_rad.as_ref()?;
    let steps = bearing_rad.windows(2).map(|w| wrapped(w[1] - w[0]));
    Some(steps.sum())
}

#[cfg(test)]
mod tests;
