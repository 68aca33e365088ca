//! Is the robot lost? A belief's own mass near its estimate, held against how well the estimate explains what was sensed.
//!
//! A belief is too sure of itself: a robot that was carried away, or whose belief has settled on the wrong one of two places
//! alike, has all its mass where it is not. What gives it away is that what it has sensed does not fit the way that leads to its estimate. So the
//! score has two factors,
//!
//! score = 1 − m · σ(base + slope · r),   σ(x) = 1 / (1 + e⁻ˣ),
//!
//! m the mass within [`NEAR_M`] of the estimate, and r the mean, later observations counting more, of ln P(z|estimate) / P(z|anywhere), each
//! observation asked where the robot was then if it is at its estimate now ([`Hindsight`](super::Hindsight)). All constants are fitted where truth is
//! known, so that the score tells lost steps from others as well as it can, both of a robot that starts anywhere and of one that was carried away.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// An estimate this far from the truth is wrong, in metres.
pub const NEAR_M: f64 = 1.0;

/// Most that a single observation says for or against a place, in nats: one reading out of order is no proof.
pub const MOST: f64 = 8.0;

/// How a belief's mass and the last observations make a score between 0 (at its place) and 1 (lost), and from which on the robot counts as
/// lost.
///
/// ```
/// use ballmark::belief::lost::LostConfig;
/// let config = LostConfig::default();
/// // Two robots that are as sure of their place; one is where it believes.
/// let (fits, contradicts) = ([2.5; 5], [-3.0; 5]);
/// assert!(config.score(0.99, &fits) < 0.1);
/// assert!(config.score(0.99, &contradicts) > 0.9);
/// // One that was carried away just now: its last observation fits no longer.
/// assert!(config.score(0.99, &[-8.0, 2.5, 2.5, 2.5]) > 0.8);
/// // Who has no idea needs no sensors to know.
/// assert!(config.score(0.02, &fits) > 0.97);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LostConfig {
    /// Weight of the newest observation in the mean, above 0 up to 1; each one before it counts 1 less that times as much.
    pub short: f64,
    /// Log odds of a sure belief whose estimate explains what was sensed no better than any place.
    pub base: f64,
    /// What a nat of that mean adds to them, 0 or more.
    pub slope: f64,
    /// Score from which on the robot counts as lost, above 0 and below 1.
    pub threshold: f64,
}

impl Default for LostConfig {
    /// What told the lost steps of ten systems on a simulated corridor and two lidar logs best on average, by likelihood (`docs/DESIGN.md`).
    fn default() -> Self {
        Self {
            short: 0.3,
            base: 0.0,
            slope: 1.0,
            threshold: 0.5,
        }
    }
}

impl LostConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: f64, expected: &str| {
            Err(Error::usage(format!(
                "lost: `{key}` is {value}; expected {expected}"
            )))
        };
        if !(self.short > 0.0 && self.short <= 1.0) {
            return wrong("short", self.short, "a weight above 0 up to 1");
        }
        if !self.base.is_finite() {
            return wrong("base", self.base, "a finite number");
        }
        if !(self.slope.is_finite() && self.slope >= 0.0) {
            return wrong("slope", self.slope, "0 or more");
        }
        if !(self.threshold > 0.0 && self.threshold < 1.0) {
            return wrong(
                "threshold",
                self.threshold,
                "between 0 and 1, both excluded",
            );
        }
        Ok(())
    }

    /// The score of a belief with this mass within [`NEAR_M`] of its estimate, and of what the last observations say of that
    /// ([`Hindsight::ratios`](super::Hindsight::ratios), the newest first). Before the first observation nothing speaks against a start that is known.
    pub fn score(&self, near_mass: f64, ratios: &[f64]) -> f64 {
        match ratios {
            [] => 1.0 - near_mass.clamp(0.0, 1.0),
            ratios => self.of_mean(near_mass, self.mean(ratios)),
        }
    }

    /// r, in nats: above 0 where the estimate explains what was sensed better than any place would, below where it does worse; 0 before the
    /// first observation.
    pub fn mean(&self, ratios: &[f64]) -> f64 {
        let (mut weight, mut sum, mut total) = (1.0, 0.0, 0.0);
        for ratio in ratios {
            sum += weight * ratio;
            total += weight;
            weight *= 1.0 - self.short;
        }
        if total > 0.0 { sum / total } else { 0.0 }
    }

    /// The same with r given.
    pub fn of_mean(&self, near_mass: f64, mean: f64) -> f64 {
        let odds = self.base + self.slope * mean;
        1.0 - near_mass.clamp(0.0, 1.0) / (1.0 + (-odds).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_observations_count_more() {
        let config = LostConfig {
            short: 0.4,
            ..LostConfig::default()
        };
        assert_eq!(config.mean(&[]), 0.0);
        assert_eq!(config.mean(&[3.0]), 3.0);
        let expected = (-1.0 + 0.6 * 3.0 + 0.36 * 2.0) / 1.96;
        assert!((config.mean(&[-1.0, 3.0, 2.0]) - expected).abs() < 1e-12);
        let only = LostConfig {
            short: 1.0,
            ..config
        };
        assert_eq!(only.mean(&[-1.0, 3.0]), -1.0);
    }

    #[test]
    fn the_score_by_hand() {
        let config = LostConfig {
            base: 0.0,
            slope: 2.0,
            ..LostConfig::default()
        };
        assert!((config.of_mean(0.8, 0.0) - 0.6).abs() < 1e-12);
        assert!((config.of_mean(1.0, 1.0) - 1.0 / (1.0 + 2f64.exp())).abs() < 1e-12);
        assert_eq!(config.of_mean(0.0, 9.0), 1.0);
        assert!((config.score(0.8, &[0.0]) - 0.6).abs() < 1e-12);
        assert!((config.score(0.8, &[]) - 0.2).abs() < 1e-12); // nothing sensed yet
    }

    #[test]
    fn senseless_constants_are_refused_by_name() {
        assert!(LostConfig::default().check().is_ok());
        let refused = |change: fn(&mut LostConfig), key: &str| {
            let mut config = LostConfig::default();
            change(&mut config);
            let fault = config.check().unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains(key),
                "{fault}"
            );
        };
        refused(|c| c.short = 0.0, "`short` is 0");
        refused(|c| c.base = f64::NAN, "`base`");
        refused(|c| c.slope = -1.0, "`slope` is -1");
        refused(|c| c.threshold = 1.0, "`threshold` is 1");
    }
}
