//! Which training places are nearest to a place: the map asks it, and so does any likelihood made from raw snapshots.

use super::places::Places;
use crate::{
    error::{Error, Result},
    geometry::Pose,
};
use rayon::prelude::*;
use rstar::{RTree, primitives::GeomWithData};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// What near means. Thrun (1998, 5.1.6) takes the Euclidean distance in a corridor that is driven along one way; where
/// robots turn, a heading must weigh something.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Nearness {
    /// k: how many nearest training places count.
    pub k: usize,
    /// ρ: metres that a radian of heading counts for; nearness is Euclidean in (x, y, ρθ). Without meaning along a route.
    pub metres_per_radian: f64,
    /// A place farther than this from every training place, in the same metric, is unmapped, in metres.
    pub reach_m: f64,
}

impl Default for Nearness {
    fn default() -> Self {
        Self {
            k: 5,
            metres_per_radian: 1.0,
            reach_m: 1.0,
        }
    }
}

/// The k nearest training places of each of some places, nearest first; of equally near ones, the earlier.
///
/// ```
/// use ballmark::belief::{Nearness, Neighbours, Places};
/// let training = Places::Route(vec![0.0, 1.0, 5.0, 6.0]);
/// let nearness = Nearness { k: 2, ..Nearness::default() };
/// let near = Neighbours::find(&training, &Places::Route(vec![5.1, 3.0]), &nearness)?;
/// assert_eq!(near.of(0), [2, 3]);
/// assert!(near.is_mapped(0) && !near.is_mapped(1));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Neighbours {
    k: usize,
    reach_m: f64,
    index: Vec<usize>,
    distance_m: Vec<f64>,
}

/// A training place, or a copy of it one round further, in (x, y, ρθ).
type Entry = GeomWithData<[f64; 3], usize>;

impl Neighbours {
    /// The k nearest of `training` to each place of `queries`.
    ///
    /// # Errors
    /// Where `training` has fewer than k places, a key of `nearness` makes no sense, or one set of places lies along a
    /// route and the other in the plane.
    pub fn find(training: &Places, queries: &Places, nearness: &Nearness) -> Result<Self> {
        nearness.check(training.len())?;
        let rho = nearness.metres_per_radian;
        let found: Vec<(usize, f64)> = match (training, queries) {
            (Places::Route(training), Places::Route(queries)) => {
                let line = Line::new(training);
                let queries = queries.par_iter();
                queries
                    .flat_map_iter(|x| line.nearest(*x, nearness.k))
                    .collect()
            }
            (Places::Plane(training), Places::Plane(queries)) => {
                // 359° and 1° are near: each place is there three times, a round apart.
                let copies = |k: usize| {
                    let pose = training[k];
                    let heading = pose.heading_rad.rem_euclid(TAU);
                    [-TAU, 0.0, TAU]
                        .map(|round| Entry::new([pose.x_m, pose.y_m, rho * (heading + round)], k))
                };
                let tree = RTree::bulk_load((0..training.len()).flat_map(copies).collect());
                let at = |p: &Pose| [p.x_m, p.y_m, rho * p.heading_rad.rem_euclid(TAU)];
                let queries = queries.par_iter();
                queries
                    .flat_map_iter(|pose| nearest(&tree, &at(pose), nearness.k))
                    .collect()
            }
            _ => {
                return Err(Error::work(
                    "map: its places lie along a route and those asked for in the plane, or the other way round",
                ));
            }
        };
        Ok(Self {
            k: nearness.k,
            reach_m: nearness.reach_m,
            index: found.iter().map(|f| f.0).collect(),
            distance_m: found.iter().map(|f| f.1).collect(),
        })
    }

    /// k.
    pub fn k(&self) -> usize {
        self.k
    }

    /// Number of places asked for.
    pub fn len(&self) -> usize {
        self.index.len() / self.k
    }

    /// Was no place asked for?
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// Indices of the k training places nearest to place `query`, nearest first.
    pub fn of(&self, query: usize) -> &[usize] {
        &self.index[query * self.k..(query + 1) * self.k]
    }

    /// How far these are, in metres of the metric that was asked for.
    pub fn distance_m(&self, query: usize) -> &[f64] {
        &self.distance_m[query * self.k..(query + 1) * self.k]
    }

    /// Is a training place within reach?
    pub fn is_mapped(&self, query: usize) -> bool {
        self.distance_m(query)[0] <= self.reach_m
    }
}

impl Nearness {
    /// Do the numbers make sense, for so many training places?
    ///
    /// # Errors
    /// Where `k` is 0 or there are fewer places, or a distance is no positive number.
    pub fn check(&self, training: usize) -> Result<()> {
        if self.k == 0 {
            return Err(Error::usage("map: `k` is 0; expected 1 or more"));
        }
        for (name, value) in [
            ("metres_per_radian", self.metres_per_radian),
            ("reach_m", self.reach_m),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::usage(format!(
                    "map: `{name}` is {value}; expected 0 or more"
                )));
            }
        }
        if training < self.k {
            return Err(Error::work(format!(
                "map: {training} training snapshots; expected at least k = {}",
                self.k
            )));
        }
        Ok(())
    }
}

/// Places along a route in the order of the route. A tree over one dimension of three would have boxes that all overlap.
struct Line(Vec<(f64, usize)>);

impl Line {
    fn new(places: &[f64]) -> Self {
        let mut all: Vec<(f64, usize)> = places.iter().copied().zip(0..).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(all)
    }

