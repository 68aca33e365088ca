//! A CARMEN log: an `ODOM` and a `ROBOTLASER1` message a snapshot, of the first channel whose beams are evenly spaced.

use super::{reach_m, scans};
use crate::{geometry::Pose, recording::Recording, storage::WriteSeek};
use std::{fmt::Write as _, io};

pub(super) fn write(
    out: &mut dyn WriteSeek,
    recording: &Recording,
    poses: Option<&[Pose]>,
) -> io::Result<()> {
    let columns = recording.columns();
    let scans = scans(recording.channels());
    let Some(&(channel, begins, (first_rad, step_rad))) = scans.first() else {
        return Err(io::Error::other("no channel of evenly spaced ranges"));
    };
    let values = |k: usize| {
        columns
            .values
            .row(k)
            .into_iter()
            .copied()
            .skip(begins)
            .take(channel.width)
    };
    // What came back from nowhere is beyond the farthest: CARMEN has no other word for it.
    let farthest_m = (0..recording.len())
        .map(|k| reach_m(channel, values(k)))
        .fold(0.0, f64::max);
    let nothing_m = farthest_m + 1.0;
    writeln!(out, "# CARMEN log of {} snapshots", recording.len())?;
    for k in 0..recording.len() {
        let stamp_s = columns.stamp_s[k];
        let of = |pose: &Pose| format!("{} {} {}", pose.x_m, pose.y_m, pose.heading_rad);
        let odometry = of(&columns.odometry[k]);
        writeln!(out, "ODOM {odometry} 0 0 0 {stamp_s} robot {stamp_s}")?;
        // Logs whose poses were corrected have them in their scans, and the raw odometry beside them.
        let pose = poses.map_or(odometry, |poses| of(&poses[k]));
        let mut ranges = String::new();
        for value in values(k) {
            let metres = if value.is_finite() {
                f64::from(value)
            } else {
                nothing_m
            };
            // In single precision, as it was: the fewest digits that give it again.
            write!(ranges, " {}", metres as f32).map_err(io::Error::other)?;
        }
        let (n, fov_rad) = (channel.width, step_rad * (channel.width - 1) as f64);
        writeln!(
            out,
            "ROBOTLASER1 0 {first_rad} {fov_rad} {step_rad} {farthest_m} 0.01 0 {n}{ranges} 0 {pose} {pose} 0 0 0 0 0 {stamp_s} robot \
             {stamp_s}"
        )?;
    }
    Ok(())
}
