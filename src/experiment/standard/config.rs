//! The constants of the standard experiment.

use crate::{
    error::{Error, Result},
    score::Effort,
};
use serde::{Deserialize, Serialize};

/// Most random tables that are drawn to judge one.
pub(in crate::experiment) const MAX_DRAWINGS: u64 = 1_000_000;
/// The constants of the standard experiment; the default is D98's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StandardConfig {
    /// Sides of the location bins, metres (6.4).
    pub bin_m: f64,
    /// Distance of a trial, metres (6.5).
    pub trial_m: f64,
    /// From one trial's start to the next one's, seconds (6.5).
    pub every_s: f64,
    /// From one contingency table to the next, metres travelled (6.5).
    pub step_m: f64,
    /// Random tables for the p-value at the end; 0: no p-value.
    pub permutations: u64,
    /// Bootstrap resamples for the intervals; 0: none.
    pub resamples: u64,
    /// The coefficient whose distance is reported (D98 Table 2).
    pub coefficient_to_reach: f64,
}

impl Default for StandardConfig {
    fn default() -> Self {
        let effort = Effort::default();
        Self {
            bin_m: 2.0,
            trial_m: 20.0,
            every_s: 5.0,
            step_m: 0.1,
            permutations: effort.permutations,
            resamples: effort.resamples,
            coefficient_to_reach: 0.9,
        }
    }
}

/// Most contingency tables of one experiment.
const MAX_TABLES: f64 = 10_000.0;

impl StandardConfig {
    /// # Errors
    /// A usage error that names the key out of bounds.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: f64, expected: &str| {
            Err(Error::usage(format!(
                "standard.{key} = {value}: expected {expected}"
            )))
        };
        for (key, value) in [
            ("bin_m", self.bin_m),
            ("trial_m", self.trial_m),
            ("every_s", self.every_s),
            ("step_m", self.step_m),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(key, value, "more than 0");
            }
        }
        if self.trial_m / self.step_m > MAX_TABLES {
            return wrong(
                "step_m",
                self.step_m,
                "a ten-thousandth of standard.trial_m or more",
            );
        }
        if !(self.coefficient_to_reach > 0.0 && self.coefficient_to_reach <= 1.0) {
            return wrong(
                "coefficient_to_reach",
                self.coefficient_to_reach,
                "more than 0, up to 1",
            );
        }
        for (key, value) in [
            ("permutations", self.permutations),
            ("resamples", self.resamples),
        ] {
            if value > MAX_DRAWINGS {
                return wrong(key, value as f64, "1000000 or less");
            }
        }
        Ok(())
    }

    /// Number of contingency tables.
    pub(super) fn tables(&self) -> usize {
        // A billionth of slack, or 20 m / 0.1 m might be short of 200.
        (self.trial_m / self.step_m + 1e-9).floor() as usize + 1
    }

    pub(super) fn distance_m(&self, table: usize) -> f64 {
        // In whole nanometres: 12 steps of 0.1 m are 1.2 m, not 1.2000000000000002 m.
        (table as f64 * self.step_m * 1e9).round() / 1e9
    }
}
