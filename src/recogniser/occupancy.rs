//! Local occupancy grids: which cells round the robot one scan makes occupied, which empty, and of which it knows nothing.
//!
//! Duckett & Nehmzow, *Performance comparison of landmark recognition systems for navigating mobile robots* (2000), take
//! 64 × 64 cells of 15 cm and update them as in Moravec & Elfes, *High resolution maps from wide angle sonar* (1985): a
//! reading's cone is probably empty up to the range read and holds something occupied at that range. All cones are
//! superposed, first what they say is empty, then what they say is occupied, so that the order of readings says nothing.

use serde::{Deserialize, Serialize};
use std::{f64::consts::TAU, sync::LazyLock};

/// Cells of a side (Duckett & Nehmzow 2000).
pub const CELLS: usize = 64;
/// Side of a cell, metres (Duckett & Nehmzow 2000).
pub const CELL_M: f64 = 0.15;

/// One reading of a range sensor: a cone, and the range at which there is something, or up to which there is nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Direction of the cone's axis in the grid's frame, radians, counter-clockwise from the grid's x axis.
    pub bearing_rad: f64,
    /// Where the cone begins: how far along its axis the sensor sits from the middle of the grid, metres.
    pub offset_m: f64,
    /// Distance read, metres from the sensor; where nothing came back, how far the sensor reaches.
    pub range_m: f64,
    /// Did anything come back? Else the cone is empty as far as the sensor reaches.
    pub returned: bool,
    /// Full opening ω of the cone, radians.
    pub opening_rad: f64,
}

/// What a reading is worth besides its range.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReadingModel {
    /// R_min: shorter readings are dropped, and nothing is said of cells that near, metres.
    pub minimum_m: f64,
    /// ε: by how much the range may be wrong, metres. Less than about 0.7 of a cell may miss every cell's middle.
    pub range_error_m: f64,
}

impl Default for ReadingModel {
    /// ε of one cell; a Polaroid transducer's shortest range. (Neither is printed by Duckett & Nehmzow.)
    fn default() -> Self {
        Self {
            minimum_m: 0.15,
            range_error_m: CELL_M,
        }
    }
}

/// What is known of a cell (Duckett & Nehmzow 2000, *State*).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// p > 0.5
    Occupied,
    /// p < 0.5
    Empty,
    /// p = 0.5
    Unknown,
}

/// The states of 64 × 64 cells, the robot in their middle: x to the right, y upwards, a bit a cell in each of two planes.
///
/// In a file: the two planes' rows, a pair of 64-bit numbers a row.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[u64; 2]>", into = "Vec<[u64; 2]>")]
pub struct States {
    /// Row y from below; bit x of it from the left.
    pub(super) occupied: [u64; CELLS],
    /// Likewise; no cell is in both.
    pub(super) empty: [u64; CELLS],
}

impl States {
    /// Nothing known.
    pub const UNKNOWN: Self = Self {
        occupied: [0; CELLS],
        empty: [0; CELLS],
    };

    /// The states that `state` gives for column and row.
    pub fn from_fn(mut state: impl FnMut(usize, usize) -> State) -> Self {
        let mut states = Self::UNKNOWN;
        for y in 0..CELLS {
            for x in 0..CELLS {
                match state(x, y) {
                    State::Occupied => states.occupied[y] |= 1 << x,
                    State::Empty => states.empty[y] |= 1 << x,
                    State::Unknown => {}
                }
            }
        }
        states
    }

    /// State of the cell at column `x` and row `y`.
    ///
    /// # Panics
    /// Beyond the grid.
    pub fn at(&self, x: usize, y: usize) -> State {
        assert!(x < CELLS, "column {x} of {CELLS}");
        match ((self.occupied[y] >> x) & 1, (self.empty[y] >> x) & 1) {
            (1, _) => State::Occupied,
            (_, 1) => State::Empty,
            _ => State::Unknown,
        }
    }

    /// Number of cells that something is known of.
    pub fn known(&self) -> u32 {
        let planes = self.occupied.iter().zip(&self.empty);
        planes.map(|(o, e)| (o | e).count_ones()).sum()
    }

    /// The same surroundings seen by a robot whose frame is turned a quarter clockwise: what was to the right is above.
    pub fn quarter_turn(&self) -> Self {
        Self::from_fn(|x, y| self.at(y, CELLS - 1 - x))
    }
}

impl From<States> for Vec<[u64; 2]> {
    fn from(states: States) -> Self {
        let planes = states.occupied.into_iter().zip(states.empty);
        planes.map(<[u64; 2]>::from).collect()
    }
}

impl TryFrom<Vec<[u64; 2]>> for States {
    type Error = String;

