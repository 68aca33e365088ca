//! How a robot does on a day: trials from starts anywhere.

use super::LifelongConfig;
use crate::{
    belief::{Belief, Places},
    error::Result,
    experiment::{
        adaptation::LabelRecord,
        convergence::{Answers, REPORTED_AT_M, converged_at_m, latest_at},
        trials::{TrialSampling, draw, stretches},
    },
    localiser::LiveLocaliser,
    recording::Recording,
    seed::Seed,
};

/// What came of a robot's day.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Judged {
    /// Mean expected error after 10 m, metres.
    pub error_at_10m_m: f64,
    /// Share of the trials that end up sure and right.
    pub found: f64,
    /// Mean distance until then, metres; a trial that never does counts with its length.
    pub found_after_m: f64,
    /// Mean expected error at each distance, metres, at every `spacing_m`.
    pub curve_m: Vec<f64>,
    /// How it labelled the day, where it did.
    pub labels: Option<LabelRecord>,
}

/// Plays a day's trials with a robot.
pub(super) fn judged(
    robot: &mut LiveLocaliser,
    day: &Recording,
    config: &LifelongConfig,
    seed: Seed,
) -> Result<Judged> {
    let every: Vec<usize> = (0..day.len()).collect();
    let sampling = TrialSampling {
        count: config.trials,
        spacing_m: config.spacing_m,
        shortest_m: config.longest_m,
        longest_m: config.longest_m,
    };
    let stretches = stretches(day, &every, |_| true, f64::INFINITY);
    let trials = draw(day, &stretches, &sampling, seed)?;
    let places = Places::of(day);
    let no_idea = Belief::uniform(robot.grid().places())?;
    let (mut judged, n) = (Judged::default(), trials.len() as f64);
    let steps = (config.longest_m / config.spacing_m).floor() as usize;
    judged.curve_m = vec![0.0; steps + 1];
    for trial in &trials {
        robot.restart(no_idea.clone())?;
        let mut answers = Answers::default();
        for &k in &trial.snapshots {
            robot.observe(&day.observation(k))?;
            let belief = robot.belief();
            answers
                .expected_error_m
                .push(belief.expected_error_m(&places, k));
            answers.point_error_m.push(belief.point_error_m(&places, k));
        }
        let error_at = |distance_m: f64| {
            let latest = latest_at(trial, distance_m, config.spacing_m);
            answers.expected_error_m[latest.unwrap_or(answers.expected_error_m.len() - 1)]
        };
        judged.error_at_10m_m += error_at(REPORTED_AT_M) / n;
        for (step, mean_m) in judged.curve_m.iter_mut().enumerate() {
            *mean_m += error_at(step as f64 * config.spacing_m) / n;
        }
        let found = converged_at_m(trial, &answers);
        judged.found += f64::from(u8::from(found.is_some())) / n;
        judged.found_after_m += found.unwrap_or(config.longest_m) / n;
    }
    Ok(judged)
}
