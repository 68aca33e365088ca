//! Priors of many truths over the same candidates, an uncertainty for each truth.

use crate::belief::{Places, Uncertainty};
use ndarray::{Array1, Array2, ArrayView1, Axis};
use rayon::prelude::*;
use std::borrow::Cow;

/// Truths, each with a prior uncertainty of its own, and the candidates they may be mistaken for.
pub struct Priors {
    uncertainty: Vec<Uncertainty>,
    truths: Places,
    candidates: Places,
    /// e of every pair, `[truth, candidate]`, kept where they are few enough, as in a training step.
    kept: Option<Array2<f32>>,
    prior_error_m: Array1<f64>,
    sizes: Vec<usize>,
    /// Where the posterior should be, `[truth, candidate]`, and what its cross entropy counts for beside the error.
    targets: Option<(Array2<f32>, f64)>,
}

/// How far about a truth its posterior should be, in metres and in radians.
const TARGET: [f64; 2] = [0.2, 0.2];

/// Most pairs whose error is kept: 64 MiB.
const MAX_KEPT: usize = 1 << 24;

/// The error of a candidate that the prior does not admit.
pub(super) const NOT_ADMITTED: f32 = f32::INFINITY;

impl Priors {
    /// One uncertainty a truth.
    ///
    /// # Panics
    /// Where there are not as many uncertainties as truths.
    pub fn new(uncertainty: Vec<Uncertainty>, truths: Places, candidates: Places) -> Self {
        assert_eq!(uncertainty.len(), truths.len(), "one uncertainty a truth");
        let (rows, columns) = (truths.len(), candidates.len());
        let mut priors = Self {
            uncertainty,
            truths,
            candidates,
            kept: None,
            prior_error_m: Array1::zeros(rows),
            sizes: vec![0; rows],
            targets: None,
        };
        if rows.saturating_mul(columns) <= MAX_KEPT {
            priors.kept = Some(priors.table());
        }
        let errors_and_sizes: Vec<(f64, usize)> = (0..rows)
            .into_par_iter()
            .map(|t| {
                let errors = priors.errors_m(t);
                let admitted = errors.iter().filter(|&&e| e != NOT_ADMITTED);
                let (sum, size) =
                    admitted.fold((0.0, 0), |(sum, n), &e| (sum + f64::from(e), n + 1));
                (sum / size.max(1) as f64, size)
            })
            .collect();
        priors.prior_error_m = errors_and_sizes.iter().map(|t| t.0).collect();
        priors.sizes = errors_and_sizes.into_iter().map(|t| t.1).collect();
        priors
    }

    /// Lets the cross entropy to a Gaussian about each truth be descended besides the error, as a share of it; 0: not.
    pub fn with_targets(&mut self, share: f64) {
        self.targets = (share > 0.0).then(|| (self.target_table(), share));
    }

    /// Where the posteriors should be, `[truth, candidate]`, and what a nat of their cross entropy counts for in metres,
    /// `[truth]`; none where the error alone is descended.
    pub fn targets(&self) -> Option<(Array2<f32>, Array1<f64>)> {
        let (table, share) = self.targets.as_ref()?;
        Some((table.clone(), &self.prior_error_m * *share))
    }

    /// A Gaussian about every truth over the candidates that its prior admits: rows of sum 1, or of nothing.
    fn target_table(&self) -> Array2<f32> {
        let mut table = Array2::zeros((self.truths.len(), self.candidates.len()));
        table
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each(|(t, mut row)| {
                let log_density = |(candidate, &error_m): (usize, &f32)| {
                    if error_m == NOT_ADMITTED {
                        return f32::NEG_INFINITY;
                    }
                    let turn_rad = self.truths.turn_rad(t, &self.candidates, candidate);
                    let off = [f64::from(error_m) / TARGET[0], turn_rad / TARGET[1]];
                    (-0.5 * (off[0] * off[0] + off[1] * off[1])) as f32
                };
                let errors_m = self.errors_m(t);
                let l: Vec<f32> = errors_m.iter().enumerate().map(log_density).collect();
                let highest = l.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                if highest == f32::NEG_INFINITY {
                    return;
                }
                for (target, l) in row.iter_mut().zip(l) {
                    *target = (l - highest).exp();
                }
                let sum = row.sum();
                row /= sum;
            });
        table
    }

    /// Where the posterior of a truth should be, over all candidates, and what a nat of its cross entropy counts for in metres
    /// of that truth's error.
    pub(super) fn target(&self, truth: usize) -> Option<(ArrayView1<'_, f32>, f64)> {
        let (table, share) = self.targets.as_ref()?;
        let counts_m = share * self.prior_error_m[truth];
        Some((table.row(truth), counts_m))
    }

    /// e(ξ*, ξ) of one truth to every candidate in metres; [`NOT_ADMITTED`] outside its prior.
    pub(super) fn errors_m(&self, truth: usize) -> Cow<'_, [f32]> {
        if let Some(kept) = self
            .kept
            .as_ref()
            .and_then(|kept| kept.row(truth).to_slice())
        {
            return Cow::Borrowed(kept);
        }
        let (uncertainty, truths) = (self.uncertainty[truth], &self.truths);
        let error_m = |candidate| {
            let distance_m = truths.distance_m(truth, &self.candidates, candidate);
            let turn_rad = || truths.turn_rad(truth, &self.candidates, candidate);
            match uncertainty.admits_at(distance_m, turn_rad) {
                true => distance_m as f32,
                false => NOT_ADMITTED,
            }
        };
        Cow::Owned((0..self.candidates.len()).map(error_m).collect())
    }

    /// Pairs of a truth and a candidate.
    pub fn len(&self) -> usize {
        self.truths.len().saturating_mul(self.candidates.len())
    }

    /// No truth, or no candidate?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// e(ξ*, ξ) of all pairs in metres, `[truth, candidate]`; ∞ where the prior does not admit the candidate.
    pub fn table(&self) -> Array2<f32> {
        if let Some(kept) = &self.kept {
            return kept.clone();
        }
        let mut table = Array2::zeros((self.truths.len(), self.candidates.len()));
        table
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .enumerate()
            .for_each(|(t, mut row)| row.assign(&ArrayView1::from(&self.errors_m(t))));
        table
    }

    /// Expected error of every truth before sensing, in metres; 0 where nothing is admitted.
    pub fn prior_error_m(&self) -> ArrayView1<'_, f64> {
        self.prior_error_m.view()
    }

    /// Candidates that every truth's prior admits.
    pub fn window_sizes(&self) -> &[usize] {
        &self.sizes
    }

    /// Weights of the truths that sum to 1: those that have something to be mistaken for, in equal shares.
    pub fn equal_weights(&self) -> Array1<f64> {
        self.shares(|_| 1.0)
    }

    /// Weights that make the objective the mean of each truth's posterior error *as a share of its prior error*, times the
    /// mean prior error: so that a narrow window counts as much as a wide one.
    pub fn relative_weights(&self) -> Array1<f64> {
        self.shares(|t| 1.0 / self.prior_error_m[t])
    }

    fn shares(&self, share: impl Fn(usize) -> f64) -> Array1<f64> {
        let counts = |t: usize| self.sizes[t] > 1 && self.prior_error_m[t] > 0.0;
        let mut shares: Array1<f64> = (0..self.truths.len())
            .map(|t| if counts(t) { share(t) } else { 0.0 })
            .collect();
        let sum = shares.sum();
        if sum > 0.0 {
            shares /= sum;
        }
        shares
    }
}
