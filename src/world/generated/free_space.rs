//! Where a robot can be: cells of 0.2 m that are inside, far enough from every wall, and reached from one another.

use super::plan::Plan;
use crate::world::{FloorPlan, Wall};
use nalgebra::{Point2, Vector2};
use std::{
    cmp::Reverse,
    collections::{BinaryHeap, VecDeque},
};

/// Size of a cell, metres.
pub(super) const CELL_M: f64 = 0.2;
/// How far from walls it makes a difference to the robot, metres.
const FAR_M: f64 = 1.0;
/// Neighbours of a cell: steps across and up.
const STEPS: [(i64, i64); 8] = [
    (1, 0),
    (-1, 0),
    (0, 1),
    (0, -1),
    (1, 1),
    (1, -1),
    (-1, 1),
    (-1, -1),
];
/// Costs of a way are whole numbers: so many to a cell.
const COST_UNIT: f64 = 1000.0;

/// The largest part of the free space that hangs together.
#[derive(Debug, Clone)]
pub(super) struct FreeSpace {
    low: Point2<f64>,
    columns: usize,
    rows: usize,
    /// Distance of each cell's middle to the nearest wall, up to [`FAR_M`], metres, `[row * columns + column]`; 0 outside
    /// of the part.
    clearance_m: Vec<f64>,
    /// The cells of the part, in rising order.
    cells: Vec<usize>,
}

impl FreeSpace {
    /// What is free at least `clearance_m` from every wall of the floor plan.
    pub fn new(floor: &FloorPlan, plan: &Plan, clearance_m: f64) -> Self {
        let (low, high) = floor.bounds();
        let size = (high - low) / CELL_M;
        let (columns, rows) = (size.x as usize + 1, size.y as usize + 1);
        let mut space = Self {
            low,
            columns,
            rows,
            clearance_m: vec![FAR_M; columns * rows],
            cells: Vec::new(),
        };
        for wall in floor.walls() {
            space.keep_off(wall);
        }
        for cell in 0..columns * rows {
            let free =
                space.clearance_m[cell] >= clearance_m && plan.is_inside(&space.middle(cell));
            if !free {
                space.clearance_m[cell] = 0.0;
            }
        }
        space.keep_largest_part();
        space
    }

    /// Its cells.
    pub fn cells(&self) -> &[usize] {
        &self.cells
    }

    /// Square metres.
    pub fn area_m2(&self) -> f64 {
        self.cells.len() as f64 * CELL_M * CELL_M
    }

    /// The middle of a cell.
    pub fn middle(&self, cell: usize) -> Point2<f64> {
        let (column, row) = (cell % self.columns, cell / self.columns);
        self.low + Vector2::new(column as f64 + 0.5, row as f64 + 0.5) * CELL_M
    }

    /// The cells of the cheapest way from one cell to another, both included. A cell that is no way from the walls costs
    /// 1 + `shyness` times as much as one that is far from them.
    pub fn way(&self, from: usize, to: usize, shyness: f64) -> Vec<usize> {
        let mut cost = vec![u64::MAX; self.clearance_m.len()];
        let mut before = vec![usize::MAX; self.clearance_m.len()];
        let mut open = BinaryHeap::from([Reverse((0, to))]);
        cost[to] = 0;
        while let Some(Reverse((so_far, cell))) = open.pop() {
            if cell == from {
                break;
            }
            if so_far > cost[cell] {
                continue;
            }
            for (next, diagonal) in self.neighbours(cell) {
                let near = (FAR_M - self.clearance_m[next]) / FAR_M;
                let length = if diagonal { 2.0_f64.sqrt() } else { 1.0 };
                let through = so_far + (COST_UNIT * length * (1.0 + shyness * near)) as u64;
                if through < cost[next] {
                    cost[next] = through;
                    before[next] = cell;
                    open.push(Reverse((through, next)));
                }
            }
        }
        // Searched from the end, so that it reads from the start.
        let mut way = vec![from];
        let mut here = from;
        while here != to {
            here = before[here];
            way.push(here);
        }
        way
    }

