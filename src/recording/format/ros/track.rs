//! A pose over time: stamped samples, and what holds between them.

use crate::geometry::Pose;
use nalgebra::{Isometry3, Vector3};

/// How far in time a reading, a pose or a transform may be from the moment it is used for, in seconds.
pub(super) const TOLERANCE_S: f64 = 0.5;
/// Between two samples nearer to each other than this (metres, radians) the robot stood still, however long it took.
const STILL: f64 = 0.1;

/// What is known at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Lookup<T> {
    Found(T),
    /// Before the first sample or after the last.
    Outside,
    /// Between two samples, both of them too far in time.
    Missing,
}

impl<T> Lookup<T> {
    pub(super) fn found(self) -> Option<T> {
        match self {
            Lookup::Found(value) => Some(value),
            _ => None,
        }
    }

    pub(super) fn map<U>(self, f: impl FnOnce(T) -> U) -> Lookup<U> {
        match self {
            Lookup::Found(value) => Lookup::Found(f(value)),
            Lookup::Outside => Lookup::Outside,
            Lookup::Missing => Lookup::Missing,
        }
    }

    /// Both values, or why one of them isn't there.
    pub(super) fn and<U>(self, other: Lookup<U>) -> Lookup<(T, U)> {
        match (self, other) {
            (Lookup::Found(a), Lookup::Found(b)) => Lookup::Found((a, b)),
            (Lookup::Outside, _) | (_, Lookup::Outside) => Lookup::Outside,
            _ => Lookup::Missing,
        }
    }
}

/// Samples in the order of time.
#[derive(Debug, Clone, Default)]
pub(super) struct Track {
    samples: Vec<(f64, Isometry3<f64>)>,
}

impl Track {
    /// Of samples with one stamp the last counts.
    pub(super) fn new(mut samples: Vec<(f64, Isometry3<f64>)>) -> Self {
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        samples.reverse();
        samples.dedup_by(|later, earlier| later.0 == earlier.0);
        samples.reverse();
        Self { samples }
    }

    /// The pose at a moment: between the samples around it in proportion of time, position along the straight line and
    /// rotation along the shortest turn.
    pub(super) fn at(&self, stamp_s: f64) -> Lookup<Isometry3<f64>> {
        let next = self.samples.partition_point(|(s, _)| *s < stamp_s);
        let before = next.checked_sub(1).map(|i| self.samples[i]);
        match (before, self.samples.get(next).copied()) {
            (_, Some((after_s, after))) if after_s == stamp_s => Lookup::Found(after),
            (Some((before_s, before)), Some((after_s, after))) => {
                let near = (stamp_s - before_s).min(after_s - stamp_s) <= TOLERANCE_S;
                if near || stood_still(&before, &after) {
                    let share = (stamp_s - before_s) / (after_s - before_s);
                    Lookup::Found(between(&before, &after, share))
                } else {
                    Lookup::Missing
                }
            }
            (Some((at_s, pose)), None) | (None, Some((at_s, pose))) => {
                if (stamp_s - at_s).abs() <= TOLERANCE_S {
                    Lookup::Found(pose)
                } else {
                    Lookup::Outside
                }
            }
            (None, None) => Lookup::Outside,
        }
    }

    /// The sample nearest in time, however far.
    pub(super) fn nearest(&self, stamp_s: f64) -> Option<Isometry3<f64>> {
        nearest_index(&self.samples, |(s, _)| *s, stamp_s).map(|i| self.samples[i].1)
    }

    /// Longest time without a sample between two moments, in seconds.
    pub(super) fn longest_silence_s(&self, from_s: f64, to_s: f64) -> f64 {
        let first = self.samples.partition_point(|(s, _)| *s <= from_s);
        let inside = self.samples[first..].iter().map(|(s, _)| *s);
        let moments = inside.take_while(|s| *s < to_s).chain([to_s]);
        let mut last_s = from_s;
        moments.fold(0.0, |longest: f64, s| {
            let silence = s - last_s;
            last_s = s;
            longest.max(silence)
        })
    }
}

