//! A landmark chosen by people: is there a door beside the robot?
//!
//! Koenig & Simmons, *Passive distance learning for robot navigation* (1996), as the baseline that Thrun (1998), 5.1.2 and
//! 5.3, gives his first two data sets. How they found their doors is not described. Ours go by three things: a door is set back in
//! its frame, or open, so that the wall beside the robot is farther away than walls are; and to a camera that looks there it
//! is darker than its surroundings, and grained. All of it from sensor values, none from a plan. Ranges tell how far apart the
//! walls are and not which of them gave way, so without a camera a door on the other side counts too.

use super::{
    Detector,
    camera::{BRIGHTNESS, Camera, STRIPS, TEXTURE_IN_RED, probability},
    check_width,
};
use crate::{
    error::{Error, Result},
    geometry::wrapped,
    recording::{Channel, Recording},
};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, Axis};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Which side of the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// Counter-clockwise of ahead.
    Left,
    /// Clockwise of ahead.
    Right,
}

/// What counts as evidence of a door, and how much: each part is added as it exceeds `…_from`, in units of `…_step`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DoorConfig {
    /// The side looked at, also by the camera.
    pub side: Side,
    /// Metres by which the walls are farther apart than usual, abeam of the robot, that speak for a door.
    pub recess_step_m: f64,
    /// More metres than this say no more; no return on the side looked at says as much.
    pub recess_most_m: f64,
    /// Without a camera, the recess that leaves a door as likely as not, metres.
    pub recess_alone_m: f64,
    /// By how much the middle of the image is darker than all of it, in its standard deviations.
    pub darkness_from: f64,
    /// Likewise.
    pub darkness_step: f64,
    /// Differences of neighbouring pixels in red there, likewise.
    pub texture_from: f64,
    /// Likewise.
    pub texture_step: f64,
    /// The sum of the three that leaves a door as likely as not.
    pub evidence_needed: f64,
}

impl Default for DoorConfig {
    /// Chosen on the first data set of the simulated corridor, with what [`Door`] says came of it.
    fn default() -> Self {
        Self {
            side: Side::Right,
            recess_step_m: 0.1,
            recess_most_m: 0.3,
            recess_alone_m: 0.06,
            darkness_from: 0.1,
            darkness_step: 0.15,
            texture_from: 0.13,
            texture_step: 0.03,
            evidence_needed: 1.5,
        }
    }
}

impl DoorConfig {
    /// # Errors
    /// A usage error that names the first constant out of bounds.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: f64, expected: &str| {
            let message = format!("door.{key} = {value}: expected {expected}");
            Err(Error::usage(message))
        };
        for (key, value) in [
            ("recess_step_m", self.recess_step_m),
            ("recess_most_m", self.recess_most_m),
            ("darkness_step", self.darkness_step),
            ("texture_step", self.texture_step),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                return wrong(key, value, "more than 0");
            }
        }
        for (key, value) in [
            ("recess_alone_m", self.recess_alone_m),
            ("darkness_from", self.darkness_from),
            ("texture_from", self.texture_from),
            ("evidence_needed", self.evidence_needed),
        ] {
            if !value.is_finite() {
                return wrong(key, value, "a finite number");
            }
        }
        Ok(())
    }
}

/// The one feature: a door is beside the robot.
///
/// On the first data set of the simulated corridor, whose camera looks at many narrow doors, its precision against the plan
/// is .77 and its recall .83 (one point of the wall abeam of the robot is a door's or not), and the same in runs of another
/// seed; on the second, where doors are few and a hallway, an elevator and blackboards are taken for some, .42 and .84. By
/// sonar alone it is .55 and .68, and .27 and .77.
///
/// ```
/// use ballmark::{detector::{Detector, door::{Door, DoorConfig}}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, spacing_m: 1.0, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let all: Vec<usize> = (0..recording.len()).collect();
/// let door = Door::fit(&DoorConfig::default(), &recording, &all)?;
/// assert_eq!(door.probabilities(&recording)?.dim(), (recording.len(), 1));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Door {
    config: DoorConfig,
    /// What the two readings abeam usually add up to, metres.
    between_walls_m: f64,
}

/// A beam within this of abeam looks abeam, radians.
const ABEAM_RAD: f64 = 0.14;

