//! When a robot has found out where it is, and error curves over distance with their confidence.

use super::{sureness::Sureness, trials::Trial};
use crate::{
    geometry::Pose,
    score::{ClusteredMean, FEW, percentiles},
    seed::Seed,
};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Distance at which mean errors are reported, in metres.
pub const REPORTED_AT_M: f64 = 10.0;

/// A robot has converged when it stays this sure and this right, in metres …
pub const SURE_WITHIN_M: f64 = 1.0;
/// … for this far …
const FOR_M: f64 = 5.0;
/// … or to the trial's end, if that is at least this far away.
const TO_THE_END_M: f64 = 2.0;

/// What a localiser answered along one trial, one entry a snapshot.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answers {
    /// Σ Bel·e in metres (Thrun 1998, eq. 21).
    pub expected_error_m: Vec<f64>,
    /// Distance from the truth to the belief's mode, in metres.
    pub point_error_m: Vec<f64>,
    /// Pose of each answer, along a route metres alone; none where it has no place or, in the plane, no heading. Of known starts only.
    pub estimates: Vec<Option<Pose>>,
    /// Mass of the cells likelier than the truth's; empty where there is no belief.
    pub likelier_mass: Vec<f64>,
    /// How far the last answer's heading is from the true one, in [0, π]; none where it has no heading.
    pub end_heading_error_rad: Option<f64>,
    /// Mass within 1 m of the last point estimate: 0 where there is no answer, none where it comes without a belief.
    pub end_confidence: Option<f64>,
    /// How sure it was; of starts anywhere only.
    pub sureness: Sureness,
}

/// One row of an error curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Row {
    /// Metres travelled since the start.
    pub distance_m: f64,
    /// Mean expected error over the trials that go this far.
    pub expected_error_m: f64,
    /// Mean point error over them.
    pub point_error_m: f64,
    /// 95 % interval of the mean expected error, by bootstrap over runs or stretches; none where only one goes this far.
    pub ci95_m: Option<[f64; 2]>,
    /// 95 % interval of the mean point error, from the same drawings.
    #[serde(default)]
    pub point_ci95_m: Option<[f64; 2]>,
    /// Number of trials that go this far.
    pub trials: usize,
    /// Share of all trials that have [converged](converged_at_m) by then.
    #[serde(default)]
    pub found: f64,
    /// Its 95 % interval, by bootstrap over runs or stretches; none where there is only one.
    #[serde(default)]
    pub found_ci95: Option<[f64; 2]>,
}

impl Row {
    /// Is the mean over fewer than ten trials, or over those of a single run or stretch?
    pub fn is_uncertain(&self) -> bool {
        self.trials < FEW || self.ci95_m.is_none()
    }
}

/// First distance from which the expected error stays under 1 m for 5 m of travel (or to the trial's end, if that is
/// at least 2 m away) with the truth within 1 m of the mode; `None` where there is none.
pub fn converged_at_m(trial: &Trial, answers: &Answers) -> Option<f64> {
    let travelled = &trial.travelled_m;
    let end = *travelled.last()?;
    let good = |i: usize| {
        answers.expected_error_m[i] < SURE_WITHIN_M && answers.point_error_m[i] <= SURE_WITHIN_M
    };
    (0..travelled.len())
        .find(|&i| {
            let until = travelled[i] + FOR_M;
            (until <= end || end - travelled[i] >= TO_THE_END_M)
                && (i..travelled.len())
                    .take_while(|&j| travelled[j] <= until)
                    .all(good)
        })
        .map(|i| travelled[i])
}

/// Median of the distances over all trials, those that never converge counting as farther than any; `None` where fewer
/// than half converge.
pub fn median_distance_m(converged: &[Option<f64>]) -> Option<f64> {
    let mut sorted: Vec<f64> = converged
        .iter()
        .map(|d| d.unwrap_or(f64::INFINITY))
        .collect();
    sorted.sort_by(f64::total_cmp);
    let (n, middle) = (sorted.len(), sorted.len() / 2);
    let median = match n {
        0 => return None,
        _ if n % 2 == 1 => sorted[middle],
        // Exactly half of them converge: the farthest of these is where half are found.
        _ if sorted[middle].is_infinite() => sorted[middle - 1],
        _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
    };
    median.is_finite().then_some(median)
}

