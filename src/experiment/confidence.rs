//! Does a method know when it is lost, and is its belief as sure as it may be? Judged over all steps of trials that start anywhere.

use super::{convergence::Answers, trials::Trial};
use crate::{
    localiser::{LostConfig, lost::NEAR_M},
    score::{Auroc, ClusteredMean},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// A place that the belief gives less than this counts as if it had so much: what no float holds would outweigh all the rest.
pub const LEAST_MASS: f64 = 1e-9;

/// How a method's confidence did on unseen runs. A step is lost where its point estimate is more than 1 m from the truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Confidence {
    /// Steps of all trials.
    pub steps: usize,
    /// Share of them that are lost.
    pub lost: f64,
    /// Mean −ln of what the belief gives to the place of the truth, one cell wide, any heading, in nats a step; what is below
    /// 10⁻⁹ counts as 10⁻⁹.
    pub nats_of_true_place: Option<f64>,
    /// Its 95 % interval, by bootstrap over runs or stretches.
    pub nats_of_true_place_ci95: Option<[f64; 2]>,
    /// The same of a robot that has no idea: ln of the number of places.
    pub nats_of_no_idea: f64,
    /// Area under the receiver operating characteristic of the lost score against lost steps; null where all steps are of one kind.
    pub lost_auroc: Option<Auroc>,
    /// The same of the belief's own word alone, its mass within 1 m of the estimate.
    pub mass_auroc: Option<Auroc>,
    /// What makes the lost score, fitted on the validation part; null where it is 1 less that mass.
    pub score: Option<LostConfig>,
    /// Threshold of the score from which on the robot says that it is lost.
    pub threshold: f64,
    /// Share of the steps after which it says so.
    pub flagged: f64,
    /// Share of lost steps among all others, where it says nothing: the risk; null where it always says so.
    pub risk: Option<f64>,
    /// Its 95 % interval.
    pub risk_ci95: Option<[f64; 2]>,
    /// Share of the lost steps at which it says so; null where none is lost.
    pub caught: Option<f64>,
    /// Mean entropy of the belief at a trial's end, in nats; null for whole localisers.
    pub end_entropy_nats: Option<f64>,
    /// Mean number of modes at a trial's end, places 1 m around that hold a twentieth or more; null for whole localisers.
    pub end_modes: Option<f64>,
}

/// One step.
pub(super) struct ScoredStep {
    pub unit: usize,
    pub is_lost: bool,
    pub score: f64,
    pub near_mass: f64,
}

/// The steps of trials with their scores; none where some answer comes without a belief.
pub(super) fn scored(
    trials: &[Trial],
    answers: &[Answers],
    score: Option<&LostConfig>,
) -> Option<Vec<ScoredStep>> {
    let mut steps = Vec::new();
    for (trial, answers) in trials.iter().zip(answers) {
        let sureness = &answers.sureness;
        if sureness.near_mass.len() != answers.point_error_m.len() {
            return None;
        }
        for (step, (&error_m, &near_mass)) in answers
            .point_error_m
            .iter()
            .zip(&sureness.near_mass)
            .enumerate()
        {
            steps.push(ScoredStep {
                unit: trial.unit,
                is_lost: error_m > NEAR_M,
                score: sureness.score(step, score)?,
                near_mass,
            });
        }
    }
    (!steps.is_empty()).then_some(steps)
}

/// The areas of the score and of the mass alone.
pub(super) fn areas(
    steps: &[ScoredStep],
    resamples: usize,
    seed: Seed,
) -> (Option<Auroc>, Option<Auroc>) {
    let of = |score: fn(&ScoredStep) -> f64| {
        let points = steps
            .iter()
            .map(|step| (step.unit, step.is_lost, score(step)));
        Auroc::of(&points.collect::<Vec<_>>(), resamples, seed)
    };
    (of(|step| step.score), of(|step| 1.0 - step.near_mass))
}

