//! The likelihood field of an occupancy map (Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, 6.4, table 6.3): a beam
//! is the more likely the nearer its end lies to something occupied, whatever stands between.

use super::{
    distance::distances,
    occupancy_map::{Occupancy, OccupancyMap},
    range_sensors::{RangeSensors, thinned},
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Observation, check_width},
};
use serde::{Deserialize, Serialize};

/// The constants of a likelihood field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LikelihoodFieldConfig {
    /// σ_hit: how far a beam's end scatters about what it hit, map and pose errors included, in metres.
    pub deviation_m: f64,
    /// z_rand / (z_hit + z_rand): share of readings that have nothing to do with the map.
    pub random_share: f64,
    /// Ends farther than this from anything occupied are all alike, in metres.
    pub farthest_m: f64,
    /// Beams of a scan that count, evenly spaced: neighbouring ones tell the same twice.
    pub beams: usize,
    /// The sensors that are held against the map. The end of a cone is that of its axis.
    pub sensors: RangeSensors,
}

impl Default for LikelihoodFieldConfig {
    fn default() -> Self {
        Self {
            deviation_m: 0.2,
            random_share: 0.05,
            farthest_m: 2.0,
            beams: 36,
            sensors: RangeSensors::default(),
        }
    }
}

impl LikelihoodFieldConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::usage(format!(
                "likelihood_field.{key} = {value}: expected {expected}"
            )))
        };
        for (key, value) in [
            ("deviation_m", self.deviation_m),
            ("farthest_m", self.farthest_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return wrong(key, value.to_string(), "metres above 0");
            }
        }
        if !(self.random_share > 0.0 && self.random_share < 1.0) {
            return wrong(
                "random_share",
                self.random_share.to_string(),
                "a share between 0 and 1",
            );
        }
        if self.beams == 0 {
            return wrong("beams", "0".into(), "1 or more");
        }
        self.sensors.check()
    }
}

/// A beam that came back: where it ended in the robot's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Metres ahead of the robot.
    pub ahead_m: f64,
    /// Metres to its left.
    pub left_m: f64,
}

/// ln p(z | ξ, map) of a single beam, for every place where it may end.
#[derive(Debug, Clone, PartialEq)]
pub struct LikelihoodField {
    cell_m: f64,
    origin_m: [f64; 2],
    width: usize,
    /// Row by row, from the south; each row from west to east.
    log_likelihood: Vec<f32>,
    /// Of an end outside of the map.
    outside: f32,
    beams: usize,
    sensors: RangeSensors,
}

impl LikelihoodField {
    /// The field of a map.
    ///
    /// # Errors
    /// Where a value of `config` makes no sense.
    pub fn new(map: &OccupancyMap, config: &LikelihoodFieldConfig) -> Result<Self> {
        config.check()?;
        let occupied: Vec<bool> = map
            .cells()
            .iter()
            .map(|c| *c == Occupancy::Occupied)
            .collect();
        let [width, _] = map.size();
        let hit = 1.0 - config.random_share;
        let of_distance = |distance_m: f64| {
            let deviations = distance_m.min(config.farthest_m) / config.deviation_m;
            (hit * (-0.5 * deviations * deviations).exp() + config.random_share).ln() as f32
        };
        let distance = distances(&occupied, width);
        Ok(Self {
            cell_m: map.cell_m(),
            origin_m: map.origin_m(),
            width,
            log_likelihood: distance
                .iter()
                .map(|&cells| of_distance(f64::from(cells) * map.cell_m()))
                .collect(),
            outside: of_distance(f64::INFINITY),
            beams: config.beams,
            sensors: config.sensors.clone(),
        })
    }

    /// Edge of a cell, in metres.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// South-west and north-east corner of the map, in metres.
    pub fn bounds_m(&self) -> ([f64; 2], [f64; 2]) {
        let height = self.log_likelihood.len() / self.width;
        let size_m = [self.width, height].map(|cells| cells as f64 * self.cell_m);
        let high = [0, 1].map(|axis| self.origin_m[axis] + size_m[axis]);
        (self.origin_m, high)
    }

    /// ln p of an end that lies outside of the map.
    pub fn outside(&self) -> f32 {
        self.outside
    }

    /// ln p of a beam that ends at a point, in metres.
    pub fn at(&self, x_m: f64, y_m: f64) -> f32 {
        let column = (x_m - self.origin_m[0]) / self.cell_m;
        let row = (y_m - self.origin_m[1]) / self.cell_m;
        self.in_cell(column, row)
    }

    /// The same of a point in cells east and north of the map's corner; no cell is NaN's.
    fn in_cell(&self, column: f64, row: f64) -> f32 {
        let within = |index: f64, count: usize| index >= 0.0 && index < count as f64;
        let height = self.log_likelihood.len() / self.width;
        match within(column, self.width) && within(row, height) {
            true => self.log_likelihood[row as usize * self.width + column as usize],
            false => self.outside,
        }
    }

    /// ln p(z | ξ) of some beams, taken as independent of each other: the sum over them, at one pose.
    pub fn log_likelihood(&self, pose: &Pose, beams: &[Beam]) -> f64 {
        let (sin, cos) = pose.heading_rad.sin_cos();
        // Everything in cells once, instead of two divisions a beam.
        let (sin, cos) = (sin / self.cell_m, cos / self.cell_m);
        let column = (pose.x_m - self.origin_m[0]) / self.cell_m;
        let row = (pose.y_m - self.origin_m[1]) / self.cell_m;
        let of_beam = |beam: &Beam| {
            let column = column + cos * beam.ahead_m - sin * beam.left_m;
            let row = row + sin * beam.ahead_m + cos * beam.left_m;
            f64::from(self.in_cell(column, row))
        };
        beams.iter().map(of_beam).sum()
    }

    /// The beams of an observation that count: evenly spaced among all, those without return left out.
    ///
    /// # Errors
    /// Where the observation has not as many values as the channels, no channel has ranges with bearings, or a sensor that the field
    /// is for is missing.
    pub fn beams(&self, channels: &[Channel], observation: &Observation) -> Result<Vec<Beam>> {
        let in_field = |error: Error| error.context("likelihood field");
        check_width(channels, observation.values.len()).map_err(in_field)?;
        let all = self.sensors.beams(channels).map_err(in_field)?;
        let beams = thinned(&all, self.beams);
        let returned = beams.iter().filter_map(|beam| {
            let range_m = f64::from(observation.values[beam.value]);
            let (sin, cos) = beam.bearing_rad.sin_cos();
            let from_middle_m = beam.offset_m + range_m;
            (range_m > 0.0 && range_m.is_finite()).then_some(Beam {
                ahead_m: from_middle_m * cos,
                left_m: from_middle_m * sin,
            })
        });
        Ok(returned.collect())
    }
}
