//! The perception that a robot expects at a pose, from the plan of its building: H(x) of Ruiz-Mayor et al., *A performance
//! metric for mobile robot localization* (2006, below R06), 2 and 4.1.
//!
//! "The distance to the nearest line segment inside a sensor cone", for every sonar: no rebounds, no noise, no outliers.
//! For a laser, the distance along every beam.

mod saved;
mod sensor;

use super::{Building, Wall};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::Channel,
    seed::Seed,
};
use ndarray::ArrayView1;
use saved::Saved;
use sensor::{Model, RangeSensor, in_the_way};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A building's plan and the range sensors of a robot in it, ready to tell what they would measure anywhere. As JSON it
/// holds the walls themselves, so that it needs the world's file no more.
///
/// ```
/// use ballmark::{geometry::Pose, recording::Channel, seed::Seed, world::{Building, ExpectedRanges, SonarConfig, Sonar}};
/// let hall = Building::from_text(r#"
///     name = "hall"
///     [[wall]]
///     points = [[0, 0], [9, 0], [9, 4], [0, 4]]
///     closed = true
///     [robot]
///     kind = "sancho2"
///     [path]
///     corners = [[1, 2], [8, 2]]
///     [record]
///     every_m = 0.5
/// "#)?;
/// let ring = Sonar::new(SonarConfig::sancho2())?.channel();
/// let expected = ExpectedRanges::new(&hall, &[ring], Seed(1))?.at(&Pose::new(6.0, 2.0, 0.0));
/// assert!((expected[0] - 2.75).abs() < 1e-9); // ahead: 3 m less the radius of the ring
/// assert!((expected[6] - 5.75).abs() < 1e-9); // behind
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct ExpectedRanges {
    sensors: Vec<RangeSensor>,
}

impl ExpectedRanges {
    /// From a world's file: its walls, and what it says of the sensors behind these channels. Channels that no sonar or
    /// laser of the world makes are passed over. The building is as a surveyor finds it who draws its doors and things
    /// with `seed`.
    ///
    /// # Errors
    /// Where the file is no world, or no channel is left.
    pub fn of_world(file: &Path, channels: &[Channel], seed: Seed) -> Result<Self> {
        let building = Building::read(file)?;
        Self::new(&building, channels, seed).map_err(|fault| fault.in_file(file))
    }

    /// The same of a building at hand.
    ///
    /// # Errors
    /// As [`ExpectedRanges::of_world`].
    pub fn new(building: &Building, channels: &[Channel], seed: Seed) -> Result<Self> {
        let plan = building.plan_while_mapping(seed, 0)?.plan;
        let mut sensors = Vec::new();
        for set in building.sets().iter().take(1) {
            let sonar = set.sensors.sonar.as_ref().map(|sonar| {
                let height_m = sonar.config().height_m;
                let standing = |wall: &&Wall| wall.stands_at(height_m);
                Ok::<_, Error>((
                    Model::plain_sonar(sonar.config())?,
                    in_the_way(&plan, standing),
                ))
            });
            let laser = set.sensors.laser.as_ref().map(|laser| {
                let (height_m, clear_below) = (laser.config().height_m, laser.config().clear_below);
                let standing = |wall: &&Wall| {
                    wall.stands_at(height_m) && wall.material.infrared >= clear_below
                };
                Ok((
                    Model::exact_laser(laser.config())?,
                    in_the_way(&plan, standing),
                ))
            });
            for found in [sonar, laser].into_iter().flatten() {
                let (model, walls) = found?;
                let Some(channel) = channels.iter().find(|channel| model.makes(channel)) else {
                    continue;
                };
                sensors.push(RangeSensor::new(channel.clone(), model, walls)?);
            }
        }
        if sensors.is_empty() {
            let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
            return Err(Error::work(format!(
                "no channel among {} is a sonar or laser of this world, of as many readings in the same directions; expected one",
                names.join(", ")
            )));
        }
        Ok(Self { sensors })
    }

    /// Are the sensors there whose ranges are expected?
    ///
    /// # Errors
    /// Where a channel is missing or has another width or unit; the message names it.
    pub fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        let mut sensors = self.sensors.iter();
        sensors.try_for_each(|sensor| sensor.columns(channels).map(|_| ()))
    }

    /// The readings of these sensors out of all of a snapshot, z of R06 (2-2): metres, no return as the longest reading.
    /// `None` where nothing at all came back, or a channel is missing.
    pub fn sensed(&self, channels: &[Channel], values: ArrayView1<f32>) -> Option<Vec<f64>> {
        let (mut sensed, mut returned) = (Vec::new(), false);
        for sensor in &self.sensors {
            let longest_m = sensor.longest_m();
            for column in sensor.columns(channels).ok()? {
                let metres = f64::from(*values.get(column)?);
                returned |= (0.0..longest_m).contains(&metres);
                // What is past all bounds is no reading.
                let is_range = metres.is_finite() && metres >= 0.0;
                sensed.push(if is_range {
                    metres.min(longest_m)
                } else {
                    longest_m
                });
            }
        }
        returned.then_some(sensed)
    }

    /// H(x): what these sensors would read at a pose, in the order of [`ExpectedRanges::sensed`].
    pub fn at(&self, pose: &Pose) -> Vec<f64> {
        let sensors = self.sensors.iter();
        sensors
            .flat_map(|sensor| sensor.expected_at(pose))
            .collect()
    }

    /// Square of the Euclidean distance between H(x) and what was sensed; `None` as soon as it is sure to be `most` or
    /// more.
    pub fn square_distance(&self, pose: &Pose, sensed: &[f64], most: f64) -> Option<f64> {
        let expected = self
            .sensors
            .iter()
            .flat_map(|sensor| sensor.expected_at(pose));
        let mut square = 0.0;
        for (expected_m, sensed_m) in expected.zip(sensed) {
            square += (expected_m - sensed_m).powi(2);
            if square >= most {
                return None;
            }
        }
        Some(square)
    }

    /// The same sensors among those walls only that any of them can reach from within `radius_m` of a pose: there, it
    /// tells the same in less time.
    pub fn near(&self, centre: &Pose, radius_m: f64) -> Self {
        let sensors = self.sensors.iter();
        let near = sensors.map(|sensor| sensor.near(centre, radius_m));
        Self {
            sensors: near.collect(),
        }
    }
}

#[cfg(test)]
mod tests;
