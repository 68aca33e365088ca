//! How far the corrected coefficient of another sample of trials may differ: a bootstrap interval.

use super::{
    contingency::{ByLocation, Contingency, Ordinals, ordinal},
    correction::{Drawn, corrected_coefficient},
};
use crate::seed::Seed;
use rand::RngExt;
use rayon::prelude::*;
use std::{collections::BTreeMap, hash::Hash};

/// A 95 % interval of the coefficient corrected for chance.
///
/// Units are drawn with replacement: whole trials where the data has trials, since the rows of one trial resemble each
/// other; else single rows. Drawing a unit twice makes rows agree that say the same thing once, which raises every
/// resampled coefficient (50 × 16 independent labels, 100 rows: plain percentiles exclude the truth, 0, always). So
/// only the spread of the resamples is taken and their mean is moved to the sample's own coefficient.
///
/// Drawing from the table it has, the bootstrap knows nothing of what sparse tables hide: with few rows a cell the
/// interval is too narrow for the coefficient of an endless sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end, at most 1.
    pub high: f64,
}

impl Interval {
    /// The interval from `resamples` drawings of units; `unit_of[k]` is the unit of the k-th data point
    /// recorded, any number that the points of one unit share. `None` where there are fewer than two units or the coefficient is undefined, of the table or of more
    /// than half of the drawings.
    ///
    /// The drawings come from numbered streams of `seed`: the result is the same for any number of threads.
    ///
    /// ```
    /// use ballmark::{score::{Contingency, Interval, corrected_coefficient}, seed::Seed};
    /// let mut table = Contingency::new();
    /// for k in 0..80 {
    ///     table.record(k % 4, if k % 5 == 0 { 0 } else { k % 4 }); // each fifth answer is a guess
    /// }
    /// let trial_of: Vec<usize> = (0..80).map(|k| k / 8).collect();
    /// let interval = Interval::by_bootstrap(&table, &trial_of, 500, Seed(1)).unwrap();
    /// let coefficient = corrected_coefficient(&table.counts()).unwrap();
    /// assert!(interval.low < coefficient && coefficient < interval.high);
    /// ```
    pub fn by_bootstrap<L: Eq + Hash, R: Eq + Hash>(
        table: &Contingency<L, R>,
        unit_of: &[usize],
        resamples: u64,
        seed: Seed,
    ) -> Option<Self> {
        Self::of_mean(std::slice::from_ref(table), unit_of, resamples, seed)
    }

    /// The same for the mean coefficient of several tables, of which the k-th data points belong to one unit: trials
    /// that are looked at again and again as they go on. One drawing of units serves all tables.
    pub fn of_mean<L: Eq + Hash, R: Eq + Hash>(
        tables: &[Contingency<L, R>],
        unit_of: &[usize],
        resamples: u64,
        seed: Seed,
    ) -> Option<Self> {
        Self::watched(tables, unit_of, resamples, seed, &|| ())
    }

    /// As [`Interval::of_mean`]; `drawn` is called after each drawing, from any thread.
    pub(super) fn watched<L: Eq + Hash, R: Eq + Hash>(
        tables: &[Contingency<L, R>],
        unit_of: &[usize],
        resamples: u64,
        seed: Seed,
        drawn: Drawn<'_>,
    ) -> Option<Self> {
        let (units, unit_of) = numbered_from_zero(unit_of);
        if units < 2 || tables.iter().any(|table| unit_of.len() != table.len()) {
            return None;
        }
        let points: Vec<ByLocation> = tables.iter().map(Contingency::by_location).collect();
        let coefficient = mean_coefficient(&points, |_| 1)?;
        // How often which unit was drawn.
        let draw = |times: &mut Vec<u32>, resample| {
            let mut stream = seed.numbered_stream("bootstrap resample", resample);
            times.clear();
            times.resize(units, 0);
            for _ in 0..units {
                times[stream.random_range(0..units)] += 1;
            }
        };
        let judge = |times: &[u32]| mean_coefficient(&points, |k| u64::from(times[unit_of[k]]));
        let resamples_of = (0..resamples).into_par_iter();
        let judged: Vec<Option<f64>> = if units <= FEW_UNITS {
            let drawings: Vec<Vec<u32>> = resamples_of
                .map(|resample| {
                    let mut times = Vec::new();
                    draw(&mut times, resample);
                    times
                })
                .collect();
            let mut alike: BTreeMap<Vec<u32>, usize> = BTreeMap::new();
            for times in drawings {
                *alike.entry(times).or_default() += 1;
            }
            let alike: Vec<(Vec<u32>, usize)> = alike.into_iter().collect();
            let judged = alike.into_par_iter().map(|(times, alike)| {
                let resampled = judge(&times);
                (0..alike).for_each(|_| drawn());
                vec![resampled; alike]
            });
            judged.collect::<Vec<_>>().concat()
        } else {
            let judged = resamples_of.map_init(Vec::new, |times, resample| {
                draw(times, resample);
                let resampled = judge(times);
                drawn();
                resampled
            });
            judged.collect()
        };
        let mut resampled: Vec<f64> = judged.into_iter().flatten().collect();
        if resampled.len() < 2 || 2 * (resampled.len() as u64) < resamples {
            return None;
        }
        resampled.sort_by(f64::total_cmp);
        let shift = coefficient - resampled.iter().sum::<f64>() / resampled.len() as f64;
        Some(Self {
            low: (quantile(&resampled, 0.025) + shift).min(coefficient),
            high: (quantile(&resampled, 0.975) + shift).clamp(coefficient, 1.0),
        })
    }
}

