//! The way of a ray through an occupancy map, cell by cell, with leaps through open space.
//!
//! Around every free cell a disc is free as far as the nearest cell that is not. A ray passes through it in one leap (sphere
//! tracing: Hart, *Sphere Tracing*, 1996), and from cell to cell only near to walls and to what is unknown. What it meets is
//! what the walk from cell to cell (Amanatides & Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, 1987) would meet.

use super::{
    distance::distances,
    occupancy_map::{Occupancy, OccupancyMap},
};

/// What a ray meets, in cells from where it begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Met {
    /// Something occupied: the middle of the ray's way through the cell.
    Occupied(f64),
    /// Nothing, as far as it was followed.
    Nothing,
    /// What was never seen: from there on it can't be followed.
    Unknown(f64),
}

/// An occupancy map made ready for rays.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RayMap {
    size: [usize; 2],
    /// A cell in a byte: [`OCCUPIED`], [`UNKNOWN`], or [`FREE`] and more, by how many cells a ray may leap.
    cells: Vec<u8>,
    /// Longest way through unknown cells, in cells.
    unknown: f64,
}

const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 1;
const FREE: u8 = 2;
/// Past a border, a ray is this far in the next cell.
const PAST: f64 = 1e-7;

impl RayMap {
    /// A ray ends as unknown after `unknown` cells on end that are.
    pub(super) fn new(map: &OccupancyMap, unknown: f64) -> Self {
        let size = map.size();
        let not_free: Vec<bool> = map.cells().iter().map(|c| *c != Occupancy::Free).collect();
        let distance = distances(&not_free, size[0]);
        // From any point of a cell to any of the other the way is shorter than between their middles by a diagonal at most.
        // Outside of the map nothing is free, either.
        let leap = |index: usize, cells: f32| {
            let (column, row) = (index % size[0], index / size[0]);
            let inside = column
                .min(row)
                .min(size[0] - 1 - column)
                .min(size[1] - 1 - row);
            let free = (f64::from(cells) - 2f64.sqrt()).min(inside as f64);
            free.clamp(0.0, f64::from(u8::MAX - FREE)) as u8
        };
        let cell = |(index, (occupancy, cells)): (usize, (&Occupancy, &f32))| match occupancy {
            Occupancy::Occupied => OCCUPIED,
            Occupancy::Unknown => UNKNOWN,
            Occupancy::Free => FREE + leap(index, *cells),
        };
        let cells = map.cells().iter().zip(&distance).enumerate().map(cell);
        Self {
            size,
            cells: cells.collect(),
            unknown,
        }
    }

    fn at(&self, column: f64, row: f64) -> Option<u8> {
        let within = column >= 0.0
            && row >= 0.0
            && column < self.size[0] as f64
            && row < self.size[1] as f64;
        within.then(|| self.cells[row as usize * self.size[0] + column as usize])
    }

