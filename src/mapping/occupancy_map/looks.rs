//! How often beams ended in the cells of an occupancy map, and how often scans crossed them.

use super::{Occupancy, OccupancyMapConfig};

/// Looks at every cell.
///
/// A beam crossed the cells along its axis. A ray ended in one cell; the echo of a cone came from somewhere on its arc: from
/// the cells there that fewest scans have crossed, as one reason is enough for an echo (Thrun, Burgard & Fox, *Probabilistic
/// Robotics*, 2005, 9.4, who search all maps for such reasons). So all ways are counted before the first arc is. The inside
/// of a cone besides its axis is not taken as free: smooth walls send slanting cones on, and what comes back late would say
/// that there is no wall.
pub(super) struct Looks {
    size: [usize; 2],
    /// Beams that ended in a cell.
    ended: Vec<u32>,
    /// Scans that crossed it, and the last of them plus 1: a scan's beams cross a near cell many times and count once.
    crossed: Vec<u32>,
    crossed_by: Vec<u32>,
}

/// A beam that came back: in the frame of the cells, in cells.
pub(super) struct Echo {
    /// The robot's middle.
    pub(super) middle: [f64; 2],
    /// Where its sensor sits, `offset` from there.
    pub(super) from: [f64; 2],
    pub(super) angle_rad: f64,
    pub(super) opening_rad: f64,
    pub(super) offset: f64,
    /// Counts from the sensor.
    pub(super) range: f64,
}

impl Echo {
    /// Directions through it, so near to each other that on the arc no cell is left out.
    fn directions(&self) -> impl Iterator<Item = [f64; 2]> {
        let steps = (self.opening_rad * self.range).ceil().max(0.0) as usize;
        let apart_rad = self.opening_rad / steps.max(1) as f64;
        let first_rad = self.angle_rad - 0.5 * self.opening_rad;
        (0..=steps).map(move |i| {
            let (sin, cos) = (first_rad + i as f64 * apart_rad).sin_cos();
            [cos, sin]
        })
    }

    fn end(&self, direction: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.from[axis] + self.range * direction[axis])
    }
}

impl Looks {
    pub(super) fn new(width: usize, height: usize) -> Self {
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

    /// Counts what an echo of a scan crossed, `farthest` cells along it at most, and what the robot stands on before its sensor.
    pub(super) fn way(&mut self, echo: &Echo, farthest: f64, scan: u32) {
        // Two cells before the end still belong to what was hit.
        let length = (echo.offset + echo.range - 2.0).min(farthest);
        let (sin, cos) = echo.angle_rad.sin_cos();
        self.cross(echo.middle, [cos, sin], length, scan);
    }

    /// Counts where an echo came from.
    pub(super) fn end(&mut self, echo: &Echo) {
        let mut arc: Vec<usize> = echo
            .directions()
            .filter_map(|direction| self.cell(echo.end(direction)))
            .collect();
        arc.sort_unstable();
        arc.dedup();
        let fewest = arc.iter().map(|&cell| self.crossed[cell]).min();
        for cell in arc {
            if Some(self.crossed[cell]) == fewest {
                self.ended[cell] += 1;
            }
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

    pub(super) fn occupancy(&self, config: &OccupancyMapConfig) -> Vec<Occupancy> {
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
