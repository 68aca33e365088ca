//! The true location as one of a few places: square bins, their grid laid over the trace so that it cuts it as little
//! as it can (Duckett & Nehmzow 1998, 6.4).

use super::uncertainty::entropy;
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::{
    cmp::{Ordering, Reverse},
    collections::HashMap,
    f64::consts::FRAC_PI_2,
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

/// Orientations that are tried: a grid turned by a right angle is the same grid, so these are whole degrees.
const ORIENTATIONS: usize = 90;
/// Offsets that are tried along each axis of the grid: 5 cm apart for bins of 2 m.
const OFFSETS: usize = 40;
/// Points that are counted between two looks at whether the grid can still be the best.
const LOOK_UP: usize = 128;
/// Most squares that a grid may have along an axis, so that a mistaken unit is refused and not computed.
const MAX_ALONG_AXIS: f64 = 2_000.0;

/// A grid of square bins over the places where a robot was.
///
/// "The orientation and positioning of the dotted grid … was determined using a search procedure to minimise the number
/// of bins occupied, and then to maximise the value of H(L) where several possible grid positions produced the same
/// number of bins" (Duckett & Nehmzow 1998, 6.4). The paper doesn't say how finely it searched; here every whole degree
/// and every fortieth of a bin along both axes is tried, 144,000 grids in all. They are counted from the points'
/// centroid, so a trace that is shifted, or turned by whole degrees, gets the same grid shifted and turned. Of grids
/// alike in both figures the first in that order is taken.
///
/// Bins are numbered in the order in which the trace first enters them.
///
/// ```
/// use ballmark::score::Binning;
/// // Three laps along a corridor 12 m long and back, 1 m aside; somewhere on a map, and askew.
/// let lap = (0..120).map(|k| if k < 60 { [0.2 * f64::from(k), 0.0] } else { [0.2 * f64::from(119 - k), 1.0] });
/// let (sin, cos) = 0.3_f64.sin_cos();
/// let turned = |[x, y]: [f64; 2]| [50.0 + cos * x - sin * y, sin * x + cos * y];
/// let trace: Vec<[f64; 2]> = lap.cycle().take(360).map(turned).collect();
///
/// let binning = Binning::search(&trace, 2.0)?;
/// assert_eq!(binning.bins(), 6); // one row of six, wherever the axes of the map lie
/// assert!((binning.entropy() - 6_f64.ln()).abs() < 1e-3); // and all alike
/// assert_eq!(binning.bin_of(trace[0]), Some(0));
/// assert_eq!(binning.bin_of(trace[119]), Some(0)); // back beside the start
/// assert_eq!(binning.bin_of(turned([6.0, 5.0])), None); // off the trace: outside
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Binning {
    grid: Grid,
    /// Number of each occupied square.
    numbers: HashMap<[i64; 2], usize>,
    /// Points in each bin, by its number.
    occupancy: Vec<u64>,
}

/// Squares of one size, by where they lie.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Grid {
    centre: [f64; 2],
    size_m: f64,
    /// Number of the orientation and of the offset along both axes.
    orientation: usize,
    offset: [usize; 2],
}

/// One grid of the search, and how well it lies. The least is the best: fewest bins, then the greatest entropy, then
/// the first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Candidate {
    bins: usize,
    entropy: f64,
    orientation: usize,
    offset: [usize; 2],
}

impl Candidate {
    fn order(&self, other: &Self) -> Ordering {
        let place = |c: &Self| (c.orientation, c.offset);
        self.bins
            .cmp(&other.bins)
            .then(other.entropy.total_cmp(&self.entropy))
            .then(place(self).cmp(&place(other)))
    }
}

