//! How a method plays trials, and what is kept of its answers: the one place where it meets the truth.

use super::{
    convergence::Answers,
    method::{AnswersBy, Method},
    methods::MethodContext,
    region_coverage::{likelier_mass, likelier_mass_of_places},
    risk_coverage::RIGHT_WITHIN_M,
    sequences::motion,
    trials::Trial,
};
use crate::{
    belief::{Belief, OdometryMotion, Places},
    error::{Error, Result},
    geometry::Pose,
    localiser::{
        BayesLocaliser, Estimate, Localiser, PreparedSensorModel, Step,
        sensor_model::{EvidenceScale, Memory, Remembered, Scaled},
    },
    seed::Stream,
};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// What a method answers in every trial; `memory` is of its sensor model on the unseen part alone.
///
/// # Errors
/// Where the method could not be made, or fails.
pub(super) fn answers(
    method: &Method,
    trials: &[Trial],
    context: &MethodContext,
    scale: Option<EvidenceScale>,
    known_start: bool,
    memory: &Memory,
) -> Result<Vec<Answers>> {
    let sensor = |sensor: Option<&dyn PreparedSensorModel>| {
        let sensor = sensor.map(|sensor| Remembered::new(sensor, memory));
        let sensor = sensor.as_ref().map(|s| s as &dyn PreparedSensorModel);
        let scaled = scaled_sensor(sensor, scale);
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
        AnswersBy::Recorded(recorded) => {
            let steps = match known_start {
                true => &recorded.known,
                false => &recorded.anywhere,
            };
            judged(trials, steps, context, known_start)
        }
        AnswersBy::Localiser(localiser) => {
            let scaled = scaled(localiser.as_ref(), scale);
            let localiser = scaled.as_deref().unwrap_or(localiser.as_ref());
            by_localiser(localiser, trials, context, known_start)
        }
    }
}

/// A sensor model with its evidence as tuned; none where there is no sensor.
pub(super) fn scaled_sensor(
    sensor: Option<&dyn PreparedSensorModel>,
    scale: Option<EvidenceScale>,
) -> Option<Scaled<'_>> {
    Some(Scaled::new(sensor?, scale?))
}

/// A localiser with its evidence as tuned; none where that is not for others to say.
pub(super) fn scaled(
    localiser: &dyn Localiser,
    scale: Option<EvidenceScale>,
) -> Option<Box<dyn Localiser + '_>> {
    localiser.with_evidence_scale(scale?.scale)
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
        if let Some(restart) = &config.restart {
            robot = robot.restarting(restart)?;
        }
        if !self.known_start {
            robot = robot.watched()?;
        }
        let mut answers = Answers::default();
        for (step, &k) in trial.snapshots.iter().enumerate() {
            let observation = parts.run.observation(k);
            let belief = robot.observe(k, &observation)?;
            let mode = belief.mode();
            let (cells, truths) = (grid.places(), &parts.places);
            let expected_m = belief.expected_error_m(truths, k);
            answers.expected_error_m.push(expected_m);
            let point_m = truths.distance_m(k, cells, mode);
            answers.point_error_m.push(point_m);
            if self.known_start {
                answers.estimates.push(Some(match **cells {
                    Places::Route(_) => cells.pose(mode),
                    Places::Plane(_) => Pose {
                        heading_rad: belief.mode_heading_rad(),
                        ..cells.pose(mode)
                    },
                }));
                continue; // what follows is reported of starts anywhere only
            }
            let likelier = likelier_mass(grid, belief, truths, k);
            answers.likelier_mass.push(likelier);
            answers.sureness.note(grid, belief, truths, k);
            let is_last = step + 1 == trial.snapshots.len();
            if is_last {
                answers.sureness.end(belief);
                let is_plane = matches!(truths, Places::Plane(_));
                let error_rad = turn_rad(belief.mode_heading_rad(), &parts.run.poses()[k]);
                answers.end_heading_error_rad = is_plane.then_some(error_rad);
                answers.end_confidence = Some(belief.mass_within_m(cells, mode, RIGHT_WITHIN_M));
            }
            answers.sureness.ratios.extend(robot.ratios(mode));
        }
        Ok(answers)
    }
}

