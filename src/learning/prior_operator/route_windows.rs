//! Along a route every window is a contiguous range of the places in order.

use super::{
    rows::Rows,
    window_sums::{RoutePlaces, Window, window_sums},
    workspace::{PriorSums, Scratch},
};
use crate::learning::lanes::Real;
use std::ops::Range;

/// Truths and candidates along a route, each in the order of their coordinate, and the window of each among the other.
pub struct RouteWindows {
    truths: RoutePlaces,
    candidates: RoutePlaces,
    /// Numbers of the places as they came; `None`: they came in order.
    truth_order: Option<Vec<usize>>,
    candidate_order: Option<Vec<usize>>,
}

impl RouteWindows {
    pub(super) fn new(half_width_m: f64, truths: &[f64], candidates: &[f64]) -> Self {
        let middle = centre(candidates);
        let (truth_x_m, truth_order) = in_order(truths, middle);
        let (candidate_x_m, candidate_order) = in_order(candidates, middle);
        Self {
            truths: RoutePlaces {
                window: windows(&truth_x_m, &candidate_x_m, half_width_m),
                x_m: truth_x_m.clone(),
            },
            candidates: RoutePlaces {
                window: windows(&candidate_x_m, &truth_x_m, half_width_m),
                x_m: candidate_x_m,
            },
            truth_order,
            candidate_order,
        }
    }

    /// Numbers of truths and candidates.
    pub(super) fn counts(&self) -> (usize, usize) {
        (self.truths.x_m.len(), self.candidates.x_m.len())
    }

    /// Candidates that the prior of every truth admits.
    pub(super) fn window_sizes(&self) -> Vec<usize> {
        let mut sizes = vec![0; self.truths.window.len()];
        for (place, window) in self.truths.window.iter().enumerate() {
            let order = self.truth_order();
            sizes[order.map_or(place, |order| order[place])] = window.end - window.first;
        }
        sizes
    }

    pub(super) fn truth_order(&self) -> Option<&[usize]> {
        self.truth_order.as_deref()
    }

    pub(super) fn candidate_order(&self) -> Option<&[usize]> {
        self.candidate_order.as_deref()
    }

    /// Coordinates of the truths, in order.
    pub(super) fn truth_x_m(&self) -> &[f64] {
        &self.truths.x_m
    }

    /// Coordinates of the candidates, in order.
    pub(super) fn candidate_x_m(&self) -> &[f64] {
        &self.candidates.x_m
    }

    /// Sums over the candidates in the windows of some truths.
    #[inline(always)]
    pub(super) fn apply<T: Real>(
        &self,
        truths: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        let sides = (&self.truths, &self.candidates);
        let out = (&mut sums.weighted[..], &mut sums.unweighted[..]);
        let (blocks, cuts) = (&scratch.map_blocks, &mut sums.map_cuts);
        window_sums(sides, truths, tile, rows, blocks, cuts, out);
    }

    /// Sums over the truths in the windows of some candidates.
    #[inline(always)]
    pub(super) fn apply_transpose<T: Real>(
        &self,
        candidates: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        let sides = (&self.candidates, &self.truths);
        let out = (&mut sums.weighted[..], &mut sums.unweighted[..]);
        let (blocks, cuts) = (&scratch.truth_blocks, &mut sums.truth_cuts);
        window_sums(sides, candidates, tile, rows, blocks, cuts, out);
    }
}

/// The window of every place of one side, in order, among the other side's, in order.
fn windows(from: &[f64], to: &[f64], half_width_m: f64) -> Vec<Window> {
    // |x_j − x_i| ≤ w as computed, so that windows are symmetric under rounding.
    let window = |&x: &f64| Window {
        first: to.partition_point(|&other| other < x && (x - other) > half_width_m),
        here: to.partition_point(|&other| other < x),
        end: to.partition_point(|&other| other <= x || (other - x) <= half_width_m),
    };
    from.iter().map(window).collect()
}

/// Coordinates from the middle in order, and the numbers they came with where that was another order.
fn in_order(values: &[f64], middle: f64) -> (Vec<f64>, Option<Vec<usize>>) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let x_m = order.iter().map(|&k| values[k] - middle).collect();
    let already_in_order = order.iter().enumerate().all(|(place, &k)| place == k);
    (x_m, (!already_in_order).then_some(order))
}

fn centre(values: &[f64]) -> f64 {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.iter().fold(ends, |(l, h), &v| (l.min(v), h.max(v)));
    if low <= high { 0.5 * (low + high) } else { 0.0 }
}