    /// What a ray meets that begins at a point given in cells, within a distance in cells. From an occupied cell nothing
    /// can be seen.
    pub(super) fn cast(&self, from: [f64; 2], direction: [f64; 2], most: f64) -> Met {
        let per_cell = direction.map(|d| 1.0 / d);
        let ahead = direction.map(|d| if d > 0.0 { 1.0 } else { 0.0 });
        // Where the way leaves a cell, on either axis; never along an axis that it doesn't move on.
        let border = |axis: usize, cell: f64| match direction[axis] {
            0.0 => f64::INFINITY,
            _ => (cell + ahead[axis] - from[axis]) * per_cell[axis],
        };
        let mut way = 0.0;
        let mut unknown_from = None;
        loop {
            let column = (from[0] + way * direction[0]).floor();
            let row = (from[1] + way * direction[1]).floor();
            let Some(cell) = self.at(column, row) else {
                return Met::Unknown(unknown_from.unwrap_or(way));
            };
            let leaves = border(0, column).min(border(1, row)).max(way);
            match cell {
                OCCUPIED if way == 0.0 => return Met::Unknown(0.0),
                OCCUPIED => {
                    let middle = 0.5 * (way + leaves);
                    return if middle < most {
                        Met::Occupied(middle)
                    } else {
                        Met::Nothing
                    };
                }
                UNKNOWN => {
                    let since = *unknown_from.get_or_insert(way);
                    if leaves.min(most) - since > self.unknown {
                        return Met::Unknown(since);
                    }
                }
                _ => unknown_from = None,
            }
            let leap = f64::from(cell.saturating_sub(FREE));
            way = (leaves + PAST).max(way + leap);
            if way >= most {
                return Met::Nothing;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;
    use rand::RngExt;
    use std::f64::consts::TAU;

    /// By the formula's words: the cells in the order in which a point that creeps along the ray comes to them.
    fn crept(
        map: &OccupancyMap,
        from: [f64; 2],
        direction: [f64; 2],
        most: f64,
        unknown: f64,
    ) -> Met {
        const STEP: f64 = 1e-3;
        let at = |way: f64| map.at(from[0] + way * direction[0], from[1] + way * direction[1]);
        let [width, height] = map.size();
        if at(0.0) == Occupancy::Occupied {
            return Met::Unknown(0.0);
        }
        let mut since = None;
        for step in 0.. {
            let way = f64::from(step) * STEP;
            if way >= most {
                break;
            }
            let [x, y] = [0, 1].map(|axis| from[axis] + way * direction[axis]);
            if !(0.0..width as f64).contains(&x) || !(0.0..height as f64).contains(&y) {
                return Met::Unknown(0.0);
            }
            match at(way) {
                Occupancy::Occupied => return Met::Occupied(way),
                Occupancy::Free => since = None,
                Occupancy::Unknown if way - *since.get_or_insert(way) > unknown => {
                    return Met::Unknown(0.0);
                }
                Occupancy::Unknown => {}
            }
        }
        Met::Nothing
    }

    #[test]
    fn a_ray_that_leaps_meets_what_one_that_creeps_meets() {
        let mut random = Seed(4).stream("blots");
        let size = [60, 40];
        let mut cells = vec![Occupancy::Free; size[0] * size[1]];
        for state in [Occupancy::Occupied, Occupancy::Unknown] {
            for _ in 0..14 {
                let (column, row) = (random.random_range(0..58), random.random_range(0..38));
                let edge = random.random_range(1..3);
                for (c, r) in (0..edge).flat_map(|c| (0..edge).map(move |r| (c, r))) {
                    cells[(row + r) * size[0] + column + c] = state;
                }
            }
        }
        let map = OccupancyMap::from_cells(1.0, [0.0; 2], size[0], cells).unwrap();
        let (mut hits, mut unknown, mut nothing, mut odd) = (0, 0, 0, 0);
        let rays = RayMap::new(&map, 1.5);
        for _ in 0..3000 {
            let from = [
                random.random_range(0.0..60.0),
                random.random_range(0.0..40.0),
            ];
            let angle: f64 = random.random_range(0.0..TAU);
            let direction = [angle.cos(), angle.sin()];
            let most = random.random_range(5.0..40.0);
            let expected = crept(&map, from, direction, most, 1.5);
            match (rays.cast(from, direction, most), expected) {
                // The middle of the way through a cell, which is at most a diagonal long.
                (Met::Occupied(a), Met::Occupied(b)) if (-1e-3..0.71).contains(&(a - b)) => {
                    hits += 1
                }
                (Met::Unknown(_), Met::Unknown(_)) => unknown += 1,
                (Met::Nothing, Met::Nothing) => nothing += 1,
                // Where a corner is cut by less than a creeping step, or the maximum lies in the cell that is hit.
                _ => odd += 1,
            }
        }
        assert!(
            hits > 300 && unknown > 500 && nothing > 300,
            "{hits} {unknown} {nothing}"
        );
        assert!(odd < 60, "{odd}");
        // Along the axes as well.
        let direction = [1.0, 0.0];
        for row in 0..40 {
            let from = [0.5, f64::from(row) + 0.5];
            let expected = crept(&map, from, direction, 1e3, 1.5);
            let found = rays.cast(from, direction, 1e3);
            assert_eq!(
                std::mem::discriminant(&found),
                std::mem::discriminant(&expected)
            );
        }
    }
}
