//! Memory that the sums need, kept from one evaluation to the next.

use super::{
    block_sums::BlockSums,
    rows::CHUNK,
    window_sums::{Cuts, no_cuts},
};
use crate::learning::lanes::Lanes;

/// What is computed from all rows once, before the sums of any place. An operator has one for the map's rows and one for
/// the truths'.
#[derive(Debug, Default)]
pub(in crate::learning) struct Scratch<T> {
    /// Along a route: the block sums of the map's rows, or of the truths'.
    pub(super) map_blocks: BlockSums<2>,
    pub(super) truth_blocks: BlockSums<3>,
    /// The sum of all unweighted rows, `[tile]`.
    pub(super) total: Vec<Lanes<f64>>,
    /// By cells: the sum of the rows in every cell, and their sums weighted by e, `[cell, tile]`.
    pub(super) cell_rows: Vec<Lanes<T>>,
    pub(super) cell_sums: Vec<Lanes<f64>>,
}

/// Σ e·rows and Σ rows over what the prior admits, for each of [`CHUNK`] places, of one tile.
#[derive(Debug)]
pub(in crate::learning) struct PriorSums {
    pub weighted: [Lanes<f64>; CHUNK],
    pub unweighted: [Lanes<f64>; CHUNK],
    pub(super) map_cuts: Cuts<2>,
    pub(super) truth_cuts: Cuts<3>,
}

impl PriorSums {
    #[inline(always)]
    pub(in crate::learning) fn new() -> Self {
        Self {
            weighted: [Lanes::default(); CHUNK],
            unweighted: [Lanes::default(); CHUNK],
            map_cuts: no_cuts(),
            truth_cuts: no_cuts(),
        }
    }
}
