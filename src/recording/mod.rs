//! What a robot saw: snapshots of its sensors, each with the place it was taken at, in one or several runs.

pub mod bearings;
pub mod compressed;
mod content;
mod declared;
pub mod degraded;
pub mod format;
mod gaps;
pub mod history;
pub mod image;
pub mod import;
pub mod import_report;
pub mod imported_log;
pub mod injected_noise;
mod joined;
pub mod log_options;
pub mod npz;
mod observation;
mod oddities;
mod one_way;
mod people;
pub mod posed;
pub mod ranges;
pub mod selection;
mod source;
pub mod split;
pub mod viewpoint;
pub mod write;

use crate::{
    error::{Error, Result},
    geometry::Pose,
};
use degraded::Degradation;
use injected_noise::InjectedNoise;
use ndarray::Array2;
pub use observation::Observation;
pub(crate) use observation::check_width;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// One sensor, or one kind of sensor: its name and what its values mean.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Name, also that of its array in a dataset: `laser`, `sonar`, `camera`, …
    pub name: String,
    /// Number of values in a snapshot.
    pub width: usize,
    /// Unit of the values: `m` for ranges, anything else as recorded.
    pub unit: String,
    /// Direction of each value in the robot's frame (radians, counter-clockwise, 0 ahead), where values have one.
    pub bearing_rad: Option<Vec<f64>>,
    /// Reading from which on there was no return, where the channel has such a limit.
    pub maximum: Option<f64>,
    /// How far from the robot's middle each value's sensor sits, in metres along its bearing: ranges count from there. None: all
    /// in the middle. Sonars of a Nomad 200, for one, sit on a ring, and count from its rim.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<Vec<f64>>,
}

/// No robot is so wide, metres: a sensor farther out is given in another unit.
const FARTHEST_OUT_M: f64 = 100.0;

impl Channel {
    /// Distance of a value's sensor from the robot's middle, in metres: of [`Channel::offset_m`], or 0.
    pub fn offset_of(&self, value: usize) -> f64 {
        let offset_m = self.offset_m.as_ref().and_then(|all| all.get(value));
        offset_m.copied().unwrap_or(0.0)
    }

    /// # Errors
    /// What is wrong with the offsets, in words.
    fn check_offsets(&self) -> std::result::Result<(), String> {
        let Some(offset_m) = &self.offset_m else {
            return Ok(());
        };
        if self.bearing_rad.is_none() {
            return Err(
                "`offset_m` without `bearing_rad`; expected offsets only along known bearings"
                    .into(),
            );
        }
        if offset_m.len() != self.width {
            return Err(format!(
                "{} numbers in `offset_m` for {} values; expected one each",
                offset_m.len(),
                self.width
            ));
        }
        let bad = |m: &&f64| !(0.0..=FARTHEST_OUT_M).contains(*m);
        match offset_m.iter().find(bad) {
            Some(m) => Err(format!(
                "`offset_m` of {m}; expected metres from the robot's middle, 0 to {FARTHEST_OUT_M}"
            )),
            None => Ok(()),
        }
    }

    /// Are these ranges in known directions: what people can be in the way of?
    pub(crate) fn is_scan(&self) -> bool {
        self.unit == "m" && self.bearing_rad.is_some()
    }
}

/// An observation together with the place where it was made.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// Position in the recording, from 0.
    pub index: usize,
    /// The true place, as well as it is known.
    pub pose: Pose,
    /// Coordinate along a route in metres, where the recording has one.
    pub route_m: Option<f64>,
    /// What the sensors said.
    pub observation: Observation<'a>,
}

/// Everything a recording is made of, column by column; [`Recording::new`] checks it.
#[derive(Debug, Clone, Default)]
pub struct Columns {
    /// Sensors in order; their widths add up to the columns of `values`.
    pub channels: Vec<Channel>,
    /// `[snapshot, value]`, channels side by side; NaN = no return.
    pub values: Array2<f32>,
    /// Seconds, one a snapshot.
    pub stamp_s: Vec<f64>,
    /// The label: the true place, one a snapshot.
    pub pose: Vec<Pose>,
    /// Raw dead-reckoned pose, cumulative, one a snapshot.
    pub odometry: Vec<Pose>,
    /// Run that a snapshot belongs to.
    pub run: Vec<i64>,
    /// Compass heading in radians.
    pub compass_rad: Option<Vec<f64>>,
    /// Coordinate along a route in metres.
    pub route_m: Option<Vec<f64>>,
    /// Where the data came from, in words or as a file name.
    pub source: Option<String>,
    /// SHA-256 of the log it came from.
    pub source_sha256: Option<String>,
    /// SHA-256 of the dataset file it was read from.
    pub dataset_sha256: Option<String>,
    /// What its range sensors [were degraded by](degraded::Degraded::sensor) since; no file has it.
    pub degraded: Option<Degradation>,
    /// Noise that was [put on](Recording::with_noise) some of its snapshots since; no file has it.
    pub noise: Option<InjectedNoise>,
}

