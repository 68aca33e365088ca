//! What a snapshot looks like to a recogniser: its range readings, each channel brought to unit length.
//!
//! Duckett & Nehmzow (1998, below D98), 3.1, keep "a normalised sonar signature and a normalised infrared signature" of a
//! place; D00 a "normalised vector of sonar readings". Neither prints the norm. Here it is the Euclidean one, both in
//! *normalised* and in ‖·‖ of D98 eq. 1: only then does the dot product of D00's RCE rank patterns as their distance does,
//! ‖a − b‖² = 2 − 2 a·b. Readings are never negative, so two signatures of one channel are at most √2 apart: D98's threshold
//! T = 1.5 can be passed by sonar and infrared together (at most 2√2), by one channel alone never.

use crate::{
    error::{Error, Result},
    recording::{Channel, Observation, Recording},
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Which readings make up a signature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SignatureConfig {
    /// Channels by name; none named: all that measure ranges (unit `m`), or simply all where none does.
    pub channels: Vec<String>,
    /// Turn a ring of readings by the compass, where there is one, so that a place looks the same whichever way the robot
    /// faces: D98 5.1 has its turret turn to the north instead.
    pub compass: bool,
}

impl Default for SignatureConfig {
    fn default() -> Self {
        Self {
            channels: Vec::new(),
            compass: true,
        }
    }
}

/// What a channel's readings are divided by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Normalisation {
    /// Their Euclidean length: a channel of a signature has length 1.
    #[default]
    Length,
    /// The sensor's longest range: each reading is a share of it.
    Maximum,
}

/// How a snapshot becomes a signature; fitted once on the mapping part and kept with what was learned from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layout {
    channels: Vec<ChannelLayout>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ChannelLayout {
    name: String,
    width: usize,
    unit: String,
    /// What a missing return counts as, and the bound of all readings.
    maximum: f32,
    /// Positions of the readings once round, counter-clockwise, where they stand evenly all the way round the robot and the
    /// compass is to turn them.
    ring: Option<Vec<usize>>,
}

/// Two neighbours of an even ring may stand apart by this share of the mean more or less.
const UNEVENNESS: f64 = 0.1;

impl Layout {
    /// Finds the channels, and the largest reading of those that have no maximum.
    ///
    /// # Errors
    /// Where the configuration names a channel that the recording lacks.
    pub fn fit(
        config: &SignatureConfig,
        recording: &Recording,
        snapshots: &[usize],
    ) -> Result<Self> {
        let all = recording.channels();
        let named = |channel: &Channel| config.channels.contains(&channel.name);
        let any_range = all.iter().any(|channel| channel.unit == "m");
        if let Some(missing) = config
            .channels
            .iter()
            .find(|name| all.iter().all(|channel| channel.name != **name))
        {
            return Err(absent(missing, all));
        }
        let (mut channels, mut from) = (Vec::new(), 0);
        for channel in all {
            let wanted = match config.channels.is_empty() {
                true => channel.unit == "m" || !any_range,
                false => named(channel),
            };
            if wanted {
                let columns = from..from + channel.width;
                let readings = || {
                    let rows = snapshots.iter().map(|&k| recording.values().row(k));
                    rows.flat_map(|row| columns.clone().map(move |column| row[column]))
                };
                channels.push(ChannelLayout::fit(config, channel, readings()));
            }
            from += channel.width;
        }
        Ok(Self { channels })
    }

    /// Number of values in a signature.
    pub fn width(&self) -> usize {
        self.channels.iter().map(|channel| channel.width).sum()
    }

    /// Number of channels, each of unit length within the signature.
    pub fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Where each channel's readings stand in the signature, by name.
    pub fn parts(&self) -> Vec<(&str, std::ops::Range<usize>)> {
        let mut from = 0;
        let mut parts = Vec::new();
        for channel in &self.channels {
            parts.push((channel.name.as_str(), from..from + channel.width));
            from += channel.width;
        }
        parts
    }

