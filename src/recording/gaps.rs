//! Where a log has a gap, a new run begins.

use crate::{
    geometry::Pose,
    recording::{import_report::ImportReport, imported_log::OdometrySource},
};

/// The run of each snapshot, counted from 0 by what the log says itself: a new one also wherever the robot is farther than
/// `gap_m` from where it was, and odometry knows less than half of it.
pub(super) fn runs(
    pose: &[Pose],
    odometry: &[Pose],
    source: OdometrySource,
    stated: &[i64],
    gap_m: f64,
    account: &mut ImportReport,
) -> Vec<i64> {
    let mut run = 0;
    let mut runs = vec![0; pose.len()];
    let mut gaps = 0;
    for k in 1..pose.len() {
        let step_m = pose[k].distance_m(&pose[k - 1]);
        let known_m = match source {
            OdometrySource::Poses => 0.0,
            _ => odometry[k].distance_m(&odometry[k - 1]),
        };
        if stated[k] != stated[k - 1] {
            run += 1;
        } else if step_m > gap_m && known_m < step_m / 2.0 {
            account.warning(&format!(
                "gap of more than {gap_m} m, where a new run begins"
            ));
            run += 1;
            gaps += 1;
        }
        runs[k] = run;
    }
    if gaps > pose.len() / 2 {
        account.note(format!(
            "most snapshots lie more than {gap_m} m from the one before: single places rather than a drive"
        ));
    }
    if gaps == 0 { stated.to_vec() } else { runs }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_odometry_knows_nothing_of_begins_a_run() {
        let at = |x: f64| Pose::new(x, 0.0, 0.0);
        let pose = [0.0, 1.0, 9.0, 10.0, 10.5].map(at);
        let reckoned = [0.0, 1.0, 8.5, 9.0, 9.5].map(at);
        let mut account = ImportReport::default();
        let account = &mut account;
        let cut = |account: &mut ImportReport, source, stated: [i64; 5], gap_m| {
            runs(&pose, &reckoned, source, &stated, gap_m, account)
        };
        assert_eq!(
            cut(account, OdometrySource::Poses, [7; 5], 5.0),
            [0, 0, 1, 1, 1]
        );
        assert_eq!(
            cut(account, OdometrySource::Poses, [4, 4, 4, 9, 9], 5.0),
            [0, 0, 1, 2, 2]
        );
        assert_eq!(cut(account, OdometrySource::Stated, [7; 5], 5.0), [7; 5]);
        assert_eq!(cut(account, OdometrySource::Poses, [7; 5], 10.0), [7; 5]);
        assert_eq!(
            account.warning_counts()["gap of more than 5 m, where a new run begins"],
            2
        );
        assert!(account.notes().is_empty());
        cut(account, OdometrySource::Poses, [0; 5], 0.4);
        assert_eq!(account.notes().len(), 1);
    }
}
