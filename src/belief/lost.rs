//! Is the robot lost? A belief's own mass near its estimate, held against how well it predicts what is sensed.
//!
//! A belief is too sure of itself: a robot that was carried away, or whose belief has settled on the wrong one of two places
//! alike, has all its mass where it is not. What gives it away is that its sensors are explained better from elsewhere, again and
//! again. So the score has two factors,
//!
//! score = 1 − m · σ(base + slope · r),   σ(x) = 1 / (1 + e⁻ˣ),
//!
//! m the mass within [`NEAR_M`] of the estimate, and r the short-term mean (Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005,
//! Table 8.3, of logarithms) of the log-likelihood ratio between the belief and a robot that may be anywhere. Base and
//! slope are fitted where truth is known, so that the score tells lost steps from others as well as it can, both of a robot that starts
//! anywhere and of one that was carried away.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// An estimate this far from the truth is wrong, in metres.
pub const NEAR_M: f64 = 1.0;

/// How likely an observation was held to be, in nats, up to a constant that both share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Explained {
    /// ln Σ_ξ Bel(ξ) P(z|ξ): by the belief before the observation.
    pub by_belief: f64,
    /// The same by a robot that may be anywhere.
    pub anywhere: f64,
}

/// Most that a single observation says for or against a belief, in nats: one reading out of order is no proof.
const MOST: f64 = 8.0;

/// What the last observations say of the belief: the short-term mean r of their log-likelihood ratios.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Prediction {
    observations: usize,
    mean: f64,
}

impl Prediction {
    /// Takes in an observation; the first ones count alike, as there is nothing before them.
    pub fn observe(&mut self, explained: Explained, short: f64) {
        self.observations += 1;
        let ratio = (explained.by_belief - explained.anywhere).clamp(-MOST, MOST);
        let weight = short.max(1.0 / self.observations as f64);
        self.mean += weight * (ratio - self.mean);
    }

    /// r, in nats: above 0 where the belief predicts better than knowing nothing, below where it does worse; 0 before the first
    /// observation.
    pub fn mean(&self) -> f64 {
        self.mean
    }
}

/// How a belief's mass and its predictions make a score between 0 (at its place) and 1 (lost), and from which on the robot counts as
/// lost.
///
/// ```
/// use ballmark::belief::lost::{Explained, LostConfig, Prediction};
/// let config = LostConfig::default();
/// let (mut fits, mut contradicts) = (Prediction::default(), Prediction::default());
/// for _ in 0..5 {
///     fits.observe(Explained { by_belief: -0.5, anywhere: -3.0 }, config.short);
///     contradicts.observe(Explained { by_belief: -6.0, anywhere: -3.0 }, config.short);
/// }
/// // Two robots that are as sure of their place; one is where it believes.
/// assert!(config.score(0.99, &fits) < 0.1);
/// assert!(config.score(0.99, &contradicts) > 0.9);
/// // Who has no idea needs no sensors to know.
/// assert!(config.score(0.02, &fits) > 0.97);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LostConfig {
    /// Weight of the newest observation in the short-term mean, above 0 up to 1: Thrun, Burgard & Fox's alpha_fast.
    pub short: f64,
    /// Log odds of a sure belief that predicts no better than knowing nothing.
    pub base: f64,
    /// What a nat of that mean adds to them, 0 or more.
    pub slope: f64,
    /// Score from which on the robot counts as lost, above 0 and below 1.
    pub threshold: f64,
}

impl Default for LostConfig {
    /// What told most of the systems' lost steps on a validation part (`docs/DESIGN.md`).
    fn default() -> Self {
        Self {
            short: 0.4,
            base: 1.0,
            slope: 3.0,
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

    /// The score of a belief with this mass within [`NEAR_M`] of its estimate.
    pub fn score(&self, near_mass: f64, prediction: &Prediction) -> f64 {
        self.of_mean(near_mass, prediction.mean())
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
    fn the_mean_is_of_all_at_first_and_of_the_latest_then() {
        let mut prediction = Prediction::default();
        let mut see = |ratio: f64| {
            let explained = Explained {
                by_belief: ratio - 5.0,
                anywhere: -5.0,
            };
            prediction.observe(explained, 0.4);
            prediction.mean()
        };
        assert_eq!(see(1.0), 1.0);
        assert_eq!(see(3.0), 2.0);
        assert!((see(-1.0) - (2.0 + 0.4 * -3.0)).abs() < 1e-12);
        assert!((see(-1e9) - (0.8 + 0.4 * (-8.0 - 0.8))).abs() < 1e-12); // no proof alone
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
