//! p(z | z*) of one beam: Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, 6.3, table 6.1.

use crate::{
    error::{Error, Result},
    mapping::{RangeSensors, Rendered},
};
use serde::{Deserialize, Serialize};
use statrs::function::erf::erf;
use std::f64::consts::{PI, SQRT_2};

/// The constants of a beam model. The weights of its four causes are taken as shares of their sum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BeamModelConfig {
    /// z_hit: weight of readings of what the map has there.
    pub hit: f64,
    /// z_short: weight of readings of something before it: people, things that were not there when the map was made.
    pub short: f64,
    /// z_max: weight of missing returns where the map has something within reach.
    pub max: f64,
    /// z_rand: weight of readings that have nothing to do with the map.
    pub random: f64,
    /// σ_hit: how far a reading scatters about what it hit, errors of map, pose and cell included, in metres.
    pub deviation_m: f64,
    /// 1/λ_short: how far readings of something before are away on average, in metres.
    pub short_m: f64,
    /// z_max where it is less than a channel's maximum: readings beyond are as none, in metres.
    pub reach_m: f64,
    /// So far a beam may go through cells of the map that were never seen and still be followed, in metres.
    pub unknown_m: f64,
    /// Beams of a scan that count, evenly spaced: neighbouring ones tell the same twice.
    pub beams: usize,
    /// Most bytes that rendered scans may take: a mistyped grid should end in a message, not in a full memory.
    pub most_bytes: usize,
    /// The sensors that count.
    pub sensors: RangeSensors,
}

impl Default for BeamModelConfig {
    fn default() -> Self {
        Self {
            hit: 0.7,
            short: 0.15,
            max: 0.05,
            random: 0.1,
            deviation_m: 0.2,
            short_m: 3.0,
            reach_m: 15.0,
            unknown_m: 0.4,
            beams: 36,
            most_bytes: 1_000_000_000,
            sensors: RangeSensors::default(),
        }
    }
}

impl BeamModelConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: f64, expected: &str| {
            Err(Error::usage(format!(
                "beam_model.{key} = {value}: expected {expected}"
            )))
        };
        for (key, value) in [("hit", self.hit), ("short", self.short)] {
            if !(value.is_finite() && value >= 0.0) {
                return wrong(key, value, "a weight, 0 or more");
            }
        }
        // Without these two a reading, or a missing one, could be impossible.
        for (key, value) in [("max", self.max), ("random", self.random)] {
            if !(value.is_finite() && value > 0.0) {
                return wrong(key, value, "a weight above 0");
            }
        }
        for (key, value) in [
            ("deviation_m", self.deviation_m),
            ("short_m", self.short_m),
            ("reach_m", self.reach_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return wrong(key, value, "metres above 0");
            }
        }
        if self.beams == 0 {
            return wrong("beams", 0.0, "1 or more");
        }
        Ok(())
    }
}

/// What a beam reads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Measured {
    /// A range below z_max, in metres.
    Range(f64),
    /// z_max: nothing came back from within reach.
    Max,
}

/// Shares of the terms of a beam that lie where it can read something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Within {
    hit: f64,
    short: f64,
}

/// p(z | z*) of a beam that sees no farther than `most_m`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mixture {
    hit: f64,
    short: f64,
    max: f64,
    random: f64,
    deviation_m: f64,
    rate_per_m: f64,
    most_m: f64,
}

impl Mixture {
    pub(super) fn new(config: &BeamModelConfig, most_m: f64) -> Self {
        let sum = config.hit + config.short + config.max + config.random;
        Self {
            hit: config.hit / sum,
            short: config.short / sum,
            max: config.max / sum,
            random: config.random / sum,
            deviation_m: config.deviation_m,
            rate_per_m: 1.0 / config.short_m,
            most_m,
        }
    }

    /// z_max, in metres.
    pub(super) fn most_m(&self) -> f64 {
        self.most_m
    }

    /// What the two terms that end somewhere have within their ends, whatever is measured.
    pub(super) fn within(&self, expected: Rendered) -> Within {
        let until_m = match expected {
            Rendered::Hit(expected_m) => f64::from(expected_m),
            Rendered::Free | Rendered::Unknown(_) => self.most_m,
        };
        let below = |m: f64| 0.5 * (1.0 + erf((m - until_m) / self.deviation_m / SQRT_2));
        Within {
            hit: below(self.most_m) - below(0.0),
            short: 1.0 - (-self.rate_per_m * until_m).exp(),
        }
    }

