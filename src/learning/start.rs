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

/// Beams that a sensor must have to stand in for another.
const FEWEST_BEAMS: usize = 4;

/// Networks that have learned already, and what they are fed.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// How readings became inputs; its constants stay.
    pub input: Input,
    /// The networks, the gain within the last layer.
    pub weights: Weights,
    /// The sensors that they learned with.
    pub channels: Vec<Channel>,
    /// Is what is learned from of the same sensors, so that inputs are made just as they were?
    pub same_sensors: bool,
}

impl Start {
    /// The inputs of a recording as these networks are used to them: `fitted`, with the constants that they learned with.
    ///
    /// # Errors
    /// Where the sensors don't fit: another view, other sectors, or more than one sensor.
    pub fn input_for(&self, fitted: Input, channels: &[Channel]) -> Result<Input> {
        if self.same_sensors {
            return Ok(self.input.clone());
        }
        let (own, other) = (self.input.shape(), fitted.shape());
        let sensor = |input: &Input, channels: &[Channel]| {
            let mut names = input.channel_names();
            let (name, more) = (names.next(), names.next());
            let named = channels.iter().find(|c| Some(c.name.as_str()) == name);
            named.filter(|_| more.is_none()).cloned()
        };
        let (sees, looks) = (
            sensor(&self.input, &self.channels),
            sensor(&fitted, channels),
        );
        let views = [&sees, &looks].map(|sensor| sensor.as_ref().and_then(view_rad));
        if let [Some(sees), Some(looks)] = views
            && own == other
            && own.scan.is_some()
            && (sees - looks).abs() < SAME_VIEW_RAD
        {
            return Ok(fitted.with_constants_of(&self.input));
        }
        // A sensor of fewer beams, or one whose view is blocked in part.
        if let ([Some(sees), Some(narrower)], Some(looks)) = (views, &looks)
            && looks.width >= FEWEST_BEAMS
            && narrower.abs() < sees.abs() + SAME_VIEW_RAD
            && let Some(input) = self.input.looked_into_by(&self.channels, looks)
        {
            return Ok(input);
        }
        let degrees = |view: Option<f64>| match view {
            Some(rad) => format!("over {:.0}°", rad.abs().to_degrees()),
            None => "in unknown directions".to_string(),
        };
        Err(Error::work(format!(
            "the pre-trained networks work from {} {}, these sensors give {} {}; expected one range sensor of at least \
             {FEWEST_BEAMS} beams that looks into most of that view and no farther round",
            self.input.describe(),
            degrees(views[0]),
            fitted.describe(),
            degrees(views[1]),
        )))
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
