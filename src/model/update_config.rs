//! How a model is updated, as a configuration says it.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// How a model is updated with newer snapshots of the building that it learned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct UpdateConfig {
    /// The seed of what is forgotten and of the steps.
    pub seed: u64,
    /// After so many newer runs through its place, half of what was seen there before is forgotten. What was seen at places where
    /// nobody came again stays.
    pub half_life: f64,
    /// Most steps of training on old and new snapshots, from the model's weights on; 0: the filters stay, the map alone is updated.
    pub steps: usize,
    /// Length of these steps, as a share of those that the model was trained with.
    pub rate: f64,
}

impl Default for UpdateConfig {
    /// Assumed, and not tuned (`docs/DESIGN.md`).
    fn default() -> Self {
        Self {
            seed: 1,
            half_life: 2.0,
            steps: 100,
            rate: 0.3,
        }
    }
}

impl UpdateConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        if self.half_life.is_nan() || self.half_life <= 0.0 {
            return Err(Error::usage(format!(
                "update.half_life = {}: expected a number of runs above 0 (inf: nothing is forgotten)",
                self.half_life
            )));
        }
        if self.steps > MOST_STEPS {
            return Err(Error::usage(format!(
                "update.steps = {}: expected at most {MOST_STEPS}",
                self.steps
            )));
        }
        if !(self.rate > 0.0 && self.rate <= 10.0) {
            return Err(Error::usage(format!(
                "update.rate = {}: expected a share above 0, at most 10",
                self.rate
            )));
        }
        Ok(())
    }
}

/// Far beyond any use: a training of its own has fewer.
const MOST_STEPS: usize = 1_000_000;
