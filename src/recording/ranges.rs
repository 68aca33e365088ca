//! From which reading on a range sensor saw nothing.
//!
//! A sensor without an echo still writes a number: 81.91, 50, about 51.1, … Which one differs between sensors, drivers
//! and settings, so it is found in the log itself. Two properties tell it from a far wall:
//!
//! 1. *It piles up at the end.* The farthest 0.4 % of distances holds at least five times as many readings as each of the ten
//!    equally wide bands below it: real distances thin out towards the far end, they don't gather there.
//! 2. *It does not depend on the place.* The pile is there from at least three different square metres of floor. A wall far
//!    away has the same distance (to 0.2 %) only while the robot stands still or turns on the spot.
//!
//! A log without such a pile gets no maximum, and all its readings stay. Fewer than 1 in 2,000 readings beyond the pile
//! don't hide it. One case needs no statistics: SICK LMS scanners transmit 13-bit centimetres whose last values, 81.83
//! to 81.91 m, are codes and not distances; where a channel ends in these, they are no returns even in a short log.
//!
//! Infinite readings and those of 0 or less are never a distance.

use super::Columns;
use crate::geometry::Pose;
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use std::collections::BTreeSet;

/// Width of the band of farthest readings, as a share of the farthest.
const BAND: f32 = 0.004;
/// Bands below it that it is compared with.
const BANDS_BELOW: u8 = 10;
/// How many times fuller than each of them it must be.
const PILE_RATIO: usize = 5;
/// Fewer readings than this are no pile.
const PILE_LEAST: usize = 10;
/// One reading in so many may lie beyond the pile.
const READINGS_PER_STRAY: usize = 2000;
/// Jitter of a no-return value, as a share of it: in one of the public logs it spans 51.01 to 51.16.
const JITTER: f32 = 0.002;
/// Square metres of floor that the pile must be seen from.
const PLACES: usize = 3;
/// SICK LMS codes in metres, half a centimetre of tolerance at both ends.
const SICK_CODES_M: std::ops::Range<f32> = 81.825..81.915;

/// The reading from which on there was no return, as the log itself shows it; `None` where every reading may be a
/// distance. `readings` is `[snapshot, beam]` in metres, `poses` one a snapshot.
///
/// ```
/// use ballmark::{geometry::Pose, recording::ranges::no_return_from};
/// let poses: Vec<Pose> = (0..40).map(|k| Pose::new(k as f64, 0.0, 0.0)).collect();
/// let scan = |k: usize| if k % 2 == 0 { 50.0 } else { 1.0 + k as f32 / 10.0 };
/// let readings = ndarray::Array2::from_shape_fn((40, 1), |(k, _)| scan(k));
/// assert_eq!(no_return_from(readings.view(), &poses), Some(50.0));
/// ```
pub fn no_return_from(readings: ArrayView2<f32>, poses: &[Pose]) -> Option<f64> {
    let mut farthest_first: Vec<f32> = readings
        .iter()
        .copied()
        .filter(|r| is_distance(*r))
        .collect();
    farthest_first.sort_unstable_by(|a, b| b.total_cmp(a));
    let limit = sick_code(&farthest_first).or_else(|| {
        pile(&farthest_first).filter(|limit| seen_from_places(readings, poses, *limit))
    })?;
    // By way of its shortest decimal form, so that 81.83 stays 81.83 and isn't told as 81.83000183.
    limit.to_string().parse().ok()
}

/// Turns every reading from `maximum` on, and every one that can't be a distance, into NaN; returns how many are NaN now.
pub fn blank_no_returns(mut readings: ArrayViewMut2<f32>, maximum: Option<f64>) -> usize {
    let limit = maximum.map_or(f32::INFINITY, |m| m as f32);
    let mut blank = 0;
    readings.mapv_inplace(|r| {
        if is_distance(r) && r < limit {
            r
        } else {
            blank += 1;
            f32::NAN
        }
    });
    blank
}

fn is_distance(reading: f32) -> bool {
    reading.is_finite() && reading > 0.0
}

fn sick_code(farthest_first: &[f32]) -> Option<f32> {
    SICK_CODES_M
        .contains(farthest_first.first()?)
        .then(|| smallest_from(farthest_first, SICK_CODES_M.start))
}

fn pile(farthest_first: &[f32]) -> Option<f32> {
    let n = farthest_first.len();
    // Index of the first reading below a distance.
    let below = |distance: f32| farthest_first.partition_point(|r| *r >= distance);
    let mut start = 0;
    while start < n && start <= n / READINGS_PER_STRAY {
        let top = farthest_first[start];
        let end = below(top * (1.0 - BAND));
        let edges = (1..=BANDS_BELOW).map(|i| top * (1.0 - BAND * f32::from(i)));
        let fullest = edges
            .map(|edge| below(edge - top * BAND) - below(edge))
            .max()
            .unwrap_or(0);
        if end < n && end - start >= PILE_LEAST.max(PILE_RATIO * fullest) {
            let no_return = most_frequent(&farthest_first[start..end]);
            return Some(smallest_from(farthest_first, no_return * (1.0 - JITTER)));
        }
        start = end;
    }
    None
}

