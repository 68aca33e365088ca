//! How long a method takes for a step of the robot: alone, on one thread, each snapshot worked on when its turn comes.

use super::{
    method::{AnswersBy, Method},
    methods::MethodContext,
    sequences::motion,
    stopwatch::{median, ms_since, on_one_thread},
    trial_play::{scaled, scaled_sensor},
    trials::Trial,
};
use crate::{
    belief::Belief,
    error::{Error, Result},
    localiser::{
        BayesLocaliser, Localiser, PreparedSensorModel,
        sensor_model::{EvidenceScale, OneByOne},
    },
};
use std::{sync::Arc, time::Instant};

/// Snapshots of a trial that are timed: 10 m of the usual half-metre steps.
const TIMED_STEPS: usize = 20;

/// How long a step takes, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StepTime {
    /// From odometry and readings to the answer.
    pub step_ms: f64,
    /// Of a grid filter: the prediction, and the correction with the answer (R06 2.1).
    pub parts_ms: Option<[f64; 2]>,
}

/// Median milliseconds from a snapshot's odometry and readings to the answer, over the first snapshots of the first trial, which
/// starts anywhere; of a whole localiser the mean over them, as it plays them at once. What trials find prepared for all
/// snapshots is worked out for each here, or counts what one took ([`Method::ready_ms`]). `None` where there is no trial.
///
/// # Errors
/// Where the method fails.
pub(super) fn step_time(
    method: &Method,
    trials: &[Trial],
    context: &MethodContext,
    scale: Option<EvidenceScale>,
) -> Result<Option<StepTime>> {
    let Some(trial) = trials.first() else {
        return Ok(None);
    };
    let snapshots = &trial.snapshots[..trial.snapshots.len().min(TIMED_STEPS)];
    let filter = |sensor: Option<&dyn PreparedSensorModel>| {
        let steps = filter_ms(method, snapshots, context, sensor, scale)?;
        let part = |of: fn(&[f64; 2]) -> f64| median(steps.iter().map(of).collect());
        let whole = part(|[prediction, correction]| prediction + correction);
        let parts = part(|of| of[0]).zip(part(|of| of[1]));
        Ok(whole.map(|ms| StepTime {
            step_ms: ms + method.ready_ms,
            parts_ms: parts
                .map(|(prediction, correction)| [prediction, correction + method.ready_ms]),
        }))
    };
    on_one_thread(|| match &method.answers {
        AnswersBy::Nobody(fault) => Err(Error::work(fault.clone())),
        AnswersBy::Recorded(_) => Ok(None),
        AnswersBy::Odometry => filter(None),
        AnswersBy::PreparedSensor(prepared) => filter(Some(prepared.as_ref())),
        AnswersBy::Sensor(model) => filter(Some(&OneByOne {
            model: Arc::clone(model),
            recording: context.parts.run,
        })),
        AnswersBy::Localiser(localiser) => {
            let scaled = scaled(localiser.as_ref(), scale);
            let localiser = scaled.as_deref().unwrap_or(localiser.as_ref());
            let step_ms = localiser_ms(localiser, snapshots, context)?;
            Ok(Some(StepTime {
                step_ms,
                parts_ms: None,
            }))
        }
    })?
}

/// Milliseconds of prediction and of correction in each step of the grid filter.
fn filter_ms(
    method: &Method,
    snapshots: &[usize],
    context: &MethodContext,
    sensor: Option<&dyn PreparedSensorModel>,
    scale: Option<EvidenceScale>,
) -> Result<Vec<[f64; 2]>> {
    let scaled = scaled_sensor(sensor, scale);
    let sensor = scaled.as_ref().map(|s| s as &dyn PreparedSensorModel);
    let start = Belief::uniform(context.grid.places())?;
    let stream = context.seed().stream("timed steps");
    let motion = motion(method, context);
    let mut robot = BayesLocaliser::new(&context.grid, motion, start, sensor, stream)?;
    let step = |&k: &usize| {
        let observation = context.parts.run.observation(k);
        let started = Instant::now();
        robot.predict(&observation)?;
        let prediction_ms = ms_since(started);
        let started = Instant::now();
        robot.correct(k)?.mode();
        Ok([prediction_ms, ms_since(started)])
    };
    snapshots.iter().map(step).collect()
}

/// Mean milliseconds of a whole localiser's steps, getting ready for these snapshots included.
fn localiser_ms(
    localiser: &dyn Localiser,
    snapshots: &[usize],
    context: &MethodContext,
) -> Result<f64> {
    let mut stream = context.seed().stream("timed steps");
    let started = Instant::now();
    let player = localiser.prepare(context.parts.run, snapshots)?;
    player.play(snapshots, None, &mut stream)?;
    Ok(ms_since(started) / snapshots.len().max(1) as f64)
}
