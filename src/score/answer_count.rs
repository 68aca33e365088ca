//! A contingency table with its labels, for records and pictures.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How often a response was given at a location.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AnswerCount {
    /// The bin of the true place.
    pub location: usize,
    /// What was answered there.
    pub response: String,
    /// So many times, at least once.
    pub count: u64,
}

impl AnswerCount {
    /// The cells of a contingency table that hold anything, in order, from its data points.
    ///
    /// ```
    /// use ballmark::score::AnswerCount;
    /// let points = [(1, "a"), (0, "b"), (1, "a")];
    /// let all = AnswerCount::all(points.map(|(at, response)| (at, response.to_string())));
    /// assert_eq!((all[0].location, all[1].count), (0, 2));
    /// ```
    pub fn all(points: impl IntoIterator<Item = (usize, String)>) -> Vec<Self> {
        let mut counts: BTreeMap<(usize, String), u64> = BTreeMap::new();
        for point in points {
            *counts.entry(point).or_default() += 1;
        }
        let counted = counts.into_iter();
        let of = |((location, response), count)| Self {
            location,
            response,
            count,
        };
        counted.map(of).collect()
    }
}
