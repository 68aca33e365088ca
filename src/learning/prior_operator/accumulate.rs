//! What is done with rows while they are still in the cache, before the sums of any place are made.

use super::{
    block_sums::{BLOCK, BlockSums, Sums, sum_blocks},
    rows::{CHUNK, Rows},
};
use crate::{learning::lanes::Real, simd::InstructionSet};

/// Accumulates the rows of one chunk of [`CHUNK`] places as soon as they are made: along a route, into sums of blocks.
pub(in crate::learning) struct Accumulator<'a, const Q: usize> {
    x_m: &'a [f64],
    /// This chunk's; `None`: the prior needs all rows at once.
    sums: Option<&'a mut [Sums<Q>]>,
}

impl<const Q: usize> Accumulator<'_, Q> {
    /// Adds the chunk's rows.
    #[inline(always)]
    pub(in crate::learning) fn add<T: Real>(
        &mut self,
        rows: &Rows<T>,
        instructions: InstructionSet,
    ) {
        if let Some(sums) = &mut self.sums {
            sum_blocks(rows, self.x_m, sums, instructions);
        }
    }
}

/// One for every chunk of rows of places at `x_m` along a route, or of a prior whose places have no such coordinate.
pub(super) fn accumulators<'a, const Q: usize>(
    x_m: Option<&'a [f64]>,
    chunks: usize,
    tiles: usize,
    blocks: &'a mut BlockSums<Q>,
) -> Vec<Accumulator<'a, Q>> {
    const { assert!(CHUNK.is_multiple_of(BLOCK)) };
    let Some(x_m) = x_m else {
        let nothing = || Accumulator {
            x_m: &[],
            sums: None,
        };
        return std::iter::repeat_with(nothing).take(chunks).collect();
    };
    let sums = blocks.start(x_m.len(), tiles);
    x_m.chunks(CHUNK)
        .zip(sums.chunks_mut(CHUNK / BLOCK * tiles))
        .map(|(x_m, sums)| Accumulator {
            x_m,
            sums: Some(sums),
        })
        .collect()
}
