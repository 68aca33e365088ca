//! Raw odometry between scans, as far as a CARMEN log still holds it.
//!
//! Mapping programs write corrected logs in which both poses of a scan are the corrected one, and the ODOM lines after a
//! scan start at its corrected pose and add raw odometry from there. The jump from the last ODOM line to the next scan
//! is then the correction and no movement: the robot's own odometry is what the ODOM lines add up to without the jumps.

use crate::{geometry::Pose, recording::imported_log::OdometrySource};

/// Poses nearer than this (metres, radians) are the same number written twice.
const SAME: f64 = 1e-6;
/// An ODOM track that stays this near to the scans, in the median, is what their poses were taken from.
const FOLLOWS_M: f64 = 0.05;

/// What happened, in the order of the log.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    Odometry {
        pose: Pose,
        stamp_s: f64,
    },
    Scan {
        pose: Pose,
        stated: Option<Pose>,
        stamp_s: f64,
    },
}

/// The cumulative odometry of each scan.
pub(super) fn of_scans(steps: &[Step]) -> (Vec<Pose>, OdometrySource) {
    let poses = || scans(steps).map(|(pose, _)| pose);
    if scans(steps).any(|(pose, stated)| stated.is_some_and(|o| !same(&o, &pose))) {
        let stated = scans(steps).map(|(pose, stated)| stated.unwrap_or(pose));
        return (stated.collect(), OdometrySource::Stated);
    }
    if restarts_at_scans(steps) {
        return (added_up(steps), OdometrySource::Restarted);
    }
    match track(steps) {
        Some(track) if median_distance_m(&track, poses()) > FOLLOWS_M => {
            (track, OdometrySource::Track)
        }
        _ => (poses().collect(), OdometrySource::Poses),
    }
}

fn scans(steps: &[Step]) -> impl Iterator<Item = (Pose, Option<Pose>)> {
    steps.iter().filter_map(|step| match *step {
        Step::Scan { pose, stated, .. } => Some((pose, stated)),
        Step::Odometry { .. } => None,
    })
}

fn same(a: &Pose, b: &Pose) -> bool {
    a.distance_m(b) < SAME && a.turn_rad(b) < SAME
}

/// Does the ODOM line after a scan repeat its pose (nine times in ten), while the one before it bears the scan's own time
/// stamp (mostly), so that the jump between the two is no movement?
fn restarts_at_scans(steps: &[Step]) -> bool {
    let (mut surrounded, mut repeated, mut simultaneous) = (0, 0, 0);
    for neighbours in steps.windows(3) {
        if let [
            Step::Odometry {
                stamp_s: before_s, ..
            },
            Step::Scan { pose, stamp_s, .. },
            Step::Odometry { pose: after, .. },
        ] = neighbours
        {
            surrounded += 1;
            repeated += usize::from(same(pose, after));
            simultaneous += usize::from(before_s == stamp_s);
        }
    }
    surrounded > 0 && repeated * 10 >= surrounded * 9 && simultaneous * 2 >= surrounded
}

fn added_up(steps: &[Step]) -> Vec<Pose> {
    let mut odometry = Vec::new();
    let mut sum: Option<Pose> = None;
    let mut last = Pose::default();
    let mut moved = false;
    for step in steps {
        match *step {
            Step::Odometry { pose, .. } => {
                sum = Some(sum.map_or(pose, |sum| sum.after(last.displacement_to(&pose))));
                (last, moved) = (pose, true);
            }
            Step::Scan { pose, .. } => {
                // Where no ODOM line stands between two scans, their poses are all that is known of the movement.
                let at_scan = match sum {
                    None => pose,
                    Some(sum) if moved => sum,
                    Some(sum) => sum.after(last.displacement_to(&pose)),
                };
                odometry.push(at_scan);
                sum = Some(at_scan);
                (last, moved) = (pose, false);
            }
        }
    }
    odometry
}

/// The ODOM pose before each scan (for scans before the first, that one); `None` without ODOM lines.
fn track(steps: &[Step]) -> Option<Vec<Pose>> {
    let mut last = steps.iter().find_map(|step| match *step {
        Step::Odometry { pose, .. } => Some(pose),
        Step::Scan { .. } => None,
    })?;
    let mut track = Vec::new();
    for step in steps {
        match *step {
            Step::Odometry { pose, .. } => last = pose,
            Step::Scan { .. } => track.push(last),
        }
    }
    Some(track)
}

fn median_distance_m(track: &[Pose], poses: impl Iterator<Item = Pose>) -> f64 {
    let mut distances: Vec<f64> = track
        .iter()
        .zip(poses)
        .map(|(a, b)| a.distance_m(&b))
        .collect();
    distances.sort_unstable_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_m: f64) -> Pose {
        Pose::new(x_m, 0.0, 0.0)
    }

    fn odometry(x_m: f64, stamp_s: f64) -> Step {
        Step::Odometry {
            pose: at(x_m),
            stamp_s,
        }
    }

    fn scan(x_m: f64, stamp_s: f64) -> Step {
        Step::Scan {
            pose: at(x_m),
            stated: Some(at(x_m)),
            stamp_s,
        }
    }

    #[test]
    fn corrections_are_left_out_and_movements_kept() {
        // Raw steps of 1 m, each corrected by 10 cm.
        let steps = [
            odometry(0.0, 0.0),
            odometry(1.0, 1.0),
            scan(1.1, 1.0),
            odometry(1.1, 0.0),
            odometry(2.1, 2.0),
            scan(2.2, 2.0),
            odometry(2.2, 0.0),
            odometry(3.2, 3.0),
            scan(3.3, 3.0),
        ];
        let (recovered, source) = of_scans(&steps);
        assert_eq!(source, OdometrySource::Restarted);
        let x: Vec<f64> = recovered.iter().map(|p| p.x_m).collect();
        assert!(
            x.iter()
                .zip([1.0, 2.0, 3.0])
                .all(|(a, b)| (a - b).abs() < 1e-12),
            "{x:?}"
        );
    }

    #[test]
    fn a_raw_log_keeps_its_whole_movement() {
        // Scans between ODOM lines of one continuous track.
        let steps = [
            odometry(0.0, 0.0),
            scan(0.5, 0.5),
            odometry(1.0, 1.0),
            scan(1.5, 1.5),
            odometry(2.0, 2.0),
        ];
        let (recovered, source) = of_scans(&steps);
        assert_eq!(
            (recovered[1].x_m - recovered[0].x_m, source),
            (1.0, OdometrySource::Track)
        );
        // A scan logged just before the ODOM line that it took its pose from: the step up to it is movement.
        let steps = [
            odometry(0.0, 0.0),
            scan(1.0, 1.0),
            odometry(1.0, 1.0),
            scan(2.0, 2.0),
            odometry(2.0, 2.0),
        ];
        assert_eq!(of_scans(&steps).0[1].x_m - of_scans(&steps).0[0].x_m, 1.0);
    }

    #[test]
    fn stated_odometry_is_taken_as_it_is() {
        let steps = [
            Step::Scan {
                pose: at(1.0),
                stated: Some(at(0.9)),
                stamp_s: 0.0,
            },
            Step::Scan {
                pose: at(2.0),
                stated: Some(at(1.7)),
                stamp_s: 1.0,
            },
        ];
        assert_eq!(
            of_scans(&steps),
            (vec![at(0.9), at(1.7)], OdometrySource::Stated)
        );
        assert_eq!(
            of_scans(&[scan(4.0, 0.0)]),
            (vec![at(4.0)], OdometrySource::Poses)
        );
    }
}
