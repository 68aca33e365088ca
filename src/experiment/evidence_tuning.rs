//! How sharply answers count: constants of a likelihood, chosen on the validation part and never on what is judged.
//!
//! Readings of one snapshot are not independent of each other, nor are snapshots of one place. So every method's evidence
//! has a power ([`EvidenceScale`]), the same way for all: the one under which its filter, run over whole sequences of
//! the validation part, gives the truth the least negative log likelihood.

use super::{
    held_out::{by_kernel, by_likelihood},
    trials::Trial,
};
use crate::{
    belief::{Belief, Grid, OdometryMotion, Places, Uncertainty},
    error::Result,
    geometry::Pose,
    localiser::{
        BayesLocaliser, Localiser, PreparedSensorModel, Step,
        sensor_model::{EvidenceScale, Memory, Remembered, Scaled},
    },
    recording::Recording,
    seed::Seed,
};
use ndarray::ArrayView2;
use rayon::prelude::*;
use std::{collections::BTreeSet, f64::consts::SQRT_2, sync::Arc};

/// Powers that evidence is tuned over.
pub const SCALES: [f64; 10] = [
    8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625,
];

/// Those of whole localisers, which take longer: between them lies what particles can do with.
const SCALES_OF_LOCALISERS: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// A belief within this distance of the truth is right, in metres. A single cell would ask for more than a grid can say: where
/// the truth lies on a border between cells, a sharp belief takes the wrong one, and every evidence would seem too sharp.
const NEAR_M: f64 = 0.5;

/// Least likelihood of the truth that counts.
const LEAST: f64 = 1e-9;

/// The same of a whole localiser, whose posterior may be of samples: 5,000 particles know no smaller probability. With less, a
/// single sequence in which chance puts no particle near the truth would outweigh all others.
const LEAST_OF_SAMPLES: f64 = 1.0 / 5000.0;

/// Times that a whole localiser plays every sequence, as what it draws decides much.
const REPEATS: usize = 3;

/// −ln of masses, added up.
#[derive(Default)]
struct Nats {
    sum: f64,
    count: usize,
}

/// Sequences of the validation part, and the filter that runs over them.
pub struct Sequences<'a> {
    /// Holds the validation part.
    pub recording: &'a Recording,
    /// Its places.
    pub places: &'a Places,
    /// Where each sequence starts, and the snapshots taken on its way.
    pub trials: &'a [Trial],
    /// Cells of the filter.
    pub grid: &'a Arc<Grid>,
    /// What it believes of odometry.
    pub motion: &'a OdometryMotion,
}

impl Sequences<'_> {
    /// Mean −ln Bel of the true place, all within half a metre of it, over all sequences, each from a start anywhere, in nats a
    /// snapshot; snapshots off the grid don't count.
    ///
    /// # Errors
    /// Where the sensor model fails.
    pub fn negative_log_likelihood(
        &self,
        sensor: &dyn PreparedSensorModel,
        scale: EvidenceScale,
        seed: Seed,
    ) -> Result<f64> {
        let sensor = Scaled::new(sensor, scale);
        let of_trial = |(number, trial): (usize, &Trial)| -> Result<Nats> {
            let start = Belief::uniform(self.grid.places())?;
            let stream = seed.numbered_stream("evidence tuning", number as u64);
            let mut robot =
                BayesLocaliser::new(self.grid, self.motion, start, Some(&sensor), stream)?;
            let mut nats = Nats::default();
            for &k in &trial.snapshots {
                let belief = robot.observe(k, &self.recording.observation(k))?;
                let mass = belief.mass_within_m(self.places, k, NEAR_M);
                self.count(k, mass.max(LEAST), &mut nats);
            }
            Ok(nats)
        };
        self.mean(of_trial)
    }

    /// The same of a whole localiser, by the probability that it gives to places within half a metre of the true one.
    ///
    /// # Errors
    /// Where it can't play the recording.
    pub fn negative_log_likelihood_of(&self, localiser: &dyn Localiser, seed: Seed) -> Result<f64> {
        let snapshots = self.trials.iter().flat_map(|trial| &trial.snapshots);
        let snapshots: BTreeSet<usize> = snapshots.copied().collect();
        let snapshots: Vec<usize> = snapshots.into_iter().collect();
        let player = localiser.prepare(self.recording, &snapshots)?;
        let of_trial = |(number, trial): (usize, &Trial)| -> Result<Nats> {
            let mut nats = Nats::default();
            for number in (REPEATS * number..).take(REPEATS) {
                let mut stream = seed.numbered_stream("evidence tuning", number as u64);
                let steps = player.play(&trial.snapshots, None, &mut stream)?;
                for (&k, step) in trial.snapshots.iter().zip(&steps) {
                    let mass = mass_near(step, &self.recording.poses()[k]);
                    self.count(k, mass.max(LEAST_OF_SAMPLES), &mut nats);
                }
            }
            Ok(nats)
        };
        self.mean(of_trial)
    }

    /// Takes in the belief's mass near the truth after a snapshot.
    fn count(&self, k: usize, mass: f64, nats: &mut Nats) {
        if self.grid.cell_at(self.places, k).is_some() {
            nats.sum -= mass.ln();
            nats.count += 1;
        }
    }

    /// A snapshot's mean over all sequences.
    fn mean(
        &self,
        of_trial: impl Fn((usize, &Trial)) -> Result<Nats> + Sync + Send,
    ) -> Result<f64> {
        let each = self.trials.par_iter().enumerate().map(of_trial);
        let each = each.collect::<Result<Vec<Nats>>>()?;
        let sum: f64 = each.iter().map(|nats| nats.sum).sum();
        let count: usize = each.iter().map(|nats| nats.count).sum();
        Ok(sum / count.max(1) as f64)
    }

    /// The power of least negative log likelihood: among [`SCALES`], and then half an octave to either side of the best.
    ///
    /// # Errors
    /// Where the sensor model fails.
    pub fn tuned(&self, sensor: &dyn PreparedSensorModel, seed: Seed) -> Result<f64> {
        let memory = Memory::default();
        let sensor = Remembered::new(sensor, &memory);
        best(&SCALES, |scale| {
            self.negative_log_likelihood(&sensor, EvidenceScale::of(scale), seed)
        })
    }

    /// The same of a whole localiser, among fewer powers; `None` where its power is not to be tuned.
    ///
    /// # Errors
    /// Where it can't play the recording.
    pub fn tuned_localiser(&self, localiser: &dyn Localiser, seed: Seed) -> Result<Option<f64>> {
        if localiser.with_evidence_scale(1.0).is_none() {
            return Ok(None);
        }
        let tuned = best(&SCALES_OF_LOCALISERS, |scale| {
            match localiser.with_evidence_scale(scale) {
                Some(scaled) => self.negative_log_likelihood_of(scaled.as_ref(), seed),
                None => Ok(f64::INFINITY),
            }
        });
        tuned.map(Some)
    }
}

