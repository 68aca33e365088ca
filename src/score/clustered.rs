//! Means over data points that are no independent evidence, such as trials in one stretch of a run, with their intervals.

use crate::seed::{Seed, Stream};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// With fewer data points than this a figure is marked as uncertain.
pub const FEW: usize = 10;

/// A mean, and how far another sample may differ. A share is the mean of ones and zeros.
///
/// The 95 % interval is a cluster bootstrap's (Davison & Hinkley, *Bootstrap Methods and their Application*, 1997, 3.8): units
/// (runs, stretches) are drawn with replacement, each with all its data points.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ClusteredMean {
    /// Over all data points alike.
    pub mean: f64,
    /// Its 95 % interval; null where all data points come from one unit.
    pub ci95: Option<[f64; 2]>,
    /// Number of data points.
    pub count: usize,
    /// Units that they come from.
    pub units: usize,
}

impl ClusteredMean {
    /// The mean of values, each with the unit that it comes from. Of nothing there is no mean.
    ///
    /// ```
    /// use ballmark::{score::ClusteredMean, seed::Seed};
    /// // Two runs, one all right and one all wrong: forty trials are no forty pieces of evidence.
    /// let trials: Vec<(usize, f64)> = (0..40).map(|k| (k % 2, f64::from(k % 2 == 0))).collect();
    /// let found = ClusteredMean::of(&trials, 1000, Seed(1)).unwrap();
    /// assert_eq!((found.mean, found.ci95), (0.5, Some([0.0, 1.0])));
    /// ```
    pub fn of(values: &[(usize, f64)], resamples: usize, seed: Seed) -> Option<Self> {
        let mut units: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
        for &(unit, value) in values {
            let sum = units.entry(unit).or_default();
            sum.0 += value;
            sum.1 += 1;
        }
        let sums: Vec<(f64, usize)> = units.into_values().collect();
        if sums.is_empty() {
            return None;
        }
        let mean = |draw: &mut dyn Iterator<Item = (f64, usize)>| {
            let (total, n) = draw.fold((0.0, 0), |sum, s| (sum.0 + s.0, sum.1 + s.1));
            total / n as f64
        };
        let mut random = seed.stream("bootstrap of shares");
        let drawn = (0..resamples).map(|_| {
            let mut draw = (0..sums.len()).map(|_| sums[random.random_range(0..sums.len())]);
            mean(&mut draw)
        });
        Some(Self {
            ci95: percentiles(drawn.collect()).filter(|_| sums.len() > 1),
            mean: mean(&mut sums.iter().copied()),
            count: values.len(),
            units: sums.len(),
        })
    }

    /// The share of the data points that are so.
    pub fn share(of: &[(usize, bool)], resamples: usize, seed: Seed) -> Option<Self> {
        let values = of.iter().map(|&(unit, is_so)| (unit, f64::from(is_so)));
        Self::of(&values.collect::<Vec<_>>(), resamples, seed)
    }

    /// Does it rest on fewer than ten data points, or on those of a single unit?
    pub fn is_uncertain(&self) -> bool {
        self.count < FEW || self.units < 2
    }
}

/// 95 % intervals of several figures from the same drawings of units; `figures` finds them where the k-th data point counts
/// `times[k]` times. None where the data points come from one unit.
pub(crate) fn intervals(
    unit_of: &[usize],
    resamples: usize,
    random: &mut Stream,
    figures: impl Fn(&[usize]) -> Vec<f64>,
) -> Option<Vec<[f64; 2]>> {
    let mut members: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, &unit) in unit_of.iter().enumerate() {
        members.entry(unit).or_default().push(k);
    }
    let members: Vec<Vec<usize>> = members.into_values().collect();
    if members.len() < 2 || resamples == 0 {
        return None;
    }
    let mut drawn: Vec<Vec<f64>> = Vec::new(); // of each figure, its value in every drawing
    for _ in 0..resamples {
        let mut times = vec![0; unit_of.len()];
        for _ in 0..members.len() {
            for &k in &members[random.random_range(0..members.len())] {
                times[k] += 1;
            }
        }
        let values = figures(&times);
        drawn.resize(values.len(), Vec::with_capacity(resamples));
        drawn.iter_mut().zip(values).for_each(|(d, v)| d.push(v));
    }
    drawn.into_iter().map(percentiles).collect()
}

/// The 2.5 and the 97.5 % point.
pub(crate) fn percentiles(mut drawn: Vec<f64>) -> Option<[f64; 2]> {
    drawn.sort_by(f64::total_cmp);
    let last = drawn.len().checked_sub(1)? as f64;
    let quantile = |q: f64| drawn[(last * q).round() as usize];
    Some([quantile(0.025), quantile(0.975)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_share_has_an_interval_over_what_its_trials_came_from() {
        let of = |units: usize| -> Vec<(usize, bool)> {
            (0..40).map(|i| (i % units, i % units == 0)).collect()
        };
        assert_eq!(ClusteredMean::share(&[], 100, Seed(1)), None);
        let one = ClusteredMean::share(&of(1), 100, Seed(1)).unwrap();
        assert_eq!((one.mean, one.ci95), (1.0, None));
        assert!(one.is_uncertain());
        let two = ClusteredMean::share(&of(2), 1000, Seed(1)).unwrap();
        assert_eq!((two.mean, two.ci95), (0.5, Some([0.0, 1.0])));
        assert_eq!((two.count, two.units), (40, 2));
        assert!(!two.is_uncertain());
        assert!(
            ClusteredMean::share(&of(2)[..9], 10, Seed(1))
                .unwrap()
                .is_uncertain()
        );
    }

    /// Of three units with one point each the bootstrap mean has the standard deviation √(σ²/3).
    #[test]
    fn intervals_of_several_figures_come_from_the_same_drawings() {
        let values = [0.0, 3.0, 6.0];
        let mean = |times: &[usize]| {
            let total: f64 = times.iter().zip(values).map(|(&t, v)| t as f64 * v).sum();
            total / times.iter().sum::<usize>() as f64
        };
        let mut random = Seed(1).stream("test");
        let both = intervals(&[7, 8, 9], 2000, &mut random, |times| {
            vec![mean(times), -mean(times)]
        });
        let both = both.unwrap();
        // 1/27 of all drawings is thrice the smallest value, more than 2.5 %.
        assert_eq!(both, [[0.0, 6.0], [-6.0, 0.0]]);
        assert_eq!(
            intervals(&[7, 7], 100, &mut random, |_| vec![1.0]),
            None,
            "one unit"
        );
    }
}
