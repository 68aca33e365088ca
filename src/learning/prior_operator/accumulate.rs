//! What is done with rows while they are still in the cache, before anybody asks about them.

use super::{
    CHUNK, Rows,
    block_sums::{self, BLOCK, BlockSums, Sums},
};
use crate::learning::lanes::{Real, Vectors};

/// What can be taken in of rows while they are made, a chunk of [`CHUNK`] places after the other: along a route, the sums
/// of their blocks.
pub(in crate::learning) struct TakeIn<'a, const Q: usize> {
    x_m: &'a [f64],
    /// Of this chunk; `None`: the prior wants all rows at once.
    sums: Option<&'a mut [Sums<Q>]>,
}

impl<const Q: usize> TakeIn<'_, Q> {
    /// Takes in a chunk of rows.
    #[inline(always)]
    pub(in crate::learning) fn chunk<T: Real>(&mut self, rows: &Rows<T>, vectors: Vectors) {
        if let Some(sums) = &mut self.sums {
            block_sums::fill(rows, self.x_m, sums, vectors);
        }
    }
}

/// One for every chunk of the rows of places at `x_m` along a route, or of a prior that has none.
pub(super) fn to_take_in<'a, const Q: usize>(
    x_m: Option<&'a [f64]>,
    chunks: usize,
    tiles: usize,
    blocks: &'a mut BlockSums<Q>,
) -> Vec<TakeIn<'a, Q>> {
    const { assert!(CHUNK.is_multiple_of(BLOCK)) };
    let Some(x_m) = x_m else {
        let nothing = || TakeIn {
            x_m: &[],
            sums: None,
        };
        return std::iter::repeat_with(nothing).take(chunks).collect();
    };
    let sums = blocks.open(x_m.len(), tiles);
    let of_chunks = x_m
        .chunks(CHUNK)
        .zip(sums.chunks_mut(CHUNK / BLOCK * tiles));
    let accumulate = |(x_m, sums)| TakeIn {
        x_m,
        sums: Some(sums),
    };
    of_chunks.map(accumulate).collect()
}
