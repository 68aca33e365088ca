//! Global localisation and position tracking on unseen runs: every method plays the same trials.

pub use super::localise_config::LocaliseConfig;

pub use super::localisation_record::{
    HeldOut, LeftOut, MethodResult, REPORTED_AT_M, Record, TrialSummary,
};

use super::{
    convergence::{
        Answers, Row, converged_at_m, error_curve, mean_below_1m, median_distance_m, share,
    },
    line_up::line_up,
    method::{AnswersBy, Method},
    methods::MethodContext,
    parts::Parts,
    recall::recalled,
    sequences::{drawn, evidence_scale, motion},
    trials::Trial,
};
use crate::{
    belief::{Belief, OdometryMotion, Places},
    error::{Error, Result},
    geometry::Pose,
    localiser::{
        BayesLocaliser, Estimate, Localiser, PreparedSensorModel, Step,
        sensor_model::{EvidenceScale, Scaled},
    },
    model::Model,
    seed::Stream,
};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Plays all trials with the [default line-up](line_up) of these models. All of them must have learned from the same
/// snapshots; `parts` are those of the first. `progress` is called with each method that plays.
///
/// # Errors
/// Where the unseen part allows no trial, the run lacks the models' sensors, or the models learned from different places.
pub fn localise(
    models: &[&Model],
    parts: &Parts,
    config: &LocaliseConfig,
    progress: &mut dyn FnMut(Progress),
) -> Result<Record> {
    let context = MethodContext::new(models, parts, config)?;
    let methods = line_up(&context)?;
    play(&context, methods, progress)
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
    let all = methods.len();
    let (mut results, mut left_out) = (Vec::new(), Vec::new());
    for (done, method) in methods.into_iter().enumerate() {
        progress(Progress {
            done,
            all,
            next: &method.title,
        });
        let (name, title) = (method.name.clone(), method.title.clone());
        match result(context, method, &trials) {
            Ok(result) => results.push(result),
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
    Ok(Record {
        trials: trials.len(),
        stretches: stretches.collect::<BTreeSet<_>>().len(),
        cells: context.grid.len(),
        unseen: parts.unseen.len(),
        covered: parts.covered(&context.mapped.places).len(),
        unseen_is_validation: parts.unseen_is_validation,
        priors: context.priors.clone(),
        results,
        left_out,
    })
}

/// All figures of a method.
fn result(context: &MethodContext, method: Method, trials: &[Trial]) -> Result<MethodResult> {
    let scale = evidence_scale(&method, context)?;
    let play = |known_start: bool| summary(&method, trials, context, scale, known_start);
    let (global, tracking) = (play(false)?, play(true)?);
    let recalled = recalled(&method, context, scale)?;
    let within = |metres: f64| {
        let hits: Vec<(usize, bool)> = recalled
            .iter()
            .map(|snapshot| (snapshot.unit, snapshot.error_m <= metres))
            .collect();
        share(&hits, context.config.resamples, context.seed())
    };
    let (recall_1m, recall_05m) = (within(1.0), within(0.5));
    let scores = context.priors.iter().zip(&method.held_out);
    Ok(MethodResult {
        held_out: scores
            .map(|(&prior, &score)| HeldOut { prior, score })
            .collect(),
        robot_bytes: robot_bytes(&method, context),
        recall_1m: recall_1m.map(|share| share.0),
        recall_1m_ci95: recall_1m.and_then(|share| share.1),
        recall_05m: recall_05m.map(|share| share.0),
        recall_05m_ci95: recall_05m.and_then(|share| share.1),
        error_at_10m_m: global.reported().map(|row| row.expected_error_m),
        error_at_10m_m_ci95: global.reported().and_then(|row| row.ci95_m),
        tracked_error_m: tracking.reported().map(|row| row.expected_error_m),
        tracked_error_m_ci95: tracking.reported().and_then(|row| row.ci95_m),
        name: method.name,
        title: method.title,
        bandwidth: method.bandwidth,
        evidence_scale: scale.map(|scale| scale.scale),
        bytes_per_place: method.bytes_per_place,
        global,
        tracking,
    })
}

/// A pose as a robot holds it: three numbers in single precision; along a route one.
fn robot_bytes(method: &Method, context: &MethodContext) -> Option<usize> {
    let places = &context.mapped.places;
    let numbers = match places {
        Places::Route(_) => 1,
        Places::Plane(_) => 3,
    };
    let of_place = |bytes: usize| places.len() * (bytes + numbers * size_of::<f32>());
    let all = method.other_bytes + method.bytes_per_place.map_or(0, of_place);
    (all > 0).then_some(all)
}

fn summary(
    method: &Method,
    trials: &[Trial],
    context: &MethodContext,
    scale: Option<EvidenceScale>,
    known_start: bool,
) -> Result<TrialSummary> {
    let sensor = |sensor: Option<&dyn PreparedSensorModel>| {
        let scaled = match (sensor, scale) {
            (Some(sensor), Some(scale)) => Some(Scaled::new(sensor, scale)),
            _ => None,
        };
        let filter = Filter {
            context,
            sensor: scaled.as_ref().map(|s| s as &dyn PreparedSensorModel),
            motion: motion(method, context),
            known_start,
        };
        played(trials, |t, trial| filter.answers(t, trial))
    };
    let answers = match &method.answers {
        AnswersBy::Nobody(fault) => return Err(Error::work(fault.clone())),
        AnswersBy::Odometry => sensor(None),
        AnswersBy::PreparedSensor(prepared) => sensor(Some(prepared.as_ref())),
        AnswersBy::Sensor(model) => {
            let prepared = model.prepare(context.parts.run, &context.parts.unseen)?;
            sensor(Some(prepared.as_ref()))
        }
        AnswersBy::Localiser(localiser) => {
            by_localiser(localiser.as_ref(), trials, context, known_start)
        }
    }?;
    let converged: Vec<Option<f64>> = trials
        .iter()
        .zip(&answers)
        .map(|(t, a)| converged_at_m(t, a))
        .collect();
    let config = context.config;
    let (spacing_m, resamples) = (config.spacing_m, config.resamples);
    let error_by_distance = error_curve(trials, &answers, spacing_m, resamples, context.seed());
    let below_1m = mean_below_1m(&error_by_distance);
    let units = trials.iter().map(|trial| trial.unit);
    let found: Vec<(usize, bool)> = units.zip(converged.iter().map(Option::is_some)).collect();
    let found = share(&found, resamples, context.seed());
    Ok(TrialSummary {
        converged_fraction: found.map_or(0.0, |found| found.0),
        converged_fraction_ci95: found.and_then(|found| found.1),
        distance_to_converge_m: median_distance_m(&converged),
        mean_error_below_1m_at_m: below_1m.map(|row| row.distance_m),
        mean_error_below_1m_trials: below_1m.map(|row| row.trials),
        mean_error_below_1m_is_uncertain: below_1m.is_some_and(Row::is_uncertain),
        error_by_distance,
    })
}

/// Every trial with its number, in parallel; the answers in the order of the trials.
fn played(
    trials: &[Trial],
    play: impl Fn(usize, &Trial) -> Result<Answers> + Sync,
) -> Result<Vec<Answers>> {
    let trials = trials.par_iter().enumerate();
    trials.map(|(t, trial)| play(t, trial)).collect()
}

/// The grid Bayes filter with a method's sensor model, or with odometry alone.
struct Filter<'a> {
    context: &'a MethodContext<'a>,
    sensor: Option<&'a dyn PreparedSensorModel>,
    motion: &'a OdometryMotion,
    known_start: bool,
}

impl Filter<'_> {
    fn answers(&self, number: usize, trial: &Trial) -> Result<Answers> {
        let (parts, grid, config) = (self.context.parts, &self.context.grid, self.context.config);
        let start = if self.known_start {
            let (at, spread_m, spread_rad) = (
                trial.snapshots[0],
                config.start_spread_m,
                config.start_spread_rad,
            );
            Belief::around(grid.places(), &parts.places, at, spread_m, spread_rad)?
        } else {
            Belief::uniform(grid.places())?
        };
        let stream = stream(self.context, number);
        let mut robot = BayesLocaliser::new(grid, self.motion, start, self.sensor, stream)?;
        let mut answers = Answers {
            expected_error_m: Vec::new(),
            point_error_m: Vec::new(),
        };
        for &k in &trial.snapshots {
            let belief = robot.observe(k, &parts.run.observation(k))?;
            let (expected_m, point_m) = (
                belief.expected_error_m(&parts.places, k),
                belief.point_error_m(&parts.places, k),
            );
            answers.expected_error_m.push(expected_m);
            answers.point_error_m.push(point_m);
        }
        Ok(answers)
    }
}