    /// Free cells next to one, and whether they lie across a corner.
    fn neighbours(&self, cell: usize) -> impl Iterator<Item = (usize, bool)> + '_ {
        let (column, row) = ((cell % self.columns) as i64, (cell / self.columns) as i64);
        STEPS.into_iter().filter_map(move |(across, up)| {
            let (x, y) = (column + across, row + up);
            let within =
                (0..self.columns as i64).contains(&x) && (0..self.rows as i64).contains(&y);
            let next = within.then(|| y as usize * self.columns + x as usize)?;
            (self.clearance_m[next] > 0.0).then_some((next, across != 0 && up != 0))
        })
    }

    /// Lowers the clearance of the cells around a wall.
    fn keep_off(&mut self, wall: &Wall) {
        let around = Vector2::repeat(FAR_M);
        let low = (wall.from.inf(&wall.to) - around - self.low) / CELL_M;
        let high = (wall.from.sup(&wall.to) + around - self.low) / CELL_M;
        let range = |low: f64, high: f64, count: usize| {
            low.max(0.0) as usize..(high.max(0.0) as usize + 1).min(count)
        };
        for row in range(low.y, high.y, self.rows) {
            for column in range(low.x, high.x, self.columns) {
                let cell = row * self.columns + column;
                let distance_m = wall.distance_m(&self.middle(cell));
                self.clearance_m[cell] = self.clearance_m[cell].min(distance_m);
            }
        }
    }

    /// Keeps the largest set of cells that are reached from one another; of two as large the one with the first cell.
    fn keep_largest_part(&mut self) {
        let mut seen: Vec<bool> = self.clearance_m.iter().map(|m| *m == 0.0).collect();
        let mut largest = Vec::new();
        for first in 0..seen.len() {
            if seen[first] {
                continue;
            }
            seen[first] = true;
            let (mut part, mut due) = (Vec::new(), VecDeque::from([first]));
            while let Some(cell) = due.pop_front() {
                part.push(cell);
                for (next, _) in self.neighbours(cell) {
                    if !seen[next] {
                        seen[next] = true;
                        due.push_back(next);
                    }
                }
            }
            if part.len() > largest.len() {
                largest = part;
            }
        }
        largest.sort_unstable();
        let mut kept = vec![0.0; self.clearance_m.len()];
        for &cell in &largest {
            kept[cell] = self.clearance_m[cell];
        }
        (self.clearance_m, self.cells) = (kept, largest);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{chance::Chance, plan::Rectangle};
    use super::*;
    use crate::seed::Seed;

    /// A room of 6 m × 4 m with a wall from its lower side to 1 m below its upper one, and a cell of 1.2 m walled off.
    fn space() -> FreeSpace {
        let mut chance = Chance(Seed(1).stream("plan"));
        let mut plan = Plan::default();
        let room = Rectangle::new(Point2::origin(), Point2::new(6.0, 4.0));
        plan.enclose(&room, &mut chance);
        plan.wall(Point2::new(3.0, 0.0), Point2::new(3.0, 3.0), &mut chance);
        let closet = Rectangle::new(Point2::new(4.8, 0.0), Point2::new(6.0, 1.2));
        plan.enclose(&closet, &mut chance);
        plan.inside.push(room);
        let floor = FloorPlan::new(plan.walls.clone()).unwrap();
        FreeSpace::new(&floor, &plan, 0.34)
    }

    #[test]
    fn free_cells_keep_off_walls_and_hang_together() {
        let space = space();
        // Left of the wall 2.3 × 3.3 m, right of it the same less 1.2 × 1.2 m of closet with its margin, and the passage.
        assert!(
            (12.0..14.5).contains(&space.area_m2()),
            "{}",
            space.area_m2()
        );
        for &cell in space.cells() {
            let Point2 { coords } = space.middle(cell);
            assert!(coords.x > 0.34 && coords.x < 5.66 && coords.y > 0.34 && coords.y < 3.66);
            assert!((coords.x - 3.0).abs() >= 0.34 || coords.y > 3.0);
            assert!(
                coords.x < 4.8 || coords.y > 1.2,
                "in the closet: {coords:?}"
            );
        }
    }

    #[test]
    fn the_way_leads_around_the_wall_and_shyness_keeps_it_in_the_middle() {
        let space = space();
        let near = |x_m: f64, y_m: f64| {
            let goal = Point2::new(x_m, y_m);
            let off = |cell: &&usize| (space.middle(**cell) - goal).norm();
            *space
                .cells()
                .iter()
                .min_by(|a, b| off(a).total_cmp(&off(b)))
                .unwrap()
        };
        let (from, to) = (near(2.5, 0.5), near(3.5, 0.5));
        for shyness in [0.0, 6.0] {
            let way = space.way(from, to, shyness);
            assert_eq!((way[0], way[way.len() - 1]), (from, to));
            let places: Vec<Point2<f64>> = way.iter().map(|cell| space.middle(*cell)).collect();
            let length_m: f64 = places.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
            assert!(places.windows(2).all(|p| (p[1] - p[0]).norm() < 0.29));
            assert!(places.iter().any(|place| place.y > 3.0));
            if shyness == 0.0 {
                assert!((5.4..6.6).contains(&length_m), "{length_m}");
            } else {
                let off_m = places
                    .iter()
                    .map(|place| (place.x - 3.0).abs())
                    .fold(0.0, f64::max);
                assert!(off_m > 0.9, "{off_m}");
            }
        }
    }
}