impl Binning {
    /// Lays squares with sides of `size_m` metres over the points (x and y, metres) as well as can be.
    ///
    /// The points are the robot's true places at even intervals over whole laps, as H(L) weighs a bin by the points
    /// in it. About a second for ten thousand of them.
    ///
    /// # Errors
    /// Where the size is not more than 0 or there are more than 2,000 bins along an axis (usage errors), a point is
    /// not finite, or there is none.
    pub fn search(points: &[[f64; 2]], size_m: f64) -> Result<Self> {
        if !(size_m > 0.0 && size_m.is_finite()) {
            return Err(Error::usage(format!(
                "binning: bins of {size_m} m; expected more than 0"
            )));
        }
        if points.is_empty() {
            return Err(Error::work("binning: no points; expected at least one"));
        }
        if let Some(at) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
            return Err(Error::work(format!(
                "binning: point {at} is ({}, {}); expected metres",
                points[at][0], points[at][1]
            )));
        }
        let centre = centroid(points);
        let farthest_m = points
            .iter()
            .map(|p| (p[0] - centre[0]).hypot(p[1] - centre[1]))
            .fold(0.0, f64::max);
        if 2.0 * farthest_m / size_m > MAX_ALONG_AXIS {
            return Err(Error::usage(format!(
                "binning: bins of {size_m} m over places up to {farthest_m:.0} m from their middle; expected up to {MAX_ALONG_AXIS} bins along an axis"
            )));
        }
        let fewest = AtomicUsize::new(usize::MAX);
        let best = (0..ORIENTATIONS)
            .into_par_iter()
            .filter_map(|orientation| best_offset(points, centre, size_m, orientation, &fewest))
            .min_by(Candidate::order)
            // One orientation found the fewest bins, so there is a best.
            .ok_or_else(|| Error::work("binning: no grid was tried"))?;
        let grid = Grid {
            centre,
            size_m,
            orientation: best.orientation,
            offset: best.offset,
        };
        let (mut numbers, mut occupancy) = (HashMap::new(), Vec::new());
        for &point in points {
            let bin = *numbers.entry(grid.square(point)).or_insert(occupancy.len());
            if bin == occupancy.len() {
                occupancy.push(0);
            }
            occupancy[bin] += 1;
        }
        Ok(Self {
            grid,
            numbers,
            occupancy,
        })
    }

    /// The bin that a place lies in; `None` is outside, where none of the points was: a location of its own for a robot
    /// that believes to be there (Duckett & Nehmzow 1998, 7.1).
    pub fn bin_of(&self, point: [f64; 2]) -> Option<usize> {
        if !point.iter().all(|c| c.is_finite()) {
            return None; // not a number is no square either
        }
        self.numbers.get(&self.grid.square(point)).copied()
    }

    /// How many bins are occupied.
    pub fn bins(&self) -> usize {
        self.occupancy.len()
    }

    /// How many of the points lie in each bin.
    pub fn occupancy(&self) -> &[u64] {
        &self.occupancy
    }

    /// H(L) of the points, in nats.
    pub fn entropy(&self) -> f64 {
        sorted_entropy(self.occupancy.clone())
    }

    /// Length of a bin's sides, metres.
    pub fn size_m(&self) -> f64 {
        self.grid.size_m
    }

    /// Direction of the grid's first axis, in [0, π/2) radians.
    pub fn orientation_rad(&self) -> f64 {
        self.grid.orientation_rad()
    }

    /// A corner at which four squares of the grid meet, metres.
    pub fn corner_m(&self) -> [f64; 2] {
        let (sin, cos) = self.orientation_rad().sin_cos();
        let [a, b] = self
            .grid
            .offset
            .map(|k| self.grid.size_m * k as f64 / OFFSETS as f64);
        [
            self.grid.centre[0] + cos * a - sin * b,
            self.grid.centre[1] + sin * a + cos * b,
        ]
    }
}

impl Grid {
    fn orientation_rad(&self) -> f64 {
        FRAC_PI_2 * self.orientation as f64 / ORIENTATIONS as f64
    }

    /// Where a point lies along the two axes, counted in squares from the centre.
    fn along_axes(&self, point: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.orientation_rad().sin_cos();
        let [x, y] = [point[0] - self.centre[0], point[1] - self.centre[1]];
        [
            (cos * x + sin * y) / self.size_m,
            (cos * y - sin * x) / self.size_m,
        ]
    }

    /// The square that a point lies in.
    fn square(&self, point: [f64; 2]) -> [i64; 2] {
        let along = self.along_axes(point);
        [0, 1].map(|axis| strip(along[axis], self.offset[axis]))
    }
}

