//! Along a route every window is a contiguous range, so running sums give all products in O((T + C)·F).

use ndarray::{Array2, ArrayView2, Axis};
use rayon::prelude::*;

/// Along a route, in order of the coordinate, candidates within a window are neighbours, and running sums of P and x·P
/// give every window's sums by one subtraction.
pub struct RouteWindows {
    truths: Side,
    candidates: Side,
}

/// The places of one side, and what each sees of the other.
struct Side {
    /// Coordinates, in metres from the middle of the route: smaller numbers cancel less.
    x_m: Vec<f64>,
    /// The places in the order of their coordinate.
    order: Vec<usize>,
    /// Of every place: its window among the other side's places in order.
    window: Vec<Window>,
}

/// A range of places in order, cut where the place that looks would stand itself.
#[derive(Clone, Copy)]
struct Window {
    first: usize,
    here: usize,
    end: usize,
}

impl Window {
    fn size(&self) -> usize {
        self.end - self.first
    }
}

impl RouteWindows {
    pub(super) fn new(half_width_m: f64, truths: &[f64], candidates: &[f64]) -> Self {
        let middle = centre(candidates);
        let centred = |values: &[f64]| -> Vec<f64> { values.iter().map(|x| x - middle).collect() };
        let (truths, candidates) = (centred(truths), centred(candidates));
        let order = |values: &[f64]| {
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
            order
        };
        let (truth_order, candidate_order) = (order(&truths), order(&candidates));
        // |x_j − x_i| ≤ w as computed, so that windows are symmetric under rounding.
        let windows = |from: &[f64], to: &[f64], order: &[usize]| -> Vec<Window> {
            let look = |&x: &f64| Window {
                first: order.partition_point(|&j| to[j] < x && (x - to[j]) > half_width_m),
                here: order.partition_point(|&j| to[j] < x),
                end: order.partition_point(|&j| to[j] <= x || (to[j] - x) <= half_width_m),
            };
            from.iter().map(look).collect()
        };
        let of_truths = windows(&truths, &candidates, &candidate_order);
        let of_candidates = windows(&candidates, &truths, &truth_order);
        Self {
            truths: Side {
                x_m: truths,
                order: truth_order,
                window: of_truths,
            },
            candidates: Side {
                x_m: candidates,
                order: candidate_order,
                window: of_candidates,
            },
        }
    }

    /// Candidates that the prior of every truth admits.
    pub(super) fn window_sizes(&self) -> Vec<usize> {
        self.truths.window.iter().map(Window::size).collect()
    }

    pub(super) fn candidates(&self) -> usize {
        self.candidates.x_m.len()
    }

    /// Bel of a truth at each of its candidates.
    fn share(&self, truth: usize) -> f64 {
        1.0 / self.truths.window[truth].size().max(1) as f64
    }

    pub(super) fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        let sums = RunningSums::new(&self.candidates, map, |_| 1.0);
        let mut n = Array2::zeros((self.truths.x_m.len(), map.ncols()));
        let mut d = Array2::zeros(n.raw_dim());
        let rows = n
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(d.axis_iter_mut(Axis(0)));
        rows.enumerate()
            .with_min_len(ROWS)
            .for_each(|(truth, (mut n, mut d))| {
                let (window, share) = (self.truths.window[truth], self.share(truth));
                sums.distances(window, self.truths.x_m[truth], share, n.as_slice_mut());
                sums.masses(window, share, d.as_slice_mut());
            });
        (n, d)
    }

    pub(super) fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        let (u, v) = rayon::join(
            || RunningSums::new(&self.truths, u, |truth| self.share(truth)),
            || RunningSums::new(&self.truths, v, |truth| self.share(truth)),
        );
        let mut out = Array2::zeros((self.candidates.x_m.len(), u.width));
        let rows = out.axis_iter_mut(Axis(0)).into_par_iter().enumerate();
        rows.with_min_len(ROWS).for_each(|(candidate, mut row)| {
            let window = self.candidates.window[candidate];
            u.distances(
                window,
                self.candidates.x_m[candidate],
                1.0,
                row.as_slice_mut(),
            );
            v.masses(window, -1.0, row.as_slice_mut());
        });
        out
    }
}

/// Rows that a thread takes at least: fewer are not worth the handing over.
const ROWS: usize = 128;

/// Σ_{j<i} P_j and Σ_{j<i} x_j·P_j for every i, outcomes side by side, both of a place together.
struct RunningSums {
    width: usize,
    /// `[place, mass or moment, outcome]`
    sums: Vec<f64>,
}

impl RunningSums {
    fn new(side: &Side, rows: ArrayView2<f64>, share: impl Fn(usize) -> f64) -> Self {
        let width = rows.ncols();
        let rows = rows.as_standard_layout();
        let values = rows.as_slice().unwrap_or_default(); // a standard layout is a slice
        let mut sums = Vec::with_capacity((side.order.len() + 1) * 2 * width);
        sums.resize(2 * width, 0.0);
        let mut running = vec![0.0; 2 * width];
        for &k in &side.order {
            let (x, share) = (side.x_m[k], share(k));
            let (mass, moment) = running.split_at_mut(width);
            let row = &values[k * width..(k + 1) * width];
            for ((mass, moment), p) in mass.iter_mut().zip(moment).zip(row) {
                *mass += share * p;
                *moment += x * (share * p);
            }
            sums.extend_from_slice(&running);
        }
        Self { width, sums }
    }

    /// Running mass and moment before place number `i` in order.
    fn before(&self, i: usize) -> (&[f64], &[f64]) {
        self.sums[2 * self.width * i..2 * self.width * (i + 1)].split_at(self.width)
    }

    /// Adds `share`·Σ |x_j − x|·P_j over the window.
    fn distances(&self, window: Window, x: f64, share: f64, out: Option<&mut [f64]>) {
        let (first, here, end) = (
            self.before(window.first),
            self.before(window.here),
            self.before(window.end),
        );
        let masses = first.0.iter().zip(here.0).zip(end.0);
        let moments = first.1.iter().zip(here.1).zip(end.1);
        for (out, (((m0, m1), m2), ((x0, x1), x2))) in
            out.into_iter().flatten().zip(masses.zip(moments))
        {
            let behind = x * (m1 - m0) - (x1 - x0);
            let ahead = (x2 - x1) - x * (m2 - m1);
            *out += share * (behind + ahead);
        }
    }

    /// Adds `share`·Σ P_j over the window.
    fn masses(&self, window: Window, share: f64, out: Option<&mut [f64]>) {
        let (first, end) = (self.before(window.first).0, self.before(window.end).0);
        for (out, (m0, m2)) in out.into_iter().flatten().zip(first.iter().zip(end)) {
            *out += share * (m2 - m0);
        }
    }
}

fn centre(values: &[f64]) -> f64 {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.iter().fold(ends, |(l, h), &v| (l.min(v), h.max(v)));
    if low <= high { 0.5 * (low + high) } else { 0.0 }
}
