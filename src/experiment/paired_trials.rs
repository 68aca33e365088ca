//! Which differences between methods are more than chance, over the same trials.

use super::{
    convergence::{Answers, REPORTED_AT_M, converged_at_m, latest_at},
    trials::Trial,
};
use crate::{score::holm, seed::Seed};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Up to so many units all ways to flip their signs are gone through …
const ENUMERATED_UNITS: usize = 14;
/// … of more, so many are drawn.
const DRAWN: usize = 10_000;
/// With fewer trials than this there is no test.
const FEWEST_TRIALS: usize = 10;
/// Sums that differ by less than this, relative to all there is to sum, differ by rounding only.
const ROUNDING: f64 = 1e-12;

/// A method against the first one, over trials that start anywhere.
///
/// p is two-sided, of the hypothesis that both do equally well (Fisher, *The Design of Experiments*, 1935, §21): the share
/// of all ways to flip the signs of the differences, those of one unit (run or stretch) together, that give a mean at
/// least as far from 0. So p takes trials of one unit for one piece of evidence; with u units it is never below 2/2^u, and
/// with five or fewer never below .05. It is null over fewer than ten trials or fewer than two units. Each of the two
/// figures is corrected for the number of methods (Holm 1979).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PairedTest {
    /// The method.
    pub name: String,
    /// The first method.
    pub against: String,
    /// Mean point error after 10 m, in metres: the method's less the first one's, over the trials that go so far; null where
    /// none does. Negative: the method is better.
    pub error_difference_m: Option<f64>,
    /// Its p.
    pub p: Option<f64>,
    /// The same, corrected.
    pub p_holm: Option<f64>,
    /// Share of trials that converge: the method's less the first one's. Positive: the method is better.
    pub found_difference: Option<f64>,
    /// Its p.
    pub p_found: Option<f64>,
    /// The same, corrected.
    pub p_found_holm: Option<f64>,
}

/// What is compared of a method.
pub(super) struct FiguresOfTrials {
    /// The method's name.
    name: String,
    /// Point error after 10 m, one a trial; none where it isn't so long.
    error_m: Vec<Option<f64>>,
    /// 1 where the trial converged, else 0.
    found: Vec<Option<f64>>,
}

impl FiguresOfTrials {
    /// Of what a method answered from a start anywhere.
    pub(super) fn new(name: &str, trials: &[Trial], answers: &[Answers], spacing_m: f64) -> Self {
        // The first row of the error curve that goes so far.
        let at_m = ((REPORTED_AT_M - 1e-9) / spacing_m).ceil() * spacing_m;
        let both = || trials.iter().zip(answers);
        let error_m = |(trial, answers): (&Trial, &Answers)| {
            Some(answers.point_error_m[latest_at(trial, at_m, spacing_m)?])
        };
        let found = |(trial, answers)| Some(f64::from(converged_at_m(trial, answers).is_some()));
        Self {
            name: name.into(),
            error_m: both().map(error_m).collect(),
            found: both().map(found).collect(),
        }
    }
}

/// Every other method against the first.
pub(super) fn paired_tests(
    methods: &[FiguresOfTrials],
    trials: &[Trial],
    seed: Seed,
) -> Vec<PairedTest> {
    let Some((first, others)) = methods.split_first() else {
        return Vec::new();
    };
    let tested = |figure: fn(&FiguresOfTrials) -> &[Option<f64>]| {
        let of = |other| test(trials, figure(other), figure(first), seed);
        let (differences, p): (Vec<_>, Vec<_>) = others.iter().map(of).unzip();
        let corrected = holm(&p);
        (differences, p, corrected)
    };
    let (error, p, p_holm) = tested(|method| &method.error_m);
    let (found, p_found, p_found_holm) = tested(|method| &method.found);
    let all = others.iter().enumerate();
    all.map(|(i, other)| PairedTest {
        name: other.name.clone(),
        against: first.name.clone(),
        error_difference_m: error[i],
        p: p[i],
        p_holm: p_holm[i],
        found_difference: found[i],
        p_found: p_found[i],
        p_found_holm: p_found_holm[i],
    })
    .collect()
}

/// Mean difference over the trials where both have a figure, and its p.
fn test(
    trials: &[Trial],
    other: &[Option<f64>],
    first: &[Option<f64>],
    seed: Seed,
) -> (Option<f64>, Option<f64>) {
    let mut units: BTreeMap<usize, f64> = BTreeMap::new();
    let mut count = 0;
    for (trial, (other, first)) in trials.iter().zip(other.iter().zip(first)) {
        if let (Some(other), Some(first)) = (other, first) {
            *units.entry(trial.unit).or_default() += other - first;
            count += 1;
        }
    }
    let sums: Vec<f64> = units.into_values().collect();
    let mean = (count > 0).then(|| sums.iter().sum::<f64>() / count as f64);
    let is_tested = count >= FEWEST_TRIALS && sums.len() >= 2;
    (mean, is_tested.then(|| sign_flip_p(&sums, seed)))
}

