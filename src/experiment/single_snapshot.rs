//! What one snapshot of the unseen part says, under every prior of a [`MethodContext`]: how much of the error it takes away.
//!
//! Candidates are the training places. The power of every system's evidence is that of least error on the validation part, or
//! systems would be told apart by how sure they are of themselves and not by what they know.

use super::{
    evidence_tuning, held_out,
    kept_evidence::{Judged, SingleSnapshots, table, together},
    method::FeatureAnswers,
    methods::MethodContext,
    once::kept,
};
use crate::{
    belief::{Belief, Evidence, GridMap, Places, Uncertainty},
    error::{Error, Result},
    learning::{error_reduction::ErrorReduction, objective::MAX_FEATURES, training_set::covered},
    localiser::{
        PreparedSensorModel, SensorModel,
        sensor_model::{DetectorAnswers, PreparedFeatures},
    },
};
use rayon::prelude::*;
use std::sync::Arc;

/// Unseen snapshots that are judged at most: each is held against every training place, so that all of a long log would take
/// time with the square of its length.
const MAX_JUDGED: usize = 4000;

/// Pairs of an unseen snapshot and a training place that are judged at most, or little more: fewer snapshots of a large map.
const MOST_PAIRS: usize = 32 << 20;

/// Snapshots of the validation part that are enough to choose a power by.
const MAX_VALIDATED: usize = 300;

/// Entries of a table of evidence at most, where it is kept for products: 64 MB.
const MOST_KEPT: usize = 16 << 20;

