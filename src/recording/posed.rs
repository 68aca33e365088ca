//! A log whose poses come from elsewhere: a trajectory that SLAM or a reference system wrote.

use super::{
    Recording, gaps,
    imported_log::{ImportedLog, OdometrySource},
};
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
};
use ndarray::Axis;

/// Poses that snapshots are to be labelled with, and how they are joined.
#[derive(Debug, Clone, Copy)]
pub struct Track<'a> {
    /// What the poses are called in messages: their file.
    pub name: &'a str,
    /// Seconds in the log's time, rising, one a pose. None: one pose a snapshot, in their order.
    pub stamp_s: Option<&'a [f64]>,
    /// The poses.
    pub pose: &'a [Pose],
    /// Farthest in time that a pose may be from a snapshot, in seconds.
    pub tolerance_s: f64,
    /// As [`LogOptions::gap_m`](super::log_options::LogOptions::gap_m).
    pub gap_m: f64,
}

/// Labels the snapshots of a log with the poses of a track.
///
/// A snapshot takes the pose between the two around its stamp, in proportion to time, if the nearer of them is within the
/// tolerance; a gap in the track costs the snapshots in it, each named as lost. Snapshots before its first pose and after its
/// last are passed over. The log's own poses become odometry where it has no other.
///
/// # Errors
/// Where no snapshot gets a pose, or there are more or fewer poses without stamps than snapshots.
///
/// ```
/// use ballmark::{Pose, recording::{format::Format, posed::{Track, with_poses}}};
/// let log = b"time_s,x_m,y_m,heading_rad,light\n0,0,0,0,5\n1,1.1,0,0,6\n2,2.3,0,0,7\n";
/// let log = Format::named("csv")?.read("walk.csv".as_ref(), log, &Default::default())?;
/// let pose = [Pose::new(0.0, 0.0, 0.0), Pose::new(2.0, 0.2, 0.0)];
/// let track = Track { name: "est.tum", stamp_s: Some(&[0.0, 2.0]), pose: &pose, tolerance_s: 1.0, gap_m: 5.0 };
/// let posed = with_poses(log, &track)?.recording;
/// assert_eq!((posed.poses()[1].x_m, posed.poses()[1].y_m), (1.0, 0.1));
/// assert_eq!(posed.columns().odometry[1].x_m, 1.1);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn with_poses(log: ImportedLog, track: &Track) -> Result<ImportedLog> {
    let ImportedLog {
        recording,
        mut account,
        odometry,
    } = log;
    let mut columns = recording.into_columns();
    let own = std::mem::take(&mut columns.pose);
    let mut kept = Vec::new();
    match track.stamp_s {
        None => {
            if track.pose.len() != own.len() {
                return Err(Error::file(
                    track.name,
                    format!(
                        "{} poses without times; expected {}, one a snapshot, or times for them",
                        track.pose.len(),
                        own.len()
                    ),
                ));
            }
            columns.pose = track.pose.to_vec();
            kept.extend(0..own.len());
        }
        Some(stamp_s) => {
            for (k, at_s) in columns.stamp_s.iter().enumerate() {
                match at(stamp_s, track.pose, *at_s, track.tolerance_s) {
                    Found::Pose(pose) => {
                        columns.pose.push(pose);
                        kept.push(k);
                    }
                    Found::Outside => {
                        account.passed_over("snapshot outside of the poses' time");
                    }
                    Found::Gap(off_s) => account.lost(format!(
                        "snapshot {k}, at {at_s} s: the nearest pose of {} is {off_s:.3} s away; expected one within {} s",
                        track.name, track.tolerance_s
                    )),
                }
            }
        }
    }
    if kept.is_empty() {
        let span = |stamps: &[f64]| match (stamps.first(), stamps.last()) {
            (Some(first), Some(last)) => format!("{first} to {last} s"),
            _ => "no time at all".to_string(),
        };
        return Err(Error::file(
            track.name,
            format!(
                "no snapshot has a pose: poses are stamped {}, snapshots {}; expected one clock",
                span(track.stamp_s.unwrap_or_default()),
                span(&columns.stamp_s)
            ),
        ));
    }
    let unplaced = own.iter().all(|pose| *pose == Pose::default());
    let source = match odometry {
        OdometrySource::Poses if unplaced => OdometrySource::Poses,
        OdometrySource::Poses => {
            columns.odometry = own;
            OdometrySource::Replaced
        }
        known => known,
    };
    fn of<T: Copy>(kept: &[usize], all: &mut Vec<T>) {
        *all = kept.iter().map(|k| all[*k]).collect();
    }
    of(&kept, &mut columns.stamp_s);
    match source {
        // A log without poses has no odometry either.
        OdometrySource::Poses => columns.odometry = columns.pose.clone(),
        _ => of(&kept, &mut columns.odometry),
    }
    of(&kept, &mut columns.run);
    columns
        .compass_rad
        .iter_mut()
        .for_each(|all| of(&kept, all));
    columns.route_m.iter_mut().for_each(|all| of(&kept, all));
    columns.values = columns.values.select(Axis(0), &kept);
    let (pose, reckoned, run) = (&columns.pose, &columns.odometry, &columns.run);
    columns.run = gaps::runs(pose, reckoned, source, run, track.gap_m, &mut account);
    Ok(ImportedLog {
        recording: Recording::new(columns)?,
        account,
        odometry: source,
    })
}

