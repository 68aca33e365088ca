//! Carrying masses over a grid: ∫ P(ξ|ξ̃, a) Bel(ξ̃) dξ̃ (Thrun 1998, eq. 19) on cells.
//!
//! A cell's mass moves by a fraction of cells as a rule, so it is shared among the four cells it lands on (bilinear
//! interpolation) and blurred. The sharing is a blur of its own, of variance f(1−f) cells² for a fraction f on either
//! axis; it is taken off the noise, so that the total is what the motion model says wherever that is the larger of the
//! two.
//!
//! At the border: noise can't push the robot through a wall, so the blur keeps that mass where it is. A movement that ends
//! off the grid did not happen, since the robot is on it: that mass is dropped, and normalising makes up for it.
//!
//! Headings are moved one by one into the workspace, which sums their masses as it goes; then bands of sites, all headings
//! of a band, are turned back into the belief, already normalised. Both pass by blocks without mass.

use super::{
    columns::Columns,
    grid::Grid,
    kernel::Kernel,
    lattice::Lattice,
    motion::OdometryMotion,
    places::Places,
    support::{Layer, Support},
    turn::{Moved, turn},
};
use crate::{geometry::Displacement, simd};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Room to work in, kept from step to step: as many masses as the belief has.
#[derive(Debug, Clone, Default)]
pub(super) struct Workspace {
    mass: Vec<f64>,
    held: Vec<bool>,
    columns: Option<Columns>,
}

/// How the masses of one heading move.
struct Move {
    shift: [Shift; 2],
    kernels: [Kernel; 2],
}

/// Replaces the masses by those after a movement, normalised, and says where they are.
pub(super) fn step(
    grid: &Grid,
    motion: &OdometryMotion,
    step: &Displacement,
    mass: &mut [f64],
    support: &mut Support,
    workspace: &mut Workspace,
) {
    let (lattice, blocks) = (grid.lattice(), support.blocks());
    let moves: Vec<Move> = (0..grid.headings())
        .map(|heading| Move::new(grid, motion, step, heading))
        .collect();
    workspace.mass.resize(mass.len(), 0.0);
    workspace.held.resize(support.held().len(), false);
    let reach = moves.iter().map(|m| m.kernels[1].radius()).max();
    let reach = reach.unwrap_or(0);
    let columns = workspace.columns.take();
    let columns = columns
        .filter(|columns| columns.reach() >= reach)
        .unwrap_or_else(|| Columns::new(lattice, reach));

    let sites = lattice.len();
    let sources = mass
        .par_chunks_mut(sites)
        .zip(support.held_mut().par_chunks_mut(blocks));
    let targets = workspace
        .mass
        .par_chunks_mut(sites)
        .zip(workspace.held.par_chunks_mut(blocks));
    let totals: Vec<f64> = sources
        .zip(targets)
        .zip(&moves)
        .map(|(((mass, held), (moved, moved_held)), how)| {
            let mut target = Layer::new(moved, moved_held);
            target.forget();
            let source = Layer::new(mass, held);
            if source.is_empty() {
                return 0.0;
            }
            simd::run(MoveLayer {
                lattice,
                columns: &columns,
                how,
                stall: motion.stall_probability,
                source,
                target,
            })
        })
        .collect();
    workspace.columns = Some(columns);

    let mut weights = match grid.headings() {
        1 => vec![1.0],
        headings => turn_weights(headings, motion, step),
    };
    // Turning keeps mass, so what it adds up to is known.
    let total: f64 = totals.iter().sum();
    weights.iter_mut().for_each(|weight| *weight /= total);
    let moved = Moved {
        mass: &workspace.mass,
        held: &workspace.held,
    };
    turn(&weights, moved, mass, support);
}

