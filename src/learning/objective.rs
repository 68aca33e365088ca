//! The objective: the error a robot is expected to make after sensing, and its gradient (Thrun 1998, eq. 36–43).
//!
//! With P[k, f] = Π_i P(f_i | s_k) the truth's outcomes, M the same of the map's places, and the prior as the matrices
//! Bel and A = e ∘ Bel,
//!
//! ```text
//! N = A·M      D = Bel·M      E = Σ_k* w_k* Σ_f P[k*, f] · N[k*, f] / D[k*, f]
//! ∂E/∂P = w ∘ N/D             ∂E/∂M = Aᵀ(w ∘ P/D) − Belᵀ(w ∘ P ∘ N/D²)
//! ```
//!
//! In Thrun's objective (eq. 42) the map is the training snapshots themselves, M = P. The printed gradient (eq. 43)
//! lacks Bel_prior in both denominators; this is the derivative of eq. 42 itself. As a prior belief is uniform over its
//! window, its height cancels, and with ē = N/D, the error expected at k* after sensing f,
//!
//! ```text
//! ē[k*, f] = Σ_k e[k*, k]·M[k, f] / Σ_k M[k, f]                 over the window of k*
//! ∂E/∂M[k, f] = Σ_k* (e[k*, k] − ē[k*, f])·U[k*, f],   U[k*, f] = w_k*·P[k*, f] / Σ_k M[k, f]
//! ```
//!
//! So an evaluation is three passes over the places: the map's outcomes; then ē, E and U; then ∂E/∂M. Each runs in
//! chunks of fixed size, outcome beside outcome in vectors, and leaves only M, U and U∘ē in memory.

mod outcomes;

use super::{
    lanes::{LANES, Lanes, Real, Vectors, at_least},
    prior_operator::{Answers, Asking, CHUNK, PriorOperator, Rows, Scratch},
};
use crate::error::{Error, Result};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2};
use outcomes::{Factors, high, tiles};
use rayon::prelude::*;

/// Most features that 2^n outcomes allow.
pub const MOST_FEATURES: usize = 12;

/// P(f) under a prior counts as at least this: saturated features would give 0/0. An outcome this rare adds at most its
/// probability times the extent to the error.
const SMALLEST_PROBABILITY: f64 = 1e-12;

/// The objective at given activations, and which way is up.
#[derive(Debug, Clone, Default)]
pub struct Evaluation<T = f64> {
    /// E_prior: expected error before sensing, in metres.
    pub prior_error_m: f64,
    /// E_posterior: expected error after sensing, in metres.
    pub posterior_error_m: f64,
    /// ∂E_posterior/∂g of the truths, `[truth, feature]`.
    pub truth_gradient: Array2<T>,
    /// ∂E_posterior/∂g of the map's places, `[candidate, feature]`.
    pub map_gradient: Array2<T>,
}

impl<T> Evaluation<T> {
    /// 1 − E_posterior / E_prior (Thrun 1998, eq. 46).
    pub fn error_reduction(&self) -> f64 {
        1.0 - self.posterior_error_m / self.prior_error_m
    }
}

/// E_posterior and its gradient, for activations g of the truths `[truth, feature]` and of the map's places
/// `[candidate, feature]`, and weights P(ξ*) of the truths, which sum to 1. An [`Objective`] does the same again and
/// again, and in `f32`.
///
/// The witness: two places d apart, one feature that answers .9 and .2, no idea where: E = 25/99·d.
///
/// ```
/// use ballmark::belief::{Places, Uncertainty};
/// use ballmark::learning::{objective::evaluate, prior_operator::PriorOperator};
/// use ndarray::array;
/// let places = Places::Route(vec![0.0, 99.0]);
/// let prior = PriorOperator::new(Uncertainty::Global, &places, &places);
/// let g = array![[0.9], [0.2]];
/// let e = evaluate(&prior, g.view(), g.view(), array![0.5, 0.5].view())?;
/// assert!((e.posterior_error_m - 25.0).abs() < 1e-12);
/// assert!((e.prior_error_m - 49.5).abs() < 1e-12);
/// let gradient = &e.truth_gradient + &e.map_gradient; // the map is the truths themselves
/// assert!((gradient[[0, 0]] / 99.0 + 0.7570656).abs() < 1e-7 && (gradient[[1, 0]] / 99.0 - 0.6570758).abs() < 1e-7);
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// As [`Objective::evaluate`].
pub fn evaluate(
    prior: &PriorOperator,
    truth: ArrayView2<f64>,
    map: ArrayView2<f64>,
    weight: ArrayView1<f64>,
) -> Result<Evaluation> {
    let mut objective = Objective::new();
    objective.evaluate(prior, truth, map, weight)?;
    Ok(objective.evaluation)
}

