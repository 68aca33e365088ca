//! In the plane a window admits a few candidates a truth: rows that hold only those.

use super::{rows::Rows, workspace::PriorSums};
use crate::{
    belief::{Places, Uncertainty},
    learning::lanes::{LANES, Lanes, Real},
};
use rayon::prelude::*;
use rstar::{RTree, primitives::GeomWithData};
use std::ops::Range;

/// Only the admitted pairs, with their errors, by truths and by candidates.
pub struct SparseRows {
    /// For every truth its candidates.
    truths: Lists,
    /// For every candidate its truths; `None`: they are the same places, and so are the lists.
    candidates: Option<Lists>,
}

/// A list of places and errors for each place of a side, one after the other.
#[derive(Default)]
struct Lists {
    start: Vec<usize>,
    index: Vec<u32>,
    error_m: Vec<f64>,
}

/// Truths whose lists are made at once.
const SLAB: usize = 4096;

impl SparseRows {
    /// With the distance as error.
    pub(super) fn within(uncertainty: Uncertainty, truths: &Places, candidates: &Places) -> Self {
        let error_m = |t, c| truths.distance_m(t, candidates, c);
        let truth_lists = Lists::new(uncertainty, truths, candidates, error_m);
        // Distance and turn are symmetric to the bit.
        let candidate_lists =
            (truths != candidates).then(|| truth_lists.transposed(candidates.len()));
        Self {
            truths: truth_lists,
            candidates: candidate_lists,
        }
    }

    /// With an error of one's own, which need not be symmetric.
    pub(super) fn with_error(
        uncertainty: Uncertainty,
        truths: &Places,
        candidates: &Places,
        error_m: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let truth_lists = Lists::new(uncertainty, truths, candidates, error_m);
        let candidate_lists = Some(truth_lists.transposed(candidates.len()));
        Self {
            truths: truth_lists,
            candidates: candidate_lists,
        }
    }

    /// Numbers of truths and candidates.
    pub(super) fn counts(&self) -> (usize, usize) {
        let candidates = self.candidates.as_ref().unwrap_or(&self.truths);
        (self.truths.places(), candidates.places())
    }

    /// Candidates that the prior of every truth admits.
    pub(super) fn window_sizes(&self) -> Vec<usize> {
        let starts = self.truths.start.windows(2);
        starts.map(|ends| ends[1] - ends[0]).collect()
    }

    /// Sums over the candidates that the priors of some truths admit.
    #[inline(always)]
    pub(super) fn apply<T: Real>(
        &self,
        truths: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        sums: &mut PriorSums,
    ) {
        self.truths.sums(truths, tile, rows, sums);
    }

    /// Sums over the truths whose priors admit some candidates.
    #[inline(always)]
    pub(super) fn apply_transpose<T: Real>(
        &self,
        candidates: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        sums: &mut PriorSums,
    ) {
        let lists = self.candidates.as_ref().unwrap_or(&self.truths);
        lists.sums(candidates, tile, rows, sums);
    }
}

impl Lists {
    #[inline(always)]
    fn sums<T: Real>(
        &self,
        places: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        sums: &mut PriorSums,
    ) {
        for (place, (weighted, unweighted)) in
            places.zip(sums.weighted.iter_mut().zip(&mut sums.unweighted))
        {
            let pairs = self.start[place]..self.start[place + 1];
            let (index, error_m) = (&self.index[pairs.clone()], &self.error_m[pairs]);
            let (mut weighed, mut summed) = (Lanes::<f64>::default(), Lanes::<f64>::default());
            for (&index, &error_m) in index.iter().zip(error_m) {
                let a = &rows.weighted[index as usize * rows.tiles + tile];
                for l in 0..LANES {
                    weighed[l] += error_m * a[l].to_f64();
                    summed[l] += a[l].to_f64();
                }
            }
            if let Some(unweighted_rows) = rows.unweighted {
                summed = Lanes::default();
                for &index in index {
                    let b = &unweighted_rows[index as usize * rows.tiles + tile];
                    for l in 0..LANES {
                        summed[l] += b[l];
                    }
                }
            }
            (*weighted, *unweighted) = (weighed, summed);
        }
    }

