//! What came of localisation trials: figures of every method, as tables and JSON show them.

use super::{
    belief_traces::BeliefTraces,
    confidence::Confidence,
    convergence::{REPORTED_AT_M, Row},
    correction::Correction,
    end_success::SuccessAtEnd,
    kidnapping::Kidnapped,
    more_particles::MoreParticles,
    paired_trials::{PairedTest, TrialFigures, paired_tests},
    protocol_record::ProtocolRecord,
    region_coverage::Coverage,
    repeats::Repeats,
    risk_coverage::RiskCoverage,
    step_time::StepTime,
};
use crate::{
    belief::Uncertainty,
    learning::error_reduction::ErrorReduction,
    recording::{degraded::Degradation, injected_noise::InjectedNoise},
    score::FEW,
    seed::Seed,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How one method did in one kind of trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TrialSummary {
    /// Runs, or stretches of a single run, that the trials are in: what intervals and tests take for independent.
    #[serde(default)]
    pub units: usize,
    /// Are there fewer than ten trials, or is there one run or stretch alone? Then other trials might give other figures
    /// altogether.
    #[serde(default)]
    pub is_uncertain: bool,
    /// Share of the trials that converged.
    pub converged_fraction: f64,
    /// Its 95 % interval, by bootstrap over runs or stretches; null where there is only one.
    pub converged_fraction_ci95: Option<[f64; 2]>,
    /// Median distance to converge over all trials; null where fewer than half did.
    pub distance_to_converge_m: Option<f64>,
    /// Distance at which the mean curve passes 1 m.
    pub mean_error_below_1m_at_m: Option<f64>,
    /// Trials that go so far, over which that mean is.
    pub mean_error_below_1m_trials: Option<usize>,
    /// Are these fewer than ten, or all in one run or stretch? Then other trials might give another distance altogether.
    pub mean_error_below_1m_is_uncertain: bool,
    /// The mean curve.
    pub error_by_distance: Vec<Row>,
}

/// Everything about one method.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MethodResult {
    /// Key in results.
    pub name: String,
    /// In words.
    pub title: String,
    /// Of a kernel, in deviations of the inputs.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub bandwidth: Option<f64>,
    /// Power of its evidence, tuned on sequences of the validation part; null where it is taken at its word.
    pub evidence_scale: Option<f64>,
    /// What the map keeps of a place besides its pose, in bytes; null where there is no map.
    pub bytes_per_place: Option<usize>,
    /// What has to be on the robot, in bytes: places with their poses, networks, map; null where it is nothing.
    pub robot_bytes: Option<usize>,
    /// Share of unseen snapshots after each of which, with no idea before, the likeliest place of the whole grid is within 1 m
    /// of the truth; null where the method is no sensor model.
    pub recall_1m: Option<f64>,
    /// Its 95 % interval, by bootstrap over runs or pieces of the way.
    pub recall_1m_ci95: Option<[f64; 2]>,
    /// The same within 0.5 m.
    pub recall_05m: Option<f64>,
    /// Its interval.
    pub recall_05m_ci95: Option<[f64; 2]>,
    /// Snapshots that these are shares of.
    #[serde(default)]
    pub recall_snapshots: usize,
    /// Mean expected error after 10 m from a start anywhere, in metres; null where no trial goes so far.
    pub error_at_10m_m: Option<f64>,
    /// Its 95 % interval.
    pub error_at_10m_m_ci95: Option<[f64; 2]>,
    /// Mean point error after 10 m from a start anywhere.
    #[serde(default)]
    pub point_error_at_10m_m: Option<f64>,
    /// Its 95 % interval.
    #[serde(default)]
    pub point_error_at_10m_m_ci95: Option<[f64; 2]>,
    /// Mean expected error after 10 m from a known start.
    pub tracked_error_m: Option<f64>,
    /// Its 95 % interval.
    pub tracked_error_m_ci95: Option<[f64; 2]>,
    /// Mean point error after 10 m from a known start.
    #[serde(default)]
    pub tracked_point_error_m: Option<f64>,
    /// Its 95 % interval.
    #[serde(default)]
    pub tracked_point_error_m_ci95: Option<[f64; 2]>,
    /// Share of the trials from a start anywhere that end within some distances of the truth.
    #[serde(default)]
    pub success_at_end: Vec<SuccessAtEnd>,
    /// Share of them that end with a heading within 5° of the true one; null along a route and for whole localisers whose
    /// answers have no heading.
    #[serde(default)]
    pub heading_within_5deg: Option<f64>,
    /// Its 95 % interval.
    #[serde(default)]
    pub heading_within_5deg_ci95: Option<[f64; 2]>,
    /// How often the truth lies in regions of the belief, over all steps of these trials; empty for whole localisers without
    /// a posterior.
    #[serde(default)]
    pub coverage: Vec<Coverage>,
    /// What is left of their errors where the least sure are rejected; empty for whole localisers that say nothing of how
    /// sure they are.
    #[serde(default)]
    pub risk_coverage: Vec<RiskCoverage>,
    /// Mean of the mean point errors of the surest 1, 2, 3, … of these trials up to all of them, in metres: the area under that
    /// curve. Where confidence says nothing of the error, it is the first row's error; null where there are no rows.
    #[serde(default)]
    pub risk_coverage_area_m: Option<f64>,
    /// Its 95 % interval.
    #[serde(default)]
    pub risk_coverage_area_m_ci95: Option<[f64; 2]>,
    /// Whether it knows when it is lost; null for whole localisers that say nothing of how sure they are.
    #[serde(default)]
    pub confidence: Option<Confidence>,
    /// What its corrections are worth apart from its predictions, from a known start; null where its answers have no headings.
    #[serde(default)]
    pub correction: Option<Correction>,
    /// What came of asking it again with the same seed and with others; null where nobody did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub repeats: Option<Repeats>,
    /// What came of carrying it away; null where nobody did, or it is no filter with a sensor.
    #[serde(default)]
    pub kidnapped: Option<Kidnapped>,
    /// Trials that start anywhere.
    #[serde(flatten)]
    pub global: TrialSummary,
    /// Trials that start at a known place.
    pub tracking: TrialSummary,
    /// One snapshot's error reduction on the unseen part, one a prior.
    pub held_out: Vec<HeldOut>,
    /// What paired tests compare, trial by trial.
    #[serde(default)]
    pub by_trial: TrialFigures,
}

