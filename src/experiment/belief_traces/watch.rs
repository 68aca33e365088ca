//! Watching the systems of a comparison play a few trials once more.

use super::{
    MOST_CELLS,
    record::{BeliefTraces, ErrorsAt, Plan, TracedSystem, TracedTrial, packed},
    squares::Squares,
};
use crate::{
    belief::{Belief, Places},
    error::Result,
    experiment::{
        convergence::{Answers, REPORTED_AT_M},
        method::{AnswersBy, Method},
        methods::MethodContext,
        sequences::motion,
        trial_play::{estimate, scaled, scaled_sensor, stream},
        trials::Trial,
    },
    geometry::Pose,
    localiser::{
        BayesLocaliser, LostConfig, PreparedSensorModel, Step, sensor_model::EvidenceScale,
    },
};
use std::collections::BTreeMap;

/// Most steps of a trial that are kept: its first ones.
const MOST_STEPS: usize = 200;

/// Most letters that kept beliefs take all together: trials beyond that are left out, the last ones first.
const MOST_LETTERS: usize = 2_500_000;

/// What was seen so far.
pub(in crate::experiment) struct Watch<'a> {
    context: &'a MethodContext<'a>,
    trials: &'a [Trial],
    squares: Squares,
    traces: BeliefTraces,
    /// Steps and sum of each system's errors, by the number of the square metre.
    errors: BTreeMap<[i64; 2], Vec<(usize, f64)>>,
}

impl<'a> Watch<'a> {
    /// Of these trials, with nobody seen yet.
    pub fn new(context: &'a MethodContext<'a>, trials: &'a [Trial]) -> Self {
        let squares = Squares::over(&context.grid, MOST_CELLS);
        let traces = BeliefTraces {
            is_route: matches!(context.parts.places, Places::Route(_)),
            cell_m: rounded(squares.cell_m),
            cells: squares.centres.iter().map(|c| all_rounded(c)).collect(),
            plan: None,
            trials: Vec::new(),
            systems: Vec::new(),
            errors: Vec::new(),
        };
        Self {
            context,
            trials,
            squares,
            traces,
            errors: BTreeMap::new(),
        }
    }

    /// Notes how a method played all trials from a start anywhere, and lets it play the kept ones again, which gives the same answers.
    ///
    /// # Errors
    /// Where the method fails.
    pub fn note(
        &mut self,
        method: &Method,
        answers: &[Answers],
        scale: Option<EvidenceScale>,
        lost: Option<&LostConfig>,
    ) -> Result<()> {
        if self.traces.trials.is_empty() {
            self.traces.trials = chosen(self.trials, answers, &method.title)
                .into_iter()
                .map(|(number, kept_as)| self.kept(number, kept_as))
                .collect();
        }
        if let (None, Some(map)) = (&self.traces.plan, &method.plan) {
            self.traces.plan = Some(Plan::of(map));
        }
        let numbers: Vec<usize> = self.traces.trials.iter().map(|t| t.number).collect();
        let seen = self.played_again(method, &numbers, scale)?;
        for ((number, (mass, answer, entropy)), trial) in
            numbers.into_iter().zip(seen).zip(&mut self.traces.trials)
        {
            let answers = &answers[number];
            trial.systems.push(TracedSystem {
                expected_error_m: all_rounded(&answers.expected_error_m[..answer.len()]),
                point_error_m: all_rounded(&answers.point_error_m[..answer.len()]),
                is_lost: is_lost(answers, lost, answer.len()),
                answer,
                entropy_nats: entropy,
                mass: packed_levels(&mass),
            });
        }
        self.note_errors(answers);
        let names = [method.name.clone(), method.title.clone()];
        self.traces.systems.push(names);
        Ok(())
    }

    /// All that was seen.
    pub fn finished(mut self) -> BeliefTraces {
        let dimensions = if self.traces.is_route { 1 } else { 2 };
        let of_square = |(square, errors): ([i64; 2], Vec<(usize, f64)>)| ErrorsAt {
            at: square[..dimensions]
                .iter()
                .map(|n| *n as f64 + 0.5)
                .collect(),
            steps: errors.iter().map(|(steps, _)| *steps).max().unwrap_or(0),
            point_error_m: errors
                .iter()
                .map(|(steps, sum)| (*steps > 0).then(|| rounded(sum / *steps as f64)))
                .collect(),
        };
        let letters = |traces: &BeliefTraces| -> usize {
            let systems = traces.trials.iter().flat_map(|trial| &trial.systems);
            systems.map(|system| system.mass.len()).sum()
        };
        while self.traces.trials.len() > 1 && letters(&self.traces) > MOST_LETTERS {
            self.traces.trials.pop();
        }
        self.traces.errors = self.errors.into_iter().map(of_square).collect();
        self.traces
    }

