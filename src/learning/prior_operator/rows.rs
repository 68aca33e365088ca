//! What is summed, and in which portions.

use crate::learning::lanes::Lanes;

/// Places that are worked on together.
pub(in crate::learning) const CHUNK: usize = 64;

/// A matrix with a row for each place that is summed over, in the operator's order: `[place, tile]` of sixteen outcomes
/// each.
pub(in crate::learning) struct Rows<'a, T> {
    /// Tiles of sixteen outcomes that a place has.
    pub tiles: usize,
    /// Summed with weight e.
    pub weighted: &'a [Lanes<T>],
    /// Summed without a weight; `None`: the same rows.
    pub unweighted: Option<&'a [Lanes<f64>]>,
}
