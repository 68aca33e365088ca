//! Clocks that stand still or run backwards.

use crate::recording::import_report::ImportReport;
use std::collections::BTreeMap;

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
