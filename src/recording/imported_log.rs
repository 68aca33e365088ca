//! What a log gives: a recording, what became of everything that the log held, and where its odometry comes from.

use super::{Recording, import_report::ImportReport};

/// A recording read from a log, and what became of everything the log held.
#[derive(Debug, Clone)]
pub struct ImportedLog {
    /// What the robot saw.
    pub recording: Recording,
    /// Messages used and passed over, oddities, losses.
    pub account: ImportReport,
    /// Where the recording's odometry comes from.
    pub odometry: OdometrySource,
}

/// Where a recording's odometry comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum OdometrySource {
    /// The log states it beside the pose.
    Stated,
    /// Added up from ODOM lines that start anew at every corrected pose.
    Restarted,
    /// The ODOM line before each scan, in a track of its own.
    Track,
    /// The poses that the log states, in whose place others came.
    Replaced,
    /// Odometry messages, interpolated between the two around each snapshot.
    Interpolated,
    /// There is none, or the poses are it: odometry repeats the poses.
    Poses,
}

impl OdometrySource {
    /// The source in words.
    pub fn describe(self) -> &'static str {
        match self {
            OdometrySource::Stated => "stated beside each pose",
            OdometrySource::Restarted => "raw, recovered from the ODOM lines between scans",
            OdometrySource::Track => "the ODOM line before each scan",
            OdometrySource::Replaced => "the log's own poses",
            OdometrySource::Interpolated => {
                "interpolated between the odometry messages around each scan"
            }
            OdometrySource::Poses => "none besides the poses: it repeats them",
        }
    }
}
