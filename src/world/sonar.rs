//! A ring of sonars: cones of rays that come back from surfaces met head-on, from corners, or not at all.

use super::{Surroundings, echo::nearest_echo_m};
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    recording::Channel,
};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Every constant of the ring and its noise. Defaults: 24 Polaroid transducers round a B21 (Thrun 1998, 5.1.3 gives
/// their number; all else is assumed from that sensor's usual data).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SonarConfig {
    /// Number of sonars, evenly spaced counter-clockwise, the first straight ahead.
    pub beams: usize,
    /// Distance of the transducers from the robot's centre, metres; ranges count from the transducer.
    pub ring_radius_m: f64,
    /// Height of the ring above the floor, metres.
    pub height_m: f64,
    /// Full opening of the cone, radians.
    pub opening_rad: f64,
    /// Rays that sample the cone, evenly from edge to edge.
    pub rays: usize,
    /// Standard deviation by which a reading's cone points aside of its sonar's axis, radians: in restless air, and
    /// between pulses, the lobe is never quite the same.
    pub axis_sd_rad: f64,
    /// Shortest reading: the transducer still rings from its own pulse until then, metres.
    pub minimum_m: f64,
    /// Longest reading; from there on there is no return, metres.
    pub maximum_m: f64,
    /// How many mirror reflections a ray is followed through.
    pub reflections: usize,
    /// How near to the transducer a ray thrown back by mirrors (a corner) must pass to be heard, metres.
    pub capture_radius_m: f64,
    /// Standard deviation of the range noise at range 0, metres.
    pub noise_m: f64,
    /// What a metre of range adds to that standard deviation, metres a metre.
    pub noise_per_m: f64,
    /// Step of the readings, metres; 0: continuous.
    pub resolution_m: f64,
    /// Probability that a reading is false and short (cross-talk, electrical noise): uniform between the minimum and
    /// the range that it replaces.
    pub short_probability: f64,
    /// Probability that an echo is not heard.
    pub lost_probability: f64,
}

impl Default for SonarConfig {
    fn default() -> Self {
        Self {
            beams: 24,
            ring_radius_m: 0.26,
            height_m: 0.6,
            opening_rad: 25_f64.to_radians(),
            rays: 17,
            axis_sd_rad: 0.04,
            minimum_m: 0.15,
            maximum_m: 10.0,
            reflections: 3,
            capture_radius_m: 0.15,
            noise_m: 0.01,
            noise_per_m: 0.01,
            resolution_m: 0.01,
            short_probability: 0.02,
            lost_probability: 0.03,
        }
    }
}

/// Most values that a ring, or rays that a cone, may have: far beyond any real one, small enough to allocate.
const MOST: usize = 10_000;
/// A ring of sonars whose constants have been checked.
///
/// Surfaces are mirrors beyond their critical angle; right-angled corners throw sound back to the sender (Kuc & Siegel
/// 1987). A sonar reports the nearest echo of its cone.
///
/// ```
/// use ballmark::{geometry::Pose, world::{floor_plan::round, FloorPlan, Material, Raycaster, Sonar, SonarConfig}};
/// use nalgebra::Point2;
/// let brick = Material { reflectivity: 1.0, critical_angle_rad: 0.3, ..Material::PLAIN };
/// let caster = Raycaster::new(FloorPlan::new(round(Point2::origin(), 3.0, 48, brick))?);
/// let sonar = Sonar::new(SonarConfig::default())?;
/// let ahead_m = sonar.echo_m(&(&caster).into(), &Pose::default(), 0).unwrap();
/// assert!((ahead_m - (3.0 - 0.26)).abs() < 0.01); // the tower's wall, from the transducer
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Sonar {
    config: SonarConfig,
}

