//! Where a log breaks off: clocks that run backwards, and gaps where a new run begins.

use crate::{
    geometry::Pose,
    recording::{import_report::ImportReport, imported_log::OdometrySource},
};
use std::collections::BTreeMap;

/// A step longer than this that odometry knows nothing of is a gap in the log.
const GAP_M: f64 = 5.0;

/// The run of each snapshot: a new one at every gap.
pub(super) fn runs(
    pose: &[Pose],
    odometry: &[Pose],
    source: OdometrySource,
    account: &mut ImportReport,
) -> Vec<i64> {
    let mut run = 0;
    let mut runs = vec![0; pose.len()];
    for k in 1..pose.len() {
        let step_m = pose[k].distance_m(&pose[k - 1]);
        let known_m = match source {
            OdometrySource::Poses => 0.0,
            _ => odometry[k].distance_m(&odometry[k - 1]),
        };
        if step_m > GAP_M && known_m < step_m / 2.0 {
            account.warning("gap of more than 5 m, where a new run begins");
            run += 1;
        }
        runs[k] = run;
    }
    runs
}

/// The last stamp of each kind of message.
#[derive(Default)]
pub(super) struct Clocks<'a>(BTreeMap<&'a str, f64>);

impl<'a> Clocks<'a> {
    /// Warns of a stamp that is 0, or not later than the one before of its kind.
    pub(super) fn check(&mut self, kind: &'a str, stamp_s: f64, account: &mut ImportReport) {
        if stamp_s == 0.0 {
            account.warning(&format!("{kind} stamped 0"));
            return;
        }
        match self.0.insert(kind, stamp_s) {
            Some(last) if stamp_s < last => {
                account.warning(&format!("{kind} stamped before the one ahead of it"))
            }
            Some(last) if stamp_s == last => {
                account.warning(&format!("{kind} stamped like the one ahead of it"))
            }
            _ => {}
        }
    }
}
