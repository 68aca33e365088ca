//! What is run, and how often.

use crate::{error::Result, localiser::local_grid::LocalGridConfig, toml_file::out_of_range};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What is run, and how often.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ruizmayor2006Config {
    /// The one seed of the run: readings and priors.
    pub seed: u64,
    /// How often priors are drawn anew; intervals are over these.
    pub repetitions: usize,
    /// The prediction is off by up to so much (4.2), metres …
    pub prediction_m: f64,
    /// … and degrees.
    pub prediction_deg: f64,
    /// And uniform noise is put on it up to so much (4.2), metres …
    pub noise_m: f64,
    /// … and degrees.
    pub noise_deg: f64,
    /// s_XY in metres.
    pub position_step_m: f64,
    /// s_T in degrees: the first is R06's, the others are tried beside it (4.3).
    pub heading_steps_deg: Vec<f64>,
    /// Normal noise put on every range, as standard deviations in metres (3.4): the first is R06's.
    pub range_noise_m: Vec<f64>,
    /// Longest readings that are tried beside those of the worlds, in metres: R06 tells of none, the worlds assume 6 m.
    pub longest_readings_m: Vec<f64>,
    /// Metres from one pilaster to the next, on both walls of the corridor R3, that are tried beside its bare walls: what stood there R06
    /// does not tell.
    pub pilasters_every_m: Vec<f64>,
}

impl Default for Ruizmayor2006Config {
    fn default() -> Self {
        Self {
            seed: 1,
            repetitions: 20,
            prediction_m: 0.1,
            prediction_deg: 5.0,
            noise_m: 0.4,
            noise_deg: 40.0,
            position_step_m: 0.1,
            heading_steps_deg: vec![10.0, 5.0, 20.0, 40.0],
            range_noise_m: vec![0.0, 0.05, 0.1, 0.2, 0.4],
            longest_readings_m: vec![40.0],
            pilasters_every_m: vec![4.0, 2.0],
        }
    }
}

impl Ruizmayor2006Config {
    /// Three repetitions.
    pub fn toy(self) -> Self {
        Self {
            repetitions: 3,
            ..self
        }
    }

    /// # Errors
    /// A usage error that names the key at fault.
    pub fn check(&self) -> Result<()> {
        let wrong =
            |key: &str, expected: &str| Err(out_of_range("ruizmayor2006", self, key, expected));
        if self.repetitions == 0 {
            return wrong("repetitions", "1 or more");
        }
        for (key, value) in [
            ("prediction_m", self.prediction_m),
            ("prediction_deg", self.prediction_deg),
            ("noise_m", self.noise_m),
            ("noise_deg", self.noise_deg),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return wrong(key, "0 or more");
            }
        }
        if self.heading_steps_deg.is_empty() {
            return wrong("heading_steps_deg", "one or more");
        }
        if self.range_noise_m.is_empty() {
            return wrong("range_noise_m", "one or more");
        }
        let positive = |value: &f64| value.is_finite() && *value > 0.0;
        if !positive(&self.position_step_m) {
            return wrong("position_step_m", "more than 0");
        }
        if !self.heading_steps_deg.iter().all(positive) {
            return wrong("heading_steps_deg", "more than 0");
        }
        if !self
            .range_noise_m
            .iter()
            .all(|m| m.is_finite() && *m >= 0.0)
        {
            return wrong("range_noise_m", "metres of 0 or more");
        }
        if !self
            .longest_readings_m
            .iter()
            .all(|m| m.is_finite() && *m > 0.0)
        {
            return wrong("longest_readings_m", "metres above 0");
        }
        if !self
            .pilasters_every_m
            .iter()
            .all(|m| m.is_finite() && *m >= 0.5)
        {
            return wrong("pilasters_every_m", "metres of 0.5 or more");
        }
        Ok(())
    }

    /// The search of R06 4.1 with another step in heading.
    pub(super) fn search(&self, world: &Path, heading_step_deg: f64) -> LocalGridConfig {
        LocalGridConfig {
            world: world.into(),
            position_step_m: self.position_step_m,
            heading_step_rad: heading_step_deg.to_radians(),
            ..LocalGridConfig::default()
        }
    }
}
