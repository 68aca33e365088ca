//! Global localisation and position tracking on unseen runs: every method plays the same trials.

pub use super::localise_config::LocaliseConfig;

pub use super::{
    convergence::REPORTED_AT_M, more_particles::MoreParticles, paired_trials::PairedTest,
};

pub use super::localisation_record::{
    HeldOut, LeftOut, MethodResult, Record, Timing, TrialSummary,
};

use super::{
    belief_traces::Watch,
    confidence::confidence,
    convergence::{Answers, Row, converged_at_m, error_curve, mean_below_1m, median_distance_m},
    correction::correction,
    end_success::{heading_success, success_at_end},
    kidnapping,
    line_up::{is_own, line_up},
    lost_tuning::tuned_lost,
    method::{AnswersBy, Method},
    methods::MethodContext,
    paired_trials::TrialFigures,
    parts::Parts,
    protocol_record::ProtocolRecord,
    recall::recalled,
    region_coverage::coverage,
    repeats::Repeats,
    risk_coverage::risk_coverage,
    sequences::{drawn, evidence_scale},
    step_time::{StepTime, step_time},
    trial_play::answers,
    trials::Trial,
};
use crate::{
    belief::Places,
    error::{Error, Result},
    localiser::sensor_model::Memory,
    model::{Model, ModelBank},
    score::ClusteredMean,
};
use std::collections::{BTreeMap, BTreeSet};

/// Plays all trials with the [default line-up](line_up) of these models. All of them must have learned from the same
/// snapshots; `parts` are those of the first. `progress` is called with each method that plays.
///
/// # Errors
/// Where the unseen part allows no trial, the run lacks the models' sensors, the models learned from different places, or
/// their filters fail.
pub fn localise(
    models: &[&Model],
    parts: &Parts,
    config: &LocaliseConfig,
    progress: &mut dyn FnMut(Progress),
) -> Result<Record> {
    play_line_up(&MethodContext::new(models, parts, config)?, progress)
}

/// The same of a bank: its sets alone, and what it makes of them.
///
/// # Errors
/// As [`localise`].
pub fn localise_bank(
    bank: &ModelBank,
    parts: &Parts,
    config: &LocaliseConfig,
    progress: &mut dyn FnMut(Progress),
) -> Result<Record> {
    let sets: Vec<&Model> = bank.sets().iter().collect();
    play_line_up(
        &MethodContext::of_bank(&sets, bank.run(), parts, config)?,
        progress,
    )
}

/// Plays all trials with the [default line-up](line_up) of a context's models.
///
/// # Errors
/// As [`localise`].
pub fn play_line_up(context: &MethodContext, progress: &mut dyn FnMut(Progress)) -> Result<Record> {
    let methods = line_up(context)?;
    let record = play(context, methods, progress)?;
    // A rival may be left out; the models are what was asked about.
    let own = |absent: &&LeftOut| is_own(&absent.name);
    match record.left_out.iter().find(own) {
        Some(absent) => Err(Error::work(absent.fault.clone()).context(&absent.name)),
        None => Ok(record),
    }
}

/// How far the trials are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// Methods that have played.
    pub done: usize,
    /// Methods in all.
    pub all: usize,
    /// Title of the one that plays next.
    pub next: &'a str,
}

