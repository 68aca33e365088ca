//! Are answers in the frame of the recording's poses? Those in another one would count as wrong, and nobody would know why.

use super::trial_files::Start;
use crate::{
    error::{Error, Result},
    experiment::trials::Trial,
    geometry::Pose,
    localiser::{Estimate, Step},
    recording::Recording,
    score::trajectory::Alignment,
};
use nalgebra::Vector3;

/// An answer farther than this from everywhere that the recording goes is in no frame of it, in metres: robots that lost their way leave
/// buildings, but not towns.
const FARTHEST_M: f64 = 500.0;
/// An answer this near to what odometry says from (0, 0) on is what it says, in metres.
const SAME_M: f64 = 0.05;
/// Fewest trials that a frame is sought for: what fits one or two of them fits by chance.
const LEAST_TRIALS: usize = 5;
/// Answers are in another frame where their median error is above this, in metres …
const WRONG_M: f64 = 2.0;
/// … and one turn and shift of all of them leaves less than this share of it.
const LEFT: f64 = 0.25;

/// Answers, trial by trial, and what they are called.
pub(super) struct Answered<'a> {
    pub start: Start,
    pub names: &'a [String],
    pub trials: &'a [Trial],
    pub steps: &'a [Vec<Step>],
}

impl Answered<'_> {
    /// Was it told where they start?
    fn is_known(&self) -> bool {
        self.start == Start::Known
    }
}

fn place(step: &Step) -> Option<[f64; 2]> {
    match step.estimate {
        Some(Estimate::Place(place)) => Some(place),
        _ => None,
    }
}

/// # Errors
/// Where an answer is out of this world, all trials begin at one place, or all answers fit the truth once they are turned and shifted.
pub(super) fn check(run: &Recording, answered: &[Answered]) -> Result<()> {
    for answered in answered {
        within_reach(run, answered)?;
        from_own_starts(run, answered)?;
    }
    in_one_frame(run, answered)
}

fn within_reach(run: &Recording, answered: &Answered) -> Result<()> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for pose in run.poses() {
        for (axis, m) in [pose.x_m, pose.y_m].into_iter().enumerate() {
            low[axis] = low[axis].min(m);
            high[axis] = high[axis].max(m);
        }
    }
    for (name, steps) in answered.names.iter().zip(answered.steps) {
        for (snapshot, step) in steps.iter().enumerate() {
            let Some([x, y]) = place(step) else { continue };
            let beyond = |axis: usize, m: f64| (low[axis] - m).max(m - high[axis]).max(0.0);
            let far_m = beyond(0, x).hypot(beyond(1, y));
            if far_m > FARTHEST_M {
                return Err(Error::work(format!(
                    "{name}: its answer to snapshot {} is ({x:.1}, {y:.1}) m, {far_m:.0} m outside of where the recording goes \
                     ({:.1} to {:.1}, {:.1} to {:.1}); expected metres in the frame of the mapping part's poses",
                    snapshot + 1,
                    low[0],
                    high[0],
                    low[1],
                    high[1]
                )));
            }
        }
    }
    Ok(())
}

/// From a start anywhere nobody knows where he is, and (0, 0) may be a first guess like any other: there only answers that go on as each
/// trial's odometry does are in its frame.
fn from_own_starts(run: &Recording, answered: &Answered) -> Result<()> {
    if answered.trials.len() < LEAST_TRIALS {
        return Ok(());
    }
    let is_known = answered.is_known();
    let is_own = |(trial, steps): (&Trial, &Vec<Step>)| {
        let odometry = |k: usize| run.observation(k).odometry;
        let first = odometry(trial.snapshots[0]);
        let reckoned = |&k: &usize| Pose::default().after(first.displacement_to(&odometry(k)));
        let mut pairs = trial.snapshots.iter().map(reckoned).zip(steps);
        let said = |(pose, step): (Pose, &Step)| {
            place(step).is_some_and(|[x, y]| (x - pose.x_m).hypot(y - pose.y_m) <= SAME_M)
        };
        match is_known {
            true => pairs.next().is_some_and(said),
            false => pairs.all(said),
        }
    };
    let truth = |trial: &Trial| run.poses()[trial.snapshots[0]];
    let at_origin = |trial: &Trial| truth(trial).x_m.hypot(truth(trial).y_m) <= WRONG_M;
    let all_own = answered.trials.iter().zip(answered.steps).all(is_own);
    match all_own && !answered.trials.iter().all(at_origin) {
        false => Ok(()),
        true => Err(Error::work(format!(
            "the answers to all {} trials begin at (0, 0); expected metres in the frame of the mapping part's poses, not of each \
             trial's odometry",
            answered.trials.len()
        ))),
    }
}

/// Of starts anywhere the second half of each trial: before, nobody can know where he is.
fn in_one_frame(run: &Recording, answered: &[Answered]) -> Result<()> {
    let (mut said, mut true_at) = (Vec::new(), Vec::new());
    let mut trials = 0;
    for answered in answered {
        let is_known = answered.is_known();
        for (trial, steps) in answered.trials.iter().zip(answered.steps) {
            let from = if is_known { 0 } else { steps.len() / 2 };
            let pairs = trial.snapshots.iter().zip(steps).skip(from);
            let before = said.len();
            for (&k, step) in pairs {
                let (Some([x, y]), Pose { x_m, y_m, .. }) = (place(step), run.poses()[k]) else {
                    continue;
                };
                said.push(Vector3::new(x, y, 0.0));
                true_at.push(Vector3::new(x_m, y_m, 0.0));
            }
            trials += usize::from(said.len() > before);
        }
    }
    if trials < LEAST_TRIALS {
        return Ok(());
    }
    let median_m = |moved: &dyn Fn(&Vector3<f64>) -> Vector3<f64>| {
        let mut off: Vec<f64> = said
            .iter()
            .zip(&true_at)
            .map(|(a, b)| (moved(a) - b).norm())
            .collect();
        off.sort_by(f64::total_cmp);
        off[off.len() / 2]
    };
    let as_said_m = median_m(&|place| *place);
    if as_said_m <= WRONG_M {
        return Ok(());
    }
    // Places that determine no turn are no frame's fault.
    let Ok(fit) = Alignment::Se2.fit(&said, &true_at) else {
        return Ok(());
    };
    let moved_m = median_m(&|place| fit.rotation * place + fit.translation_m);
    if moved_m >= LEFT * as_said_m {
        return Ok(());
    }
    let turn_deg = fit.rotation[(1, 0)]
        .atan2(fit.rotation[(0, 0)])
        .to_degrees();
    let [x, y] =
        [fit.translation_m.x, fit.translation_m.y].map(|m| (m * 100.0).round() / 100.0 + 0.0); // no -0.00
    Err(Error::work(format!(
        "its answers are in another frame: turned by {turn_deg:.1}° and shifted by ({x:.2}, {y:.2}) m their median error falls from \
         {as_said_m:.2} to {moved_m:.2} m; expected metres in the frame of the mapping part's poses"
    )))
}

#[cfg(test)]
mod tests;
