//! A global prior in the plane: all distances, by blocks.

use super::rows::Rows;
use crate::{
    geometry::Pose,
    learning::lanes::{LANES, Lanes, Real},
    simd::{InstructionSet, Kernel},
};
use rayon::prelude::*;
use std::ops::Range;

/// Every candidate for every truth. Up to some thousands of places the distances are kept; beyond, they are made block
/// by block, used and dropped, so that memory grows no faster than the number of places.
pub struct AllPairs {
    truths: Vec<[f64; 2]>,
    candidates: Vec<[f64; 2]>,
    /// `[truth, candidate]`, in metres.
    kept: Option<Vec<f64>>,
    /// Truths and candidates are the same places, so that rows are as good as columns.
    symmetric: bool,
}

/// Places summed over whose distances are made at once.
const BLOCK: usize = 32;

/// Places that are given their sums at once.
const ROWS: usize = 4;

/// Most distances that are kept: 200 MB.
const MAX_KEPT: usize = 25_000_000;

impl AllPairs {
    pub(super) fn new(truths: &[Pose], candidates: &[Pose]) -> Self {
        let at = |poses: &[Pose]| poses.iter().map(|p| [p.x_m, p.y_m]).collect();
        Self::between(at(truths), at(candidates))
    }

    pub(super) fn between(truths: Vec<[f64; 2]>, candidates: Vec<[f64; 2]>) -> Self {
        let pairs = truths.len() * candidates.len();
        let kept = (0 < pairs && pairs <= MAX_KEPT).then(|| {
            let mut all = vec![0.0; pairs];
            let rows = all.par_chunks_mut(candidates.len()).zip(&truths);
            rows.for_each(|(row, truth)| {
                for (out, candidate) in row.iter_mut().zip(&candidates) {
                    *out = distance_m(truth, candidate);
                }
            });
            all
        });
        Self {
            symmetric: truths == candidates,
            truths,
            candidates,
            kept,
        }
    }

    /// Numbers of truths and candidates.
    pub(super) fn counts(&self) -> (usize, usize) {
        (self.truths.len(), self.candidates.len())
    }

    /// Σ e·rows over all candidates, for some truths, one tile.
    #[inline(always)]
    pub(super) fn apply<T: Real>(
        &self,
        truths: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        weighted: &mut [Lanes<f64>],
    ) {
        let sides = (&self.truths[..], &self.candidates[..]);
        self.weighted_sums(sides, true, truths, tile, rows, weighted);
    }

    /// Σ e·rows over all truths, for some candidates, one tile.
    #[inline(always)]
    pub(super) fn apply_transpose<T: Real>(
        &self,
        candidates: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        weighted: &mut [Lanes<f64>],
    ) {
        let sides = (&self.candidates[..], &self.truths[..]);
        self.weighted_sums(sides, self.symmetric, candidates, tile, rows, weighted);
    }

    /// Sums for places of the first side over all of the second. `by_rows`: a place's distances are a row of those kept,
    /// and not a column.
    #[inline(always)]
    fn weighted_sums<T: Real>(
        &self,
        (from, to): (&[[f64; 2]], &[[f64; 2]]),
        by_rows: bool,
        places: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        weighted: &mut [Lanes<f64>],
    ) {
        let kept = self.kept.as_deref();
        for (first, out) in places.step_by(ROWS).zip(weighted.chunks_mut(ROWS)) {
            out.fill(Lanes::<f64>::default());
            for start in (0..to.len()).step_by(BLOCK) {
                let end = (start + BLOCK).min(to.len());
                let mut e = [[0.0; BLOCK]; ROWS];
                for (row, e) in e[..out.len()].iter_mut().enumerate() {
                    let e = &mut e[..end - start];
                    match kept {
                        Some(all) if by_rows => {
                            let row = (first + row) * to.len();
                            e.copy_from_slice(&all[row + start..row + end]);
                        }
                        Some(all) => {
                            for (place, e) in (start..end).zip(e) {
                                *e = all[place * from.len() + first + row];
                            }
                        }
                        None => {
                            for (to, e) in to[start..end].iter().zip(e) {
                                *e = distance_m(&from[first + row], to);
                            }
                        }
                    }
                }
                let sums = sums(&e, start..end, tile, rows);
                for (out, sums) in out.iter_mut().zip(&sums) {
                    for l in 0..LANES {
                        out[l] += sums[l];
                    }
                }
            }
        }
    }
}

/// Σ e·rows over some places, for each of the four whose distances are given.
#[inline(always)]
fn sums<T: Real>(
    e: &[[f64; BLOCK]; ROWS],
    places: Range<usize>,
    tile: usize,
    rows: &Rows<T>,
) -> [Lanes<f64>; ROWS] {
    let nothing = Lanes::<f64>::default();
    let (mut s0, mut s1, mut s2, mut s3) = (nothing, nothing, nothing, nothing);
    let [e0, e1, e2, e3] = e;
    let summed =
        rows.weighted[places.start * rows.tiles..places.end * rows.tiles].chunks_exact(rows.tiles);
    for ((((row, &e0), &e1), &e2), &e3) in summed.zip(e0).zip(e1).zip(e2).zip(e3) {
        let row = row[tile];
        for l in 0..LANES {
            s0[l] += e0 * row[l].to_f64();
        }
        for l in 0..LANES {
            s1[l] += e1 * row[l].to_f64();
        }
        for l in 0..LANES {
            s2[l] += e2 * row[l].to_f64();
        }
        for l in 0..LANES {
            s3[l] += e3 * row[l].to_f64();
        }
    }
    [s0, s1, s2, s3]
}

/// The sum of all unweighted rows, for every tile.
pub(super) fn add_up<T: Real>(
    rows: &Rows<T>,
    total: &mut Vec<Lanes<f64>>,
    instructions: InstructionSet,
) {
    total.clear();
    total.resize(rows.tiles, Lanes::<f64>::default());
    match rows.unweighted {
        Some(unweighted) => instructions.run(AddUp { unweighted, total }),
        None => instructions.run(AddUp {
            unweighted: rows.weighted,
            total,
        }),
    }
}

struct AddUp<'a, T> {
    unweighted: &'a [Lanes<T>],
    total: &'a mut [Lanes<f64>],
}

impl<T: Real> Kernel for AddUp<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for row in self.unweighted.chunks_exact(self.total.len()) {
            for (total, row) in self.total.iter_mut().zip(row) {
                for l in 0..LANES {
                    total[l] += row[l].to_f64();
                }
            }
        }
    }
}

#[inline(always)]
fn distance_m(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    let (x, y) = (a[0] - b[0], a[1] - b[1]);
    (x * x + y * y).sqrt()
}
