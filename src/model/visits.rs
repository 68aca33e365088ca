//! Training snapshots near a pose: what was seen there, beside what a map says is to be seen.

use crate::geometry::{Pose, wrapped};
use rstar::{RTree, primitives::GeomWithData};

/// A snapshot was taken at a pose if it was taken within this distance of it, in metres, …
const WITHIN_M: f64 = 0.25;
/// … and turned by no more than this, in radians: a cell of the usual grid is 0.25 m wide and 15° deep.
const WITHIN_RAD: f64 = 0.15;

/// Where training snapshots were taken.
pub(super) struct Visits<'a> {
    pose: &'a [Pose],
    tree: RTree<GeomWithData<[f64; 2], usize>>,
}

impl<'a> Visits<'a> {
    pub(super) fn new(pose: &'a [Pose]) -> Self {
        let entry = |(k, pose): (usize, &Pose)| GeomWithData::new([pose.x_m, pose.y_m], k);
        Self {
            pose,
            tree: RTree::bulk_load(pose.iter().enumerate().map(entry).collect()),
        }
    }

    /// The snapshots that were taken at a pose, ascending.
    pub(super) fn at(&self, pose: &Pose) -> Vec<usize> {
        let near = self
            .tree
            .locate_within_distance([pose.x_m, pose.y_m], WITHIN_M * WITHIN_M);
        let turned_rad = |k: usize| wrapped(self.pose[k].heading_rad - pose.heading_rad).abs();
        let mut here: Vec<usize> = near
            .map(|found| found.data)
            .filter(|&k| turned_rad(k) <= WITHIN_RAD)
            .collect();
        here.sort_unstable();
        here
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_snapshot_is_of_a_pose_nearby_and_turned_little() {
        let pose = [(0.0, PI - 0.05), (0.2, -PI + 0.05), (0.1, 0.0), (0.3, PI)]
            .map(|(x_m, heading_rad)| Pose::new(x_m, 0.0, heading_rad));
        let visits = Visits::new(&pose);
        assert_eq!(visits.at(&Pose::new(0.0, 0.0, PI)), [0, 1]);
        assert_eq!(visits.at(&Pose::new(0.1, 0.2, 0.1)), [2]);
        assert!(visits.at(&Pose::new(0.1, 0.0, PI / 2.0)).is_empty());
    }
}