/// The power of least negative log likelihood: among these, and then half an octave to either side of the best.
fn best(scales: &[f64], nats: impl Fn(f64) -> Result<f64>) -> Result<f64> {
    let mut best = (1.0, f64::INFINITY);
    let mut try_all = |scales: &[f64]| -> Result<f64> {
        for &scale in scales {
            let nats = nats(scale)?;
            if nats < best.1 {
                best = (scale, nats);
            }
        }
        Ok(best.0)
    };
    let coarse = try_all(scales)?;
    try_all(&[coarse * SQRT_2, coarse / SQRT_2])
}

/// Probability that a localiser gives to places near the truth.
fn mass_near(step: &Step, truth: &Pose) -> f64 {
    let is_near = |[x_m, y_m]: &[f64; 2]| (x_m - truth.x_m).hypot(y_m - truth.y_m) <= NEAR_M;
    let near = step.posterior.iter().filter(|(place, _)| is_near(place));
    near.map(|(_, p)| p).sum()
}

/// The power among [`SCALES`] under which single snapshots of the validation part leave least error, for figures of single
/// snapshots; 1 where nothing can be validated. `log_likelihood(row)` is ln P(s | candidate) for validation place `row`.
pub fn tuned_power(
    uncertainty: Uncertainty,
    validation: &Places,
    candidates: &Places,
    log_likelihood: impl Fn(usize) -> Vec<f64> + Sync,
) -> (f64, f64) {
    let mut best = (1.0, f64::INFINITY);
    if !validation.is_empty() {
        for power in SCALES {
            let score = by_likelihood(uncertainty, validation, candidates, |row| {
                let mut l = log_likelihood(row);
                l.iter_mut().for_each(|l| *l *= power);
                l
            });
            if score.posterior_error_m < best.1 {
                best = (power, score.posterior_error_m);
            }
        }
    }
    best
}

/// Bandwidths h that the kernel is tuned over, in units of the inputs' deviation.
const BANDWIDTHS: [f64; 10] = [0.01, 0.02, 0.04, 0.08, 0.12, 0.16, 0.24, 0.32, 0.64, 1.28];

/// The bandwidth of least error on the validation part, given as its places and their distances `[validation, candidate]`
/// from the candidates' scans; in the middle of the range where nothing can be validated.
pub fn tuned_bandwidth(
    uncertainty: Uncertainty,
    validation: &Places,
    candidates: &Places,
    square: ArrayView2<f32>,
) -> f64 {
    let mut best = (BANDWIDTHS[BANDWIDTHS.len() / 2], f64::INFINITY);
    if !validation.is_empty() {
        for h in BANDWIDTHS {
            let score = by_kernel(uncertainty, validation, candidates, square, h);
            if score.posterior_error_m < best.1 {
                best = (h, score.posterior_error_m);
            }
        }
    }
    best.0
}

#[cfg(test)]
mod tests;
