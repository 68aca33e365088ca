//! A ring of sonars: cones of rays that come back from surfaces met head-on, from corners, or not at all.

use super::Raycaster;
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    recording::Channel,
};
use nalgebra::{Point2, Vector2};
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
    /// Full opening of the cone, radians.
    pub opening_rad: f64,
    /// Rays that sample the cone, evenly from edge to edge.
    pub rays: usize,
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
            opening_rad: 25_f64.to_radians(),
            rays: 9,
            minimum_m: 0.15,
            maximum_m: 10.0,
            reflections: 3,
            capture_radius_m: 0.15,
            noise_m: 0.01,
            noise_per_m: 0.01,
            resolution_m: 0.01,
            short_probability: 0.01,
            lost_probability: 0.02,
        }
    }
}

/// Most values that a ring, or rays that a cone, may have: far beyond any real one, small enough to allocate.
const MOST: usize = 10_000;
/// After a reflection a ray starts this much short of the wall, on the side that it came from, so that rounding can't
/// put it behind the wall or, in a corner, behind the next one.
const STEP_BACK_M: f64 = 1e-6;

/// A ring of sonars whose constants have been checked.
///
/// Surfaces are mirrors beyond their critical angle; right-angled corners throw sound back to the sender (Kuc & Siegel
/// 1987). A sonar reports the nearest echo of its cone.
///
/// ```
/// use ballmark::{geometry::Pose, world::{floor_plan::round, FloorPlan, Material, Raycaster, Sonar, SonarConfig}};
/// use nalgebra::Point2;
/// let brick = Material { reflectivity: 1.0, critical_angle_rad: 0.3 };
/// let caster = Raycaster::new(FloorPlan::new(round(Point2::origin(), 3.0, 48, brick))?);
/// let sonar = Sonar::new(SonarConfig::default())?;
/// let ahead_m = sonar.echo_m(&caster, &Pose::default(), 0).unwrap();
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
    pub fn read(&self, caster: &Raycaster, pose: &Pose, random: &mut impl Rng) -> Vec<f32> {
        (0..self.config.beams)
            .map(|beam| self.corrupted(self.echo_m(caster, pose, beam), random))
            .map(|reading_m| reading_m.map_or(f32::NAN, |metres| metres as f32))
            .collect()
    }

    /// The nearest echo that a sonar hears, without noise, in metres from its transducer.
    pub fn echo_m(&self, caster: &Raycaster, pose: &Pose, beam: usize) -> Option<f64> {
        let bearing_rad = pose.heading_rad + self.bearing_rad(beam);
        let transducer =
            Point2::new(pose.x_m, pose.y_m) + unit(bearing_rad) * self.config.ring_radius_m;
        let last = (self.config.rays - 1).max(1) as f64;
        let echoes = (0..self.config.rays).filter_map(|ray| {
            let share = if self.config.rays == 1 {
                0.0
            } else {
                ray as f64 / last - 0.5
            };
            self.ray_echo_m(
                caster,
                &transducer,
                unit(bearing_rad + share * self.config.opening_rad),
            )
        });
        echoes.min_by(f64::total_cmp)
    }

    /// Follows one ray until it comes back: half the way it made, if that is still heard.
    fn ray_echo_m(
        &self,
        caster: &Raycaster,
        transducer: &Point2<f64>,
        mut direction: Vector2<f64>,
    ) -> Option<f64> {
        let mut origin = *transducer;
        let mut way_m = 0.0;
        let mut heard_to_m = self.config.maximum_m;
        for reflected in 0..=self.config.reflections {
            let hit = caster.cast(&origin, &direction, 2.0 * self.config.maximum_m);
            // Two mirrors may have turned the ray back to where it came from: a corner.
            if reflected >= 2 {
                let back = transducer - origin;
                let back_m = back.dot(&direction);
                let missed_by_m = (back - direction * back_m).norm();
                let free = hit.is_none_or(|hit| hit.distance_m >= back_m);
                if back_m > 0.0 && missed_by_m <= self.config.capture_radius_m && free {
                    let range_m = (way_m + back_m) / 2.0;
                    return (range_m < heard_to_m).then_some(range_m);
                }
            }
            let hit = hit?;
            let material = caster.plan().walls()[hit.wall].material;
            way_m += hit.distance_m;
            heard_to_m *= material.reflectivity;
            if way_m >= 2.0 * heard_to_m {
                return None;
            }
            if hit.cos_incidence >= material.critical_angle_rad.cos() {
                return (way_m < heard_to_m).then_some(way_m); // back the way it came
            }
            origin += direction * (hit.distance_m - STEP_BACK_M);
            direction += hit.normal * (2.0 * hit.cos_incidence);
        }
        None
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

fn unit(angle_rad: f64) -> Vector2<f64> {
    Vector2::new(angle_rad.cos(), angle_rad.sin())
}
