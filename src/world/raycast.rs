//! What a ray hits first: an exact walk through a uniform grid of cells that know their walls.

mod through;

use super::{FloorPlan, Wall};
use nalgebra::{Point2, Vector2};
use std::ops::ControlFlow;

/// Where a ray met a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Way along the ray, in metres.
    pub distance_m: f64,
    /// Index of the wall in the floor plan.
    pub wall: usize,
    /// Unit normal of the wall on the side the ray came from.
    pub normal: Vector2<f64>,
    /// Cosine of the angle between ray and normal: 1 head-on, 0 grazing.
    pub cos_incidence: f64,
}

impl Hit {
    /// Where a ray meets a wall of this index, if it does.
    pub(super) fn of(
        wall: &Wall,
        index: usize,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
    ) -> Option<Self> {
        let distance_m = meet(wall, origin, direction)?;
        Some(Self::at(wall, index, direction, distance_m))
    }

    fn at(wall: &Wall, index: usize, direction: &Vector2<f64>, distance_m: f64) -> Self {
        let along = (wall.to - wall.from).normalize();
        let left = Vector2::new(-along.y, along.x);
        let cosine = left.dot(direction);
        let normal = if cosine > 0.0 { -left } else { left };
        Self {
            distance_m,
            wall: index,
            normal,
            cos_incidence: cosine.abs(),
        }
    }
}

/// A floor plan made ready for many rays.
///
/// The cells are walked in the order a ray passes them (Amanatides & Woo, *A fast voxel traversal algorithm for ray
/// tracing*, 1987), so a ray only meets the walls near its way and stops at the first.
///
/// ```
/// use ballmark::world::{FloorPlan, Material, Raycaster, Wall};
/// use nalgebra::{Point2, Vector2};
/// let plaster = Material { reflectivity: 0.9, critical_angle_rad: 0.2, ..Material::PLAIN };
/// let wall = Wall::new(Point2::new(3.0, -1.0), Point2::new(3.0, 1.0), plaster);
/// let caster = Raycaster::new(FloorPlan::new(vec![wall])?);
/// let hit = caster.cast(&Point2::origin(), &Vector2::x(), 10.0).unwrap();
/// assert_eq!((hit.distance_m, hit.cos_incidence), (3.0, 1.0));
/// assert!(caster.cast(&Point2::origin(), &Vector2::y(), 10.0).is_none());
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Raycaster {
    plan: FloorPlan,
    low: Point2<f64>,
    cell_m: f64,
    columns: usize,
    rows: usize,
    /// Walls that touch each cell, `[row * columns + column]`.
    cells: Vec<Vec<u32>>,
}

/// Walls are entered into cells this much too far, so that rounding never hides one behind a cell's edge.
const SLACK_M: f64 = 1e-6;
/// Cells a wall, on average: memory grows with the plan, never with its extent.
const CELLS_PER_WALL: f64 = 8.0;
/// A wall reaches this share of its length past its ends, so that no ray slips through where two walls meet.
const JOINT: f64 = 1e-9;

impl Raycaster {
    /// Sorts the walls of a plan into cells.
    pub fn new(plan: FloorPlan) -> Self {
        let (low, high) = plan.bounds();
        let low = low - Vector2::repeat(2.0 * SLACK_M);
        let extent = high - low + Vector2::repeat(2.0 * SLACK_M);
        let budget = CELLS_PER_WALL * plan.walls().len() as f64;
        // Square cells of about the budget's area, and no more than the budget along a long thin plan.
        let cell_m = (extent.x * extent.y / budget)
            .sqrt()
            .max(extent.max() / budget);
        let columns = (extent.x / cell_m) as usize + 1;
        let rows = (extent.y / cell_m) as usize + 1;
        let mut caster = Self {
            plan,
            low,
            cell_m,
            columns,
            rows,
            cells: vec![Vec::new(); columns * rows],
        };
        for index in 0..caster.plan.walls().len() {
            caster.enter(index);
        }
        caster
    }

    /// The plan behind it.
    pub fn plan(&self) -> &FloorPlan {
        &self.plan
    }

