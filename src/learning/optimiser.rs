//! One step down the gradient, with a state that can be saved and restored to the bit.

mod in_place;

pub use in_place::InPlace;

use super::{
    line_search::line_search,
    recipe::{DescentConfig, Optimiser},
};
use crate::{detector::net::values, error::Result};
use burn::tensor::Tensor;
use burn_optim::{Adam, AdamConfig, AdamState, AdaptiveMomentumState, Optimizer};

/// Share of the last step that momentum descent keeps (Thrun 1998, 5.1.4).
const MOMENTUM: f64 = 0.9;

/// Farthest that one line may take all parameters together: a third of what networks of small random weights measure. From
/// their plateau at the start, the lowest place along the first line is far off, where the units are saturated and there
/// is no slope left to follow.
const FARTHEST: f64 = 1.0;

/// The state that a parameter keeps of its past gradients.
#[derive(Debug, Clone)]
pub enum Memory {
    /// First and second moment.
    Adam {
        /// Mean gradient.
        first: Tensor<3>,
        /// Mean squared gradient.
        second: Tensor<3>,
    },
    /// The last step.
    Momentum {
        /// In units of the parameter.
        velocity: Tensor<3>,
    },
    /// Where the last line ran, and from where.
    ConjugateGradient {
        /// Gradient at the start of the last line.
        gradient: Tensor<3>,
        /// The line's direction; zero where nothing better was found along it.
        direction: Tensor<3>,
    },
}

/// A rule for steps, and every parameter's memory.
pub struct Descent {
    config: DescentConfig,
    adam: Adam,
    /// Steps taken so far.
    pub steps: usize,
    /// One a parameter, in the order they are stepped; none before the first step.
    pub memory: Vec<Memory>,
    /// How far the error would have fallen on the last line, had it been straight: the next search begins where its own
    /// slope promises as much. 0: none yet.
    pub promised: f64,
}

impl Descent {
    /// Before the first step.
    pub fn new(config: &DescentConfig) -> Self {
        let adam = AdamConfig::new().with_epsilon(1e-8).build();
        Self {
            config: config.clone(),
            adam,
            steps: 0,
            memory: Vec::new(),
            promised: 0.0,
        }
    }

    /// Forgets past gradients: what comes is another error, or has other parameters.
    pub fn forget(&mut self) {
        self.memory.clear();
    }

    /// Moves all parameters one step down their gradients, by a length that the configuration gives: Adam and momentum.
    pub fn step(
        &mut self,
        parameters: Vec<Tensor<3>>,
        gradients: Vec<Tensor<3>>,
    ) -> Vec<Tensor<3>> {
        let rate = self.config.rate_at(self.steps);
        let mut memories = std::mem::take(&mut self.memory).into_iter();
        let mut moved = Vec::with_capacity(parameters.len());
        for (parameter, gradient) in parameters.into_iter().zip(gradients) {
            let shrink = 1.0 - rate * self.config.weight_decay;
            let (next, memory) = self.move_one(
                parameter.mul_scalar(shrink),
                gradient,
                memories.next(),
                rate,
            );
            moved.push(next);
            self.memory.push(memory);
        }
        self.steps += 1;
        moved
    }

    fn move_one(
        &self,
        w: Tensor<3>,
        gradient: Tensor<3>,
        memory: Option<Memory>,
        rate: f64,
    ) -> (Tensor<3>, Memory) {
        match (self.config.optimiser, memory) {
            (Optimiser::Adam, memory) => {
                let state = match memory {
                    Some(Memory::Adam { first, second }) => Some(AdamState::new(
                        AdaptiveMomentumState::new(self.steps, first, second),
                    )),
                    _ => None,
                };
                let zeros = gradient.zeros_like();
                let (w, state) = self.adam.step(rate, w, gradient, state);
                let (first, second) = match state {
                    Some(state) => (state.momentum.moment_1, state.momentum.moment_2),
                    None => (zeros.clone(), zeros),
                };
                (w, Memory::Adam { first, second })
            }
            (_, Some(Memory::Momentum { velocity })) => {
                let velocity = velocity.mul_scalar(MOMENTUM) - gradient.mul_scalar(rate);
                (w + velocity.clone(), Memory::Momentum { velocity })
            }
            (_, _) => {
                let velocity = gradient.mul_scalar(-rate);
                (w + velocity.clone(), Memory::Momentum { velocity })
            }
        }
    }

