//! Does a robot know when it is wrong? The error that is left where the trials are rejected of which it is least sure.
//!
//! El-Yaniv & Wiener, *On the foundations of noise-free selective classification*, Journal of Machine Learning Research 11,
//! 2010: who may abstain has a risk for each share that it answers. Confidence is the belief's own mass within 1 m of its
//! point estimate when the trial ends.

use super::{convergence::Answers, trials::Trial};
use crate::{
    score::{FEW, intervals},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

/// Confidence is mass within this distance of the point estimate, and an answer this near the truth is right, in metres.
pub const RIGHT_WITHIN_M: f64 = 1.0;

/// Rows: 0, 1, … 9 tenths of the trials are rejected.
const TENTHS: usize = 10;

/// What is left where some trials are rejected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RiskCoverage {
    /// Share of the trials that are rejected, those of least confidence; rounded down to whole trials.
    pub rejected: f64,
    /// Trials that are left.
    pub trials: usize,
    /// Their mean point error at the end, in metres.
    pub point_error_m: f64,
    /// Its 95 % interval, by bootstrap over runs or stretches; null where there is only one.
    #[serde(default)]
    pub point_error_m_ci95: Option<[f64; 2]>,
    /// Share of them with a point error of at most 1 m.
    pub within_1m: f64,
    /// Its 95 % interval.
    #[serde(default)]
    pub within_1m_ci95: Option<[f64; 2]>,
}

impl RiskCoverage {
    /// Is it over fewer than ten trials, or those of a single run or stretch?
    pub fn is_uncertain(&self) -> bool {
        self.trials < FEW || self.point_error_m_ci95.is_none()
    }
}

/// The rows, from nothing rejected, and the area under them.
pub(super) struct RiskCurve {
    pub rows: Vec<RiskCoverage>,
    /// Mean of the mean point errors of the surest 1, 2, 3, … trials up to all (Geifman, Uziel & El-Yaniv, *Bias-reduced
    /// uncertainty estimation for deep neural classifiers*, 2019), in metres.
    pub area_m: f64,
    /// Its 95 % interval.
    pub area_m_ci95: Option<[f64; 2]>,
}

/// Confidences that differ by less than this are alike but for rounding.
const ROUNDING: f64 = 1e-9;

/// The curve; none where some trial ends without a confidence, or there is no trial. Trials that are equally sure are
/// rejected alike, each of them in part, whatever their order.
pub(super) fn risk_coverage(
    trials: &[Trial],
    answers: &[Answers],
    resamples: usize,
    seed: Seed,
) -> Option<RiskCurve> {
    let rounded = |confidence: f64| (confidence / ROUNDING).round() as i64;
    let confidence = answers.iter().map(|a| a.end_confidence.map(rounded));
    let confidence: Vec<i64> = confidence.collect::<Option<_>>()?;
    let error_m = answers.iter().map(|a| a.point_error_m.last().copied());
    let error_m: Vec<f64> = error_m.collect::<Option<_>>()?;
    let mut order: Vec<usize> = (0..trials.len()).collect();
    order.sort_by_key(|&k| std::cmp::Reverse(confidence[k]));
    let alike: Vec<&[usize]> = order
        .chunk_by(|&a, &b| confidence[a] == confidence[b])
        .collect();
    if alike.is_empty() {
        return None;
    }
    let figures = |times: &[usize]| Figures::of(&alike, &error_m, times).all();
    let whole = figures(&vec![1; trials.len()]);
    let units: Vec<usize> = trials.iter().map(|trial| trial.unit).collect();
    let mut random = seed.stream("bootstrap of rejection");
    let ci95 = intervals(&units, resamples, &mut random, figures);
    let ci95 = |figure: usize| ci95.as_ref().map(|ci95| ci95[figure]);
    let rows = (0..TENTHS).map(|tenths| RiskCoverage {
        rejected: tenths as f64 / TENTHS as f64,
        trials: left(trials.len(), tenths),
        point_error_m: whole[tenths],
        point_error_m_ci95: ci95(tenths),
        within_1m: whole[TENTHS + tenths],
        within_1m_ci95: ci95(TENTHS + tenths),
    });
    Some(RiskCurve {
        rows: rows.collect(),
        area_m: whole[2 * TENTHS],
        area_m_ci95: ci95(2 * TENTHS),
    })
}

/// Of so many trials, how many a row leaves: one at least.
fn left(trials: usize, tenths: usize) -> usize {
    trials - trials * tenths / TENTHS
}

/// Of each row the mean point error and the share within 1 m, and the area.
struct Figures {
    error_m: Vec<f64>,
    within_1m: Vec<f64>,
    area_m: f64,
}

