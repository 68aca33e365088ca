//! Recordings in formats of other people's programs: tables, CARMEN logs, MCAP files as ROS 2 plays them, datasets.

mod carmen;
mod csv;
mod mcap;

use super::{Channel, Recording, npz};
use crate::{error::Result, geometry::Pose, storage};
use std::path::Path;

/// A format to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A table with a header, which states units, bearings and offsets: any sensor.
    Csv,
    /// A CARMEN log: scans of one range sensor whose beams are evenly spaced.
    Carmen,
    /// MCAP with messages of ROS 2: scans, and odometry.
    Mcap,
    /// A dataset of this program, which numpy opens: any sensor.
    Npz,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Csv, Self::Carmen, Self::Mcap, Self::Npz];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Carmen => "carmen",
            Self::Mcap => "mcap",
            Self::Npz => "npz",
        }
    }

    /// What its files' names end with.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Carmen => "log",
            other => other.name(),
        }
    }

    /// Why a recording of these sensors can't be written in it; none where it can. What it can't hold of other sensors is left out.
    ///
    /// ```
    /// use ballmark::recording::{Channel, write::Format};
    /// let light = Channel { name: "light".into(), width: 1, unit: "lux".into(), ..Channel::default() };
    /// assert!(Format::Csv.refuses(&[light.clone()]).is_none());
    /// assert!(Format::Carmen.refuses(&[light]).is_some());
    /// ```
    pub fn refuses(self, channels: &[Channel]) -> Option<String> {
        match (self, scans(channels).len()) {
            (Self::Carmen | Self::Mcap, 0) => Some(format!(
                "{}: no channel of ranges whose beams are evenly spaced",
                self.name()
            )),
            _ => None,
        }
    }
}

/// Writes a recording, with the true poses where they are given and its odometry and sensors alone where they are not.
///
/// ```
/// use ballmark::recording::{Channel, Columns, Recording, write::{Format, write}};
/// # let folder = tempfile::tempdir().unwrap();
/// let light = Channel { name: "light".into(), width: 1, unit: "lux".into(), ..Channel::default() };
/// let recording = Recording::new(Columns {
///     channels: vec![light],
///     values: ndarray::array![[3.0], [5.0]],
///     stamp_s: vec![0.0, 1.0],
///     pose: vec![Default::default(); 2],
///     odometry: vec![Default::default(); 2],
///     run: vec![0, 0],
///     ..Columns::default()
/// })?;
/// let file = folder.path().join("walk.csv");
/// write(Format::Csv, &file, &recording, Some(recording.poses()))?;
/// let text = std::fs::read_to_string(&file).unwrap();
/// assert!(text.starts_with("time_s,x_m,y_m,heading_rad,odometry_x_m,odometry_y_m,odometry_heading_rad,run,light[lux]\n0,0,0,0,"));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the [format can't hold it](Format::refuses), or the file can't be written.
pub fn write(
    format: Format,
    file: &Path,
    recording: &Recording,
    poses: Option<&[Pose]>,
) -> Result<()> {
    if let Some(why) = format.refuses(recording.channels()) {
        return Err(crate::error::Error::work(why));
    }
    match format {
        Format::Npz => npz::write(file, recording),
        Format::Csv => storage::write_file(file, |out| csv::write(out, recording, poses)),
        Format::Carmen => storage::write_file(file, |out| carmen::write(out, recording, poses)),
        Format::Mcap => storage::write_file(file, |out| mcap::write(out, recording, poses)),
    }
}

/// How far beams may be from even spacing, in radians: rounding.
const EVEN_RAD: f64 = 1e-4;

/// Where the first beam of a scan points and by how much the next one is turned, in radians; none where its beams aren't evenly
/// spaced about the robot's middle, or are no ranges.
fn fan(channel: &Channel) -> Option<(f64, f64)> {
    let bearings = channel.bearing_rad.as_ref().filter(|_| channel.is_scan())?;
    let (first, last) = (*bearings.first()?, *bearings.last()?);
    let gaps = bearings.len().checked_sub(1).filter(|&gaps| gaps > 0)?;
    let step = (last - first) / gaps as f64;
    let even = |(k, bearing): (usize, &f64)| (bearing - first - step * k as f64).abs() < EVEN_RAD;
    let middle = channel.offset_m.iter().flatten().all(|&m| m == 0.0);
    (middle && step != 0.0 && bearings.iter().enumerate().all(even)).then_some((first, step))
}

/// A scan in a recording: its channel, where its values begin in a snapshot, and its [`fan`].
type Scan<'a> = (&'a Channel, usize, (f64, f64));

/// All channels whose beams are evenly spaced.
fn scans(channels: &[Channel]) -> Vec<Scan<'_>> {
    let mut begins = 0;
    let mut scans = Vec::new();
    for channel in channels {
        scans.extend(fan(channel).map(|fan| (channel, begins, fan)));
        begins += channel.width;
    }
    scans
}

/// The farthest that a scan can see, in metres: as stated, or as seen.
fn reach_m(channel: &Channel, values: impl Iterator<Item = f32>) -> f64 {
    let seen = values.filter(|m| m.is_finite()).fold(0.0, f32::max);
    channel.maximum.unwrap_or(f64::from(seen))
}

#[cfg(test)]
mod tests;
