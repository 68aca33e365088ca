//! Which snapshots of a long log come into a map.
//!
//! Every method holds what is sensed against the places of the map, so that a map of all snapshots of a day's drive takes time with
//! the square of the day, and tells no more: a corridor that was driven a hundred times needs no hundred snapshots a step of the way.

use super::places::Places;
use std::{collections::BTreeMap, f64::consts::TAU};

/// Edge of the smallest box of places, in metres; it is doubled until no more boxes than snapshots that may stay are filled.
const BOX_M: f64 = 0.1;

/// Headings that places of a box are told apart by.
const HEADINGS: f64 = 24.0;

/// Which of some places come into a map of `most` at most, ascending; 0: all of them.
///
/// Each is in a box of the plane and of headings, or of the route. Boxes with few snapshots keep all of theirs, and the others all the
/// same number, evenly over time: where a robot stood for hours it leaves no more behind than where it passed.
///
/// ```
/// use ballmark::belief::{Places, thinning::thinned};
/// // An hour at the charger, and one walk of 5 m.
/// let places = Places::Route((0..3600).map(|k| (k - 3550).max(0) as f64 * 0.1).collect());
/// let kept = thinned(&places, 100);
/// assert!(kept.len() <= 100);
/// assert_eq!(kept.iter().filter(|&&k| k > 3550).count(), 49);
/// assert_eq!(thinned(&places, 0).len(), 3600);
/// ```
pub fn thinned(places: &Places, most: usize) -> Vec<usize> {
    if most == 0 || places.len() <= most {
        return (0..places.len()).collect();
    }
    let mut edge_m = BOX_M;
    let boxes = loop {
        let boxes = boxed(places, edge_m);
        if boxes.len() <= most || edge_m > f64::MAX / 4.0 {
            break boxes;
        }
        edge_m *= 2.0;
    };
    let of_each = most_of_each(boxes.iter().map(Vec::len), most);
    let mut kept: Vec<usize> = boxes.iter().flat_map(|all| evenly(all, of_each)).collect();
    kept.sort_unstable();
    kept.truncate(most); // places farther apart than numbers tell are one a box at any edge
    kept
}

/// Those of some snapshots, of all that were taken at `places`, that come into a map of `most` places at most, see [`thinned`].
pub fn thinned_snapshots(places: &Places, snapshots: &[usize], most: usize) -> Vec<usize> {
    let kept = thinned(&places.select(snapshots), most);
    kept.into_iter().map(|row| snapshots[row]).collect()
}

/// The places of each box, ascending.
fn boxed(places: &Places, edge_m: f64) -> Vec<Vec<usize>> {
    let mut boxes: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for k in 0..places.len() {
        let pose = places.pose(k);
        let heading = (pose.heading_rad.rem_euclid(TAU) / TAU * HEADINGS) as i64;
        let along = |metres: f64| (metres / edge_m).floor() as i64;
        let at = [along(pose.x_m), along(pose.y_m), heading];
        boxes.entry(at).or_default().push(k);
    }
    boxes.into_values().collect()
}

/// The number that every box may keep so that all together keep no more than `most`; 1 at least.
fn most_of_each(sizes: impl Iterator<Item = usize> + Clone, most: usize) -> usize {
    let kept = |of_each: usize| -> usize { sizes.clone().map(|size| size.min(of_each)).sum() };
    let (mut enough, mut too_many) = (1, most + 1);
    while too_many - enough > 1 {
        let middle = enough.midpoint(too_many);
        match kept(middle) <= most {
            true => enough = middle,
            false => too_many = middle,
        }
    }
    enough
}

/// So many of some numbers, spread over all of them.
fn evenly(all: &[usize], most: usize) -> impl Iterator<Item = usize> + '_ {
    let kept = all.len().min(most);
    (0..kept).map(move |k| all[(2 * k + 1) * all.len() / (2 * kept)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    /// Where there is room for all, all stay; there are never more than asked for, and whatever was passed once stays.
    #[test]
    fn a_short_log_stays_whole_and_a_long_one_keeps_every_place() {
        let ring = |k: usize| {
            let angle = k as f64 * 0.01;
            Pose::new(10.0 * angle.cos(), 10.0 * angle.sin(), angle)
        };
        let mut poses: Vec<Pose> = (0..20_000).map(ring).collect();
        poses.extend((0..50).map(|k| Pose::new(30.0 + k as f64, 5.0, 0.0)));
        let places = Places::Plane(poses);
        assert_eq!(thinned(&places, 20_050), (0..20_050).collect::<Vec<_>>());
        let kept = thinned(&places, 4000);
        assert!((3500..=4000).contains(&kept.len()), "{}", kept.len());
        assert!(kept.is_sorted_by(|a, b| a < b));
        assert!((20_000..20_050).all(|k| kept.contains(&k)));
        // Every lap gives as much as every other, and every stretch of the ring.
        let laps = kept.iter().filter(|&&k| k < 10_000).count();
        let half = (kept.len() - 50) / 2;
        assert!(laps.abs_diff(half) < half / 10, "{laps} of {half}");
        let turn = |k: usize| (k as f64 * 0.01).rem_euclid(TAU);
        for sector in 0..60 {
            let is_in = |k: &&usize| **k < 20_000 && (turn(**k) / TAU * 60.0) as usize == sector;
            let inside = kept.iter().filter(is_in).count();
            assert!(inside > half / 60, "sector {sector}: {inside}");
        }
    }

    /// Few places far apart: one of a neighbourhood, and no more than asked for, even where numbers no longer tell them apart.
    #[test]
    fn boxes_grow_until_few_enough_are_left() {
        let far = Places::Route((0..1000).map(|k| k as f64 * 50.0).collect());
        let kept = thinned(&far, 10);
        assert!((5..=10).contains(&kept.len()), "{kept:?}");
        let apart = Places::Route((0..64).map(|k| (k as f64 - 32.0) * 1e300).collect());
        assert!(thinned(&apart, 3).len() <= 3);
        let standing = Places::Plane(vec![Pose::new(1.0, 1.0, 0.0); 500]);
        assert_eq!(thinned(&standing, 7).len(), 7);
    }
}