/// The objective with all its buffers, for one evaluation after the other: fresh ones cost more than the sums. Whoever
/// evaluates priors of different sizes in turn keeps one for each.
///
/// ```
/// use ballmark::{belief::Places, learning::{objective::{Objective, equal_weights}, prior_operator::PriorOperator}};
/// use ndarray::array;
/// let places = Places::Route(vec![0.0, 99.0]);
/// let prior = PriorOperator::new("global".parse()?, &places, &places);
/// let mut objective = Objective::<f32>::new();
/// for step in 0..3 {
///     let g = array![[0.9f32 + 0.01 * step as f32], [0.2]];
///     let e = objective.evaluate(&prior, g.view(), g.view(), equal_weights(2).view())?;
///     assert!(e.posterior_error_m < 25.001);
/// }
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug)]
pub struct Objective<T> {
    vectors: Vectors,
    /// M `[candidate, tile]`, in the operator's order, as are U and U∘ē `[truth, tile]`.
    map: Vec<Lanes<T>>,
    by_error: Vec<Lanes<T>>,
    plain: Vec<Lanes<T>>,
    of_map: Scratch<T>,
    of_truths: Scratch<T>,
    /// E of every chunk of truths.
    parts_m: Vec<f64>,
    /// Gradients that are not yet in the callers' order.
    in_order: Vec<T>,
    evaluation: Evaluation<T>,
}

impl<T: Real> Default for Objective<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> Objective<T> {
    /// With buffers still empty: they take their size from the first evaluation.
    pub fn new() -> Self {
        Self::on(Vectors::Best)
    }

    fn on(vectors: Vectors) -> Self {
        Self {
            vectors,
            map: Vec::new(),
            by_error: Vec::new(),
            plain: Vec::new(),
            of_map: Scratch::default(),
            of_truths: Scratch::default(),
            parts_m: Vec::new(),
            in_order: Vec::new(),
            evaluation: Evaluation::default(),
        }
    }

    /// E_posterior and its gradient, for activations g of the truths `[truth, feature]` and of the map's places
    /// `[candidate, feature]`, and weights P(ξ*) of the truths, which sum to 1. The bits of the result depend neither on
    /// the number of threads nor on what was evaluated before.
    ///
    /// # Errors
    /// Where there are more than [`MOST_FEATURES`] features, or the numbers of places, features and weights do not fit
    /// one another.
    pub fn evaluate(
        &mut self,
        prior: &PriorOperator,
        truth: ArrayView2<T>,
        map: ArrayView2<T>,
        weight: ArrayView1<f64>,
    ) -> Result<&Evaluation<T>> {
        let n = truth.ncols();
        if n > MOST_FEATURES {
            return Err(Error::work(format!(
                "{n} features have 2^{n} outcomes; the exact objective takes at most {MOST_FEATURES}"
            )));
        }
        let expected = [(prior.truths(), n), (prior.candidates(), n)];
        if [truth.dim(), map.dim()] != expected || weight.len() != prior.truths() {
            return Err(Error::work(format!(
                "objective: activations of {:?} truths and {:?} places of the map with {} weights; expected {:?}, {:?} and {}",
                truth.dim(),
                map.dim(),
                weight.len(),
                expected[0],
                expected[1],
                prior.truths()
            )));
        }
        let (truth, map) = (truth.as_standard_layout(), map.as_standard_layout());
        let weight = weight.as_standard_layout();
        // A standard layout is a slice.
        let (truth, map, weight) = (
            truth.as_slice().unwrap_or_default(),
            map.as_slice().unwrap_or_default(),
            weight.as_slice().unwrap_or_default(),
        );
        // One way into the pool for all passes.
        rayon::scope(|_| {
            self.look_at_map(prior, map, n);
            self.look_at_truths(prior, truth, weight, n);
            self.look_back(prior, map, n);
        });
        let errors_m = prior.prior_error_m().iter();
        self.evaluation.prior_error_m = errors_m.zip(weight).map(|(e, w)| e * w).sum();
        Ok(&self.evaluation)
    }

