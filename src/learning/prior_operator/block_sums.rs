//! Sums over any range of places in order, by blocks, so that nothing is ever subtracted.
//!
//! The usual running sums give a range as the difference of two prefixes, and lose the digits of whatever is rare in the
//! range and common before it. Here the sums of whole blocks of places are kept, those of whole blocks of blocks, and so
//! on, and a range is put together from them, as in a sum tree.

use super::rows::Rows;
use crate::{
    learning::lanes::{LANES, Lanes, Real},
    simd::{InstructionSet, Kernel},
};
use std::ops::Range;

/// Places in a block, and blocks in a block of blocks.
pub(super) const BLOCK: usize = 16;

/// Of some places: Σ a, Σ x·a and, where other rows are summed without a weight, Σ b.
pub(super) type Sums<const Q: usize> = [Lanes<f64>; Q];

pub(super) const NOTHING: Lanes<f64> = Lanes::all(0.0);

/// The sums of all blocks, of all blocks of blocks, …, `[level][block, tile]`.
#[derive(Debug, Default)]
pub(super) struct BlockSums<const Q: usize> {
    levels: Vec<Vec<Sums<Q>>>,
}

impl<const Q: usize> BlockSums<Q> {
    /// Room for the sums of all blocks of so many places, `[block, tile]`, to be filled by [`sum_blocks`].
    pub(super) fn start(&mut self, places: usize, tiles: usize) -> &mut [Sums<Q>] {
        let sums = self.level(0);
        sums.resize(places.div_ceil(BLOCK) * tiles, [NOTHING; Q]);
        sums
    }

    /// Sums up what has been filled in, by blocks of blocks.
    pub(super) fn finish(&mut self, tiles: usize) {
        let mut blocks = self.level(0).len() / tiles;
        let mut level = 0;
        while blocks > BLOCK {
            let above = blocks.div_ceil(BLOCK);
            self.level(level + 1).clear();
            self.level(level + 1).resize(above * tiles, [NOTHING; Q]);
            let (below, this) = self.levels.split_at_mut(level + 1);
            for (node, sums) in below[level].iter().enumerate() {
                add(
                    &mut this[0][node / tiles / BLOCK * tiles + node % tiles],
                    sums,
                );
            }
            (level, blocks) = (level + 1, above);
        }
        self.levels.truncate(level + 1);
    }

    fn level(&mut self, level: usize) -> &mut Vec<Sums<Q>> {
        if self.levels.len() <= level {
            self.levels.resize_with(level + 1, Vec::new);
        }
        &mut self.levels[level]
    }

    /// The sums of some whole blocks.
    #[inline(always)]
    pub(super) fn whole_blocks(&self, blocks: Range<usize>, tile: usize, tiles: usize) -> Sums<Q> {
        let mut sums = [NOTHING; Q];
        let Range { mut start, mut end } = blocks;
        for (level, nodes) in self.levels.iter().enumerate() {
            let top = level + 1 == self.levels.len();
            while start < end && (top || !start.is_multiple_of(BLOCK)) {
                add(&mut sums, &nodes[start * tiles + tile]);
                start += 1;
            }
            while start < end && !end.is_multiple_of(BLOCK) {
                end -= 1;
                add(&mut sums, &nodes[end * tiles + tile]);
            }
            if start >= end {
                break;
            }
            (start, end) = (start / BLOCK, end / BLOCK);
        }
        sums
    }
}

/// The sums of the blocks of some rows of places at `x_m`, whole blocks but for the last one, into `sums`.
pub(super) fn sum_blocks<T: Real, const Q: usize>(
    rows: &Rows<T>,
    x_m: &[f64],
    sums: &mut [Sums<Q>],
    instructions: InstructionSet,
) {
    instructions.run(BlocksOfRows { rows, x_m, sums });
}

/// The sums of some blocks, `[block, tile]`.
struct BlocksOfRows<'a, T, const Q: usize> {
    rows: &'a Rows<'a, T>,
    x_m: &'a [f64],
    sums: &'a mut [Sums<Q>],
}

impl<T: Real, const Q: usize> Kernel for BlocksOfRows<'_, T, Q> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let tiles = self.rows.tiles;
        for (node, sums) in self.sums.iter_mut().enumerate() {
            let (block, tile) = (node / tiles, node % tiles);
            *sums = one_by_one(places_of(block, self.x_m.len()), self.rows, tile, self.x_m);
        }
    }
}

/// The sums of a few places one by one.
#[inline(always)]
pub(super) fn one_by_one<T: Real, const Q: usize>(
    places: Range<usize>,
    rows: &Rows<T>,
    tile: usize,
    x_m: &[f64],
) -> Sums<Q> {
    let mut sums = [NOTHING; Q];
    for place in places {
        add_row(&mut sums, rows, place, tile, x_m[place]);
    }
    sums
}

#[inline(always)]
fn add<const Q: usize>(sums: &mut Sums<Q>, other: &Sums<Q>) {
    for (sums, other) in sums.iter_mut().zip(other) {
        for l in 0..LANES {
            sums[l] += other[l];
        }
    }
}

#[inline(always)]
pub(super) fn add_row<T: Real, const Q: usize>(
    sums: &mut Sums<Q>,
    rows: &Rows<T>,
    place: usize,
    tile: usize,
    x: f64,
) {
    let row = place * rows.tiles + tile;
    let a = &rows.weighted[row];
    for l in 0..LANES {
        let a = a[l].to_f64();
        sums[0][l] += a;
        sums[1][l] += x * a;
    }
    if let (3, Some(unweighted)) = (Q, rows.unweighted) {
        let b = &unweighted[row];
        for l in 0..LANES {
            sums[2][l] += b[l];
        }
    }
}

pub(super) fn places_of(block: usize, places: usize) -> Range<usize> {
    (block * BLOCK).min(places)..((block + 1) * BLOCK).min(places)
}
