//! Kernel regression: weighted sums of the readings that were taken around a place.

use super::{reading_model::ReadingModel, readings::LabelledReadings};
use crate::{
    belief::Places,
    geometry::wrapped,
    simd::{self, Kernel},
};
use rstar::{RTree, primitives::GeomWithData};

/// The kernel reaches this many bandwidths: weights below e^−4.5 are 0.
const REACH: f64 = 3.0;

/// Less weight than this of snapshots that have a reading is none.
pub(super) const LEAST_WEIGHT: f32 = 1e-6;

/// A training snapshot at its place.
type Entry = GeomWithData<[f64; 2], u32>;

/// A training snapshot and its weight.
pub(super) type Weighted = (u32, f32);

/// The training snapshots, to be found by place.
#[derive(Debug, Clone)]
pub(super) struct Visits {
    tree: RTree<Entry>,
    places: Places,
    /// `[snapshot, column]`: the standardised readings, 0 where missing; then for each value that is ever missing whether
    /// it is there, 1 or 0; then 1.
    rows: Vec<f32>,
    columns: usize,
    /// For each value, the column that says whether it is there: the last one for values that are never missing.
    is_there: Vec<usize>,
    bandwidth_m: f64,
    /// `None`: heading plays no part.
    bandwidth_rad: Option<f64>,
}

