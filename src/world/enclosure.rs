//! Can the robot get out? A flood through the free space of a floor plan, from where the robot stands.

use super::FloorPlan;
use crate::error::{Error, Result};
use nalgebra::{Point2, Vector2};
use std::collections::VecDeque;

/// Most cells a flood may fill; a plan that needs more is too wide for its robot.
const MAX_CELLS: f64 = 4e6;
/// No parent: the flood has not been here.
const DRY: u32 = u32::MAX;

/// Makes sure that a round robot at `start` stands free and finds no way out of the plan.
///
/// Free space is flooded in square cells of half the robot's radius. A gap that the robot fits through always lets the
/// flood pass; one narrower by up to a third of the robot may too, and is refused alike.
///
/// ```
/// use ballmark::world::{enclosure::check_enclosed, FloorPlan, Material, floor_plan::round};
/// use nalgebra::Point2;
/// let brick = Material { reflectivity: 1.0, critical_angle_rad: 0.5, ..Material::PLAIN };
/// let mut tower = round(Point2::origin(), 3.0, 12, brick);
/// check_enclosed(&FloorPlan::new(tower.clone())?, &Point2::origin(), 0.25)?;
/// tower.pop(); // a wall falls
/// assert!(check_enclosed(&FloorPlan::new(tower)?, &Point2::origin(), 0.25).is_err());
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the robot stands in a wall, can get out (the message names the narrowest place on its way), or the plan is
/// too wide to be flooded.
pub fn check_enclosed(plan: &FloorPlan, start: &Point2<f64>, radius_m: f64) -> Result<()> {
    let clearance_m = plan.clearance_m(start);
    if clearance_m.is_nan() || clearance_m < radius_m {
        return Err(Error::work(format!(
            "robot: starts in a wall: ({:.2}, {:.2}) is {clearance_m:.2} m from the nearest; expected at least its radius, {radius_m} m",
            start.x, start.y
        )));
    }
    let mut flood = Flood::over(plan, radius_m)?;
    flood.block(plan, radius_m);
    match flood.way_out(start) {
        None => Ok(()),
        Some(way) => {
            let hole = way
                .into_iter()
                .min_by(|a, b| plan.clearance_m(a).total_cmp(&plan.clearance_m(b)))
                .unwrap_or(*start);
            let (low, high) = plan.bounds();
            let within = |at: &Point2<f64>| low.inf(at) == low && high.sup(at) == high;
            if !within(start) {
                return Err(Error::work(format!(
                    "robot: starts outside of the walls: ({:.2}, {:.2}); expected a place between ({:.1}, {:.1}) and ({:.1}, {:.1}), walls all round",
                    start.x, start.y, low.x, low.y, high.x, high.y
                )));
            }
            Err(Error::work(format!(
                "floor plan: a robot of radius {radius_m} m gets out near ({:.1}, {:.1}); expected walls all round",
                hole.x, hole.y
            )))
        }
    }
}

struct Flood {
    low: Point2<f64>,
    cell_m: f64,
    columns: usize,
    rows: usize,
    blocked: Vec<bool>,
}

impl Flood {
    /// Dry cells over the plan and a rim around it, so that what reaches the edge is outside.
    fn over(plan: &FloorPlan, radius_m: f64) -> Result<Self> {
        let cell_m = radius_m / 2.0;
        let rim = Vector2::repeat(2.0 * radius_m);
        let (low, high) = plan.bounds();
        let low = low - rim;
        let size = (high + rim - low) / cell_m;
        let cells = size.x * size.y;
        if cells.is_nan() || cells > MAX_CELLS {
            return Err(Error::work(format!(
                "floor plan: {:.0} × {:.0} m is too wide for a robot of radius {radius_m} m; expected up to {MAX_CELLS} squares of half that radius",
                high.x - low.x,
                high.y - low.y
            )));
        }
        let (columns, rows) = (size.x as usize + 1, size.y as usize + 1);
        Ok(Self {
            low,
            cell_m,
            columns,
            rows,
            blocked: vec![false; columns * rows],
        })
    }

    fn centre(&self, cell: usize) -> Point2<f64> {
        let (column, row) = (cell % self.columns, cell / self.columns);
        self.low + Vector2::new(column as f64 + 0.5, row as f64 + 0.5) * self.cell_m
    }

    fn index(&self, x_m: f64, low_m: f64, count: usize) -> usize {
        (((x_m - low_m) / self.cell_m).max(0.0) as usize).min(count - 1)
    }

