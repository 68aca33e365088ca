//! Carrying masses over a grid: ∫ P(ξ|ξ̃, a) Bel(ξ̃) dξ̃ (Thrun 1998, eq. 19) on cells.
//!
//! A cell's mass moves by a fraction of cells as a rule, so it is shared among the four cells it lands on (bilinear
//! interpolation) and blurred. The sharing is a blur of its own, of variance f(1−f) cells² for a fraction f on either
//! axis; it is taken off the noise, so that the total is what the motion model says wherever that is the larger of the
//! two.
//!
//! At the border: noise can't push the robot through a wall, so the blur keeps that mass where it is. A movement that ends
//! off the grid did not happen, since the robot is on it: that mass is dropped, and normalising makes up for it.

use super::{grid::Grid, kernel::Kernel, lattice::Lattice, motion::OdometryMotion, places::Places};
use crate::geometry::Displacement;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// The masses after a movement, not normalised.
pub(super) fn moved(
    grid: &Grid,
    motion: &OdometryMotion,
    step: &Displacement,
    mass: &[f64],
) -> Vec<f64> {
    let lattice = grid.lattice();
    let sites = lattice.len();
    let variance_m2 = motion.position_variance_m2(step);
    let mut moved = vec![0.0; mass.len()];
    let planes = moved
        .par_chunks_mut(sites)
        .zip(mass.par_chunks(sites))
        .enumerate();
    planes.for_each(|(heading, (target, source))| {
        let (east_m, north_m) = match **grid.places() {
            // A step along the route is as long as the way, forwards or backwards.
            Places::Route(_) => (step.distance_m().copysign(step.forward_m), 0.0),
            Places::Plane(_) => {
                let (sin, cos) = (heading as f64 * TAU / grid.headings() as f64).sin_cos();
                let (ahead, left) = (step.forward_m, step.left_m);
                (cos * ahead - sin * left, sin * ahead + cos * left)
            }
        };
        let shift = [east_m, north_m].map(|d| Shift::new(d / lattice.cell_m(), lattice.extent()));
        let variance = variance_m2 / (lattice.cell_m() * lattice.cell_m());
        let kernels = shift.map(|s| Kernel::gaussian(variance - s.variance(), lattice.extent()));
        move_plane(
            lattice,
            shift,
            &kernels,
            motion.stall_probability,
            source,
            target,
        );
    });
    if grid.headings() == 1 {
        return moved;
    }
    let weights = turn_weights(grid.headings(), motion, step);
    turn_planes(&weights, sites, &moved)
}

/// A distance in cells, cut into a whole number and a fraction in [0, 1).
#[derive(Clone, Copy)]
struct Shift {
    whole: i64,
    fraction: f64,
}

impl Shift {
    fn new(cells: f64, extent: usize) -> Self {
        // Beyond the grid is beyond the grid, however far.
        let beyond = extent as f64 + 1.0;
        let cells = cells.clamp(-beyond, beyond);
        // 0.9999999999 of a cell is one cell: rounding should not share it among two.
        let whole = (cells + 1e-9).floor();
        Self {
            whole: whole as i64,
            fraction: (cells - whole).max(0.0),
        }
    }

    fn variance(self) -> f64 {
        self.fraction * (1.0 - self.fraction)
    }
}

/// Moves and blurs the masses of one heading.
fn move_plane(
    lattice: &Lattice,
    [east, north]: [Shift; 2],
    [along_rows, along_columns]: &[Kernel; 2],
    stall: f64,
    source: &[f64],
    target: &mut [f64],
) {
    target
        .iter_mut()
        .zip(source)
        .for_each(|(t, s)| *t = stall * s);
    for (columns, weight_east) in [(0, 1.0 - east.fraction), (1, east.fraction)] {
        for (rows, weight_north) in [(0, 1.0 - north.fraction), (1, north.fraction)] {
            let weight = (1.0 - stall) * weight_east * weight_north;
            if weight > 0.0 {
                let (columns, rows) = (east.whole + columns, north.whole + rows);
                lattice.add_shifted(source, target, columns, rows, weight);
            }
        }
    }
    let mut blurred = vec![0.0; target.len()];
    if !along_rows.is_identity() {
        lattice.along_rows(target, &mut blurred, |from, to| along_rows.blur(from, to));
        target.copy_from_slice(&blurred);
    }
    if !along_columns.is_identity() {
        lattice.along_columns(target, &mut blurred, |from, to| {
            along_columns.blur(from, to)
        });
        target.copy_from_slice(&blurred);
    }
}

/// P(heading + j cells | heading) for j = 0..headings, around the circle.
fn turn_weights(headings: usize, motion: &OdometryMotion, step: &Displacement) -> Vec<f64> {
    let cell_rad = TAU / headings as f64;
    // The turn as at most one round: the circle has no end, so the extent that bounds it is any.
    let shift = Shift::new(step.turn_rad.rem_euclid(TAU) / cell_rad, headings);
    let variance = motion.heading_variance_rad2(step) / (cell_rad * cell_rad) - shift.variance();
    let blur = Kernel::gaussian(variance, 4 * headings); // four rounds are flat
    let mut weights = vec![0.0; headings];
    for (cells, weight) in [(0, 1.0 - shift.fraction), (1, shift.fraction)] {
        let centre = shift.whole + cells;
        for offset in -(blur.radius() as i64)..=blur.radius() as i64 {
            let heading = (centre + offset).rem_euclid(headings as i64) as usize;
            weights[heading] += weight * blur.weight(offset.unsigned_abs() as usize);
        }
    }
    weights
}

/// Shares each heading's plane among the headings it may have turned to.
fn turn_planes(weights: &[f64], sites: usize, mass: &[f64]) -> Vec<f64> {
    let headings = weights.len();
    let mut turned = vec![0.0; mass.len()];
    turned
        .par_chunks_mut(sites)
        .enumerate()
        .for_each(|(heading, target)| {
            for (turn, &weight) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
                let from = (heading + headings - turn) % headings;
                let source = &mass[from * sites..(from + 1) * sites];
                target
                    .iter_mut()
                    .zip(source)
                    .for_each(|(t, s)| *t += weight * s);
            }
        });
    turned
}
