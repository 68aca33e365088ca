//! From an observation to the local grid of what it says, in a frame that does not depend on where the robot faces.
//!
//! With a compass, north is up, as Duckett & Nehmzow (2000) held their turret. Without one, the walls run along the axes
//! ([`super::angle_histogram`]), and which of the four ways is up is left to who matches.

use super::{
    angle_histogram::main_direction,
    nearest::spaced,
    occupancy::{CELLS, OccupancyGrid, Reading, ReadingModel, States},
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Observation, Recording},
};
use serde::{Deserialize, Serialize};

/// How range readings become a grid.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScanConfig {
    /// Turn grids north up by the compass, where the recording learned from has one. Else the walls run along their axes.
    pub compass: bool,
    /// Opening of a sonar's cone, radians: of channels whose name begins with `sonar`.
    pub sonar_opening_rad: f64,
    /// Opening that a beam of light is given, radians: of all other range channels. Wide enough that neighbouring beams
    /// leave no gap.
    pub light_opening_rad: f64,
    /// Is a cone without return empty as far as the sensor reaches, where its channel says how far? A Nomad 200 reports its
    /// longest range there, a reading like any other, and Duckett & Nehmzow (2000) tell of none that they drop; it
    /// empties the cone. Else it says nothing, as readings beyond a sensor's range are dropped by Moravec & Elfes (1985).
    pub empty_without_return: bool,
    /// What a reading is worth.
    pub reading: ReadingModel,
}

impl Default for ScanConfig {
    /// 30° (Moravec & Elfes 1985), and 2° for laser scanners of a beam a degree.
    fn default() -> Self {
        Self {
            compass: true,
            sonar_opening_rad: 30_f64.to_radians(),
            light_opening_rad: 2_f64.to_radians(),
            empty_without_return: true,
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
            let message = format!("scan.{key} = {value}: expected {expected}");
            Err(Error::usage(message))
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
}

/// How the scans of one robot become grids; settled once on the mapping part and kept with what was learned from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalScans {
    config: ScanConfig,
    /// Is north up? Else the walls run along the axes.
    north_up: bool,
    /// Names of the channels of ranges.
    sensors: Vec<String>,
}

impl LocalScans {
    /// For these channels, and a compass or none.
    ///
    /// # Errors
    /// Where no channel holds ranges in metres with a bearing each; the message says so.
    pub fn new(config: &ScanConfig, channels: &[Channel], compass: bool) -> Result<Self> {
        let ranges = channels
            .iter()
            .filter(|channel| bearings(channel).is_some());
        let sensors: Vec<String> = ranges.map(|channel| channel.name.clone()).collect();
        if sensors.is_empty() {
            return Err(Error::work(
                "occupancy grids: no channel of ranges; expected one with unit `m` and a bearing for each value",
            ));
        }
        Ok(Self {
            config: *config,
            north_up: config.compass && compass,
            sensors,
        })
    }

    /// Are the channels there that this was made for?
    ///
    /// # Errors
    /// Where one is missing, or holds no ranges with bearings; the message names it.
    pub fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        let is_there = |name: &&String| {
            let mut ranges = channels
                .iter()
                .filter(|channel| bearings(channel).is_some());
            ranges.any(|channel| channel.name == **name)
        };
        match self.sensors.iter().find(|name| !is_there(name)) {
            None => Ok(()),
            Some(name) => Err(Error::work(format!(
                "occupancy grids: expected a channel `{}` with unit `m` and a bearing for each value",
                name.escape_debug()
            ))),
        }
    }

    /// Checks what may have come from a file.
    ///
    /// # Errors
    /// Where a constant is out of bounds, or there is no sensor.
    pub fn check(&self) -> Result<()> {
        self.config.check()?;
        match self.sensors.is_empty() {
            false => Ok(()),
            true => Err(Error::work("scan: no sensor; expected at least one")),
        }
    }

