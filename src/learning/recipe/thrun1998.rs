//! The paper's own training as a recipe: what it says, and what had to be assumed.

use super::{
    AugmentationConfig, BeginWith, DescentConfig, ObjectiveKind, Optimiser, PriorMix, Recipe,
    Scale, Schedule,
};
use crate::{
    belief::{FilledFrom, MapConfig},
    detector::{input::InputConfig, net::NetConfig},
};

impl Recipe {
    /// What `--recipe thrun1998` stands for: the networks and the descent of Thrun (1998), 5.1.4 with 4.4.2 and note 3.
    ///
    /// As the paper has it: six hidden sigmoid units a network and nothing shared; the printed objective (eq. 42) over all
    /// snapshots with the stated uncertainty, no map in it; learning rate 1e-4, momentum 0.9; a hundred backpropagation
    /// steps on pseudo-patterns to every evaluation of the objective; nothing else done to weights or inputs.
    ///
    /// Where the paper is silent, this is assumed:
    ///
    /// - **What the rate multiplies.** P(ξ*) is called a likelihood of occurrence, but no value is given. It is 1 here: the
    ///   truths' errors are summed, in metres ([`Scale::Sum`]), as backpropagation sums over its patterns. With 1/K in its
    ///   place the printed rate moves nothing in the printed number of iterations.
    /// - **What an iteration is.** 4.4.2 counts "gradient descent iterations" and calls pseudo-patterns an approximation
    ///   of these: the 10,000 of note 3 are backpropagation steps here, and evaluate the objective 100 times. Momentum runs
    ///   on from one evaluation to the next.
    /// - **How momentum and conjugate gradients, both named, go together.** They don't: one has a given rate, the other
    ///   searches for it. This is momentum; `optimiser = "conjugate_gradient"` is the other.
    /// - **How small** the random weights are: uniform in ±1/√inputs of their layer, biases too.
    /// - **When to stop.** Note 3 saw no over-fitting and trained on. A validation part is kept back nevertheless, as 4.3
    ///   has it and as with every recipe here, and the weights that do best on it are the ones kept: without it
    ///   (`split.validation_every = 0`), the last ones are.
    ///
    /// ```
    /// let recipe = ballmark::learning::Recipe::thrun1998();
    /// assert!(recipe.check().is_ok());
    /// assert_eq!(recipe.network.hidden, [6]);
    /// assert_eq!(recipe.descent.steps / recipe.descent.pseudo_pattern_steps, 100); // evaluations of the objective
    /// ```
    pub fn thrun1998() -> Self {
        Self {
            begin_with: BeginWith::Random,
            input: InputConfig {
                history_m: Some(Vec::new()),
                ..InputConfig::default()
            },
            network: NetConfig::thrun1998(),
            descent: DescentConfig {
                objective: ObjectiveKind::Exact,
                optimiser: Optimiser::Momentum,
                scale: Scale::Sum,
                learning_rate: 1e-4,
                pseudo_pattern_steps: 100,
                sequential: false,
                schedule: Schedule::Constant,
                weight_decay: 0.0,
                gradient_limit: 0.0,
                steps: 10_000,
                truths_per_step: 0,
                candidates_per_step: 0,
                patience: 10_000,
                cross_entropy: 0.0,
                map_in_objective: false,
                ..DescentConfig::default()
            },
            augmentation: AugmentationConfig {
                input_noise: 0.0,
                shift_m: 0.0,
                turn_rad: 0.0,
                dropped_beams: 0.0,
                people: Some(0.0),
            },
            priors: PriorMix {
                stated: Some(1.0),
                ..PriorMix::default()
            },
            map: MapConfig {
                filled_from: FilledFrom::Visits,
                most_places: 0,
                ..MapConfig::default()
            },
            ..Self::default()
        }
    }
}
