//! The sums by whatever way the prior and the places allow.

use super::{
    accumulate::{Accumulator, accumulators},
    all_pairs::{self, AllPairs},
    cells::Cells,
    route_windows::RouteWindows,
    rows::{CHUNK, Rows},
    sparse_rows::SparseRows,
    workspace::{PriorSums, Scratch},
};
use crate::{learning::lanes::Real, simd::InstructionSet};
use std::ops::Range;

/// Which pairs of a truth and a candidate the prior admits, with their errors.
pub(super) enum Shape {
    /// Along a route.
    Route(RouteWindows),
    /// In the plane, within a window, or with an error of one's own.
    Sparse(SparseRows),
    /// In the plane, anywhere.
    AllPairs(AllPairs),
    /// In the plane, anywhere, by cells.
    Cells(Cells),
}

impl Shape {
    /// Numbers of truths and candidates.
    pub(super) fn counts(&self) -> (usize, usize) {
        match self {
            Shape::Route(s) => s.counts(),
            Shape::Sparse(s) => s.counts(),
            Shape::AllPairs(s) => s.counts(),
            Shape::Cells(s) => s.counts(),
        }
    }

    /// Candidates that the prior of every truth admits.
    pub(super) fn window_sizes(&self) -> Vec<usize> {
        match self {
            Shape::Route(s) => s.window_sizes(),
            Shape::Sparse(s) => s.window_sizes(),
            Shape::AllPairs(_) | Shape::Cells(_) => {
                let (truths, candidates) = self.counts();
                vec![candidates; truths]
            }
        }
    }

    /// The order in which rows of the truths must come; `None`: as they are.
    pub(super) fn truth_order(&self) -> Option<&[usize]> {
        match self {
            Shape::Route(s) => s.truth_order(),
            _ => None,
        }
    }

    /// The order in which rows of the candidates must come; `None`: as they are.
    pub(super) fn candidate_order(&self) -> Option<&[usize]> {
        match self {
            Shape::Route(s) => s.candidate_order(),
            _ => None,
        }
    }

    /// One for every chunk of the candidates' rows.
    pub(super) fn map_accumulators<'a, T>(
        &'a self,
        tiles: usize,
        scratch: &'a mut Scratch<T>,
    ) -> Vec<Accumulator<'a, 2>> {
        let x_m = match self {
            Shape::Route(s) => Some(s.candidate_x_m()),
            _ => None,
        };
        let chunks = self.counts().1.div_ceil(CHUNK);
        accumulators(x_m, chunks, tiles, &mut scratch.map_blocks)
    }

    /// One for every chunk of the truths' rows.
    pub(super) fn truth_accumulators<'a, T>(
        &'a self,
        tiles: usize,
        scratch: &'a mut Scratch<T>,
    ) -> Vec<Accumulator<'a, 3>> {
        let x_m = match self {
            Shape::Route(s) => Some(s.truth_x_m()),
            _ => None,
        };
        let chunks = self.counts().0.div_ceil(CHUNK);
        accumulators(x_m, chunks, tiles, &mut scratch.truth_blocks)
    }

    /// Makes ready for [`apply`](Self::apply), once all chunks of the candidates' rows are accumulated.
    pub(super) fn prepare<T: Real>(
        &self,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        instructions: InstructionSet,
    ) {
        match self {
            Shape::Route(_) => scratch.map_blocks.finish(rows.tiles),
            Shape::Sparse(_) => {}
            Shape::AllPairs(_) => all_pairs::add_up(rows, &mut scratch.total, instructions),
            Shape::Cells(s) => s.prepare(rows, scratch, instructions),
        }
    }

    /// Makes ready for [`apply_transpose`](Self::apply_transpose), once all chunks of the truths' rows are accumulated.
    pub(super) fn prepare_transpose<T: Real>(
        &self,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        instructions: InstructionSet,
    ) {
        match self {
            Shape::Route(_) => scratch.truth_blocks.finish(rows.tiles),
            Shape::Sparse(_) => {}
            Shape::AllPairs(_) => all_pairs::add_up(rows, &mut scratch.total, instructions),
            Shape::Cells(s) => s.prepare_transpose(rows, scratch, instructions),
        }
    }

    /// Sums over the candidates that the priors of some truths admit.
    #[inline(always)]
    pub(super) fn apply<T: Real>(
        &self,
        truths: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        match self {
            Shape::Route(s) => s.apply(truths, tile, rows, scratch, sums),
            Shape::Sparse(s) => s.apply(truths, tile, rows, sums),
            Shape::AllPairs(s) => {
                let count = truths.len();
                s.apply(truths, tile, rows, &mut sums.weighted[..count]);
                sums.unweighted[..count].fill(scratch.total[tile]);
            }
            Shape::Cells(s) => s.apply(truths, tile, rows.tiles, scratch, sums),
        }
    }

    /// Sums over the truths whose priors admit some candidates.
    #[inline(always)]
    pub(super) fn apply_transpose<T: Real>(
        &self,
        candidates: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        match self {
            Shape::Route(s) => s.apply_transpose(candidates, tile, rows, scratch, sums),
            Shape::Sparse(s) => s.apply_transpose(candidates, tile, rows, sums),
            Shape::AllPairs(s) => {
                let count = candidates.len();
                s.apply_transpose(candidates, tile, rows, &mut sums.weighted[..count]);
                sums.unweighted[..count].fill(scratch.total[tile]);
            }
            Shape::Cells(s) => s.apply_transpose(candidates, tile, rows.tiles, scratch, sums),
        }
    }
}
