//! Global localisation and position tracking on unseen runs: everybody plays the same trials.

use super::{
    convergence::{
        Answers, Row, converged_at_m, error_curve, mean_below_1m_at_m, median_distance_m,
    },
    methods::{BaselineContext, Method, Parts, methods},
    trials::{self, Drawing, Trial},
};
use crate::{
    belief::{Belief, Evidence, Grid, GridConfig, Neighbours, OdometryMotion, Uncertainty},
    error::{Error, Result},
    learning::error_reduction::ErrorReduction,
    localiser::BayesLocaliser,
    model::Model,
    seed::Seed,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeSet, sync::Arc};

/// How trials are played.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LocaliseConfig {
    /// The one seed of the run: starts, random planes, sampled features, bootstrap.
    pub seed: u64,
    /// Number of trials, their starts drawn evenly over the unseen stretches.
    pub trials: usize,
    /// Metres between two snapshots (Thrun 1998, 5.2.4).
    pub spacing_m: f64,
    /// A start leaves at least this much of its stretch.
    pub shortest_m: f64,
    /// A trial ends after this much.
    pub longest_m: f64,
    /// A stretch ends where its way leads for more than this through places that training never saw.
    pub longest_gap_m: f64,
    /// How answers become likelihoods.
    pub evidence: Evidence,
    /// Cells of the belief.
    pub grid: GridConfig,
    /// What the filter believes of odometry; nothing said: what the model learned of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<OdometryMotion>,
    /// Position tracking starts with this standard deviation around the truth …
    pub start_spread_m: f64,
    /// … and this one in heading.
    pub start_spread_rad: f64,
    /// Resamples of the bootstrap.
    pub resamples: usize,
}

impl Default for LocaliseConfig {
    fn default() -> Self {
        Self {
            seed: 1,
            trials: 60,
            spacing_m: 0.5,
            shortest_m: 5.0,
            longest_m: 30.0,
            longest_gap_m: 3.0,
            evidence: Evidence::MeanField,
            grid: GridConfig::default(),
            motion: None,
            start_spread_m: 0.3,
            start_spread_rad: 0.1,
            resamples: 1000,
        }
    }
}

impl LocaliseConfig {
    /// # Errors
    /// Where a value makes no sense; the message names the key.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, expected: &str| {
            Err(Error::usage(format!("localise.{key}: expected {expected}")))
        };
        let positive = |v: f64| v.is_finite() && v > 0.0;
        if self.trials == 0 || self.resamples == 0 {
            return wrong("trials, localise.resamples", "at least 1 of each");
        }
        if self.trials > 100_000 || self.resamples > 1_000_000 {
            return wrong(
                "trials, localise.resamples",
                "at most 100,000 and 1,000,000",
            );
        }
        if !(self.spacing_m >= 0.01 && self.spacing_m <= self.shortest_m) {
            return wrong(
                "spacing_m",
                "at least 0.01 m and at most localise.shortest_m",
            );
        }
        if !positive(self.shortest_m)
            || !positive(self.longest_m)
            || self.shortest_m > self.longest_m
        {
            return wrong(
                "shortest_m, localise.longest_m",
                "positive numbers of metres, the first not above the second",
            );
        }
        if !(self.longest_gap_m.is_finite() && self.longest_gap_m >= 0.0) {
            return wrong("longest_gap_m", "0 or more metres");
        }
        if !positive(self.start_spread_m) || !positive(self.start_spread_rad) {
            return wrong(
                "start_spread_m, localise.start_spread_rad",
                "positive numbers",
            );
        }
        Ok(())
    }
}

/// How one method did in one kind of trial.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TrialSummary {
    /// Share of the trials that converged.
    pub converged_fraction: f64,
    /// Median distance to converge over all trials; null where fewer than half did.
    pub distance_to_converge_m: Option<f64>,
    /// Distance at which the mean curve passes 1 m.
    pub mean_error_below_1m_at_m: Option<f64>,
    /// The mean curve.
    pub error_by_distance: Vec<Row>,
}

/// Everything about one method.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MethodResult {
    /// Key in results.
    #[serde(skip)]
    pub name: &'static str,
    /// In words.
    pub title: String,
    /// Of a kernel, in deviations of the inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bandwidth: Option<f64>,
    /// What the map keeps of a place besides its pose, in bytes; null where there is no map.
    pub bytes_per_place: Option<usize>,
    /// Trials that start anywhere.
    #[serde(flatten)]
    pub global: TrialSummary,
    /// Trials that start at a known place.
    pub tracking: TrialSummary,
    /// One snapshot's error reduction on the unseen part, one a prior.
    pub held_out: Vec<HeldOut>,
}