    fn try_from(rows: Vec<[u64; 2]>) -> Result<Self, String> {
        if rows.len() != CELLS || rows.iter().any(|[o, e]| o & e != 0) {
            return Err(format!(
                "an occupancy grid of {} rows; expected {CELLS}, no cell of them both occupied and empty",
                rows.len()
            ));
        }
        let mut states = Self::UNKNOWN;
        for (y, [occupied, empty]) in rows.into_iter().enumerate() {
            (states.occupied[y], states.empty[y]) = (occupied, empty);
        }
        Ok(states)
    }
}

/// What one scan says of 64 × 64 cells round the robot.
///
/// ```
/// use ballmark::recogniser::occupancy::{OccupancyGrid, Reading, ReadingModel, State};
/// let ahead = Reading { bearing_rad: 0.0, offset_m: 0.0, range_m: 2.0, returned: true, opening_rad: 0.4 };
/// let grid = OccupancyGrid::of(&[ahead], &ReadingModel::default());
/// let states = grid.states();
/// assert_eq!(states.at(32 + 6, 32), State::Empty); // a metre ahead
/// assert_eq!(states.at(32 + 13, 32), State::Occupied); // two metres
/// assert_eq!(states.at(32 + 20, 32), State::Unknown); // behind
/// assert!(grid.probability(32 + 6, 32) < 0.5);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct OccupancyGrid {
    /// Emp, row by row: certainty that a cell is empty.
    empty: Vec<f64>,
    /// Occ, row by row: certainty that it is occupied.
    occupied: Vec<f64>,
}

impl OccupancyGrid {
    /// The grid of one scan (Moravec & Elfes 1985, their map building steps). Readings that are no finite range, or
    /// shorter than the model's least, say nothing.
    pub fn of(readings: &[Reading], model: &ReadingModel) -> Self {
        let mut grid = Self {
            empty: vec![0.0; CELLS * CELLS],
            occupied: vec![0.0; CELLS * CELLS],
        };
        let heard = readings.iter().filter(|reading| {
            reading.range_m.is_finite()
                && reading.range_m >= model.minimum_m
                && reading.bearing_rad.is_finite()
                && reading.offset_m.is_finite()
                && reading.opening_rad > 0.0
        });
        for reading in heard.clone() {
            grid.superpose_empty(reading, model);
        }
        let mut arc = Vec::new();
        for reading in heard.filter(|reading| reading.returned) {
            grid.superpose_occupied(reading, model, &mut arc);
        }
        grid
    }

    /// Enhance: Emp ← Emp + Emp_k − Emp·Emp_k, with Emp_k = E_r(δ)·E_a(θ),
    /// E_r(δ) = 1 − ((δ − R_min)/(R − ε − R_min))² between R_min and R − ε.
    fn superpose_empty(&mut self, reading: &Reading, model: &ReadingModel) {
        let depth_m = reading.range_m - model.range_error_m - model.minimum_m;
        if depth_m <= 0.0 {
            return;
        }
        let emptied_m = [model.minimum_m, model.minimum_m + depth_m];
        for seen in CONES.within(reading, emptied_m) {
            let share = (seen.distance_m - model.minimum_m) / depth_m;
            if (0.0..=1.0).contains(&share) {
                let empty = (1.0 - share * share) * aside(seen.off_axis_rad, reading);
                let known = &mut self.empty[seen.index];
                *known += empty - *known * empty;
            }
        }
    }

    /// Cancel: Occ_k ← O_r(δ)·O_a(θ)·(1 − Emp), with O_r(δ) = 1 − ((δ − R)/ε)² between R − ε and R + ε.
    /// Normalise: Occ_k ← Occ_k / Σ Occ_k, as one thing somewhere on the arc threw the echo back.
    /// Enhance: Occ ← Occ + Occ_k − Occ·Occ_k.
    fn superpose_occupied(
        &mut self,
        reading: &Reading,
        model: &ReadingModel,
        arc: &mut Vec<(usize, f64)>,
    ) {
        arc.clear();
        let error_m = model.range_error_m;
        let arc_m = [reading.range_m - error_m, reading.range_m + error_m];
        for seen in CONES.within(reading, arc_m) {
            let share = (seen.distance_m - reading.range_m) / error_m;
            if (-1.0..=1.0).contains(&share) {
                let occupied = (1.0 - share * share) * aside(seen.off_axis_rad, reading);
                arc.push((seen.index, occupied * (1.0 - self.empty[seen.index])));
            }
        }
        let sum: f64 = arc.iter().map(|(_, occupied)| occupied).sum();
        if sum > 0.0 {
            for &(cell, share) in arc.iter() {
                let occupied = share / sum;
                let known = &mut self.occupied[cell];
                *known += occupied - *known * occupied;
            }
        }
    }