/// Plays all trials with these methods, to be made by `context`. A method that fails is left out, with the reason, and the
/// others play on.
///
/// # Errors
/// Where the unseen part allows no trial, two methods have one name, or no method is left.
pub fn play(
    context: &MethodContext,
    methods: Vec<Method>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Record> {
    let parts = context.parts;
    let mut names = BTreeSet::new();
    if let Some(twice) = methods.iter().find(|method| !names.insert(&method.name)) {
        return Err(Error::usage(format!(
            "two methods named `{}`; expected a name of its own for each",
            twice.name.escape_debug()
        )));
    }
    let trials = drawn(context)?;
    if let Some(after_m) = context.config.kidnap_m {
        kidnapping::drawn(&trials, context, after_m)?; // no method's fault
    }
    let all = methods.len();
    let (mut results, mut left_out) = (Vec::new(), Vec::new());
    let (mut smaller, mut timing) = (BTreeMap::new(), Timing::default());
    let mut watch = context.keeps_beliefs.then(|| Watch::new(context, &trials));
    for (done, method) in methods.into_iter().enumerate() {
        progress(Progress {
            done,
            all,
            next: &method.title,
        });
        let (name, title) = (method.name.clone(), method.title.clone());
        if let Some(fewer) = method.fewer_particles.clone() {
            smaller.insert(name.clone(), fewer);
        }
        match played(context, method, &trials, watch.as_mut()) {
            Ok(played) => {
                timing.note(&name, played.step);
                results.push(played.result);
            }
            // One that fails must not keep the others from playing.
            Err(fault) => left_out.push(LeftOut {
                name,
                title,
                fault: fault.to_string(),
            }),
        }
    }
    if let (true, Some(LeftOut { name, fault, .. })) = (results.is_empty(), left_out.first()) {
        return Err(Error::work(fault.clone()).context(name));
    }
    let stretches = trials.iter().map(|trial| trial.stretch);
    let mut record = Record {
        trials: trials.len(),
        trial_units: trials.iter().map(|trial| trial.unit).collect(),
        stretches: stretches.collect::<BTreeSet<_>>().len(),
        protocol: ProtocolRecord::of_trials(context, &trials),
        cells: context.grid.len(),
        unseen: parts.unseen.len(),
        covered: context.all_covered().len(),
        judged: context.covered().len(),
        unseen_is_validation: parts.unseen_is_validation,
        people: context.config.people(),
        degraded: parts.run.columns().degraded.clone(),
        noise: parts.run.columns().noise.clone(),
        priors: context.priors.clone(),
        results,
        paired_tests: Vec::new(),
        more_particles: Vec::new(),
        timing,
        left_out,
        beliefs: watch.map(Watch::finished),
    };
    let (resamples, seed) = (context.config.resamples, context.seed());
    record.compare_methods(resamples, seed);
    let checks = smaller.iter().filter_map(|(name, fewer)| {
        let figures = |name: &str| {
            let result = record.results.iter().find(|result| result.name == name)?;
            Some((&*result.name, &result.by_trial))
        };
        let pair = [figures(&fewer.name)?, figures(name)?];
        MoreParticles::of(fewer, &pair, &record.trial_units, resamples, seed)
    });
    record.more_particles = checks.collect();
    Ok(record)
}

/// What came of one method.
struct Played {
    result: MethodResult,
    /// How long a step took.
    step: Option<StepTime>,
}

fn played(
    context: &MethodContext,
    method: Method,
    trials: &[Trial],
    watch: Option<&mut Watch>,
) -> Result<Played> {
    let scale = evidence_scale(&method, context)?;
    let memory = Memory::default(); // snapshots are asked in trials of both kinds, and one by one
    let play = |known: bool| answers(&method, trials, context, scale, known, &memory);
    let (anywhere, known) = (play(false)?, play(true)?);
    let step = step_time(&method, trials, context, scale)?;
    let (global, tracking) = (
        summary(trials, &anywhere, context),
        // Nothing is said of starts that somebody was not asked about.
        summary(&trials[..known.len()], &known, context),
    );
    let (resamples, seed) = (context.config.resamples, context.seed());
    let heading = heading_success(trials, &anywhere, resamples, seed);
    let recalled = recalled(&method, context, scale, &memory)?;
    drop(memory);
    let within = |metres: f64| {
        let hits: Vec<(usize, bool)> = recalled
            .iter()
            .map(|snapshot| (snapshot.unit, snapshot.error_m <= metres))
            .collect();
        ClusteredMean::share(&hits, resamples, seed)
    };
    let (recall_1m, recall_05m) = (within(1.0), within(0.5));
    let (at_10m, tracked) = (global.reported(), tracking.reported());
    let risk = risk_coverage(trials, &anywhere, resamples, seed);
    let scores = context.priors.iter().zip(&method.held_out);
    let lost = tuned_lost(&method, context, scale)?;
    let kidnapped = kidnapping::kidnapped(&method, trials, context, scale, lost.as_ref())?;
    if let Some(watch) = watch {
        watch.note(&method, &anywhere, scale, lost.as_ref())?;
    }
    let places = context.grid.len() / context.grid.headings();
    let is_grid_filter = method.answers.is_grid_filter();
    let result = MethodResult {
        correction: correction(&trials[..known.len()], &known, is_grid_filter, context)?,
        confidence: confidence(trials, &anywhere, lost, places, resamples, seed),
        kidnapped,
        repeats: match &method.answers {
            AnswersBy::Recorded(recorded) => Repeats::of(recorded, trials, context)?,
            _ => None,
        },
        held_out: scores
            .map(|(&prior, &score)| HeldOut { prior, score })
            .collect(),
        robot_bytes: robot_bytes(&method, context),
        recall_1m: recall_1m.map(|share| share.mean),
        recall_1m_ci95: recall_1m.and_then(|share| share.ci95),
        recall_05m: recall_05m.map(|share| share.mean),
        recall_05m_ci95: recall_05m.and_then(|share| share.ci95),
        recall_snapshots: recalled.len(),
        error_at_10m_m: at_10m.map(|row| row.expected_error_m),
        error_at_10m_m_ci95: at_10m.and_then(|row| row.ci95_m),
        point_error_at_10m_m: at_10m.map(|row| row.point_error_m),
        point_error_at_10m_m_ci95: at_10m.and_then(|row| row.point_ci95_m),
        tracked_error_m: tracked.map(|row| row.expected_error_m),
        tracked_error_m_ci95: tracked.and_then(|row| row.ci95_m),
        tracked_point_error_m: tracked.map(|row| row.point_error_m),
        tracked_point_error_m_ci95: tracked.and_then(|row| row.point_ci95_m),
        by_trial: TrialFigures::new(trials, &anywhere, context.config.spacing_m),
        name: method.name,
        title: method.title,
        bandwidth: method.bandwidth,
        evidence_scale: scale.map(|scale| scale.scale),
        bytes_per_place: method.bytes_per_place,
        success_at_end: success_at_end(trials, &anywhere, resamples, seed),
        heading_within_5deg: heading.map(|share| share.mean),
        heading_within_5deg_ci95: heading.and_then(|share| share.ci95),
        coverage: coverage(trials, &anywhere, resamples, seed),
        risk_coverage_area_m: risk.as_ref().map(|risk| risk.area_m),
        risk_coverage_area_m_ci95: risk.as_ref().and_then(|risk| risk.area_m_ci95),
        risk_coverage: risk.map_or(Vec::new(), |risk| risk.rows),
        global,
        tracking,
    };
    Ok(Played { result, step })
}

/// A pose as a robot holds it: three numbers in single precision; along a route one.
fn robot_bytes(method: &Method, context: &MethodContext) -> Option<usize> {
    let places = &context.mapped.places;
    let numbers = match places {
        Places::Route(_) => 1,
        Places::Plane(_) => 3,
    };
    let of_place = |bytes: usize| places.len() * (bytes + numbers * size_of::<f32>());
    let of_places = match method.fills_map {
        true => 0,
        false => method.bytes_per_place.map_or(0, of_place),
    };
    let all = method.other_bytes + of_places;
    (all > 0).then_some(all)
}

fn summary(trials: &[Trial], answers: &[Answers], context: &MethodContext) -> TrialSummary {
    let converged: Vec<Option<f64>> = trials
        .iter()
        .zip(answers)
        .map(|(t, a)| converged_at_m(t, a))
        .collect();
    let config = context.config;
    let (spacing_m, resamples) = (config.spacing_m, config.resamples);
    let error_by_distance = error_curve(trials, answers, spacing_m, resamples, context.seed());
    let below_1m = mean_below_1m(&error_by_distance);
    let units = trials.iter().map(|trial| trial.unit);
    let found: Vec<(usize, bool)> = units.zip(converged.iter().map(Option::is_some)).collect();
    let found = ClusteredMean::share(&found, resamples, context.seed());
    TrialSummary {
        units: found.map_or(0, |found| found.units),
        is_uncertain: found.is_none_or(|found| found.is_uncertain()),
        converged_fraction: found.map_or(0.0, |found| found.mean),
        converged_fraction_ci95: found.and_then(|found| found.ci95),
        distance_to_converge_m: median_distance_m(&converged),
        mean_error_below_1m_at_m: below_1m.map(|row| row.distance_m),
        mean_error_below_1m_trials: below_1m.map(|row| row.trials),
        mean_error_below_1m_is_uncertain: below_1m.is_some_and(Row::is_uncertain),
        error_by_distance,
    }
}
