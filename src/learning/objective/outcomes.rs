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

/// P(f|s) of one place, by its factors.
#[derive(Clone, Copy)]
pub(super) struct Factors<T> {
    /// P(f_i|s) for i below four, over the sixteen outcomes.
    low: [Lanes<T>; LOW],
    /// Their product.
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
        Self { low, product }
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

    /// ∂E/∂g_i = Σ_f ∂E/∂P[f] · (±1) · Π_{j≠i} P(f_j | s): leave-one-out products, so that g = 0 and g = 1 are fine.
    ///
    /// `slope` is ∂E/∂P, `[tile]`, `high` the tiles' numbers; `room` is overwritten.
    #[inline(always)]
    pub(super) fn gradient(
        &self,
        g: &[T],
        high: &[T],
        slope: &[Lanes<T>],
        room: &mut [T],
        out: &mut [T],
    ) {
        // Summed over the high features, the sixteen outcomes of the low ones are left.
        let mut open = Lanes::<T>::default();
        for (slope, &high) in slope.iter().zip(high) {
            for l in 0..LANES {
                open[l] += slope[l] * high;
            }
        }
        let [a, b, c, d] = &self.low;
        let (ab, cd) = (times(a, b), times(c, d));
        let others = [times(b, &cd), times(a, &cd), times(&ab, d), times(&ab, c)];
        for ((i, others), out) in others.iter().enumerate().zip(out.iter_mut()) {
            let mut signed = times(others, &open);
            for l in 0..LANES {
                signed[l] = if l >> i & 1 == 1 { signed[l] } else { T::default() - signed[l] };
            }
            *out = total(&signed);
        }
        if g.len() > LOW {
            // And summed over the low ones, one number a tile.
            for (room, slope) in room.iter_mut().zip(slope) {
                *room = total(&times(&self.product, slope));
            }
            high_gradient(&g[LOW..], room, &mut out[LOW..]);
        }
    }
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