impl Figures {
    /// `alike` has the trials that are equally sure, the surest first; trial k counts `times[k]` times.
    fn of(alike: &[&[usize]], error_m: &[f64], times: &[usize]) -> Self {
        let trials: usize = times.iter().sum();
        let mut figures = Self {
            error_m: vec![0.0; TENTHS],
            within_1m: vec![0.0; TENTHS],
            area_m: 0.0,
        };
        // Of those surer than the ones at hand.
        let (mut count, mut errors_m, mut right) = (0, 0.0, 0.0);
        for group in alike {
            let sum = |value: &dyn Fn(usize) -> f64| -> f64 {
                group.iter().map(|&k| times[k] as f64 * value(k)).sum()
            };
            let here: usize = group.iter().map(|&k| times[k]).sum();
            let (errors_here_m, right_here) = (
                sum(&|k| error_m[k]),
                sum(&|k| f64::from(error_m[k] <= RIGHT_WITHIN_M)),
            );
            let part = |more: usize| more as f64 / here as f64;
            for tenths in 0..TENTHS {
                let left = left(trials, tenths);
                if (count + 1..=count + here).contains(&left) {
                    let part = part(left - count);
                    figures.error_m[tenths] = (errors_m + part * errors_here_m) / left as f64;
                    figures.within_1m[tenths] = (right + part * right_here) / left as f64;
                }
            }
            for more in 1..=here {
                let mean_m = (errors_m + part(more) * errors_here_m) / (count + more) as f64;
                figures.area_m += mean_m / trials as f64;
            }
            count += here;
            errors_m += errors_here_m;
            right += right_here;
        }
        figures
    }

    fn all(self) -> Vec<f64> {
        let mut all = self.error_m;
        all.extend(self.within_1m);
        all.push(self.area_m);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of trials by their stretch, confidence and error at the end.
    fn curve(all: &[(usize, Option<f64>, f64)]) -> Option<RiskCurve> {
        let trial = |&(unit, ..): &(usize, Option<f64>, f64)| Trial {
            stretch: unit,
            unit,
            snapshots: vec![0, 1],
            travelled_m: vec![0.0, 0.5],
        };
        let answers = |&(_, end_confidence, error_m): &(usize, Option<f64>, f64)| Answers {
            point_error_m: vec![99.0, error_m],
            end_confidence,
            ..Answers::default()
        };
        let trials: Vec<Trial> = all.iter().map(trial).collect();
        let answers: Vec<Answers> = all.iter().map(answers).collect();
        risk_coverage(&trials, &answers, 300, Seed(1))
    }

    #[test]
    fn the_least_sure_are_rejected_first() {
        let curve = curve(&[
            (0, Some(0.1), 6.0),
            (0, Some(0.9), 0.0),
            (1, Some(0.5), 2.0), // as sure as the next one
            (1, Some(0.5), 0.0),
        ])
        .unwrap();
        let rows = &curve.rows;
        let row = |k: usize| (rows[k].trials, rows[k].point_error_m, rows[k].within_1m);
        assert_eq!(rows.len(), 10);
        assert_eq!(row(0), (4, 2.0, 0.5));
        assert_eq!(row(2), (4, 2.0, 0.5)); // .8 of a trial is none
        assert_eq!(row(3), (3, 2.0 / 3.0, 2.0 / 3.0));
        assert_eq!(row(5), (2, 0.5, 0.75)); // one of the two that are as sure, either
        assert_eq!(row(9), (1, 0.0, 1.0));
        assert_eq!(rows[9].rejected, 0.9);
        // (0 + 1/2 + 2/3 + 2) / 4
        assert!(
            (curve.area_m - 19.0 / 24.0).abs() < 1e-12,
            "{}",
            curve.area_m
        );
        // Two stretches, with means of 3 and 1 m. Twice the first: (0 + 0 + 2 + 3) / 4; twice the second: 1.
        assert_eq!(rows[0].point_error_m_ci95, Some([1.0, 3.0]));
        let [low, high] = curve.area_m_ci95.unwrap();
        assert!((low - 19.0 / 24.0).abs() < 1e-12 && (high - 1.25).abs() < 1e-12);
        assert!(rows[0].is_uncertain()); // four trials
    }

    #[test]
    fn who_is_as_sure_of_all_gains_nothing_by_rejecting() {
        let trials: Vec<_> = (0..10).map(|k| (k, Some(0.7), k as f64)).collect();
        let curve = curve(&trials).unwrap();
        for row in &curve.rows {
            assert!((row.point_error_m - 4.5).abs() < 1e-12, "{row:?}");
            assert!((row.within_1m - 0.2).abs() < 1e-12, "{row:?}");
        }
        assert!((curve.area_m - 4.5).abs() < 1e-12);
    }

    #[test]
    fn without_confidence_trials_or_a_second_stretch() {
        assert!(curve(&[]).is_none());
        assert!(curve(&[(0, Some(0.5), 1.0), (1, None, 1.0)]).is_none());
        let one = curve(&[(0, Some(0.5), 1.0), (0, Some(0.4), 2.0)]).unwrap();
        assert_eq!((one.area_m, one.area_m_ci95), (1.25, None));
        assert_eq!(one.rows[0].within_1m_ci95, None);
    }
}