    /// The signature of a snapshot: channels side by side, each of Euclidean length 1, or all 0 where all its readings
    /// are. `None` where a channel is missing or has another width or unit.
    ///
    /// ```
    /// use ballmark::{geometry::Pose, recording::{Channel, Columns, Recording}, recogniser::signature::{Layout, SignatureConfig}};
    /// let sonar = Channel { name: "sonar".into(), width: 2, unit: "m".into(), bearing_rad: None, maximum: Some(4.0), offset_m: None };
    /// let recording = Recording::new(Columns {
    ///     channels: vec![sonar],
    ///     values: ndarray::array![[3.0, f32::NAN]], // no return: 4 m
    ///     stamp_s: vec![0.0],
    ///     pose: vec![Pose::default()],
    ///     odometry: vec![Pose::default()],
    ///     run: vec![0],
    ///     ..Columns::default()
    /// })?;
    /// let layout = Layout::fit(&SignatureConfig::default(), &recording, &[0])?;
    /// assert_eq!(layout.of(recording.channels(), &recording.observation(0)), Some(vec![0.6, 0.8]));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn of(&self, channels: &[Channel], observation: &Observation) -> Option<Vec<f32>> {
        self.normalised(Normalisation::Length, channels, observation)
    }

    /// The same with readings divided by something else. `None` as [`Layout::of`].
    pub fn normalised(
        &self,
        by: Normalisation,
        channels: &[Channel],
        observation: &Observation,
    ) -> Option<Vec<f32>> {
        let mut signature = Vec::with_capacity(self.width());
        for wanted in &self.channels {
            let start = wanted.find(channels).ok()?;
            if start + wanted.width > observation.values.len() {
                return None;
            }
            let reading = |i: usize| wanted.bounded(observation.values[start + i]);
            let from = signature.len();
            match (&wanted.ring, observation.compass_rad) {
                (Some(ring), Some(compass)) if compass.is_finite() => {
                    // Place s of the ring looks where reading s − shift of the turned robot looks.
                    let around = ring.len() as f64;
                    let shift = (compass / TAU * around).round().rem_euclid(around) as usize;
                    let turned = |s| ring[(s + ring.len() - shift) % ring.len()];
                    signature.extend((0..ring.len()).map(|s| reading(turned(s))));
                }
                _ => signature.extend((0..wanted.width).map(reading)),
            }
            match by {
                Normalisation::Length => to_unit_length(&mut signature[from..]),
                Normalisation::Maximum => {
                    let own = signature[from..].iter_mut();
                    own.for_each(|reading| *reading /= wanted.maximum);
                }
            }
        }
        (!signature.is_empty()).then_some(signature)
    }

    /// Brings each channel of a signature to length 1 again, after a sum or a mean of several.
    pub fn to_unit_length(&self, signature: &mut [f32]) {
        for (_, part) in self.parts() {
            to_unit_length(&mut signature[part]);
        }
    }

    /// Does a signature look the same whichever way the robot faces? Where there is a compass, and every channel a ring that
    /// it turns.
    pub fn is_turned_by_compass(&self, recording: &Recording) -> bool {
        let rings = self.channels.iter().all(|channel| channel.ring.is_some());
        rings && recording.columns().compass_rad.is_some()
    }

    /// # Errors
    /// Where a channel of ours is missing there, or has another width or unit.
    pub fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.channels
            .iter()
            .try_for_each(|wanted| wanted.find(channels).map(|_| ()))
    }

    /// Checks what may have come from a file.
    ///
    /// # Errors
    /// Where a channel has no values, no positive maximum, or a ring that is not once round its readings.
    pub fn check(&self) -> Result<()> {
        let sound = |channel: &ChannelLayout| {
            let once_round = channel.ring.as_ref().is_none_or(|ring| {
                let mut sorted = ring.clone();
                sorted.sort_unstable();
                sorted.into_iter().eq(0..channel.width)
            });
            channel.width > 0 && channel.maximum.is_finite() && channel.maximum > 0.0 && once_round
        };
        match self.channels.iter().find(|channel| !sound(channel)) {
            Some(channel) => Err(Error::work(format!(
                "signature: channel `{}`: expected values, a maximum above 0, and a ring of all its readings",
                channel.name.escape_debug()
            ))),
            None if self.channels.is_empty() => {
                Err(Error::work("signature: no channel; expected at least one"))
            }
            None => Ok(()),
        }
    }
}

