//! Every constant of a camera.

use crate::{error::Result, world::bounds::Bounds};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Where a camera looks, as seen from its robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Straight ahead.
    Ahead,
    /// To the left.
    #[default]
    Left,
    /// To the right.
    Right,
    /// At the ceiling, tilted up from ahead: the picture's right is the robot's right, its top is behind the robot.
    Up,
}

/// Every constant of a camera and its noise. Size and direction are Thrun's (1998, 5.1.1, 5.1.3); all else is assumed
/// from colour CCD cameras of that time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraConfig {
    /// Where it looks.
    pub look: Direction,
    /// Pixels from top to bottom.
    pub rows: usize,
    /// Pixels from left to right, as wide as they are high.
    pub columns: usize,
    /// Rays a pixel's side: each pixel is the mean of `samples` × `samples` of them.
    pub samples: usize,
    /// Full horizontal angle of view, radians.
    pub opening_rad: f64,
    /// Height of the lens above the floor, metres; it sits over the robot's centre.
    pub height_m: f64,
    /// How far away anything is seen, metres; beyond lies darkness.
    pub reach_m: f64,
    /// Share of the full scale that a white surface in full light comes to.
    pub exposure: f64,
    /// Share of the light past the full scale that spills over to pixels near by.
    pub bloom: f64,
    /// How far it spills, pixels.
    pub bloom_pixels: f64,
    /// Standard deviation of the noise in the dark, in steps of the 255.
    pub read_noise: f64,
    /// Electrons that a pixel holds at full scale; their number is uncertain by its root. ∞: no shot noise.
    pub full_well: f64,
}

impl Default for CameraConfig {
    fn default() -> Self {
        Self {
            look: Direction::default(),
            rows: 60,
            columns: 64,
            samples: 2,
            opening_rad: 50_f64.to_radians(),
            height_m: 1.2,
            reach_m: 50.0,
            exposure: 0.8,
            bloom: 0.1,
            bloom_pixels: 3.0,
            read_noise: 1.5,
            full_well: 20_000.0,
        }
    }
}

impl CameraConfig {
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("camera");
        for (key, count, least, most) in [
            ("rows", self.rows, 10, 1000),
            ("columns", self.columns, 10, 1000),
            ("samples", self.samples, 1, 8),
        ] {
            if !(least..=most).contains(&count) {
                return bounds.wrong(key, count as f64, &format!("{least} to {most}"));
            }
        }
        if !(self.opening_rad > 0.0 && self.opening_rad < 0.9 * PI) {
            return bounds.wrong("opening_rad", self.opening_rad, "above 0, below 0.9 π");
        }
        bounds.positive(&[
            ("height_m", self.height_m),
            ("reach_m", self.reach_m),
            ("exposure", self.exposure),
            ("bloom_pixels", self.bloom_pixels),
        ])?;
        if !(0.0..=1.0).contains(&self.bloom) {
            return bounds.wrong("bloom", self.bloom, "0 to 1");
        }
        if !(self.read_noise >= 0.0 && self.read_noise.is_finite()) {
            return bounds.wrong("read_noise", self.read_noise, "0 or more");
        }
        if self.full_well.is_nan() || self.full_well <= 0.0 {
            return bounds.wrong("full_well", self.full_well, "more than 0");
        }
        Ok(())
    }
}
