//! One step down the gradient, with a state that can be written down and taken up again to the bit.

pub mod in_place;

use super::recipe::{DescentConfig, Optimiser};
use burn::{
    optim::{Adam, AdamConfig, AdamState, AdaptiveMomentumState, Optimizer},
    tensor::Tensor,
};

/// Share of the last step that momentum descent keeps (Thrun 1998, 5.1.4).
const MOMENTUM: f64 = 0.9;

/// What a parameter remembers of its past gradients.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "a handful of them exist, all of the same variant"
)]
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
}

/// A rule for steps, and every parameter's memory.
pub struct Descent {
    config: DescentConfig,
    adam: Adam,
    /// Steps taken so far.
    pub steps: usize,
    /// One a parameter, in the order they are stepped; none before the first step.
    pub memory: Vec<Memory>,
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
        }
    }

    /// Moves all parameters one step down their gradients.
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
            (Optimiser::Momentum, Some(Memory::Momentum { velocity })) => {
                let velocity = velocity.mul_scalar(MOMENTUM) - gradient.mul_scalar(rate);
                (w + velocity.clone(), Memory::Momentum { velocity })
            }
            (Optimiser::Momentum, _) => {
                let velocity = gradient.mul_scalar(-rate);
                (w + velocity.clone(), Memory::Momentum { velocity })
            }
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
        }
    }
}