    /// M, and what the truths will ask of it.
    fn look_at_map(&mut self, prior: &PriorOperator, g: &[T], n: usize) {
        let (tiles, vectors) = (tiles(n), self.vectors);
        let order = prior.order(Asking::Candidates);
        self.map
            .resize(prior.candidates() * tiles, [T::default(); LANES]);
        let chunks = self.map.par_chunks_mut(CHUNK * tiles).enumerate();
        chunks.for_each(|(chunk, rows)| {
            let mut highs = vec![T::ONE; tiles];
            vectors.run(|| {
                for (i, row) in rows.chunks_mut(tiles).enumerate() {
                    let g = of_place(g, n, order, chunk * CHUNK + i);
                    let factors = Factors::new(g);
                    high(g, &mut highs);
                    for (row, &high) in row.iter_mut().zip(&highs) {
                        *row = factors.outcomes(high);
                    }
                }
            });
        });
        let rows = Rows {
            tiles,
            by_error: &self.map,
            plain: None,
        };
        prior.prepare(Asking::Truths, &rows, &mut self.of_map, vectors);
    }

    /// ē, E, ∂E/∂g of the truths, and U for the way back.
    fn look_at_truths(&mut self, prior: &PriorOperator, g: &[T], weight: &[f64], n: usize) {
        let (tiles, vectors) = (tiles(n), self.vectors);
        let order = prior.order(Asking::Truths);
        let truths = prior.truths();
        let nothing = [T::default(); LANES];
        self.by_error.resize(truths * tiles, nothing);
        self.plain.resize(truths * tiles, nothing);
        self.parts_m.resize(truths.div_ceil(CHUNK), 0.0);
        let (of_map, rows) = (
            &self.of_map,
            Rows {
                tiles,
                by_error: &self.map,
                plain: None,
            },
        );
        let (by_error, plain, parts_m) = (&mut self.by_error, &mut self.plain, &mut self.parts_m);
        let gradient = &mut self.evaluation.truth_gradient;
        fill(gradient, &mut self.in_order, (truths, n), order, |out| {
            let chunks = by_error
                .par_chunks_mut(CHUNK * tiles)
                .zip(plain.par_chunks_mut(CHUNK * tiles))
                .zip(out.par_chunks_mut(CHUNK * n))
                .zip(parts_m.par_iter_mut())
                .enumerate();
            chunks.for_each(|(chunk, (((by_error, plain), out), part_m))| {
                let mut room = Room::new(tiles);
                let chunk = Truths {
                    first: chunk * CHUNK,
                    g,
                    n,
                    order,
                    weight,
                };
                *part_m = vectors
                    .run(|| chunk.look(prior, &rows, of_map, &mut room, by_error, plain, out));
            });
        });
        self.evaluation.posterior_error_m = self.parts_m.iter().sum();
        let rows = Rows {
            tiles,
            by_error: &self.by_error,
            plain: Some(&self.plain),
        };
        prior.prepare(Asking::Candidates, &rows, &mut self.of_truths, vectors);
    }

    /// ∂E/∂M and with it ∂E/∂g of the map's places.
    fn look_back(&mut self, prior: &PriorOperator, g: &[T], n: usize) {
        let (tiles, vectors) = (tiles(n), self.vectors);
        let order = prior.order(Asking::Candidates);
        let rows = Rows {
            tiles,
            by_error: &self.by_error,
            plain: Some(&self.plain),
        };
        let of_truths = &self.of_truths;
        let gradient = &mut self.evaluation.map_gradient;
        let shape = (prior.candidates(), n);
        fill(gradient, &mut self.in_order, shape, order, |out| {
            let chunks = out.par_chunks_mut(CHUNK * n).enumerate();
            chunks.for_each(|(chunk, out)| {
                let (first, count) = (chunk * CHUNK, out.len() / n);
                let mut room = Room::new(tiles);
                vectors.run(|| {
                    for tile in 0..tiles {
                        let places = first..first + count;
                        let asking = Asking::Candidates;
                        prior.answer(asking, places, tile, &rows, of_truths, &mut room.answers);
                        for i in 0..count {
                            let slope = &mut room.slope[i * tiles + tile];
                            for l in 0..LANES {
                                let (by_error, plain) =
                                    (room.answers.by_error[i][l], room.answers.plain[i][l]);
                                slope[l] = T::of(by_error - plain);
                            }
                        }
                    }
                    for (i, out) in out.chunks_exact_mut(n).enumerate() {
                        let g = of_place(g, n, order, first + i);
                        high(g, &mut room.highs[..tiles]);
                        let slope = &room.slope[i * tiles..(i + 1) * tiles];
                        Factors::new(g).gradient(g, &room.highs[..tiles], slope, &mut room.open, out);
                    }
                });
            });
        });
    }
}

/// A chunk of truths in order.
struct Truths<'a, T> {
    first: usize,
    g: &'a [T],
    n: usize,
    order: Option<&'a [usize]>,
    weight: &'a [f64],
}

