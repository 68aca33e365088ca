//! Sums over any range of places in order, by blocks, so that nothing is ever subtracted.
//!
//! The usual running sums give a range as the difference of two prefixes, and lose the digits of whatever is rare in the
//! range and common before it. Here a range is put together instead, as in a sum tree:
//!
//! ```text
//! |· · · a b|c d e f|· · · ·| …  |· · · ·|u v · ·|      a..v = from a on in its block + whole blocks + up to v in its block
//! ```
//!
//! Whole blocks are summed up in blocks of blocks, and so on. As places ask in order, the three cuts of their windows
//! (first, here, end) move ahead slowly: the sums up to and from every place are made once for each block that a cut
//! enters, and stay in the first-level cache. Cost: a few additions a place and outcome, whatever the windows' width.

use super::{Rows, route_windows::Side};
use crate::learning::lanes::{Kernel, LANES, Lanes, Real, Vectors};
use std::ops::Range;

/// Places in a block, and blocks in a block of blocks.
pub(super) const BLOCK: usize = 16;

/// Of some places: Σ a, Σ x·a and, where other rows are summed plainly, Σ b.
pub(super) type Sums<const Q: usize> = [Lanes<f64>; Q];

const NOTHING: Lanes<f64> = Lanes::all(0.0);

/// The sums of all blocks, of all blocks of blocks, …, `[level][block, tile]`.
#[derive(Debug, Default)]
pub(super) struct BlockSums<const Q: usize> {
    levels: Vec<Vec<Sums<Q>>>,
}

impl<const Q: usize> BlockSums<Q> {
    /// Makes room for the sums of all blocks of so many places, `[block, tile]`, to be filled by [`fill`].
    pub(super) fn open(&mut self, places: usize, tiles: usize) -> &mut [Sums<Q>] {
        let sums = self.level(0);
        sums.resize(places.div_ceil(BLOCK) * tiles, [NOTHING; Q]);
        sums
    }

    /// Sums up what has been filled in, by blocks of blocks.
    pub(super) fn close(&mut self, tiles: usize) {
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
    fn of(&self, blocks: Range<usize>, tile: usize, tiles: usize) -> Sums<Q> {
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
pub(super) fn fill<T: Real, const Q: usize>(
    rows: &Rows<T>,
    x_m: &[f64],
    sums: &mut [Sums<Q>],
    vectors: Vectors,
) {
    vectors.run(SumUp { rows, x_m, sums });
}

/// The sums of some blocks, `[block, tile]`.
struct SumUp<'a, T, const Q: usize> {
    rows: &'a Rows<'a, T>,
    x_m: &'a [f64],
    sums: &'a mut [Sums<Q>],
}

impl<T: Real, const Q: usize> Kernel for SumUp<'_, T, Q> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let tiles = self.rows.tiles;
        for (node, sums) in self.sums.iter_mut().enumerate() {
            let (block, tile) = (node / tiles, node % tiles);
            *sums = directly(places_of(block, self.x_m.len()), self.rows, tile, self.x_m);
        }
    }
}

/// The three cuts of the windows: first, here, end. Kept, since filling them with nothing takes time.
pub(super) type Cuts<const Q: usize> = [Cut<Q>; 3];

/// One of the cuts of a window, and the sums of the block it is in, up to every place and from every place.
#[derive(Debug)]
pub(super) struct Cut<const Q: usize> {
    block: usize,
    up_to: [Sums<Q>; BLOCK],
    from: [Sums<Q>; BLOCK],
}

impl<const Q: usize> Cut<Q> {
    pub(super) fn new() -> Self {
        Self {
            block: usize::MAX,
            up_to: [[NOTHING; Q]; BLOCK],
            from: [[NOTHING; Q]; BLOCK],
        }
    }