impl MethodContext<'_> {
    /// Error reductions of a sensor model that answers for the training places, under every prior.
    ///
    /// # Errors
    /// Where the training part is not at hand, or the sensor model fails.
    pub(super) fn held_out(&self, alone: &dyn SensorModel) -> Result<Judged> {
        let on_run = alone.prepare(self.parts.run, &self.covered())?;
        let validated = self.validated()?;
        let on_source = alone.prepare(&self.source()?.recording, &validated)?;
        let on_source = (on_source.as_ref(), &validated[..]);
        self.held_out_by(on_run.as_ref(), Some(on_source), MOST_KEPT)
    }

    /// The same of features, with a map of the training places. The exact objective of few features, which Jeffrey's rule and sampled
    /// evidence ask for, has no power.
    ///
    /// # Errors
    /// Where answers and map have different numbers of features.
    pub(super) fn held_out_by_features(
        &self,
        answers: &FeatureAnswers,
        at_candidates: &Arc<GridMap>,
        evidence: Evidence,
    ) -> Result<Judged> {
        let candidates = &self.mapped.places;
        let rule = match evidence {
            Evidence::Sampled | Evidence::Jeffrey if answers.run.features() <= MAX_FEATURES => {
                let held_out = self.on_counted(|prior, truths| {
                    let seen = answers.run.select(truths);
                    let seen = seen.ok_or_else(|| Error::work("features: of other snapshots"))?;
                    let seen = seen.mapv(f64::from);
                    let truths = self.parts.places.select(truths);
                    let map = (candidates, at_candidates.as_ref());
                    held_out::by_features(prior, (&truths, seen.view()), map)
                })?;
                return Ok(Judged {
                    held_out,
                    evidence: None,
                });
            }
            Evidence::Likelihood => Evidence::Likelihood,
            _ => Evidence::MeanField,
        };
        let sensor = |answers: &DetectorAnswers| {
            PreparedFeatures::new(answers.clone(), Arc::clone(at_candidates), rule)
        };
        let validated = self.parts.source.as_ref().map(|_| self.validated());
        let validated = validated.transpose()?;
        let on_source = answers.source.as_ref().map(sensor);
        let on_source = on_source.as_ref().zip(validated.as_ref());
        self.held_out_by(
            &sensor(&answers.run),
            on_source.map(|(sensor, some)| (sensor as &dyn PreparedSensorModel, &some[..])),
            MOST_KEPT,
        )
    }

    /// The same of several sensor models at once, as if they erred independently of each other: each has the power that it is tuned
    /// to alone, one of them perhaps less, and their product one more, whatever leaves least error on the validation part. None where
    /// one of them did not keep its evidence.
    ///
    /// # Errors
    /// Where the training part is not at hand.
    pub(super) fn held_out_of_product(
        &self,
        factors: &[Option<&SingleSnapshots>],
    ) -> Result<Judged> {
        let Some(factors) = factors.iter().copied().collect::<Option<Vec<_>>>() else {
            return Ok(Judged::default());
        };
        let covered = self.covered();
        let can_tune = factors.iter().all(|f| !f.powers.is_empty());
        let mut held_out = Vec::new();
        for (number, &prior) in self.priors.iter().enumerate() {
            let alone = factors.iter().map(|f| f.powers.get(number));
            let alone: Vec<f64> = alone.map(|power| power.copied().unwrap_or(1.0)).collect();
            let powers = match can_tune {
                true => self.powers_together(prior, &factors, alone)?,
                false => alone,
            };
            let log_likelihood = |row| together(&factors, &powers, row, |f| &f.on_run);
            held_out.push(self.reduction(prior, &covered, log_likelihood));
        }
        Ok(Judged {
            held_out,
            evidence: None,
        })
    }

    /// Powers of the factors of a product under one prior, from those that each has alone: which of them counts for less is settled
    /// first, at few powers of the whole, then the power of the whole. All powers of all shares would cost three times as much.
    fn powers_together(
        &self,
        prior: Uncertainty,
        factors: &[&SingleSnapshots],
        alone: Vec<f64>,
    ) -> Result<Vec<f64>> {
        let some = self.validated()?;
        let (truths, rows) = self.counted_of(prior, &some)?;
        let candidates = &self.mapped.places;
        let mut best = (f64::INFINITY, alone.clone());
        for weights in weighed(&alone).into_iter().filter(|_| !truths.is_empty()) {
            for power in TRIED_TOGETHER {
                let powers: Vec<f64> = weights.iter().map(|weight| power * weight).collect();
                let log_likelihood =
                    |truth: usize| together(factors, &powers, rows[truth], |f| &f.on_validation);
                let score = held_out::by_likelihood(prior, &truths, candidates, log_likelihood);
                if score.posterior_error_m < best.0 {
                    best = (score.posterior_error_m, powers);
                }
            }
        }
        let known = |row| together(factors, &best.1, row, |f| &f.on_validation);
        let (power, _) = self.power_of(prior, &some, &known)?;
        Ok(best.1.iter().map(|weight| power * weight).collect())
    }

    /// The same of a sensor model that is prepared for the unseen part, and for some snapshots of the validation part; without those
    /// its evidence is taken at its word. No more than `most_kept` entries of evidence are kept.
    fn held_out_by(
        &self,
        on_run: &dyn PreparedSensorModel,
        on_source: Option<(&dyn PreparedSensorModel, &[usize])>,
        most_kept: usize,
    ) -> Result<Judged> {
        let candidates = &self.mapped.places;
        let covered = self.covered();
        let (powers, on_validation) = match on_source {
            Some((sensor, some)) => {
                let known = self.ask_all(sensor, some)?;
                let powers = self.powers_by(&known, some)?;
                (powers.into_iter().map(|(power, _)| power).collect(), known)
            }
            None => (Vec::new(), Vec::new()),
        };
        let power = |prior: usize| powers.get(prior).copied().unwrap_or(1.0);
        let anywhere = Belief::uniform(&Arc::new(candidates.clone()))?;
        // What fails of one snapshot fails of all: asked once here, then not expected.
        if let Some(&first) = covered.first() {
            self.ask(on_run, first, &anywhere)?;
        }
        if covered.len().saturating_mul(candidates.len()) > most_kept {
            let of_prior = |(number, &prior): (usize, &Uncertainty)| {
                self.reduction(prior, &covered, |row| {
                    let answer = self.ask(on_run, covered[row], &anywhere);
                    let mut l = answer.unwrap_or_else(|_| vec![0.0; candidates.len()]);
                    l.iter_mut().for_each(|l| *l *= power(number));
                    l
                })
            };
            return Ok(Judged {
                held_out: self.priors.iter().enumerate().map(of_prior).collect(),
                evidence: None,
            });
        }
        let on_run = self.ask_all(on_run, &covered)?;
        let of_prior = |(number, &prior): (usize, &Uncertainty)| {
            let scaled = |row: usize| on_run[row].iter().map(|l| l * power(number)).collect();
            self.reduction(prior, &covered, scaled)
        };
        Ok(Judged {
            held_out: self.priors.iter().enumerate().map(of_prior).collect(),
            evidence: Some(Arc::new(SingleSnapshots {
                on_run: table(&on_run, candidates.len())?,
                on_validation: table(&on_validation, candidates.len())?,
                powers,
            })),
        })
    }

    /// Error reduction under one prior; `log_likelihood` gives ln P(s | candidate) of a row of `covered`, already to its power.
    fn reduction(
        &self,
        prior: Uncertainty,
        covered: &[usize],
        log_likelihood: impl Fn(usize) -> Vec<f64> + Sync,
    ) -> ErrorReduction {
        let candidates = &self.mapped.places;
        let counted = held_out::counted(prior, &self.parts.places, covered, candidates);
        let rows = rows(covered, &counted);
        let truths = self.parts.places.select(&counted);
        held_out::by_likelihood(prior, &truths, candidates, |truth| {
            log_likelihood(rows[truth])
        })
    }

    /// All unseen snapshots at places that training saw.
    pub(super) fn all_covered(&self) -> &[usize] {
        let covered = || self.parts.covered(&self.mapped.places);
        self.once.covered.get_or_init(covered)
    }

    /// Unseen snapshots at places that training saw, evenly chosen where there are more than [`MAX_JUDGED`], or [`MOST_PAIRS`] with all
    /// places.
    pub(super) fn covered(&self) -> Vec<usize> {
        let most = MOST_PAIRS
            .div_ceil(self.mapped.places.len())
            .min(MAX_JUDGED);
        evenly(self.all_covered().to_vec(), most)
    }

    /// ln P(s | candidate) of a snapshot, from a sensor model that draws no random numbers.
    fn ask(
        &self,
        prepared: &dyn PreparedSensorModel,
        snapshot: usize,
        anywhere: &Belief,
    ) -> Result<Vec<f64>> {
        let mut unused = self.seed().stream("not drawn from");
        prepared.log_likelihood(snapshot, anywhere, &mut unused)
    }

    /// The same of several snapshots.
    fn ask_all(
        &self,
        prepared: &dyn PreparedSensorModel,
        snapshots: &[usize],
    ) -> Result<Vec<Vec<f64>>> {
        let anywhere = Belief::uniform(&Arc::new(self.mapped.places.clone()))?;
        let asked = snapshots.par_iter();
        asked
            .map(|&snapshot| self.ask(prepared, snapshot, &anywhere))
            .collect()
    }

    /// Snapshots of the validation part at places that training saw, evenly spaced: as many as settle a constant.
    ///
    /// # Errors
    /// Where the training part is not at hand.
    pub(super) fn validated(&self) -> Result<Vec<usize>> {
        let validated = kept(&self.once.validated, || {
            let source = self.source()?;
            let all = Places::of(&source.recording);
            let validation = covered(&all, &source.validation, &self.mapped.places);
            Ok(evenly(validation, MAX_VALIDATED))
        });
        validated.map(<[usize]>::to_vec)
    }

    /// Of every prior, the power of a sensor model's evidence that leaves least error of single snapshots of the validation part,
    /// and that error in metres (infinite where nothing can be validated). `alone` answers for the training places.
    ///
    /// # Errors
    /// Where the training part is not at hand, or the sensor model fails.
    pub(super) fn tuned_powers(&self, alone: &dyn SensorModel) -> Result<Vec<(f64, f64)>> {
        let some = self.validated()?;
        let on_source = alone.prepare(&self.source()?.recording, &some)?;
        self.powers_by(&self.ask_all(on_source.as_ref(), &some)?, &some)
    }

    /// The same from what a sensor model says of those snapshots of the validation part, `[snapshot][candidate]`.
    fn powers_by(&self, known: &[Vec<f64>], some: &[usize]) -> Result<Vec<(f64, f64)>> {
        let of_row = |row: usize| known[row].clone();
        let priors = self.priors.iter();
        priors
            .map(|&prior| self.power_of(prior, some, &of_row))
            .collect()
    }

    /// The same of one prior; `known` gives ln P(s | candidate) of a row of `some`.
    fn power_of(
        &self,
        prior: Uncertainty,
        some: &[usize],
        known: &(dyn Fn(usize) -> Vec<f64> + Sync),
    ) -> Result<(f64, f64)> {
        let (truths, rows) = self.counted_of(prior, some)?;
        let candidates = &self.mapped.places;
        let of_truth = |truth: usize| known(rows[truth]);
        Ok(evidence_tuning::tuned_power(
            prior, &truths, candidates, of_truth,
        ))
    }

    /// Places of those of some snapshots of the validation part that count under a prior, and where they stand in `some`.
    fn counted_of(&self, prior: Uncertainty, some: &[usize]) -> Result<(Places, Vec<usize>)> {
        let all = Places::of(&self.source()?.recording);
        let counted = held_out::counted(prior, &all, some, &self.mapped.places);
        Ok((all.select(&counted), rows(some, &counted)))
    }

    /// `score` of every prior and the unseen snapshots that count under it.
    ///
    /// # Errors
    /// Where `score` fails.
    pub(super) fn on_counted(
        &self,
        mut score: impl FnMut(Uncertainty, &[usize]) -> Result<ErrorReduction>,
    ) -> Result<Vec<ErrorReduction>> {
        let candidates = &self.mapped.places;
        let covered = self.covered();
        let counted = |prior| held_out::counted(prior, &self.parts.places, &covered, candidates);
        self.priors
            .iter()
            .map(|&prior| score(prior, &counted(prior)))
            .collect()
    }
}

