//! The contingency table of true locations and responses (Duckett & Nehmzow 1998, 4.1, Fig. 3).

use foldhash::fast::FixedState;
use std::{collections::HashMap, hash::Hash};

/// Numbers of labels. Hashed fast instead of safe from whoever picks labels to collide: they come from one's own run or
/// file, there are few of them, and looking them up is most of the work of filling a table.
pub(super) type Ordinals<T> = HashMap<T, usize, FixedState>;

/// A table of at most so many cells, empty ones included, is counted as a whole; or of at most so many a data point.
const DENSE_CELLS: usize = 1 << 12;
const DENSE_CELLS_A_POINT: usize = 2;

/// How often each response was given at each location. Any two types of label will do: bin numbers, names, sets.
///
/// The table is filled by [`record`](Contingency::record) alone and has no axes to confuse: what is a row and what a
/// column is known in this file only. Duckett & Nehmzow's Fig. 3, worked by hand:
///
/// ```
/// use ballmark::score::{Contingency, Entropies};
/// let figure_3 = [
///     [0, 2, 15, 0, 1], // times that response 0 was given at locations 0, 1, 2, 3, 4
///     [10, 10, 0, 0, 0],
///     [0, 2, 1, 0, 19],
///     [5, 7, 3, 1, 1],
///     [0, 0, 0, 23, 0],
/// ];
/// let mut table = Contingency::new();
/// for (response, times_at) in figure_3.iter().enumerate() {
///     for (location, &times) in times_at.iter().enumerate() {
///         for _ in 0..times {
///             table.record(location, response);
///         }
///     }
/// }
/// assert_eq!(table.count(&4, &2), 19);
/// let counts = table.counts();
/// assert_eq!(counts.responses(), [17, 18, 20, 22, 23]); // ascending
/// assert_eq!(counts.locations(), [15, 19, 21, 21, 24]);
/// assert_eq!(counts.total(), 100);
///
/// // 15 of 100 at one location, 19, 21, 21 and 24 at the others: H(L) = −.15 ln .15 − .19 ln .19 − …
/// let entropies = Entropies::of(&counts);
/// assert!((entropies.location - 1.598087).abs() < 1e-6);
/// assert!((entropies.response - 1.602918).abs() < 1e-6);
/// assert!((entropies.joint - 2.180469).abs() < 1e-6);
/// assert!((entropies.location_given_response() - 0.577551).abs() < 1e-6);
/// assert!((entropies.uncertainty_coefficient().unwrap() - 0.638598).abs() < 1e-6);
/// ```
#[derive(Debug, Clone)]
pub struct Contingency<L, R> {
    locations: Ordinals<L>,
    responses: Ordinals<R>,
    /// `(location, response)`, one a data point, by order of the labels' first appearance.
    points: Vec<(usize, usize)>,
}

/// Totals and cells of a table without their labels, each in ascending order and without zeros: the order of rows and
/// columns "makes no difference to the outcome" (Duckett & Nehmzow 1998, 4.1), here to the last bit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Counts {
    locations: Vec<u64>,
    responses: Vec<u64>,
    cells: Vec<u64>,
}

impl<L: Eq + Hash, R: Eq + Hash> Default for Contingency<L, R> {
    fn default() -> Self {
        Self::new()
    }
}

impl<L: Eq + Hash, R: Eq + Hash> Contingency<L, R> {
    /// A table without data points.
    pub fn new() -> Self {
        Self {
            locations: Ordinals::default(),
            responses: Ordinals::default(),
            points: Vec::new(),
        }
    }

    /// One data point: the robot was at `location` and answered `response`.
    pub fn record(&mut self, location: L, response: R) {
        let location = ordinal(&mut self.locations, location);
        let response = ordinal(&mut self.responses, response);
        self.points.push((location, response));
    }

    /// Number of data points N.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Is there no data point?
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// N_rl: how often `response` was given at `location`.
    pub fn count(&self, location: &L, response: &R) -> u64 {
        let (Some(&l), Some(&r)) = (self.locations.get(location), self.responses.get(response))
        else {
            return 0;
        };
        self.points.iter().filter(|&&point| point == (l, r)).count() as u64
    }

    /// The table's totals and cells.
    pub fn counts(&self) -> Counts {
        let (rows, columns) = (self.locations.len(), self.responses.len());
        let most = DENSE_CELLS.max(DENSE_CELLS_A_POINT * self.points.len());
        match rows.checked_mul(columns) {
            Some(cells) if (1..=most).contains(&cells) => self.dense_counts(rows, columns),
            _ => self.by_location().counts(|_| 1),
        }
    }

    /// The same counts by one walk over the data points, for tables that are not mostly empty.
    fn dense_counts(&self, rows: usize, columns: usize) -> Counts {
        let mut cells = vec![0; rows * columns]; // N_rl
        for &(location, response) in &self.points {
            cells[location * columns + response] += 1;
        }
        let mut responses = vec![0; columns];
        let total_of = |row: &[u64]| row.iter().sum(); // N_•l (eq. 16)
        let locations = cells.chunks(columns).map(total_of).collect();
        for row in cells.chunks(columns) {
            let totals = responses.iter_mut().zip(row);
            totals.for_each(|(total, cell)| *total += cell); // N_r• (eq. 15)
        }
        Counts::new(locations, responses, cells)
    }

