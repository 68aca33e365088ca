//! Errors summed up.

use serde::Serialize;

/// Statistics of the errors of a trajectory, in the errors' unit; those of `evo`.
///
/// ```
/// use ballmark::score::trajectory::Statistics;
/// let of = Statistics::of(&[3.0, 1.0, 2.0, 6.0]).unwrap();
/// assert_eq!((of.mean, of.median, of.min, of.max, of.sse), (3.0, 2.5, 1.0, 6.0, 50.0));
/// assert!((of.rmse - 12.5_f64.sqrt()).abs() < 1e-15 && (of.std - 3.5_f64.sqrt()).abs() < 1e-15);
/// assert!(Statistics::of(&[]).is_none());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Statistics {
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median; between the two in the middle where there is an even number.
    pub median: f64,
    /// Standard deviation, of all errors and not of a sample (divided by n).
    pub std: f64,
    /// Least error.
    pub min: f64,
    /// Largest error.
    pub max: f64,
    /// Sum of squares, in the unit squared.
    pub sse: f64,
}

impl Statistics {
    /// Of these errors; none of none.
    pub fn of(errors: &[f64]) -> Option<Self> {
        let mut sorted = errors.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let (min, max) = (*sorted.first()?, *sorted.last()?);
        let n = errors.len();
        let mean = errors.iter().sum::<f64>() / n as f64;
        let sse = errors.iter().map(|e| e * e).sum::<f64>();
        let squares = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
        Some(Self {
            rmse: (sse / n as f64).sqrt(),
            mean,
            median: (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0,
            std: (squares / n as f64).sqrt(),
            min,
            max,
            sse,
        })
    }
}