/// Snapshots in the order they were taken, in runs.
///
/// ```
/// use ballmark::{geometry::Pose, recording::{Channel, Columns, Recording}};
/// let light = Channel { name: "light".into(), width: 1, unit: "lux".into(), bearing_rad: None, maximum: None, offset_m: None };
/// let recording = Recording::new(Columns {
///     channels: vec![light],
///     values: ndarray::array![[3.0], [5.0]],
///     stamp_s: vec![0.0, 1.0],
///     pose: vec![Pose::new(0.0, 0.0, 0.0), Pose::new(1.0, 0.0, 0.0)],
///     odometry: vec![Pose::default(), Pose::new(1.02, 0.0, 0.0)],
///     run: vec![0, 0],
///     ..Columns::default()
/// })?;
/// assert_eq!(recording.len(), 2);
/// assert_eq!(recording.observation(1).values[0], 5.0);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Recording {
    columns: Columns,
}

impl Recording {
    /// A recording from its columns.
    ///
    /// # Errors
    /// Where lengths differ, a pose, odometry, stamp, route or compass value is not finite, there is no snapshot or no
    /// channel, two channels share a name, or a channel's bearings or offsets don't match its width. The message names the column
    /// and the first snapshot at fault.
    pub fn new(columns: Columns) -> Result<Self> {
        let k = columns.values.nrows();
        let wrong = |column: &str, fault: String| Error::work(format!("`{column}`: {fault}"));
        if k == 0 {
            return Err(wrong("pose", "no snapshot; expected at least one".into()));
        }
        let mut lengths = vec![
            ("stamp", columns.stamp_s.len()),
            ("pose", columns.pose.len()),
            ("odometry", columns.odometry.len()),
            ("run", columns.run.len()),
        ];
        lengths.extend(columns.compass_rad.as_ref().map(|c| ("compass", c.len())));
        lengths.extend(columns.route_m.as_ref().map(|r| ("route", r.len())));
        if let Some((name, length)) = lengths.into_iter().find(|(_, length)| *length != k) {
            return Err(wrong(
                name,
                format!("{length} entries; expected {k}, one a snapshot"),
            ));
        }
        if columns.channels.is_empty() {
            return Err(wrong(
                "channels",
                "none; expected at least one sensor channel".into(),
            ));
        }
        for (i, channel) in columns.channels.iter().enumerate() {
            if channel.width == 0 {
                return Err(wrong(
                    &channel.name,
                    "no values; expected at least one a snapshot".into(),
                ));
            }
            if columns.channels[..i]
                .iter()
                .any(|other| other.name == channel.name)
            {
                return Err(wrong(
                    &channel.name,
                    "two channels of that name; expected one".into(),
                ));
            }
            if let Some(bearings) = channel
                .bearing_rad
                .as_ref()
                .filter(|b| b.len() != channel.width)
            {
                return Err(wrong(
                    &channel.name,
                    format!("{} bearings for {} values", bearings.len(), channel.width),
                ));
            }
            let offsets = channel.check_offsets();
            offsets.map_err(|fault| wrong(&channel.name, fault))?;
        }
        let width: usize = columns.channels.iter().map(|channel| channel.width).sum();
        if width != columns.values.ncols() {
            return Err(wrong(
                "channels",
                format!("{width} values declared, {} found", columns.values.ncols()),
            ));
        }
        let finite = |name: &str, bad: Option<usize>| match bad {
            Some(row) => Err(wrong(
                name,
                format!("snapshot {row} is not a finite number"),
            )),
            None => Ok(()),
        };
        finite("stamp", columns.stamp_s.iter().position(|v| !v.is_finite()))?;
        finite("pose", columns.pose.iter().position(|p| !p.is_finite()))?;
        finite(
            "odometry",
            columns.odometry.iter().position(|p| !p.is_finite()),
        )?;
        finite(
            "compass",
            columns
                .compass_rad
                .iter()
                .flatten()
                .position(|v| !v.is_finite()),
        )?;
        finite(
            "route",
            columns
                .route_m
                .iter()
                .flatten()
                .position(|v| !v.is_finite()),
        )?;
        Ok(Self { columns })
    }