/// Every second, third, … of some snapshots: as few as leave no more than `most`.
pub(super) fn evenly(all: Vec<usize>, most: usize) -> Vec<usize> {
    let every = all.len().div_ceil(most).max(1);
    all.into_iter().step_by(every).collect()
}

/// What a factor of a product counts for beside the others, as shares of the power that it has alone.
const SHARES: [f64; 4] = [0.5, 0.25, 0.1, 0.0];

/// Powers of a whole product at which shares are tried: two that are right and independent have 1, two that say the same a half.
const TRIED_TOGETHER: [f64; 2] = [1.0, 0.5];

/// Powers of the factors of a product: those that each has alone, and those with one of them less.
fn weighed(alone: &[f64]) -> Vec<Vec<f64>> {
    let less = |factor: usize, share: f64| {
        let mut weights = alone.to_vec();
        weights[factor] *= share;
        weights
    };
    let factors = (0..alone.len()).flat_map(|f| SHARES.map(|share| less(f, share)));
    std::iter::once(alone.to_vec()).chain(factors).collect()
}

/// Where in `some`, ascending, those that count stand.
fn rows(some: &[usize], counted: &[usize]) -> Vec<usize> {
    let counts = |row: &usize| counted.binary_search(&some[*row]).is_ok();
    (0..some.len()).filter(counts).collect()
}

#[cfg(test)]
mod tests;
