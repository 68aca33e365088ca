//! How a compass's error changes while the robot drives: its core sways, and a slow error drifts.
//!
//! A core that floats or hangs shows the horizontal field only while it is level. Tilted by δ across the magnetic meridian it takes
//! in δ times the vertical field too, which turns the reading by δ tan(dip). Sway and slow error are Ornstein–Uhlenbeck processes:
//! normally distributed, and the correlation of two moments t apart is exp(−t / τ). Nothing of this is alike at one place from one
//! lap to the next.

use super::CompassConfig;
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

/// What is not steady in a compass, at one moment.
///
/// ```
/// use ballmark::{seed::Seed, world::{unsteadiness::Unsteadiness, CompassConfig}};
/// let (config, mut random) = (CompassConfig::default(), Seed(1).stream("compass"));
/// let mut unsteadiness = Unsteadiness::draw(&config, &mut random);
/// let before_rad = unsteadiness.error_rad(&config);
/// unsteadiness.pass(&config, 0.01, &mut random);
/// assert!((unsteadiness.error_rad(&config) - before_rad).abs() < 0.02); // little changes in a hundredth of a second
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unsteadiness {
    tilt_rad: f64,
    drift_rad: f64,
}

impl Unsteadiness {
    /// At a moment of which nothing is known.
    pub fn draw(config: &CompassConfig, random: &mut impl Rng) -> Self {
        Self {
            tilt_rad: config.tilt_sd_rad * normal(random),
            drift_rad: config.drift_sd_rad * normal(random),
        }
    }

    /// Some seconds later.
    pub fn pass(&mut self, config: &CompassConfig, elapsed_s: f64, random: &mut impl Rng) {
        let mut passed = |value_rad: f64, sd_rad: f64, time_s: f64| {
            let kept = (-elapsed_s / time_s).exp();
            kept * value_rad + sd_rad * (1.0 - kept * kept).sqrt() * normal(random)
        };
        self.tilt_rad = passed(self.tilt_rad, config.tilt_sd_rad, config.tilt_time_s);
        self.drift_rad = passed(self.drift_rad, config.drift_sd_rad, config.drift_time_s);
    }

    /// How far it turns a reading counter-clockwise, radians.
    pub fn error_rad(&self, config: &CompassConfig) -> f64 {
        self.tilt_rad * config.dip_rad.tan() + self.drift_rad
    }
}

fn normal(random: &mut impl Rng) -> f64 {
    random.sample(StandardNormal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;

    /// Covariance of the error with that so many seconds later.
    fn covariance(config: &CompassConfig, later_s: f64) -> f64 {
        let (n, mut random) = (40_000, Seed(2).stream("unsteadiness"));
        let product = |random: &mut crate::seed::Stream| {
            let mut state = Unsteadiness::draw(config, random);
            let before = state.error_rad(config);
            // Cut in two, the same comes of it.
            state.pass(config, 0.3 * later_s, random);
            state.pass(config, 0.7 * later_s, random);
            before * state.error_rad(config)
        };
        (0..n).map(|_| product(&mut random)).sum::<f64>() / f64::from(n)
    }

    #[test]
    fn sway_and_drift_have_the_stated_sizes_and_times() {
        let sway = CompassConfig {
            drift_sd_rad: 0.0,
            ..CompassConfig::default()
        };
        let drift = CompassConfig {
            tilt_sd_rad: 0.0,
            ..CompassConfig::default()
        };
        // tan 68.18° = 2.4979: half a degree of tilt turns the reading by 1.25°.
        let at_once = (0.0087 * 2.4979_f64).powi(2);
        for (config, at_once, time_s) in [(&sway, at_once, 1.0), (&drift, 0.0087_f64.powi(2), 60.0)]
        {
            for later in [0.0, 1.0, 2.0] {
                let share = covariance(config, later * time_s) / at_once;
                // 4 standard errors of a mean of 40,000 products of two normal numbers: 0.028 at most.
                assert!((share - (-later).exp()).abs() < 0.03, "{later}: {share}");
            }
        }
        let steady = CompassConfig::default().steady();
        assert_eq!(covariance(&steady, 1.0), 0.0);
    }
}