/// One snapshot's error reduction under a prior.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct HeldOut {
    /// The prior uncertainty.
    pub prior: Uncertainty,
    /// Expected errors before and after.
    #[serde(flatten)]
    pub score: ErrorReduction,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Number of trials.
    pub trials: usize,
    /// Unseen stretches that they run in.
    pub stretches: usize,
    /// Cells of the belief.
    pub cells: usize,
    /// Unseen snapshots, and those of them at places that training saw.
    pub unseen: usize,
    /// See `unseen`.
    pub covered: usize,
    /// Is the unseen part the one that stopped the training?
    pub unseen_is_validation: bool,
    /// The learned filters first.
    pub results: Vec<MethodResult>,
}

/// Plays all trials with all methods. `progress` is told who plays next.
///
/// # Errors
/// Where the unseen part allows no trial, or the run lacks the model's sensors.
pub fn localise(
    model: &Model,
    parts: &Parts,
    config: &LocaliseConfig,
    progress: &mut dyn FnMut(&str),
) -> Result<Record> {
    config.check()?;
    let seed = Seed(config.seed);
    let near = Neighbours::find(
        &model.places(),
        &parts.places,
        &model.header.recipe.map.nearness,
    )?;
    let stretches = trials::stretches(
        parts.run,
        &parts.unseen,
        |k| near.is_mapped(k),
        config.longest_gap_m,
    );
    let drawing = Drawing {
        count: config.trials,
        spacing_m: config.spacing_m,
        shortest_m: config.shortest_m,
        longest_m: config.longest_m,
    };
    let trials = trials::draw(parts.run, &stretches, &drawing, seed)?;
    let grid = Arc::new(Grid::over(&model.places(), &config.grid)?);
    let mut priors = vec![
        Uncertainty::Window {
            half_width_m: 2.0,
            half_turn_rad: Some(0.5),
        },
        Uncertainty::Global,
    ];
    if !priors.contains(&model.header.prior) {
        priors.push(model.header.prior);
    }
    let context = BaselineContext {
        model,
        parts,
        grid: &grid,
        evidence: config.evidence,
        priors: &priors,
        seed,
    };
    let mut results = Vec::new();
    for method in methods(&context)? {
        progress(&method.title);
        let motion = config.motion.as_ref().unwrap_or(&model.header.motion);
        let play = |known_start: bool| {
            summary(
                &method,
                &trials,
                (parts, motion),
                &grid,
                config,
                known_start,
            )
        };
        let (global, tracking) = (play(false)?, play(true)?);
        let scores = priors.iter().zip(method.held_out);
        results.push(MethodResult {
            name: method.name,
            title: method.title,
            bandwidth: method.bandwidth,
            bytes_per_place: method.bytes_per_place,
            global,
            tracking,
            held_out: scores
                .map(|(&prior, score)| HeldOut { prior, score })
                .collect(),
        });
    }
    Ok(Record {
        trials: trials.len(),
        stretches: trials
            .iter()
            .map(|trial| trial.stretch)
            .collect::<BTreeSet<_>>()
            .len(),
        cells: grid.len(),
        unseen: parts.unseen.len(),
        covered: parts.covered(model).len(),
        unseen_is_validation: parts.unseen_is_validation,
        results,
    })
}

fn summary(
    method: &Method,
    trials: &[Trial],
    (parts, motion): (&Parts, &OdometryMotion),
    grid: &Arc<Grid>,
    config: &LocaliseConfig,
    known_start: bool,
) -> Result<TrialSummary> {
    let answers = trials
        .par_iter()
        .enumerate()
        .map(|(t, trial)| {
            let start = if known_start {
                let (at, spread_m, spread_rad) = (
                    trial.snapshots[0],
                    config.start_spread_m,
                    config.start_spread_rad,
                );
                Belief::around(grid.places(), &parts.places, at, spread_m, spread_rad)?
            } else {
                Belief::uniform(grid.places())?
            };
            let stream = Seed(config.seed).numbered_stream("sampled features", t as u64);
            let sensor = method.sensor.as_deref();
            let mut robot = BayesLocaliser::new(grid, motion, start, sensor, stream)?;
            let mut answers = Answers {
                expected_error_m: Vec::new(),
                point_error_m: Vec::new(),
            };
            for &k in &trial.snapshots {
                let belief = robot.observe(k, &parts.run.observation(k))?;
                answers
                    .expected_error_m
                    .push(belief.expected_error_m(&parts.places, k));
                answers
                    .point_error_m
                    .push(belief.point_error_m(&parts.places, k));
            }
            Ok(answers)
        })
        .collect::<Result<Vec<Answers>>>()?;
    let converged: Vec<Option<f64>> = trials
        .iter()
        .zip(&answers)
        .map(|(t, a)| converged_at_m(t, a))
        .collect();
    let seed = Seed(config.seed);
    let error_by_distance = error_curve(trials, &answers, config.spacing_m, config.resamples, seed);
    Ok(TrialSummary {
        converged_fraction: converged.iter().flatten().count() as f64 / trials.len() as f64,
        distance_to_converge_m: median_distance_m(&converged),
        mean_error_below_1m_at_m: mean_below_1m_at_m(&error_by_distance),
        error_by_distance,
    })
}