impl MethodResult {
    /// Are the shares of single snapshots over fewer than ten of them, or over one run or piece of the way?
    pub fn recall_is_uncertain(&self) -> bool {
        self.recall_snapshots < FEW || self.recall_1m_ci95.is_none()
    }
}

impl TrialSummary {
    /// The mean errors after [`REPORTED_AT_M`]; none where no trial goes so far.
    pub fn reported(&self) -> Option<&Row> {
        let mut rows = self.error_by_distance.iter();
        rows.find(|row| row.distance_m >= REPORTED_AT_M - 1e-9)
    }
}

/// One snapshot's error reduction under a prior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HeldOut {
    /// The prior uncertainty.
    pub prior: Uncertainty,
    /// Expected errors before and after.
    #[serde(flatten)]
    pub score: ErrorReduction,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Record {
    /// Number of trials.
    pub trials: usize,
    /// Unseen stretches that they run in.
    pub stretches: usize,
    /// What the figures were measured on.
    #[serde(default)]
    pub protocol: ProtocolRecord,
    /// Cells of the belief.
    pub cells: usize,
    /// Unseen snapshots, and those of them at places that training saw.
    pub unseen: usize,
    /// See `unseen`.
    pub covered: usize,
    /// As many of these, evenly chosen, as are judged one by one: each is held against every training place, so of a long log not
    /// all are. 0 in records of before.
    #[serde(default)]
    pub judged: usize,
    /// Is the unseen part the one that stopped the training?
    pub unseen_is_validation: bool,
    /// Share of the range beams of every unseen snapshot that people were put in the way of.
    #[serde(default)]
    pub people: f64,
    /// What the recording's range sensors were degraded by; none: they are as recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degraded: Option<Degradation>,
    /// Noise that was put on odometry and ranges of the unseen snapshots; none: they are as recorded.
    #[serde(default)]
    pub noise: Option<InjectedNoise>,
    /// Priors of the single-snapshot figures.
    pub priors: Vec<Uncertainty>,
    /// In the order that the methods played.
    pub results: Vec<MethodResult>,
    /// Every other method against the first.
    #[serde(default)]
    pub paired_tests: Vec<PairedTest>,
    /// Run or stretch of each trial, by any number: what trials have in common.
    #[serde(default)]
    pub trial_units: Vec<usize>,
    /// Whoever played with more particles, too: whether that changes its figures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub more_particles: Vec<MoreParticles>,
    /// What the methods believed along a few trials, where that was to be kept. In a file of its own, as it is long.
    #[serde(skip)]
    pub beliefs: Option<BeliefTraces>,
    /// How long the methods took.
    #[serde(skip)]
    pub timing: Timing,
    /// Methods that could not be made.
    pub left_out: Vec<LeftOut>,
}

