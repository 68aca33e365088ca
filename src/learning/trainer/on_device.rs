//! The objective on the device that the networks are on: dense, as products of matrices, which is what a GPU is for.
//!
//! The formulas are those of [the exact objective](crate::learning::objective) and of
//! [the mean-field one](crate::learning::mean_field), over a table of all pairs of truth and candidate. Where there are
//! too many pairs for a table, the CPU takes over: it knows the structure of the priors, and its cost is linear in the
//! number of places.

use super::tensors::tensor;
use crate::{
    detector::net::values,
    error::Result,
    learning::{error_reduction::Errors, problem::Problem},
};
use burn::tensor::{Bool, Device, IndexingUpdateOp, Int, Tensor, TensorData};
use ndarray::Axis;

/// Most pairs that are put on the device: all of 5,000 places, 100 MB.
const MAX_PAIRS: usize = 25_000_000;

/// Probabilities of a map are kept this far off 0 and 1 in a log-likelihood, as on the CPU.
const SMALLEST_PROBABILITY: f32 = 1e-6;

/// P(f) under a prior counts as at least this, as on the CPU.
const RAREST_OUTCOME: f32 = 1e-12;

/// Far below any log-likelihood.
const NEVER: f32 = -1e30;

/// A problem whose pairs lie on the device.
pub struct OnDevice {
    exact: bool,
    /// e(ξ*, ξ), 0 where it is not admitted: `[truth, candidate]`.
    error_m: Tensor<2>,
    excluded: Tensor<2, Bool>,
    /// 1 where admitted.
    admitted: Tensor<2>,
    /// Candidates that a truth's prior admits, `[truth, 1]`.
    places: Tensor<2>,
    /// `[truth, 1]`
    weight: Tensor<2>,
    prior_error_m: f64,
    /// Where posteriors should be, and what a nat of cross entropy counts for: `[truth, candidate]`, `[truth, 1]`.
    targets: Option<(Tensor<2>, Tensor<2>)>,
    map: Option<Map>,
}

/// The map made of the candidates' own outputs.
struct Map {
    /// Snapshots that a place's map is made of, one row of neighbours after the other.
    near: Tensor<1, Int>,
    share: f32,
    floor: f32,
}

/// The objective and its gradient, on the device.
pub struct OnDeviceAnswer {
    pub errors: Errors,
    /// ∂E/∂g `[truth, feature]`.
    pub truth_gradient: Tensor<2>,
    /// ∂E/∂g `[candidate, feature]`.
    pub candidate_gradient: Tensor<2>,
}

impl OnDevice {
    /// Puts a problem on the device, where it has few enough pairs.
    pub fn where_it_fits(problem: &Problem, with_map: bool, device: &Device) -> Option<Self> {
        let pairs = problem.pairs(MAX_PAIRS)?;
        let admitted = pairs.errors_m.mapv(|e| f32::from(u8::from(e.is_finite())));
        let error_m = pairs.errors_m.mapv(|e| if e.is_finite() { e } else { 0.0 });
        let places = admitted.sum_axis(Axis(1)).mapv(|n| n.max(1.0));
        let targets = pairs.targets.map(|(table, counts_m)| {
            let counts_m = (&counts_m * &pairs.weight).mapv(|c| c as f32);
            let counts_m = counts_m.insert_axis(Axis(1));
            (
                tensor(table.view(), device),
                tensor(counts_m.view(), device),
            )
        });
        let weight = pairs.weight.mapv(|w| w as f32).insert_axis(Axis(1));
        let admitted = tensor(admitted.view(), device);
        let map = with_map.then(|| {
            let (share, floor) = problem.smoothing().share_and_floor();
            let near: Vec<i32> = problem
                .smoothing()
                .near()
                .iter()
                .map(|&k| k as i32)
                .collect();
            let shape = [near.len()];
            Map {
                near: Tensor::from_data(TensorData::new(near, shape), device),
                share,
                floor,
            }
        });
        Some(Self {
            exact: pairs.exact,
            error_m: tensor(error_m.view(), device),
            excluded: admitted.clone().equal_elem(0.0),
            admitted,
            places: tensor(places.insert_axis(Axis(1)).view(), device),
            weight: tensor(weight.view(), device),
            prior_error_m: pairs.prior_error_m,
            targets,
            map,
        })
    }