    /// Data points sorted by location, remembering in which order they were recorded.
    pub(super) fn by_location(&self) -> ByLocation {
        let mut starts = vec![0; self.locations.len() + 1];
        for &(location, _) in &self.points {
            starts[location + 1] += 1;
        }
        for location in 0..self.locations.len() {
            starts[location + 1] += starts[location];
        }
        let mut next = starts.clone();
        let mut responses = vec![0; self.points.len()];
        let mut recorded = vec![0; self.points.len()];
        for (index, &(location, response)) in self.points.iter().enumerate() {
            responses[next[location]] = response;
            recorded[next[location]] = index;
            next[location] += 1;
        }
        ByLocation {
            starts,
            responses,
            recorded,
            response_labels: self.responses.len(),
        }
    }
}

/// Number of a label: that of its first appearance.
pub(super) fn ordinal<T: Eq + Hash>(labels: &mut Ordinals<T>, label: T) -> usize {
    if let Some(&known) = labels.get(&label) {
        return known; // nearly always; `entry` is slower
    }
    labels.insert(label, labels.len());
    labels.len() - 1
}

/// The data points in the order of their locations, for counting them again and again with other weights or with
/// shuffled responses.
pub(super) struct ByLocation {
    /// Points of location l are those from `starts[l]` to `starts[l + 1]`.
    starts: Vec<usize>,
    responses: Vec<usize>,
    recorded: Vec<usize>,
    response_labels: usize,
}

impl ByLocation {
    /// The counts where the data point that was recorded as number k counts `weight(k)` times.
    pub(super) fn counts(&self, weight: impl Fn(usize) -> u64) -> Counts {
        let mut locations = Vec::with_capacity(self.starts.len());
        let mut totals = vec![0; self.response_labels];
        let mut at_location = vec![0; self.response_labels];
        let (mut seen, mut cells) = (Vec::new(), Vec::new());
        for bounds in self.starts.windows(2) {
            for k in bounds[0]..bounds[1] {
                let (response, times) = (self.responses[k], weight(self.recorded[k]));
                if times > 0 && at_location[response] == 0 {
                    seen.push(response);
                }
                at_location[response] += times; // N_rl
                totals[response] += times; // N_r• (eq. 15)
            }
            let mut total = 0;
            for response in seen.drain(..) {
                let cell = std::mem::take(&mut at_location[response]);
                total += cell; // N_•l (eq. 16)
                cells.push(cell);
            }
            locations.push(total);
        }
        Counts::new(locations, totals, cells)
    }
}

impl Counts {
    fn new(locations: Vec<u64>, responses: Vec<u64>, cells: Vec<u64>) -> Self {
        let ascending = |mut counts: Vec<u64>| {
            counts.retain(|&count| count > 0);
            counts.sort_unstable();
            counts
        };
        Self {
            locations: ascending(locations),
            responses: ascending(responses),
            cells: ascending(cells),
        }
    }

    /// N_•l: how often the robot was at each location, ascending.
    pub fn locations(&self) -> &[u64] {
        &self.locations
    }

    /// N_r•: how often each response was given, ascending.
    pub fn responses(&self) -> &[u64] {
        &self.responses
    }

    /// N_rl: every cell that is not empty, ascending.
    pub fn cells(&self) -> &[u64] {
        &self.cells
    }

    /// N: all data points (eq. 17).
    pub fn total(&self) -> u64 {
        self.cells.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_do_not_depend_on_the_order_of_recording() {
        let points = [("hall", 3), ("door", 1), ("hall", 3), ("hall", 2)];
        let (mut forward, mut backward) = (Contingency::new(), Contingency::new());
        points.iter().for_each(|&(l, r)| forward.record(l, r));
        points
            .iter()
            .rev()
            .for_each(|&(l, r)| backward.record(l, r));
        assert_eq!(forward.counts(), backward.counts());
        assert_eq!(forward.counts().cells(), [1, 1, 2]);
        assert_eq!(forward.count(&"hall", &3), 2);
        assert_eq!(forward.count(&"door", &3), 0);
        assert_eq!(forward.count(&"roof", &3), 0);
    }

    #[test]
    fn weights_say_how_often_a_point_counts() {
        let mut table = Contingency::new();
        for (location, response) in [("a", 0), ("b", 0), ("a", 1)] {
            table.record(location, response);
        }
        let counts = table.by_location().counts(|k| [0, 5, 2][k]);
        assert_eq!(counts.locations(), [2, 5]);
        assert_eq!(counts.responses(), [2, 5]);
        assert_eq!(counts.cells(), [2, 5]);
    }

    /// A table counted as a whole, and one too sparse for that, against the walk by location.
    #[test]
    fn both_ways_of_counting_agree() {
        for (points, locations) in [(3_000, 40), (10_000, 9_000)] {
            let mut table = Contingency::new();
            for k in 0..points {
                table.record(k * 7_919 % locations, k * k % 37);
            }
            let (rows, columns) = (table.locations.len(), table.responses.len());
            let counts = table.by_location().counts(|_| 1);
            assert_eq!(table.counts(), counts);
            assert_eq!(table.dense_counts(rows, columns), counts);
            assert_eq!(counts.total(), points as u64);
        }
    }

    #[test]
    fn an_empty_table_counts_nothing() {
        let table = Contingency::<u8, u8>::new();
        assert!(table.is_empty());
        assert_eq!(table.counts().total(), 0);
    }
}
