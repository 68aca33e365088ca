//! The sums over a window of places along a route, for one place after the other.
//!
//! ```text
//! |· · · a b|c d e f|· · · ·| …  |· · · ·|u v · ·|      a..v = from a on in its block + whole blocks + up to v in its block
//! ```
//!
//! As places come in order, the three cuts of their windows (first, here, end) move ahead slowly: the sums up to and from
//! every place are made once for each block that a cut enters, and stay in the first-level cache. Cost: a few additions a
//! place and outcome, whatever the windows' width.

use super::{
    block_sums::{BLOCK, BlockSums, NOTHING, Sums, add_row, one_by_one, places_of},
    rows::Rows,
};
use crate::learning::lanes::{LANES, Lanes, Real};
use std::ops::Range;

/// Places along a route, in order.
pub(super) struct RoutePlaces {
    /// Coordinates, in metres from the middle of the route: smaller numbers cancel less.
    pub(super) x_m: Vec<f64>,
    /// The window of every place among the other side's places. All three cuts grow from place to place.
    pub(super) window: Vec<Window>,
}

/// A range of the other side's places in order, cut where the place itself would stand among them.
#[derive(Clone, Copy)]
pub(super) struct Window {
    pub(super) first: usize,
    pub(super) here: usize,
    pub(super) end: usize,
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

/// Cuts in no block yet.
pub(super) fn no_cuts<const Q: usize>() -> Cuts<Q> {
    std::array::from_fn(|_| Cut::new())
}

impl<const Q: usize> Cut<Q> {
    fn new() -> Self {
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

/// Σ |x_j − x|·a_j and Σ b_j over the windows of some places, for one tile: of the first places' windows among the second.
#[inline(always)]
pub(super) fn window_sums<T: Real, const Q: usize>(
    (with_windows, summed): (&RoutePlaces, &RoutePlaces),
    places: Range<usize>,
    tile: usize,
    rows: &Rows<T>,
    blocks: &BlockSums<Q>,
    cuts: &mut Cuts<Q>,
    (weighted, unweighted): (&mut [Lanes<f64>], &mut [Lanes<f64>]),
) {
    let x_m = &summed.x_m[..];
    for cut in &mut *cuts {
        cut.block = usize::MAX; // what it holds is of other rows
    }
    let [first, here, end] = cuts;
    let (mut whole_behind, mut whole_ahead) = ([NOTHING; Q], [NOTHING; Q]);
    for (place, (weighted, unweighted)) in places.zip(weighted.iter_mut().zip(unweighted)) {
        let (x, window) = (with_windows.x_m[place], with_windows.window[place]);
        let first_moved = first.move_to::<T, false, true>(window.first, rows, tile, x_m);
        let here_moved = here.move_to::<T, true, true>(window.here, rows, tile, x_m);
        let end_moved = end.move_to::<T, true, false>(window.end, rows, tile, x_m);
        if first_moved || here_moved {
            whole_behind = blocks.whole_blocks(first.block + 1..here.block, tile, rows.tiles);
        }
        if here_moved || end_moved {
            whole_ahead = blocks.whole_blocks(here.block + 1..end.block, tile, rows.tiles);
        }
        let (few_behind, few_ahead);
        let behind: [&Sums<Q>; 3] = if first.block == here.block {
            few_behind = one_by_one(window.first..window.here, rows, tile, x_m);
            [&few_behind, &[NOTHING; Q], &[NOTHING; Q]]
        } else {
            let (from, up_to) = (window.first % BLOCK, window.here % BLOCK);
            [&first.from[from], &whole_behind, &here.up_to[up_to]]
        };
        let ahead: [&Sums<Q>; 3] = if here.block == end.block {
            few_ahead = one_by_one(window.here..window.end, rows, tile, x_m);
            [&few_ahead, &[NOTHING; Q], &[NOTHING; Q]]
        } else {
            let (from, up_to) = (window.here % BLOCK, window.end % BLOCK);
            [&here.from[from], &whole_ahead, &end.up_to[up_to]]
        };
        let unweighted_sum = if Q == 2 { 0 } else { 2 };
        for l in 0..LANES {
            let behind = |q: usize| behind[0][q][l] + behind[1][q][l] + behind[2][q][l];
            let ahead = |q: usize| ahead[0][q][l] + ahead[1][q][l] + ahead[2][q][l];
            weighted[l] = x * (behind(0) - ahead(0)) - (behind(1) - ahead(1));
            unweighted[l] = behind(unweighted_sum) + ahead(unweighted_sum);
        }
    }
}
