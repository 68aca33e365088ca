//! A mean over few independent repetitions, such as the folds of a rotation, with its interval.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// A mean and its 95 % interval by Student's t: mean ± t_{0.975, n−1} s/√n, with s the standard deviation (of n − 1).
///
/// It takes the values for independent and normal. Folds that share training data are not quite independent, so the interval is
/// somewhat too narrow (Bengio & Grandvalet, *No unbiased estimator of the variance of K-fold cross-validation*, 2004).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MeanInterval {
    /// Over all values alike.
    pub mean: f64,
    /// Its 95 % interval; null of a single value.
    pub ci95: Option<[f64; 2]>,
    /// Number of values.
    pub count: usize,
}

impl MeanInterval {
    /// The mean of some values; none where there are none, or one is not finite.
    ///
    /// ```
    /// use ballmark::score::MeanInterval;
    /// let folds = MeanInterval::of(&[0.40, 0.44, 0.38, 0.42]).unwrap();
    /// let [low, high] = folds.ci95.unwrap();
    /// // s = .0258, t of 3 degrees of freedom 3.182: ± .0411
    /// assert!((folds.mean - 0.41).abs() < 1e-12);
    /// assert!((low - 0.3689).abs() < 1e-4 && (high - 0.4511).abs() < 1e-4);
    /// assert_eq!(MeanInterval::of(&[0.4]).unwrap().ci95, None);
    /// ```
    pub fn of(values: &[f64]) -> Option<Self> {
        if values.is_empty() || !values.iter().all(|value| value.is_finite()) {
            return None;
        }
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let t = (values.len() > 1)
            .then(|| StudentsT::new(0.0, 1.0, n - 1.0).ok())
            .flatten();
        let ci95 = t.map(|t| {
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            let half = t.inverse_cdf(0.975) * (squares / (n - 1.0) / n).sqrt();
            [mean - half, mean + half]
        });
        Some(Self {
            mean,
            ci95,
            count: values.len(),
        })
    }

    /// Half of the 95 % interval; none of a single value.
    pub fn half(&self) -> Option<f64> {
        self.ci95.map(|[low, high]| (high - low) / 2.0)
    }

    /// Where one more value like these falls in 95 of 100 cases: mean ± t_{0.975, n−1} s √(1 + 1/n). It says whether somebody else's
    /// single value may be one of the same kind, which the interval of the mean does not.
    ///
    /// ```
    /// use ballmark::score::MeanInterval;
    /// let [low, high] = MeanInterval::of(&[0.40, 0.44, 0.38, 0.42]).unwrap().one_more().unwrap();
    /// // 3.182 · .02582 · √1.25 = .0919
    /// assert!((low - 0.3181).abs() < 1e-4 && (high - 0.5019).abs() < 1e-4);
    /// ```
    pub fn one_more(&self) -> Option<[f64; 2]> {
        let half = self.half()? * (self.count as f64 + 1.0).sqrt();
        Some([self.mean - half, self.mean + half])
    }
}