    /// Blocks the cells whose every point is too near to a wall for the robot's centre.
    fn block(&mut self, plan: &FloorPlan, radius_m: f64) {
        let reach_m = radius_m - self.cell_m * std::f64::consts::FRAC_1_SQRT_2;
        for wall in plan.walls() {
            let (low, high) = (wall.from.inf(&wall.to), wall.from.sup(&wall.to));
            for row in self.index(low.y - reach_m, self.low.y, self.rows)
                ..=self.index(high.y + reach_m, self.low.y, self.rows)
            {
                for column in self.index(low.x - reach_m, self.low.x, self.columns)
                    ..=self.index(high.x + reach_m, self.low.x, self.columns)
                {
                    let cell = row * self.columns + column;
                    if wall.distance_m(&self.centre(cell)) < reach_m {
                        self.blocked[cell] = true;
                    }
                }
            }
        }
    }

    /// The shortest way from `start` to the edge, if there is one.
    fn way_out(&self, start: &Point2<f64>) -> Option<Vec<Point2<f64>>> {
        let first = self.index(start.y, self.low.y, self.rows) * self.columns
            + self.index(start.x, self.low.x, self.columns);
        let mut came_from = vec![DRY; self.blocked.len()];
        came_from[first] = first as u32;
        let mut front = VecDeque::from([first]);
        while let Some(cell) = front.pop_front() {
            let (column, row) = (cell % self.columns, cell / self.columns);
            if column == 0 || row == 0 || column + 1 == self.columns || row + 1 == self.rows {
                let back = std::iter::successors(Some(cell), |&at| {
                    Some(came_from[at] as usize).filter(|&before| before != at)
                });
                return Some(back.map(|at| self.centre(at)).collect());
            }
            for next in [cell - 1, cell + 1, cell - self.columns, cell + self.columns] {
                if came_from[next] == DRY && !self.blocked[next] {
                    came_from[next] = cell as u32;
                    front.push_back(next);
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Material, Wall};

    const BRICK: Material = Material {
        reflectivity: 1.0,
        critical_angle_rad: 0.5,
        ..Material::PLAIN
    };

    /// A room of 6 × 4 m with a gap of that width in its right wall, in the middle.
    fn room_with_gap(gap_m: f64) -> FloorPlan {
        let corners = [
            [6.0, 2.0 - gap_m / 2.0],
            [6.0, 0.0],
            [0.0, 0.0],
            [0.0, 4.0],
            [6.0, 4.0],
            [6.0, 2.0 + gap_m / 2.0],
        ];
        let walls = corners
            .windows(2)
            .map(|pair| Wall::new(pair[0].into(), pair[1].into(), BRICK));
        FloorPlan::new(walls.collect()).unwrap()
    }

    #[test]
    fn a_hole_is_found_where_it_is_and_a_crack_is_none() {
        let inside = Point2::new(1.0, 1.0);
        for gap_m in [0.0, 0.1, 0.3] {
            check_enclosed(&room_with_gap(gap_m), &inside, 0.25).unwrap();
        }
        for gap_m in [0.5, 0.52, 0.9, 2.0] {
            let message = check_enclosed(&room_with_gap(gap_m), &inside, 0.25)
                .unwrap_err()
                .to_string();
            assert!(
                message.contains("gets out near (6.") || message.contains("gets out near (5."),
                "{message}"
            );
        }
    }

    #[test]
    fn a_start_in_a_wall_or_outside_and_a_plan_without_end_are_told() {
        let plan = room_with_gap(0.0);
        let in_wall = check_enclosed(&plan, &Point2::new(0.1, 2.0), 0.25)
            .unwrap_err()
            .to_string();
        assert!(in_wall.contains("starts in a wall"), "{in_wall}");
        let outside = check_enclosed(&plan, &Point2::new(9.0, 2.0), 0.25)
            .unwrap_err()
            .to_string();
        assert!(
            outside.contains("starts outside of the walls: (9.00, 2.00)"),
            "{outside}"
        );
        let endless = Wall::new(Point2::origin(), Point2::new(6e5, 6e5), BRICK);
        let plan = FloorPlan::new(vec![endless]).unwrap();
        let wide = check_enclosed(&plan, &Point2::new(0.0, 5.0), 0.25)
            .unwrap_err()
            .to_string();
        assert!(wide.contains("too wide"), "{wide}");
    }
}
