//! A ring of infrared sensors: ranges derived from how much light comes back, so a dark wall seems farther.

use super::{Surroundings, bounds::Bounds};
use crate::{
    error::Result,
    geometry::{Pose, wrapped},
    recording::Channel,
};
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Every constant of the ring and its noise. Defaults: the 16 sensors of a Nomad 200 (Duckett & Nehmzow 1998, 5, gives
/// their number; all else is assumed: such sensors reach some 60 cm and tell inches).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InfraredConfig {
    /// Number of sensors, evenly spaced counter-clockwise, the first straight ahead.
    pub beams: usize,
    /// Distance of the sensors from the robot's centre, metres; ranges count from the sensor.
    pub ring_radius_m: f64,
    /// Height of the ring above the floor, metres.
    pub height_m: f64,
    /// Full opening of the beam, radians.
    pub opening_rad: f64,
    /// Rays that sample the beam, evenly from edge to edge.
    pub rays: usize,
    /// `Material::infrared` of the wall that the ring is calibrated to: met head-on, such a wall reads its distance.
    pub calibrated_to: f64,
    /// Shortest reading, metres: with more light than from there the sensor is saturated.
    pub minimum_m: f64,
    /// Longest reading, metres; with less light than from there, there is no return.
    pub maximum_m: f64,
    /// Standard deviation of the amplifier's gain, relative.
    pub gain_sd: f64,
    /// Standard deviation of the stray light, as a share of the light that comes back from the maximum.
    pub stray_sd: f64,
    /// Step of the readings, metres; 0: continuous.
    pub resolution_m: f64,
}

impl Default for InfraredConfig {
    fn default() -> Self {
        Self {
            beams: 16,
            ring_radius_m: 0.22,
            height_m: 0.5,
            opening_rad: 20_f64.to_radians(),
            rays: 5,
            calibrated_to: 0.7,
            minimum_m: 0.05,
            maximum_m: 0.6,
            gain_sd: 0.05,
            stray_sd: 0.1,
            resolution_m: 0.0254,
        }
    }
}

/// Most sensors of a ring, or rays of a beam: far beyond any real one, small enough to allocate.
const MOST: usize = 10_000;

impl InfraredConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("infrared");
        for (key, count) in [("beams", self.beams), ("rays", self.rays)] {
            if !(1..=MOST).contains(&count) {
                return bounds.wrong(key, count as f64, &format!("1 to {MOST}"));
            }
        }
        // Short of a half circle: a ray along the wall would meet it nowhere.
        if !(self.opening_rad >= 0.0 && self.opening_rad < PI) {
            return bounds.wrong("opening_rad", self.opening_rad, "0 to less than π");
        }
        if !(self.calibrated_to > 0.0 && self.calibrated_to <= 1.0) {
            return bounds.wrong("calibrated_to", self.calibrated_to, "above 0, up to 1");
        }
        bounds.not_negative(&[
            ("ring_radius_m", self.ring_radius_m),
            ("height_m", self.height_m),
            ("minimum_m", self.minimum_m),
            ("gain_sd", self.gain_sd),
            ("stray_sd", self.stray_sd),
            ("resolution_m", self.resolution_m),
        ])?;
        if !(self.maximum_m > self.minimum_m && self.maximum_m.is_finite()) {
            return bounds.wrong("maximum_m", self.maximum_m, "more than `minimum_m`");
        }
        Ok(())
    }
}

/// A ring of infrared sensors whose constants have been checked.
///
/// A sensor lights up a spot and measures what comes back. Of a matt wall that is ρ cos θ / d²: its reflectivity, the
/// cosine of the angle at which it is met, and the square of the distance. Knowing neither ρ nor θ, the sensor gives the
/// distance from which its calibration wall, met head-on, would send as much. Over the rays of its beam the light is
/// averaged, so that a wall's edge in the beam reads farther than the whole wall.
///
/// ```
/// use ballmark::{geometry::Pose, world::{infrared::{Infrared, InfraredConfig}, FloorPlan, Material, Raycaster, Wall}};
/// use nalgebra::Point2;
/// let ring = Infrared::new(InfraredConfig { ring_radius_m: 0.0, ..Default::default() })?;
/// let range_m = |infrared| {
///     let paint = Material { infrared, ..Material::PLAIN };
///     let wall = Wall::new(Point2::new(0.2, -1.0), Point2::new(0.2, 1.0), paint);
///     let caster = Raycaster::new(FloorPlan::new(vec![wall]).unwrap());
///     ring.range_m(&(&caster).into(), &Pose::default(), 0).unwrap()
/// };
/// assert!((range_m(0.7) - 0.2).abs() < 1e-9);
/// assert!((range_m(0.175) - 0.4).abs() < 1e-9); // a quarter of the light: as from twice as far
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Infrared {
    config: InfraredConfig,
    /// Light of the calibration wall at one metre, head-on.
    reference: f64,
}

