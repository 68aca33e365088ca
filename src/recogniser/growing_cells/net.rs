//! The network of growing cell structures (Fritzke 1994, F94): cells, triangles between them, signal counters.
//!
//! F94 prints three things that a net of few signals in many dimensions can't do with, and which differ here:
//! - the volume of a cell's Voronoi region is estimated as l̄ⁿ, l̄ its mean edge and n the dimension of the inputs (F94).
//!   With n = 24 readings one edge that is a tenth longer is ten times the volume. The net is two-dimensional, so n is 2;
//! - a region can seem to grow by an insertion next to it. Its counter then is left as it is, where F94's formula would
//!   make the new cell's negative;
//! - η is taken relative to the mean density of the net, as inputs here don't fill an area of 1.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// How much a signal moves, and how much older ones are forgotten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// ε_b, of the best-matching cell.
    pub best: f64,
    /// ε_n, of its direct neighbours.
    pub neighbour: f64,
    /// α, of all counters.
    pub decay: f64,
}

/// Cells on a net of triangles: two cells are neighbours where a triangle has both.
///
/// ```
/// use ballmark::recogniser::growing_cells::net::{Net, Rates};
/// let mut net = Net::triangle([vec![0.0, 0.0], vec![4.0, 0.0], vec![0.0, 2.0]]);
/// net.adapt(&[4.0, 1.0], &Rates { best: 0.5, neighbour: 0.0, decay: 0.0 });
/// net.insert(); // between cell 1, which was signalled, and its farther neighbour, 2
/// assert_eq!((net.len(), net.neighbours(3)), (4, vec![0, 1, 2]));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Net {
    /// w_c, `[cell][value]`.
    weights: Vec<Vec<f64>>,
    /// τ_c: signals that the cell was best for, older ones counting less.
    signals: Vec<f64>,
    /// Cells of each triangle, in rising order.
    triangles: Vec<[usize; 3]>,
}

impl Net {
    /// The first three cells, neighbours all.
    pub fn triangle(weights: [Vec<f64>; 3]) -> Self {
        Self {
            weights: weights.to_vec(),
            signals: vec![0.0; 3],
            triangles: vec![[0, 1, 2]],
        }
    }

    /// Number of cells; never less than 3.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Bytes that are kept of a cell, with its share of the triangles.
    pub fn bytes_per_cell(&self) -> usize {
        let of_cell = (self.weights[0].len() + 1) * size_of::<f64>();
        of_cell + self.triangles.len() * size_of::<[usize; 3]>() / self.len()
    }

    /// Direct neighbours of a cell, in rising order.
    pub fn neighbours(&self, cell: usize) -> Vec<usize> {
        let own = self.triangles.iter().filter(|t| t.contains(&cell));
        let mut others: Vec<usize> = own.flatten().copied().filter(|&c| c != cell).collect();
        others.sort_unstable();
        others.dedup();
        others
    }