    fn new(
        uncertainty: Uncertainty,
        truths: &Places,
        candidates: &Places,
        error_m: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let near = Near::new(uncertainty, candidates);
        let mut lists = Self {
            start: vec![0],
            ..Self::default()
        };
        for first in (0..truths.len()).step_by(SLAB) {
            let slab = (first..truths.len().min(first + SLAB)).into_par_iter();
            let found: Vec<Vec<(u32, f64)>> = slab
                .map(|truth| {
                    let admitted = near
                        .candidates_of(truths, truth)
                        .into_iter()
                        .filter(|&c| uncertainty.admits(truths, truth, candidates, c as usize));
                    admitted.map(|c| (c, error_m(truth, c as usize))).collect()
                })
                .collect();
            for (index, error_m) in found.iter().flatten() {
                lists.index.push(*index);
                lists.error_m.push(*error_m);
            }
            for list in &found {
                lists
                    .start
                    .push(lists.start[lists.start.len() - 1] + list.len());
            }
        }
        lists
    }

    fn places(&self) -> usize {
        self.start.len() - 1
    }

    /// The same pairs by the other side's places.
    fn transposed(&self, others: usize) -> Self {
        let mut start = vec![0; others + 1];
        for &other in &self.index {
            start[other as usize + 1] += 1;
        }
        for other in 0..others {
            start[other + 1] += start[other];
        }
        let mut next = start.clone();
        let (mut index, mut error_m) = (vec![0; self.index.len()], vec![0.0; self.index.len()]);
        for place in 0..self.places() {
            for pair in self.start[place]..self.start[place + 1] {
                let slot = &mut next[self.index[pair] as usize];
                (index[*slot], error_m[*slot]) = (place as u32, self.error_m[pair]);
                *slot += 1;
            }
        }
        Self {
            start,
            index,
            error_m,
        }
    }
}

/// A candidate's position and number.
type Entry = GeomWithData<[f64; 2], u32>;

/// Finds the candidates that a window may admit without looking at all of them.
struct Near {
    /// By position, with a radius that rounding can't defeat; `None`: all candidates come into question.
    tree: Option<(RTree<Entry>, f64)>,
    candidates: usize,
}

impl Near {
    fn new(uncertainty: Uncertainty, candidates: &Places) -> Self {
        let tree = match (uncertainty, candidates) {
            (Uncertainty::Window { half_width_m, .. }, Places::Plane(poses))
                if half_width_m.is_finite() =>
            {
                let positions = poses
                    .iter()
                    .enumerate()
                    .map(|(k, p)| ([p.x_m, p.y_m], k as u32));
                // No window admits a place without coordinates, and the tree takes none.
                let finite = positions.filter(|(at, _)| at.iter().all(|v| v.is_finite()));
                let entries = finite.map(|(at, k)| Entry::new(at, k)).collect();
                Some((
                    RTree::bulk_load(entries),
                    half_width_m * (1.0 + 1e-9) + 1e-9,
                ))
            }
            _ => None,
        };
        Self {
            tree,
            candidates: candidates.len(),
        }
    }

    /// In the order of their numbers.
    fn candidates_of(&self, truths: &Places, truth: usize) -> Vec<u32> {
        match (&self.tree, truths) {
            (Some((tree, radius_m)), Places::Plane(poses)) => {
                let at = [poses[truth].x_m, poses[truth].y_m];
                if !at.iter().all(|v| v.is_finite()) {
                    return Vec::new();
                }
                let near = tree.locate_within_distance(at, radius_m * radius_m);
                let mut near: Vec<u32> = near.map(|entry| entry.data).collect();
                near.sort_unstable();
                near
            }
            _ => (0..self.candidates as u32).collect(),
        }
    }
}
