//! In the plane without any idea where, by cells (Thrun 1998, 4.4.2 item 2): linear in the number of places.

use super::{
    Answers, Asking, CHUNK, Rows, Scratch,
    all_pairs::{self, AllPairs},
};
use crate::{
    geometry::Pose,
    learning::lanes::{Kernel, LANES, Lanes, Real, Vectors},
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

    fn sides(&self, asking: Asking) -> (&Side, &Side) {
        match asking {
            Asking::Truths => (&self.truths, &self.candidates),
            Asking::Candidates => (&self.candidates, &self.truths),
        }
    }

    /// Adds the rows up cell by cell, and answers every cell that holds a place asking.
    pub(super) fn prepare<T: Real>(
        &self,
        asking: Asking,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        vectors: Vectors,
    ) {
        all_pairs::add_up(rows, &mut scratch.total, vectors);
        let (from, to) = self.sides(asking);
        let tiles = rows.tiles;
        scratch
            .cell_rows
            .resize(to.cells() * tiles, Lanes::<T>::default());
        let chunks = scratch.cell_rows.par_chunks_mut(CHUNK * tiles).enumerate();
        chunks.for_each(|(chunk, out)| {
            let first = chunk * CHUNK;
            vectors.run(AddUp {
                to,
                first,
                rows,
                out,
            });
        });
        let rows = Rows {
            tiles,
            weighted: &scratch.cell_rows,
            unweighted: None,
        };
        scratch
            .cell_sums
            .resize(from.cells() * tiles, Lanes::<f64>::default());
        let chunks = scratch.cell_sums.par_chunks_mut(CHUNK * tiles).enumerate();
        chunks.for_each(|(chunk, out)| {
            vectors.run(Between {
                cells: self,
                asking,
                first: chunk * CHUNK,
                rows: &rows,
                out,
            });
        });
    }

    #[inline(always)]
    pub(super) fn answer<T>(
        &self,
        asking: Asking,
        places: Range<usize>,
        tile: usize,
        tiles: usize,
        scratch: &Scratch<T>,
        answers: &mut Answers,
    ) {
        let cells = &self.sides(asking).0.cell[places];
        for (&cell, out) in cells.iter().zip(&mut answers.weighted) {
            *out = scratch.cell_sums[cell as usize * tiles + tile];
        }
        answers.unweighted[..cells.len()].fill(scratch.total[tile]);
    }
}

impl Side {
    /// Sorts places into cells; the second value are the cells' middles.
    fn new(places: &[Pose], side_m: f64) -> (Self, Vec<[f64; 2]>) {
        let of = |pose: &Pose| [pose.x_m, pose.y_m].map(|v| (v / side_m).floor() as i64);
        let mut members: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
        for (k, pose) in places.iter().enumerate() {
            members.entry(of(pose)).or_default().push(k as u32);
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
struct AddUp<'a, T> {
    to: &'a Side,
    first: usize,
    rows: &'a Rows<'a, T>,
    out: &'a mut [Lanes<T>],
}

impl<T: Real> Kernel for AddUp<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let tiles = self.rows.tiles;
        for (node, out) in self.out.iter_mut().enumerate() {
            let (cell, tile) = (self.first + node / tiles, node % tiles);
            let mut sums = Lanes::<f64>::default();
            for &place in self.to.members(cell) {
                let row = &self.rows.weighted[place as usize * tiles + tile];
                for l in 0..LANES {
                    sums[l] += row[l].wide();
                }
            }
            for l in 0..LANES {
                out[l] = T::of(sums[l]);
            }
        }
    }
}

/// Σ e·rows of some cells that ask, `[cell, tile]`.
struct Between<'a, T> {
    cells: &'a Cells,
    asking: Asking,
    first: usize,
    rows: &'a Rows<'a, T>,
    out: &'a mut [Lanes<f64>],
}

impl<T: Real> Kernel for Between<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let tiles = self.rows.tiles;
        let cells = self.first..self.first + self.out.len() / tiles;
        let mut sums = [Lanes::default(); CHUNK];
        let sums = &mut sums[..cells.len()];
        for tile in 0..tiles {
            self.cells
                .between
                .answer(self.asking, cells.clone(), tile, self.rows, sums);
            for (out, sums) in self.out.chunks_mut(tiles).zip(&*sums) {
                out[tile] = *sums;
            }
        }
    }
}
