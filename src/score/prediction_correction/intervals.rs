//! The posterior error where the prior error lies in an interval (R06 3.4).

use super::{CorrectionFactor, ErrorSummary};
use serde::{Deserialize, Serialize};

/// What comes of prior errors in one interval: how far the error sources of the prediction still show in the posterior.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PriorInterval {
    /// Prior errors above this (from this on, in the first interval), in metres or degrees.
    pub above: f64,
    /// Prior errors up to this; none: however large.
    pub up_to: Option<f64>,
    /// Mean prior error; none where no estimate lies in the interval.
    pub prior_mean: Option<f64>,
    /// Posterior errors; none where no estimate lies in the interval.
    pub posterior: Option<ErrorSummary>,
    /// What became of the errors.
    pub correction: CorrectionFactor,
}

/// The posterior errors by intervals of their prior errors, of position or of heading; the slices are of one length.
///
/// `edges` are the ends of the intervals, rising, and one more takes what is larger. Without edges the quartiles of the prior errors
/// are, so that each interval has as many estimates, as far as ties allow.
///
/// ```
/// use ballmark::score::prediction_correction::by_prior_error;
/// let (prior, posterior) = ([0.1, 0.2, 0.3, 0.9], [0.1, 0.1, 0.2, 0.8]);
/// let intervals = by_prior_error(&prior, &posterior, &[0.2, 0.4]);
/// let n: Vec<usize> = intervals.iter().map(|i| i.correction.n).collect();
/// assert_eq!(n, [2, 1, 1]);
/// assert_eq!((intervals[2].above, intervals[2].up_to), (0.4, None));
/// assert_eq!(intervals[2].posterior.unwrap().mean, 0.8);
/// assert_eq!(by_prior_error(&prior, &posterior, &[]).len(), 4);
/// ```
pub fn by_prior_error(prior: &[f64], posterior: &[f64], edges: &[f64]) -> Vec<PriorInterval> {
    let mut ends: Vec<Option<f64>> = edges.iter().copied().map(Some).collect();
    if edges.is_empty() {
        let mut sorted = prior.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let quartile = |q: usize| {
            sorted
                .get((q * sorted.len()).div_ceil(4).max(1) - 1)
                .copied()
        };
        ends = (1..=4).map(quartile).collect();
        ends.dedup();
    } else {
        ends.push(None);
    }
    let mut above = 0.0;
    let mut intervals = Vec::new();
    for (k, &up_to) in ends.iter().enumerate() {
        let holds =
            |error: f64| (error > above || k == 0) && up_to.is_none_or(|up_to| error <= up_to);
        let pairs = prior.iter().zip(posterior);
        let (before, after): (Vec<f64>, Vec<f64>) = pairs.filter(|(p, _)| holds(**p)).unzip();
        intervals.push(PriorInterval {
            above,
            up_to,
            prior_mean: ErrorSummary::of(&before).map(|of| of.mean),
            posterior: ErrorSummary::of(&after),
            correction: CorrectionFactor::of_errors(&before, &after),
        });
        above = up_to.unwrap_or(above);
    }
    intervals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_estimate_lies_in_one_interval() {
        let prior: Vec<f64> = (0..101).map(|k| f64::from(k % 17)).collect();
        let posterior = vec![1.0; 101];
        for edges in [&[][..], &[3.0], &[0.5, 4.0, 100.0]] {
            let intervals = by_prior_error(&prior, &posterior, edges);
            let n: usize = intervals.iter().map(|i| i.correction.n).sum();
            assert_eq!(n, 101, "{edges:?}");
        }
        // The last one is empty, and says so.
        let empty = by_prior_error(&prior, &posterior, &[100.0])[1];
        assert_eq!((empty.prior_mean, empty.correction.n), (None, 0));
        assert_eq!(by_prior_error(&[0.0; 5], &[1.0; 5], &[]).len(), 1);
    }
}