    /// The k nearest and their distances; of equally near ones the earlier.
    fn nearest(&self, x: f64, k: usize) -> Vec<(usize, f64)> {
        let mut above = self.0.partition_point(|(at, _)| *at < x);
        let mut below = above;
        let square = |place: usize| self.0.get(place).map(|(at, _)| (at - x) * (at - x));
        let mut found: Vec<(f64, usize)> = Vec::with_capacity(k + 1);
        loop {
            let left = below.checked_sub(1).and_then(square);
            let right = square(above);
            let (next, square) = match (left, right) {
                (None, None) => break,
                (Some(left), right) if right.is_none_or(|right| left <= right) => {
                    below -= 1;
                    (below, left)
                }
                (_, right) => {
                    above += 1;
                    (above - 1, right.unwrap_or(f64::INFINITY))
                }
            };
            // All that are as near as the k-th are looked at.
            if found.len() >= k && square > found[k - 1].0 {
                break;
            }
            found.push((square, self.0[next].1));
        }
        first(found, k)
    }
}

/// The k nearest and their distances. The tree gives equally near ones in an order of its own, so all that are as near as
/// the k-th are looked at.
fn nearest(tree: &RTree<Entry>, query: &[f64; 3], k: usize) -> Vec<(usize, f64)> {
    let mut found: Vec<(f64, usize)> = Vec::with_capacity(k + 1);
    for (entry, square) in tree.nearest_neighbor_iter_with_distance_2(*query) {
        // The first copy of a place is its nearest.
        if found.iter().any(|f| f.1 == entry.data) {
            continue;
        }
        if found.len() >= k && square > found[k - 1].0 {
            break;
        }
        found.push((square, entry.data));
    }
    first(found, k)
}

/// The first k of what was found, nearest first, of equally near ones the earlier, with their distances.
fn first(mut found: Vec<(f64, usize)>, k: usize) -> Vec<(usize, f64)> {
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.truncate(k);
    found
        .into_iter()
        .map(|(square, k)| (k, square.sqrt()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use rand::RngExt;

    fn scattered(name: &str, n: usize) -> Places {
        let mut random = Seed(3).stream(name);
        let mut uniform = |width: f64| width * (random.random::<f64>() - 0.5);
        // Some headings outside of (−π, π], as logs have them.
        let poses = (0..n).map(|_| Pose::new(uniform(4.0), uniform(4.0), uniform(14.0)));
        Places::Plane(poses.collect())
    }

    #[test]
    fn agree_with_brute_force_around_the_circle() {
        let (training, queries) = (scattered("training", 300), scattered("queries", 200));
        let nearness = Nearness {
            k: 7,
            metres_per_radian: 0.7,
            reach_m: 0.4,
        };
        let near = Neighbours::find(&training, &queries, &nearness).unwrap();
        let mut mapped = 0;
        for q in 0..queries.len() {
            let far = |k: usize| {
                let turn = 0.7 * queries.turn_rad(q, &training, k);
                queries.distance_m(q, &training, k).hypot(turn)
            };
            let mut order: Vec<usize> = (0..training.len()).collect();
            order.sort_by(|&a, &b| far(a).total_cmp(&far(b)));
            assert_eq!(near.of(q), &order[..7], "query {q}");
            assert!((near.distance_m(q)[6] - far(order[6])).abs() < 1e-12);
            assert_eq!(near.is_mapped(q), far(order[0]) <= 0.4);
            mapped += usize::from(near.is_mapped(q));
        }
        assert!(mapped > 20 && mapped < 180, "{mapped}");
    }

    #[test]
    fn agree_with_brute_force_along_a_route() {
        let mut random = Seed(4).stream("route");
        // Coarse, so that many are equally near, and some are at one place.
        let mut route = |n: usize| -> Vec<f64> {
            let mut place = || (random.random::<f64>() * 60.0).round() / 4.0 - 2.0;
            (0..n).map(|_| place()).collect()
        };
        let (training, queries) = (route(300), route(200));
        let places = |route: &Vec<f64>| Places::Route(route.clone());
        for k in [1, 5, 300] {
            let nearness = Nearness {
                k,
                ..Nearness::default()
            };
            let near = Neighbours::find(&places(&training), &places(&queries), &nearness).unwrap();
            for (q, x) in queries.iter().enumerate() {
                let far = |t: usize| (training[t] - x).abs();
                let mut order: Vec<usize> = (0..training.len()).collect();
                order.sort_by(|&a, &b| far(a).total_cmp(&far(b)).then(a.cmp(&b)));
                assert_eq!(near.of(q), &order[..k], "query {q}, {k} nearest");
                let distances = order[..k].iter().map(|&t| far(t));
                assert_eq!(near.distance_m(q), Vec::from_iter(distances));
            }
        }
    }

    #[test]
    fn equally_near_ones_come_in_their_order() {
        let training = Places::Plane(vec![Pose::new(1.0, 0.0, 0.0); 9]);
        let query = Places::Plane(vec![Pose::default()]);
        let nearness = Nearness {
            k: 4,
            ..Nearness::default()
        };
        let near = Neighbours::find(&training, &query, &nearness).unwrap();
        assert_eq!(near.of(0), [0, 1, 2, 3]);
    }

    #[test]
    fn too_few_snapshots_and_mixed_places_are_refused() {
        let few = scattered("few", 3);
        let error = Neighbours::find(&few, &few, &Nearness::default())
            .unwrap_err()
            .to_string();
        assert_eq!(error, "map: 3 training snapshots; expected at least k = 5");
        let none = Nearness {
            k: 0,
            ..Nearness::default()
        };
        assert!(Neighbours::find(&few, &few, &none).unwrap_err().is_usage());
        let one = Nearness {
            k: 1,
            ..Nearness::default()
        };
        assert!(Neighbours::find(&few, &Places::Route(vec![0.0]), &one).is_err());
    }
}
