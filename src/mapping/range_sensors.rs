//! Which of a recording's channels are range sensors that a map can predict, where each reading looks, and how wide.

use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::Channel,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// The range sensors that take part, and what their channels don't say of themselves: a channel has bearings and a maximum,
/// but no opening angle. What kind of sensor it is, its name tells: `sonar…`, `infrared…`; every other is a beam of light.
///
/// ```
/// use ballmark::{mapping::RangeSensors, recording::Channel};
/// let ring = |name: &str| Channel { name: name.into(), width: 2, unit: "m".into(), bearing_rad: Some(vec![0.0, 1.0]), maximum: Some(5.0), offset_m: None };
/// let channels = [ring("sonar"), ring("laser")];
/// let all = RangeSensors::default().beams(&channels)?;
/// assert_eq!((all[0].opening_rad.to_degrees().round(), all[2].opening_rad), (30.0, 0.0));
/// let laser = RangeSensors { channels: vec!["laser".into()], ..RangeSensors::default() };
/// assert_eq!(laser.beams(&channels)?[0].value, 2);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RangeSensors {
    /// Names of the channels that take part; empty: all in metres that have bearings.
    pub channels: Vec<String>,
    /// Full opening of a sonar's cone, radians; 0 takes a reading as a ray along its axis. 30° is Polaroid's (Moravec & Elfes,
    /// *High Resolution Maps from Wide Angle Sonar*, 1985).
    pub sonar_opening_rad: f64,
    /// Full opening of an infrared sensor's beam, radians, likewise. Assumed: 10°.
    pub infrared_opening_rad: f64,
}

impl Default for RangeSensors {
    fn default() -> Self {
        Self {
            channels: Vec::new(),
            sonar_opening_rad: 30_f64.to_radians(),
            infrared_opening_rad: 10_f64.to_radians(),
        }
    }
}

/// Where one reading of a snapshot looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBeam {
    /// Its place among a snapshot's values.
    pub value: usize,
    /// Direction of its axis in the robot's frame, radians.
    pub bearing_rad: f64,
    /// How far from the robot's middle its sensor sits along that axis, metres: readings count from there.
    pub offset_m: f64,
    /// Full opening, radians; 0: a ray.
    pub opening_rad: f64,
    /// Reading from which on there was no return, metres, where the channel has such a limit.
    pub maximum_m: Option<f64>,
}

impl RangeBeam {
    /// The point on its axis that lies this far from the sensor, for a robot in `pose`: metres east, metres north.
    pub fn point_m(&self, pose: &Pose, range_m: f64) -> [f64; 2] {
        let (sin, cos) = (pose.heading_rad + self.bearing_rad).sin_cos();
        let from_middle_m = self.offset_m + range_m;
        [
            pose.x_m + from_middle_m * cos,
            pose.y_m + from_middle_m * sin,
        ]
    }
}

impl RangeSensors {
    /// The same sensors, every reading taken as a ray along its axis.
    pub fn as_rays(&self) -> Self {
        self.narrowed(0.0)
    }

    /// The same sensors, their openings this share of what they are.
    pub fn narrowed(&self, share: f64) -> Self {
        Self {
            channels: self.channels.clone(),
            sonar_opening_rad: share * self.sonar_opening_rad,
            infrared_opening_rad: share * self.infrared_opening_rad,
        }
    }