impl Record {
    /// Tests every other method against the first, by what their results hold trial by trial; no test where one holds none, as in
    /// records of earlier versions.
    pub(super) fn compare_methods(&mut self, resamples: usize, seed: Seed) {
        let trials = self.trial_units.len();
        let whole = |result: &MethodResult| result.by_trial.found.len() == trials;
        let methods: Vec<(&str, &TrialFigures)> = self
            .results
            .iter()
            .map(|result| (&*result.name, &result.by_trial))
            .collect();
        self.paired_tests = match self.results.iter().all(whole) {
            true => paired_tests(&methods, &self.trial_units, resamples, seed),
            false => Vec::new(),
        };
    }

    /// Keeps the methods of some names only.
    pub fn retain(&mut self, is_kept: impl Fn(&str) -> bool) {
        self.results.retain(|result| is_kept(&result.name));
        if let Some(beliefs) = &mut self.beliefs {
            beliefs.retain(is_kept);
        }
    }
}

/// Wall clock, which differs from call to call: records are equal whatever theirs is, and have none in their JSON.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Timing {
    /// By method, the median milliseconds from a snapshot's odometry and readings to the answer: of the first twenty snapshots of
    /// the first trial, from a start anywhere, played again on one thread while nobody else plays. What trials find worked out
    /// for all snapshots is worked out for each; of a whole localiser it is the mean over these steps, getting ready included.
    pub step_ms: BTreeMap<String, f64>,
    /// Of grid filters, the part of it that the prediction takes: odometry moves the belief (R06 2.1).
    #[serde(default)]
    pub prediction_ms: BTreeMap<String, f64>,
    /// And the part of the correction: the sensors speak. What trials find worked out beforehand counts here.
    #[serde(default)]
    pub correction_ms: BTreeMap<String, f64>,
}

impl Timing {
    /// Notes how long a method's step took, where somebody measured it.
    pub(super) fn note(&mut self, name: &str, step: Option<StepTime>) {
        let Some(StepTime { step_ms, parts_ms }) = step else {
            return;
        };
        self.step_ms.insert(name.into(), step_ms);
        if let Some([prediction_ms, correction_ms]) = parts_ms {
            self.prediction_ms.insert(name.into(), prediction_ms);
            self.correction_ms.insert(name.into(), correction_ms);
        }
    }

    /// Adds the times of another record, whose methods are called otherwise now.
    pub(super) fn join(&mut self, other: Self, names: &BTreeMap<String, String>) {
        let called = |(name, ms): (String, f64)| (names.get(&name).cloned().unwrap_or(name), ms);
        self.step_ms.extend(other.step_ms.into_iter().map(called));
        self.prediction_ms
            .extend(other.prediction_ms.into_iter().map(called));
        self.correction_ms
            .extend(other.correction_ms.into_iter().map(called));
    }
}

impl PartialEq for Timing {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// A method that could not be made from this recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LeftOut {
    /// Key in results.
    pub name: String,
    /// In words.
    pub title: String,
    /// Why.
    pub fault: String,
}
