//! Global localisation and position tracking on unseen runs: every method plays the same trials.

pub use super::localise_config::LocaliseConfig;

pub use super::convergence::REPORTED_AT_M;

pub use super::localisation_record::{
    HeldOut, LeftOut, MethodResult, Record, Timing, TrialSummary,
};

use super::{
    convergence::{
        Answers, Row, converged_at_m, error_curve, mean_below_1m, median_distance_m, share,
    },
    end_success::{heading_success, success_at_end},
    line_up::line_up,
    method::{AnswersBy, Method},
    methods::MethodContext,
    paired_trials::{FiguresOfTrials, paired_tests},
    parts::Parts,
    recall::recalled,
    region_coverage::{coverage, likelier_mass},
    risk_coverage::{RIGHT_WITHIN_M, risk_coverage},
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
use std::{collections::BTreeSet, time::Instant};

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
    let (mut figures, mut timing) = (Vec::new(), Timing::default());
    for (done, method) in methods.into_iter().enumerate() {
        progress(Progress {
            done,
            all,
            next: &method.title,
        });
        let (name, title) = (method.name.clone(), method.title.clone());
        match result(context, method, &trials) {
            Ok((result, answers)) => {
                let spacing_m = context.config.spacing_m;
                figures.push(FiguresOfTrials::new(&name, &trials, &answers, spacing_m));
                timing
                    .step_ms
                    .extend(step_ms(&answers).map(|ms| (name, ms)));
                results.push(result);
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
    Ok(Record {
        trials: trials.len(),
        stretches: stretches.collect::<BTreeSet<_>>().len(),
        cells: context.grid.len(),
        unseen: parts.unseen.len(),
        covered: parts.covered(&context.mapped.places).len(),
        unseen_is_validation: parts.unseen_is_validation,
        priors: context.priors.clone(),
        results,
        paired_tests: paired_tests(&figures, &trials, context.seed()),
        timing,
        left_out,
    })
}

/// Median milliseconds a step, over the steps of all trials.
fn step_ms(answers: &[Answers]) -> Option<f64> {
    let steps = answers.iter().flat_map(|answers| &answers.step_ms);
    let mut steps: Vec<f64> = steps.copied().collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied()
}

/// All figures of a method, and its answers in the trials that start anywhere.
fn result(
    context: &MethodContext,
    method: Method,
    trials: &[Trial],
) -> Result<(MethodResult, Vec<Answers>)> {
    let scale = evidence_scale(&method, context)?;
    let play = |known_start: bool| answers(&method, trials, context, scale, known_start);
    let (anywhere, known) = (play(false)?, play(true)?);
    let (global, tracking) = (
        summary(trials, &anywhere, context),
        summary(trials, &known, context),
    );
    let (resamples, seed) = (context.config.resamples, context.seed());
    let heading = heading_success(trials, &anywhere, resamples, seed);
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
    let result = MethodResult {
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
        success_at_end: success_at_end(trials, &anywhere, resamples, seed),
        heading_within_5deg: heading.map(|share| share.0),
        heading_within_5deg_ci95: heading.and_then(|share| share.1),
        coverage: coverage(trials, &anywhere, resamples, seed),
        risk_coverage: risk_coverage(&anywhere),
        global,
        tracking,
    };
    Ok((result, anywhere))
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

/// What a method answers in every trial.
fn answers(
    method: &Method,
    trials: &[Trial],
    context: &MethodContext,
    scale: Option<EvidenceScale>,
    known_start: bool,
) -> Result<Vec<Answers>> {
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
    match &method.answers {
        AnswersBy::Nobody(fault) => Err(Error::work(fault.clone())),
        AnswersBy::Odometry => sensor(None),
        AnswersBy::PreparedSensor(prepared) => sensor(Some(prepared.as_ref())),
        AnswersBy::Sensor(model) => {
            let prepared = model.prepare(context.parts.run, &context.parts.unseen)?;
            sensor(Some(prepared.as_ref()))
        }
        AnswersBy::Localiser(localiser) => {
            by_localiser(localiser.as_ref(), trials, context, known_start)
        }
    }
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
    let found = share(&found, resamples, context.seed());
    TrialSummary {
        converged_fraction: found.map_or(0.0, |found| found.0),
        converged_fraction_ci95: found.and_then(|found| found.1),
        distance_to_converge_m: median_distance_m(&converged),
        mean_error_below_1m_at_m: below_1m.map(|row| row.distance_m),
        mean_error_below_1m_trials: below_1m.map(|row| row.trials),
        mean_error_below_1m_is_uncertain: below_1m.is_some_and(Row::is_uncertain),
        error_by_distance,
    }
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
        let mut answers = Answers::default();
        for (step, &k) in trial.snapshots.iter().enumerate() {
            let observation = parts.run.observation(k);
            let started = Instant::now();
            let belief = robot.observe(k, &observation)?;
            let mode = belief.mode();
            answers.step_ms.push(started.elapsed().as_secs_f64() * 1e3);
            let (cells, truths) = (grid.places(), &parts.places);
            let expected_m = belief.expected_error_m(truths, k);
            answers.expected_error_m.push(expected_m);
            let point_m = truths.distance_m(k, cells, mode);
            answers.point_error_m.push(point_m);
            if self.known_start {
                continue; // what follows is reported of starts anywhere only
            }
            let likelier = likelier_mass(grid, belief, truths, k);
            answers.likelier_mass.push(likelier);
            if step + 1 == trial.snapshots.len() {
                let is_plane = matches!(truths, Places::Plane(_));
                answers.end_heading_error_rad = is_plane.then(|| truths.turn_rad(k, cells, mode));
                answers.end_confidence = Some(belief.mass_within_m(cells, mode, RIGHT_WITHIN_M));
            }
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
        let started = Instant::now();
        let steps = player.play(&trial.snapshots, start, &mut stream(context, number))?;
        let trial_ms = started.elapsed().as_secs_f64() * 1e3;
        if steps.len() != trial.snapshots.len() {
            return Err(Error::work(format!(
                "{} answers to a trial of {} snapshots; expected one each",
                steps.len(),
                trial.snapshots.len()
            )));
        }
        let mut answers = Answers {
            step_ms: vec![trial_ms / steps.len() as f64; steps.len()],
            end_confidence: steps.last().and_then(confidence),
            ..Answers::default()
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

/// The place of a localiser's answer: its estimate, else the likeliest of its posterior; none where it has no answer.
fn estimate(step: &Step) -> Result<Option<[f64; 2]>> {
    match &step.estimate {
        Some(Estimate::Place(place)) => Ok(Some(*place)),
        Some(Estimate::Class(class)) => Err(Error::work(format!(
            "the answer is class {class}, which only the localiser can interpret; trials need places in the plane"
        ))),
        None => {
            let likelier = |a: &&([f64; 2], f64), b: &&([f64; 2], f64)| a.1.total_cmp(&b.1);
            let likeliest = step.posterior.iter().max_by(likelier);
            Ok(likeliest.map(|(place, _)| *place))
        }
    }
}

/// Probability that a localiser gives to places within 1 m of its own estimate; none where it says nothing of how sure it is.
fn confidence(step: &Step) -> Option<f64> {
    let at = estimate(step).ok()??;
    let is_near = |place: &[f64; 2]| (place[0] - at[0]).hypot(place[1] - at[1]) <= RIGHT_WITHIN_M;
    let near = step.posterior.iter().filter(|(place, _)| is_near(place));
    (!step.posterior.is_empty()).then(|| near.map(|(_, p)| p).sum())
}

/// Expected and point error of a localiser's answer, in metres in the plane; none where it has no answer.
fn errors_m(step: &Step, truth: &Pose) -> Result<Option<(f64, f64)>> {
    let off_m = |place: &[f64; 2]| (place[0] - truth.x_m).hypot(place[1] - truth.y_m);
    let Some(point_m) = estimate(step)?.as_ref().map(off_m) else {
        return Ok(None);
    };
    let expected_m = step.posterior.iter().map(|(place, p)| p * off_m(place));
    Ok(Some(match step.posterior.is_empty() {
        true => (point_m, point_m),
        false => (expected_m.sum(), point_m),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_localiser_is_as_sure_as_it_gives_mass_near_its_estimate() {
        let step = |estimate: Option<[f64; 2]>, posterior: &[([f64; 2], f64)]| Step {
            estimate: estimate.map(Estimate::Place),
            posterior: posterior.to_vec(),
        };
        let posterior = [([0.0, 0.0], 0.5), ([0.9, 0.0], 0.25), ([3.0, 0.0], 0.25)];
        assert_eq!(confidence(&step(Some([3.0, 0.5]), &posterior)), Some(0.25));
        assert_eq!(confidence(&step(None, &posterior)), Some(0.75)); // of the likeliest place
        assert_eq!(confidence(&step(Some([0.0, 0.0]), &[])), None);
        assert_eq!(confidence(&step(None, &[])), None);
    }

    #[test]
    fn the_median_step_is_over_all_trials() {
        let of = |step_ms: &[f64]| Answers {
            step_ms: step_ms.to_vec(),
            ..Answers::default()
        };
        assert_eq!(step_ms(&[of(&[9.0, 1.0]), of(&[2.0])]), Some(2.0));
        assert_eq!(step_ms(&[]), None);
    }
}
