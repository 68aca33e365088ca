//! From activations to the probabilities of all 2^n outcomes, and from their gradient back.
//!
//! Bit i of an outcome's number says whether f_i = 1. The four lowest bits are the place in a row of sixteen, the others
//! the number of the row, the *tile*; P(f|s) is a row that depends on the four lowest features, times one number a tile.
//! Fewer than four features are filled up with features that never fire: their outcomes have no probability.

use crate::learning::lanes::{LANES, Lanes, Real, total};

/// Features told apart within a row: 2^4 = 16.
const LOW: usize = 4;

/// Tiles that n features take.
pub(super) fn tiles(features: usize) -> usize {
    1 << features.saturating_sub(LOW)
}

/// P(f|s) of one place, but for the high features.
#[derive(Clone, Copy)]
pub(super) struct Factors<T> {
    /// The product over the four lowest features, over the sixteen outcomes.
    product: Lanes<T>,
}

impl<T: Real> Factors<T> {
    /// Of activations g, all n of them.
    #[inline(always)]
    pub(super) fn new(g: &[T]) -> Self {
        let mut low = [Lanes::<T>::default(); LOW];
        for (i, low) in low.iter_mut().enumerate() {
            let g = if i < g.len() { g[i] } else { T::default() };
            let not = T::ONE - g;
            for l in 0..LANES {
                low[l] = if l >> i & 1 == 1 { g } else { not };
            }
        }
        let product = times(&times(&low[0], &low[1]), &times(&low[2], &low[3]));
        Self { product }
    }

    /// P(f|s) of a tile's outcomes, the tile's number given by [`high`].
    #[inline(always)]
    pub(super) fn outcomes(&self, high: T) -> Lanes<T> {
        let mut p = self.product;
        for l in 0..LANES {
            p[l] = p[l] * high;
        }
        p
    }

    /// Σ over the low outcomes of P times ∂E/∂P, one number a tile: what the high features' gradient is made of.
    #[inline(always)]
    fn sum_out_low(&self, slope: &[Lanes<T>], out: &mut [T]) {
        for (out, slope) in out.iter_mut().zip(slope) {
            *out = total(&times(&self.product, slope));
        }
    }
}

/// ∂E/∂g_i = Σ_f ∂E/∂P[f] · (±1) · Π_{j≠i} P(f_j | s), for up to sixteen places side by side: leave-one-out products,
/// so that g = 0 and g = 1 are fine.
///
/// Of each place `g` are its activations, `[place, feature]`, `slope` is ∂E/∂P and `highs` the tiles' numbers,
/// `[place, tile]`; `workspace` is overwritten.
#[inline(always)]
pub(super) fn gradient<T: Real>(
    g: [&[T]; LANES],
    highs: &[T],
    slope: &[Lanes<T>],
    workspace: &mut [T],
    out: &mut [T],
) {
    let (n, tiles) = (g[0].len(), workspace.len());
    let places = out.len() / n;
    // Outcome by outcome, with the places in the lanes. Summed over the high features, sixteen are left.
    let mut open = [Lanes::<T>::default(); LANES];
    for place in 0..places {
        let mut summed = Lanes::<T>::default();
        for tile in 0..tiles {
            let (slope, high) = (slope[place * tiles + tile], highs[place * tiles + tile]);
            for l in 0..LANES {
                summed[l] += slope[l] * high;
            }
        }
        for f in 0..LANES {
            open[f][place] = summed[f];
        }
    }
    let mut low = [Lanes::<T>::default(); LOW];
    for place in 0..places {
        for (i, &g) in g[place].iter().take(LOW).enumerate() {
            low[i][place] = g;
        }
    }
    // The last feature first: what comes after it is summed over already, what comes before it still is open.
    for i in (0..LOW).rev() {
        let half = 1 << i;
        let mut difference = [Lanes::<T>::default(); LANES / 2];
        for f in 0..half {
            for l in 0..LANES {
                difference[f][l] = open[f + half][l] - open[f][l];
            }
        }
        for j in (0..i).rev() {
            for f in 0..1 << j {
                difference[f] = mean(&difference[f], &difference[f + (1 << j)], &low[j]);
            }
        }
        if i < n {
            for place in 0..places {
                out[place * n + i] = difference[0][place];
            }
        }
        for f in 0..half {
            open[f] = mean(&open[f], &open[f + half], &low[i]);
        }
    }
    if n > LOW {
        for (place, out) in out.chunks_exact_mut(n).enumerate() {
            let g = g[place];
            Factors::new(g).sum_out_low(&slope[place * tiles..(place + 1) * tiles], workspace);
            high_gradient(&g[LOW..], workspace, &mut out[LOW..]);
        }
    }
}

/// The mean over a feature that is 1 with probability g.
#[inline(always)]
fn mean<T: Real>(without: &Lanes<T>, with: &Lanes<T>, g: &Lanes<T>) -> Lanes<T> {
    let mut mean = *without;
    for l in 0..LANES {
        mean[l] = (T::ONE - g[l]) * without[l] + g[l] * with[l];
    }
    mean
}

/// P of the high features' outcomes, one a tile.
#[inline(always)]
pub(super) fn high<T: Real>(g: &[T], out: &mut [T]) {
    out[0] = T::ONE;
    for (i, &g) in g.iter().skip(LOW).enumerate() {
        for tile in 0..1 << i {
            out[tile + (1 << i)] = out[tile] * g;
            out[tile] = out[tile] * (T::ONE - g);
        }
    }
}

/// The same leave-one-out sums, over the tiles.
fn high_gradient<T: Real>(g: &[T], open: &mut [T], out: &mut [T]) {
    // The last feature first: what comes after it is summed over already, what comes before it still is open.
    for i in (0..g.len()).rev() {
        let (without, with) = open[..1 << (i + 1)].split_at(1 << i);
        let mut difference: Vec<T> = with.iter().zip(without).map(|(&w, &o)| w - o).collect();
        for j in (0..i).rev() {
            sum_out(&mut difference, j, g[j]);
        }
        out[i] = difference[0];
        sum_out(open, i, g[i]);
    }
}

/// Sums over f_i, the last open feature: what is left, in front, are the outcomes of those before it.
fn sum_out<T: Real>(open: &mut [T], i: usize, g: T) {
    let (without, with) = open.split_at_mut(1 << i);
    for (o, &w) in without.iter_mut().zip(&*with) {
        *o = (T::ONE - g) * *o + g * w;
    }
}

#[inline(always)]
fn times<T: Real>(a: &Lanes<T>, b: &Lanes<T>) -> Lanes<T> {
    let mut product = *a;
    for l in 0..LANES {
        product[l] = product[l] * b[l];
    }
    product
}