impl ChannelLayout {
    fn fit(
        config: &SignatureConfig,
        channel: &Channel,
        readings: impl Iterator<Item = f32>,
    ) -> Self {
        let declared = channel.maximum.map(|maximum| maximum as f32);
        let largest = readings
            .filter(|r| r.is_finite())
            .fold(0.0, |largest: f32, r| largest.max(r.abs()));
        // Nothing but 0 and missing returns: any bound will do.
        let usable = |m: &f32| m.is_finite() && *m > 0.0;
        let maximum = declared
            .filter(usable)
            .or(Some(largest).filter(usable))
            .unwrap_or(1.0);
        let bearings = channel.bearing_rad.as_deref().filter(|_| config.compass);
        Self {
            name: channel.name.clone(),
            width: channel.width,
            unit: channel.unit.clone(),
            maximum,
            ring: bearings.and_then(even_ring),
        }
    }

    /// Where this channel's values begin among those of a snapshot.
    fn find(&self, channels: &[Channel]) -> Result<usize> {
        let mut from = 0;
        for channel in channels {
            if channel.name == self.name {
                if channel.width == self.width && channel.unit == self.unit {
                    return Ok(from);
                }
                return Err(Error::work(format!(
                    "channel `{}` has {} values in `{}`; the recogniser learned from {} in `{}`",
                    self.name, channel.width, channel.unit, self.width, self.unit
                )));
            }
            from += channel.width;
        }
        Err(absent(&self.name, channels))
    }

    /// A reading within the channel's bounds, which a missing return lies at.
    fn bounded(&self, reading: f32) -> f32 {
        let least = if self.unit == "m" { 0.0 } else { -self.maximum };
        match reading.is_nan() {
            true => self.maximum,
            false => reading.clamp(least, self.maximum),
        }
    }
}

/// The readings in counter-clockwise order, where they stand evenly all the way round.
fn even_ring(bearings: &[f64]) -> Option<Vec<usize>> {
    let around = |i: usize| bearings[i].rem_euclid(TAU);
    let step = TAU / bearings.len() as f64;
    let mut ring: Vec<usize> = (0..bearings.len()).collect();
    ring.sort_by(|&a, &b| around(a).total_cmp(&around(b)));
    let gap = |s: usize| {
        let next = ring[(s + 1) % ring.len()];
        (around(next) - around(ring[s])).rem_euclid(TAU)
    };
    let even = (0..ring.len()).all(|s| (gap(s) - step).abs() <= UNEVENNESS * step);
    (even && ring.len() > 1).then_some(ring)
}

/// Divides by the Euclidean length; nothing but zeros stays so.
fn to_unit_length(values: &mut [f32]) {
    let length = values
        .iter()
        .map(|&v| f64::from(v) * f64::from(v))
        .sum::<f64>()
        .sqrt();
    if length > 0.0 {
        for value in values {
            *value = (f64::from(*value) / length) as f32;
        }
    }
}

fn absent(name: &str, channels: &[Channel]) -> Error {
    let found: Vec<String> = channels
        .iter()
        .map(|c| format!("`{}` ({} values)", c.name, c.width))
        .collect();
    Error::work(format!(
        "no channel `{}`; the recording has {}",
        name.escape_debug(),
        found.join(", ")
    ))
}

#[cfg(test)]
mod tests;
