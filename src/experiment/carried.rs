//! Drives on which somebody carries the robot to another place without a word, and how a method plays them.

use super::{
    convergence::Answers,
    method::{AnswersBy, Method},
    methods::MethodContext,
    sureness::Sureness,
    trials::Trial,
};
use crate::{
    belief::{Grid, Places},
    error::{Error, Result},
    localiser::{BayesLocaliser, PreparedSensorModel},
    recording::Recording,
    seed::Seed,
};
use rand::RngExt;
use std::sync::Arc;

/// A robot is carried at least this far, in metres.
pub const CARRIED_M: f64 = 5.0;

/// A stretch that is driven, and another where the robot goes on; wheels say nothing of the way between.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Jump {
    /// The trial up to the jump.
    pub before: Trial,
    /// The trial after it, from 0 m on; of the same unit.
    pub after: Trial,
}

/// Of each trial that goes so far, a jump after `after_m` of it to the start of another trial at least [`CARRIED_M`] away; trials
/// from where there is none are left out. `after_m` has a trial's length for its argument.
pub(super) fn jumps(
    trials: &[Trial],
    places: &Places,
    after_m: impl Fn(f64) -> f64,
    seed: Seed,
) -> Vec<Jump> {
    let jump = |(number, trial): (usize, &Trial)| {
        let length_m = *trial.travelled_m.last()?;
        let after_m = after_m(length_m);
        if length_m < after_m {
            return None;
        }
        let driven = trial.travelled_m.iter().filter(|m| **m <= after_m + 1e-9);
        let driven = driven.count().max(1);
        let at = trial.snapshots[driven - 1];
        let is_far =
            |other: &&Trial| places.distance_m(at, places, other.snapshots[0]) >= CARRIED_M;
        let far: Vec<&Trial> = trials.iter().filter(is_far).collect();
        let mut random = seed.numbered_stream("carried away", number as u64);
        let there = (!far.is_empty()).then(|| far[random.random_range(0..far.len())])?;
        Some(Jump {
            before: Trial {
                snapshots: trial.snapshots[..driven].to_vec(),
                travelled_m: trial.travelled_m[..driven].to_vec(),
                ..trial.clone()
            },
            after: Trial {
                stretch: trial.stretch,
                unit: trial.unit,
                ..there.clone()
            },
        })
    };
    trials.iter().enumerate().filter_map(jump).collect()
}

/// Where a robot drives.
#[derive(Clone, Copy)]
pub(super) struct Ground<'a> {
    pub recording: &'a Recording,
    pub places: &'a Places,
    pub grid: &'a Arc<Grid>,
}

impl Ground<'_> {
    /// Drives the legs one after another, the robot carried from each to the next; its answers leg by leg.
    ///
    /// # Errors
    /// Where the sensor model fails.
    pub fn drive(&self, robot: BayesLocaliser, legs: &[&Trial]) -> Result<Vec<Answers>> {
        let mut robot = robot.watched()?;
        let mut leg = |leg: &&Trial| {
            let mut answers = Answers::default();
            for (step, &k) in leg.snapshots.iter().enumerate() {
                let observation = self.recording.observation(k);
                if step == 0 {
                    robot.carried(observation.odometry);
                }
                let belief = robot.observe(k, &observation)?;
                let (cells, mode) = (self.grid.places(), belief.mode());
                let expected_m = belief.expected_error_m(self.places, k);
                answers.expected_error_m.push(expected_m);
                let point_m = self.places.distance_m(k, cells, mode);
                answers.point_error_m.push(point_m);
                let sureness: &mut Sureness = &mut answers.sureness;
                sureness.note(self.grid, belief, self.places, k);
                sureness.ratios.extend(robot.ratios(mode));
            }
            Ok(answers)
        };
        legs.iter().map(&mut leg).collect()
    }
}

/// Is it a grid filter with a sensor model?
pub(super) fn is_filter(method: &Method) -> bool {
    matches!(
        method.answers,
        AnswersBy::Sensor(_) | AnswersBy::PreparedSensor(_)
    )
}

/// Does something with a method's sensor model, prepared for the unseen part; none where it is no filter with a sensor.
pub(super) fn on_unseen<T>(
    method: &Method,
    context: &MethodContext,
    play: impl FnOnce(&dyn PreparedSensorModel) -> Result<T>,
) -> Result<Option<T>> {
    match &method.answers {
        AnswersBy::Nobody(fault) => Err(Error::work(fault.clone())),
        AnswersBy::Odometry | AnswersBy::Localiser(_) | AnswersBy::Recorded(_) => Ok(None),
        AnswersBy::PreparedSensor(prepared) => play(prepared.as_ref()).map(Some),
        AnswersBy::Sensor(model) => {
            let prepared = model.prepare(context.parts.run, &context.parts.unseen)?;
            play(prepared.as_ref()).map(Some)
        }
    }
}

/// The same, prepared for the validation part; none also where that is not at hand.
pub(super) fn on_validation<T>(
    method: &Method,
    context: &MethodContext,
    play: impl FnOnce(&dyn PreparedSensorModel) -> Result<T>,
) -> Result<Option<T>> {
    let Some(source) = &context.parts.source else {
        return Ok(None);
    };
    match (&method.answers, &method.validation) {
        (AnswersBy::Sensor(model), _) => {
            let prepared = model.prepare(&source.recording, &source.validation)?;
            play(prepared.as_ref()).map(Some)
        }
        (AnswersBy::PreparedSensor(_), Some(prepared)) => play(prepared.as_ref()).map(Some),
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(unit: usize, first: usize, steps: usize) -> Trial {
        Trial {
            stretch: unit,
            unit,
            snapshots: (first..first + steps).collect(),
            travelled_m: (0..steps).map(|i| i as f64 * 0.5).collect(),
        }
    }

    #[test]
    fn a_jump_goes_far_and_keeps_its_unit() {
        let places = Places::Route((0..100).map(|k| k as f64 * 0.5).collect());
        let trials = [trial(0, 0, 21), trial(1, 40, 11), trial(2, 44, 5)];
        let all = jumps(&trials, &places, |_| 4.0, Seed(1));
        assert_eq!(all.len(), 2, "the third is too short");
        for (jump, from) in all.iter().zip(&trials) {
            assert_eq!(jump.before.travelled_m.last(), Some(&4.0));
            assert_eq!((jump.before.unit, jump.after.unit), (from.unit, from.unit));
            assert_eq!(jump.after.travelled_m[0], 0.0);
            let (at, to) = (jump.before.snapshots[8], jump.after.snapshots[0]);
            assert!(places.distance_m(at, &places, to) >= CARRIED_M);
        }
        // The first can go to the second or third, the second to the first alone.
        assert!(all[0].after.snapshots[0] >= 40);
        assert_eq!(all[1].after.snapshots[0], 0);
        assert_eq!(all, jumps(&trials, &places, |_| 4.0, Seed(1)));
        assert!(jumps(&trials, &places, |_| 50.0, Seed(1)).is_empty());
        let near = [trial(0, 0, 21), trial(1, 8, 11)];
        assert_eq!(jumps(&near, &places, |length| length, Seed(1)).len(), 2);
        assert!(jumps(&near[..1], &places, |_| 2.0, Seed(1)).is_empty());
    }
}
