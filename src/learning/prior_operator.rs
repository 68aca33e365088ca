//! Bel and A = e ∘ Bel as operators: the two big matrices of the objective, never stored as such.
//!
//! Row ξ* of Bel is the prior belief of a robot that is truly at ξ*: uniform over the candidates that the prior
//! admits. Row ξ* of A is the same times e(ξ*, ξ). All the objective needs of them are two products and their
//! transposes, and the shape of the prior says how to get them cheaply:
//!
//! | prior | product | cost |
//! |---|---|---|
//! | any, along a route | running sums: a window is a contiguous range, e is a difference of coordinates | (T + C)·F |
//! | window, in the plane | sparse rows | T·window·F |
//! | global, in the plane | blocks of distances, made and multiplied in turn | T·C·F |
//!
//! with T truths, C candidates, F = 2^n outcomes. All sums are f64 and in a fixed order.

use crate::belief::{Places, Uncertainty};
use ndarray::{Array1, Array2, ArrayView2, ArrayViewMut2, Axis, Zip};
use rayon::prelude::*;

/// The prior beliefs of all truths over all candidates.
pub enum PriorOperator {
    /// Along a route.
    Route(RouteWindows),
    /// In the plane, within a window.
    Sparse(SparseRows),
    /// In the plane, anywhere.
    Everywhere(Everywhere),
}

impl PriorOperator {
    /// The prior `uncertainty` of robots truly at `truths`, over `candidates`.
    pub fn new(uncertainty: Uncertainty, truths: &Places, candidates: &Places) -> Self {
        match (truths, candidates, uncertainty) {
            (Places::Route(truths), Places::Route(candidates), _) => {
                let half_width_m = match uncertainty {
                    Uncertainty::Global => f64::INFINITY,
                    Uncertainty::Window { half_width_m, .. } => half_width_m,
                };
                PriorOperator::Route(RouteWindows::new(half_width_m, truths, candidates))
            }
            (_, _, Uncertainty::Global) => {
                PriorOperator::Everywhere(Everywhere::new(truths, candidates))
            }
            _ => PriorOperator::Sparse(SparseRows::new(uncertainty, truths, candidates)),
        }
    }

    /// N = A·M and D = Bel·M, both `[truth, outcome]`, of M `[candidate, outcome]`.
    ///
    /// D[ξ*, f] is P(f) under the prior of a robot at ξ* (Thrun 1998, eq. 37); N/D its expected error after sensing f.
    pub fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        match self {
            PriorOperator::Route(route) => route.apply(map),
            PriorOperator::Sparse(rows) => rows.apply(map),
            PriorOperator::Everywhere(all) => all.apply(map),
        }
    }

    /// Aᵀ·U − Belᵀ·V, `[candidate, outcome]`, of U and V `[truth, outcome]`.
    pub fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        match self {
            PriorOperator::Route(route) => route.apply_transposed(u, v),
            PriorOperator::Sparse(rows) => rows.apply_transposed(u, v),
            PriorOperator::Everywhere(all) => all.apply_transposed(u, v),
        }
    }

    /// Prior error of every truth in metres, Σ_ξ e(ξ*, ξ)·Bel(ξ) (Thrun 1998, eq. 21).
    pub fn prior_error_m(&self) -> Array1<f64> {
        let ones = Array2::ones((self.candidates(), 1));
        self.apply(ones.view()).0.remove_axis(Axis(1))
    }

    /// Candidates that the prior of every truth admits.
    pub fn window_sizes(&self) -> Vec<usize> {
        match self {
            PriorOperator::Route(route) => route.truth_window.iter().map(|w| w.1 - w.0).collect(),
            PriorOperator::Sparse(rows) => rows.forward.iter().map(Vec::len).collect(),
            PriorOperator::Everywhere(all) => vec![all.candidates.len(); all.truths.len()],
        }
    }

    fn candidates(&self) -> usize {
        match self {
            PriorOperator::Route(route) => route.candidate_m.len(),
            PriorOperator::Sparse(rows) => rows.backward.len(),
            PriorOperator::Everywhere(all) => all.candidates.len(),
        }
    }
}

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
    fn new(half_width_m: f64, truths: &[f64], candidates: &[f64]) -> Self {
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

    fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
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

    fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
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

/// Only the admitted candidates of every truth, with belief and error, stored by rows and by columns.
pub struct SparseRows {
    forward: Vec<Vec<Entry>>,
    backward: Vec<Vec<Entry>>,
}

struct Entry {
    index: usize,
    belief: f64,
    error_times_belief: f64,
}

impl SparseRows {
    fn new(uncertainty: Uncertainty, truths: &Places, candidates: &Places) -> Self {
        let forward: Vec<Vec<Entry>> = (0..truths.len())
            .into_par_iter()
            .map(|truth| {
                let admitted: Vec<usize> = (0..candidates.len())
                    .filter(|&c| uncertainty.admits(truths, truth, candidates, c))
                    .collect();
                let belief = 1.0 / admitted.len().max(1) as f64;
                let entry = |index| Entry {
                    index,
                    belief,
                    error_times_belief: belief * truths.distance_m(truth, candidates, index),
                };
                admitted.into_iter().map(entry).collect()
            })
            .collect();
        let mut backward: Vec<Vec<Entry>> = (0..candidates.len()).map(|_| Vec::new()).collect();
        for (index, row) in forward.iter().enumerate() {
            for &Entry {
                index: candidate,
                belief,
                error_times_belief,
            } in row
            {
                backward[candidate].push(Entry {
                    index,
                    belief,
                    error_times_belief,
                });
            }
        }
        Self { forward, backward }
    }

    fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        let mut n = Array2::zeros((self.forward.len(), map.ncols()));
        let mut d = Array2::zeros(n.raw_dim());
        n.axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(d.axis_iter_mut(Axis(0)))
            .zip(&self.forward)
            .for_each(|((mut n, mut d), row)| {
                for entry in row {
                    let candidate = map.row(entry.index);
                    n.scaled_add(entry.error_times_belief, &candidate);
                    d.scaled_add(entry.belief, &candidate);
                }
            });
        (n, d)
    }

    fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        let mut out = Array2::zeros((self.backward.len(), u.ncols()));
        out.axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(&self.backward)
            .for_each(|(mut out, column)| {
                for entry in column {
                    out.scaled_add(entry.error_times_belief, &u.row(entry.index));
                    out.scaled_add(-entry.belief, &v.row(entry.index));
                }
            });
        out
    }
}