/// What a method draws from in a trial.
pub(super) fn stream(context: &MethodContext, number: usize) -> Stream {
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
    let play = |number: usize, trial: &Trial| {
        let start = run.poses()[trial.snapshots[0]];
        let start = (known_start && localiser.asks_for_the_start()).then_some(start);
        let stream = &mut stream(context, number);
        // Judged at once: the particles of all trials together are a gigabyte.
        let steps = player.play(&trial.snapshots, start, stream)?;
        judged_trial(trial, &steps, context, known_start, &no_idea)
    };
    played(trials, play)
}

/// The answers of somebody who is no grid filter, held against the truth, one entry a trial.
pub(super) fn judged(
    trials: &[Trial],
    steps: &[Vec<Step>],
    context: &MethodContext,
    known_start: bool,
) -> Result<Vec<Answers>> {
    let no_idea = Belief::uniform(context.grid.places())?;
    let all = trials.par_iter().zip(steps);
    all.map(|(trial, steps)| judged_trial(trial, steps, context, known_start, &no_idea))
        .collect()
}

/// The same of one trial; `no_idea` is what a robot without an answer believes.
fn judged_trial(
    trial: &Trial,
    steps: &[Step],
    context: &MethodContext,
    known_start: bool,
    no_idea: &Belief,
) -> Result<Answers> {
    let run = context.parts.run;
    if steps.len() != trial.snapshots.len() {
        return Err(Error::work(format!(
            "{} answers to a trial of {} snapshots; expected one each",
            steps.len(),
            trial.snapshots.len()
        )));
    }
    let mut answers = Answers {
        end_confidence: steps.last().and_then(confidence),
        end_heading_error_rad: steps.last().and_then(|step| {
            let heading = step.heading_rad.filter(|_| is_answer(step))?;
            let truth = &run.poses()[*trial.snapshots.last()?];
            Some(turn_rad(heading, truth))
        }),
        ..Answers::default()
    };
    for (&k, step) in trial.snapshots.iter().zip(steps) {
        let errors = errors_m(step, &run.poses()[k])?;
        // Who has no answer knows nothing.
        let (expected_m, point_m) = errors.unwrap_or_else(|| {
            let error_m = no_idea.expected_error_m(&context.parts.places, k);
            (error_m, error_m)
        });
        answers.expected_error_m.push(expected_m);
        answers.point_error_m.push(point_m);
        if known_start {
            let place = estimate(step)?;
            let pose = place.zip(step.heading_rad);
            let pose = pose.map(|([x_m, y_m], heading)| Pose::new(x_m, y_m, heading));
            answers.estimates.push(pose);
        }
        if !known_start && !step.posterior.is_empty() {
            let truth = &run.poses()[k];
            let (at, square_m) = ([truth.x_m, truth.y_m], context.grid.cell_m());
            let likelier = likelier_mass_of_places(&step.posterior, at, square_m);
            answers.likelier_mass.push(likelier);
            let near = confidence(step).unwrap_or(0.0);
            let sureness = &mut answers.sureness;
            sureness.note_places(&step.posterior, near, at, square_m);
        }
    }
    Ok(answers)
}

/// Is there an answer at all?
fn is_answer(step: &Step) -> bool {
    step.estimate.is_some() || !step.posterior.is_empty()
}

fn turn_rad(heading_rad: f64, truth: &Pose) -> f64 {
    Pose::new(0.0, 0.0, heading_rad).turn_rad(truth)
}

/// The place of a localiser's answer: its estimate, else the likeliest of its posterior; none where it has no answer.
pub(super) fn estimate(step: &Step) -> Result<Option<[f64; 2]>> {
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

/// Probability that a localiser gives to places within 1 m of its own estimate: 0 where it has no answer, none where it says
/// nothing of how sure it is.
fn confidence(step: &Step) -> Option<f64> {
    if !is_answer(step) {
        return Some(0.0);
    }
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
            ..Step::default()
        };
        let posterior = [([0.0, 0.0], 0.5), ([0.9, 0.0], 0.25), ([3.0, 0.0], 0.25)];
        assert_eq!(confidence(&step(Some([3.0, 0.5]), &posterior)), Some(0.25));
        assert_eq!(confidence(&step(None, &posterior)), Some(0.75)); // of the likeliest place
        assert_eq!(confidence(&step(Some([0.0, 0.0]), &[])), None);
        assert_eq!(confidence(&step(None, &[])), Some(0.0));
    }
}
