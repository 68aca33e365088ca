//! An occupancy map of a recording's range scans at their poses: how often beams ended in a cell, how often they crossed it.

mod looks;
#[cfg(test)]
mod tests;

use super::range_sensors::RangeSensors;
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::Recording,
};
use looks::{Echo, Looks};
use serde::{Deserialize, Serialize};

/// How an occupancy map is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OccupancyMapConfig {
    /// Edge of a cell, in metres.
    pub cell_m: f64,
    /// How far beyond the poses the map reaches, and how far along a beam cells count as crossed, in metres.
    pub margin_m: f64,
    /// Readings beyond this are not used, in metres.
    pub reach_m: f64,
    /// A cell is occupied where at least so many beams ended in it …
    pub least_hits: u32,
    /// … and they are more than this share of the looks at it: of the beams that ended there and the scans that crossed it.
    pub least_share: f64,
    /// Most cells: a mistyped `cell_m` should end in a message, not in a full memory.
    pub most_cells: usize,
    /// The sensors that draw it.
    pub sensors: RangeSensors,
}

impl Default for OccupancyMapConfig {
    fn default() -> Self {
        Self {
            cell_m: 0.05,
            margin_m: 15.0,
            reach_m: 40.0,
            least_hits: 2,
            least_share: 0.25,
            most_cells: 100_000_000,
            sensors: RangeSensors::default(),
        }
    }
}

impl OccupancyMapConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        for (key, value) in [
            ("cell_m", self.cell_m),
            ("margin_m", self.margin_m),
            ("reach_m", self.reach_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::usage(format!(
                    "occupancy_map.{key} = {value}: expected metres above 0"
                )));
            }
        }
        if !(0.0..1.0).contains(&self.least_share) {
            return Err(Error::usage(format!(
                "occupancy_map.least_share = {}: expected 0 up to less than 1",
                self.least_share
            )));
        }
        self.sensors.check()
    }
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occupancy {
    /// No beam ended in it or crossed it, or too few ended in it to tell.
    Unknown,
    /// Beams crossed it.
    Free,
    /// Beams ended in it.
    Occupied,
}

/// Square cells, each free, occupied or unknown.
///
/// ```
/// use ballmark::{geometry::Pose, mapping::{Occupancy, OccupancyMap, OccupancyMapConfig}};
/// use ballmark::recording::{Channel, Columns, Recording};
/// // One beam straight ahead, which ends at 2 m; seen twice from the same place.
/// let laser = Channel { name: "laser".into(), width: 1, unit: "m".into(), bearing_rad: Some(vec![0.0]), maximum: None, offset_m: None };
/// let recording = Recording::new(Columns {
///     channels: vec![laser],
///     values: ndarray::array![[2.0], [2.0]],
///     stamp_s: vec![0.0, 1.0],
///     pose: vec![Pose::new(0.02, 0.02, 0.0); 2],
///     odometry: vec![Pose::default(); 2],
///     run: vec![0, 0],
///     ..Columns::default()
/// })?;
/// let map = OccupancyMap::from_scans(&recording, &[0, 1], &OccupancyMapConfig::default())?;
/// assert_eq!(map.at(2.02, 0.02), Occupancy::Occupied);
/// assert_eq!(map.at(1.0, 0.02), Occupancy::Free);
/// assert_eq!(map.at(2.5, 0.02), Occupancy::Unknown);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct OccupancyMap {
    cell_m: f64,
    /// Corner of the first cell, in metres.
    origin_m: [f64; 2],
    width: usize,
    /// Row by row, from the south; each row from west to east.
    cells: Vec<Occupancy>,
}

impl OccupancyMap {
    /// The map that the range scans of some snapshots draw, each at its true pose. A beam without return tells nothing.
    ///
    /// # Errors
    /// Where a value of `config` makes no sense, the map would have more than its `most_cells` cells (usage errors), no
    /// channel has ranges with bearings, there is no snapshot, or no cell is occupied.
    pub fn from_scans(
        recording: &Recording,
        snapshots: &[usize],
        config: &OccupancyMapConfig,
    ) -> Result<Self> {
        config.check()?;
        let beams = config.sensors.beams(recording.channels());
        let beams = beams.map_err(|error| error.context("occupancy map"))?;
        let poses = recording.poses();
        let (low, high) = bounds(snapshots.iter().map(|&k| &poses[k]), config)?;
        let cells_along = |axis: usize| ((high[axis] - low[axis]) / config.cell_m).ceil().max(1.0);
        if cells_along(0) * cells_along(1) > config.most_cells as f64 {
            return Err(Error::usage(format!(
                "occupancy map: {} × {} cells of {} m; expected at most {} (a larger cell_m or a smaller margin_m)",
                cells_along(0),
                cells_along(1),
                config.cell_m,
                config.most_cells
            )));
        }
        let (width, height) = (cells_along(0) as usize, cells_along(1) as usize);
        let mut looks = Looks::new(width, height);
        let (cell_m, reach_m) = (config.cell_m, config.reach_m);
        let echoes = |&k: &usize| {
            let (pose, values) = (poses[k], recording.observation(k).values);
            let in_cells = move |at: [f64; 2]| [0, 1].map(|axis| (at[axis] - low[axis]) / cell_m);
            beams.iter().filter_map(move |beam| {
                let range_m = f64::from(values[beam.value]);
                // Else there was no return, or it is no distance.
                (range_m > 0.0 && range_m < reach_m).then(|| Echo {
                    middle: in_cells([pose.x_m, pose.y_m]),
                    from: in_cells(beam.point_m(&pose, 0.0)),
                    angle_rad: pose.heading_rad + beam.bearing_rad,
                    opening_rad: beam.opening_rad,
                    offset: beam.offset_m / cell_m,
                    range: range_m / cell_m,
                })
            })
        };
        let farthest = config.margin_m / config.cell_m;
        for (scan, k) in snapshots.iter().enumerate() {
            echoes(k).for_each(|echo| looks.way(&echo, farthest, scan as u32));
        }
        for echo in snapshots.iter().flat_map(echoes) {
            looks.end(&echo);
        }
        let map = Self {
            cell_m: config.cell_m,
            origin_m: low,
            width,
            cells: looks.occupancy(config),
        };
        if !map.cells.contains(&Occupancy::Occupied) {
            return Err(Error::work(
                "occupancy map: no cell is occupied; expected scans that see the same walls at least twice",
            ));
        }
        Ok(map)
    }