/// Every candidate for every truth. Up to some thousands of places the distances are kept; beyond, they are made block
/// by block, multiplied and dropped, so that memory grows no faster than the number of places.
pub struct Everywhere {
    truths: Places,
    candidates: Places,
    kept: Option<Array2<f64>>,
}

/// Truths handled at once.
const BLOCK: usize = 64;

/// Most distances that are kept: 200 MB.
const MOST_KEPT: usize = 25_000_000;

impl Everywhere {
    fn new(truths: &Places, candidates: &Places) -> Self {
        let (truths, candidates) = (truths.clone(), candidates.clone());
        let kept = (truths.len() * candidates.len() <= MOST_KEPT).then(|| {
            let mut all = Array2::zeros((truths.len(), candidates.len()));
            let blocks = all
                .axis_chunks_iter_mut(Axis(0), BLOCK)
                .into_par_iter()
                .enumerate();
            blocks
                .for_each(|(block, out)| fill_distances(&truths, block * BLOCK, &candidates, out));
            all
        });
        Self {
            truths,
            candidates,
            kept,
        }
    }

    fn share(&self) -> f64 {
        1.0 / self.candidates.len().max(1) as f64
    }

    fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        let kept = self.kept.as_ref().map(|all| all.view());
        let n = distances_times(&self.truths, &self.candidates, kept, map, self.share());
        let mean = map.sum_axis(Axis(0)) * self.share();
        let mut d = Array2::zeros(n.raw_dim());
        d.assign(&mean);
        (n, d)
    }

    fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        let kept = self.kept.as_ref().map(|all| all.t());
        let mut out = distances_times(&self.candidates, &self.truths, kept, u, self.share());
        out -= &(v.sum_axis(Axis(0)) * self.share());
        out
    }
}

/// `share`·e(from, to)·rows, `[from, outcome]`.
fn distances_times(
    from: &Places,
    to: &Places,
    kept: Option<ArrayView2<f64>>,
    rows: ArrayView2<f64>,
    share: f64,
) -> Array2<f64> {
    let mut out = Array2::zeros((from.len(), rows.ncols()));
    out.axis_chunks_iter_mut(Axis(0), BLOCK)
        .into_par_iter()
        .enumerate()
        .for_each(|(block, mut out)| {
            let first = block * BLOCK;
            match &kept {
                Some(all) => {
                    let block = all.slice_axis(Axis(0), (first..first + out.nrows()).into());
                    ndarray::linalg::general_mat_mul(share, &block, &rows, 0.0, &mut out);
                }
                None => {
                    let mut block = Array2::zeros((out.nrows(), to.len()));
                    fill_distances(from, first, to, block.view_mut());
                    ndarray::linalg::general_mat_mul(share, &block, &rows, 0.0, &mut out);
                }
            }
        });
    out
}

/// e from places `first`.. to all others, `[from, to]`.
fn fill_distances(from: &Places, first: usize, to: &Places, mut out: ArrayViewMut2<f64>) {
    Zip::indexed(&mut out).for_each(|(i, j), d| *d = from.distance_m(first + i, to, j));
}
