//! The logs of ROS, without ROS: bags of ROS 1 (format 2.0), of ROS 2 (SQLite and MCAP, compressed or not), and MCAP as such.
//!
//! **Snapshots.** One comes from each message of the leading topic: of those with `sensor_msgs/LaserScan` the first by name;
//! without any, of those with `sensor_msgs/Range`; without any, of those with `sensor_msgs/CompressedImage`. Times are those
//! of the message's headers, and put in order. Every other sensor topic gives the message nearest in time, at most half a
//! second away; its values are NaN where there is none.
//!
//! **Channels.** The first topic of scans is `laser`, further ones are called as the topic; topics of single ranges become one
//! channel, a value each in the order of names: `sonar`, or `infrared` by their radiation type; pictures are
//! `camera` ([`image`](crate::recording::image)). Readings outside of their message's limits are no returns, and the
//! greatest limit is the channel's maximum. Bearings and offsets contain the sensor's place on the robot as tf states it; of a
//! place beside the robot's middle the part along each bearing is kept, the part across is left out.
//!
//! **Labels.** The topic that the user names; else the transforms of tf from `map` (or whatever stands at the root, but no
//! odometry frame) down to the robot's base; else a topic that calls itself the truth, else
//! `geometry_msgs/PoseWithCovarianceStamped`, else `PoseStamped` (goals left out): the first of them that places half of the
//! snapshots. Poses are interpolated between the two samples around a moment, of which one must be at most half a second
//! away, unless the robot stood still in between. A snapshot with a hole in the poses is lost; those before the first pose and
//! after the last one are passed over with a warning. The robot's base is the frame that odometry is of, else `base_link` or
//! `base_footprint`.
//!
//! **Odometry.** `nav_msgs/Odometry`, interpolated alike, else tf from an odometry frame to the base. A log that has nothing
//! else takes it for its poses, with a warning. Where a step of more than 5 m or 10 s is without odometry, a new run begins.
//!
//! **Damage.** What can be read is read, and the rest counted: messages that end early, chunks whose checksum or length
//! doesn't fit, files that were cut. A log's memory is one unpacked chunk and the readings kept, and its file's where that is packed as a
//! whole or comes through a pipe; all that is unpacked of one file together is bounded as a packed file of its length is.

mod assemble;
mod bytes;
mod collector;
mod cursor;
mod folder;
mod frames;
mod mcap;
mod message;
mod mounting;
mod part;
mod poses;
mod rosbag1;
mod rosbag2;
mod sensors;
mod sqlite;
mod track;

use crate::{
    error::{Error, Result},
    recording::{content::Content, imported_log::ImportedLog, log_options::LogOptions},
};
use collector::Collector;
use std::path::Path;

pub(in crate::recording) use folder::read as read_folder;

/// Are these the first bytes of a bag of ROS 1?
pub(super) fn detect_rosbag1(bytes: &[u8]) -> bool {
    bytes.starts_with(rosbag1::MAGIC)
}

/// Are these the first bytes of an SQLite database?
pub(super) fn detect_rosbag2(bytes: &[u8]) -> bool {
    bytes.starts_with(sqlite::MAGIC)
}

/// Are these the first bytes of an MCAP file?
pub(super) fn detect_mcap(bytes: &[u8]) -> bool {
    bytes.starts_with(mcap::MAGIC)
}

/// Reads a bag of ROS 1. `path` is for messages only.
///
/// # Errors
/// Where it has no sensor message, no pose for any of them, or not the topics asked for. Damage is no error but an entry in
/// the account.
pub fn read_rosbag1(path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    rosbag1_content(path, &Content::of_bytes(bytes), options)
}

/// Reads a `.db3` file of a bag of ROS 2. `path` is for messages only.
///
/// # Errors
/// As [`read_rosbag1`], and where it is a database of something else.
pub fn read_rosbag2(path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    rosbag2_content(path, &Content::of_bytes(bytes), options)
}

/// Reads an MCAP file with messages of ROS 1 or ROS 2. `path` is for messages only.
///
/// # Errors
/// As [`read_rosbag1`].
pub fn read_mcap(path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    mcap_content(path, &Content::of_bytes(bytes), options)
}

/// As [`read_rosbag1`], and where the content can't be read on.
pub(super) fn rosbag1_content(
    path: &Path,
    content: &Content,
    options: &LogOptions,
) -> Result<ImportedLog> {
    read(path, content, options, |content, collector| {
        rosbag1::read(content, collector);
        Ok(())
    })
}

/// As [`read_rosbag2`], and where the content can't be read on.
pub(super) fn rosbag2_content(
    path: &Path,
    content: &Content,
    options: &LogOptions,
) -> Result<ImportedLog> {
    read(path, content, options, rosbag2::read)
}

/// As [`read_mcap`], and where the content can't be read on.
pub(super) fn mcap_content(
    path: &Path,
    content: &Content,
    options: &LogOptions,
) -> Result<ImportedLog> {
    read(path, content, options, |content, collector| {
        mcap::read(content, collector);
        Ok(())
    })
}

fn read(
    path: &Path,
    content: &Content,
    options: &LogOptions,
    container: fn(&Content, &mut Collector) -> std::result::Result<(), String>,
) -> Result<ImportedLog> {
    let mut collector = Collector::new(options.topics.as_deref());
    let read = container(content, &mut collector);
    content.check(path)?; // why a reader stumbled
    read.map_err(|fault| Error::file(path, fault))?;
    assembled(path, collector, options)
}

/// The recording of all that was collected; where nothing comes of it, what was lost first says more than the outcome.
fn assembled(path: &Path, collector: Collector, options: &LogOptions) -> Result<ImportedLog> {
    let first_loss = collector.account.lost_records().first().cloned();
    assemble::assemble(collector, options).map_err(|fault| match first_loss {
        Some(loss) => Error::file(path, format!("{fault}; damaged: {loss}")),
        None => Error::file(path, fault),
    })
}

#[cfg(test)]
mod tests;