    /// Probability that the cell at column `x` and row `y` is occupied, in [0, 1]: (1 + v)/2 of Moravec & Elfes's v, which is
    /// Occ where that is no less than Emp, else −Emp. Unknown is 0.5.
    ///
    /// # Panics
    /// Beyond the grid.
    pub fn probability(&self, x: usize, y: usize) -> f64 {
        assert!(x < CELLS, "column {x} of {CELLS}");
        let (occupied, empty) = (self.occupied[y * CELLS + x], self.empty[y * CELLS + x]);
        let value = if occupied >= empty { occupied } else { -empty };
        (1.0 + value) / 2.0
    }

    /// The state of every cell.
    pub fn states(&self) -> States {
        States::from_fn(|x, y| {
            let p = self.probability(x, y);
            if p > 0.5 {
                State::Occupied
            } else if p < 0.5 {
                State::Empty
            } else {
                State::Unknown
            }
        })
    }
}

/// E_a(θ) = O_a(θ) = 1 − (2θ/ω)².
fn aside(off_axis_rad: f64, reading: &Reading) -> f64 {
    let share = 2.0 * off_axis_rad / reading.opening_rad;
    (1.0 - share * share).max(0.0)
}

/// A cell's middle as a sensor has it in its cone.
struct Seen {
    index: usize,
    distance_m: f64,
    /// θ
    off_axis_rad: f64,
}

/// A cell's middle as the robot's middle sees it.
struct Cell {
    bearing_rad: f64,
    distance_m: f64,
    at_m: [f64; 2],
    index: usize,
}

/// Where a sensor sits, and the direction of its axis.
struct Sensor {
    offset_m: f64,
    axis: [f64; 2],
}

impl Sensor {
    fn of(reading: &Reading) -> Self {
        let (sin, cos) = reading.bearing_rad.sin_cos();
        Self {
            offset_m: reading.offset_m,
            axis: [cos, sin],
        }
    }

    /// A cell that lies off the axis by this angle at the robot's middle, if its distance from the sensor is within bounds. Angles at
    /// a sensor on a ring are dear, and most cells of a wide cone are nearer or farther than what is asked for.
    fn seen(&self, cell: &Cell, off_axis_rad: f64, [least_m, most_m]: [f64; 2]) -> Option<Seen> {
        let [ahead_m, left_m] = match self.offset_m {
            0.0 => [cell.distance_m, 0.0],
            offset_m => {
                let ([x_m, y_m], [cos, sin]) = (cell.at_m, self.axis);
                [x_m * cos + y_m * sin - offset_m, y_m * cos - x_m * sin]
            }
        };
        let distance_m = (ahead_m * ahead_m + left_m * left_m).sqrt();
        (least_m..=most_m).contains(&distance_m).then(|| Seen {
            index: cell.index,
            distance_m,
            off_axis_rad: match self.offset_m {
                0.0 => off_axis_rad,
                _ => left_m.atan2(ahead_m),
            },
        })
    }
}

/// All cells by their bearing, so that a cone need not be looked for among all of them.
struct Cones(Vec<Cell>);

static CONES: LazyLock<Cones> = LazyLock::new(|| {
    let middle_m = |i: usize| (i as f64 + 0.5 - CELLS as f64 / 2.0) * CELL_M;
    let mut cells: Vec<Cell> = (0..CELLS * CELLS)
        .map(|index| {
            let (x_m, y_m) = (middle_m(index % CELLS), middle_m(index / CELLS));
            Cell {
                bearing_rad: y_m.atan2(x_m).rem_euclid(TAU),
                distance_m: x_m.hypot(y_m),
                at_m: [x_m, y_m],
                index,
            }
        })
        .collect();
    cells.sort_by(|a, b| a.bearing_rad.total_cmp(&b.bearing_rad));
    Cones(cells)
});

impl Cones {
    /// The cells in a reading's cone, so far from its sensor. A cone that begins farther out lies within one of the same opening
    /// from the middle.
    fn within(&self, reading: &Reading, between_m: [f64; 2]) -> impl Iterator<Item = Seen> {
        let sensor = Sensor::of(reading);
        let half = reading.opening_rad.min(TAU) / 2.0;
        let axis = reading.bearing_rad.rem_euclid(TAU);
        // A cone across bearing 0 has two stretches.
        let turns = [-TAU, 0.0, TAU].into_iter();
        let stretches = turns.map(move |turn| {
            let axis = axis + turn;
            let first = self.0.partition_point(|c| c.bearing_rad < axis - half);
            let end = self.0.partition_point(|c| c.bearing_rad <= axis + half);
            (axis, self.0.get(first..end).unwrap_or_default())
        });
        let cells = stretches.flat_map(|(axis, cells)| cells.iter().map(move |cell| (cell, axis)));
        let seen =
            cells.filter_map(move |(c, axis)| sensor.seen(c, c.bearing_rad - axis, between_m));
        seen.filter(move |seen| seen.off_axis_rad.abs() <= half)
    }
}

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(super) use tests::blotched;
