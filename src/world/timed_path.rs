//! Where a robot is when: its poses with their times, and the way between them.

use crate::geometry::{Pose, wrapped};

/// A pose and when the robot is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimedPose {
    /// Seconds since the run began.
    pub stamp_s: f64,
    /// Where it truly is.
    pub pose: Pose,
}

/// Poses in the order of their times, joined by straight lines.
#[derive(Debug, Clone)]
pub(super) struct TimedPath {
    poses: Vec<TimedPose>,
    /// Way from the first pose to each, metres.
    way_m: Vec<f64>,
}

impl TimedPath {
    /// The path through at least one pose; times must not go back.
    pub fn new(poses: &[TimedPose]) -> Option<Self> {
        let ordered = poses.is_sorted_by(|a, b| a.stamp_s <= b.stamp_s);
        let finite = |timed: &TimedPose| timed.stamp_s.is_finite() && timed.pose.is_finite();
        if poses.is_empty() || !ordered || !poses.iter().all(finite) {
            return None;
        }
        let mut way_m = vec![0.0];
        for pair in poses.windows(2) {
            way_m.push(way_m[way_m.len() - 1] + pair[0].pose.distance_m(&pair[1].pose));
        }
        let poses = poses.to_vec();
        Some(Self { poses, way_m })
    }

    pub fn poses(&self) -> &[TimedPose] {
        &self.poses
    }

    /// Way from the first pose to each, metres.
    pub fn ways_m(&self) -> &[f64] {
        &self.way_m
    }

    /// The pose at a time and the way until there, metres; before and after all poses the first and the last.
    pub fn at_time(&self, stamp_s: f64) -> (Pose, f64) {
        let later = self.poses.partition_point(|timed| timed.stamp_s <= stamp_s);
        let span = |index: usize| self.poses[index].stamp_s;
        self.between(later, stamp_s, span)
    }

    /// The pose so far along the way, metres, and that way; before and after it the first and the last.
    pub fn at_way(&self, way_m: f64) -> (Pose, f64) {
        let later = self.way_m.partition_point(|&there_m| there_m <= way_m);
        self.between(later, way_m, |index| self.way_m[index])
    }

    /// Between the poses before and at `later`, as `at` lies between their coordinates.
    fn between(&self, later: usize, at: f64, coordinate: impl Fn(usize) -> f64) -> (Pose, f64) {
        let last = self.poses.len() - 1;
        let (a, b) = (later.saturating_sub(1), later.min(last));
        let span = coordinate(b) - coordinate(a);
        let share = if span > 0.0 {
            (at - coordinate(a)) / span
        } else {
            0.0
        };
        let (from, to) = (self.poses[a].pose, self.poses[b].pose);
        let turn_rad = wrapped(to.heading_rad - from.heading_rad);
        let pose = Pose::new(
            from.x_m + share * (to.x_m - from.x_m),
            from.y_m + share * (to.y_m - from.y_m),
            wrapped(from.heading_rad + share * turn_rad),
        );
        (
            pose,
            self.way_m[a] + share * (self.way_m[b] - self.way_m[a]),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_is_straight_between_poses_and_stands_still_at_its_ends() {
        let timed = |stamp_s, x_m, heading_rad| TimedPose {
            stamp_s,
            pose: Pose::new(x_m, 0.0, heading_rad),
        };
        // 2 m in 4 s, a stop of 6 s, and 1 m in 1 s.
        let poses = [
            timed(0.0, 0.0, 3.0),
            timed(4.0, 2.0, -3.0),
            timed(10.0, 2.0, -3.0),
            timed(11.0, 3.0, -3.0),
        ];
        let path = TimedPath::new(&poses).unwrap();
        for (at_s, x_m) in [
            (-1.0, 0.0),
            (1.0, 0.5),
            (4.0, 2.0),
            (7.0, 2.0),
            (10.5, 2.5),
            (99.0, 3.0),
        ] {
            let (pose, way_m) = path.at_time(at_s);
            assert!((pose.x_m - x_m).abs() < 1e-12 && (way_m - x_m).abs() < 1e-12);
        }
        // From 3 to −3 rad it turns through π, by 0.28 rad, not back through 0.
        let (pose, _) = path.at_time(2.0);
        assert!(wrapped(pose.heading_rad - std::f64::consts::PI).abs() < 1e-12);
        for way_m in [0.0, 0.7, 2.0, 2.9, 3.0] {
            let (pose, there_m) = path.at_way(way_m);
            assert!((pose.x_m - way_m).abs() < 1e-12 && (there_m - way_m).abs() < 1e-12);
        }
        assert_eq!(path.at_way(9.0).1, 3.0);
        assert!(TimedPath::new(&[]).is_none());
        assert!(TimedPath::new(&[poses[1], poses[0]]).is_none());
    }
}