/// Index of the item nearest in time, of items in the order of time; of two equally near the earlier.
pub(super) fn nearest_index<T>(
    items: &[T],
    stamp: impl Fn(&T) -> f64,
    stamp_s: f64,
) -> Option<usize> {
    let next = items.partition_point(|item| stamp(item) < stamp_s);
    let apart = |i: &usize| (stamp(&items[*i]) - stamp_s).abs();
    let around = [next.checked_sub(1), (next < items.len()).then_some(next)];
    let around = around.into_iter().flatten();
    around.min_by(|a, b| apart(a).total_cmp(&apart(b)))
}

fn stood_still(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    let apart_m = (a.translation.vector - b.translation.vector).norm();
    apart_m <= STILL && a.rotation.angle_to(&b.rotation) <= STILL
}

fn between(a: &Isometry3<f64>, b: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let position = a.translation.vector.lerp(&b.translation.vector, share);
    // No shortest turn between opposite rotations: the nearer one then.
    let rotation = a.rotation.try_slerp(&b.rotation, share, 1e-9);
    let nearer = if share < 0.5 { a.rotation } else { b.rotation };
    Isometry3::from_parts(position.into(), rotation.unwrap_or(nearer))
}

/// The pose on the floor: x, y, and where the x axis points seen from above.
pub(super) fn on_the_floor(pose: &Isometry3<f64>) -> Pose {
    let ahead = pose.rotation * Vector3::x();
    let position = pose.translation.vector;
    Pose::new(position.x, position.y, ahead.y.atan2(ahead.x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};
    use std::f64::consts::PI;

    fn at(x_m: f64, yaw_rad: f64) -> Isometry3<f64> {
        Isometry3::from_parts(
            Translation3::new(x_m, 0.0, 0.0),
            UnitQuaternion::from_euler_angles(0.0, 0.0, yaw_rad),
        )
    }

    fn floor(track: &Track, stamp_s: f64) -> Lookup<Pose> {
        track.at(stamp_s).map(|pose| on_the_floor(&pose))
    }

    #[test]
    fn between_samples_time_decides_and_the_turn_is_the_short_one() {
        let track = Track::new(vec![(2.0, at(4.0, PI - 0.1)), (1.0, at(0.0, 0.1 - PI))]);
        let pose = floor(&track, 1.25).found().unwrap();
        assert!((pose.x_m - 1.0).abs() < 1e-12);
        assert!(
            pose.turn_rad(&Pose::new(0.0, 0.0, 0.05 - PI)) < 1e-9,
            "{pose:?}"
        );
    }

    #[test]
    fn nothing_is_made_up_where_nothing_was_recorded() {
        let track = Track::new(vec![(0.0, at(0.0, 0.0)), (9.0, at(5.0, 0.0))]);
        assert_eq!(floor(&track, -0.6), Lookup::Outside);
        assert_eq!(floor(&track, 9.6), Lookup::Outside);
        assert_eq!(floor(&track, 4.0), Lookup::Missing);
        assert!(floor(&track, 0.4).found().is_some() && floor(&track, -0.4).found().is_some());
        // Who stood still in between, was there all the time.
        let standing = Track::new(vec![(0.0, at(0.0, 0.0)), (9.0, at(0.05, 0.0))]);
        assert!(floor(&standing, 4.0).found().is_some());
        assert_eq!(track.longest_silence_s(1.0, 11.0), 8.0);
    }

    #[test]
    fn of_one_stamp_the_last_sample_counts() {
        let track = Track::new(vec![(1.0, at(1.0, 0.0)), (1.0, at(2.0, 0.0))]);
        assert_eq!(floor(&track, 1.0).found().unwrap().x_m, 2.0);
        assert_eq!(nearest_index(&[1.0, 2.0, 4.0], |s| *s, 2.9), Some(1));
        assert_eq!(nearest_index(&[1.0, 2.0, 4.0], |s| *s, 3.1), Some(2));
        assert_eq!(nearest_index(&[0.0; 0], |s| *s, 3.1), None);
    }
}