/// Mean errors against distance, a row every `spacing_m`; a trial counts up to its end, with its latest answer.
pub fn error_curve(
    trials: &[Trial],
    answers: &[Answers],
    spacing_m: f64,
    resamples: usize,
    seed: Seed,
) -> Vec<Row> {
    let longest = trials
        .iter()
        .filter_map(|t| t.travelled_m.last())
        .copied()
        .fold(0.0, f64::max);
    let mut random = seed.stream("bootstrap");
    let found_at_m: Vec<(usize, f64)> = trials
        .iter()
        .zip(answers)
        .map(|(t, a)| (t.unit, converged_at_m(t, a).unwrap_or(f64::INFINITY)))
        .collect();
    let mut found: Option<(usize, ClusteredMean)> = None; // as many as at the last distance have the same interval
    let mut rows = Vec::new();
    for step in 0..=(longest / spacing_m + 1e-9) as usize {
        let distance_m = step as f64 * spacing_m;
        // Errors of the trials that go this far, by what is resampled.
        let mut units: BTreeMap<usize, Sums> = BTreeMap::new();
        for (trial, answers) in trials.iter().zip(answers) {
            if let Some(latest) = latest_at(trial, distance_m, spacing_m) {
                let sums = units.entry(trial.unit).or_default();
                sums.0 += answers.expected_error_m[latest];
                sums.1 += answers.point_error_m[latest];
                sums.2 += 1;
            }
        }
        let sums: Vec<Sums> = units.into_values().collect();
        let count: usize = sums.iter().map(|s| s.2).sum();
        if count == 0 {
            break;
        }
        let drawn = (0..resamples).map(|_| {
            let draw = (0..sums.len()).map(|_| sums[random.random_range(0..sums.len())]);
            let sum = |a: Sums, b: Sums| (a.0 + b.0, a.1 + b.1, a.2 + b.2);
            means(draw.fold((0.0, 0.0, 0), sum))
        });
        let (expected, point): (Vec<f64>, Vec<f64>) = drawn.unzip();
        let ci95 = |drawn: Vec<f64>| percentiles(drawn).filter(|_| sums.len() > 1);
        let total = |value: fn(&Sums) -> f64| sums.iter().map(value).sum::<f64>();
        let (expected_error_m, point_error_m) = means((total(|s| s.0), total(|s| s.1), count));
        let by_now = found_at_m
            .iter()
            .map(|(unit, at_m)| (*unit, *at_m <= distance_m + 1e-9));
        let by_now: Vec<(usize, bool)> = by_now.collect();
        let many = by_now.iter().filter(|(_, is_found)| *is_found).count();
        if found.is_none_or(|(before, _)| before != many) {
            found = ClusteredMean::share(&by_now, resamples, seed).map(|share| (many, share));
        }
        rows.push(Row {
            found: found.map_or(0.0, |(_, share)| share.mean),
            found_ci95: found.and_then(|(_, share)| share.ci95),
            distance_m,
            expected_error_m,
            point_error_m,
            ci95_m: ci95(expected),
            point_ci95_m: ci95(point),
            trials: count,
        });
    }
    rows
}

/// Expected and point errors of some trials together, in metres, and how many trials.
type Sums = (f64, f64, usize);

fn means((expected_m, point_m, trials): Sums) -> (f64, f64) {
    (expected_m / trials as f64, point_m / trials as f64)
}

/// The latest snapshot of a trial at this distance from its start; none where the trial ends before, by more than half
/// the spacing of snapshots.
pub(super) fn latest_at(trial: &Trial, distance_m: f64, spacing_m: f64) -> Option<usize> {
    let travelled = &trial.travelled_m;
    let passed = travelled.partition_point(|d| *d <= distance_m + 1e-9);
    (*travelled.last()? >= distance_m - 0.5 * spacing_m).then(|| passed.max(1) - 1)
}

