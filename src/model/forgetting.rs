//! What a model forgets of a place that was visited anew.
//!
//! "… allowing the robot to 'forget' as well as to acquire map knowledge" (Duckett & Nehmzow 1998, section 10, of lasting changes as
//! Yamauchi tells them from transient ones). With n newer runs through its place a snapshot stays with probability 2^(−n / half-life),
//! drawn once. Forgetting so has no memory: it makes no difference whether the runs come at once or one by one, the file keeps no
//! ages, and a place that is visited again and again keeps about as many snapshots as 1 / (1 − 2^(−1 / half-life)) runs bring.

use crate::{
    belief::Places,
    learning::training_set::{COVERED_WITHIN_M, COVERED_WITHIN_RAD},
    seed::Stream,
};
use rand::RngExt;
use rstar::{RTree, primitives::GeomWithData};
use std::collections::BTreeSet;

/// Those of the old places, ascending, that stay. `runs` is the run of each new place; a new place is of an old one where training
/// would count it as [covered](crate::learning::training_set::covered).
pub(super) fn remembered(
    old: &Places,
    new: &Places,
    runs: &[usize],
    half_life: f64,
    random: &mut Stream,
) -> Vec<usize> {
    let at = |places: &Places, k: usize| {
        let pose = places.pose(k);
        [pose.x_m, pose.y_m]
    };
    let entry = |k| GeomWithData::new(at(new, k), k);
    let tree = RTree::bulk_load((0..new.len()).map(entry).collect());
    let newer_runs = |k: usize| {
        let near = tree.locate_within_distance(at(old, k), COVERED_WITHIN_M * COVERED_WITHIN_M);
        let near = near.map(|found| found.data);
        let faces = |n: &usize| old.turn_rad(k, new, *n) < COVERED_WITHIN_RAD;
        let runs: BTreeSet<usize> = near.filter(faces).map(|n| runs[n]).collect();
        runs.len()
    };
    let mut stays = |k: &usize| {
        let draw: f64 = random.random(); // one each, whatever comes of it
        draw < (-(newer_runs(*k) as f64) / half_life).exp2()
    };
    (0..old.len()).filter(|k| stays(k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{geometry::Pose, seed::Seed};

    fn kept(old: &Places, new: &Places, runs: &[usize], half_life: f64) -> Vec<usize> {
        let mut random = Seed(3).stream("a test");
        remembered(old, new, runs, half_life, &mut random)
    }

    /// Of 4,000 snapshots where two runs came by, as many stay as the law says; of those elsewhere, all.
    #[test]
    fn as_many_stay_as_the_half_life_says() {
        let old = Places::Route((0..8000).map(|k| k as f64 * 0.01).collect());
        let new = Places::Route((0..400).map(|k| (k % 200) as f64 * 0.2).collect());
        let runs: Vec<usize> = (0..400).map(|k| k / 200).collect();
        let kept = kept(&old, &new, &runs, 2.0);
        let (visited, elsewhere): (Vec<usize>, Vec<usize>) = kept.iter().partition(|k| **k < 3900);
        let share = visited.len() as f64 / 3900.0;
        assert!((share - 0.5).abs() < 0.03, "{share}");
        assert_eq!(elsewhere.iter().filter(|k| **k > 4050).count(), 8000 - 4051);
    }

    #[test]
    fn who_faces_another_way_visits_another_place() {
        let pose = |heading| Places::Plane(vec![Pose::new(1.0, 1.0, heading); 100]);
        let anew =
            |heading: f64, half_life| kept(&pose(0.0), &pose(heading), &[0; 100], half_life).len();
        assert_eq!(anew(3.0, 0.01), 100);
        assert_eq!(anew(0.1, 0.01), 0);
        assert_eq!(anew(0.1, f64::INFINITY), 100);
        // A hundred snapshots of one run are one visit.
        assert!((30..=70).contains(&anew(0.1, 1.0)));
    }
}
