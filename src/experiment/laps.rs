//! Laps of a robot that goes round the same way again and again, and the drift that they give away.
//!
//! D98 (Duckett & Nehmzow 1998), 6.4: "the recorded data were manually divided into laps by finding an obvious landmark
//! (e.g., corner) in the odometry trace. … For each lap, the accumulated drift error was then removed by correcting each
//! data point by an amount proportional to the distance travelled along the route. Finally, an offset was applied to each
//! of the successive laps to cancel out the remaining translational error between them." Here nobody needs to look: a
//! trace that goes round repeats its directions after the length of a lap and comes back to about where it was.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// How laps are found, or given. Times and thresholds are ours: the papers divide by hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LapsConfig {
    /// Stamps at which the laps start, in seconds, ascending, for those who divide by hand; the last may be the end of
    /// the last lap. Empty: they are found.
    pub starts_s: Vec<f64>,
    /// No lap is shorter, metres.
    pub shortest_m: f64,
    /// Mean cosine between the directions of successive laps from which on they count as alike.
    pub likeness: f64,
}

impl Default for LapsConfig {
    fn default() -> Self {
        Self {
            starts_s: Vec::new(),
            shortest_m: 10.0,
            likeness: 0.7,
        }
    }
}

impl LapsConfig {
    /// # Errors
    /// A usage error that names the key out of bounds.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, fault: String| Err(Error::usage(format!("laps.{key} {fault}")));
        if !(self.shortest_m >= 1.0 && self.shortest_m.is_finite()) {
            return wrong(
                "shortest_m",
                format!("= {}: expected 1 m or more", self.shortest_m),
            );
        }
        if !(0.0..=1.0).contains(&self.likeness) {
            return wrong(
                "likeness",
                format!("= {}: expected a cosine from 0 to 1", self.likeness),
            );
        }
        if self.starts_s.len() == 1 || !self.starts_s.is_sorted_by(|a, b| a < b) {
            return wrong(
                "starts_s",
                "must be none, or the starts of two laps or more in rising order".into(),
            );
        }
        Ok(())
    }
}

/// The laps of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Laps {
    /// Where each starts, metres along the trace, ascending. What follows the last may be a part of a lap.
    pub starts_m: Vec<f64>,
    /// Mean length, metres.
    pub length_m: f64,
}

/// A way through the plane, and metres travelled on it.
///
/// ```
/// use ballmark::experiment::laps::{LapsConfig, Trace};
/// // Two and a half times round a square of 10 m × 10 m, a point every 25 cm; one end of a metre is 3 % too long.
/// let at = |m: f64| match (m % 40.0 / 10.0, m % 10.0) {
///     (side, m) if side < 1.0 => [m, 0.0],
///     (side, m) if side < 2.0 => [10.0, m],
///     (side, m) if side < 3.0 => [10.0 - m, 10.0],
///     (_, m) => [0.0, 10.0 - m],
/// };
/// let drifting = |k: usize| at(0.25 * k as f64).map(|x| x + 0.03 * 0.25 * k as f64);
/// let trace = Trace::new((0..400).map(drifting).collect());
/// let laps = trace.laps(&LapsConfig::default())?;
/// assert_eq!(laps.starts_m.len(), 3);
/// let corrected = trace.without_drift(&laps);
/// let back = corrected[160]; // 40 m later
/// assert!((back[0] - corrected[0][0]).hypot(back[1] - corrected[0][1]) < 0.3);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    points: Vec<[f64; 2]>,
    travelled_m: Vec<f64>,
}

/// Resolution at which a trace is compared with itself, metres; coarser where it is very long.
const STEP_M: f64 = 0.1;
/// Most samples of a trace: their products with one another are counted in hundreds of millions.
const MAX_SAMPLES: f64 = 20_000.0;
/// A direction is that of the chord from so far behind to so far ahead, metres: wheels' noise drowns shorter ones.
const CHORD_M: f64 = 0.5;
/// Share of a lap by which its end may miss its start: three times the worst drift that D98 5.2 tells of.
const MAX_DRIFT: f64 = 0.15;
/// Of lags nearly as good as the best (it may be that of two laps) the first is the lap's.
const NEARLY: f64 = 0.9;
/// A lap may be longer or shorter than the others by this share.
const SLACK: f64 = 0.1;

impl Trace {
    /// A trace of points, metres. It has at least one.
    pub fn new(points: Vec<[f64; 2]>) -> Self {
        let mut travelled = 0.0;
        let travelled_m = (0..points.len()).map(|k| {
            travelled += if k > 0 {
                apart(points[k], points[k - 1])
            } else {
                0.0
            };
            travelled
        });
        Self {
            travelled_m: travelled_m.collect(),
            points,
        }
    }