/// Share of the ways to flip signs that give a sum at least as far from 0 as these sums of units together; where ways are
/// drawn, the observed one is counted as well (Phipson & Smyth, *Permutation p-values should never be zero*, 2010).
fn sign_flip_p(sums: &[f64], seed: Seed) -> f64 {
    let scale: f64 = sums.iter().map(|sum| sum.abs()).sum();
    let observed = sums.iter().sum::<f64>().abs() - ROUNDING * scale;
    let is_as_far = |is_flipped: &mut dyn FnMut(usize) -> bool| {
        let signed = sums.iter().enumerate();
        let signed = signed.map(|(unit, sum)| if is_flipped(unit) { -sum } else { *sum });
        signed.sum::<f64>().abs() >= observed
    };
    if sums.len() <= ENUMERATED_UNITS {
        let ways = 1_usize << sums.len();
        let as_far = (0..ways).filter(|way| is_as_far(&mut |unit| (way >> unit) & 1 == 1));
        return as_far.count() as f64 / ways as f64;
    }
    let mut random = seed.stream("signs of units");
    let as_far = (0..DRAWN).filter(|_| is_as_far(&mut |_| random.random()));
    (1 + as_far.count()) as f64 / (1 + DRAWN) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two trials of 12 m in each of so many stretches.
    fn trials(units: usize) -> Vec<Trial> {
        let of = |k: usize| Trial {
            stretch: k / 2,
            unit: k / 2,
            snapshots: (0..25).collect(),
            travelled_m: (0..25).map(|i| f64::from(i) * 0.5).collect(),
        };
        (0..2 * units).map(of).collect()
    }

    /// Always so far off; sure or never.
    fn method(name: &str, trials: &[Trial], point_m: f64, expected_m: f64) -> FiguresOfTrials {
        let answers = Answers {
            expected_error_m: vec![expected_m; 25],
            point_error_m: vec![point_m; 25],
            ..Answers::default()
        };
        FiguresOfTrials::new(name, trials, &vec![answers; trials.len()], 0.5)
    }

    #[test]
    fn every_other_is_tested_against_the_first_and_corrected() {
        let trials = trials(6);
        let all = [
            method("a", &trials, 0.5, 0.1),
            method("b", &trials, 0.75, 0.1),
            method("c", &trials, 0.5, 9.0),
        ];
        let tests = paired_tests(&all, &trials, Seed(1));
        assert_eq!(tests.len(), 2);
        let [b, c] = [&tests[0], &tests[1]];
        assert_eq!((&*b.name, &*b.against), ("b", "a"));
        // Worse in all six stretches: two of 64 ways are as far; twice that, of two tests.
        assert_eq!(b.error_difference_m, Some(0.25));
        assert_eq!((b.p, b.p_holm), (Some(2.0 / 64.0), Some(4.0 / 64.0)));
        assert_eq!((b.found_difference, b.p_found), (Some(0.0), Some(1.0)));
        assert_eq!((c.error_difference_m, c.p), (Some(0.0), Some(1.0)));
        assert_eq!(
            (c.found_difference, c.p_found),
            (Some(-1.0), Some(2.0 / 64.0))
        );
        assert_eq!(
            (c.p_found_holm, b.p_found_holm),
            (Some(4.0 / 64.0), Some(1.0))
        );
    }

    #[test]
    fn few_trials_or_one_unit_have_no_p_and_short_trials_no_error() {
        let mut one_unit = trials(6);
        one_unit.iter_mut().for_each(|trial| trial.unit = 0);
        for trials in [trials(4), one_unit] {
            let all = [
                method("a", &trials, 0.5, 0.1),
                method("b", &trials, 1.0, 0.1),
            ];
            let tests = paired_tests(&all, &trials, Seed(1));
            assert_eq!(tests[0].error_difference_m, Some(0.5));
            assert_eq!(
                (tests[0].p, tests[0].p_holm, tests[0].p_found),
                (None, None, None)
            );
        }
        let mut short = trials(6);
        short
            .iter_mut()
            .for_each(|trial| trial.travelled_m.truncate(15)); // 7 m
        let all = [method("a", &short, 0.5, 0.1), method("b", &short, 1.0, 0.1)];
        let tests = paired_tests(&all, &short, Seed(1));
        assert_eq!((tests[0].error_difference_m, tests[0].p), (None, None));
        assert_eq!(tests[0].found_difference, Some(0.0));
        assert!(paired_tests(&[], &short, Seed(1)).is_empty());
    }

    /// ±4 ±1 ±2 is at least as far from 0 as 4 + 1 − 2 in six of eight ways: 7, 3 and 5, and their negatives.
    #[test]
    fn ways_to_flip_signs_by_hand() {
        assert_eq!(sign_flip_p(&[4.0, 1.0, -2.0], Seed(1)), 0.75);
        // Of fifteen units eleven on one side: 2 · P(Binomial(15, ½) ≥ 11) = 2 · 1941/32768, from drawn ways nearly.
        let sums: Vec<f64> = (0..15).map(|u| if u < 11 { 1.0 } else { -1.0 }).collect();
        let p = sign_flip_p(&sums, Seed(3));
        assert!((p - 2.0 * 1941.0 / 32768.0).abs() < 0.01, "{p}");
    }
}
