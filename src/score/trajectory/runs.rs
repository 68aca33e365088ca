//! Several runs of one localiser, each evaluated on its own and all of them together.

use super::{Evaluation, RunTraces};
use crate::{
    error::Result,
    geometry::{Pose, wrapped},
    score::prediction_correction::{MetricOptions, PredictionCorrection, Traces},
};
use serde::Serialize;

/// What the poses of a run tell of its conditions (R06 3.1 and 3.2: frequencies, trajectory, numbers of samples).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RunFacts {
    /// Real poses that an estimate is compared with.
    pub poses: usize,
    /// Length of the way from one to the next, in metres.
    pub way_m: f64,
    /// Seconds from the first to the last; none without stamps.
    pub duration_s: Option<f64>,
    /// Estimates a metre; none where the robot did not move.
    pub per_m: Option<f64>,
    /// Estimates a second; none without stamps.
    pub per_s: Option<f64>,
    /// Metres a second; none without stamps.
    pub speed_m_per_s: Option<f64>,
    /// Degrees of turning a metre, either way; none where the robot did not move.
    pub turning_deg_per_m: Option<f64>,
    /// Extent of the real poses along x and y, in metres.
    pub extent_m: [f64; 2],
}

impl RunFacts {
    /// Of the compared poses of a run.
    pub fn of(traces: &RunTraces) -> Self {
        let real = &traces.real;
        let sum = |of: fn(&Pose, &Pose) -> f64| -> f64 {
            real.windows(2).map(|pair| of(&pair[0], &pair[1])).sum()
        };
        let way_m = sum(|a, b| a.distance_m(b));
        let turned_deg = sum(|a, b| wrapped(b.heading_rad - a.heading_rad).abs()).to_degrees();
        let stamps = traces.stamp_s.as_deref();
        let ends = stamps.and_then(|stamps| Some((stamps.first()?, stamps.last()?)));
        let duration_s = ends.map(|(first, last)| last - first);
        let steps = real.len().saturating_sub(1) as f64;
        let a_metre = |value: f64| (way_m > 0.0).then(|| value / way_m);
        let a_second = |value: f64| duration_s.filter(|&s| s > 0.0).map(|s| value / s);
        let extent = |axis: fn(&Pose) -> f64| {
            let ends = real.iter().map(axis);
            let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
            (high - low).max(0.0)
        };
        Self {
            poses: real.len(),
            way_m,
            duration_s,
            per_m: a_metre(steps),
            per_s: a_second(steps),
            speed_m_per_s: a_second(way_m),
            turning_deg_per_m: a_metre(turned_deg),
            extent_m: [extent(|pose| pose.x_m), extent(|pose| pose.y_m)],
        }
    }
}

/// One run of several.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RunEvaluation {
    /// What it is called.
    pub name: String,
    /// What its poses tell of its conditions.
    pub facts: RunFacts,
    /// Its errors.
    #[serde(flatten)]
    pub evaluation: Evaluation,
}

/// Several runs, apart and together.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct RunsEvaluation {
    /// Each on its own.
    pub runs: Vec<RunEvaluation>,
    /// The prediction–correction metric of all runs whose estimates before correction are known, run by run and as the union of their
    /// distributions (R06 3.3, 3.4); none where there is no such run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub prediction_correction: Option<PredictionCorrection>,
}

impl RunsEvaluation {
    /// Of runs by name.
    ///
    /// # Errors
    /// Where the metric can't be worked out.
    pub fn of(runs: Vec<(String, Evaluation)>, options: &MetricOptions) -> Result<Self> {
        let known: Vec<(&str, [Vec<Pose>; 3])> = runs
            .iter()
            .map(|(name, evaluation)| (name.as_str(), evaluation.traces.with_prior()))
            .filter(|(_, [real, ..])| !real.is_empty())
            .collect();
        let traces: Vec<Traces> = known
            .iter()
            .map(|(name, [real, prior, posterior])| Traces {
                name,
                real,
                prior,
                posterior,
            })
            .collect();
        let prediction_correction = match traces.is_empty() {
            true => None,
            false => Some(PredictionCorrection::of(&traces, options)?),
        };
        let runs = runs.into_iter().map(|(name, evaluation)| RunEvaluation {
            name,
            facts: RunFacts::of(&evaluation.traces),
            evaluation,
        });
        Ok(Self {
            runs: runs.collect(),
            prediction_correction,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::trajectory::{EvaluationOptions, Trajectory, evaluate};
    use std::f64::consts::FRAC_PI_2;

    /// Three metres east in six seconds, a quarter turn, two metres north in four.
    fn corner(off_m: f64) -> Trajectory {
        let east = (0..4).map(|k| Pose::new(f64::from(k), off_m, 0.0));
        let north = (1..3).map(|k| Pose::new(3.0, f64::from(k) + off_m, FRAC_PI_2));
        let poses: Vec<Pose> = east.chain(north).collect();
        let stamps = (0..6).map(|k| 2.0 * f64::from(k)).collect();
        Trajectory::in_plane(format!("off {off_m}"), Some(stamps), &poses).unwrap()
    }

    #[test]
    fn facts_by_hand() {
        let options = EvaluationOptions::default();
        let evaluation = evaluate(&corner(0.2), &corner(0.0), None, &options).unwrap();
        let facts = RunFacts::of(&evaluation.traces);
        assert_eq!((facts.poses, facts.way_m), (6, 5.0));
        assert_eq!((facts.duration_s, facts.per_s), (Some(10.0), Some(0.5)));
        assert_eq!((facts.per_m, facts.speed_m_per_s), (Some(1.0), Some(0.5)));
        assert!((facts.turning_deg_per_m.unwrap() - 18.0).abs() < 1e-9);
        assert_eq!(facts.extent_m, [3.0, 2.0]);
    }

    #[test]
    fn runs_without_a_prior_are_judged_by_their_errors_alone() {
        let options = EvaluationOptions::default();
        let judged = |off: f64, prior: Option<f64>| {
            let prior = prior.map(corner);
            evaluate(&corner(off), &corner(0.0), prior.as_ref(), &options).unwrap()
        };
        let runs = vec![
            ("R1".to_string(), judged(0.1, Some(0.4))),
            ("R2".to_string(), judged(0.3, None)),
            ("R3".to_string(), judged(0.5, Some(0.4))),
        ];
        let all = RunsEvaluation::of(runs, &options.metric).unwrap();
        let metric = all.prediction_correction.unwrap();
        assert_eq!(
            (all.runs.len(), metric.runs.len(), metric.overall.n),
            (3, 2, 12)
        );
        let position = &metric.overall.correction.position;
        assert_eq!((position.improved, position.worsened), (6, 6));
        let none = RunsEvaluation::of(vec![("R2".into(), judged(0.3, None))], &options.metric);
        assert!(none.unwrap().prediction_correction.is_none());
    }
}
