//! What one snapshot of the unseen part says, under every prior of a [`MethodContext`]: how much of the error it takes away.
//!
//! Candidates are the training places. The power of every system's evidence is that of least error on the validation part, or
//! systems would be told apart by how sure they are of themselves and not by what they know.

use super::{evidence_tuning, held_out, method::FeatureAnswers, methods::MethodContext};
use crate::{
    belief::{Belief, Evidence, GridMap, Places, Uncertainty},
    error::Result,
    learning::{error_reduction::ErrorReduction, objective::MAX_FEATURES, training_set::covered},
    localiser::{PreparedSensorModel, SensorModel, sensor_model::PreparedFeatures},
};
use ndarray::Axis;
use rayon::prelude::*;
use std::sync::Arc;

/// Snapshots of the validation part that are enough to choose a power by.
const MAX_VALIDATED: usize = 300;

impl MethodContext<'_> {
    /// Error reductions of a sensor model that answers for the training places, under every prior.
    ///
    /// # Errors
    /// Where the training part is not at hand, or the sensor model fails.
    pub(super) fn held_out(&self, alone: &dyn SensorModel) -> Result<Vec<ErrorReduction>> {
        let covered = self.parts.covered(&self.mapped.places);
        let on_run = alone.prepare(self.parts.run, &covered)?;
        self.held_out_by(on_run.as_ref(), self.tuned_powers(alone)?)
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
    ) -> Result<Vec<ErrorReduction>> {
        let candidates = &self.mapped.places;
        let rule = match evidence {
            Evidence::Sampled | Evidence::Jeffrey if answers.run.ncols() <= MAX_FEATURES => {
                return self.on_counted(|prior, truths| {
                    let seen = answers.run.select(Axis(0), truths).mapv(f64::from);
                    let truths = self.parts.places.select(truths);
                    let map = (candidates, at_candidates.as_ref());
                    held_out::by_features(prior, (&truths, seen.view()), map)
                });
            }
            Evidence::Likelihood => Evidence::Likelihood,
            _ => Evidence::MeanField,
        };
        let sensor = |answers| PreparedFeatures::new(answers, Arc::clone(at_candidates), rule);
        let powers = match (&answers.source, &self.parts.source) {
            (Some(on_source), Some(_)) => self.powers_by(&sensor(on_source), &self.validated()?)?,
            _ => Vec::new(),
        };
        self.held_out_by(&sensor(&answers.run), powers)
    }

    /// The same of a sensor model that is prepared for the unseen part; where powers are missing, its evidence is taken at its word.
    fn held_out_by(
        &self,
        on_run: &dyn PreparedSensorModel,
        powers: Vec<(f64, f64)>,
    ) -> Result<Vec<ErrorReduction>> {
        let candidates = &self.mapped.places;
        let anywhere = Belief::uniform(&Arc::new(candidates.clone()))?;
        // What fails of one snapshot fails of all: asked once here, then not expected.
        if let Some(&first) = self.parts.covered(candidates).first() {
            self.ask(on_run, first, &anywhere)?;
        }
        let mut powers = powers.into_iter();
        self.on_counted(|prior, truths| {
            let power = powers.next().map_or(1.0, |(power, _)| power);
            let at = self.parts.places.select(truths);
            Ok(held_out::by_likelihood(prior, &at, candidates, |truth| {
                let answer = self.ask(on_run, truths[truth], &anywhere);
                let mut l = answer.unwrap_or_else(|_| vec![0.0; candidates.len()]);
                l.iter_mut().for_each(|l| *l *= power);
                l
            }))
        })
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

    /// Snapshots of the validation part at places that training saw, evenly spaced: as many as settle a constant.
    ///
    /// # Errors
    /// Where the training part is not at hand.
    pub(super) fn validated(&self) -> Result<Vec<usize>> {
        let source = self.source()?;
        let all = Places::of(&source.recording);
        let validation = covered(&all, &source.validation, &self.mapped.places);
        let every = validation.len().div_ceil(MAX_VALIDATED).max(1);
        Ok(validation.into_iter().step_by(every).collect())
    }

    /// Of every prior, the power of a sensor model's evidence that leaves least error of single snapshots of the validation part,
    /// and that error in metres (infinite where nothing can be validated). `alone` answers for the training places.
    ///
    /// # Errors
    /// Where the training part is not at hand, or the sensor model fails.
    pub(super) fn tuned_powers(&self, alone: &dyn SensorModel) -> Result<Vec<(f64, f64)>> {
        let some = self.validated()?;
        let on_source = alone.prepare(&self.source()?.recording, &some)?;
        self.powers_by(on_source.as_ref(), &some)
    }

    /// The same of a sensor model that is prepared for those snapshots of the validation part.
    fn powers_by(
        &self,
        on_source: &dyn PreparedSensorModel,
        some: &[usize],
    ) -> Result<Vec<(f64, f64)>> {
        let candidates = &self.mapped.places;
        let all = Places::of(&self.source()?.recording);
        let anywhere = Belief::uniform(&Arc::new(candidates.clone()))?;
        let known = some
            .par_iter()
            .map(|&k| self.ask(on_source, k, &anywhere))
            .collect::<Result<Vec<_>>>()?;
        let of_prior = |&prior: &Uncertainty| {
            let counted = held_out::counted(prior, &all, some, candidates);
            let rows: Vec<usize> = (0..some.len())
                .filter(|&row| counted.binary_search(&some[row]).is_ok())
                .collect();
            let truths = all.select(&counted);
            evidence_tuning::tuned_power(prior, &truths, candidates, |row| known[rows[row]].clone())
        };
        Ok(self.priors.iter().map(of_prior).collect())
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
        let covered = self.parts.covered(candidates);
        let counted = |prior| held_out::counted(prior, &self.parts.places, &covered, candidates);
        self.priors
            .iter()
            .map(|&prior| score(prior, &counted(prior)))
            .collect()
    }
}

#[cfg(test)]
mod tests;
