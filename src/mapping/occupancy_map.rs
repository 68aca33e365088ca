//! An occupancy map of a recording's range scans at their poses: how often beams ended in a cell, how often they crossed it.

use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Recording},
};
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
        Ok(())
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
/// let laser = Channel { name: "laser".into(), width: 1, unit: "m".into(), bearing_rad: Some(vec![0.0]), maximum: None };
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
    /// The map that the range scans of some snapshots draw, each at its true pose. All channels in metres whose bearings are
    /// known take part; a beam without return tells nothing.
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
        let beams = range_beams(recording.channels());
        if beams.is_empty() {
            return Err(Error::work(
                "occupancy map: no channel in metres has bearings; expected a range sensor whose beams' directions are known",
            ));
        }
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
        for (scan, &k) in snapshots.iter().enumerate() {
            let (pose, values) = (poses[k], recording.observation(k).values);
            let from = [0, 1].map(|axis| ([pose.x_m, pose.y_m][axis] - low[axis]) / config.cell_m);
            for &(value, bearing_rad) in &beams {
                let range_m = f64::from(values[value]);
                if !(range_m > 0.0 && range_m < config.reach_m) {
                    continue; // no return, or no distance
                }
                let (sin, cos) = (pose.heading_rad + bearing_rad).sin_cos();
                let direction = [cos, sin];
                let range = range_m / config.cell_m;
                looks.end([0, 1].map(|axis| from[axis] + range * direction[axis]));
                // Two cells before the end still belong to what was hit.
                let crossed = (range - 2.0).min(config.margin_m / config.cell_m);
                looks.cross(from, direction, crossed, scan as u32);
            }
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

/// Place among a snapshot's values, and bearing, of every range reading with a known direction.
pub(crate) fn range_beams(channels: &[Channel]) -> Vec<(usize, f64)> {
    let mut first = 0;
    let mut beams = Vec::new();
    for channel in channels {
        if let ("m", Some(bearings)) = (channel.unit.as_str(), &channel.bearing_rad) {
            beams.extend(bearings.iter().enumerate().map(|(i, &b)| (first + i, b)));
        }
        first += channel.width;
    }
    beams
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

/// Looks at every cell.
struct Looks {
    size: [usize; 2],
    /// Beams that ended in a cell.
    ended: Vec<u32>,
    /// Scans that crossed it, and the last of them plus 1: a scan's beams cross a near cell many times and count once.
    crossed: Vec<u32>,
    crossed_by: Vec<u32>,
}

impl Looks {
    fn new(width: usize, height: usize) -> Self {
        let none = || vec![0; width * height];
        Self {
            size: [width, height],
            ended: none(),
            crossed: none(),
            crossed_by: none(),
        }
    }

    /// The cell at a point given in cells.
    fn cell(&self, at: [f64; 2]) -> Option<usize> {
        let [column, row] = at.map(f64::floor);
        let within = column >= 0.0
            && row >= 0.0
            && column < self.size[0] as f64
            && row < self.size[1] as f64;
        within.then(|| row as usize * self.size[0] + column as usize)
    }

    fn end(&mut self, at: [f64; 2]) {
        if let Some(cell) = self.cell(at) {
            self.ended[cell] += 1;
        }
    }

    /// Marks the cells of a ray, cell by cell (Amanatides & Woo 1987), `length` cells long.
    fn cross(&mut self, from: [f64; 2], direction: [f64; 2], length: f64, scan: u32) {
        let mut at = from.map(f64::floor);
        let step = direction.map(|d| if d < 0.0 { -1.0 } else { 1.0 });
        let along = direction.map(|d| {
            if d == 0.0 {
                f64::INFINITY
            } else {
                1.0 / d.abs()
            }
        });
        // Way along the ray to the next border on either axis.
        let mut next = [0, 1].map(|axis| {
            let within = from[axis] - at[axis];
            let left = if step[axis] > 0.0 {
                1.0 - within
            } else {
                within
            };
            left * along[axis]
        });
        let mut way = 0.0;
        while way < length {
            if let Some(cell) = self.cell(at)
                && self.crossed_by[cell] != scan + 1
            {
                self.crossed_by[cell] = scan + 1;
                self.crossed[cell] += 1;
            }
            let axis = usize::from(next[1] < next[0]);
            way = next[axis];
            next[axis] += along[axis];
            at[axis] += step[axis];
        }
    }

    fn occupancy(&self, config: &OccupancyMapConfig) -> Vec<Occupancy> {
        let cells = self.ended.iter().zip(&self.crossed);
        let occupancy = cells.map(|(&ended, &crossed)| {
            let looks = f64::from(ended) + f64::from(crossed);
            if ended >= config.least_hits && f64::from(ended) > config.least_share * looks {
                Occupancy::Occupied
            } else if crossed > 0 {
                Occupancy::Free
            } else {
                Occupancy::Unknown
            }
        });
        occupancy.collect()
    }
}