    /// A trial that nobody was seen in yet.
    fn kept(&self, number: usize, kept_as: Vec<String>) -> TracedTrial {
        let trial = &self.trials[number];
        let snapshots = self.snapshots(number);
        let truth = snapshots.iter().map(|&k| self.truth(k));
        TracedTrial {
            number,
            kept_as,
            snapshots: snapshots.to_vec(),
            travelled_m: all_rounded(&trial.travelled_m[..snapshots.len()]),
            truth: truth.collect(),
            systems: Vec::new(),
        }
    }

    /// The snapshots of a trial that are kept.
    fn snapshots(&self, number: usize) -> &'a [usize] {
        let all = &self.trials[number].snapshots;
        &all[..all.len().min(MOST_STEPS)]
    }

    /// Where the robot is at a snapshot.
    fn truth(&self, k: usize) -> Vec<f64> {
        match &self.context.parts.places {
            Places::Route(route) => vec![rounded(route[k])],
            Places::Plane(poses) => of_pose(&poses[k]),
        }
    }

    fn note_errors(&mut self, answers: &[Answers]) {
        let (system, places) = (self.traces.systems.len(), &self.context.parts.places);
        for (trial, answers) in self.trials.iter().zip(answers) {
            let steps = trial.snapshots.iter().zip(&trial.travelled_m);
            for ((&k, metres), error_m) in steps.zip(&answers.point_error_m) {
                if *metres < REPORTED_AT_M - 1e-9 {
                    continue;
                }
                let square = match places {
                    Places::Route(route) => [route[k].floor() as i64, 0],
                    Places::Plane(poses) => [poses[k].x_m, poses[k].y_m].map(|m| m.floor() as i64),
                };
                let here = self.errors.entry(square).or_default();
                here.resize(system + 1, (0, 0.0));
                here[system].0 += 1;
                here[system].1 += error_m;
            }
        }
    }

    /// Of each of these trials what squares held, the answers, and the entropy, one a step.
    fn played_again(
        &self,
        method: &Method,
        numbers: &[usize],
        scale: Option<EvidenceScale>,
    ) -> Result<Vec<Seen>> {
        let (context, parts) = (self.context, self.context.parts);
        let mut snapshots: Vec<usize> = numbers
            .iter()
            .flat_map(|&number| self.snapshots(number).iter().copied())
            .collect();
        snapshots.sort_unstable();
        snapshots.dedup();
        let with = |sensor: Option<&dyn PreparedSensorModel>| {
            let sensor = scaled_sensor(sensor, scale);
            let sensor = sensor.as_ref().map(|s| s as &dyn PreparedSensorModel);
            let by_filter = |&number: &usize| self.by_filter(method, number, sensor);
            numbers.iter().map(by_filter).collect()
        };
        match &method.answers {
            AnswersBy::Nobody(_) => Ok(Vec::new()),
            AnswersBy::Odometry => with(None),
            AnswersBy::PreparedSensor(prepared) => with(Some(prepared.as_ref())),
            AnswersBy::Sensor(model) => {
                let prepared = model.prepare(parts.run, &snapshots)?;
                with(Some(prepared.as_ref()))
            }
            AnswersBy::Recorded(recorded) => {
                let steps = |number: usize| &recorded.anywhere[number];
                let kept = |number: usize| &steps(number)[..self.snapshots(number).len()];
                numbers
                    .iter()
                    .map(|&number| self.by_steps(kept(number)))
                    .collect()
            }
            AnswersBy::Localiser(localiser) => {
                let scaled = scaled(localiser.as_ref(), scale);
                let localiser = scaled.as_deref().unwrap_or(localiser.as_ref());
                let player = localiser.prepare(context.parts.run, &snapshots)?;
                let by_localiser = |&number: &usize| {
                    let mut stream = stream(context, number);
                    self.by_steps(&player.play(self.snapshots(number), None, &mut stream)?)
                };
                numbers.iter().map(by_localiser).collect()
            }
        }
    }

    /// Of somebody who is no grid filter.
    fn by_steps(&self, steps: &[Step]) -> Result<Seen> {
        let mut seen = Seen::default();
        for step in steps {
            if !self.traces.is_route && !step.posterior.is_empty() {
                seen.0.push(self.squares.of_places(&step.posterior));
            }
            let place = estimate(step)?.filter(|_| !self.traces.is_route);
            let heading = step.heading_rad.into_iter();
            seen.1
                .push(place.map(|p| all_rounded_of(p.into_iter().chain(heading))));
            seen.2.push(None);
        }
        Ok(seen)
    }

    fn by_filter(
        &self,
        method: &Method,
        number: usize,
        sensor: Option<&dyn PreparedSensorModel>,
    ) -> Result<Seen> {
        let (context, grid) = (self.context, &self.context.grid);
        let start = Belief::uniform(grid.places())?;
        let (motion, stream) = (motion(method, context), stream(context, number));
        let mut robot = BayesLocaliser::new(grid, motion, start, sensor, stream)?;
        if let Some(restart) = &context.config.restart {
            robot = robot.restarting(restart)?;
        }
        let mut seen = Seen::default();
        for &k in self.snapshots(number) {
            let belief = robot.observe(k, &context.parts.run.observation(k))?;
            let mode = belief.mode();
            seen.0.push(self.squares.of_belief(belief));
            seen.1.push(Some(match &**grid.places() {
                Places::Route(route) => vec![rounded(route[mode])],
                Places::Plane(poses) => of_pose(&Pose {
                    heading_rad: belief.mode_heading_rad(),
                    ..poses[mode]
                }),
            }));
            seen.2.push(Some(rounded(belief.entropy())));
        }
        Ok(seen)
    }
}