impl Sonar {
    /// A ring of these constants.
    ///
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn new(config: SonarConfig) -> Result<Self> {
        let wrong = |key: &str, value: f64, expected: &str| {
            Err(Error::usage(format!(
                "sonar: `{key}` is {value}; expected {expected}"
            )))
        };
        for (key, count) in [("beams", config.beams), ("rays", config.rays)] {
            if !(1..=MOST).contains(&count) {
                return wrong(key, count as f64, &format!("1 to {MOST}"));
            }
        }
        if config.reflections > MOST {
            return wrong(
                "reflections",
                config.reflections as f64,
                &format!("0 to {MOST}"),
            );
        }
        if !(config.opening_rad >= 0.0 && config.opening_rad <= PI) {
            return wrong("opening_rad", config.opening_rad, "0 to π");
        }
        for (key, value) in [
            ("ring_radius_m", config.ring_radius_m),
            ("axis_sd_rad", config.axis_sd_rad),
            ("minimum_m", config.minimum_m),
            ("capture_radius_m", config.capture_radius_m),
            ("noise_m", config.noise_m),
            ("noise_per_m", config.noise_per_m),
            ("resolution_m", config.resolution_m),
        ] {
            if !(value >= 0.0 && value.is_finite()) {
                return wrong(key, value, "0 or more");
            }
        }
        if !(config.maximum_m > config.minimum_m && config.maximum_m.is_finite()) {
            return wrong("maximum_m", config.maximum_m, "more than `minimum_m`");
        }
        for (key, value) in [
            ("short_probability", config.short_probability),
            ("lost_probability", config.lost_probability),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return wrong(key, value, "0 to 1");
            }
        }
        Ok(Self { config })
    }

    /// The constants.
    pub fn config(&self) -> &SonarConfig {
        &self.config
    }

    /// The channel that its readings make.
    pub fn channel(&self) -> Channel {
        let beams = 0..self.config.beams;
        Channel {
            name: "sonar".into(),
            width: self.config.beams,
            unit: "m".into(),
            bearing_rad: Some(beams.map(|beam| self.bearing_rad(beam)).collect()),
            maximum: Some(self.config.maximum_m),
        }
    }

    /// Direction of a sonar in the robot's frame, in (−π, π].
    pub fn bearing_rad(&self, beam: usize) -> f64 {
        wrapped(TAU * beam as f64 / self.config.beams as f64)
    }

    /// One reading of every sonar at a pose, with noise: metres, NaN = no return.
    pub fn read(&self, around: &Surroundings, pose: &Pose, random: &mut impl Rng) -> Vec<f32> {
        (0..self.config.beams)
            .map(|beam| {
                let normal: f64 = random.sample(StandardNormal);
                let bearing_rad = self.bearing_rad(beam) + normal * self.config.axis_sd_rad;
                let echo_m = nearest_echo_m(
                    around,
                    &self.config,
                    pose,
                    self.bearing_rad(beam),
                    bearing_rad,
                );
                self.corrupted(echo_m, random)
                    .map_or(f32::NAN, |metres| metres as f32)
            })
            .collect()
    }

    /// The nearest echo that a sonar hears, without noise, in metres from its transducer.
    pub fn echo_m(&self, around: &Surroundings, pose: &Pose, beam: usize) -> Option<f64> {
        let bearing_rad = self.bearing_rad(beam);
        nearest_echo_m(around, &self.config, pose, bearing_rad, bearing_rad)
    }

    /// What the sensor reports of an echo.
    fn corrupted(&self, echo_m: Option<f64>, random: &mut impl Rng) -> Option<f64> {
        let c = &self.config;
        // The same three draws for every reading, so that one reading's fate never shifts the next one's.
        let (fate, place): (f64, f64) = (random.random(), random.random());
        let normal: f64 = random.sample(StandardNormal);
        if fate < c.short_probability {
            let range_m = echo_m.unwrap_or(c.maximum_m).max(c.minimum_m);
            return Some(c.minimum_m + place * (range_m - c.minimum_m));
        }
        if fate >= 1.0 - c.lost_probability {
            return None;
        }
        let range_m = echo_m?;
        let noisy_m = range_m + normal * (c.noise_m + c.noise_per_m * range_m);
        let stepped_m = if c.resolution_m > 0.0 {
            (noisy_m / c.resolution_m).round() * c.resolution_m
        } else {
            noisy_m
        };
        (stepped_m < c.maximum_m).then_some(stepped_m.max(c.minimum_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;

    #[test]
    fn noise_has_the_stated_statistics() {
        let config = SonarConfig {
            short_probability: 0.1,
            lost_probability: 0.2,
            resolution_m: 0.0,
            ..Default::default()
        };
        let (sonar, n) = (Sonar::new(config).unwrap(), 100_000);
        let mut random = Seed(5).stream("noise");
        let readings: Vec<Option<f64>> = (0..n)
            .map(|_| sonar.corrupted(Some(3.0), &mut random))
            .collect();
        let lost = readings.iter().filter(|reading| reading.is_none()).count() as f64 / n as f64;
        assert!((lost - 0.2).abs() < 0.005, "{lost}"); // 4 standard errors
        // Short ones are uniform on [0.15, 3]: 2.35/2.85 of them lie below 2.5, where no noisy echo comes.
        let short: Vec<f64> = readings
            .iter()
            .flatten()
            .copied()
            .filter(|&metres| metres < 2.5)
            .collect();
        let share = short.len() as f64 / n as f64;
        assert!((share - 0.1 * 2.35 / 2.85).abs() < 0.004, "{share}");
        let mean = short.iter().sum::<f64>() / short.len() as f64;
        assert!((mean - (0.15 + 2.5) / 2.0).abs() < 0.03, "{mean}");

        let sonar = Sonar::new(SonarConfig {
            short_probability: 0.0,
            lost_probability: 0.0,
            ..sonar.config
        })
        .unwrap();
        let errors: Vec<f64> = (0..n)
            .map(|_| sonar.corrupted(Some(3.0), &mut random).unwrap() - 3.0)
            .collect();
        let mean = errors.iter().sum::<f64>() / n as f64;
        let sd = (errors.iter().map(|error| error * error).sum::<f64>() / n as f64).sqrt();
        // 0.01 + 0.01 · 3 m
        assert!(
            mean.abs() < 0.0006 && (sd - 0.04).abs() < 0.0004,
            "{mean} ± {sd}"
        );
    }

    #[test]
    fn readings_step_by_the_resolution_and_stay_in_their_bounds() {
        let sonar = Sonar::new(SonarConfig {
            short_probability: 0.0,
            resolution_m: 0.05,
            ..Default::default()
        })
        .unwrap();
        let mut random = Seed(6).stream("noise");
        for echo_m in [0.02, 1.3, 9.99] {
            for reading_m in (0..2000).filter_map(|_| sonar.corrupted(Some(echo_m), &mut random)) {
                let steps = reading_m / 0.05;
                assert!((steps - steps.round()).abs() < 1e-9 && (0.15..10.0).contains(&reading_m));
            }
        }
    }

    #[test]
    fn constants_out_of_bounds_are_told_by_name() {
        let default = SonarConfig::default;
        for (key, config) in [
            (
                "beams",
                SonarConfig {
                    beams: 0,
                    ..default()
                },
            ),
            (
                "rays",
                SonarConfig {
                    rays: 1_000_000,
                    ..default()
                },
            ),
            (
                "opening_rad",
                SonarConfig {
                    opening_rad: -0.1,
                    ..default()
                },
            ),
            (
                "noise_m",
                SonarConfig {
                    noise_m: -0.1,
                    ..default()
                },
            ),
            (
                "noise_per_m",
                SonarConfig {
                    noise_per_m: f64::NAN,
                    ..default()
                },
            ),
            (
                "maximum_m",
                SonarConfig {
                    maximum_m: 0.1,
                    ..default()
                },
            ),
            (
                "lost_probability",
                SonarConfig {
                    lost_probability: 1.5,
                    ..default()
                },
            ),
        ] {
            let error = Sonar::new(config).unwrap_err();
            assert!(
                error.is_usage() && error.to_string().contains(&format!("`{key}`")),
                "{error}"
            );
        }
        assert!(serde_json::from_str::<SonarConfig>(r#"{"beams": 16}"#).is_ok());
        assert!(serde_json::from_str::<SonarConfig>(r#"{"beems": 16}"#).is_err());
    }
}
