//! Errors of estimated poses, in position and in heading (R06 3.3, 3.4), and what sums them up.

use crate::{
    error::{Error, Result},
    geometry::Pose,
};
use serde::{Deserialize, Serialize};

/// The three traces of a run (R06 eq. 3-1), pose by pose of one length.
#[derive(Debug, Clone, Copy)]
pub struct Traces<'a> {
    /// What the run is called.
    pub name: &'a str,
    /// RP: where the robot was.
    pub real: &'a [Pose],
    /// PEprio: where it thought to be before it looked.
    pub prior: &'a [Pose],
    /// PEpost: where it thought to be once it had looked.
    pub posterior: &'a [Pose],
}

/// EEP_XY and EEP_T of every pose of a trace (R06 eq. 3-2).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EstimationErrors {
    /// Distances over the floor, in metres.
    pub position_m: Vec<f64>,
    /// Absolute differences of heading, in degrees, at most 180.
    pub heading_deg: Vec<f64>,
}

/// Something of the position error and the same of the heading error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PositionAndHeading<T> {
    /// Of distances over the floor, in metres.
    pub position_m: T,
    /// Of differences of heading, in degrees.
    pub heading_deg: T,
}

/// A distribution of errors in a few numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorSummary {
    /// Number of errors.
    pub n: usize,
    /// μ.
    pub mean: f64,
    /// σ, of all errors and not of a sample (divided by n).
    pub std: f64,
    /// The merit factor μ + σ (R06 eq. 4-2): the less, the better.
    pub merit: f64,
    /// Errors that so many per cent stay within.
    pub percentiles: Percentiles,
}

/// The least error that so many per cent of all errors do not exceed: always an error that occurred (nearest rank), as in "95 % of
/// the errors should be under 20 cm" (R06 3.3).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Half of the errors are no larger.
    #[serde(rename = "50")]
    pub p50: f64,
    /// Nine tenths.
    #[serde(rename = "90")]
    pub p90: f64,
    /// Nineteen of twenty.
    #[serde(rename = "95")]
    pub p95: f64,
    /// All: the largest error.
    #[serde(rename = "100")]
    pub p100: f64,
}

impl EstimationErrors {
    /// Of estimated poses against the real ones.
    ///
    /// # Errors
    /// Where there are none, or one is not finite, or numbers differ.
    ///
    /// ```
    /// use ballmark::{Pose, score::prediction_correction::EstimationErrors};
    /// let real = [Pose::new(0.0, 0.0, 3.1)];
    /// let errors = EstimationErrors::of(&[Pose::new(3.0, 4.0, -3.1)], &real)?;
    /// assert_eq!(errors.position_m, [5.0]);
    /// assert!((errors.heading_deg[0] - 4.7662).abs() < 1e-4); // the short way round
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn of(estimated: &[Pose], real: &[Pose]) -> Result<Self> {
        if estimated.len() != real.len() || real.is_empty() {
            return Err(Error::work(format!(
                "{} estimated poses and {} real ones; expected as many, and at least one",
                estimated.len(),
                real.len()
            )));
        }
        let finite = |poses: &[Pose]| poses.iter().all(Pose::is_finite);
        if !finite(estimated) || !finite(real) {
            return Err(Error::work("a pose that is not finite; expected numbers"));
        }
        let pairs = || estimated.iter().zip(real);
        Ok(Self {
            position_m: pairs().map(|(a, b)| a.distance_m(b)).collect(),
            heading_deg: pairs().map(|(a, b)| a.turn_rad(b).to_degrees()).collect(),
        })
    }

    /// Number of poses.
    pub fn len(&self) -> usize {
        self.position_m.len()
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.position_m.is_empty()
    }

    /// Takes the errors of another run in, behind these: the union of distributions (R06 3.3).
    pub fn extend(&mut self, other: &Self) {
        self.position_m.extend(&other.position_m);
        self.heading_deg.extend(&other.heading_deg);
    }

    /// Both summed up; none of none.
    pub fn summary(&self) -> Option<PositionAndHeading<ErrorSummary>> {
        Some(PositionAndHeading {
            position_m: ErrorSummary::of(&self.position_m)?,
            heading_deg: ErrorSummary::of(&self.heading_deg)?,
        })
    }
}

impl ErrorSummary {
    /// Of these errors; none of none.
    ///
    /// ```
    /// use ballmark::score::prediction_correction::ErrorSummary;
    /// let errors: Vec<f64> = (1..=20).map(f64::from).collect();
    /// let of = ErrorSummary::of(&errors).unwrap();
    /// let at = of.percentiles;
    /// assert_eq!((at.p50, at.p90, at.p95, at.p100), (10.0, 18.0, 19.0, 20.0));
    /// assert_eq!(of.merit, of.mean + of.std);
    /// ```
    pub fn of(errors: &[f64]) -> Option<Self> {
        let mut sorted = errors.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let n = sorted.len();
        // Nearest rank, in whole numbers: 0.95 · 20 is 19 and no hair more.
        let percentile = |percent: usize| sorted[(percent * n).div_ceil(100).max(1) - 1];
        let mean = (n > 0).then(|| errors.iter().sum::<f64>() / n as f64)?;
        let std = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n as f64).sqrt();
        Some(Self {
            n,
            mean,
            std,
            merit: mean + std,
            percentiles: Percentiles {
                p50: percentile(50),
                p90: percentile(90),
                p95: percentile(95),
                p100: percentile(100),
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of seven errors half is more than three, so the median is the fourth; nine tenths are more than six.
    #[test]
    fn a_percentile_is_an_error_that_enough_errors_do_not_exceed() {
        let at = |errors: &[f64]| {
            let at = ErrorSummary::of(errors).unwrap().percentiles;
            [at.p50, at.p90, at.p95, at.p100]
        };
        assert_eq!(
            at(&[7.0, 1.0, 5.0, 3.0, 2.0, 6.0, 4.0]),
            [4.0, 7.0, 7.0, 7.0]
        );
        let eleven: Vec<f64> = (1..=11).map(f64::from).collect();
        assert_eq!(at(&eleven), [6.0, 10.0, 11.0, 11.0]);
        assert_eq!(at(&[2.5]), [2.5; 4]);
        assert_eq!(ErrorSummary::of(&[]), None);
    }
}
