//! A log whose labels come from a trajectory that another system wrote.

use crate::{
    error::Result,
    geometry::Pose,
    recording::{
        imported_log::ImportedLog,
        posed::{Track, with_poses},
    },
    score::trajectory::{Pose3, Trajectory},
};

/// Poses may be so far in time from a snapshot where nothing is said, in seconds.
pub const TOLERANCE_S: f64 = 0.5;

/// Labels a log's snapshots with the poses of a trajectory, seen from above, as [`with_poses`] does.
///
/// # Errors
/// As [`with_poses`].
pub fn labelled(
    log: ImportedLog,
    trajectory: &Trajectory,
    tolerance_s: f64,
    gap_m: f64,
) -> Result<ImportedLog> {
    let pose: Vec<Pose> = trajectory.poses().iter().map(Pose3::to_plane).collect();
    let track = Track {
        name: trajectory.name(),
        stamp_s: trajectory.stamps(),
        pose: &pose,
        tolerance_s,
        gap_m,
    };
    with_poses(log, &track)
}