    /// The nearest wall on the way from `origin` along the unit vector `direction`, up to `reach_m` metres; of two at
    /// the same distance the first in the plan.
    pub fn cast(
        &self,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
        reach_m: f64,
    ) -> Option<Hit> {
        self.cast_at(origin, direction, reach_m, |_| true)
    }

    /// The same among those walls only that `counts` picks.
    pub fn cast_at(
        &self,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
        reach_m: f64,
        counts: impl Fn(&Wall) -> bool,
    ) -> Option<Hit> {
        let mut nearest: Option<(f64, usize)> = None;
        self.walk(origin, direction, reach_m, |walls, exit_m| {
            for &wall in walls {
                let met = &self.plan.walls()[wall as usize];
                let found = meet(met, origin, direction)
                    .filter(|_| counts(met))
                    .map(|distance_m| (distance_m, wall as usize))
                    .filter(|found| found.0 <= reach_m);
                if found.is_some_and(|found| nearest.is_none_or(|best| found < best)) {
                    nearest = found;
                }
            }
            match nearest {
                Some(best) if best.0 <= exit_m => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        });
        nearest.map(|(distance_m, wall)| {
            Hit::at(&self.plan.walls()[wall], wall, direction, distance_m)
        })
    }

    /// Goes through the cells that a ray passes, up to `reach_m`, until `at_cell` breaks off; it is given the walls that
    /// touch the cell, and how far along the ray the cell ends.
    #[inline]
    fn walk(
        &self,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
        reach_m: f64,
        mut at_cell: impl FnMut(&[u32], f64) -> ControlFlow<()>,
    ) {
        let Some((enter_m, leave_m)) = self.crossing(origin, direction) else {
            return;
        };
        let entry = origin + direction * enter_m - self.low;
        let (mut column, mut row) = (self.column(entry.x), self.row(entry.y));
        let mut next_x_m = self.edge_m(column, origin.x - self.low.x, direction.x);
        let mut next_y_m = self.edge_m(row, origin.y - self.low.y, direction.y);
        loop {
            let exit_m = next_x_m.min(next_y_m);
            let done = at_cell(&self.cells[row * self.columns + column], exit_m).is_break();
            if done || exit_m > reach_m.min(leave_m) {
                break;
            }
            let stayed = if next_x_m <= next_y_m {
                step(&mut column, direction.x, self.columns)
                    .then(|| next_x_m = self.edge_m(column, origin.x - self.low.x, direction.x))
            } else {
                step(&mut row, direction.y, self.rows)
                    .then(|| next_y_m = self.edge_m(row, origin.y - self.low.y, direction.y))
            };
            if stayed.is_none() {
                break;
            }
        }
    }

    /// Enters a wall into every cell it touches, column by column.
    fn enter(&mut self, index: usize) {
        let Wall { from, to, .. } = self.plan.walls()[index];
        let (a, b) = if from.x <= to.x {
            (from - self.low, to - self.low)
        } else {
            (to - self.low, from - self.low)
        };
        let slope = (b.y - a.y) / (b.x - a.x);
        for column in self.column(a.x - SLACK_M)..=self.column(b.x + SLACK_M) {
            let left = (column as f64 * self.cell_m - SLACK_M).max(a.x);
            let right = ((column + 1) as f64 * self.cell_m + SLACK_M).min(b.x);
            // A wall that stands upright, or nearly so within this column, takes its whole height.
            let upright = b.x - a.x <= SLACK_M;
            let (y1, y2) = if upright {
                (a.y, b.y)
            } else {
                (a.y + slope * (left - a.x), a.y + slope * (right - a.x))
            };
            for row in self.row(y1.min(y2) - SLACK_M)..=self.row(y1.max(y2) + SLACK_M) {
                self.cells[row * self.columns + column].push(index as u32);
            }
        }
    }

    /// Where along the ray it enters and leaves the box of cells; `None` if it passes by.
    fn crossing(&self, origin: &Point2<f64>, direction: &Vector2<f64>) -> Option<(f64, f64)> {
        let size = [
            self.columns as f64 * self.cell_m,
            self.rows as f64 * self.cell_m,
        ];
        let (mut enter_m, mut leave_m) = (0.0_f64, f64::INFINITY);
        for (axis, size_m) in size.into_iter().enumerate() {
            let (start, speed) = (origin[axis] - self.low[axis], direction[axis]);
            if speed == 0.0 {
                if !(0.0..=size_m).contains(&start) {
                    return None;
                }
            } else {
                let (one, other) = (-start / speed, (size_m - start) / speed);
                enter_m = enter_m.max(one.min(other));
                leave_m = leave_m.min(one.max(other));
            }
        }
        (enter_m <= leave_m).then_some((enter_m, leave_m))
    }

    /// Way along the ray to where it leaves the cells of this index on one axis.
    fn edge_m(&self, index: usize, start_m: f64, speed: f64) -> f64 {
        if speed == 0.0 {
            return f64::INFINITY;
        }
        let edge = index + usize::from(speed > 0.0);
        (edge as f64 * self.cell_m - start_m) / speed
    }

    fn column(&self, x_m: f64) -> usize {
        ((x_m / self.cell_m).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y_m: f64) -> usize {
        ((y_m / self.cell_m).max(0.0) as usize).min(self.rows - 1)
    }
}

/// One cell on along an axis; false where the grid ends.
fn step(index: &mut usize, speed: f64, count: usize) -> bool {
    let next = if speed > 0.0 {
        *index + 1
    } else {
        index.wrapping_sub(1)
    };
    let inside = next < count;
    if inside {
        *index = next;
    }
    inside
}

/// Way along the ray to the wall, in metres; `None` where it misses or runs along it.
fn meet(wall: &Wall, origin: &Point2<f64>, direction: &Vector2<f64>) -> Option<f64> {
    let (along, offset) = (wall.to - wall.from, wall.from - origin);
    let across = direction.perp(&along);
    if across == 0.0 {
        return None;
    }
    // origin + t direction = from + u along
    let (t, u) = (
        offset.perp(&along) / across,
        offset.perp(direction) / across,
    );
    (t >= 0.0 && (-JOINT..=1.0 + JOINT).contains(&u)).then_some(t)
}

#[cfg(test)]
mod odd_rays;

#[cfg(test)]
mod tests {
    use super::odd_rays::{REACH_M, odd_rays};
    use super::*;
    use crate::world::Material;
    use std::f64::consts::PI;

    const PLASTER: Material = Material {
        reflectivity: 0.9,
        critical_angle_rad: 0.2,
        ..Material::PLAIN
    };

    fn nearest_of_all(
        plan: &FloorPlan,
        origin: &Point2<f64>,
        direction: &Vector2<f64>,
    ) -> Option<(f64, usize)> {
        let met = plan.walls().iter().enumerate();
        met.filter_map(|(index, wall)| Some((meet(wall, origin, direction)?, index)))
            .filter(|found| found.0 <= REACH_M)
            .min_by(|a, b| a.partial_cmp(b).unwrap())
    }

    #[test]
    fn the_grid_finds_what_trying_every_wall_finds() {
        let mut met = 0;
        odd_rays(|plan, caster, origin, direction| {
            let found = caster
                .cast(origin, direction, REACH_M)
                .map(|hit| (hit.distance_m, hit.wall));
            met += usize::from(found.is_some());
            assert_eq!(found, nearest_of_all(plan, origin, direction));
        });
        assert!(met > 5000, "{met} rays met anything");
    }

    #[test]
    fn the_normal_faces_the_ray_and_the_cosine_is_that_of_the_incidence() {
        let wall = Wall::new(Point2::new(-5.0, 2.0), Point2::new(5.0, 2.0), PLASTER);
        let caster = Raycaster::new(FloorPlan::new(vec![wall]).unwrap());
        for (from_y, sign) in [(0.0, 1.0), (4.0, -1.0)] {
            let direction = Vector2::new((PI / 6.0).sin(), sign * (PI / 6.0).cos());
            let hit = caster
                .cast(&Point2::new(0.0, from_y), &direction, 10.0)
                .unwrap();
            assert!((hit.distance_m - 2.0 / (PI / 6.0).cos()).abs() < 1e-12);
            assert!((hit.cos_incidence - (PI / 6.0).cos()).abs() < 1e-12);
            assert!((hit.normal - Vector2::new(0.0, -sign)).norm() < 1e-12);
        }
    }
}