/// What a chunk of places needs besides its input and output.
struct Room<T> {
    answers: Answers,
    /// ∂E/∂P, `[place, tile]`.
    slope: Vec<Lanes<T>>,
    /// `[place, tile]`.
    highs: Vec<T>,
    /// `[tile]`.
    open: Vec<T>,
}

impl<T: Real> Room<T> {
    fn new(tiles: usize) -> Self {
        Self {
            answers: Answers::new(),
            slope: vec![[T::default(); LANES]; CHUNK * tiles],
            highs: vec![T::default(); CHUNK * tiles],
            open: vec![T::default(); tiles],
        }
    }
}

impl<T: Real> Truths<'_, T> {
    /// Their part of E; U, U∘ē and ∂E/∂g.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "three inputs, three outputs and room to work in")]
    fn look(
        &self,
        prior: &PriorOperator,
        rows: &Rows<T>,
        of_map: &Scratch<T>,
        room: &mut Room<T>,
        by_error: &mut [Lanes<T>],
        plain: &mut [Lanes<T>],
        out: &mut [T],
    ) -> f64 {
        let (tiles, count) = (rows.tiles, out.len() / self.n);
        let mut error_m = [0.0; LANES];
        for (i, highs) in room.highs.chunks_exact_mut(tiles).take(count).enumerate() {
            high(of_place(self.g, self.n, self.order, self.first + i), highs);
        }
        for tile in 0..tiles {
            let places = self.first..self.first + count;
            prior.answer(Asking::Truths, places, tile, rows, of_map, &mut room.answers);
            for i in 0..count {
                let truth = number(self.order, self.first + i);
                let weight = T::of(self.weight[truth]);
                let least = SMALLEST_PROBABILITY * prior.window_size(truth).max(1) as f64;
                let least = T::of(least);
                let g = of_place(self.g, self.n, self.order, self.first + i);
                let p = Factors::new(g).outcomes(room.highs[i * tiles + tile]);
                let row = i * tiles + tile;
                let (by_error, plain) = (&mut by_error[row], &mut plain[row]);
                let (n, d) = (&room.answers.by_error[i], &room.answers.plain[i]);
                let slope = &mut room.slope[row];
                for l in 0..LANES {
                    let inverse = T::ONE / at_least(T::of(d[l]), least);
                    let expected = at_least(T::of(n[l]), T::default()) * inverse; // ē
                    slope[l] = weight * expected; // ∂E/∂P
                    by_error[l] = weight * p[l] * inverse; // U
                    plain[l] = by_error[l] * expected;
                    error_m[l] += (p[l] * slope[l]).wide();
                }
            }
        }
        for (i, out) in out.chunks_exact_mut(self.n).enumerate() {
            let g = of_place(self.g, self.n, self.order, self.first + i);
            let of_tiles = i * tiles..(i + 1) * tiles;
            let (high, slope) = (&room.highs[of_tiles.clone()], &room.slope[of_tiles]);
            Factors::new(g).gradient(g, high, slope, &mut room.open, out);
        }
        super::lanes::total(&error_m)
    }
}

/// The caller's number of place `place` in order.
#[inline(always)]
fn number(order: Option<&[usize]>, place: usize) -> usize {
    match order {
        Some(order) => order[place],
        None => place,
    }
}

/// Activations of place `place` in order.
#[inline(always)]
fn of_place<'a, T>(g: &'a [T], n: usize, order: Option<&[usize]>, place: usize) -> &'a [T] {
    let k = number(order, place);
    &g[k * n..(k + 1) * n]
}

/// Lets a gradient be filled in order, and puts it into the caller's.
fn fill<T: Real>(
    gradient: &mut Array2<T>,
    room: &mut Vec<T>,
    shape: (usize, usize),
    order: Option<&[usize]>,
    in_order: impl FnOnce(&mut [T]),
) {
    if gradient.dim() != shape {
        *gradient = Array2::from_elem(shape, T::default());
    }
    let out = gradient.as_slice_mut().unwrap_or_default(); // a standard layout is a slice
    match order {
        None => in_order(out),
        Some(order) => {
            room.resize(out.len(), T::default());
            in_order(room);
            let n = shape.1.max(1);
            for (&k, row) in order.iter().zip(room.chunks_exact(n)) {
                out[k * n..(k + 1) * n].copy_from_slice(row);
            }
        }
    }
}

/// Equal weights P(ξ*) for `truths` places.
pub fn equal_weights(truths: usize) -> Array1<f64> {
    Array1::from_elem(truths, 1.0 / truths.max(1) as f64)
}

#[cfg(test)]
mod dense_tests;
#[cfg(test)]
mod tests;