enum Found {
    Pose(Pose),
    /// Before the first pose or after the last.
    Outside,
    /// The nearest pose is so many seconds away.
    Gap(f64),
}

/// Where the robot was at a time, between the poses around it.
fn at(stamp_s: &[f64], pose: &[Pose], at_s: f64, tolerance_s: f64) -> Found {
    let after = stamp_s.partition_point(|stamp_s| *stamp_s < at_s);
    if after == stamp_s.len() || (after == 0 && stamp_s[0] > at_s) {
        return Found::Outside;
    }
    if stamp_s[after] == at_s {
        return Found::Pose(pose[after]);
    }
    let (from_s, to_s) = (stamp_s[after - 1], stamp_s[after]);
    let off_s = (at_s - from_s).min(to_s - at_s);
    if off_s > tolerance_s {
        return Found::Gap(off_s);
    }
    let share = (at_s - from_s) / (to_s - from_s);
    let (from, to) = (pose[after - 1], pose[after]);
    let turn_rad = wrapped(to.heading_rad - from.heading_rad);
    Found::Pose(Pose::new(
        from.x_m + share * (to.x_m - from.x_m),
        from.y_m + share * (to.y_m - from.y_m),
        wrapped(from.heading_rad + share * turn_rad),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Channel, Columns, import_report::ImportReport};

    /// Seven snapshots a second apart, a metre each by odometry.
    fn log() -> ImportedLog {
        let pose: Vec<Pose> = (0..7).map(|k| Pose::new(f64::from(k), 0.0, 0.0)).collect();
        let channel = Channel {
            name: "light".into(),
            width: 1,
            unit: "lux".into(),
            ..Channel::default()
        };
        let columns = Columns {
            channels: vec![channel],
            values: ndarray::Array2::from_shape_fn((7, 1), |(k, _)| k as f32),
            stamp_s: (0..7).map(f64::from).collect(),
            odometry: pose.clone(),
            pose,
            run: vec![0; 7],
            ..Columns::default()
        };
        ImportedLog {
            recording: Recording::new(columns).unwrap(),
            account: ImportReport::default(),
            odometry: OdometrySource::Poses,
        }
    }

    fn joined(stamp_s: Option<&[f64]>, pose: &[Pose]) -> Result<ImportedLog> {
        let track = Track {
            name: "est.tum",
            stamp_s,
            pose,
            tolerance_s: 0.5,
            gap_m: 5.0,
        };
        with_poses(log(), &track)
    }

    #[test]
    fn snapshots_outside_are_passed_over_and_those_in_a_gap_lost() {
        let stamps = [0.5, 1.5, 4.5, 5.0];
        let pose = stamps.map(|s| Pose::new(s, 1.0, 0.0));
        let log = joined(Some(&stamps), &pose).unwrap();
        let columns = log.recording.columns();
        assert_eq!(columns.stamp_s, [1.0, 2.0, 4.0, 5.0]);
        assert_eq!(columns.values.column(0).to_vec(), [1.0, 2.0, 4.0, 5.0]);
        assert!(
            columns
                .pose
                .iter()
                .zip(&columns.stamp_s)
                .all(|(p, s)| (p.x_m - s).abs() < 1e-12 && p.y_m == 1.0)
        );
        assert_eq!(columns.odometry[0].y_m, 0.0);
        assert_eq!(log.odometry, OdometrySource::Replaced);
        assert_eq!(
            log.account.passed_over_counts()["snapshot outside of the poses' time"],
            2
        );
        assert_eq!(
            log.account.lost_records(),
            [
                "snapshot 3, at 3 s: the nearest pose of est.tum is 1.500 s away; expected one within 0.5 s"
            ]
        );
    }

    #[test]
    fn headings_take_the_short_way_round() {
        let pose = [Pose::new(0.0, 0.0, 3.0), Pose::new(0.0, 0.0, -3.0)];
        let log = joined(Some(&[0.5, 1.5]), &pose).unwrap();
        let heading_rad = log.recording.poses()[0].heading_rad;
        assert!((heading_rad.abs() - std::f64::consts::PI).abs() < 1e-9);
    }

    #[test]
    fn a_jump_of_the_track_begins_a_run() {
        let pose: Vec<Pose> = (0..7)
            .map(|k| Pose::new(if k > 3 { 40.0 } else { 0.0 }, 0.0, 0.0))
            .collect();
        let log = joined(None, &pose).unwrap();
        assert_eq!(log.recording.runs().len(), 2);
    }

    #[test]
    fn clocks_and_numbers_that_do_not_fit_are_refused() {
        let pose = [Pose::default(); 3];
        let other_clock = joined(Some(&[1e9, 1e9 + 1.0, 1e9 + 2.0]), &pose).unwrap_err();
        assert!(other_clock.to_string().contains("expected one clock"));
        let too_few = joined(None, &pose).unwrap_err().to_string();
        assert!(
            too_few.contains("3 poses without times; expected 7"),
            "{too_few}"
        );
    }
}
