//! The way of the first run: from goal to goal through the free space, smoothed, and the places on it.

use super::{GeneratedConfig, chance::Chance, free_space::FreeSpace};
use crate::{
    geometry::{Pose, wrapped},
    world::FloorPlan,
};
use nalgebra::Point2;

/// Goals nearer to the last one than so many cells are drawn again, so often.
const NEAR_CELLS: usize = 15;
const ATTEMPTS: usize = 20;
/// How strongly the robot prefers the middle, drawn a building.
const SHYNESS: [f64; 2] = [0.5, 6.0];
/// Fewest and most cells that the way is smoothed over.
const SMOOTHED_CELLS: [usize; 2] = [3, 8];
/// The robot looks to where it will be this much later on its way, from where it was as much earlier, metres.
const LOOK_M: f64 = 0.25;
/// How much its heading is off that: standard deviation, radians.
const HEADING_RAD: f64 = 0.03;
/// Nearer to a wall than this there is no place, metres.
const LEAST_CLEARANCE_M: f64 = 0.2;

/// Draws the poses of the first run.
pub(super) fn places(
    space: &FreeSpace,
    floor: &FloorPlan,
    config: &GeneratedConfig,
    chance: &mut Chance,
) -> Vec<Pose> {
    let wanted_m = chance.between(config.path_m[0], config.path_m[1]);
    let shyness = chance.between(SHYNESS[0], SHYNESS[1]);
    let line = Line::new(&smoothed(&goals(space, wanted_m, shyness, chance), chance));
    let length_m = line.length_m().min(wanted_m);
    let drawn_m = chance.between(config.spacing_m[0], config.spacing_m[1]);
    let spacing_m = drawn_m.max(length_m / config.places as f64);
    let count = ((length_m / spacing_m) as usize).min(config.places);
    let pose = |index: usize| {
        let at_m = (index as f64 + 0.5) * spacing_m;
        let ahead = line.at(at_m + LOOK_M) - line.at(at_m - LOOK_M);
        let heading_rad = ahead.y.atan2(ahead.x) + HEADING_RAD * chance.normal();
        let place = line.at(at_m);
        Pose::new(place.x, place.y, wrapped(heading_rad))
    };
    let poses = (0..count).map(pose);
    poses
        .filter(|pose| floor.clearance_m(&Point2::new(pose.x_m, pose.y_m)) >= LEAST_CLEARANCE_M)
        .collect()
}

/// The way over goals drawn at random until it is long enough.
fn goals(space: &FreeSpace, wanted_m: f64, shyness: f64, chance: &mut Chance) -> Vec<Point2<f64>> {
    let mut here = chance.one_of(space.cells());
    let mut way = vec![space.middle(here)];
    let (mut length_m, mut attempts) = (0.0, 0);
    while length_m < wanted_m && attempts < ATTEMPTS {
        let goal = chance.one_of(space.cells());
        let leg = space.way(here, goal, shyness);
        if leg.len() < NEAR_CELLS {
            attempts += 1;
            continue;
        }
        for cell in leg.into_iter().skip(1) {
            let next = space.middle(cell);
            length_m += (next - way[way.len() - 1]).norm();
            way.push(next);
        }
        here = goal;
    }
    way
}

/// Each point becomes the mean of those around it.
fn smoothed(way: &[Point2<f64>], chance: &mut Chance) -> Vec<Point2<f64>> {
    let [fewest, most] = SMOOTHED_CELLS;
    let width = fewest + chance.below(most - fewest + 1);
    let mean = |index: usize| {
        let begin = index.saturating_sub(width / 2);
        let around = &way[begin..(index + width.div_ceil(2)).min(way.len())];
        let sum = around
            .iter()
            .fold(Point2::origin(), |sum, p| sum + p.coords);
        sum / around.len() as f64
    };
    (0..way.len()).map(mean).collect()
}

/// A line through points, by the way along it.
struct Line {
    points: Vec<Point2<f64>>,
    /// Way to each point, rising, metres.
    way_m: Vec<f64>,
}

impl Line {
    /// The line through these points, of which there is at least one.
    fn new(points: &[Point2<f64>]) -> Self {
        let mut line = Self {
            points: vec![points[0]],
            way_m: vec![0.0],
        };
        for pair in points.windows(2) {
            let step_m = (pair[1] - pair[0]).norm();
            if step_m > 1e-9 {
                line.points.push(pair[1]);
                line.way_m.push(line.length_m() + step_m);
            }
        }
        line
    }

    fn length_m(&self) -> f64 {
        self.way_m.last().copied().unwrap_or(0.0)
    }

    /// The point after so many metres, no farther than the ends.
    fn at(&self, at_m: f64) -> Point2<f64> {
        let next = self.way_m.partition_point(|m| *m <= at_m);
        if next == 0 {
            return self.points[0];
        }
        let before = self.points[next - 1];
        match self.points.get(next) {
            None => before,
            Some(after) => {
                let step_m = self.way_m[next] - self.way_m[next - 1];
                before + (after - before) * ((at_m - self.way_m[next - 1]) / step_m)
            }
        }
    }
}
