//! The three passes over the places, a chunk of them at a time.

use super::{
    SMALLEST_PROBABILITY,
    outcomes::{Factors, gradient, high},
};
use crate::learning::{
    lanes::{Kernel, LANES, Lanes, Real, at_least, total},
    prior_operator::{Answers, Asking, CHUNK, PriorOperator, Rows, Scratch},
};

/// Activations g of one side's places, `[place, feature]`.
#[derive(Clone, Copy)]
pub(super) struct Activations<'a, T> {
    pub g: &'a [T],
    pub features: usize,
    /// The operator's order of the places.
    pub order: Option<&'a [usize]>,
}

impl<'a, T> Activations<'a, T> {
    /// The caller's number of place `place` in order.
    #[inline(always)]
    fn number(&self, place: usize) -> usize {
        match self.order {
            Some(order) => order[place],
            None => place,
        }
    }

    /// All features of place `place` in order.
    #[inline(always)]
    fn of(&self, place: usize) -> &'a [T] {
        let k = self.number(place);
        &self.g[k * self.features..(k + 1) * self.features]
    }
}

/// The first pass: P of a chunk's outcomes, `[place, tile]`.
pub(super) struct Outcomes<'a, T> {
    pub activations: Activations<'a, T>,
    pub first: usize,
    /// `[tile]`, to work in.
    pub highs: &'a mut [T],
    pub out: &'a mut [Lanes<T>],
}

impl<T: Real> Kernel for Outcomes<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let rows = self.out.chunks_exact_mut(self.highs.len());
        for (i, rows) in rows.enumerate() {
            let g = self.activations.of(self.first + i);
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
    answers: Answers,
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
            answers: Answers::new(),
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
            let of_tiles = places.start * tiles..places.end * tiles;
            let (highs, slope) = (&self.highs[of_tiles.clone()], &self.slope[of_tiles]);
            let mut g = [activations.of(first + start); LANES];
            for (g, place) in g.iter_mut().zip(places) {
                *g = activations.of(first + place);
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
            high(activations.of(first + i), highs);
        }
    }
}

/// The second pass: from M, a chunk of truths' ē, E and ∂E/∂g, and U for the way back.
pub(super) struct ExpectedErrorPass<'a, T> {
    pub prior: &'a PriorOperator,
    pub activations: Activations<'a, T>,
    pub weight: &'a [f64],
    pub first: usize,
    /// M.
    pub rows: &'a Rows<'a, T>,
    pub scratch: &'a Scratch<T>,
    pub workspace: &'a mut ChunkWorkspace<T>,
    /// U, `[truth, tile]`.
    pub weighted: &'a mut [Lanes<T>],
    /// U∘ē, `[truth, tile]`.
    pub unweighted: &'a mut [Lanes<f64>],
    /// `[truth, feature]`.
    pub gradient: &'a mut [T],
}

impl<T: Real> Kernel for ExpectedErrorPass<'_, T> {
    /// The chunk's part of E, in metres.
    type Output = f64;

    #[inline(always)]
    fn run(self) -> f64 {
        let Self {
            activations,
            first,
            workspace,
            ..
        } = self;
        let (tiles, count) = (self.rows.tiles, self.gradient.len() / activations.features);
        let prior_errors_m = self.prior.prior_errors_m();
        let (mut given_m, mut error_m) = (0.0, Lanes::<f64>::default());
        workspace.fill_highs(&activations, first, tiles, count);
        for tile in 0..tiles {
            let truths = first..first + count;
            let answers = &mut workspace.answers;
            self.prior.answer(
                Asking::Truths,
                truths,
                tile,
                self.rows,
                self.scratch,
                answers,
            );
            for i in 0..count {
                let truth = activations.number(first + i);
                let (weight, prior_error_m) = (self.weight[truth], prior_errors_m[truth]);
                if tile == 0 {
                    given_m += weight * prior_error_m;
                }
                let places = self.prior.window_size(truth).max(1);
                let least = SMALLEST_PROBABILITY * places as f64;
                let row = i * tiles + tile;
                let p = Factors::new(activations.of(first + i)).outcomes(workspace.highs[row]);
                let (n, d) = (answers.weighted[i], answers.unweighted[i]);
                let (mut slope, mut u, mut expected_m) = (n, n, n);
                for l in 0..LANES {
                    let inverse = 1.0 / at_least(d[l], least);
                    // ē − prior error: what is small is rounded, not what it is the difference of.
                    let above_m = (n[l] - prior_error_m * d[l]) * inverse;
                    expected_m[l] = at_least(prior_error_m + above_m, 0.0); // ē
                    slope[l] = weight * above_m; // ∂E/∂P, but for a number that is the same for all f
                    u[l] = weight * p[l].wide() * inverse;
                    error_m[l] += p[l].wide() * slope[l];
                }
                let (slope, u) = (T::row_of(&slope), T::row_of(&u));
                // Where one place alone shows f, e − ē vanishes there: U∘ē must be that of the U that was rounded.
                let mut v = expected_m;
                for l in 0..LANES {
                    v[l] = u[l].wide() * expected_m[l];
                }
                workspace.slope[row] = slope;
                self.weighted[row] = u;
                self.unweighted[row] = v;
            }
        }
        workspace.fill_gradient(&activations, first, tiles, self.gradient);
        given_m + total(&error_m)
    }
}

/// The third pass: from U and U∘ē, ∂E/∂M and ∂E/∂g of a chunk of the map's places.
pub(super) struct MapGradientPass<'a, T> {
    pub prior: &'a PriorOperator,
    pub activations: Activations<'a, T>,
    pub first: usize,
    /// U and U∘ē.
    pub rows: &'a Rows<'a, T>,
    pub scratch: &'a Scratch<T>,
    pub workspace: &'a mut ChunkWorkspace<T>,
    /// `[candidate, feature]`.
    pub gradient: &'a mut [T],
}

impl<T: Real> Kernel for MapGradientPass<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            activations,
            first,
            workspace,
            ..
        } = self;
        let (tiles, count) = (self.rows.tiles, self.gradient.len() / activations.features);
        workspace.fill_highs(&activations, first, tiles, count);
        for tile in 0..tiles {
            let places = first..first + count;
            let answers = &mut workspace.answers;
            let asking = Asking::Candidates;
            self.prior
                .answer(asking, places, tile, self.rows, self.scratch, answers);
            for i in 0..count {
                let (mut slope, unweighted) = (answers.weighted[i], answers.unweighted[i]);
                for l in 0..LANES {
                    slope[l] -= unweighted[l];
                }
                workspace.slope[i * tiles + tile] = T::row_of(&slope);
            }
        }
        workspace.fill_gradient(&activations, first, tiles, self.gradient);
    }
}
