//! The same steps as [`Descent`] takes on tensors, on plain arrays and in place.

use super::{Descent, MOMENTUM, Memory};
use crate::{
    detector::net::{Nets, Weights, values},
    error::{Error, Result},
    learning::recipe::{DescentConfig, Optimiser},
};
use burn::tensor::{Tensor, TensorData};

/// Adam's constants (Kingma & Ba 2015, algorithm 1).
const BETA: [f32; 2] = [0.9, 0.999];
const EPSILON: f32 = 1e-8;

/// A rule for steps, and every parameter's memory as numbers in row order.
///
/// ```
/// use ballmark::{detector::net::{NetConfig, Weights}, learning::{optimiser::InPlace, recipe::DescentConfig}, seed::Seed};
///
/// let mut weights = Weights::random(&NetConfig::thrun1998(), 3, 2, &mut Seed(1).stream("doc"));
/// let gradient = weights.clone(); // of E = Σ w²/2
/// let mut descent = InPlace::new(&DescentConfig::default());
/// descent.step(&mut weights, &gradient)?;
/// let length = |w: &Weights| w.layers[0].weight.iter().map(|w| w * w).sum::<f32>();
/// assert!(length(&weights) < length(&gradient));
/// # ballmark::Result::Ok(())
/// ```
#[derive(Debug, Clone)]
pub struct InPlace {
    config: DescentConfig,
    /// Steps taken so far.
    pub steps: usize,
    /// Of every parameter, weights of all layers before biases of all layers: both moments, or the last step and nothing.
    memory: Vec<[Vec<f32>; 2]>,
}

impl InPlace {
    /// Before the first step.
    pub fn new(config: &DescentConfig) -> Self {
        Self {
            config: config.clone(),
            steps: 0,
            memory: Vec::new(),
        }
    }

    /// Goes on from where a descent on tensors stands.
    ///
    /// # Errors
    /// Where the device does not give its data back as f32.
    pub fn after(descent: &Descent) -> Result<Self> {
        let memory = |memory: &Memory| {
            Ok(match memory {
                Memory::Adam { first, second } => [values(first.clone())?, values(second.clone())?],
                Memory::Momentum { velocity } => [values(velocity.clone())?, Vec::new()],
                Memory::ConjugateGradient { .. } => return Err(line_searched()),
            })
        };
        Ok(Self {
            config: descent.config.clone(),
            steps: descent.steps,
            memory: descent.memory.iter().map(memory).collect::<Result<_>>()?,
        })
    }

    /// The same as a descent on tensors, of these networks, where they are.
    pub fn descent(&self, nets: &Nets) -> Descent {
        let parameters = nets.weight.iter().chain(&nets.bias);
        let memory = parameters.zip(&self.memory).map(|(parameter, memory)| {
            let tensor = |values: &Vec<f32>| {
                let data = TensorData::new(values.clone(), parameter.dims());
                Tensor::from_data(data, &parameter.device())
            };
            match self.config.optimiser {
                Optimiser::Adam => Memory::Adam {
                    first: tensor(&memory[0]),
                    second: tensor(&memory[1]),
                },
                // There is no memory of conjugate gradients here: no step of theirs was taken.
                Optimiser::Momentum | Optimiser::ConjugateGradient => Memory::Momentum {
                    velocity: tensor(&memory[0]),
                },
            }
        });
        Descent {
            steps: self.steps,
            memory: memory.collect(),
            ..Descent::new(&self.config)
        }
    }

    /// Moves all parameters one step down their gradients.
    ///
    /// # Errors
    /// Where the gradient has another shape than the weights, or than those of earlier steps, or the rule is not Adam or
    /// momentum.
    pub fn step(&mut self, weights: &mut Weights, gradient: &Weights) -> Result<()> {
        let parameters = parameters_mut(weights)?;
        let gradients = parameters_of(gradient)?;
        if self.memory.is_empty() {
            let second = self.config.optimiser == Optimiser::Adam;
            let zeros = |g: &&[f32]| [vec![0.0; g.len()], vec![0.0; g.len() * usize::from(second)]];
            self.memory = gradients.iter().map(zeros).collect();
        }
        let lengths = gradients.iter().map(|g| g.len());
        if !lengths.clone().eq(parameters.iter().map(|w| w.len()))
            || !lengths.eq(self.memory.iter().map(|memory| memory[0].len()))
        {
            return Err(Error::work(
                "descent: weights, gradient and memory differ in shape; expected those of the same networks",
            ));
        }
        let rate = self.config.rate_at(self.steps);
        let shrink = (1.0 - rate * self.config.weight_decay) as f32;
        for ((w, g), [first, second]) in parameters.into_iter().zip(gradients).zip(&mut self.memory)
        {
            w.iter_mut().for_each(|w| *w *= shrink);
            match self.config.optimiser {
                Optimiser::Adam => adam(rate as f32, self.steps + 1, w, g, first, second),
                Optimiser::Momentum => momentum(rate as f32, w, g, first),
                Optimiser::ConjugateGradient => return Err(line_searched()),
            }
        }
        self.steps += 1;
        Ok(())
    }
}

/// w ← w − rate m̂/(√v̂ + ε), with the two corrections for the start of `time` drawn into factors (Kingma & Ba 2015, section 2).
fn adam(rate: f32, time: usize, w: &mut [f32], g: &[f32], first: &mut [f32], second: &mut [f32]) {
    let time = i32::try_from(time).unwrap_or(i32::MAX);
    let root = (1.0 - BETA[1].powi(time)).sqrt();
    let factor = root / (1.0 - BETA[0].powi(time));
    let epsilon = EPSILON * root;
    let memory = first.iter_mut().zip(second);
    for ((w, &g), (m, v)) in w.iter_mut().zip(g).zip(memory) {
        *m = *m * BETA[0] + g * (1.0 - BETA[0]);
        *v = *v * BETA[1] + g * g * (1.0 - BETA[1]);
        *w -= *m * factor / (v.sqrt() + epsilon) * rate;
    }
}

/// w ← w + 0.9 · last step − rate · gradient (Thrun 1998, 5.1.4).
fn momentum(rate: f32, w: &mut [f32], g: &[f32], velocity: &mut [f32]) {
    for ((w, &g), velocity) in w.iter_mut().zip(g).zip(velocity) {
        *velocity = *velocity * MOMENTUM as f32 - g * rate;
        *w += *velocity;
    }
}

fn line_searched() -> Error {
    Error::work("descent: conjugate gradients search along a line; expected Adam or momentum")
}

const SCATTERED: &str = "descent: weights scattered in memory; expected them in row order";

fn parameters_mut(weights: &mut Weights) -> Result<Vec<&mut [f32]>> {
    let (weight, bias): (Vec<_>, Vec<_>) = weights
        .layers
        .iter_mut()
        .map(|layer| (layer.weight.as_slice_mut(), layer.bias.as_slice_mut()))
        .unzip();
    let all: Option<Vec<_>> = weight.into_iter().chain(bias).collect();
    all.ok_or_else(|| Error::work(SCATTERED))
}

fn parameters_of(weights: &Weights) -> Result<Vec<&[f32]>> {
    let weight = weights.layers.iter().map(|layer| layer.weight.as_slice());
    let bias = weights.layers.iter().map(|layer| layer.bias.as_slice());
    let all: Option<Vec<_>> = weight.chain(bias).collect();
    all.ok_or_else(|| Error::work(SCATTERED))
}

#[cfg(test)]
mod tests;
