//! How the arrays of a bank are named, whatever contains them.

use crate::belief::Uncertainty;

/// The JSON's key of the sets' headers.
pub(super) const BANK: &str = "bank";

/// Array of the runs.
pub(super) const RUN: &str = "map.run";

/// How the names of a set's arrays begin.
pub(super) fn prefix(prior: Uncertainty) -> String {
    format!("set.{prior}.")
}

/// Is an array one of all sets?
pub(super) fn is_shared(name: &str) -> bool {
    ["map.pose", "map.route"].contains(&name)
}
