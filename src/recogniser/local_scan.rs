//! From an observation to the local grid of what it says, in a frame that does not depend on where the robot faces.
//!
//! With a compass, north is up, as Duckett & Nehmzow (2000) held their turret. Without one, the walls run along the axes
//! ([`super::angle_histogram`]), and which of the four ways is up is left to who matches.

use super::{
    angle_histogram::main_direction,
    occupancy::{OccupancyGrid, Reading, ReadingModel, States},
};
use crate::{
    error::{Error, Result},
    recording::{Channel, Observation},
};
use serde::{Deserialize, Serialize};

/// How range readings become a grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScanConfig {
    /// Opening of a sonar's cone, radians: of channels whose name begins with `sonar`.
    pub sonar_opening_rad: f64,
    /// Opening that a beam of light is given, radians: of all other range channels. Wide enough that neighbouring beams
    /// leave no gap.
    pub light_opening_rad: f64,
    /// What a reading is worth.
    pub reading: ReadingModel,
}

impl Default for ScanConfig {
    /// 30° (Moravec & Elfes 1985), and 2° for laser scanners of a beam a degree.
    fn default() -> Self {
        Self {
            sonar_opening_rad: 30_f64.to_radians(),
            light_opening_rad: 2_f64.to_radians(),
            reading: ReadingModel::default(),
        }
    }
}

impl ScanConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: f64, expected: &str| {
            let told = format!("scan: `{key}` is {value}; expected {expected}");
            Err(Error::usage(told))
        };
        for (key, opening) in [
            ("sonar_opening_rad", self.sonar_opening_rad),
            ("light_opening_rad", self.light_opening_rad),
        ] {
            if !(opening > 0.0 && opening <= std::f64::consts::TAU) {
                return wrong(key, opening, "more than 0, up to a whole turn");
            }
        }
        let ReadingModel {
            minimum_m,
            range_error_m,
        } = self.reading;
        if !(minimum_m >= 0.0 && minimum_m.is_finite()) {
            return wrong("reading.minimum_m", minimum_m, "0 or more");
        }
        if !(range_error_m > 0.0 && range_error_m.is_finite()) {
            return wrong("reading.range_error_m", range_error_m, "more than 0");
        }
        Ok(())
    }

    /// Is there a channel to make grids of?
    ///
    /// # Errors
    /// Where no channel holds ranges in metres with a bearing each; the message says so.
    pub fn needs(channels: &[Channel]) -> Result<()> {
        if channels.iter().any(|channel| bearings(channel).is_some()) {
            return Ok(());
        }
        Err(Error::work(
            "occupancy grids: no channel of ranges; expected one with unit `m` and a bearing for each value",
        ))
    }

    /// The grid of a snapshot. With `north_up` it needs a compass; else the walls run along its axes. `None` where nothing
    /// came back within the grid's reach, or the compass is lacking.
    pub fn grid(
        &self,
        channels: &[Channel],
        observation: &Observation,
        north_up: bool,
    ) -> Option<States> {
        let mut readings = self.readings(channels, observation);
        let turn_rad = match north_up {
            true => observation.compass_rad.filter(|rad| rad.is_finite())?,
            false => -main_direction(&readings).unwrap_or(0.0),
        };
        for reading in &mut readings {
            reading.bearing_rad += turn_rad;
        }
        let states = OccupancyGrid::of(&readings, &self.reading).states();
        (states.known() > 0).then_some(states)
    }

    /// All readings that came back, in the robot's frame.
    fn readings(&self, channels: &[Channel], observation: &Observation) -> Vec<Reading> {
        let mut readings = Vec::new();
        let mut values = observation.values.iter();
        for channel in channels {
            let of_channel = values.by_ref().take(channel.width);
            let Some(bearing_rad) = bearings(channel) else {
                of_channel.for_each(drop);
                continue;
            };
            let opening_rad = match channel.name.starts_with("sonar") {
                true => self.sonar_opening_rad,
                false => self.light_opening_rad,
            };
            let no_return_m = channel.maximum.unwrap_or(f64::INFINITY);
            let heard = of_channel
                .zip(bearing_rad)
                .filter_map(|(&range, &bearing_rad)| {
                    let range_m = f64::from(range);
                    (range_m.is_finite() && range_m < no_return_m).then_some(Reading {
                        bearing_rad,
                        range_m,
                        opening_rad,
                    })
                });
            readings.extend(heard);
        }
        readings
    }
}