    /// Moves to a place; true where it entered another block.
    #[inline(always)]
    fn move_to<T: Real, const UP_TO: bool, const FROM: bool>(
        &mut self,
        place: usize,
        rows: &Rows<T>,
        tile: usize,
        x_m: &[f64],
    ) -> bool {
        let block = place / BLOCK;
        if block == self.block {
            return false;
        }
        self.block = block;
        let places = places_of(block, x_m.len());
        if UP_TO {
            let mut sums = [NOTHING; Q];
            for (slot, place) in self.up_to.iter_mut().zip(places.clone()) {
                *slot = sums;
                add_row(&mut sums, rows, place, tile, x_m[place]);
            }
            // A cut behind the last place of all.
            if let Some(slot) = self.up_to.get_mut(places.len()) {
                *slot = sums;
            }
        }
        if FROM {
            let mut sums = [NOTHING; Q];
            self.from[places.len().min(BLOCK - 1)] = sums;
            for (slot, place) in self.from[..places.len()].iter_mut().zip(places).rev() {
                add_row(&mut sums, rows, place, tile, x_m[place]);
                *slot = sums;
            }
        }
        true
    }
}

/// Σ |x_j − x|·a_j and Σ b_j over the windows of some places, for one tile.
#[inline(always)]
pub(super) fn answer<T: Real, const Q: usize>(
    (asking, asked): (&Side, &Side),
    places: Range<usize>,
    tile: usize,
    rows: &Rows<T>,
    blocks: &BlockSums<Q>,
    cuts: &mut Cuts<Q>,
    (weighted, unweighted): (&mut [Lanes<f64>], &mut [Lanes<f64>]),
) {
    let x_m = &asked.x_m[..];
    for cut in &mut *cuts {
        cut.block = usize::MAX; // what it holds is of other rows
    }
    let [first, here, end] = cuts;
    let (mut whole_behind, mut whole_ahead) = ([NOTHING; Q], [NOTHING; Q]);
    for (place, (weighted, unweighted)) in places.zip(weighted.iter_mut().zip(unweighted)) {
        let (x, window) = (asking.x_m[place], asking.window[place]);
        let first_moved = first.move_to::<T, false, true>(window.first, rows, tile, x_m);
        let here_moved = here.move_to::<T, true, true>(window.here, rows, tile, x_m);
        let end_moved = end.move_to::<T, true, false>(window.end, rows, tile, x_m);
        if first_moved || here_moved {
            whole_behind = blocks.of(first.block + 1..here.block, tile, rows.tiles);
        }
        if here_moved || end_moved {
            whole_ahead = blocks.of(here.block + 1..end.block, tile, rows.tiles);
        }
        let (few_behind, few_ahead);
        let behind: [&Sums<Q>; 3] = if first.block == here.block {
            few_behind = directly(window.first..window.here, rows, tile, x_m);
            [&few_behind, &[NOTHING; Q], &[NOTHING; Q]]
        } else {
            let (from, up_to) = (window.first % BLOCK, window.here % BLOCK);
            [&first.from[from], &whole_behind, &here.up_to[up_to]]
        };
        let ahead: [&Sums<Q>; 3] = if here.block == end.block {
            few_ahead = directly(window.here..window.end, rows, tile, x_m);
            [&few_ahead, &[NOTHING; Q], &[NOTHING; Q]]
        } else {
            let (from, up_to) = (window.here % BLOCK, window.end % BLOCK);
            [&here.from[from], &whole_ahead, &end.up_to[up_to]]
        };
        let plainly = if Q == 2 { 0 } else { 2 };
        for l in 0..LANES {
            let behind = |q: usize| behind[0][q][l] + behind[1][q][l] + behind[2][q][l];
            let ahead = |q: usize| ahead[0][q][l] + ahead[1][q][l] + ahead[2][q][l];
            weighted[l] = x * (behind(0) - ahead(0)) - (behind(1) - ahead(1));
            unweighted[l] = behind(plainly) + ahead(plainly);
        }
    }
}

/// The sums of a few places one by one.
#[inline(always)]
fn directly<T: Real, const Q: usize>(
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
fn add_row<T: Real, const Q: usize>(
    sums: &mut Sums<Q>,
    rows: &Rows<T>,
    place: usize,
    tile: usize,
    x: f64,
) {
    let row = place * rows.tiles + tile;
    let a = &rows.weighted[row];
    for l in 0..LANES {
        let a = a[l].wide();
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

fn places_of(block: usize, places: usize) -> Range<usize> {
    (block * BLOCK).min(places)..((block + 1) * BLOCK).min(places)
}
