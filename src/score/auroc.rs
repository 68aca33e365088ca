//! How well a score tells two kinds apart: the area under its receiver operating characteristic.

use super::clustered::percentiles;
use crate::seed::Seed;
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Probability that a point of the one kind, drawn at random, has a higher score than one of the other; of equal scores half
/// (Hanley & McNeil, *The meaning and use of the area under a receiver operating characteristic curve*, Radiology 143, 1982). 1/2 by
/// chance, 1 where a threshold tells all of them apart.
///
/// ```
/// use ballmark::{score::Auroc, seed::Seed};
/// // Runs, whether the robot was lost, and how it said so.
/// let said = [(0, true, 0.9), (0, false, 0.2), (1, true, 0.4), (1, false, 0.4), (2, false, 0.5), (2, true, 0.8)];
/// let auroc = Auroc::of(&said, 1000, Seed(1)).unwrap();
/// assert_eq!(auroc.value, (3.0 + 1.5 + 3.0) / 9.0);
/// let alike: Vec<(usize, bool, f64)> = said.iter().map(|&(run, lost, _)| (run, lost, 1.0)).collect();
/// assert_eq!(Auroc::of(&alike, 0, Seed(1)).unwrap().value, 0.5);
/// assert_eq!(Auroc::of(&said[..1], 1000, Seed(1)), None); // one kind alone
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Auroc {
    /// The area.
    pub value: f64,
    /// Its 95 % interval, by bootstrap over units; null where there is one unit alone, or more than half of the drawings lack
    /// one of the two kinds.
    pub ci95: Option<[f64; 2]>,
}

impl Auroc {
    /// Of points, each with the unit (run, stretch) that it comes from, whether it is of the kind that should score high, and
    /// its score. None where there is but one kind, or a score is NaN.
    pub fn of(points: &[(usize, bool, f64)], resamples: usize, seed: Seed) -> Option<Self> {
        if points.iter().any(|(_, _, score)| score.is_nan()) {
            return None;
        }
        let mut sorted = points.to_vec();
        sorted.sort_by(|a, b| a.2.total_cmp(&b.2));
        let mut units: BTreeMap<usize, usize> = BTreeMap::new();
        for (unit, ..) in &sorted {
            let next = units.len();
            units.entry(*unit).or_insert(next);
        }
        for point in &mut sorted {
            point.0 = units[&point.0];
        }
        let value = area(&sorted, &vec![1; units.len()])?;
        let mut random = seed.stream("bootstrap of areas");
        let drawn = (0..resamples).filter_map(|_| {
            let mut times = vec![0; units.len()];
            for _ in 0..units.len() {
                times[random.random_range(0..units.len())] += 1;
            }
            area(&sorted, &times)
        });
        let drawn: Vec<f64> = drawn.collect();
        let is_enough = units.len() > 1 && 2 * drawn.len() > resamples;
        Some(Self {
            value,
            ci95: percentiles(drawn).filter(|_| is_enough),
        })
    }
}

/// Of points in rising order of their scores, those of unit u counting `times[u]` times.
fn area(sorted: &[(usize, bool, f64)], times: &[usize]) -> Option<f64> {
    let (mut low, mut high, mut pairs) = (0.0, 0.0, 0.0);
    for alike in sorted.chunk_by(|a, b| a.2 == b.2) {
        let count = |kind: bool| -> f64 {
            let of_kind = alike.iter().filter(|point| point.1 == kind);
            of_kind.map(|point| times[point.0] as f64).sum()
        };
        let (low_here, high_here) = (count(false), count(true));
        pairs += high_here * (low + 0.5 * low_here);
        low += low_here;
        high += high_here;
    }
    (low > 0.0 && high > 0.0).then(|| pairs / (low * high))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Brute force over all pairs.
    #[test]
    fn it_is_the_share_of_pairs_in_order() {
        let mut stream = Seed(3).stream("scores");
        let points: Vec<(usize, bool, f64)> = (0..200)
            .map(|k| {
                let is_high = stream.random_bool(0.3);
                let score = f64::from(stream.random_range(0..20)) + 4.0 * f64::from(is_high);
                (k / 20, is_high, score)
            })
            .collect();
        let (mut sum, mut pairs) = (0.0, 0.0);
        for high in points.iter().filter(|p| p.1) {
            for low in points.iter().filter(|p| !p.1) {
                pairs += 1.0;
                sum += match high.2.total_cmp(&low.2) {
                    std::cmp::Ordering::Greater => 1.0,
                    std::cmp::Ordering::Equal => 0.5,
                    std::cmp::Ordering::Less => 0.0,
                };
            }
        }
        let auroc = Auroc::of(&points, 500, Seed(1)).unwrap();
        assert!((auroc.value - sum / pairs).abs() < 1e-12);
        let [low, high] = auroc.ci95.unwrap();
        assert!(low < auroc.value && auroc.value < high && high - low < 0.3);
    }

    #[test]
    fn an_interval_needs_units_and_both_kinds_in_most_drawings() {
        let one: Vec<_> = [(7, true, 1.0), (7, false, 0.0)].to_vec();
        assert_eq!(Auroc::of(&one, 100, Seed(1)).unwrap().ci95, None);
        // Drawn with replacement, both of two units come in half of the drawings only.
        let apart: Vec<_> = [(0, true, 1.0), (1, false, 0.0)].to_vec();
        assert_eq!(Auroc::of(&apart, 1, Seed(1)).unwrap().value, 1.0);
        let nan: Vec<_> = [(0, true, f64::NAN), (1, false, 0.0)].to_vec();
        assert_eq!(Auroc::of(&nan, 100, Seed(1)), None);
    }
}
