//! A laser range-finder: a fan of thin beams in one plane.

use super::{Surroundings, Wall, bounds::Bounds};
use crate::{
    error::Result,
    geometry::{Displacement, Pose, wrapped},
    recording::Channel,
};
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Every constant of the scanner and its noise. Defaults: a SICK LMS-200's half circle, a beam a degree, centimetres;
/// the noise is assumed from that sensor's usual data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LaserConfig {
    /// Number of beams.
    pub beams: usize,
    /// Full width of the fan, radians, centred ahead. The beams share it evenly, each in the middle of its share; the
    /// first is the one farthest to the right.
    pub field_of_view_rad: f64,
    /// Distance of the scanner ahead of the robot's centre, metres; ranges count from the scanner.
    pub ahead_m: f64,
    /// Height of the scanner above the floor, metres.
    pub height_m: f64,
    /// Shortest reading, metres.
    pub minimum_m: f64,
    /// Longest reading; from there on there is no return, metres.
    pub maximum_m: f64,
    /// Materials with less `infrared` than this let the beam through, as glass does.
    pub clear_below: f64,
    /// Standard deviation of the range noise at range 0, metres.
    pub noise_m: f64,
    /// What a metre of range adds to that standard deviation, metres a metre.
    pub noise_per_m: f64,
    /// Step of the readings, metres; 0: continuous.
    pub resolution_m: f64,
    /// Probability that a reading is false (dust, an edge half hit): uniform between the minimum and the range that it
    /// replaces.
    pub short_probability: f64,
    /// Probability that a beam doesn't come back.
    pub lost_probability: f64,
}

impl Default for LaserConfig {
    fn default() -> Self {
        Self {
            beams: 180,
            field_of_view_rad: PI,
            ahead_m: 0.1,
            height_m: 0.35,
            minimum_m: 0.02,
            maximum_m: 20.0,
            clear_below: 0.15,
            noise_m: 0.01,
            noise_per_m: 0.0005,
            resolution_m: 0.01,
            short_probability: 0.001,
            lost_probability: 0.001,
        }
    }
}

/// Most beams of a scanner: far beyond any real one, small enough to allocate.
const MOST: usize = 10_000;
/// A beam goes through at most so many panes.
const MAX_PANES: usize = 16;
/// Behind a pane the beam starts again this much farther on.
const STEP_M: f64 = 1e-6;

impl LaserConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("laser");
        if !(1..=MOST).contains(&self.beams) {
            return bounds.wrong("beams", self.beams as f64, &format!("1 to {MOST}"));
        }
        if !(self.field_of_view_rad > 0.0 && self.field_of_view_rad <= TAU) {
            let expected = "above 0, up to 2π";
            return bounds.wrong("field_of_view_rad", self.field_of_view_rad, expected);
        }
        if !self.ahead_m.is_finite() {
            return bounds.wrong("ahead_m", self.ahead_m, "metres");
        }
        bounds.not_negative(&[
            ("height_m", self.height_m),
            ("minimum_m", self.minimum_m),
            ("noise_m", self.noise_m),
            ("noise_per_m", self.noise_per_m),
            ("resolution_m", self.resolution_m),
        ])?;
        if !(self.maximum_m > self.minimum_m && self.maximum_m.is_finite()) {
            return bounds.wrong("maximum_m", self.maximum_m, "more than `minimum_m`");
        }
        bounds.shares(&[
            ("clear_below", self.clear_below),
            ("short_probability", self.short_probability),
            ("lost_probability", self.lost_probability),
        ])?;
        Ok(())
    }
}

/// A laser scanner whose constants have been checked.
///
/// ```
/// use ballmark::{geometry::Pose, world::{laser::{Laser, LaserConfig}, FloorPlan, Material, Raycaster, Wall}};
/// use nalgebra::Point2;
/// let wall = Wall::new(Point2::new(2.1, -9.0), Point2::new(2.1, 9.0), Material::PLAIN);
/// let caster = Raycaster::new(FloorPlan::new(vec![wall])?);
/// let laser = Laser::new(LaserConfig { beams: 181, field_of_view_rad: 181_f64.to_radians(), ..Default::default() })?;
/// let range_m = |beam| laser.range_m(&(&caster).into(), &Pose::default(), beam).unwrap();
/// assert!((range_m(90) - 2.0).abs() < 1e-9); // straight ahead, from the scanner 0.1 m before the centre
/// assert!((range_m(150) - 4.0).abs() < 1e-9); // 60° to the left
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Laser {
    config: LaserConfig,
}

impl Laser {
    /// A scanner of these constants.
    ///
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn new(config: LaserConfig) -> Result<Self> {
        config.check()?;
        Ok(Self { config })
    }

    /// The constants.
    pub fn config(&self) -> &LaserConfig {
        &self.config
    }

    /// The channel that its readings make.
    pub fn channel(&self) -> Channel {
        let beams = 0..self.config.beams;
        Channel {
            name: "laser".into(),
            width: self.config.beams,
            unit: "m".into(),
            bearing_rad: Some(beams.map(|beam| self.bearing_rad(beam)).collect()),
            maximum: Some(self.config.maximum_m),
            offset_m: None,
        }
    }

    /// Direction of a beam in the robot's frame, in (−π, π].
    pub fn bearing_rad(&self, beam: usize) -> f64 {
        let share = (beam as f64 + 0.5) / self.config.beams as f64 - 0.5;
        wrapped(share * self.config.field_of_view_rad)
    }

    /// One scan at a pose, with noise, `[beam]`: metres, NaN = no return.
    pub fn read(&self, around: &Surroundings, pose: &Pose, random: &mut impl Rng) -> Vec<f32> {
        (0..self.config.beams)
            .map(|beam| {
                self.corrupted(self.range_m(around, pose, beam), random)
                    .map_or(f32::NAN, |metres| metres as f32)
            })
            .collect()
    }

    /// Where a beam ends, without noise, in metres from the scanner; `None` from the maximum on.
    pub fn range_m(&self, around: &Surroundings, pose: &Pose, beam: usize) -> Option<f64> {
        let c = &self.config;
        let scanner = pose.after(Displacement {
            forward_m: c.ahead_m,
            ..Displacement::default()
        });
        let angle_rad = pose.heading_rad + self.bearing_rad(beam);
        let direction = Vector2::new(angle_rad.cos(), angle_rad.sin());
        let start = Point2::new(scanner.x_m, scanner.y_m);
        let clear = |wall: &Wall| wall.material.infrared < c.clear_below;
        let mut passed_m = 0.0;
        for _ in 0..=MAX_PANES {
            let origin = start + direction * passed_m;
            let hit = around.cast(&origin, &direction, c.maximum_m - passed_m, c.height_m)?;
            let range_m = passed_m + hit.distance_m;
            if !clear(around.wall(&hit)) {
                return (range_m < c.maximum_m).then_some(range_m);
            }
            passed_m = range_m + STEP_M;
        }
        None
    }

    /// What the scanner reports of a range.
    fn corrupted(&self, range_m: Option<f64>, random: &mut impl Rng) -> Option<f64> {
        let c = &self.config;
        // The same three draws for every reading, so that what happens to one reading never shifts the next one's.
        let (outcome, place): (f64, f64) = (random.random(), random.random());
        let normal: f64 = random.sample(StandardNormal);
        if outcome < c.short_probability {
            let until_m = range_m.unwrap_or(c.maximum_m).max(c.minimum_m);
            return Some(c.minimum_m + place * (until_m - c.minimum_m));
        }
        if outcome >= 1.0 - c.lost_probability {
            return None;
        }
        let range_m = range_m?;
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
mod tests;