/// The most frequent of some sorted readings.
fn most_frequent(sorted: &[f32]) -> f32 {
    let longest = sorted.chunk_by(|a, b| a == b).max_by_key(|run| run.len());
    longest.map_or(f32::NAN, |run| run[0])
}

fn smallest_from(farthest_first: &[f32], limit: f32) -> f32 {
    let end = farthest_first.partition_point(|r| *r >= limit);
    farthest_first[..end].last().copied().unwrap_or(limit)
}

fn seen_from_places(readings: ArrayView2<f32>, poses: &[Pose], limit: f32) -> bool {
    let mut places = BTreeSet::new();
    for (scan, pose) in readings.rows().into_iter().zip(poses) {
        if scan.iter().any(|r| is_distance(*r) && *r >= limit) {
            places.insert((pose.x_m.floor() as i64, pose.y_m.floor() as i64));
            if places.len() >= PLACES {
                return true;
            }
        }
    }
    false
}

/// Makes a maximum hold for all channels in metres: readings from it on become "no return".
pub(super) fn limit_channels_in_metres(columns: &mut Columns, maximum_m: f64) {
    let mut first = 0;
    for channel in &mut columns.channels {
        let end = first + channel.width;
        if channel.unit == "m" {
            let values = columns.values.slice_axis_mut(Axis(1), (first..end).into());
            blank_no_returns(values, Some(maximum_m));
            channel.maximum = Some(maximum_m);
        }
        first = end;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use ndarray::{Array2, array};
    use rand::RngExt;

    fn walk(k: usize) -> Vec<Pose> {
        (0..k)
            .map(|k| Pose::new(k as f64 / 2.0, 0.0, 0.0))
            .collect()
    }

    /// Distances that thin out towards 30 m, to the centimetre.
    fn distances(k: usize, beams: usize) -> Array2<f32> {
        let mut stream = Seed(1).stream("distances");
        Array2::from_shape_fn((k, beams), |_| {
            let u: f32 = stream.random();
            ((0.5 + 29.5 * u * u) * 100.0).round() / 100.0
        })
    }

    #[test]
    fn ordinary_readings_have_no_maximum() {
        assert_eq!(no_return_from(distances(300, 40).view(), &walk(300)), None);
        // Cut off by the driver at 10 m, as some do: the densest band is then the last, but no pile.
        let cut = distances(300, 40).mapv(|r| if r < 10.0 { r } else { f32::NAN });
        assert_eq!(no_return_from(cut.view(), &walk(300)), None);
        assert_eq!(no_return_from(array![[3.0f32]].view(), &walk(1)), None);
        assert_eq!(
            no_return_from(Array2::from_elem((9, 4), f32::NAN).view(), &walk(9)),
            None
        );
    }

    #[test]
    fn a_pile_with_jitter_is_found_though_distances_reach_it() {
        let mut readings = distances(300, 40);
        for k in 0..300 {
            readings[[k, k % 40]] = [30.66, 30.7, 30.66][k % 3];
        }
        assert_eq!(no_return_from(readings.view(), &walk(300)), Some(30.66));
        readings[[7, 7]] = 327.67; // a stray glitch beyond hides nothing
        assert_eq!(no_return_from(readings.view(), &walk(300)), Some(30.66));
    }

    #[test]
    fn a_far_wall_seen_from_one_place_is_a_distance() {
        let mut readings = distances(300, 40);
        readings.column_mut(3).fill(45.0);
        let standing = vec![Pose::new(2.0, 2.0, 0.0); 300];
        assert_eq!(no_return_from(readings.view(), &standing), None);
        assert_eq!(no_return_from(readings.view(), &walk(300)), Some(45.0));
    }

    #[test]
    fn sick_codes_need_no_statistics() {
        let readings = array![[1.0f32, 81.91, 81.83]];
        assert_eq!(no_return_from(readings.view(), &walk(1)), Some(81.83));
        let beyond = array![[1.0f32, 81.91, 120.0]];
        assert_eq!(no_return_from(beyond.view(), &walk(1)), None);
    }

    #[test]
    fn blanking_spares_what_is_below_the_maximum() {
        let mut readings = array![[1.0f32, 81.83, 0.0, -2.0, f32::INFINITY, 81.82]];
        assert_eq!(blank_no_returns(readings.view_mut(), Some(81.83)), 4);
        assert_eq!((readings[[0, 0]], readings[[0, 5]]), (1.0, 81.82));
    }
}