    /// The cell nearest to a signal, the first of several, and the square of its distance.
    pub fn best_matching(&self, signal: &[f64]) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        for (cell, weights) in self.weights.iter().enumerate() {
            let square = square(weights, signal);
            if square < best.1 {
                best = (cell, square);
            }
        }
        best
    }

    /// One adaptation step (F94): the best-matching cell and its neighbours move towards the signal, its
    /// counter goes up by one, and all counters lose a share.
    pub fn adapt(&mut self, signal: &[f64], rates: &Rates) {
        let (best, _) = self.best_matching(signal);
        towards(&mut self.weights[best], signal, rates.best);
        for neighbour in self.neighbours(best) {
            towards(&mut self.weights[neighbour], signal, rates.neighbour);
        }
        self.signals[best] += 1.0;
        for signals in &mut self.signals {
            *signals -= rates.decay * *signals;
        }
    }

    /// One insertion (F94): a new cell half way between the cell that got most signals and the farthest of its
    /// neighbours, which becomes a neighbour of both and of the neighbours they share. Its counter is what theirs lose
    /// with the part of their regions that is now its own.
    pub fn insert(&mut self) {
        let q = first_largest(self.signals.iter().copied());
        let around = self.neighbours(q);
        let lengths = around.iter().map(|&c| self.length(q, c));
        let f = around[first_largest(lengths)];
        let r = self.weights.len();
        let halfway = |(a, b): (&f64, &f64)| 0.5 * (a + b);
        let between = self.weights[q].iter().zip(&self.weights[f]);
        let between = between.map(halfway).collect();
        let joined: Vec<usize> = {
            let of_f = self.neighbours(f);
            let shared = around.iter().filter(|c| of_f.contains(c));
            shared.copied().chain([q, f]).collect()
        };
        let before: Vec<f64> = joined.iter().map(|&c| self.volume(c)).collect();

        // Each triangle on the edge from q to f is cut in two.
        let on_edge = |t: &[usize; 3]| t.contains(&q) && t.contains(&f);
        let triangles = std::mem::take(&mut self.triangles).into_iter();
        let (cut, mut kept): (Vec<[usize; 3]>, Vec<_>) = triangles.partition(on_edge);
        for triangle in cut {
            for gone in [f, q] {
                let mut half = triangle.map(|c| if c == gone { r } else { c });
                half.sort_unstable();
                kept.push(half);
            }
        }
        self.triangles = kept;
        self.weights.push(between);

        let mut signals = 0.0;
        for (&c, before) in joined.iter().zip(before) {
            // Δτ_c = (F_new − F_old)/F_old · τ_c, and τ_r = −Σ Δτ_c.
            let after = self.volume(c);
            let lost = if after < before {
                (before - after) / before * self.signals[c]
            } else {
                0.0
            };
            self.signals[c] -= lost;
            signals += lost;
        }
        self.signals.push(signals);
    }

    /// Removal of superfluous cells (F94): those with h̃_c/F_c, their share of the signals over their region's
    /// volume, below η times that of the whole net; with a cell go its triangles, and then all cells without one. The
    /// least dense goes first. Never the last triangle. Returns the number of cells removed.
    pub fn remove_superfluous(&mut self, eta: f64) -> usize {
        let before = self.len();
        loop {
            let volumes: Vec<f64> = (0..self.len()).map(|c| self.volume(c)).collect();
            let (all, space): (f64, f64) = (self.signals.iter().sum(), volumes.iter().sum());
            if all <= 0.0 || space <= 0.0 {
                return before - self.len();
            }
            // h_c/F_c < η Σh/ΣF without the divisions: a region of no volume is as dense as can be.
            let excess = |c: usize| self.signals[c] * space - eta * all * volumes[c];
            let candidates = (0..self.len()).filter(|&c| excess(c) < 0.0);
            let mut by_density: Vec<(f64, usize)> = candidates
                .map(|c| (self.signals[c] / volumes[c], c))
                .collect();
            by_density.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let stays = |c: usize| self.triangles.iter().any(|t| !t.contains(&c));
            let Some((_, gone)) = by_density.into_iter().find(|&(_, c)| stays(c)) else {
                return before - self.len();
            };
            self.remove(gone);
        }
    }

    fn remove(&mut self, cell: usize) {
        self.triangles.retain(|t| !t.contains(&cell));
        let alive = |c: usize| self.triangles.iter().any(|t| t.contains(&c));
        let kept: Vec<usize> = (0..self.len()).filter(|&c| alive(c)).collect();
        let mut number = vec![usize::MAX; self.len()];
        for (new, &old) in kept.iter().enumerate() {
            number[old] = new;
        }
        // Numbers fall together in order, so triangles stay in rising order.
        for triangle in &mut self.triangles {
            *triangle = triangle.map(|c| number[c]);
        }
        self.weights = kept.iter().map(|&c| self.weights[c].clone()).collect();
        self.signals = kept.iter().map(|&c| self.signals[c]).collect();
    }

    /// Volume of a cell's Voronoi region, estimated: that of a square whose side is the cell's mean edge (F94).
    fn volume(&self, cell: usize) -> f64 {
        let around = self.neighbours(cell);
        let sum: f64 = around.iter().map(|&c| self.length(cell, c)).sum();
        (sum / around.len().max(1) as f64).powi(2)
    }

    fn length(&self, a: usize, b: usize) -> f64 {
        square(&self.weights[a], &self.weights[b]).sqrt()
    }

    /// Checks what may have come from a file: `width` values a cell, a counter a cell, and each cell in a triangle.
    ///
    /// # Errors
    /// Where one of these is not so.
    pub fn check(&self, width: usize) -> Result<()> {
        let cells = self.weights.len();
        let finite = |w: &Vec<f64>| w.len() == width && w.iter().all(|w| w.abs() < 1e9);
        let rising = |t: &[usize; 3]| t[0] < t[1] && t[1] < t[2] && t[2] < cells;
        let sound = cells >= 3
            && self.weights.iter().all(finite)
            && self.signals.len() == cells
            && self.signals.iter().all(|s| s.is_finite() && *s >= 0.0)
            && self.triangles.iter().all(rising)
            && (0..cells).all(|c| self.triangles.iter().any(|t| t.contains(&c)));
        match sound {
            true => Ok(()),
            false => Err(Error::work(format!(
                "growing_cells: expected 3 cells or more of {width} finite values, a counter each, and each in a triangle"
            ))),
        }
    }
}

fn towards(weights: &mut [f64], signal: &[f64], rate: f64) {
    for (w, s) in weights.iter_mut().zip(signal) {
        *w += rate * (s - *w);
    }
}

fn square(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Position of the largest, the first of several; 0 of none.
fn first_largest(values: impl Iterator<Item = f64>) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (i, value) in values.enumerate() {
        if value > best.1 {
            best = (i, value);
        }
    }
    best.0
}

#[cfg(test)]
mod tests;
