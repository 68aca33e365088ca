//! A recording as a worse range sensor would have made it: fewer beams, a shorter reach, something mounted in its view.

use super::{Recording, injected_noise::InjectedNoise};
use crate::{
    error::{Error, Result},
    geometry::wrapped,
    seed::Seed,
};
use ndarray::{ArrayViewMut2, Axis};
use serde::{Deserialize, Serialize};
use std::{f64::consts::TAU, fmt};

/// Ends of sectors are as exact as people write them, in radians: a bearing this near to one is in the sector, and 6.283 is all
/// the way round.
const ROUNDING_RAD: f64 = 0.001;

/// What if the robot's range sensor were a worse one, and people were in its way?
///
/// Every channel in metres that has bearings is degraded; all others stay as they were, and so do poses, odometry and
/// compass. Training, validation and testing parts alike are degraded, so the scans of the worse sensor draw the map, too;
/// people alone are only where somebody is tested. A beam stays where every key leaves it: of 12 beams with a sector
/// blocked, fewer than 12 are left.
///
/// ```
/// use ballmark::{recording::degraded::Degraded, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 1, spacing_m: 2.0 };
/// let ring = corridor::thrun1998(Seed(1), &config)?; // 24 sonars
/// let worse = Degraded { beams: Some(8), reach_m: Some(1.5), ..Degraded::default() };
/// let seen = worse.sensor(ring)?;
/// let sonar = &seen.channels()[0];
/// assert_eq!((sonar.width, sonar.maximum), (8, Some(1.5)));
/// assert!(seen.values().row(0).iter().take(8).all(|range| range.is_nan() || *range < 1.5));
/// assert_eq!(seen.columns().degraded.as_ref().unwrap().to_string(), "8 of 24 beams, reach 1.5 m");
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Degraded {
    /// So many beams of every range sensor, chosen evenly in their order; a sensor that has no more keeps all. Not said: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beams: Option<usize>,
    /// From this distance on there is no return, in metres. Not said: as recorded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reach_m: Option<f64>,
    /// Sectors in which something mounted on the robot blocks the view: `[from, to]`, two bearings in radians (0 ahead, within
    /// ±2π), from the first counter-clockwise to the second. The beams in them are taken away.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub blocked_rad: Vec<[f64; 2]>,
    /// Share of the range beams of all that is tested on that people are in the way of, 0 to 1: stretches of 3° to 20° that end
    /// before what they met. What is learned from, and what evidence is tuned on, has nobody in it. Not said: nobody.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub people: Option<f64>,
    /// Noise on odometry and ranges of all that is tested on, likewise. Not said: none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<InjectedNoise>,
}

/// What a recording's range sensors were degraded by, for records and captions; people are told of elsewhere, as they stand
/// before a part of it only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Degradation {
    /// Beams asked for; none: all.
    pub beams: Option<usize>,
    /// From this distance on there is no return, in metres; none: as recorded.
    pub reach_m: Option<f64>,
    /// Sectors without beams, from one bearing counter-clockwise to another, in radians.
    pub blocked_rad: Vec<[f64; 2]>,
    /// What each range sensor has left.
    pub channels: Vec<KeptBeams>,
}

/// How many beams a range sensor has left.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeptBeams {
    /// Name of its channel.
    pub channel: String,
    /// Beams that are left.
    pub kept: usize,
    /// Beams that were recorded.
    pub recorded: usize,
}