/// First row at which the mean curve is under 1 m; `None` where it never is.
pub fn mean_below_1m(curve: &[Row]) -> Option<&Row> {
    let mut rows = curve.iter();
    rows.find(|row| row.expected_error_m < SURE_WITHIN_M)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(stretch: usize, steps: usize) -> Trial {
        Trial {
            stretch,
            unit: stretch,
            snapshots: (0..steps).collect(),
            travelled_m: (0..steps).map(|i| i as f64 * 0.5).collect(),
        }
    }

    fn answers(expected: &[f64]) -> Answers {
        Answers {
            expected_error_m: expected.to_vec(),
            point_error_m: vec![0.3; expected.len()],
            ..Answers::default()
        }
    }

    #[test]
    fn converges_where_it_stays_sure_and_right() {
        let mut expected = vec![9.0, 8.0, 0.5, 3.0]; // sure at 1 m, but not for long
        expected.extend([0.5; 17]);
        let long = trial(0, expected.len());
        assert_eq!(converged_at_m(&long, &answers(&expected)), Some(2.0));
        let mut wrong = answers(&expected);
        wrong.point_error_m[10] = 1.5; // sure, but of another place, at 5 m
        assert_eq!(converged_at_m(&long, &wrong), Some(5.5));
    }

    #[test]
    fn a_trial_may_end_early_but_not_at_once() {
        let mut expected = vec![9.0; 6];
        expected.extend([0.5; 5]); // sure from 3 m to the end at 5 m
        assert_eq!(
            converged_at_m(&trial(0, 11), &answers(&expected)),
            Some(3.0)
        );
        let mut late = vec![9.0; 7];
        late.extend([0.5; 4]); // from 3.5 m: only 1.5 m left
        assert_eq!(converged_at_m(&trial(0, 11), &answers(&late)), None);
    }

    #[test]
    fn trials_that_never_converge_count_in_the_median() {
        assert_eq!(median_distance_m(&[Some(2.0), None, Some(4.0)]), Some(4.0));
        assert_eq!(median_distance_m(&[Some(2.0), None, None]), None);
        assert_eq!(median_distance_m(&[Some(2.0), None]), Some(2.0));
        assert_eq!(median_distance_m(&[Some(2.0), None, None, None]), None);
        assert_eq!(median_distance_m(&[Some(2.0), Some(3.0)]), Some(2.5));
        assert_eq!(median_distance_m(&[]), None);
    }

    /// One is found after 2 m, one after 3 m, one never.
    #[test]
    fn the_share_that_is_found_grows_with_the_distance() {
        let sure_from = |step: usize| {
            let errors = (0..12).map(|k| if k < step { 9.0 } else { 0.5 });
            answers(&errors.collect::<Vec<f64>>())
        };
        let trials = [trial(0, 12), trial(1, 12), trial(2, 12)];
        let played = [sure_from(4), sure_from(6), sure_from(99)];
        let curve = error_curve(&trials, &played, 0.5, 200, Seed(1));
        let found: Vec<f64> = curve.iter().map(|row| 3.0 * row.found).collect();
        assert_eq!(found, [0., 0., 0., 0., 1., 1., 2., 2., 2., 2., 2., 2.]);
        assert!(
            curve[4]
                .found_ci95
                .is_some_and(|[low, high]| low == 0.0 && high < 1.01)
        );
    }

    #[test]
    fn the_curve_is_the_mean_of_the_trials_that_go_so_far() {
        let trials = [trial(0, 3), trial(1, 2)];
        let curve = error_curve(
            &trials,
            &[answers(&[4.0, 2.0, 1.0]), answers(&[8.0, 4.0])],
            0.5,
            200,
            Seed(1),
        );
        let means: Vec<f64> = curve.iter().map(|row| row.expected_error_m).collect();
        assert_eq!(means, [6.0, 3.0, 1.0]);
        assert_eq!(curve[0].ci95_m, Some([4.0, 8.0]));
        assert_eq!(
            (curve[0].point_error_m, curve[0].point_ci95_m),
            (0.3, Some([0.3, 0.3]))
        );
        assert_eq!(curve[2].ci95_m, None); // two stretches: the bootstrap sees one alone often enough
        assert_eq!((curve[1].trials, curve[2].trials), (2, 1));
        assert_eq!(
            (curve[2].found, curve[2].found_ci95),
            (0.0, Some([0.0, 0.0]))
        );
        assert_eq!(mean_below_1m(&curve), None);
        assert!(curve[0].is_uncertain()); // two trials
    }
}