    /// The objective where truths and candidates answer so, `[snapshot, feature]` each. Its error is no number where any
    /// part of the gradient is none.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn evaluate(&self, truth: Tensor<2>, candidates: Tensor<2>) -> Result<OnDeviceAnswer> {
        let map = match &self.map {
            Some(map) => map.apply(candidates),
            None => candidates,
        };
        let (error_m, truth_gradient, map_gradient) = match self.exact {
            true => self.exact(truth, map),
            false => self.mean_field(truth, map),
        };
        let candidate_gradient = match &self.map {
            Some(map) => map.back(map_gradient),
            None => map_gradient,
        };
        let posterior = (error_m * self.weight.clone()).sum();
        let zero = truth_gradient.clone().sum() * 0.0 + candidate_gradient.clone().sum() * 0.0;
        let posterior_error_m = values(posterior + zero)?.first().copied();
        Ok(OnDeviceAnswer {
            errors: Errors {
                prior_error_m: self.prior_error_m,
                posterior_error_m: f64::from(posterior_error_m.unwrap_or(f32::NAN)),
            },
            truth_gradient,
            candidate_gradient,
        })
    }

    /// Expected errors `[truth, 1]`, ∂E/∂g of the truths and ∂E/∂m: the mean field's softmax over the candidates.
    fn mean_field(&self, truth: Tensor<2>, map: Tensor<2>) -> (Tensor<2>, Tensor<2>, Tensor<2>) {
        let m = map.clamp(SMALLEST_PROBABILITY, 1.0 - SMALLEST_PROBABILITY);
        let off = m.clone().neg().log1p();
        let log_odds = m.clone().log() - off.clone(); // [candidate, feature]
        let likelihood =
            truth.clone().matmul(log_odds.clone().transpose()) + off.sum_dim(1).transpose(); // [truth, candidate]
        let likelihood = likelihood.mask_fill(self.excluded.clone(), NEVER);
        let highest = likelihood.clone().max_dim(1);
        let q = (likelihood - highest).exp() * self.admitted.clone();
        let q = q.clone() / q.sum_dim(1).clamp_min(f32::MIN_POSITIVE);
        let expected_m = (q.clone() * self.error_m.clone()).sum_dim(1); // [truth, 1]
        let off_m = self.error_m.clone() - expected_m.clone();
        let mut slope = q.clone() * off_m * self.weight.clone();
        if let Some((targets, counts_m)) = &self.targets {
            slope = slope + (q - targets.clone()) * counts_m.clone();
        }
        let on = slope.clone().transpose().matmul(truth); // T, [candidate, feature]
        let all = slope.clone().sum_dim(0).transpose(); // r, [candidate, 1]
        let map_gradient = on.clone() / m.clone() - (all - on) / (m.neg() + 1.0);
        (expected_m, slope.matmul(log_odds), map_gradient)
    }

    /// The same of the exact objective: N = A·M, D = Bel·M over all 2^n outcomes.
    fn exact(&self, truth: Tensor<2>, map: Tensor<2>) -> (Tensor<2>, Tensor<2>, Tensor<2>) {
        let weighted = self.error_m.clone(); // 0 where not admitted
        let (p, m) = (outcomes(&truth), outcomes(&map)); // [snapshot, outcome]
        let least = self.places.clone() * RAREST_OUTCOME;
        let seen = self.admitted.clone().matmul(m.clone()).max_pair(least);
        let expected_m = weighted.clone().matmul(m) / seen.clone(); // ē, [truth, outcome]
        let posterior_m = (p.clone() * expected_m.clone()).sum_dim(1);
        let u = p * self.weight.clone() / seen;
        let behind_map = weighted.transpose().matmul(u.clone())
            - self
                .admitted
                .clone()
                .transpose()
                .matmul(u * expected_m.clone());
        let truth_gradient = behind_outcomes(&truth, expected_m * self.weight.clone());
        (
            posterior_m,
            truth_gradient,
            behind_outcomes(&map, behind_map),
        )
    }
}

impl Map {
    fn apply(&self, activation: Tensor<2>) -> Tensor<2> {
        let [places, features] = activation.dims();
        let near = activation.select(0, self.near.clone());
        let near = near.reshape([places as i32, -1, features as i32]); // [place, neighbour, feature]
        near.sum_dim(1).reshape([places, features]) * self.share + self.floor
    }

    /// The transpose: every place's gradient goes to the snapshots that its map is made of.
    fn back(&self, gradient: Tensor<2>) -> Tensor<2> {
        let [places, features] = gradient.dims();
        let neighbours = self.near.dims()[0] / places;
        let spread = gradient.clone().mul_scalar(self.share);
        let spread = spread
            .reshape([places, 1, features])
            .repeat_dim(1, neighbours)
            .reshape([places * neighbours, features]);
        gradient
            .zeros_like()
            .select_assign(0, self.near.clone(), spread, IndexingUpdateOp::Add)
    }
}

/// P of all outcomes of the first `features` columns, `[snapshot, outcome]`; the first feature is the highest bit.
fn outcomes(g: &Tensor<2>) -> Tensor<2> {
    let [snapshots, features] = g.dims();
    (0..features).fold(g.ones_like().narrow(1, 0, 1), |p, feature| {
        let on = g.clone().narrow(1, feature, 1);
        let p = p.reshape([snapshots as i32, -1, 1]);
        let both = Tensor::cat(vec![on.clone().neg() + 1.0, on], 1).reshape([snapshots, 1, 2]);
        (p * both).reshape([snapshots as i32, -1])
    })
}

/// From ∂E/∂P to ∂E/∂g: Σ over the outcomes of the *other* features, never dividing by g.
fn behind_outcomes(g: &Tensor<2>, slope: Tensor<2>) -> Tensor<2> {
    let [snapshots, features] = g.dims();
    let outcomes_of = |columns: std::ops::Range<usize>| match columns.is_empty() {
        true => g.ones_like().narrow(1, 0, 1),
        false => outcomes(&g.clone().narrow(1, columns.start, columns.len())),
    };
    let columns = (0..features).map(|feature| {
        let (before, after) = (outcomes_of(0..feature), outcomes_of(feature + 1..features));
        let (rows, left, right) = (snapshots, 1 << feature, 1 << (features - 1 - feature));
        let sides = slope.clone().reshape([rows, left, 2, right]);
        let difference = sides.clone().narrow(2, 1, 1) - sides.narrow(2, 0, 1);
        let difference = difference.reshape([rows, left, right]);
        let others = before.reshape([rows, left, 1]) * after.reshape([rows, 1, right]);
        (difference * others)
            .reshape([rows, left * right])
            .sum_dim(1)
    });
    Tensor::cat(columns.collect(), 1)
}

#[cfg(test)]
mod tests;