/// So few units are drawn alike again and again, and such drawings are judged but once. Of more, no drawing is kept.
const FEW_UNITS: usize = 12;

/// Mean corrected coefficient of the tables that have one, where the k-th data point counts `weight(k)` times.
fn mean_coefficient(points: &[ByLocation], weight: impl Fn(usize) -> u64) -> Option<f64> {
    let of_each = points
        .iter()
        .map(|points| corrected_coefficient(&points.counts(&weight)));
    let (sum, tables) = of_each
        .flatten()
        .fold((0.0, 0.0), |(sum, n), c| (sum + c, n + 1.0));
    (tables > 0.0).then(|| sum / tables)
}

/// How many units there are, and the same division into units by numbers from 0 in the order of first appearance: whatever
/// the units are called, memory and drawings depend on how many there are.
fn numbered_from_zero(unit_of: &[usize]) -> (usize, Vec<usize>) {
    let mut numbers = Ordinals::default();
    let unit_of = unit_of
        .iter()
        .map(|unit| ordinal(&mut numbers, *unit))
        .collect();
    (numbers.len(), unit_of)
}

/// Quantile of ascending values, linear between neighbours (Hyndman & Fan 1996, type 7).
fn quantile(ascending: &[f64], share: f64) -> f64 {
    let place = share * (ascending.len() - 1) as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    ascending[below] + (place - place.floor()) * (ascending[above] - ascending[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_neighbours() {
        assert_eq!(quantile(&[0.0, 10.0, 20.0], 0.25), 5.0);
        assert_eq!(quantile(&[3.0], 0.975), 3.0);
    }

    /// Rows of a trial repeat one another: over trials the interval must be wider than over rows.
    #[test]
    fn trials_that_repeat_themselves_widen_the_interval() {
        let mut table = Contingency::new();
        let (mut trial_of, mut row_of) = (Vec::new(), Vec::new());
        let mut stream = Seed(5).stream("answers");
        for trial in 0..30 {
            let location = trial % 3;
            let response = if stream.random_bool(0.6) { location } else { 9 };
            for _ in 0..10 {
                table.record(location, response);
                row_of.push(trial_of.len());
                trial_of.push(trial);
            }
        }
        let width = |unit_of: &[usize]| {
            let interval = Interval::by_bootstrap(&table, unit_of, 400, Seed(1)).unwrap();
            interval.high - interval.low
        };
        assert!(width(&trial_of) > 2.0 * width(&row_of));
    }

    #[test]
    fn chance_is_not_excluded() {
        let mut excluded = 0;
        for sample in 0..40 {
            let mut stream = Seed(2).numbered_stream("independent", sample);
            let mut table = Contingency::new();
            for _ in 0..100 {
                table.record(stream.random_range(0..50), stream.random_range(0..16));
            }
            let rows: Vec<usize> = (0..100).collect();
            let interval = Interval::by_bootstrap(&table, &rows, 200, Seed(sample)).unwrap();
            excluded += usize::from(interval.low > 0.0 || interval.high < 0.0);
        }
        assert!(excluded <= 4, "{excluded} of 40");
    }

    /// Of a mean of tables alike the interval is that of each; tables that err differently vary less together.
    #[test]
    fn the_mean_of_several_tables_has_one_interval() {
        let table = |shift: usize| {
            let mut table = Contingency::new();
            let mut stream = Seed(8).numbered_stream("answers", shift as u64);
            for trial in 0..60 {
                let right = stream.random_bool(0.7);
                table.record(trial % 3, if right { trial % 3 } else { 9 });
            }
            table
        };
        let units: Vec<usize> = (0..60).map(|trial| trial / 3).collect();
        let interval = |tables: &[Contingency<usize, usize>]| {
            Interval::of_mean(tables, &units, 400, Seed(1)).unwrap()
        };
        let one = Interval::by_bootstrap(&table(0), &units, 400, Seed(1)).unwrap();
        assert_eq!(interval(&[table(0), table(0)]), one);
        let many: Vec<_> = (0..8).map(table).collect();
        let width = |interval: Interval| interval.high - interval.low;
        assert!(width(interval(&many)) < 0.7 * width(one));
        assert_eq!(Interval::of_mean(&many, &units[1..], 400, Seed(1)), None);
    }

    /// Numbers of units may have gaps of any width: neither memory nor the interval depends on them.
    #[test]
    fn units_may_have_any_numbers() {
        let mut table = Contingency::new();
        (0..60).for_each(|k| table.record(k % 3, if k % 5 == 0 { 9 } else { k % 3 }));
        let units: Vec<usize> = (0..60).map(|k| k / 6).collect();
        let far: Vec<usize> = units
            .iter()
            .map(|unit| usize::MAX - 1_000_003 * unit)
            .collect();
        let interval =
            |units: &[usize]| Interval::by_bootstrap(&table, units, 200, Seed(4)).unwrap();
        assert_eq!(interval(&far), interval(&units));
    }

    #[test]
    fn one_trial_or_one_location_has_no_interval_and_certainty_no_width() {
        let mut table = Contingency::new();
        (0..20).for_each(|k| table.record(k % 2, k % 2));
        let rows: Vec<usize> = (0..20).collect();
        assert_eq!(Interval::by_bootstrap(&table, &[0; 20], 100, Seed(1)), None);
        let sure = Interval::by_bootstrap(&table, &rows, 100, Seed(1)).unwrap();
        assert_eq!((sure.low, sure.high), (1.0, 1.0));
        let mut one = Contingency::new();
        (0..20).for_each(|k| one.record("here", k % 2));
        assert_eq!(Interval::by_bootstrap(&one, &rows, 100, Seed(1)), None);
    }
}
