//! What errors can be measured (R06 3.3, ground truth limits) and what errors a search over a grid can't avoid (4.1).

use super::{EstimationErrors, PositionHeading, factors::TIE};
use serde::{Deserialize, Serialize};

/// How precisely the real poses are known.
pub type Precision = PositionHeading;

/// Steps s_XY and s_T of a localiser that answers with a pose of a regular grid (R06 4.1).
pub type SearchStep = PositionHeading;

/// The errors held against the precision of the truth.
///
/// "Every distribution point should be above the ground truth" (R06 3.3), and the truth at least twice as precise as what is
/// expected of the estimate (R06 3): here the mean posterior error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TruthLimit {
    /// Precision of the real positions, in metres.
    pub position_m: Option<f64>,
    /// Precision of the real headings, in degrees.
    pub heading_deg: Option<f64>,
    /// Estimates whose position error is no larger than that precision: these errors are the truth's as much as the estimate's.
    pub positions_within: Option<usize>,
    /// Likewise of headings.
    pub headings_within: Option<usize>,
    /// Is the truth at least twice as precise as the mean position error?
    pub position_precise_enough: Option<bool>,
    /// And as the mean heading error?
    pub heading_precise_enough: Option<bool>,
}

impl TruthLimit {
    /// Of the posterior errors and the precision that is stated.
    ///
    /// ```
    /// use ballmark::score::prediction_correction::{EstimationErrors, TruthLimit};
    /// let errors = EstimationErrors { position_m: vec![0.05, 0.25], heading_deg: vec![3.0, 5.0] };
    /// let limit = TruthLimit::of(&errors, &"0.1m,1deg".parse()?);
    /// assert_eq!(limit.positions_within, Some(1));
    /// assert_eq!(limit.position_precise_enough, Some(false)); // 0.1 m are no half of 0.15 m
    /// assert_eq!(limit.heading_precise_enough, Some(true));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn of(errors: &EstimationErrors, precision: &Precision) -> Self {
        let within = |errors: &[f64], precision: Option<f64>| {
            precision.map(|p| errors.iter().filter(|&&e| e <= p + TIE).count())
        };
        let enough = |errors: &[f64], precision: Option<f64>| {
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            precision.map(|p| 2.0 * p <= mean + TIE)
        };
        Self {
            position_m: precision.position_m,
            heading_deg: precision.heading_deg,
            positions_within: within(&errors.position_m, precision.position_m),
            headings_within: within(&errors.heading_deg, precision.heading_deg),
            position_precise_enough: enough(&errors.position_m, precision.position_m),
            heading_precise_enough: enough(&errors.heading_deg, precision.heading_deg),
        }
    }
}

/// Estimates that no search over the grid could have made better: within the maximum reachable precisions (R06 4.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Optimal {
    /// MPA_xy = s_XY/√2, half the diagonal of a cell, in metres; R06 prints 0.71 s_XY. None where the step is not stated.
    pub limit_position_m: Option<f64>,
    /// MPA_t = s_T/2, in degrees.
    pub limit_heading_deg: Option<f64>,
    /// Number of estimates within every limit that there is.
    pub count: usize,
    /// Their share.
    pub fraction: f64,
}

impl Optimal {
    /// Of the posterior errors and the steps of the search.
    ///
    /// ```
    /// use ballmark::score::prediction_correction::{EstimationErrors, Optimal};
    /// let errors = EstimationErrors { position_m: vec![0.07, 0.07, 0.08], heading_deg: vec![5.0, 6.0, 1.0] };
    /// let optimal = Optimal::of(&errors, &"10cm,10deg".parse()?);
    /// assert_eq!(optimal.count, 1);
    /// assert!((optimal.limit_position_m.unwrap() - 0.0707).abs() < 1e-4); // printed: 7.1 cm
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn of(errors: &EstimationErrors, step: &SearchStep) -> Self {
        let limit_position_m = step.position_m.map(|s| s * std::f64::consts::FRAC_1_SQRT_2);
        let limit_heading_deg = step.heading_deg.map(|s| s / 2.0);
        let within = |error: f64, limit: Option<f64>| limit.is_none_or(|l| error <= l + TIE);
        let optimal = |&(&position, &heading): &(&f64, &f64)| {
            within(position, limit_position_m) && within(heading, limit_heading_deg)
        };
        let pairs = errors.position_m.iter().zip(&errors.heading_deg);
        let count = pairs.filter(optimal).count();
        Self {
            limit_position_m,
            limit_heading_deg,
            count,
            fraction: count as f64 / errors.len() as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R06 4.3: 53.2 % of 141 estimates, which is 75 of them, within 7.1 cm and 5°.
    #[test]
    fn the_share_of_the_paper() {
        let errors = EstimationErrors {
            position_m: (0..141)
                .map(|k| if k < 80 { 0.0707 } else { 0.0708 })
                .collect(),
            heading_deg: (0..141).map(|k| if k < 5 { 5.1 } else { 5.0 }).collect(),
        };
        let optimal = Optimal::of(&errors, &"10cm,10deg".parse().unwrap());
        assert_eq!(optimal.count, 75);
        assert_eq!(format!("{:.1}", 100.0 * optimal.fraction), "53.2");
        // A step that is not stated limits nothing.
        let only = Optimal::of(&errors, &"10cm".parse().unwrap());
        assert_eq!((only.count, only.limit_heading_deg), (80, None));
    }
}
