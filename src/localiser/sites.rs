//! Where in the plane a belief is: its cells of all headings together.

use super::{Estimate, Probable, Step};
use crate::{
    belief::{Belief, Grid, Places},
    geometry::Pose,
};

/// A place that holds less than this share of the likeliest one's probability is left out of a posterior.
const NEGLIGIBLE: f64 = 1e-6;

/// Where the sites of a grid lie in the plane: the cells of one heading.
#[derive(Debug, Clone)]
pub struct Sites(Vec<[f64; 2]>);

impl Sites {
    /// The sites of a grid over places whose poses are these, and, where it lies along a route, their coordinates on it, in
    /// metres. Along a route a site lies on the straight line between the mapped places before and behind it.
    pub fn of(grid: &Grid, pose: &[Pose], route_m: Option<&[f64]>) -> Self {
        let sites = grid.len() / grid.headings();
        Self(match &**grid.places() {
            Places::Plane(cells) => cells[..sites].iter().map(|p| [p.x_m, p.y_m]).collect(),
            Places::Route(cells) => {
                let route = route_m.into_iter().flatten();
                let mut on_route: Vec<(f64, &Pose)> = route.copied().zip(pose).collect();
                on_route.sort_by(|a, b| a.0.total_cmp(&b.0));
                cells.iter().map(|&x_m| between(&on_route, x_m)).collect()
            }
        })
    }

    /// Where a cell lies.
    pub fn place(&self, cell: usize) -> [f64; 2] {
        self.0[cell % self.0.len()]
    }

    /// What a localiser with this belief says: the place and heading of its mode, and how probable each place is.
    pub fn step(&self, belief: &Belief) -> Step {
        let is_plane = matches!(**belief.places(), Places::Plane(_));
        Step {
            estimate: Some(Estimate::Place(self.place(belief.mode()))),
            heading_rad: is_plane.then(|| belief.mode_heading_rad()),
            posterior: self.posterior(belief),
        }
    }

    /// The belief of a place in the plane: its cells of all headings together.
    fn posterior(&self, belief: &Belief) -> Vec<Probable> {
        let sites = &self.0;
        let mut mass = vec![0.0; sites.len()];
        for cells in belief.mass().chunks(sites.len()) {
            mass.iter_mut().zip(cells).for_each(|(m, cell)| *m += cell);
        }
        let least = NEGLIGIBLE * mass.iter().copied().fold(0.0, f64::max);
        let kept = || mass.iter().zip(sites).filter(|(m, _)| **m > least);
        let total: f64 = kept().map(|(m, _)| m).sum();
        kept().map(|(m, place)| (*place, m / total)).collect()
    }
}

/// The point at `x_m` along the route; past an end, the end. `on_route` is sorted and not empty.
fn between(on_route: &[(f64, &Pose)], x_m: f64) -> [f64; 2] {
    let behind = on_route.partition_point(|place| place.0 < x_m);
    let (from, from_at) = on_route[behind.saturating_sub(1)];
    let (to, to_at) = on_route[behind.min(on_route.len() - 1)];
    let share = if to > from {
        ((x_m - from) / (to - from)).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let mixed = |from_m: f64, to_m: f64| from_m + share * (to_m - from_m);
    [mixed(from_at.x_m, to_at.x_m), mixed(from_at.y_m, to_at.y_m)]
}