/// The figures of answers from a start anywhere; none where they come without a belief. `places` is their number on the grid,
/// headings aside.
pub(super) fn confidence(
    trials: &[Trial],
    answers: &[Answers],
    score: Option<LostConfig>,
    places: usize,
    resamples: usize,
    seed: Seed,
) -> Option<Confidence> {
    let steps = scored(trials, answers, score.as_ref())?;
    let of_truth = |(trial, answers): (&Trial, &Answers)| {
        let unit = trial.unit;
        let masses = answers.sureness.true_place_mass.iter().flatten();
        let nats = masses.map(|mass| (unit, -mass.max(LEAST_MASS).ln()));
        nats.collect::<Vec<_>>()
    };
    let nats: Vec<(usize, f64)> = trials.iter().zip(answers).flat_map(of_truth).collect();
    let nats = ClusteredMean::of(&nats, resamples, seed);
    let (lost_auroc, mass_auroc) = areas(&steps, resamples, seed);
    let threshold = score
        .as_ref()
        .map_or(LostConfig::default().threshold, |score| score.threshold);
    let is_flagged = |step: &&ScoredStep| step.score >= threshold;
    let (count, lost) = (steps.len() as f64, steps.iter().filter(|step| step.is_lost));
    let (lost, caught) = (lost.clone().count(), lost.filter(is_flagged).count());
    let flagged = steps.iter().filter(is_flagged).count();
    let others = steps.iter().filter(|step| !is_flagged(step));
    let others: Vec<(usize, bool)> = others.map(|step| (step.unit, step.is_lost)).collect();
    let risk = ClusteredMean::share(&others, resamples, seed);
    let mean = |of: &dyn Fn(&Answers) -> Option<f64>| {
        let all = answers.iter().map(of).collect::<Option<Vec<f64>>>()?;
        Some(all.iter().sum::<f64>() / all.len() as f64)
    };
    Some(Confidence {
        steps: steps.len(),
        lost: lost as f64 / count,
        nats_of_true_place: nats.map(|nats| nats.mean),
        nats_of_true_place_ci95: nats.and_then(|nats| nats.ci95),
        nats_of_no_idea: (places as f64).ln(),
        lost_auroc,
        mass_auroc,
        threshold,
        flagged: flagged as f64 / count,
        risk: risk.map(|risk| risk.mean),
        risk_ci95: risk.and_then(|risk| risk.ci95),
        caught: (lost > 0).then(|| caught as f64 / lost as f64),
        end_entropy_nats: mean(&|answers| answers.sureness.end_entropy_nats),
        end_modes: mean(&|answers| answers.sureness.end_modes.map(|modes| modes as f64)),
        score,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::sureness::Sureness;

    fn trial(unit: usize) -> Trial {
        Trial {
            stretch: unit,
            unit,
            snapshots: vec![0, 1, 2],
            travelled_m: vec![0.0, 0.5, 1.0],
        }
    }

    fn answers(error_m: [f64; 3], near: [f64; 3], ratios: [f64; 3]) -> Answers {
        Answers {
            point_error_m: error_m.to_vec(),
            sureness: Sureness {
                near_mass: near.to_vec(),
                ratios: ratios.iter().map(|ratio| vec![*ratio]).collect(),
                true_place_mass: vec![Some(0.25), Some(0.0), None],
                end_entropy_nats: Some(1.5),
                end_modes: Some(2),
            },
            ..Answers::default()
        }
    }

    fn both() -> [Answers; 2] {
        [
            answers([5.0, 0.5, 0.5], [0.1, 0.9, 0.9], [0.0, 2.0, 2.0]),
            answers([0.5, 7.0, 7.0], [0.9, 0.95, 0.95], [2.0, -2.0, -2.0]),
        ]
    }

    /// Of the second run the robot is sure and wrong; only the sensors tell.
    #[test]
    fn the_score_tells_what_mass_alone_does_not() {
        let score = LostConfig {
            base: 0.0,
            slope: 2.0,
            threshold: 0.5,
            ..LostConfig::default()
        };
        let figures = |score| confidence(&[trial(0), trial(1)], &both(), score, 40, 200, Seed(1));
        let judged = figures(Some(score)).unwrap();
        assert_eq!((judged.steps, judged.lost), (6, 0.5));
        assert_eq!(judged.lost_auroc.unwrap().value, 1.0);
        // 1 − .1 lies above all three right ones, 1 − .95 below them.
        assert!((judged.mass_auroc.unwrap().value - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!((judged.flagged, judged.caught), (0.5, Some(1.0)));
        assert_eq!(judged.risk, Some(0.0));
        let expected = 0.5 * (4f64.ln() + 9.0 * 10f64.ln());
        assert!((judged.nats_of_true_place.unwrap() - expected).abs() < 1e-9);
        assert!((judged.nats_of_no_idea - 40f64.ln()).abs() < 1e-12);
        assert_eq!(
            (judged.end_entropy_nats, judged.end_modes),
            (Some(1.5), Some(2.0))
        );

        let alone = figures(None).unwrap();
        assert_eq!(alone.lost_auroc, alone.mass_auroc);
        assert_eq!((alone.threshold, alone.caught), (0.5, Some(1.0 / 3.0)));
        assert!((alone.risk.unwrap() - 0.4).abs() < 1e-12);
    }

    #[test]
    fn without_a_belief_there_is_nothing_to_judge() {
        let mut answers = both();
        answers[1].sureness = Sureness::default();
        let judged = confidence(&[trial(0), trial(1)], &answers, None, 40, 200, Seed(1));
        assert_eq!(judged, None);
        assert_eq!(confidence(&[], &[], None, 40, 200, Seed(1)), None);
    }
}