impl Degraded {
    /// # Errors
    /// A usage error where a value makes no sense; the message names the key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, expected: &str| {
            Err(Error::usage(format!(
                "degraded.{key} = {value}: expected {expected}"
            )))
        };
        if self.beams == Some(0) {
            return wrong("beams", "0".into(), "at least 1");
        }
        if let Some(reach_m) = self.reach_m
            && !(reach_m.is_finite() && reach_m > 0.0)
        {
            return wrong("reach_m", reach_m.to_string(), "metres, more than 0");
        }
        let is_bearing = |rad: &f64| rad.abs() <= TAU + ROUNDING_RAD;
        let mut sectors = self.blocked_rad.iter();
        if let Some(sector) = sectors.find(|sector| !sector.iter().all(is_bearing)) {
            return Err(Error::usage(format!(
                "degraded.blocked_rad: the sector {sector:?}; expected two bearings in radians, within ±2π"
            )));
        }
        if let Some(people) = self.people
            && !(0.0..=1.0).contains(&people)
        {
            let expected = "the share of beams that they hide, 0 to 1";
            return wrong("people", people.to_string(), expected);
        }
        self.noise.iter().try_for_each(InjectedNoise::check)?;
        Ok(())
    }

    /// Is nothing said?
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The recording as the worse sensor would have made it. It counts as the same recording: labels, checksums and order stay.
    ///
    /// # Errors
    /// A usage error as [`Degraded::check`]; an error where there is no channel to degrade, or none of a channel's beams is left.
    pub fn sensor(&self, recording: Recording) -> Result<Recording> {
        self.check()?;
        if self.beams.is_none() && self.reach_m.is_none() && self.blocked_rad.is_empty() {
            return Ok(recording);
        }
        let mut columns = recording.into_columns();
        let (mut kept_values, mut channels) = (Vec::new(), Vec::new());
        let mut first = 0;
        for channel in &mut columns.channels {
            let own = first..first + channel.width;
            first = own.end;
            if !channel.is_scan() {
                kept_values.extend(own);
                continue;
            }
            let bearing_rad = channel.bearing_rad.take().unwrap_or_default();
            let kept = self.kept_beams(&bearing_rad);
            if kept.is_empty() {
                return Err(Error::work(format!(
                    "degraded.blocked_rad: no beam of channel `{}` is left; expected at least one",
                    channel.name
                )));
            }
            channels.push(KeptBeams {
                channel: channel.name.clone(),
                kept: kept.len(),
                recorded: channel.width,
            });
            channel.width = kept.len();
            channel.bearing_rad = Some(kept.iter().map(|&beam| bearing_rad[beam]).collect());
            if let Some(offset_m) = channel.offset_m.take() {
                channel.offset_m = Some(kept.iter().map(|&beam| offset_m[beam]).collect());
            }
            kept_values.extend(kept.iter().map(|beam| own.start + beam));
            if let Some(reach_m) = self.reach_m {
                channel.maximum = Some(channel.maximum.map_or(reach_m, |m| m.min(reach_m)));
                blank_beyond(columns.values.slice_axis_mut(Axis(1), own.into()), reach_m);
            }
        }
        if channels.is_empty() {
            return Err(Error::work(
                "degraded: no channel in metres has bearings; expected a range sensor whose beams' directions are known",
            ));
        }
        columns.values = columns.values.select(Axis(1), &kept_values);
        columns.degraded = Some(Degradation {
            beams: self.beams,
            reach_m: self.reach_m,
            blocked_rad: self.blocked_rad.clone(),
            channels,
        });
        Recording::new(columns)
    }

    /// The share of beams behind people, where another key may say it, too: `other`, which messages call `name`.
    ///
    /// # Errors
    /// A usage error where both are given and differ.
    pub fn people_or(&self, other: Option<f64>, name: &str) -> Result<Option<f64>> {
        match (self.people, other) {
            (Some(people), Some(other)) if people != other => Err(Error::usage(format!(
                "degraded.people = {people} and {name} = {other}: both say which share of the beams people hide; expected one of \
                 them, or the same share"
            ))),
            (people, other) => Ok(people.or(other)),
        }
    }

    /// What is tested on with the noise that is put on it, where there is any.
    ///
    /// # Errors
    /// As [`Recording::with_noise`].
    pub fn noisy(
        &self,
        recording: &Recording,
        tested: &[usize],
        seed: Seed,
    ) -> Result<Option<Recording>> {
        let noise = self.noise.as_ref().filter(|noise| !noise.is_none());
        noise
            .map(|noise| recording.with_noise(tested, noise, seed))
            .transpose()
    }

    /// Beams of a scan that are left, ascending.
    fn kept_beams(&self, bearing_rad: &[f64]) -> Vec<usize> {
        let all = bearing_rad.len();
        let count = self.beams.map_or(all, |beams| beams.min(all));
        // The middle one of as many equal parts.
        let chosen = (0..count).map(|i| (2 * i + 1) * all / (2 * count));
        let is_free = |beam: &usize| {
            let mut sectors = self.blocked_rad.iter();
            !sectors.any(|sector| is_within(bearing_rad[*beam], sector))
        };
        chosen.filter(is_free).collect()
    }
}

/// Readings that a sensor of this reach would not have had.
fn blank_beyond(mut values: ArrayViewMut2<f32>, reach_m: f64) {
    values.mapv_inplace(|range_m| match f64::from(range_m) >= reach_m {
        true => f32::NAN,
        false => range_m,
    });
}

/// Does a bearing lie in a sector, both ends counted?
fn is_within(bearing_rad: f64, &[from_rad, to_rad]: &[f64; 2]) -> bool {
    let width_rad = match to_rad - from_rad {
        width_rad if width_rad >= TAU - ROUNDING_RAD => return true, // all the way round
        width_rad => width_rad.rem_euclid(TAU),
    };
    // From the sector's middle, so that neither end is where angles jump.
    let middle_rad = from_rad + 0.5 * width_rad;
    wrapped(bearing_rad - middle_rad).abs() <= 0.5 * width_rad + ROUNDING_RAD
}

impl fmt::Display for Degradation {
    /// "12 of 180 beams, reach 4 m, blocked from -0.3 to 0.5 rad".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, channel) in self.channels.iter().enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            if self.channels.len() > 1 {
                write!(f, "{}: ", channel.channel)?;
            }
            write!(f, "{} of {} beams", channel.kept, channel.recorded)?;
        }
        if let Some(reach_m) = self.reach_m {
            write!(f, ", reach {reach_m} m")?;
        }
        for [from_rad, to_rad] in &self.blocked_rad {
            write!(f, ", blocked from {from_rad} to {to_rad} rad")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