    /// Metres travelled at every point.
    pub fn travelled_m(&self) -> &[f64] {
        &self.travelled_m
    }

    fn length_m(&self) -> f64 {
        self.travelled_m.last().copied().unwrap_or(0.0)
    }

    /// Finds the laps; the first starts with the trace.
    ///
    /// # Errors
    /// Where the trace doesn't go round at least one and a half times.
    pub fn laps(&self, config: &LapsConfig) -> Result<Laps> {
        config.check()?;
        let length_m = self.length_m();
        let none = |why: String| {
            Error::work(format!(
                "laps: {why}; expected a trace that goes round one and a half times or more (or else protocol.mapping = \
                 \"split\" or \"first_run\", or [protocol.laps] starts_s = [..])"
            ))
        };
        let step_m = STEP_M.max(length_m / MAX_SAMPLES);
        let places = self.resampled(step_m);
        let directions = directions(&places, (CHORD_M / step_m).ceil() as usize);
        let shortest = (config.shortest_m / step_m).ceil() as usize;
        let longest = places.len() * 2 / 3; // the half of a lap, at least, can be compared
        let alike: Vec<f64> = (shortest..=longest)
            .map(|lag| likeness(&places, &directions, lag, step_m))
            .collect();
        let best = alike.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if best == f64::NEG_INFINITY {
            return Err(none(format!("no lap in {length_m:.1} m of way")));
        }
        if best < config.likeness {
            return Err(none(format!(
                "no lap in {length_m:.1} m of way: directions repeat themselves with a mean cosine of {best:.2} at best, \
                 less than laps.likeness = {}",
                config.likeness
            )));
        }
        // The first hill of nearly the best likeness, and its top.
        let hill = alike.iter().skip_while(|&&a| a < NEARLY * best);
        let from = alike.len() - hill.clone().count();
        let width = hill.take_while(|&&a| a >= NEARLY * best).count();
        let top = (from..from + width).max_by(|&a, &b| alike[a].total_cmp(&alike[b]));
        let period = shortest + top.unwrap_or(from);
        let starts = starts(&directions, period);
        let starts_m: Vec<f64> = starts.iter().map(|&at| at as f64 * step_m).collect();
        Ok(Laps {
            length_m: mean_length(&starts_m),
            starts_m,
        })
    }

    /// The laps that start at these points.
    pub fn laps_at(&self, starts: &[usize]) -> Laps {
        let starts_m: Vec<f64> = starts.iter().map(|&k| self.travelled_m[k]).collect();
        Laps {
            length_m: mean_length(&starts_m),
            starts_m,
        }
    }

    /// The first point of each lap: the one nearest to its start.
    pub fn first_points(&self, laps: &Laps) -> Vec<usize> {
        let nearest = |&start_m: &f64| {
            let after = self.travelled_m.partition_point(|&m| m < start_m);
            let before = after.saturating_sub(1);
            let off = |k: usize| {
                self.travelled_m
                    .get(k)
                    .map_or(f64::INFINITY, |m| (m - start_m).abs())
            };
            if off(after) < off(before) {
                after
            } else {
                before
            }
        };
        laps.starts_m.iter().map(nearest).collect()
    }

    /// The trace with its drift removed lap by lap (D98 6.4): each closed on its start in proportion to the distance
    /// travelled, then all laid onto the first. What follows the last start, or stands before the first, has the drift
    /// of the lap beside it.
    pub fn without_drift(&self, laps: &Laps) -> Vec<[f64; 2]> {
        let starts = &laps.starts_m;
        let last = starts.len().saturating_sub(1);
        if last == 0 {
            return self.points.clone();
        }
        let drift: Vec<[f64; 2]> = starts
            .windows(2)
            .map(|ends| {
                let (from, to) = (self.at(ends[0]), self.at(ends[1]));
                [0, 1].map(|axis| (to[axis] - from[axis]) / (ends[1] - ends[0]))
            })
            .collect();
        let lap_of = |m: f64| {
            starts
                .partition_point(|&start| start <= m)
                .saturating_sub(1)
        };
        let closed = |k: usize, lap: usize| {
            let since = self.travelled_m[k] - starts[lap];
            let drift = drift[lap.min(last - 1)];
            [0, 1].map(|axis| self.points[k][axis] - drift[axis] * since)
        };
        let lap: Vec<usize> = self.travelled_m.iter().map(|&m| lap_of(m)).collect();
        let mut corrected: Vec<[f64; 2]> = (0..lap.len()).map(|k| closed(k, lap[k])).collect();
        // Where the first lap is after a share of its length, for the others to be laid upon.
        let first_length = starts[1] - starts[0];
        let first = |share: f64| {
            let (m, drift) = (first_length * share, drift[0]);
            let place = self.at(starts[0] + m);
            [0, 1].map(|axis| place[axis] - drift[axis] * m)
        };
        for number in 1..=last {
            let of_lap: Vec<usize> = (0..lap.len()).filter(|&k| lap[k] == number).collect();
            let length = starts
                .get(number + 1)
                .map_or(laps.length_m, |end| end - starts[number]);
            let mut offset = [0.0; 2];
            for &k in &of_lap {
                let share = (self.travelled_m[k] - starts[number]) / length;
                let point = first(share.rem_euclid(1.0));
                (0..2).for_each(|axis| offset[axis] += point[axis] - corrected[k][axis]);
            }
            for &k in &of_lap {
                (0..2).for_each(|axis| corrected[k][axis] += offset[axis] / of_lap.len() as f64);
            }
        }
        corrected
    }

