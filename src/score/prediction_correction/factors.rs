//! How often the correction brings the estimate nearer to the truth (R06 3.4): C_XY, C_T, C_XYT.

use super::EstimationErrors;
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Metres or degrees by which two errors may differ and still count as one: more than rounding makes, less than any robot does.
pub(crate) const TIE: f64 = 1e-9;

/// How many estimates the correction improved, left as they were, or made worse.
///
/// The inequality signs of R06's eq. 3-5 and 3-6 are lost in print. With ≤, ties count as successes, and a correction that
/// copies its prior has 100 %; with <, it has 0 %. So both are given, and ties apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CorrectionFactor {
    /// Number of estimates.
    pub n: usize,
    /// Posterior error below the prior error. For position and heading together: neither larger, and at least one below.
    pub improved: usize,
    /// Posterior error equal to the prior error, to 10⁻⁹ m or degrees.
    pub unchanged: usize,
    /// Posterior error above the prior error; together: at least one of them.
    pub worsened: usize,
    /// C with ≤: the share that is improved or unchanged.
    pub not_worse: f64,
    /// C with <: the share in which the error is less; together: both errors are.
    pub better: f64,
}

/// The three factors of R06.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CorrectionFactors {
    /// C_XY (eq. 3-5).
    pub position: CorrectionFactor,
    /// C_T (eq. 3-6).
    pub heading: CorrectionFactor,
    /// C_XYT: both at once.
    pub both: CorrectionFactor,
}

impl CorrectionFactors {
    /// Of the errors of the same estimates before and after correction.
    ///
    /// # Errors
    /// Where numbers differ or there is none.
    ///
    /// ```
    /// use ballmark::score::prediction_correction::{CorrectionFactors, EstimationErrors};
    /// let prior = EstimationErrors { position_m: vec![3.0, 3.0, 3.0, 3.0], heading_deg: vec![5.0; 4] };
    /// let posterior = EstimationErrors { position_m: vec![1.0, 3.0, 4.0, 2.0], heading_deg: vec![5.0, 5.0, 1.0, 1.0] };
    /// let c = CorrectionFactors::of(&prior, &posterior)?;
    /// assert_eq!((c.position.improved, c.position.unchanged, c.position.worsened), (2, 1, 1));
    /// assert_eq!((c.position.not_worse, c.position.better), (0.75, 0.5));
    /// assert_eq!((c.both.improved, c.both.unchanged, c.both.worsened), (2, 1, 1));
    /// assert_eq!((c.both.not_worse, c.both.better), (0.75, 0.25)); // only the last is better in both
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn of(prior: &EstimationErrors, posterior: &EstimationErrors) -> Result<Self> {
        let lengths = [
            prior.position_m.len(),
            prior.heading_deg.len(),
            posterior.position_m.len(),
            posterior.heading_deg.len(),
        ];
        if lengths.iter().any(|&length| length != lengths[0]) || lengths[0] == 0 {
            return Err(Error::work(format!(
                "{} and {} prior errors of position and heading, {} and {} posterior ones; expected as many of each, and at least one",
                lengths[0], lengths[1], lengths[2], lengths[3]
            )));
        }
        let position = changes(&prior.position_m, &posterior.position_m);
        let heading = changes(&prior.heading_deg, &posterior.heading_deg);
        let worst = |(a, b): (&Ordering, &Ordering)| (*a).max(*b);
        let best = |(a, b): (&Ordering, &Ordering)| (*a).min(*b);
        let together = || position.iter().zip(&heading);
        // Neither larger and one below is an improvement; one above is none, whatever the other is.
        let both: Vec<Ordering> = together()
            .map(|pair| match worst(pair) {
                Ordering::Equal => best(pair),
                other => other,
            })
            .collect();
        let in_both = together().filter(|pair| worst(*pair).is_lt()).count();
        let factor = |changes: &[Ordering]| CorrectionFactor::of(changes, None);
        Ok(Self {
            position: factor(&position),
            heading: factor(&heading),
            both: CorrectionFactor::of(&both, Some(in_both)),
        })
    }
}

impl CorrectionFactor {
    /// From how each posterior error compares with its prior error; `better` where not all improvements count as such.
    fn of(changes: &[Ordering], better: Option<usize>) -> Self {
        let count = |which: Ordering| changes.iter().filter(|&&change| change == which).count();
        let n = changes.len();
        let (improved, unchanged) = (count(Ordering::Less), count(Ordering::Equal));
        let share = |of: usize| of as f64 / n as f64;
        Self {
            n,
            improved,
            unchanged,
            worsened: count(Ordering::Greater),
            not_worse: share(improved + unchanged),
            better: share(better.unwrap_or(improved)),
        }
    }

    /// Of one kind of error alone; both slices are of one length.
    pub(super) fn of_errors(prior: &[f64], posterior: &[f64]) -> Self {
        Self::of(&changes(prior, posterior), None)
    }
}

/// How each posterior error compares with the prior error.
fn changes(prior: &[f64], posterior: &[f64]) -> Vec<Ordering> {
    let change = |(prior, posterior): (&f64, &f64)| {
        if (posterior - prior).abs() <= TIE {
            Ordering::Equal
        } else {
            posterior.total_cmp(prior)
        }
    };
    prior.iter().zip(posterior).map(change).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R06 4.4: C_XY = 88 % of 141 estimates, which is 124 of them.
    #[test]
    fn the_shares_of_the_paper_are_whole_estimates() {
        let posterior: Vec<f64> = (0..141).map(|k| if k < 124 { 0.1 } else { 0.5 }).collect();
        let factor = CorrectionFactor::of_errors(&[0.2; 141], &posterior);
        assert_eq!((factor.improved, factor.worsened), (124, 17));
        assert_eq!((factor.not_worse * 100.0).round(), 88.0);
    }

    #[test]
    fn rounding_is_no_change() {
        let factor = CorrectionFactor::of_errors(&[0.3, 0.3, 0.3], &[0.1 + 0.2, 0.3 - 1e-8, 0.3]);
        assert_eq!(
            (factor.improved, factor.unchanged, factor.worsened),
            (1, 2, 0)
        );
    }

    #[test]
    fn together_counts_what_is_worse_in_either() {
        let errors = |position: &[f64], heading: &[f64]| EstimationErrors {
            position_m: position.to_vec(),
            heading_deg: heading.to_vec(),
        };
        let prior = errors(&[2.0; 5], &[2.0; 5]);
        let posterior = errors(&[1.0, 1.0, 1.0, 2.0, 3.0], &[1.0, 2.0, 3.0, 2.0, 3.0]);
        let both = CorrectionFactors::of(&prior, &posterior).unwrap().both;
        assert_eq!((both.improved, both.unchanged, both.worsened), (2, 1, 2));
        assert_eq!((both.not_worse, both.better), (0.6, 0.2));
        assert!(CorrectionFactors::of(&prior, &errors(&[1.0], &[1.0])).is_err());
    }
}
