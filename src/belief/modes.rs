//! The separate places that a belief holds for likely.

use super::{belief::Belief, places::Places};
use crate::geometry::{Pose, wrapped};
use serde::{Deserialize, Serialize};
use std::{collections::BTreeMap, f64::consts::FRAC_PI_2};

/// A peak of a belief.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Mode {
    /// Its likeliest place; along a route `x_m` is the coordinate and the rest is 0.
    pub pose: Pose,
    /// What the belief gives to the places around it, likelier modes' own aside.
    pub mass: f64,
}

impl Belief {
    /// The separate peaks that hold at least `least_share` of the mass, the heaviest peak first: places likelier than all others
    /// within `within_m` metres and a quarter turn, each with the mass of these places. What lies near two peaks counts for the
    /// likelier one. A belief that is spread over more room than that has no mode at all: the robot is nowhere in particular.
    ///
    /// ```
    /// use ballmark::belief::{Belief, Places};
    /// // Two doors that look alike, and a little mass in between.
    /// let corridor = std::sync::Arc::new(Places::Route((0..20).map(f64::from).collect()));
    /// let mut mass = vec![0.004; 20];
    /// (mass[3], mass[4], mass[15]) = (0.4, 0.1, 0.43);
    /// let belief = Belief::from_mass(&corridor, mass)?;
    /// let modes = belief.modes(1.0, 0.05);
    /// let found: Vec<(f64, f64)> = modes.iter().map(|mode| (mode.pose.x_m, (100.0 * mode.mass).round())).collect();
    /// assert_eq!(found, [(3.0, 51.0), (15.0, 44.0)]);
    /// assert!(Belief::uniform(&corridor)?.modes(1.0, 0.2).is_empty());
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn modes(&self, within_m: f64, least_share: f64) -> Vec<Mode> {
        let (places, mass) = (self.places(), self.mass());
        // A peak of that share needs a place of at least the share's part.
        let index = Index::new(places, mass, within_m);
        let least = least_share / index.most_together as f64;
        let mut order: Vec<usize> = (0..mass.len())
            .filter(|&k| mass[k] > 0.0 && mass[k] >= least)
            .collect();
        order.sort_by(|&a, &b| mass[b].total_cmp(&mass[a]).then(a.cmp(&b)));
        let mut taken = vec![false; mass.len()];
        let mut modes: Vec<Mode> = Vec::new();
        for cell in order {
            if taken[cell] {
                continue;
            }
            let near = index.near(places, cell);
            let is_peak = |&k: &usize| mass[k] < mass[cell] || (mass[k] == mass[cell] && k >= cell);
            if !near.iter().all(is_peak) {
                continue; // the flank of another
            }
            let free = near.iter().filter(|k| !taken[**k]);
            let held: f64 = free.map(|&k| mass[k]).sum();
            near.iter().for_each(|&k| taken[k] = true);
            if held >= least_share {
                modes.push(Mode {
                    pose: places.pose(cell),
                    mass: held,
                });
            }
        }
        modes.sort_by(|a, b| b.mass.total_cmp(&a.mass));
        modes
    }
}

/// Places with mass by squares as wide as a mode, so that those near a place are found at once.
struct Index {
    squares: BTreeMap<[i64; 2], Vec<usize>>,
    within_m: f64,
    /// No place has more places with mass near it than this.
    most_together: usize,
}

impl Index {
    fn new(places: &Places, mass: &[f64], within_m: f64) -> Self {
        let mut index = Self {
            squares: BTreeMap::new(),
            within_m: within_m.max(1e-6),
            most_together: 1,
        };
        for cell in (0..mass.len()).filter(|&k| mass[k] > 0.0) {
            let square = index.square(&places.pose(cell));
            index.squares.entry(square).or_default().push(cell);
        }
        let around = |at: &[i64; 2]| index.around(*at).map(Vec::len).sum();
        index.most_together = index.squares.keys().map(around).max().unwrap_or(1).max(1);
        index
    }

    fn square(&self, pose: &Pose) -> [i64; 2] {
        [pose.x_m, pose.y_m].map(|v| (v / self.within_m).floor() as i64)
    }

    /// What lies in a square and the eight around it.
    fn around(&self, [x, y]: [i64; 2]) -> impl Iterator<Item = &Vec<usize>> {
        let squares = (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
        squares.filter_map(|square| self.squares.get(&square))
    }

    /// Places with mass within reach of a place and a quarter turn, itself among them.
    fn near(&self, places: &Places, cell: usize) -> Vec<usize> {
        let here = places.pose(cell);
        let is_near = |&&k: &&usize| {
            let there = places.pose(k);
            here.distance_m(&there) <= self.within_m
                && wrapped(here.heading_rad - there.heading_rad).abs() <= FRAC_PI_2
        };
        let around = self.around(self.square(&here));
        around.flatten().filter(is_near).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{f64::consts::PI, sync::Arc};

    fn plane(poses: &[[f64; 3]], mass: &[f64]) -> Belief {
        let poses = poses.iter().map(|&[x, y, h]| Pose::new(x, y, h));
        let places = Arc::new(Places::Plane(poses.collect()));
        Belief::from_mass(&places, mass.to_vec()).unwrap()
    }

    #[test]
    fn a_robot_that_may_look_either_way_has_two_modes_at_one_place() {
        let belief = plane(
            &[
                [1.0, 2.0, 0.1],
                [1.5, 2.0, 0.3],
                [1.0, 2.0, PI],
                [9.0, 9.0, 0.0],
            ],
            &[0.4, 0.15, 0.43, 0.02],
        );
        let modes = belief.modes(1.0, 0.05);
        let masses: Vec<f64> = modes.iter().map(|mode| mode.mass).collect();
        assert_eq!(modes.len(), 2, "{modes:?}");
        assert!((masses[0] - 0.55).abs() < 1e-12 && (masses[1] - 0.43).abs() < 1e-12);
        // The heaviest first, though a single place of the other is likelier.
        assert_eq!(modes[0].pose, Pose::new(1.0, 2.0, 0.1));
    }

    #[test]
    fn a_flank_is_no_mode_and_what_is_between_counts_once() {
        let places = Arc::new(Places::Route(vec![0.0, 0.9, 1.8, 5.0]));
        let belief = Belief::from_mass(&places, vec![0.4, 0.3, 0.2, 0.1]).unwrap();
        // 1.8 lies near 0.9, which is likelier: a flank, and part of no mode.
        let modes = belief.modes(1.0, 0.05);
        let found: Vec<f64> = modes.iter().map(|mode| mode.pose.x_m).collect();
        assert_eq!(found, [0.0, 5.0]);
        assert!((modes[0].mass - 0.7).abs() < 1e-12);
        let twins = Belief::from_mass(&places, vec![0.4, 0.2, 0.4, 0.0]).unwrap();
        let masses: Vec<f64> = twins.modes(1.0, 0.05).iter().map(|m| m.mass).collect();
        assert!((masses[0] - 0.6).abs() < 1e-12 && (masses[1] - 0.4).abs() < 1e-12);
    }

    #[test]
    fn a_spread_belief_has_no_mode() {
        let poses: Vec<[f64; 3]> = (0..900)
            .map(|k| [(k % 30) as f64 * 0.5, (k / 30) as f64 * 0.5, 0.0])
            .collect();
        let belief = plane(&poses, &[1.0; 900]);
        assert!(belief.modes(1.0, 0.05).is_empty());
        assert!(!belief.modes(1.0, 0.005).is_empty());
    }
}