    /// # Errors
    /// A usage error where an opening makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        for (key, value) in [
            ("sonar_opening_rad", self.sonar_opening_rad),
            ("infrared_opening_rad", self.infrared_opening_rad),
        ] {
            if !(0.0..TAU / 2.0).contains(&value) {
                return Err(Error::usage(format!(
                    "sensors.{key} = {value}: expected radians, 0 up to less than half a turn"
                )));
            }
        }
        Ok(())
    }

    /// Does any of the sensors see more than a ray?
    ///
    /// # Errors
    /// As [`RangeSensors::beams`].
    pub fn have_cones(&self, channels: &[Channel]) -> Result<bool> {
        Ok(self
            .beams(channels)?
            .iter()
            .any(|beam| beam.opening_rad > 0.0))
    }

    /// Every range reading of the sensors with a known direction, in the order of a snapshot's values.
    ///
    /// # Errors
    /// Where an opening makes no sense (a usage error), a channel that is named is not there, or none is left.
    pub fn beams(&self, channels: &[Channel]) -> Result<Vec<RangeBeam>> {
        self.check()?;
        let names = || {
            let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
            names.join(", ")
        };
        let missing = |name: &&String| channels.iter().all(|c| c.name != **name);
        if let Some(missing) = self.channels.iter().find(missing) {
            return Err(Error::work(format!(
                "no channel `{missing}`; found {}",
                names()
            )));
        }
        let mut first = 0;
        let mut beams = Vec::new();
        for channel in channels {
            let wanted = self.channels.is_empty() || self.channels.contains(&channel.name);
            if let ("m", Some(bearings), true) =
                (channel.unit.as_str(), &channel.bearing_rad, wanted)
            {
                let beam = |(i, &bearing_rad): (usize, &f64)| RangeBeam {
                    value: first + i,
                    bearing_rad,
                    offset_m: channel.offset_of(i),
                    opening_rad: self.opening_rad(&channel.name),
                    maximum_m: channel.maximum,
                };
                beams.extend(bearings.iter().enumerate().map(beam));
            }
            first += channel.width;
        }
        if beams.is_empty() {
            return Err(Error::work(
                "no channel in metres has bearings; expected a range sensor whose beams' directions are known",
            ));
        }
        Ok(beams)
    }

    fn opening_rad(&self, name: &str) -> f64 {
        match name {
            name if name.starts_with("sonar") => self.sonar_opening_rad,
            name if name.starts_with("infrared") => self.infrared_opening_rad,
            _ => 0.0,
        }
    }
}

/// At most `count` of some beams, evenly spaced: neighbouring ones tell the same twice.
pub(super) fn thinned<T: Copy>(all: &[T], count: usize) -> Vec<T> {
    let count = count.min(all.len());
    let nth = |i: usize| all[(2 * i + 1) * all.len() / (2 * count)];
    (0..count).map(nth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_channels_named_take_part_and_faults_name_them() {
        let ring = |name: &str, unit: &str, bearings| Channel {
            name: name.into(),
            width: 2,
            unit: unit.into(),
            bearing_rad: bearings,
            maximum: None,
            offset_m: None,
        };
        let round = || Some(vec![0.0, 1.0]);
        let channels = [
            ring("camera", "", None),
            ring("sonar", "m", round()),
            ring("infrared_low", "m", round()),
            ring("laser", "m", round()),
        ];
        let of = |names: &[&str]| RangeSensors {
            channels: names.iter().map(|n| n.to_string()).collect(),
            ..RangeSensors::default()
        };
        let values = |names: &[&str]| -> Vec<usize> {
            let beams = of(names).beams(&channels).unwrap();
            beams.iter().map(|beam| beam.value).collect()
        };
        assert_eq!(values(&[]), [2, 3, 4, 5, 6, 7]);
        assert_eq!(values(&["laser", "sonar"]), [2, 3, 6, 7]);
        let openings: Vec<f64> = of(&[]).beams(&channels).unwrap()[..]
            .iter()
            .map(|beam| beam.opening_rad.to_degrees().round())
            .collect();
        assert_eq!(openings, [30.0, 30.0, 10.0, 10.0, 0.0, 0.0]);
        let fault = |names: &[&str]| of(names).beams(&channels).unwrap_err().to_string();
        assert!(fault(&["lidar"]).contains("no channel `lidar`; found camera, sonar"));
        assert!(fault(&["camera"]).contains("has bearings"));
        let wide = RangeSensors {
            sonar_opening_rad: 4.0,
            ..RangeSensors::default()
        };
        let error = wide.beams(&channels).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("sonar_opening_rad = 4"));
    }
}
