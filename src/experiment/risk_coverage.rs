//! Does a robot know when it is wrong? The error that is left where the trials are rejected of which it is least sure.
//!
//! El-Yaniv & Wiener, *On the foundations of noise-free selective classification*, Journal of Machine Learning Research 11,
//! 2010: who may abstain has a risk for each share that it answers. Confidence is the belief's own mass within 1 m of its
//! point estimate when the trial ends.

use super::convergence::Answers;
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
    /// Share of them with a point error of at most 1 m.
    pub within_1m: f64,
}

/// The rows, from nothing rejected; of equally sure trials the one of the lower number goes first. Empty where some trial
/// ends without a confidence, or there is no trial.
pub fn risk_coverage(answers: &[Answers]) -> Vec<RiskCoverage> {
    let of_trial =
        |answers: &Answers| Some((answers.end_confidence?, *answers.point_error_m.last()?));
    let Some(mut all) = answers.iter().map(of_trial).collect::<Option<Vec<_>>>() else {
        return Vec::new();
    };
    if all.is_empty() {
        return Vec::new();
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable: ties stay in the order of the trials
    let row = |tenths: usize| {
        let kept = &all[all.len() * tenths / TENTHS..];
        let mean = |value: &dyn Fn(f64) -> f64| {
            kept.iter().map(|(_, error_m)| value(*error_m)).sum::<f64>() / kept.len() as f64
        };
        RiskCoverage {
            rejected: tenths as f64 / TENTHS as f64,
            trials: kept.len(),
            point_error_m: mean(&|error_m| error_m),
            within_1m: mean(&|error_m| f64::from(error_m <= RIGHT_WITHIN_M)),
        }
    };
    (0..TENTHS).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn answers(end_confidence: Option<f64>, error_m: f64) -> Answers {
        Answers {
            point_error_m: vec![99.0, error_m],
            end_confidence,
            ..Answers::default()
        }
    }

    #[test]
    fn the_least_sure_are_rejected_first() {
        let rows = risk_coverage(&[
            answers(Some(0.1), 6.0),
            answers(Some(0.9), 0.0),
            answers(Some(0.5), 2.0), // as sure as the next one, but of a lower number
            answers(Some(0.5), 0.0),
        ]);
        let row = |k: usize| (rows[k].trials, rows[k].point_error_m, rows[k].within_1m);
        assert_eq!(rows.len(), 10);
        assert_eq!(row(0), (4, 2.0, 0.5));
        assert_eq!(row(2), (4, 2.0, 0.5)); // .8 of a trial is none
        assert_eq!(row(3), (3, 2.0 / 3.0, 2.0 / 3.0));
        assert_eq!(row(5), (2, 0.0, 1.0));
        assert_eq!(row(9), (1, 0.0, 1.0));
        assert_eq!(rows[9].rejected, 0.9);
    }

    #[test]
    fn without_confidence_or_trials_there_are_no_rows() {
        assert_eq!(risk_coverage(&[]), []);
        let some = [answers(Some(0.5), 1.0), answers(None, 1.0)];
        assert_eq!(risk_coverage(&some), []);
    }
}