impl Infrared {
    /// A ring of these constants.
    ///
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn new(config: InfraredConfig) -> Result<Self> {
        config.check()?;
        // Aside of a beam that meets a wall head-on, a ray is 1 / cos longer and meets it at that cosine: cos³ in all.
        let shares = (0..config.rays).map(|ray| config.aside_rad(ray).cos().powi(3));
        let reference = config.calibrated_to * shares.sum::<f64>() / config.rays as f64;
        Ok(Self { config, reference })
    }

    /// The constants.
    pub fn config(&self) -> &InfraredConfig {
        &self.config
    }

    /// The channel that its readings make.
    pub fn channel(&self) -> Channel {
        let beams = 0..self.config.beams;
        Channel {
            name: "infrared".into(),
            width: self.config.beams,
            unit: "m".into(),
            bearing_rad: Some(beams.map(|beam| self.bearing_rad(beam)).collect()),
            maximum: Some(self.config.maximum_m),
            offset_m: (self.config.ring_radius_m > 0.0)
                .then(|| vec![self.config.ring_radius_m; self.config.beams]),
        }
    }

    /// Direction of a sensor in the robot's frame, in (−π, π].
    pub fn bearing_rad(&self, beam: usize) -> f64 {
        wrapped(TAU * beam as f64 / self.config.beams as f64)
    }

    /// One reading of every sensor at a pose, with noise, `[beam]`: metres, NaN = no return.
    pub fn read(&self, around: &Surroundings, pose: &Pose, random: &mut impl Rng) -> Vec<f32> {
        (0..self.config.beams)
            .map(|beam| {
                let light = self.light(around, pose, beam);
                self.told_m(self.disturbed(light, random))
                    .map_or(f32::NAN, |metres| metres as f32)
            })
            .collect()
    }

    /// What a sensor takes for the range, without noise or steps, in metres; `None` from the maximum on.
    pub fn range_m(&self, around: &Surroundings, pose: &Pose, beam: usize) -> Option<f64> {
        self.seeming_m(self.light(around, pose, beam))
    }

    /// Light that comes back to a sensor, where a white wall that fills its beam from a metre would send 1.
    fn light(&self, around: &Surroundings, pose: &Pose, beam: usize) -> f64 {
        let c = &self.config;
        let axis_rad = pose.heading_rad + self.bearing_rad(beam);
        let sensor = Point2::new(pose.x_m, pose.y_m) + unit(axis_rad) * c.ring_radius_m;
        // From three times the maximum less than a sixth of what differs from nothing comes back, off white too.
        let reach_m = 3.0 * c.maximum_m;
        let returned = (0..c.rays).map(|ray| {
            let direction = unit(axis_rad + c.aside_rad(ray));
            let hit = around.cast(&sensor, &direction, reach_m, c.height_m);
            hit.map_or(0.0, |hit| {
                let reflectivity = around.wall(&hit).material.infrared;
                // A sensor that touches the wall sees light without end: as good as from a tenth of a millimetre.
                reflectivity * hit.cos_incidence / hit.distance_m.max(1e-4).powi(2)
            })
        });
        returned.sum::<f64>() / c.rays as f64
    }

    /// The light as the photodiode and its amplifier have it.
    fn disturbed(&self, light: f64, random: &mut impl Rng) -> f64 {
        let gain_normal: f64 = random.sample(StandardNormal);
        let stray_normal: f64 = random.sample(StandardNormal);
        let least = self.reference / self.config.maximum_m.powi(2);
        light * (1.0 + self.config.gain_sd * gain_normal)
            + self.config.stray_sd * least * stray_normal
    }

    /// The distance from which the calibration wall would send this light.
    fn seeming_m(&self, light: f64) -> Option<f64> {
        let metres = (self.reference / light.max(0.0)).sqrt();
        (metres < self.config.maximum_m).then_some(metres)
    }

    /// What the sensor reports of this light.
    fn told_m(&self, light: f64) -> Option<f64> {
        let (c, metres) = (&self.config, self.seeming_m(light)?);
        let stepped_m = if c.resolution_m > 0.0 {
            (metres / c.resolution_m).round() * c.resolution_m
        } else {
            metres
        };
        (stepped_m < c.maximum_m).then_some(stepped_m.max(c.minimum_m))
    }
}

impl InfraredConfig {
    /// How far aside of its beam's middle a ray points.
    fn aside_rad(&self, ray: usize) -> f64 {
        if self.rays == 1 {
            return 0.0;
        }
        (ray as f64 / (self.rays - 1) as f64 - 0.5) * self.opening_rad
    }
}

fn unit(angle_rad: f64) -> Vector2<f64> {
    Vector2::new(angle_rad.cos(), angle_rad.sin())
}

#[cfg(test)]
mod tests;