    /// A map of these cells, each of edge `cell_m`, `width` of them in a row: row by row from the south, each row from west
    /// to east, from the corner `origin_m`.
    ///
    /// # Errors
    /// Where they don't fill whole rows, edge or corner is no sound number of metres, or no cell is occupied.
    pub fn from_cells(
        cell_m: f64,
        origin_m: [f64; 2],
        width: usize,
        cells: Vec<Occupancy>,
    ) -> Result<Self> {
        if width == 0 || cells.is_empty() || !cells.len().is_multiple_of(width) {
            return Err(Error::work(format!(
                "occupancy map: {} cells in rows of {width}; expected whole rows",
                cells.len()
            )));
        }
        if !(cell_m.is_finite() && cell_m > 0.0 && origin_m.iter().all(|m| m.is_finite())) {
            return Err(Error::work(format!(
                "occupancy map: cells of {cell_m} m from {origin_m:?} on; expected finite metres, cells above 0"
            )));
        }
        if !cells.contains(&Occupancy::Occupied) {
            return Err(Error::work(
                "occupancy map: no cell is occupied; expected walls",
            ));
        }
        Ok(Self {
            cell_m,
            origin_m,
            width,
            cells,
        })
    }

    /// The same without the margins where nothing is known.
    pub fn cropped(&self) -> Self {
        let [width, height] = self.size();
        let known =
            |column: usize, row: usize| self.cells[row * width + column] != Occupancy::Unknown;
        let columns = 0..width;
        let rows = 0..height;
        let is_known_row = |row: &usize| columns.clone().any(|column| known(column, *row));
        let is_known_column = |column: &usize| rows.clone().any(|row| known(*column, row));
        // A map has an occupied cell, so there is a first and a last of each.
        let south = rows.clone().find(is_known_row).unwrap_or(0);
        let north = rows.clone().rev().find(is_known_row).unwrap_or(0);
        let west = columns.clone().find(is_known_column).unwrap_or(0);
        let east = columns.clone().rev().find(is_known_column).unwrap_or(0);
        let row = |row: usize| &self.cells[row * width + west..row * width + east + 1];
        Self {
            cell_m: self.cell_m,
            origin_m: [
                self.origin_m[0] + west as f64 * self.cell_m,
                self.origin_m[1] + south as f64 * self.cell_m,
            ],
            width: east + 1 - west,
            cells: (south..=north).flat_map(row).copied().collect(),
        }
    }

    /// Edge of a cell, in metres.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Corner of the first cell, x and y in metres.
    pub fn origin_m(&self) -> [f64; 2] {
        self.origin_m
    }

    /// Cells from west to east, and from south to north.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.cells.len() / self.width]
    }

    /// All cells, row by row from the south, each row from west to east.
    pub fn cells(&self) -> &[Occupancy] {
        &self.cells
    }

    /// What is known at a point; outside of the map nothing is.
    pub fn at(&self, x_m: f64, y_m: f64) -> Occupancy {
        let [width, height] = self.size();
        let column = ((x_m - self.origin_m[0]) / self.cell_m).floor();
        let row = ((y_m - self.origin_m[1]) / self.cell_m).floor();
        let within = |index: f64, count: usize| index >= 0.0 && index < count as f64;
        match within(column, width) && within(row, height) {
            true => self.cells[row as usize * width + column as usize],
            false => Occupancy::Unknown,
        }
    }

    /// What the map takes on a robot, packed: a bit for every cell that is not unknown, in bytes.
    pub fn bytes(&self) -> usize {
        let known = self
            .cells
            .iter()
            .filter(|cell| **cell != Occupancy::Unknown);
        known.count().div_ceil(8)
    }
}

/// The rectangle around some poses with the margin, from its south-west to its north-east corner.
fn bounds<'a>(
    poses: impl Iterator<Item = &'a Pose>,
    config: &OccupancyMapConfig,
) -> Result<([f64; 2], [f64; 2])> {
    let nothing = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    let (low, high) = poses.fold(nothing, |(low, high), pose| {
        let at = [pose.x_m, pose.y_m];
        (
            [0, 1].map(|axis| at[axis].min(low[axis])),
            [0, 1].map(|axis| at[axis].max(high[axis])),
        )
    });
    if low[0] > high[0] {
        return Err(Error::work(
            "occupancy map: no snapshot to map; expected at least one",
        ));
    }
    let margin_m = config.margin_m;
    Ok((low.map(|v| v - margin_m), high.map(|v| v + margin_m)))
}