impl Visits {
    /// The snapshots of `readings`, with mean, deviation and presence of every value, and the bandwidths h and ρ.
    pub(super) fn new(
        readings: &LabelledReadings,
        models: &[ReadingModel],
        (bandwidth_m, bandwidth_rad): (f64, Option<f64>),
    ) -> Self {
        let values = models.len();
        let ever_missing = models.iter().filter(|model| model.is_ever_missing).count();
        let columns = values + ever_missing + 1;
        let mut next = values..;
        let is_there: Vec<usize> = models
            .iter()
            .map(|model| match model.is_ever_missing {
                true => next.next().unwrap_or(columns - 1),
                false => columns - 1,
            })
            .collect();
        let mut rows = vec![0.0; readings.len() * columns];
        for (row, raw) in rows.chunks_mut(columns).zip(readings.values.rows()) {
            row[columns - 1] = 1.0;
            for (value, model) in models.iter().enumerate() {
                if raw[value].is_finite() {
                    row[value] = model.standardised(raw[value]);
                    row[is_there[value]] = 1.0;
                }
            }
        }
        let entry = |k: usize| {
            let pose = readings.places.pose(k);
            Entry::new([pose.x_m, pose.y_m], k as u32)
        };
        Self {
            tree: RTree::bulk_load((0..readings.len()).map(entry).collect()),
            places: readings.places.clone(),
            rows,
            columns,
            is_there,
            bandwidth_m,
            bandwidth_rad: bandwidth_rad.filter(|_| matches!(readings.places, Places::Plane(_))),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    pub(super) fn places(&self) -> &Places {
        &self.places
    }

    /// Does heading play a part?
    pub(super) fn has_headings(&self) -> bool {
        self.bandwidth_rad.is_some()
    }

    /// Numbers that a place of the field is given by.
    pub(super) fn numbers_of_place(&self) -> usize {
        match self.places {
            Places::Route(_) => 1,
            Places::Plane(_) => 2 + usize::from(self.has_headings()),
        }
    }

    /// Columns of a sum.
    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    /// The training snapshots within reach of a point, whatever their heading, in their order.
    pub(super) fn near(&self, x_m: f64, y_m: f64, found: &mut Vec<Weighted>) {
        found.clear();
        let reach_m = REACH * self.bandwidth_m;
        let within = self
            .tree
            .locate_within_distance([x_m, y_m], reach_m * reach_m);
        found.extend(within.map(|entry| {
            let [x, y] = entry.geom();
            let square = (x - x_m).powi(2) + (y - y_m).powi(2);
            let weight = (-0.5 * square / self.bandwidth_m.powi(2)).exp();
            (entry.data, weight as f32)
        }));
        // The tree's order is its own affair.
        found.sort_unstable_by_key(|near| near.0);
    }

    /// The factor of every training snapshot for a heading. Empty where heading plays no part.
    pub(super) fn factors(&self, heading_rad: f64) -> Vec<f32> {
        match (self.bandwidth_rad, &self.places) {
            (Some(bandwidth_rad), Places::Plane(poses)) => {
                let factor = |heading: f64| turn_weight(heading - heading_rad, bandwidth_rad);
                poses.iter().map(|pose| factor(pose.heading_rad)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Leaves of those within reach of a point those within reach in heading as well, with their weights. `factors` as
    /// [`Visits::factors`] gives them.
    pub(super) fn turned(&self, near: &[Weighted], factors: &[f32], found: &mut Vec<Weighted>) {
        let least = (-0.5 * REACH * REACH).exp() as f32;
        found.clear();
        if factors.is_empty() {
            found.extend_from_slice(near);
            return;
        }
        for &(k, weight) in near {
            let weight = weight * factors[k as usize];
            if weight >= least {
                found.push((k, weight));
            }
        }
    }

    /// The same for one heading alone, where no factors are at hand.
    pub(super) fn turned_to(&self, near: &[Weighted], heading_rad: f64, found: &mut Vec<Weighted>) {
        let least = (-0.5 * REACH * REACH).exp() as f32;
        found.clear();
        for &(k, weight) in near {
            let factor = match (self.bandwidth_rad, &self.places) {
                (Some(bandwidth_rad), Places::Plane(poses)) => {
                    turn_weight(poses[k as usize].heading_rad - heading_rad, bandwidth_rad)
                }
                _ => 1.0,
            };
            let weight = weight * factor;
            if weight >= least {
                found.push((k, weight));
            }
        }
    }

    /// Σ_k w_k row_k of some weighted snapshots, `[column]`.
    pub(super) fn sum(&self, weighted: &[Weighted], sums: &mut [f32]) {
        sums.fill(0.0);
        simd::run(WeightedSum {
            rows: &self.rows,
            weighted,
            sums,
        });
    }

    /// The mean of a value under the weights of a sum; `None` where no snapshot within reach has it.
    pub(super) fn mean(&self, sums: &[f32], value: usize) -> Option<f32> {
        let weight = sums[self.is_there[value]];
        (weight > LEAST_WEIGHT).then(|| sums[value] / weight)
    }

    /// Weight of the snapshots that have a value, and of all.
    pub(super) fn weights(&self, sums: &[f32], value: usize) -> (f32, f32) {
        (sums[self.is_there[value]], sums[self.columns - 1])
    }

    /// Standardised readings of training snapshot `k` less what the others say of its place, NaN where there is no reading
    /// or nothing is known; `is_left_out` says of whom nothing is heard.
    pub(super) fn residuals(&self, k: usize, is_left_out: impl Fn(usize) -> bool) -> Vec<f32> {
        let pose = self.places.pose(k);
        let (mut near, mut turned) = (Vec::new(), Vec::new());
        self.near(pose.x_m, pose.y_m, &mut near);
        near.retain(|&(other, _)| !is_left_out(other as usize));
        self.turned_to(&near, pose.heading_rad, &mut turned);
        let mut sums = vec![0.0; self.columns];
        self.sum(&turned, &mut sums);
        let row = &self.rows[k * self.columns..(k + 1) * self.columns];
        let residual = |value: usize| match self.mean(&sums, value) {
            Some(mean) if row[self.is_there[value]] > 0.0 => row[value] - mean,
            _ => f32::NAN,
        };
        (0..self.is_there.len()).map(residual).collect()
    }
}

/// exp(−turn²/2ρ²)
fn turn_weight(turn_rad: f64, bandwidth_rad: f64) -> f32 {
    (-0.5 * (wrapped(turn_rad) / bandwidth_rad).powi(2)).exp() as f32
}

/// Adds weighted rows up, in their order.
struct WeightedSum<'a> {
    rows: &'a [f32],
    weighted: &'a [Weighted],
    sums: &'a mut [f32],
}

impl Kernel for WeightedSum<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let columns = self.sums.len();
        for &(k, weight) in self.weighted {
            let row = &self.rows[k as usize * columns..(k as usize + 1) * columns];
            for (sum, value) in self.sums.iter_mut().zip(row) {
                *sum += weight * value;
            }
        }
    }
}