/// The bearings of a channel of ranges.
fn bearings(channel: &Channel) -> Option<&[f64]> {
    channel
        .bearing_rad
        .as_deref()
        .filter(|_| channel.unit == "m")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Pose, recogniser::occupancy::State};
    use ndarray::Array1;
    use std::f64::consts::{FRAC_PI_2, TAU};

    const BEAMS: usize = 180;

    fn channels() -> Vec<Channel> {
        let camera = Channel {
            name: "camera".into(),
            width: 2,
            unit: "grey".into(),
            bearing_rad: None,
            maximum: None,
        };
        let laser = Channel {
            name: "laser".into(),
            width: BEAMS,
            unit: "m".into(),
            bearing_rad: Some((0..BEAMS).map(|i| TAU * i as f64 / BEAMS as f64).collect()),
            maximum: Some(8.0),
        };
        vec![camera, laser]
    }

    /// A room from −2 to 3 m by −1 to 2 m, from the origin.
    fn room(heading_rad: f64) -> Array1<f32> {
        let ranges = (0..BEAMS).map(|i| {
            let (sin, cos) = (TAU * i as f64 / BEAMS as f64 + heading_rad).sin_cos();
            let in_x = if cos > 0.0 { 3.0 / cos } else { -2.0 / cos };
            let in_y = if sin > 0.0 { 2.0 / sin } else { -1.0 / sin };
            in_x.min(in_y) as f32
        });
        [7.0, 9.0].into_iter().chain(ranges).collect()
    }

    fn seen(values: &Array1<f32>, compass_rad: Option<f64>) -> Observation<'_> {
        Observation {
            stamp_s: 0.0,
            values: values.view(),
            odometry: Pose::default(),
            compass_rad,
        }
    }

    fn agreeing(a: &States, b: &States) -> usize {
        let cells = (0..64).flat_map(|x| (0..64).map(move |y| (x, y)));
        cells.filter(|&(x, y)| a.at(x, y) == b.at(x, y)).count()
    }

    #[test]
    fn with_a_compass_the_heading_does_not_matter() {
        let (config, channels) = (ScanConfig::default(), channels());
        let of = |heading_rad: f64| {
            let values = room(heading_rad);
            let observation = seen(&values, Some(heading_rad));
            config.grid(&channels, &observation, true).unwrap()
        };
        let ahead = of(0.0);
        assert_eq!(ahead.at(32 + 10, 32), State::Empty);
        assert_eq!(ahead.at(32 + 19, 33), State::Occupied); // 2.925 m of 3
        assert_eq!(ahead.at(32 + 25, 32), State::Unknown);
        for heading_rad in [0.4, 1.7, -2.9] {
            let same = agreeing(&ahead, &of(heading_rad));
            assert!(same > 4000, "{heading_rad}: {same}");
        }
        let values = room(0.0);
        assert_eq!(config.grid(&channels, &seen(&values, None), true), None);
    }

    #[test]
    fn without_one_it_matters_by_quarter_turns_only() {
        let (config, channels) = (ScanConfig::default(), channels());
        let of = |heading_rad: f64| {
            let values = room(heading_rad);
            config.grid(&channels, &seen(&values, None), false).unwrap()
        };
        let ahead = of(0.0);
        for heading_rad in [0.4, 1.2, FRAC_PI_2 + 0.1, -2.9] {
            let turned = of(heading_rad);
            let turns = std::iter::successors(Some(turned), |t| Some(t.quarter_turn()));
            let same = turns.take(4).map(|t| agreeing(&ahead, &t)).max().unwrap();
            assert!(same > 3950, "{heading_rad}: {same}");
        }
    }

    #[test]
    fn nothing_heard_is_no_grid_and_no_ranges_are_told() {
        let (config, channels) = (ScanConfig::default(), channels());
        for silence in [f32::NAN, 8.0, f32::INFINITY, -1.0] {
            let values = Array1::from_elem(BEAMS + 2, silence);
            let observation = seen(&values, Some(0.0));
            assert_eq!(
                config.grid(&channels, &observation, true),
                None,
                "{silence}"
            );
        }
        let short = Array1::from_elem(1, 2.0);
        assert_eq!(config.grid(&channels, &seen(&short, None), false), None);
        assert!(ScanConfig::needs(&channels).is_ok());
        let error = ScanConfig::needs(&channels[..1]).unwrap_err().to_string();
        assert!(error.contains("unit `m`"), "{error}");
        let flat = ScanConfig {
            light_opening_rad: 0.0,
            ..config
        };
        let error = flat.check().unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("`light_opening_rad` is 0"));
    }
}