impl Move {
    fn new(grid: &Grid, motion: &OdometryMotion, step: &Displacement, heading: usize) -> Self {
        let lattice = grid.lattice();
        let (east_m, north_m) = match **grid.places() {
            // A step along the route is as long as the way, forwards or backwards.
            Places::Route(_) => (step.along_route_m(), 0.0),
            Places::Plane(_) => {
                let (sin, cos) = (heading as f64 * TAU / grid.headings() as f64).sin_cos();
                let (ahead, left) = (step.forward_m, step.left_m);
                (cos * ahead - sin * left, sin * ahead + cos * left)
            }
        };
        let shift = [east_m, north_m].map(|d| Shift::new(d / lattice.cell_m(), lattice.extent()));
        let variance = motion.position_variance_m2(step) / (lattice.cell_m() * lattice.cell_m());
        let kernels = shift.map(|s| Kernel::gaussian(variance - s.variance(), lattice.extent()));
        Self { shift, kernels }
    }
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

/// Moves and blurs the masses of one heading, and returns their sum; `source` is room to work in afterwards.
struct MoveLayer<'a> {
    lattice: &'a Lattice,
    columns: &'a Columns,
    how: &'a Move,
    stall: f64,
    source: Layer<'a>,
    target: Layer<'a>,
}

impl simd::Kernel for MoveLayer<'_> {
    type Output = f64;

    #[inline(always)]
    fn run(mut self) -> f64 {
        let (mut row, target) = (Vec::new(), &mut self.target);
        let [along_rows, along_columns] = &self.how.kernels;
        let shift = &self.how.shift;
        shift_layer(
            self.lattice,
            shift,
            self.stall,
            &self.source,
            target,
            &mut row,
        );
        if !along_rows.is_identity() {
            blur_rows(self.lattice, along_rows, target, &mut row);
        }
        if !along_columns.is_identity() {
            let blurred = &mut self.source;
            self.columns
                .blur(self.lattice, along_columns, target, blurred);
            target.copy_from(blurred);
        }
        target.sum()
    }
}

/// Adds what stalls where it is, and the rest where it moves to; what leaves the lattice is dropped.
#[inline(always)]
fn shift_layer(
    lattice: &Lattice,
    [east, north]: &[Shift; 2],
    stall: f64,
    source: &Layer,
    target: &mut Layer,
    row: &mut Vec<f64>,
) {
    let [near, far] = [1.0 - east.fraction, east.fraction].map(|share| (1.0 - stall) * share);
    let mut taps = [
        (north.whole, 1.0 - north.fraction, 0),
        (north.whole + 1, north.fraction, 0),
    ];
    for run in lattice.runs() {
        let span = source.span(&run.sites);
        if span.is_empty() {
            continue;
        }
        let masses = source.mass(span.clone());
        target.add(span.start, masses, stall);
        // The row between the columns, then shared between two rows.
        let n = masses.len();
        row.resize(n + 1, 0.0);
        row[0] = near * masses[0];
        row[n] = far * masses[n - 1];
        let pairs = masses[1..].iter().zip(masses);
        for (t, (own, left)) in row[1..n].iter_mut().zip(pairs) {
            *t = near * own + far * left;
        }
        let shared = &row[..n + usize::from(far > 0.0)];
        let first = run.column + (span.start - run.sites.start) as i64 + east.whole;
        let columns = first..first + shared.len() as i64;
        for (rows, weight, cursor) in &mut taps {
            if *weight > 0.0 {
                let row = run.row + *rows;
                for (_, offset, sites) in lattice.overlaps(cursor, row, columns.clone()) {
                    target.add(sites.start, &shared[offset..offset + sites.len()], *weight);
                }
            }
        }
    }
}

#[inline(always)]
fn blur_rows(lattice: &Lattice, kernel: &Kernel, layer: &mut Layer, row: &mut Vec<f64>) {
    let mut padded = Vec::new();
    for run in lattice.runs() {
        let span = layer.span(&run.sites);
        if span.is_empty() {
            continue;
        }
        row.clear();
        row.extend_from_slice(layer.mass(span.clone()));
        let (before, after) = (span.start - run.sites.start, run.sites.end - span.end);
        let (left, right) = kernel.reach(before, row.len(), after);
        let target = layer.mass_mut(span.start - left..span.end + right);
        kernel.blur(before, row, after, &mut padded, target);
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
