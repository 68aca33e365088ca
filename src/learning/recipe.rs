//! What is trained how, as data: the resolved form of a training configuration.

use crate::{
    belief::{MapConfig, Uncertainty},
    detector::{input::InputConfig, net::NetConfig},
    error::{Error, Result},
    learning::objective::MOST_FEATURES,
    recording::split::SplitConfig,
};
use serde::{Deserialize, Serialize};

/// Everything that decides a training besides the data. A model file keeps it whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recipe {
    /// The one seed of the run.
    pub seed: u64,
    /// Prior uncertainty that the filters are trained for.
    pub uncertainty: Uncertainty,
    /// Number n of filters.
    pub features: usize,
    /// What the networks are fed.
    pub input: InputConfig,
    /// Their shape.
    pub network: NetConfig,
    /// How their weights descend.
    pub descent: DescentConfig,
    /// How P(f|ξ) is read off the training part.
    pub map: MapConfig,
    /// What training sees, what stops it, and what neither sees.
    pub split: SplitConfig,
}

/// How the weights descend E_posterior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescentConfig {
    /// Rule for a step.
    pub optimiser: Optimiser,
    /// Length of a step, on the objective divided by the prior error.
    pub learning_rate: f64,
    /// Share of its length that every weight loses a step, times the learning rate.
    pub weight_decay: f64,
    /// Most steps; every step sees all training snapshots.
    pub steps: usize,
    /// Steps between two looks at the validation part.
    pub validate_every: usize,
    /// Stop after this many steps without a better validation error.
    pub patience: usize,
    /// Steps between two checkpoints.
    pub checkpoint_every: usize,
    /// Noise added to the normalised inputs in every step (standard deviation).
    pub input_noise: f64,
    /// Smooth the features into a map inside the objective, as localisation will.
    pub map_in_objective: bool,
}

/// A rule for taking a step down a gradient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Optimiser {
    /// Adam (Kingma & Ba 2015), β = (0.9, 0.999).
    Adam,
    /// Gradient descent with momentum 0.9 (Thrun 1998, 5.1.4).
    Momentum,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            seed: 1,
            uncertainty: Uncertainty::Window {
                half_width_m: 2.0,
                half_turn_rad: Some(crate::belief::prior::DEFAULT_HALF_TURN_RAD),
            },
            features: 4,
            input: InputConfig::default(),
            network: NetConfig::default(),
            descent: DescentConfig::default(),
            map: MapConfig::default(),
            split: SplitConfig::default(),
        }
    }
}

impl Default for DescentConfig {
    fn default() -> Self {
        Self {
            optimiser: Optimiser::Adam,
            learning_rate: 0.03,
            weight_decay: 0.01,
            steps: 2000,
            validate_every: 10,
            patience: 300,
            checkpoint_every: 100,
            input_noise: 0.3,
            map_in_objective: true,
        }
    }
}

impl Recipe {
    /// Checks everything once; what passes can be trained.
    ///
    /// # Errors
    /// Where a value makes no sense; the message names the key and what was expected.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: &dyn std::fmt::Display, expected: &str| {
            Err(Error::usage(format!(
                "{key} = {value}: expected {expected}"
            )))
        };
        let d = &self.descent;
        if self.features == 0 || self.features > MOST_FEATURES {
            return wrong(
                "features",
                &self.features,
                &format!("1 to {MOST_FEATURES} (2^n outcomes are summed exactly)"),
            );
        }
        if !(d.learning_rate.is_finite() && d.learning_rate > 0.0) {
            return wrong(
                "descent.learning_rate",
                &d.learning_rate,
                "a positive number",
            );
        }
        if !(0.0..1.0).contains(&(d.weight_decay * d.learning_rate)) {
            return wrong(
                "descent.weight_decay",
                &d.weight_decay,
                "0 or more, and less than 1/learning_rate",
            );
        }
        if !(d.input_noise.is_finite() && d.input_noise >= 0.0) {
            return wrong("descent.input_noise", &d.input_noise, "0 or more");
        }
        let counts = [
            ("descent.steps", d.steps),
            ("descent.validate_every", d.validate_every),
            ("descent.patience", d.patience),
            ("descent.checkpoint_every", d.checkpoint_every),
        ];
        if let Some((key, value)) = counts.into_iter().find(|(_, value)| *value == 0) {
            return wrong(key, &value, "at least 1");
        }
        self.input.check()?;
        self.network.check()?;
        self.split.check()
    }
}
