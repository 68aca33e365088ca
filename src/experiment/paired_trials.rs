//! Which differences between methods are more than chance, over the same trials.

use super::{
    convergence::{Answers, REPORTED_AT_M, converged_at_m, latest_at},
    trials::Trial,
};
use crate::{
    score::{ClusteredMean, holm},
    seed::Seed,
};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Up to so many units all ways to flip their signs are gone through …
const ENUMERATED_UNITS: usize = 14;
/// … of more, so many are drawn.
const DRAWN: usize = 10_000;
/// A difference of less p than this is more than chance.
pub const SURE_P: f64 = 0.05;
/// Sums that differ by less than this, relative to all there is to sum, differ by rounding only.
const ROUNDING: f64 = 1e-12;

/// A method against the first one, over trials that start anywhere.
///
/// p is two-sided, of the hypothesis that both do equally well (Fisher, *The Design of Experiments*, 1935, §21): the share
/// of all ways to flip the signs of the differences, those of one unit (run or stretch) together, that give a mean at
/// least as far from 0. So p takes trials of one unit for one piece of evidence: with u units it is never below 2/2^u, which
/// of ten tests together leaves no corrected p below .05 with eight units or fewer; `note` says where that is so. p is null
/// over fewer than ten trials or fewer than two units. Each of the three figures is a family of its own, corrected for the
/// number of methods (Holm 1979). Means have 95 % intervals by bootstrap over runs or stretches.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PairedTest {
    /// The method.
    pub name: String,
    /// The first method.
    pub against: String,
    /// Trials.
    #[serde(default)]
    pub trials: usize,
    /// Runs or stretches that they are in.
    #[serde(default)]
    pub units: usize,
    /// Mean point error after 10 m, in metres: the method's less the first one's, over the trials that go so far; null where
    /// none does. Negative: the method is better.
    pub error_difference_m: Option<f64>,
    /// Its interval.
    #[serde(default)]
    pub error_difference_m_ci95: Option<[f64; 2]>,
    /// Its p.
    pub p: Option<f64>,
    /// The same, corrected.
    pub p_holm: Option<f64>,
    /// The smallest corrected p that so few runs or stretches allow, whatever the differences are.
    #[serde(default)]
    pub least_p_holm: Option<f64>,
    /// Share of trials that converge: the method's less the first one's. Positive: the method is better.
    pub found_difference: Option<f64>,
    /// Its interval.
    #[serde(default)]
    pub found_difference_ci95: Option<[f64; 2]>,
    /// Its p.
    pub p_found: Option<f64>,
    /// The same, corrected.
    pub p_found_holm: Option<f64>,
    /// The smallest that this can be, and `p_distance_holm` as well.
    #[serde(default)]
    pub least_p_found_holm: Option<f64>,
    /// Mean metres until a trial converges, or to its end where it never does: the method's less the first one's. Negative: the
    /// method is better.
    #[serde(default)]
    pub distance_difference_m: Option<f64>,
    /// Its interval.
    #[serde(default)]
    pub distance_difference_m_ci95: Option<[f64; 2]>,
    /// Its p.
    #[serde(default)]
    pub p_distance: Option<f64>,
    /// The same, corrected.
    #[serde(default)]
    pub p_distance_holm: Option<f64>,
    /// Where there are too few runs or stretches for any corrected p below .05, or for any p: that.
    #[serde(default)]
    pub note: Option<String>,
}

impl PairedTest {
    /// Could no difference, however large, have a corrected p below .05? Of found trials and of metres until found.
    pub fn is_too_few(&self) -> bool {
        self.least_p_found_holm.is_none_or(|p| p >= SURE_P)
    }

    /// What `note` says.
    fn in_words(&self) -> Option<String> {
        let without = |least_p: Option<f64>| least_p.is_none_or(|p| p >= SURE_P);
        let whose = match (without(self.least_p_holm), self.is_too_few()) {
            (_, true) => "any corrected p",
            (true, false) => "a corrected p of error_difference_m",
            (false, false) => return None,
        };
        Some(format!(
            "too few runs or stretches for {whose} below {SURE_P}"
        ))
    }
}

/// What is compared of a method: a value a trial that starts anywhere.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TrialFigures {
    /// Point error after 10 m, in metres; null where the trial isn't so long.
    pub error_m: Vec<Option<f64>>,
    /// Did it converge?
    pub found: Vec<bool>,
    /// Metres until it converged, or to its end.
    pub distance_m: Vec<Option<f64>>,
}

