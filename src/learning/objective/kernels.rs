//! What each pass does with a chunk of places, in vectors.

use super::{
    SMALLEST_PROBABILITY, Truth,
    activations::Activations,
    map_slope,
    outcomes::{Factors, gradient, high},
};
use crate::{
    learning::{
        lanes::{LANES, Lanes, Real, total},
        prior_operator::{CHUNK, PriorOperator, PriorSums, Rows, Scratch},
    },
    simd::Kernel,
};

/// The first pass: P of a chunk's outcomes, `[place, tile]`.
pub(super) struct MapOutcomes<'a, T> {
    pub activations: Activations<'a, T>,
    pub first: usize,
    /// `[tile]`, to work in.
    pub highs: &'a mut [T],
    pub out: &'a mut [Lanes<T>],
}

impl<T: Real> Kernel for MapOutcomes<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let rows = self.out.chunks_exact_mut(self.highs.len());
        for (i, rows) in rows.enumerate() {
            let g = self.activations.row(self.first + i);
            let factors = Factors::new(g);
            high(g, self.highs);
            for (row, &high) in rows.iter_mut().zip(&*self.highs) {
                *row = factors.outcomes(high);
            }
        }
    }
}

/// What a chunk needs besides input and output.
#[derive(Debug)]
pub(super) struct ChunkWorkspace<T> {
    sums: PriorSums,
    /// ∂E/∂P or ∂E/∂M, `[place, tile]`.
    slope: Vec<Lanes<T>>,
    /// `[place, tile]`.
    highs: Vec<T>,
    /// `[tile]`.
    open: Vec<T>,
}

impl<T: Real> ChunkWorkspace<T> {
    pub(super) fn new(tiles: usize) -> Self {
        Self {
            sums: PriorSums::new(),
            slope: vec![Lanes::default(); CHUNK * tiles],
            highs: vec![T::default(); CHUNK * tiles],
            open: vec![T::default(); tiles],
        }
    }

    /// Tiles that it is made for.
    pub(super) fn tiles(&self) -> usize {
        self.open.len()
    }

    /// `[tile]`, for one place.
    pub(super) fn highs_of_one(&mut self) -> &mut [T] {
        &mut self.open
    }

    /// ∂E/∂g of a chunk, from `slope`, `[place, feature]`.
    #[inline(always)]
    fn fill_gradient(
        &mut self,
        activations: &Activations<T>,
        first: usize,
        tiles: usize,
        out: &mut [T],
    ) {
        for (group, out) in out.chunks_mut(activations.features * LANES).enumerate() {
            let start = group * LANES;
            let places = start..start + out.len() / activations.features;
            let rows = places.start * tiles..places.end * tiles;
            let (highs, slope) = (&self.highs[rows.clone()], &self.slope[rows]);
            let mut g = [activations.row(first + start); LANES];
            for (g, place) in g.iter_mut().zip(places) {
                *g = activations.row(first + place);
            }
            gradient(g, highs, slope, &mut self.open, out);
        }
    }

    #[inline(always)]
    fn fill_highs(
        &mut self,
        activations: &Activations<T>,
        first: usize,
        tiles: usize,
        count: usize,
    ) {
        let highs = self.highs.chunks_exact_mut(tiles).take(count);
        for (i, highs) in highs.enumerate() {
            high(activations.row(first + i), highs);
        }
    }
}

/// The second pass: from M, a chunk of truths' N, D and ē; from them E, ∂E/∂g, U and U∘ē.
pub(super) struct ExpectedError<'a, T> {
    pub prior: &'a PriorOperator,
    pub activations: Activations<'a, T>,
    pub weight: &'a [f64],
    pub first: usize,
    pub m: &'a Rows<'a, T>,
    pub scratch: &'a Scratch<T>,
    pub workspace: &'a mut ChunkWorkspace<T>,
    /// U, `[truth, tile]`.
    pub u: &'a mut [Lanes<T>],
    /// U∘ē, `[truth, tile]`.
    pub u_errors: &'a mut [Lanes<f64>],
    /// `[truth, feature]`.
    pub gradient: &'a mut [T],
}

impl<T: Real> Kernel for ExpectedError<'_, T> {
    /// The chunk's part of E, in metres.
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self {
            prior,
            activations,
            first,
            workspace,
            ..
        } = self;
        let (tiles, count) = (self.m.tiles, self.gradient.len() / activations.features);
        let prior_errors_m = prior.prior_errors_m();
        let (mut prior_error_m, mut error_m) = (0.0, Lanes::<f64>::default());
        workspace.fill_highs(&activations, first, tiles, count);
        for tile in 0..tiles {
            let truths = first..first + count;
            let sums = &mut workspace.sums;
            prior.apply(truths, tile, self.m, self.scratch, sums);
            for i in 0..count {
                let number = activations.number(first + i);
                let places = prior.window_size(number).max(1);
                let truth = Truth {
                    weight: self.weight[number],
                    prior_error_m: prior_errors_m[number],
                    smallest_d: SMALLEST_PROBABILITY * places as f64,
                };
                if tile == 0 {
                    prior_error_m += truth.weight * truth.prior_error_m;
                }
                let row = i * tiles + tile;
                let p = Factors::new(activations.row(first + i)).outcomes(workspace.highs[row]);
                let n_and_d = [&sums.weighted[i], &sums.unweighted[i]];
                let (slope, u, u_errors) = truth.expected_error(n_and_d, &p, &mut error_m);
                workspace.slope[row] = slope;
                self.u[row] = u;
                self.u_errors[row] = u_errors;
            }
        }
        workspace.fill_gradient(&activations, first, tiles, self.gradient);
        prior_error_m + total(&error_m)
    }
}

/// The third pass: from U and U∘ē, ∂E/∂M and ∂E/∂g of a chunk of the map's places.
pub(super) struct MapGradient<'a, T> {
    pub prior: &'a PriorOperator,
    pub activations: Activations<'a, T>,
    pub first: usize,
    /// U and U∘ē.
    pub u: &'a Rows<'a, T>,
    pub scratch: &'a Scratch<T>,
    pub workspace: &'a mut ChunkWorkspace<T>,
    /// `[candidate, feature]`.
    pub gradient: &'a mut [T],
}

impl<T: Real> Kernel for MapGradient<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            prior,
            activations,
            first,
            workspace,
            ..
        } = self;
        let (tiles, count) = (self.u.tiles, self.gradient.len() / activations.features);
        workspace.fill_highs(&activations, first, tiles, count);
        for tile in 0..tiles {
            let places = first..first + count;
            let sums = &mut workspace.sums;
            prior.apply_transpose(places, tile, self.u, self.scratch, sums);
            for i in 0..count {
                workspace.slope[i * tiles + tile] =
                    map_slope(&sums.weighted[i], &sums.unweighted[i]);
            }
        }
        workspace.fill_gradient(&activations, first, tiles, self.gradient);
    }
}