    /// A density per metre of a range, a probability of none (the book takes both as densities, one of them a narrow one:
    /// for places compared by the same reading it is all one).
    ///
    /// A beam that the map says nothing about may hit something at any range alike: a place is not worse than others because
    /// little of what it sees was mapped.
    pub(super) fn probability(
        &self,
        measured: Measured,
        expected: Rendered,
        within: Within,
    ) -> f64 {
        match measured {
            Measured::Range(z_m) => {
                // (6.4) to (6.6)
                let p_hit = match expected {
                    Rendered::Hit(expected_m) => {
                        self.gaussian(z_m, f64::from(expected_m), within.hit)
                    }
                    Rendered::Free => 0.0,
                    // Whatever it hits may be anywhere.
                    Rendered::Unknown(_) => 1.0 / self.most_m,
                };
                // (6.7) to (6.9)
                let until_m = match expected {
                    Rendered::Hit(expected_m) => f64::from(expected_m),
                    Rendered::Free | Rendered::Unknown(_) => self.most_m,
                };
                let p_short = match z_m > until_m {
                    true => 0.0,
                    false => self.exponential(z_m, within.short),
                };
                // (6.11)
                let p_random = 1.0 / self.most_m;
                self.hit * p_hit + self.short * p_short + self.random * p_random
            }
            // (6.10); what the map has beyond reach comes back as nothing.
            Measured::Max => match expected {
                Rendered::Free => self.hit + self.max,
                Rendered::Hit(_) | Rendered::Unknown(_) => self.max,
            },
        }
    }

    /// N(z; z*, σ), of which what lies below 0 and beyond z_max is given to the rest.
    fn gaussian(&self, z_m: f64, expected_m: f64, within: f64) -> f64 {
        let d = (z_m - expected_m) / self.deviation_m;
        (-0.5 * d * d).exp() / (self.deviation_m * (2.0 * PI).sqrt() * within)
    }

    /// λ exp(−λ z) up to z*, of which what lies beyond is given to the rest.
    fn exponential(&self, z_m: f64, within: f64) -> f64 {
        self.rate_per_m * (-self.rate_per_m * z_m).exp() / within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probability(mixture: &Mixture, measured: Measured, expected: Rendered) -> f64 {
        mixture.probability(measured, expected, mixture.within(expected))
    }

    #[test]
    fn ranges_and_missing_returns_share_all_probability() {
        let mixture = Mixture::new(&BeamModelConfig::default(), 8.0);
        let steps = 80_000;
        let step_m = 8.0 / f64::from(steps);
        let over_ranges = |expected| -> f64 {
            let middles = (0..steps).map(|i| (f64::from(i) + 0.5) * step_m);
            let each = middles.map(|z_m| probability(&mixture, Measured::Range(z_m), expected));
            step_m * each.sum::<f64>()
        };
        for expected in [0.1, 2.0, 7.9]
            .map(Rendered::Hit)
            .into_iter()
            .chain([Rendered::Free, Rendered::Unknown(0.0)])
        {
            let all = over_ranges(expected) + probability(&mixture, Measured::Max, expected);
            assert!((all - 1.0).abs() < 1e-4, "{expected:?}: {all}");
        }
    }

    #[test]
    fn each_term_is_the_books() {
        let config = BeamModelConfig {
            hit: 0.6,
            short: 0.2,
            max: 0.1,
            random: 0.1,
            deviation_m: 0.5,
            short_m: 2.0,
            ..BeamModelConfig::default()
        };
        let mixture = Mixture::new(&config, 10.0);
        // z = 3 m where the map has a wall at 4 m: 2 deviations short of it. Whole to 1e-12 within 0 and 10 m.
        let p_hit = (-2f64).exp() / (0.5 * (2.0 * PI).sqrt());
        let p_short = 0.5 * (-1.5f64).exp() / (1.0 - (-2f64).exp());
        let by_hand = 0.6 * p_hit + 0.2 * p_short + 0.1 / 10.0;
        let found = probability(&mixture, Measured::Range(3.0), Rendered::Hit(4.0));
        assert!((found / by_hand - 1.0).abs() < 1e-9, "{found} {by_hand}");
        // Past the wall nothing is short.
        let by_hand = 0.6 * p_hit + 0.1 / 10.0;
        let found = probability(&mixture, Measured::Range(5.0), Rendered::Hit(4.0));
        assert!((found / by_hand - 1.0).abs() < 1e-9, "{found} {by_hand}");
        assert!((probability(&mixture, Measured::Max, Rendered::Free) - 0.7).abs() < 1e-12);
        assert!((probability(&mixture, Measured::Max, Rendered::Hit(4.0)) - 0.1).abs() < 1e-12);
    }
}
