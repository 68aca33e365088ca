//! A global prior in the plane by cells (Thrun 1998, 4.4.2 item 2): linear in the number of places.

use super::{
    all_pairs::{self, AllPairs},
    rows::{CHUNK, Rows},
    workspace::{PriorSums, Scratch},
};
use crate::{
    geometry::Pose,
    learning::lanes::{LANES, Lanes, Real},
    simd::{InstructionSet, Kernel},
};
use rayon::prelude::*;
use std::{collections::BTreeMap, ops::Range};

/// Places in square cells, and the distances between the middles of cells that hold any.
///
/// A place is at most half a diagonal from the middle of its cell, so |e − e of the cells| ≤ one diagonal.
pub struct Cells {
    truths: Side,
    candidates: Side,
    between: AllPairs,
}

/// The places of one side.
struct Side {
    /// The cell that every place is in.
    cell: Vec<u32>,
    /// The places in every cell, one cell after the other.
    places: Vec<u32>,
    start: Vec<usize>,
}

impl Cells {
    pub(super) fn new(truths: &[Pose], candidates: &[Pose], side_m: f64) -> Self {
        let (truths, truth_middles) = Side::new(truths, side_m);
        let (candidates, candidate_middles) = Side::new(candidates, side_m);
        Self {
            truths,
            candidates,
            between: AllPairs::between(truth_middles, candidate_middles),
        }
    }

    /// Numbers of truths and candidates.
    pub(super) fn counts(&self) -> (usize, usize) {
        (self.truths.cell.len(), self.candidates.cell.len())
    }

    /// Adds the map's rows up cell by cell, and sums over them for every cell that holds a truth.
    pub(super) fn prepare<T: Real>(
        &self,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        instructions: InstructionSet,
    ) {
        add_up_by_cells(&self.candidates, rows, scratch, instructions);
        let Scratch {
            cell_rows,
            cell_sums,
            ..
        } = scratch;
        let cells = self.truths.cells();
        in_chunks_of_cells(
            cell_rows,
            cells,
            rows.tiles,
            cell_sums,
            |first, rows, out| {
                let between = &self.between;
                instructions.run(BetweenCells::<_, false> {
                    between,
                    first,
                    rows,
                    out,
                });
            },
        );
    }

    /// Adds the truths' rows up cell by cell, and sums over them for every cell that holds a candidate.
    pub(super) fn prepare_transpose<T: Real>(
        &self,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        instructions: InstructionSet,
    ) {
        add_up_by_cells(&self.truths, rows, scratch, instructions);
        let Scratch {
            cell_rows,
            cell_sums,
            ..
        } = scratch;
        let cells = self.candidates.cells();
        in_chunks_of_cells(
            cell_rows,
            cells,
            rows.tiles,
            cell_sums,
            |first, rows, out| {
                let between = &self.between;
                instructions.run(BetweenCells::<_, true> {
                    between,
                    first,
                    rows,
                    out,
                });
            },
        );
    }

    /// The sums of some truths, as their cells have them.
    #[inline(always)]
    pub(super) fn apply<T>(
        &self,
        truths: Range<usize>,
        tile: usize,
        tiles: usize,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        sums_of_cells(&self.truths.cell[truths], tile, tiles, scratch, sums);
    }

    /// The sums of some candidates, as their cells have them.
    #[inline(always)]
    pub(super) fn apply_transpose<T>(
        &self,
        candidates: Range<usize>,
        tile: usize,
        tiles: usize,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        sums_of_cells(
            &self.candidates.cell[candidates],
            tile,
            tiles,
            scratch,
            sums,
        );
    }
}

/// The sum of all rows, and of the rows in every cell.
fn add_up_by_cells<T: Real>(
    side: &Side,
    rows: &Rows<T>,
    scratch: &mut Scratch<T>,
    instructions: InstructionSet,
) {
    all_pairs::add_up(rows, &mut scratch.total, instructions);
    let tiles = rows.tiles;
    let cell_rows = &mut scratch.cell_rows;
    cell_rows.resize(side.cells() * tiles, Lanes::<T>::default());
    let chunks = cell_rows.par_chunks_mut(CHUNK * tiles).enumerate();
    chunks.for_each(|(chunk, out)| {
        let first = chunk * CHUNK;
        instructions.run(RowsOfCells {
            side,
            first,
            rows,
            out,
        });
    });
}