/// Number of the strip of squares that a coordinate lies in, the grid being moved by so many fortieths of a square.
fn strip(along: f64, offset: usize) -> i64 {
    // Saturates far outside, where there are no bins.
    (along - offset as f64 / OFFSETS as f64).floor() as i64
}

/// The best of all offsets at one orientation, if it is as good as the fewest bins that any orientation has found: that
/// number, which the threads share, only says which grids needn't be looked at to the end.
fn best_offset(
    points: &[[f64; 2]],
    centre: [f64; 2],
    size_m: f64,
    orientation: usize,
    fewest: &AtomicUsize,
) -> Option<Candidate> {
    let unmoved = Grid {
        centre,
        size_m,
        orientation,
        offset: [0, 0],
    };
    let along: Vec<[f64; 2]> = points.iter().map(|&p| unmoved.along_axes(p)).collect();
    let [columns, rows] = [0, 1].map(|axis| strips(&along, axis));
    // Which grid was the last to find a square occupied: no need to clear between grids.
    let mut seen = vec![0_u32; columns.width * rows.width];
    let mut grid = 0;
    let mut least = Vec::new();
    for (i, column) in columns.square_of.iter().enumerate() {
        for (j, row) in rows.square_of.iter().enumerate() {
            grid += 1;
            let allowed = fewest.load(Relaxed);
            let mut bins = 0;
            for (column, row) in column.chunks(LOOK_UP).zip(row.chunks(LOOK_UP)) {
                for (&column, &row) in column.iter().zip(row) {
                    let square = &mut seen[column as usize * rows.width + row as usize];
                    bins += usize::from(*square != grid);
                    *square = grid;
                }
                if bins > allowed {
                    break;
                }
            }
            if bins <= allowed {
                fewest.fetch_min(bins, Relaxed);
                least.push((bins, [i, j]));
            }
        }
    }
    // Of those that any other grid has bettered in the meantime, none can be the best.
    let allowed = fewest.load(Relaxed);
    least.retain(|&(bins, _)| bins <= allowed);
    let mut counts = vec![0_u64; seen.len()];
    let candidates = least.into_iter().map(|(bins, offset)| {
        let (column, row) = (&columns.square_of[offset[0]], &rows.square_of[offset[1]]);
        let squares = || {
            column
                .iter()
                .zip(row)
                .map(|(&c, &r)| c as usize * rows.width + r as usize)
        };
        squares().for_each(|square| counts[square] += 1);
        let occupancy = squares()
            .map(|square| std::mem::take(&mut counts[square]))
            .filter(|&count| count > 0)
            .collect();
        Candidate {
            bins,
            entropy: sorted_entropy(occupancy),
            orientation,
            offset,
        }
    });
    candidates.min_by(Candidate::order)
}

/// Along one axis, the strip of every point at every offset, counted from the first one occupied.
struct Strips {
    square_of: Vec<Vec<u32>>,
    width: usize,
}

fn strips(along: &[[f64; 2]], axis: usize) -> Strips {
    let all = || along.iter().map(|along| along[axis]);
    // A larger offset makes numbers smaller.
    let first = all()
        .map(|a| strip(a, OFFSETS - 1))
        .min()
        .unwrap_or_default();
    let last = all().map(|a| strip(a, 0)).max().unwrap_or_default();
    Strips {
        square_of: (0..OFFSETS)
            .map(|offset| all().map(|a| (strip(a, offset) - first) as u32).collect())
            .collect(),
        width: (last - first) as usize + 1,
    }
}

/// Entropy of counts in descending order: the same counts in other squares then give the same bits, and grids that are
/// alike stay alike.
fn sorted_entropy(mut counts: Vec<u64>) -> f64 {
    counts.sort_unstable_by_key(|&count| Reverse(count));
    entropy(&counts, counts.iter().sum())
}

fn centroid(points: &[[f64; 2]]) -> [f64; 2] {
    // From the first point, so that a far-off origin costs no digits.
    let [x, y] = points[0];
    let (sum_x, sum_y) = points
        .iter()
        .fold((0.0, 0.0), |(a, b), p| (a + (p[0] - x), b + (p[1] - y)));
    let n = points.len() as f64;
    [x + sum_x / n, y + sum_y / n]
}

#[cfg(test)]
mod tests;
