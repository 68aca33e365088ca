//! Along a route every window is a contiguous range, so running sums give all products in O((T + C)·F).

use ndarray::{Array2, ArrayView2};

/// Along a route, in order of the coordinate, candidates within a window are neighbours, and running sums of P and x·P
/// give every window's sums by one subtraction.
pub struct RouteWindows {
    /// Coordinates sorted, and where each came from.
    truth_m: Vec<f64>,
    truth_order: Vec<usize>,
    candidate_m: Vec<f64>,
    candidate_order: Vec<usize>,
    /// Sorted truth → (first, past the last) sorted candidate of its window; and the other way round.
    truth_window: Vec<(usize, usize)>,
    candidate_window: Vec<(usize, usize)>,
    /// Sorted truth → number of sorted candidates before it; and the other way round.
    candidates_before: Vec<usize>,
    truths_before: Vec<usize>,
}

impl RouteWindows {
    pub(super) fn new(half_width_m: f64, truths: &[f64], candidates: &[f64]) -> Self {
        let middle = centre(candidates);
        let sorted = |values: &[f64]| {
            let mut order: Vec<usize> = (0..values.len()).collect();
            order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
            // Coordinates from the middle of the route: smaller numbers cancel less.
            (
                order
                    .iter()
                    .map(|&k| values[k] - middle)
                    .collect::<Vec<f64>>(),
                order,
            )
        };
        let (truth_m, truth_order) = sorted(truths);
        let (candidate_m, candidate_order) = sorted(candidates);
        // |x_j − x_i| ≤ w as computed, so that windows are symmetric under rounding.
        let windows = |from: &[f64], to: &[f64]| -> Vec<(usize, usize)> {
            from.iter()
                .map(|&x| {
                    let first = to.partition_point(|&y| y < x && (x - y) > half_width_m);
                    (
                        first,
                        to.partition_point(|&y| y <= x || (y - x) <= half_width_m),
                    )
                })
                .collect()
        };
        let before = |from: &[f64], to: &[f64]| {
            from.iter()
                .map(|&x| to.partition_point(|&y| y < x))
                .collect()
        };
        Self {
            truth_window: windows(&truth_m, &candidate_m),
            candidate_window: windows(&candidate_m, &truth_m),
            candidates_before: before(&truth_m, &candidate_m),
            truths_before: before(&candidate_m, &truth_m),
            truth_m,
            truth_order,
            candidate_m,
            candidate_order,
        }
    }

    /// Candidates that the prior of every truth admits.
    pub(super) fn window_sizes(&self) -> Vec<usize> {
        let mut sizes = vec![0; self.truth_m.len()];
        for (&truth, &(first, end)) in self.truth_order.iter().zip(&self.truth_window) {
            sizes[truth] = end - first;
        }
        sizes
    }

    pub(super) fn candidates(&self) -> usize {
        self.candidate_m.len()
    }

    pub(super) fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        let sums = RunningSums::new(&self.candidate_m, &self.candidate_order, map, |_| 1.0);
        let mut n = Array2::zeros((self.truth_m.len(), map.ncols()));
        let mut d = Array2::zeros(n.raw_dim());
        for (sorted, &truth) in self.truth_order.iter().enumerate() {
            let (first, end) = self.truth_window[sorted];
            let share = 1.0 / (end - first).max(1) as f64;
            let (x, here) = (self.truth_m[sorted], self.candidates_before[sorted]);
            sums.distances(
                (first, here, end),
                x,
                share,
                n.row_mut(truth).as_slice_mut(),
            );
            sums.masses((first, end), share, d.row_mut(truth).as_slice_mut());
        }
        (n, d)
    }

    pub(super) fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        let share = |sorted: usize| {
            let (first, end) = self.truth_window[sorted];
            1.0 / (end - first).max(1) as f64
        };
        let u = RunningSums::new(&self.truth_m, &self.truth_order, u, share);
        let v = RunningSums::new(&self.truth_m, &self.truth_order, v, share);
        let mut out = Array2::zeros((self.candidate_m.len(), u.width));
        for (sorted, &candidate) in self.candidate_order.iter().enumerate() {
            let (first, end) = self.candidate_window[sorted];
            let (x, here) = (self.candidate_m[sorted], self.truths_before[sorted]);
            let mut row = out.row_mut(candidate);
            u.distances((first, here, end), x, 1.0, row.as_slice_mut());
            v.masses((first, end), -1.0, row.as_slice_mut());
        }
        out
    }
}

/// Σ_{j<i} P_j and Σ_{j<i} x_j·P_j for every i, outcomes side by side.
struct RunningSums {
    width: usize,
    mass: Vec<f64>,
    moment: Vec<f64>,
}

impl RunningSums {
    fn new(
        x: &[f64],
        order: &[usize],
        rows: ArrayView2<f64>,
        share: impl Fn(usize) -> f64,
    ) -> Self {
        let width = rows.ncols();
        let (mut mass, mut moment) = (
            vec![0.0; (x.len() + 1) * width],
            vec![0.0; (x.len() + 1) * width],
        );
        for (i, (&x, &k)) in x.iter().zip(order).enumerate() {
            let share = share(i);
            for f in 0..width {
                let value = rows[[k, f]] * share;
                mass[(i + 1) * width + f] = mass[i * width + f] + value;
                moment[(i + 1) * width + f] = moment[i * width + f] + x * value;
            }
        }
        Self {
            width,
            mass,
            moment,
        }
    }

    /// Adds `share`·Σ |x_j − x|·P_j over the window, x being at position `here` of the sorted order.
    fn distances(
        &self,
        (first, here, end): (usize, usize, usize),
        x: f64,
        share: f64,
        out: Option<&mut [f64]>,
    ) {
        let (a, b, c) = (first * self.width, here * self.width, end * self.width);
        for (f, out) in out.into_iter().flatten().enumerate() {
            let behind = x * (self.mass[b + f] - self.mass[a + f])
                - (self.moment[b + f] - self.moment[a + f]);
            let ahead = (self.moment[c + f] - self.moment[b + f])
                - x * (self.mass[c + f] - self.mass[b + f]);
            *out += share * (behind + ahead);
        }
    }

    /// Adds `share`·Σ P_j over the window.
    fn masses(&self, (first, end): (usize, usize), share: f64, out: Option<&mut [f64]>) {
        let (a, c) = (first * self.width, end * self.width);
        for (f, out) in out.into_iter().flatten().enumerate() {
            *out += share * (self.mass[c + f] - self.mass[a + f]);
        }
    }
}

fn centre(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| {
            (l.min(v), h.max(v))
        });
    if low <= high { 0.5 * (low + high) } else { 0.0 }
}