impl TrialFigures {
    /// Of what a method answered from a start anywhere.
    pub(super) fn new(trials: &[Trial], answers: &[Answers], spacing_m: f64) -> Self {
        // The first row of the error curve that goes so far.
        let at_m = ((REPORTED_AT_M - 1e-9) / spacing_m).ceil() * spacing_m;
        let both = || trials.iter().zip(answers);
        let error_m = |(trial, answers): (&Trial, &Answers)| {
            Some(answers.point_error_m[latest_at(trial, at_m, spacing_m)?])
        };
        let found = |(trial, answers)| converged_at_m(trial, answers).is_some();
        let distance_m = |(trial, answers): (&Trial, &Answers)| {
            converged_at_m(trial, answers).or(trial.travelled_m.last().copied())
        };
        Self {
            distance_m: both().map(distance_m).collect(),
            error_m: both().map(error_m).collect(),
            found: both().map(found).collect(),
        }
    }
}

/// Every other method against the first, each by its name; `unit_of[k]` is the run or stretch of the k-th trial.
pub(super) fn paired_tests(
    methods: &[(&str, &TrialFigures)],
    unit_of: &[usize],
    resamples: usize,
    seed: Seed,
) -> Vec<PairedTest> {
    let Some(((against, first), others)) = methods.split_first() else {
        return Vec::new();
    };
    let tested = |figure: fn(&TrialFigures) -> Vec<Option<f64>>| {
        let of = |(_, other): &(&str, &TrialFigures)| {
            Difference::of(unit_of, &figure(other), &figure(first), resamples, seed)
        };
        let mut family: Vec<Difference> = others.iter().map(of).collect();
        let p: Vec<Option<f64>> = family.iter().map(|difference| difference.p).collect();
        let tests = p.iter().flatten().count() as f64;
        for (difference, corrected) in family.iter_mut().zip(holm(&p)) {
            difference.p_holm = corrected;
            difference.least_p_holm = difference.least_p.map(|p| (tests * p).min(1.0));
        }
        family
    };
    let error = tested(|figures| figures.error_m.clone());
    let found = tested(|figures| {
        let found = figures.found.iter();
        found.map(|found| Some(f64::from(*found))).collect()
    });
    let distance = tested(|figures| figures.distance_m.clone());
    let all = others.iter().zip(error).zip(found).zip(distance);
    let tests = all.map(|((((name, _), error), found), distance)| PairedTest {
        name: (*name).into(),
        against: (*against).into(),
        trials: unit_of.len(),
        units: found.mean.map_or(0, |mean| mean.units),
        error_difference_m: error.mean.map(|mean| mean.mean),
        error_difference_m_ci95: error.mean.and_then(|mean| mean.ci95),
        p: error.p,
        p_holm: error.p_holm,
        least_p_holm: error.least_p_holm,
        found_difference: found.mean.map(|mean| mean.mean),
        found_difference_ci95: found.mean.and_then(|mean| mean.ci95),
        p_found: found.p,
        p_found_holm: found.p_holm,
        least_p_found_holm: found.least_p_holm,
        distance_difference_m: distance.mean.map(|mean| mean.mean),
        distance_difference_m_ci95: distance.mean.and_then(|mean| mean.ci95),
        p_distance: distance.p,
        p_distance_holm: distance.p_holm,
        note: None,
    });
    let noted = |test: PairedTest| PairedTest {
        note: test.in_words(),
        ..test
    };
    tests.map(noted).collect()
}

/// One figure of two methods.
struct Difference {
    /// Over the trials where both have the figure; none where none does.
    mean: Option<ClusteredMean>,
    p: Option<f64>,
    p_holm: Option<f64>,
    /// The smallest that p can be over so many runs or stretches.
    least_p: Option<f64>,
    least_p_holm: Option<f64>,
}

impl Difference {
    fn of(
        unit_of: &[usize],
        other: &[Option<f64>],
        first: &[Option<f64>],
        resamples: usize,
        seed: Seed,
    ) -> Self {
        let both = unit_of.iter().zip(other.iter().zip(first));
        let differences: Vec<(usize, f64)> = both
            .filter_map(|(unit, (other, first))| Some((*unit, (*other)? - (*first)?)))
            .collect();
        let mean = ClusteredMean::of(&differences, resamples, seed);
        let mut units: BTreeMap<usize, f64> = BTreeMap::new();
        for (unit, difference) in differences {
            *units.entry(unit).or_default() += difference;
        }
        let sums: Vec<f64> = units.into_values().collect();
        let is_tested = mean.is_some_and(|mean| !mean.is_uncertain());
        Self {
            mean,
            p: is_tested.then(|| sign_flip_p(&sums, seed)),
            p_holm: None,
            least_p: is_tested.then(|| least_p(sums.len())),
            least_p_holm: None,
        }
    }
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

/// The p of units that all differ to the same side: two ways to flip signs are as far.
fn least_p(units: usize) -> f64 {
    if units <= ENUMERATED_UNITS {
        return 2.0 / (1_usize << units) as f64;
    }
    1.0 / (1 + DRAWN) as f64
}

#[cfg(test)]
mod tests;