fn stream(context: &MethodContext, number: usize) -> Stream {
    context
        .seed()
        .numbered_stream("sampled features", number as u64)
}

/// The answers of a whole localiser. Who asks for the start is given it where it is known.
fn by_localiser(
    localiser: &dyn Localiser,
    trials: &[Trial],
    context: &MethodContext,
    known_start: bool,
) -> Result<Vec<Answers>> {
    let run = context.parts.run;
    let snapshots: BTreeSet<usize> = trials.iter().flat_map(|t| &t.snapshots).copied().collect();
    let snapshots: Vec<usize> = snapshots.into_iter().collect();
    let player = localiser.prepare(run, &snapshots)?;
    let no_idea = Belief::uniform(context.grid.places())?;
    played(trials, |number, trial| {
        let start = run.poses()[trial.snapshots[0]];
        let start = (known_start && localiser.asks_for_the_start()).then_some(start);
        let steps = player.play(&trial.snapshots, start, &mut stream(context, number))?;
        if steps.len() != trial.snapshots.len() {
            return Err(Error::work(format!(
                "{} answers to a trial of {} snapshots; expected one each",
                steps.len(),
                trial.snapshots.len()
            )));
        }
        let mut answers = Answers {
            expected_error_m: Vec::new(),
            point_error_m: Vec::new(),
        };
        for (&k, step) in trial.snapshots.iter().zip(&steps) {
            let errors = errors_m(step, &run.poses()[k])?;
            // Who has no answer knows nothing.
            let (expected_m, point_m) = errors.unwrap_or_else(|| {
                let error_m = no_idea.expected_error_m(&context.parts.places, k);
                (error_m, error_m)
            });
            answers.expected_error_m.push(expected_m);
            answers.point_error_m.push(point_m);
        }
        Ok(answers)
    })
}

/// Expected and point error of a localiser's answer, in metres in the plane; none where it has no answer.
fn errors_m(step: &Step, truth: &Pose) -> Result<Option<(f64, f64)>> {
    let off_m = |place: &[f64; 2]| (place[0] - truth.x_m).hypot(place[1] - truth.y_m);
    let point_m = match &step.estimate {
        Some(Estimate::Place(place)) => off_m(place),
        Some(Estimate::Class(class)) => {
            return Err(Error::work(format!(
                "the answer is class {class}, which only the localiser can interpret; trials need places in the plane"
            )));
        }
        None => {
            let likelier = |a: &&([f64; 2], f64), b: &&([f64; 2], f64)| a.1.total_cmp(&b.1);
            match step.posterior.iter().max_by(likelier) {
                Some((place, _)) => off_m(place),
                None => return Ok(None),
            }
        }
    };
    let expected_m = step.posterior.iter().map(|(place, p)| p * off_m(place));
    Ok(Some(match step.posterior.is_empty() {
        true => (point_m, point_m),
        false => (expected_m.sum(), point_m),
    }))
}