    /// The grid of a snapshot. `None` where nothing at all came back, or a channel or the compass is lacking.
    pub fn grid(&self, channels: &[Channel], observation: &Observation) -> Option<States> {
        self.check_channels(channels).ok()?;
        let mut readings = self.readings(channels, observation);
        if !readings.iter().any(|reading| reading.returned) {
            return None; // a sensor that is switched off
        }
        let turn_rad = match self.north_up {
            true => observation.compass_rad.filter(|rad| rad.is_finite())?,
            false => -main_direction(&readings).unwrap_or(0.0),
        };
        for reading in &mut readings {
            reading.bearing_rad += turn_rad;
        }
        let states = OccupancyGrid::of(&readings, &self.config.reading).states();
        (states.known() > 0).then_some(states)
    }

    /// The same grid as a robot sees it that faces each way that may be meant: one where north is up, else all four.
    pub fn turns(&self, states: States) -> impl Iterator<Item = States> {
        let turns = std::iter::successors(Some(states), |states| Some(states.quarter_turn()));
        turns.take(self.ways())
    }

    /// Number of [`LocalScans::turns`].
    pub fn ways(&self) -> usize {
        if self.north_up { 1 } else { 4 }
    }

    /// Places: snapshots, of some of a recording's, that lie `spacing_m` or more from one another. Each with its pose and its
    /// grid, of which nothing is known where nothing came back.
    pub fn places(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        spacing_m: f64,
    ) -> Vec<(Pose, States)> {
        let place = |k: usize| {
            let grid = self.grid(recording.channels(), &recording.observation(k));
            (recording.poses()[k], grid.unwrap_or(States::UNKNOWN))
        };
        let spaced = spaced(recording.poses(), snapshots, spacing_m);
        spaced.into_iter().map(place).collect()
    }

    /// All readings that say something, in the robot's frame.
    fn readings(&self, channels: &[Channel], observation: &Observation) -> Vec<Reading> {
        let mut readings = Vec::new();
        let mut values = observation.values.iter();
        for channel in channels {
            let of_channel = values.by_ref().take(channel.width);
            let wanted = self.sensors.contains(&channel.name);
            let Some(bearing_rad) = bearings(channel).filter(|_| wanted) else {
                of_channel.for_each(drop);
                continue;
            };
            let opening_rad = match channel.name.starts_with("sonar") {
                true => self.config.sonar_opening_rad,
                false => self.config.light_opening_rad,
            };
            let no_return_m = channel.maximum.unwrap_or(f64::INFINITY);
            let reading = |(value, (&range, &bearing_rad)): (usize, (&f32, &f64))| {
                let range_m = f64::from(range);
                let returned = range_m.is_finite() && range_m < no_return_m;
                let range_m = match returned {
                    true => range_m,
                    false if self.config.empty_without_return => no_return_m,
                    false => return None,
                };
                // How far a sensor without a maximum reaches nobody knows.
                range_m.is_finite().then_some(Reading {
                    bearing_rad,
                    offset_m: channel.offset_of(value),
                    range_m,
                    returned,
                    opening_rad,
                })
            };
            let each = of_channel.zip(bearing_rad).enumerate();
            readings.extend(each.filter_map(reading));
        }
        readings
    }
}

/// Checks the distance between places.
///
/// # Errors
/// A usage error where it is no positive number; `name` is the recogniser's.
pub(super) fn check_spacing(name: &str, spacing_m: f64) -> Result<()> {
    match spacing_m.is_finite() && spacing_m > 0.0 {
        true => Ok(()),
        false => Err(Error::usage(format!(
            "{name}.spacing_m = {spacing_m}: expected a positive number of metres"
        ))),
    }
}

/// Checks how far grids or histograms of them are moved.
///
/// # Errors
/// A usage error where nothing would overlap any more; `name` is the recogniser's.
pub(super) fn check_reach(name: &str, reach_cells: usize) -> Result<()> {
    match reach_cells < CELLS {
        true => Ok(()),
        false => Err(Error::usage(format!(
            "{name}.reach_cells = {reach_cells}: expected at most {}, the last translation that overlaps",
            CELLS - 1
        ))),
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
mod tests;