    /// Moves all parameters to the lowest place that is found along a direction conjugate to the last one, by Polak and
    /// Ribière's rule: with γ the gradient and δ the direction, δ ← −γ + β δ, β = γ·(γ − γ_last) / γ_last·γ_last, and no
    /// less than 0, so that a search that has lost its way starts again straight down.
    ///
    /// `error` is the error at the parameters, `error_at` that at others. Where nothing lower is found, they stay.
    ///
    /// # Errors
    /// Where `error_at` has one, or the device does not give its data back.
    pub fn step_along_a_line(
        &mut self,
        parameters: &[Tensor<3>],
        gradients: &[Tensor<3>],
        error: f64,
        error_at: &mut dyn FnMut(Vec<Tensor<3>>) -> Result<f64>,
    ) -> Result<Vec<Tensor<3>>> {
        let squares = dot(gradients, gradients)?;
        let mut direction: Vec<Tensor<3>> = gradients.iter().map(|g| g.clone().neg()).collect();
        let mut slope = -squares;
        let (last_gradient, last_direction) = self.last_line();
        if !last_gradient.is_empty() {
            let last_squares = dot(&last_gradient, &last_gradient)?;
            let change = squares - dot(gradients, &last_gradient)?;
            let beta = match last_squares > 0.0 {
                true => (change / last_squares).max(0.0),
                false => 0.0,
            };
            let conjugate: Vec<Tensor<3>> = direction
                .iter()
                .zip(last_direction)
                .map(|(down, last)| down.clone() + last.mul_scalar(beta))
                .collect();
            let along = dot(gradients, &conjugate)?;
            if along < 0.0 {
                (direction, slope) = (conjugate, along);
            }
        }
        let moved = |length: f64| -> Vec<Tensor<3>> {
            let both = parameters.iter().zip(&direction);
            both.map(|(w, d)| w.clone() + d.clone().mul_scalar(length))
                .collect()
        };
        let first = match self.promised > 0.0 {
            true => self.promised / -slope,
            false => self.config.learning_rate,
        };
        let longest = FARTHEST / dot(&direction, &direction)?.sqrt();
        let found = match slope < 0.0 {
            true => line_search(error, slope, first, longest, |length| {
                error_at(moved(length))
            })?,
            false => None, // the gradient is zero
        };
        let next = match found {
            Some(length) => {
                self.promised = -slope * length;
                moved(length)
            }
            None => parameters.to_vec(),
        };
        let remembered = gradients.iter().zip(direction);
        self.memory = remembered
            .map(|(gradient, direction)| Memory::ConjugateGradient {
                gradient: gradient.clone(),
                direction: match found {
                    Some(_) => direction,
                    None => direction.zeros_like(),
                },
            })
            .collect();
        self.steps += 1;
        Ok(next)
    }

    /// Gradient and direction of the last line; nothing where there was none.
    fn last_line(&self) -> (Vec<Tensor<3>>, Vec<Tensor<3>>) {
        let lines = self.memory.iter().filter_map(|memory| match memory {
            Memory::ConjugateGradient {
                gradient,
                direction,
            } => Some((gradient.clone(), direction.clone())),
            _ => None,
        });
        lines.unzip()
    }
}

/// Σ a·b over all parameters, in f64 and in order.
fn dot(a: &[Tensor<3>], b: &[Tensor<3>]) -> Result<f64> {
    let mut sum = 0.0;
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (values(a.clone())?, values(b.clone())?);
        let products = a.iter().zip(&b).map(|(&a, &b)| f64::from(a) * f64::from(b));
        sum += products.sum::<f64>();
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use burn::tensor::Device;

    /// A narrow valley, ½ (x² + 100 y²): straight down it takes a hundred lines, in conjugate directions two.
    #[test]
    fn conjugate_directions_cross_a_narrow_valley_at_once() {
        let device = Device::flex();
        let steepness = Tensor::<3>::from_data([[[1.0, 100.0]]], &device);
        let error = |at: &Tensor<3>| -> Result<f64> {
            let squares = at.clone() * at.clone() * steepness.clone();
            Ok(0.5 * values(squares)?.iter().map(|&x| f64::from(x)).sum::<f64>())
        };
        let mut descent = Descent::new(&DescentConfig {
            optimiser: Optimiser::ConjugateGradient,
            learning_rate: 1e-3,
            ..DescentConfig::default()
        });
        let mut at = vec![Tensor::<3>::from_data([[[0.9, 0.009]]], &device)];
        for _ in 0..4 {
            let gradient = at[0].clone() * steepness.clone();
            let before = error(&at[0]).unwrap();
            at = descent
                .step_along_a_line(&at, &[gradient], before, &mut |at| error(&at[0]))
                .unwrap();
            assert!(error(&at[0]).unwrap() <= before);
        }
        let left = error(&at[0]).unwrap();
        assert!(left < 1e-4, "{left}");
    }
}
