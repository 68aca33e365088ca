//! In the plane without any idea where: all distances, by blocks.

use super::{Asking, Rows};
use crate::{
    geometry::Pose,
    learning::lanes::{LANES, Lanes, Real, Vectors},
};
use rayon::prelude::*;
use std::ops::Range;

/// Every candidate for every truth. Up to some thousands of places the distances are kept; beyond, they are made block
/// by block, used and dropped, so that memory grows no faster than the number of places.
pub struct Everywhere {
    truths: Vec<[f64; 2]>,
    candidates: Vec<[f64; 2]>,
    /// `[truth, candidate]`, in metres; enough for whoever calculates in `f32`.
    kept: Option<Vec<f32>>,
}

/// Places asked about whose distances are made at once, and that are summed in the rows' own precision.
const BLOCK: usize = 32;

/// Places asking at once.
const ROWS: usize = 4;

/// Most distances that are kept: 100 MB.
const MOST_KEPT: usize = 25_000_000;

impl Everywhere {
    pub(super) fn new(truths: &[Pose], candidates: &[Pose]) -> Self {
        let at = |poses: &[Pose]| poses.iter().map(|p| [p.x_m, p.y_m]).collect();
        Self::between(at(truths), at(candidates))
    }

    pub(super) fn between(truths: Vec<[f64; 2]>, candidates: Vec<[f64; 2]>) -> Self {
        let pairs = truths.len() * candidates.len();
        let kept = (0 < pairs && pairs <= MOST_KEPT).then(|| {
            let mut all = vec![0.0; pairs];
            let rows = all.par_chunks_mut(candidates.len()).zip(&truths);
            rows.for_each(|(row, truth)| {
                for (out, candidate) in row.iter_mut().zip(&candidates) {
                    *out = distance_m::<f64>(truth, candidate) as f32;
                }
            });
            all
        });
        Self {
            truths,
            candidates,
            kept,
        }
    }

    /// Numbers of truths and candidates.
    pub(super) fn counts(&self) -> (usize, usize) {
        (self.truths.len(), self.candidates.len())
    }

    /// Σ e·rows for some places, one tile.
    #[inline(always)]
    pub(super) fn answer<T: Real>(
        &self,
        asking: Asking,
        places: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        by_error: &mut [Lanes<f64>],
    ) {
        let kept = self.kept.as_deref().and_then(T::kept);
        let (from, to) = match asking {
            Asking::Truths => (&self.truths, &self.candidates),
            Asking::Candidates => (&self.candidates, &self.truths),
        };
        // How far apart the distances of neighbours stand, from one place asking to the next, and asked about.
        let (step_from, step_to) = match asking {
            Asking::Truths => (self.candidates.len(), 1),
            Asking::Candidates => (1, self.candidates.len()),
        };
        for (first, out) in places.step_by(ROWS).zip(by_error.chunks_mut(ROWS)) {
            out.fill([0.0; LANES]);
            for start in (0..to.len()).step_by(BLOCK) {
                let end = (start + BLOCK).min(to.len());
                let mut e = [[T::default(); BLOCK]; ROWS];
                for (row, e) in e[..out.len()].iter_mut().enumerate() {
                    for (place, e) in (start..end).zip(e) {
                        *e = match kept {
                            Some(all) => all[(first + row) * step_from + place * step_to],
                            None => distance_m(&from[first + row], &to[place]),
                        };
                    }
                }
                let mut sums = [[T::default(); LANES]; ROWS];
                for place in start..end {
                    let a = &rows.by_error[place * rows.tiles + tile];
                    for (sums, e) in sums.iter_mut().zip(&e) {
                        let e = e[place - start];
                        for l in 0..LANES {
                            sums[l] += e * a[l];
                        }
                    }
                }
                for (out, sums) in out.iter_mut().zip(&sums) {
                    for l in 0..LANES {
                        out[l] += sums[l].wide();
                    }
                }
            }
        }
    }
}

/// The sum of all rows to be summed plainly, for every tile.
pub(super) fn add_up<T: Real>(rows: &Rows<T>, total: &mut Vec<Lanes<f64>>, vectors: Vectors) {
    total.clear();
    total.resize(rows.tiles, [0.0; LANES]);
    let plain = rows.plain.unwrap_or(rows.by_error);
    vectors.run(|| {
        for row in plain.chunks_exact(rows.tiles) {
            for (total, row) in total.iter_mut().zip(row) {
                for l in 0..LANES {
                    total[l] += row[l].wide();
                }
            }
        }
    });
}

/// The difference in `f64`, as it cancels; the rest in the precision asked for.
#[inline(always)]
fn distance_m<T: Real>(a: &[f64; 2], b: &[f64; 2]) -> T {
    let (x, y) = (T::of(a[0] - b[0]), T::of(a[1] - b[1]));
    (x * x + y * y).root()
}