/// Fills the sums of all cells, `work` a chunk of them at a time: the number of its first cell, what to sum, and where to.
fn in_chunks_of_cells<T: Real>(
    cell_rows: &[Lanes<T>],
    cells: usize,
    tiles: usize,
    cell_sums: &mut Vec<Lanes<f64>>,
    work: impl Fn(usize, &Rows<T>, &mut [Lanes<f64>]) + Sync,
) {
    let rows = Rows {
        tiles,
        weighted: cell_rows,
        unweighted: None,
    };
    cell_sums.resize(cells * tiles, Lanes::<f64>::default());
    let chunks = cell_sums.par_chunks_mut(CHUNK * tiles).enumerate();
    chunks.for_each(|(chunk, out)| work(chunk * CHUNK, &rows, out));
}

#[inline(always)]
fn sums_of_cells<T>(
    cells: &[u32],
    tile: usize,
    tiles: usize,
    scratch: &Scratch<T>,
    sums: &mut PriorSums,
) {
    for (&cell, out) in cells.iter().zip(&mut sums.weighted) {
        *out = scratch.cell_sums[cell as usize * tiles + tile];
    }
    sums.unweighted[..cells.len()].fill(scratch.total[tile]);
}

impl Side {
    /// Sorts places into cells; the second value are the cells' middles.
    fn new(places: &[Pose], side_m: f64) -> (Self, Vec<[f64; 2]>) {
        let cell = |pose: &Pose| [pose.x_m, pose.y_m].map(|v| (v / side_m).floor() as i64);
        let mut members: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
        for (k, pose) in places.iter().enumerate() {
            members.entry(cell(pose)).or_default().push(k as u32);
        }
        let mut side = Self {
            cell: vec![0; places.len()],
            places: Vec::with_capacity(places.len()),
            start: vec![0],
        };
        let mut middles = Vec::with_capacity(members.len());
        for (number, (at, members)) in members.into_iter().enumerate() {
            middles.push(at.map(|v| (v as f64 + 0.5) * side_m));
            for &k in &members {
                side.cell[k as usize] = number as u32;
            }
            side.places.extend(members);
            side.start.push(side.places.len());
        }
        (side, middles)
    }

    fn cells(&self) -> usize {
        self.start.len() - 1
    }

    fn members(&self, cell: usize) -> &[u32] {
        &self.places[self.start[cell]..self.start[cell + 1]]
    }
}

/// The rows of some cells, `[cell, tile]`: each the sum of its places'.
struct RowsOfCells<'a, T> {
    side: &'a Side,
    first: usize,
    rows: &'a Rows<'a, T>,
    out: &'a mut [Lanes<T>],
}

impl<T: Real> Kernel for RowsOfCells<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let tiles = self.rows.tiles;
        for (node, out) in self.out.iter_mut().enumerate() {
            let (cell, tile) = (self.first + node / tiles, node % tiles);
            let mut sums = Lanes::<f64>::default();
            for &place in self.side.members(cell) {
                let row = &self.rows.weighted[place as usize * tiles + tile];
                for l in 0..LANES {
                    sums[l] += row[l].to_f64();
                }
            }
            for l in 0..LANES {
                out[l] = T::from_f64(sums[l]);
            }
        }
    }
}

/// Σ e·rows for some cells, `[cell, tile]`: of truths over candidates, or the transpose.
struct BetweenCells<'a, T, const TRANSPOSE: bool> {
    between: &'a AllPairs,
    first: usize,
    rows: &'a Rows<'a, T>,
    out: &'a mut [Lanes<f64>],
}

impl<T: Real, const TRANSPOSE: bool> Kernel for BetweenCells<'_, T, TRANSPOSE> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let tiles = self.rows.tiles;
        let cells = self.first..self.first + self.out.len() / tiles;
        let mut sums = [Lanes::default(); CHUNK];
        let sums = &mut sums[..cells.len()];
        for tile in 0..tiles {
            let cells = cells.clone();
            match TRANSPOSE {
                false => self.between.apply(cells, tile, self.rows, sums),
                true => self.between.apply_transpose(cells, tile, self.rows, sums),
            }
            for (out, sums) in self.out.chunks_mut(tiles).zip(&*sums) {
                out[tile] = *sums;
            }
        }
    }
}