/// What squares held, the answers, and the entropy, one a step.
type Seen = (Vec<Vec<u8>>, Vec<Option<Vec<f64>>>, Vec<Option<f64>>);

/// The first trial, and those in which the mean expected error of these answers is least and largest, each with why it is kept.
fn chosen(trials: &[Trial], answers: &[Answers], title: &str) -> Vec<(usize, Vec<String>)> {
    let mean = |number: &usize| {
        let errors = &answers[*number].expected_error_m;
        errors.iter().sum::<f64>() / errors.len().max(1) as f64
    };
    let all = || 0..trials.len().min(answers.len());
    let least = all().min_by(|a, b| mean(a).total_cmp(&mean(b)));
    let most = all().min_by(|a, b| mean(b).total_cmp(&mean(a)));
    let mut kept: BTreeMap<(usize, usize), Vec<String>> = BTreeMap::new();
    let mut rank = BTreeMap::new();
    for (number, why) in [
        (all().next(), "the first".to_string()),
        (least, format!("the best of {title}")),
        (most, format!("the worst of {title}")),
    ] {
        if let Some(number) = number {
            let next = rank.len();
            let place = *rank.entry(number).or_insert(next);
            kept.entry((place, number)).or_default().push(why);
        }
    }
    kept.into_iter().map(|((_, n), why)| (n, why)).collect()
}

/// After which steps the robot says that it is lost, as [`confidence`](crate::experiment::confidence) counts it.
fn is_lost(answers: &Answers, lost: Option<&LostConfig>, steps: usize) -> Vec<Option<bool>> {
    let usual = LostConfig::default();
    let threshold = lost.unwrap_or(&usual).threshold;
    let of_step = |step| Some(answers.sureness.score(step, lost)? >= threshold);
    (0..steps).map(of_step).collect()
}

fn packed_levels(steps: &[Vec<u8>]) -> String {
    match steps {
        [] => String::new(),
        steps => packed(&steps.concat()),
    }
}

/// To the millimetre, or the thousandth: what a reader sees of it, in few letters.
fn rounded(value: f64) -> f64 {
    (value * 1000.0).round() / 1000.0
}

fn all_rounded(values: &[f64]) -> Vec<f64> {
    all_rounded_of(values.iter().copied())
}

fn all_rounded_of(values: impl Iterator<Item = f64>) -> Vec<f64> {
    values.map(rounded).collect()
}

fn of_pose(pose: &Pose) -> Vec<f64> {
    all_rounded(&[pose.x_m, pose.y_m, pose.heading_rad])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_the_best_and_the_worst_are_kept_each_once() {
        let trial = Trial {
            stretch: 0,
            unit: 0,
            snapshots: vec![0],
            travelled_m: vec![0.0],
        };
        let kept = |errors: &[f64]| {
            let answers = errors.iter().map(|&error_m| Answers {
                expected_error_m: vec![error_m],
                ..Answers::default()
            });
            let answers: Vec<Answers> = answers.collect();
            let kept = chosen(&vec![trial.clone(); errors.len()], &answers, "x");
            let short = |why: Vec<String>| why.join(", ").replace("the ", "").replace(" of x", "");
            let all = kept.into_iter().map(|(number, why)| (number, short(why)));
            all.collect::<Vec<_>>()
        };
        let is = |number: usize, why: &str| (number, why.to_string());
        assert_eq!(
            kept(&[2.0, 9.0, 1.0]),
            [is(0, "first"), is(2, "best"), is(1, "worst")]
        );
        assert_eq!(kept(&[1.0, 9.0]), [is(0, "first, best"), is(1, "worst")]);
        assert_eq!(kept(&[1.0]), [is(0, "first, best, worst")]);
    }
}