    /// The place after so many metres, between the points on a straight line.
    fn at(&self, m: f64) -> [f64; 2] {
        let after = self.travelled_m.partition_point(|&t| t < m);
        let after = after.min(self.points.len() - 1);
        let before = after.saturating_sub(1);
        let step = self.travelled_m[after] - self.travelled_m[before];
        if step <= 0.0 {
            return self.points[after];
        }
        let share = ((m - self.travelled_m[before]) / step).clamp(0.0, 1.0);
        let (a, b) = (self.points[before], self.points[after]);
        [0, 1].map(|axis| a[axis] + share * (b[axis] - a[axis]))
    }

    fn resampled(&self, step_m: f64) -> Vec<[f64; 2]> {
        let samples = (self.length_m() / step_m).floor() as usize + 1;
        (0..samples).map(|i| self.at(i as f64 * step_m)).collect()
    }
}

/// Unit vectors along the way, each that of a chord.
fn directions(places: &[[f64; 2]], reach: usize) -> Vec<[f64; 2]> {
    let last = places.len().saturating_sub(1);
    (0..places.len())
        .map(|i| {
            let (a, b) = (
                places[i.saturating_sub(reach)],
                places[(i + reach).min(last)],
            );
            let length = apart(a, b).max(f64::MIN_POSITIVE);
            [0, 1].map(|axis| (b[axis] - a[axis]) / length)
        })
        .collect()
}

/// Mean cosine between the directions now and so many samples later; none where the way isn't back by then.
fn likeness(places: &[[f64; 2]], directions: &[[f64; 2]], lag: usize, step_m: f64) -> f64 {
    let pairs = (places.len() - lag) as f64;
    let missed = places.iter().zip(&places[lag..]);
    let missed = missed.map(|(a, b)| apart(*a, *b)).sum::<f64>() / pairs;
    if missed > MAX_DRIFT * lag as f64 * step_m {
        return f64::NEG_INFINITY;
    }
    let cosines = directions.iter().zip(&directions[lag..]);
    cosines.map(|(a, b)| dot(*a, *b)).sum::<f64>() / pairs
}

/// The samples at which laps start: where the directions of half a lap around fit those around the first start best; the
/// second start, which has no trace before the first to be compared with, by what follows it.
fn starts(directions: &[[f64; 2]], period: usize) -> Vec<usize> {
    let slack = ((period as f64 * SLACK) as usize).max(1);
    let half = period / 2;
    let mut starts = vec![0];
    loop {
        let expected = starts[starts.len() - 1] + period;
        if expected >= directions.len() {
            return starts;
        }
        let (like, before, after) = match starts[..] {
            [first] => (first, 0, period),
            [_, second, ..] => (second, half, half),
            [] => (0, 0, period),
        };
        // All candidates are judged by the same number of samples, those that the last of them still has.
        let latest = (expected + slack).min(directions.len() - 1);
        let after = after
            .min(directions.len() - latest)
            .min(directions.len() - like);
        let fit = |at: usize| {
            let around = |middle: usize| &directions[middle - before.min(like)..middle + after];
            around(at)
                .iter()
                .zip(around(like))
                .map(|(a, b)| dot(*a, *b))
                .sum::<f64>()
        };
        let mut best = (expected, fit(expected.min(latest)));
        for at in expected - slack..=latest {
            let fit = fit(at);
            if fit > best.1 {
                best = (at, fit);
            }
        }
        starts.push(best.0);
    }
}

fn mean_length(starts_m: &[f64]) -> f64 {
    match starts_m {
        [first, .., last] => (last - first) / (starts_m.len() - 1) as f64,
        _ => 0.0,
    }
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests;
