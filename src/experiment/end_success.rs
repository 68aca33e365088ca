//! How often a robot is where it takes itself to be when a trial ends.

use super::{convergence::Answers, trials::Trial};
use crate::{score::ClusteredMean, seed::Seed};
use serde::{Deserialize, Serialize};

/// Distances that are reported, in metres.
pub const WITHIN_M: [f64; 4] = [0.2, 0.3, 0.5, 1.0];

/// The heading error that is reported, in degrees.
const HEADING_WITHIN_DEG: f64 = 5.0;

/// Share of the trials whose point error after the last snapshot is at most this.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SuccessAtEnd {
    /// Largest point error that counts, in metres.
    pub within_m: f64,
    /// Share of all trials.
    pub share: f64,
    /// Its 95 % interval, by bootstrap over runs or stretches; null where there is only one.
    pub share_ci95: Option<[f64; 2]>,
    /// Share of all trials that end with the heading within 5° of the true one as well; null along a route, and of whole
    /// localisers whose answers have no heading.
    #[serde(default)]
    pub share_within_5deg: Option<f64>,
    /// Its interval.
    #[serde(default)]
    pub share_within_5deg_ci95: Option<[f64; 2]>,
}

/// The shares within each of [`WITHIN_M`]; empty where there is no trial.
pub fn success_at_end(
    trials: &[Trial],
    answers: &[Answers],
    resamples: usize,
    seed: Seed,
) -> Vec<SuccessAtEnd> {
    let within = |metres: f64| {
        let is_near =
            |answers: &Answers| answers.point_error_m.last().is_some_and(|e| *e <= metres);
        let hits: Vec<(usize, bool)> = trials
            .iter()
            .zip(answers)
            .map(|(trial, answers)| (trial.unit, is_near(answers)))
            .collect();
        let both = turned_right(trials, answers).map(|turned| {
            let both = hits.iter().zip(turned);
            both.map(|(&(unit, near), (_, turned))| (unit, near && turned))
        });
        let both =
            both.and_then(|both| ClusteredMean::share(&both.collect::<Vec<_>>(), resamples, seed));
        let near = ClusteredMean::share(&hits, resamples, seed)?;
        Some(SuccessAtEnd {
            within_m: metres,
            share: near.mean,
            share_ci95: near.ci95,
            share_within_5deg: both.map(|both| both.mean),
            share_within_5deg_ci95: both.and_then(|both| both.ci95),
        })
    };
    WITHIN_M.into_iter().filter_map(within).collect()
}

/// Share of the trials whose answer after the last snapshot is turned from the true heading by at most 5°, with its
/// interval; `None` where no answer has a heading: along a route, or of a whole localiser that gives none.
pub fn heading_success(
    trials: &[Trial],
    answers: &[Answers],
    resamples: usize,
    seed: Seed,
) -> Option<ClusteredMean> {
    ClusteredMean::share(&turned_right(trials, answers)?, resamples, seed)
}

/// Of each trial its unit, and does it end within 5°; a trial without an answer does not. `None` where no answer has a heading.
fn turned_right(trials: &[Trial], answers: &[Answers]) -> Option<Vec<(usize, bool)>> {
    let errors = || answers.iter().map(|answers| answers.end_heading_error_rad);
    let is_right = |error: f64| error.to_degrees() <= HEADING_WITHIN_DEG;
    let hits = trials.iter().zip(errors());
    let hits = hits.map(|(trial, error)| (trial.unit, error.is_some_and(is_right)));
    errors()
        .any(|error| error.is_some())
        .then(|| hits.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(share: Option<ClusteredMean>) -> Option<(f64, Option<[f64; 2]>)> {
        share.map(|share| (share.mean, share.ci95))
    }

    fn trial(unit: usize) -> Trial {
        Trial {
            stretch: unit,
            unit,
            snapshots: vec![0, 1],
            travelled_m: vec![0.0, 0.5],
        }
    }

    fn answers(end_m: f64, heading_deg: Option<f64>) -> Answers {
        Answers {
            point_error_m: vec![0.0, end_m],
            end_heading_error_rad: heading_deg.map(f64::to_radians),
            ..Answers::default()
        }
    }

    #[test]
    fn only_the_last_answer_counts() {
        let trials = [trial(0), trial(0), trial(1), trial(1)];
        let all = [
            answers(0.1, Some(1.0)),
            answers(0.25, Some(4.9)),
            answers(0.9, Some(5.1)),
            answers(5.0, Some(90.0)),
        ];
        let rows = success_at_end(&trials, &all, 500, Seed(1));
        let shares: Vec<f64> = rows.iter().map(|row| row.share).collect();
        assert_eq!(shares, [0.25, 0.5, 0.5, 0.75]);
        // One unit has both within 0.3 m, the other none.
        assert_eq!(
            (rows[1].within_m, rows[1].share_ci95),
            (0.3, Some([0.0, 1.0]))
        );
        assert_eq!(
            figures(heading_success(&trials, &all, 500, Seed(1))),
            Some((0.5, Some([0.0, 1.0])))
        );
        let both: Vec<f64> = rows.iter().map(|r| r.share_within_5deg.unwrap()).collect();
        assert_eq!(both, [0.25, 0.5, 0.5, 0.5]); // 0.9 m is near enough, 5.1° is not
        assert_eq!(success_at_end(&[], &[], 500, Seed(1)), []);
        // No answer at the end is no success.
        let some = [answers(0.1, Some(1.0)), answers(9.0, None)];
        let found = figures(heading_success(&[trial(0), trial(0)], &some, 10, Seed(1)));
        assert_eq!(found, Some((0.5, None)));
    }

    #[test]
    fn without_headings_there_is_no_share_of_them() {
        let all = [answers(0.1, None), answers(0.1, None)];
        let found = figures(heading_success(&[trial(0), trial(1)], &all, 10, Seed(1)));
        assert_eq!(found, None);
        let rows = success_at_end(&[trial(0), trial(1)], &all, 10, Seed(1));
        assert!(rows[0].share == 1.0 && rows[0].share_within_5deg.is_none());
    }
}
