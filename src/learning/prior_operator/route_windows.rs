//! Along a route every window is a contiguous range of the places in order.

use super::{
    Answers, Asking, Rows,
    block_sums::{BlockSums, answer},
};
use crate::learning::lanes::Real;
use std::ops::Range;

/// Truths and candidates along a route, each in the order of their coordinate, and what each sees of the other.
pub struct RouteWindows {
    truths: Side,
    candidates: Side,
}

/// The places of one side, in order.
pub(super) struct Side {
    /// Coordinates, in metres from the middle of the route: smaller numbers cancel less.
    pub(super) x_m: Vec<f64>,
    /// Of every place: its window among the other side's places in order. All three cuts grow from place to place.
    pub(super) window: Vec<Window>,
    /// Numbers of the places as they came; `None`: they came in order.
    order: Option<Vec<usize>>,
}

/// A range of places in order, cut where the place that looks would stand itself.
#[derive(Clone, Copy)]
pub(super) struct Window {
    pub(super) first: usize,
    pub(super) here: usize,
    pub(super) end: usize,
}

impl RouteWindows {
    pub(super) fn new(half_width_m: f64, truths: &[f64], candidates: &[f64]) -> Self {
        let middle = centre(candidates);
        let (truth_x_m, truth_order) = in_order(truths, middle);
        let (candidate_x_m, candidate_order) = in_order(candidates, middle);
        Self {
            truths: Side {
                window: windows(&truth_x_m, &candidate_x_m, half_width_m),
                x_m: truth_x_m.clone(),
                order: truth_order,
            },
            candidates: Side {
                window: windows(&candidate_x_m, &truth_x_m, half_width_m),
                x_m: candidate_x_m,
                order: candidate_order,
            },
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
            let order = self.truths.order.as_ref();
            sizes[order.map_or(place, |order| order[place])] = window.end - window.first;
        }
        sizes
    }

    pub(super) fn order(&self, side: Asking) -> Option<&[usize]> {
        match side {
            Asking::Truths => self.truths.order.as_deref(),
            Asking::Candidates => self.candidates.order.as_deref(),
        }
    }

    fn sides(&self, asking: Asking) -> (&Side, &Side) {
        match asking {
            Asking::Truths => (&self.truths, &self.candidates),
            Asking::Candidates => (&self.candidates, &self.truths),
        }
    }

    /// Coordinates of the places that `asking` asks about, in order.
    pub(super) fn asked_x_m(&self, asking: Asking) -> &[f64] {
        &self.sides(asking).1.x_m
    }

    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "one sum for each kind of rows")]
    pub(super) fn answer<T: Real>(
        &self,
        asking: Asking,
        places: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        one: &BlockSums<2>,
        two: &BlockSums<3>,
        answers: &mut Answers,
    ) {
        let sides = self.sides(asking);
        let Answers {
            weighted,
            unweighted,
            cuts_of_one,
            cuts_of_two,
        } = answers;
        let out = (&mut weighted[..], &mut unweighted[..]);
        match rows.unweighted {
            None => answer(sides, places, tile, rows, one, cuts_of_one, out),
            Some(_) => answer(sides, places, tile, rows, two, cuts_of_two, out),
        }
    }
}

/// Of every place `from`, in order: its window `to` the other side, in order.
fn windows(from: &[f64], to: &[f64], half_width_m: f64) -> Vec<Window> {
    // |x_j − x_i| ≤ w as computed, so that windows are symmetric under rounding.
    let look = |&x: &f64| Window {
        first: to.partition_point(|&other| other < x && (x - other) > half_width_m),
        here: to.partition_point(|&other| other < x),
        end: to.partition_point(|&other| other <= x || (other - x) <= half_width_m),
    };
    from.iter().map(look).collect()
}

/// Coordinates from the middle in order, and the numbers they came with where that was another order.
fn in_order(values: &[f64], middle: f64) -> (Vec<f64>, Option<Vec<usize>>) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let x_m = order.iter().map(|&k| values[k] - middle).collect();
    let as_they_came = order.iter().enumerate().all(|(place, &k)| place == k);
    (x_m, (!as_they_came).then_some(order))
}

fn centre(values: &[f64]) -> f64 {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.iter().fold(ends, |(l, h), &v| (l.min(v), h.max(v)));
    if low <= high { 0.5 * (low + high) } else { 0.0 }
}