    /// Number of snapshots K; never 0.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.columns.values.nrows()
    }

    /// All columns at once, to write them out.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// Gives the columns back, to build another recording from them.
    pub fn into_columns(self) -> Columns {
        self.columns
    }

    /// The sensors, in order.
    pub fn channels(&self) -> &[Channel] {
        &self.columns.channels
    }

    /// The true places, one a snapshot.
    pub fn poses(&self) -> &[Pose] {
        &self.columns.pose
    }

    /// Coordinates along the route in metres, where the recording has them.
    pub fn route_m(&self) -> Option<&[f64]> {
        self.columns.route_m.as_deref()
    }

    /// Sensor values `[snapshot, value]`, channels side by side; NaN = no return.
    pub fn values(&self) -> &Array2<f32> {
        &self.columns.values
    }

    /// What a localiser may see of snapshot `index`.
    pub fn observation(&self, index: usize) -> Observation<'_> {
        let c = &self.columns;
        Observation {
            channels: &c.channels,
            stamp_s: c.stamp_s[index],
            values: c.values.row(index),
            odometry: c.odometry[index],
            compass_rad: c.compass_rad.as_ref().map(|compass| compass[index]),
        }
    }

    /// Snapshot `index` with its truth.
    pub fn snapshot(&self, index: usize) -> Snapshot<'_> {
        Snapshot {
            index,
            pose: self.columns.pose[index],
            route_m: self.columns.route_m.as_ref().map(|route| route[index]),
            observation: self.observation(index),
        }
    }

    /// The runs: stretches of consecutive snapshots with the same run number. Odometry connects snapshots inside a run
    /// and says nothing across two.
    pub fn runs(&self) -> Vec<Range<usize>> {
        let run = &self.columns.run;
        let starts: Vec<usize> = (0..run.len())
            .filter(|&k| k == 0 || run[k] != run[k - 1])
            .collect();
        let ends = starts.iter().skip(1).copied().chain([run.len()]);
        starts
            .iter()
            .copied()
            .zip(ends)
            .map(|(start, end)| start..end)
            .collect()
    }

    /// Metres travelled since the start of the run, by the true poses, one a snapshot.
    pub fn travelled_m(&self) -> Vec<f64> {
        let mut travelled = vec![0.0; self.len()];
        for run in self.runs() {
            for k in run.start + 1..run.end {
                travelled[k] =
                    travelled[k - 1] + self.columns.pose[k].distance_m(&self.columns.pose[k - 1]);
            }
        }
        travelled
    }

    /// The run that each of some snapshots is of, counted from 0.
    pub fn run_numbers(&self, snapshots: &[usize]) -> Vec<usize> {
        let runs = self.runs();
        let of = |&k: &usize| runs.partition_point(|run| run.end <= k);
        snapshots.iter().map(of).collect()
    }

    /// Metres travelled in all runs together, by the true poses.
    pub fn path_m(&self) -> f64 {
        let travelled_m = self.travelled_m();
        let ends = self.runs().into_iter().map(|run| run.end - 1);
        // Added to 0, not -0 which an empty sum of floats starts from.
        ends.fold(0.0, |sum, end| sum + travelled_m[end])
    }

    /// The recording made of some of the snapshots, in the order given.
    ///
    /// # Errors
    /// Where `indices` is empty.
    pub fn select(&self, indices: &[usize]) -> Result<Recording> {
        let c = &self.columns;
        let poses = |all: &[Pose]| indices.iter().map(|&k| all[k]).collect();
        let numbers = |all: &[f64]| -> Vec<f64> { indices.iter().map(|&k| all[k]).collect() };
        Recording::new(Columns {
            channels: c.channels.clone(),
            values: c.values.select(ndarray::Axis(0), indices),
            stamp_s: numbers(&c.stamp_s),
            pose: poses(&c.pose),
            odometry: poses(&c.odometry),
            run: indices.iter().map(|&k| c.run[k]).collect(),
            compass_rad: c.compass_rad.as_deref().map(numbers),
            route_m: c.route_m.as_deref().map(numbers),
            source: c.source.clone(),
            source_sha256: c.source_sha256.clone(),
            dataset_sha256: c.dataset_sha256.clone(),
            degraded: c.degraded.clone(),
            noise: c.noise.clone(),
        })
    }
}