impl Door {
    /// Learns, from some snapshots, how far apart the walls usually are: the median of what the readings to both sides add
    /// up to.
    ///
    /// # Errors
    /// Where no range sensor looks to both sides, or none of the snapshots has a return on both.
    pub fn fit(config: &DoorConfig, recording: &Recording, snapshots: &[usize]) -> Result<Self> {
        config.check()?;
        let abeam = Abeam::find(recording.channels(), config.side)?;
        let values = |&k: &usize| recording.values().row(k);
        let both = snapshots
            .iter()
            .map(values)
            .filter_map(|values| abeam.both_m(values));
        let mut both: Vec<f64> = both.collect();
        both.sort_by(f64::total_cmp);
        let Some(&between_walls_m) = both.get(both.len() / 2) else {
            return Err(Error::work(
                "doors: no snapshot with returns from both sides; expected some to learn the usual width from",
            ));
        };
        Ok(Self {
            config: config.clone(),
            between_walls_m,
        })
    }

    /// How much farther than usual the walls are apart here. Where the other side is silent, it is taken to be half of the
    /// usual away.
    fn recess_m(&self, abeam: &Abeam, values: ArrayView1<f32>) -> f64 {
        let other_m = abeam.other_m(values).unwrap_or(self.between_walls_m / 2.0);
        abeam
            .looked_at_m(values)
            .map_or(self.config.recess_most_m, |side_m| {
                (side_m + other_m - self.between_walls_m).min(self.config.recess_most_m)
            })
    }

    /// Above 0: rather a door than none.
    fn evidence(&self, recess_m: f64, camera: Option<&Camera>, values: ArrayView1<f32>) -> f64 {
        let c = &self.config;
        let Some(camera) = camera else {
            return (recess_m - c.recess_alone_m) / c.recess_step_m;
        };
        let middle = |value| {
            let column = |column| camera.column(values, column, value);
            (column(STRIPS / 2 - 1) + column(STRIPS / 2)) / 2.0
        };
        (-middle(BRIGHTNESS) - c.darkness_from) / c.darkness_step
            + (middle(TEXTURE_IN_RED) - c.texture_from) / c.texture_step
            + recess_m / c.recess_step_m
            - c.evidence_needed
    }
}

impl Detector for Door {
    fn features(&self) -> usize {
        1
    }

    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        check_width(channels, values)?;
        let abeam = Abeam::find(channels, self.config.side)?;
        let camera = Camera::find(channels);
        let seen = values.rows().into_iter().map(|values| {
            let recess_m = self.recess_m(&abeam, values);
            probability(self.evidence(recess_m, camera.as_ref(), values))
        });
        Ok(seen.collect::<Array1<f32>>().insert_axis(Axis(1)))
    }
}

/// The readings that look to the sides.
struct Abeam {
    looked_at: usize,
    other: usize,
    maximum_m: f64,
}

impl Abeam {
    fn find(channels: &[Channel], side: Side) -> Result<Self> {
        let mut from = 0;
        for channel in channels {
            let bearings = channel
                .bearing_rad
                .as_deref()
                .filter(|_| channel.unit == "m");
            let towards = |bearing_rad: f64| {
                let off = bearings?.iter().map(|b| wrapped(b - bearing_rad).abs());
                let nearest = off.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
                let (index, off) = nearest?;
                (off <= ABEAM_RAD).then_some(from + index)
            };
            if let (Some(left), Some(right)) = (towards(FRAC_PI_2), towards(-FRAC_PI_2)) {
                let (looked_at, other) = match side {
                    Side::Left => (left, right),
                    Side::Right => (right, left),
                };
                return Ok(Self {
                    looked_at,
                    other,
                    maximum_m: channel.maximum.unwrap_or(f64::INFINITY),
                });
            }
            from += channel.width;
        }
        Err(Error::work(
            "doors: expected a channel with unit `m` and bearings that looks to both sides (±90°)",
        ))
    }

    fn range_m(&self, values: ArrayView1<f32>, index: usize) -> Option<f64> {
        let range_m = f64::from(values[index]);
        (range_m >= 0.0 && range_m < self.maximum_m).then_some(range_m)
    }

    fn looked_at_m(&self, values: ArrayView1<f32>) -> Option<f64> {
        self.range_m(values, self.looked_at)
    }

    fn other_m(&self, values: ArrayView1<f32>) -> Option<f64> {
        self.range_m(values, self.other)
    }

    fn both_m(&self, values: ArrayView1<f32>) -> Option<f64> {
        Some(self.looked_at_m(values)? + self.other_m(values)?)
    }
}

#[cfg(test)]
mod tests;
