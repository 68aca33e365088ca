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
mod passes;

use super::{
    lanes::{Lanes, Real, Vectors},
    prior_operator::{Asking, CHUNK, PriorOperator, Rows, Scratch},
};
use crate::error::{Error, Result};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2};
use outcomes::tiles;
use passes::{Activations, ChunkWorkspace, ExpectedErrorPass, MapGradientPass, Outcomes};
use rayon::prelude::*;

/// Most features that 2^n outcomes allow.
pub const MOST_FEATURES: usize = 12;

/// P(f) under a prior counts as at least this: saturated features would give 0/0. An outcome this rare adds at most its
/// probability times the extent to the error.
const SMALLEST_PROBABILITY: f64 = 1e-12;

/// Parts that every thread takes of a pass.
const PARTS_A_THREAD: usize = 2;

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
    weighted: Vec<Lanes<T>>,
    unweighted: Vec<Lanes<f64>>,
    of_map: Scratch<T>,
    of_truths: Scratch<T>,
    workspaces: Vec<ChunkWorkspace<T>>,
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
            weighted: Vec::new(),
            unweighted: Vec::new(),
            of_map: Scratch::default(),
            of_truths: Scratch::default(),
            workspaces: Vec::new(),
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
        let of = |g, side| Activations {
            g,
            features: n,
            order: prior.order(side),
        };
        let (truth, map) = (of(truth, Asking::Truths), of(map, Asking::Candidates));
        // One way into the pool for all passes.
        rayon::scope(|_| {
            self.map_outcomes(prior, map);
            self.expected_error(prior, truth, weight);
            self.map_gradient_pass(prior, map);
        });
        let errors_m = prior.prior_error_m().iter();
        self.evaluation.prior_error_m = errors_m.zip(weight).map(|(e, w)| e * w).sum();
        Ok(&self.evaluation)
    }

    /// M, and what the truths will ask of it.
    fn map_outcomes(&mut self, prior: &PriorOperator, map: Activations<T>) {
        let (tiles, vectors) = (tiles(map.features), self.vectors);
        let part = self.part_of(prior.candidates(), tiles);
        self.map
            .resize(prior.candidates() * tiles, Lanes::<T>::default());
        let mut to_take_in = prior.take_in_map(tiles, &mut self.of_map);
        let parts = self.workspaces.par_iter_mut();
        let parts = parts
            .zip(self.map.par_chunks_mut(part * CHUNK * tiles))
            .zip(to_take_in.par_chunks_mut(part));
        parts
            .enumerate()
            .for_each(|(number, ((workspace, out), to_take_in))| {
                let chunks = out.chunks_mut(CHUNK * tiles).zip(to_take_in);
                for (chunk, (out, accumulate)) in (number * part..).zip(chunks) {
                    vectors.run(Outcomes {
                        activations: map,
                        first: chunk * CHUNK,
                        highs: workspace.highs_of_one(),
                        out,
                    });
                    accumulate.chunk(&rows_of(tiles, out, None), vectors);
                }
            });
        drop(to_take_in);
        let rows = rows_of(tiles, &self.map, None);
        prior.prepare(Asking::Truths, &rows, &mut self.of_map, vectors);
    }

    /// ē, E, ∂E/∂g of the truths, and U for the way back.
    fn expected_error(&mut self, prior: &PriorOperator, truth: Activations<T>, weight: &[f64]) {
        let (n, vectors) = (truth.features, self.vectors);
        let (tiles, truths) = (tiles(n), prior.truths());
        let part = self.part_of(truths, tiles);
        self.weighted.resize(truths * tiles, Lanes::<T>::default());
        self.unweighted.resize(truths * tiles, Lanes::default());
        self.parts_m.resize(truths.div_ceil(CHUNK), 0.0);
        let (rows, scratch) = (rows_of(tiles, &self.map, None), &self.of_map);
        let mut to_take_in = prior.take_in_truths(tiles, &mut self.of_truths);
        let (weighted, unweighted, parts_m) =
            (&mut self.weighted, &mut self.unweighted, &mut self.parts_m);
        let (workspaces, gradient) = (&mut self.workspaces, &mut self.evaluation.truth_gradient);
        fill(
            gradient,
            &mut self.in_order,
            (truths, n),
            truth.order,
            |gradient| {
                let parts = workspaces
                    .par_iter_mut()
                    .zip(weighted.par_chunks_mut(part * CHUNK * tiles))
                    .zip(unweighted.par_chunks_mut(part * CHUNK * tiles))
                    .zip(gradient.par_chunks_mut(part * CHUNK * n))
                    .zip(parts_m.par_chunks_mut(part))
                    .zip(to_take_in.par_chunks_mut(part))
                    .enumerate();
                parts.for_each(
                    |(
                        number,
                        (((((workspace, weighted), unweighted), gradient), parts_m), to_take_in),
                    )| {
                        let chunks = weighted
                            .chunks_mut(CHUNK * tiles)
                            .zip(unweighted.chunks_mut(CHUNK * tiles))
                            .zip(gradient.chunks_mut(CHUNK * n))
                            .zip(parts_m)
                            .zip(to_take_in);
                        for (chunk, ((((weighted, unweighted), gradient), part_m), accumulate)) in
                            (number * part..).zip(chunks)
                        {
                            *part_m = vectors.run(ExpectedErrorPass {
                                prior,
                                activations: truth,
                                weight,
                                first: chunk * CHUNK,
                                rows: &rows,
                                scratch,
                                workspace,
                                weighted: &mut *weighted,
                                unweighted: &mut *unweighted,
                                gradient,
                            });
                            accumulate.chunk(&rows_of(tiles, weighted, Some(unweighted)), vectors);
                        }
                    },
                );
            },
        );
        drop(to_take_in);
        self.evaluation.posterior_error_m = self.parts_m.iter().sum();
        let rows = rows_of(tiles, &self.weighted, Some(&self.unweighted));
        prior.prepare(Asking::Candidates, &rows, &mut self.of_truths, vectors);
    }

    /// ∂E/∂M and with it ∂E/∂g of the map's places.
    fn map_gradient_pass(&mut self, prior: &PriorOperator, map: Activations<T>) {
        let (n, vectors) = (map.features, self.vectors);
        let tiles = tiles(n);
        let part = self.part_of(prior.candidates(), tiles);
        let rows = rows_of(tiles, &self.weighted, Some(&self.unweighted));
        let scratch = &self.of_truths;
        let (workspaces, gradient) = (&mut self.workspaces, &mut self.evaluation.map_gradient);
        let shape = (prior.candidates(), n);
        fill(gradient, &mut self.in_order, shape, map.order, |gradient| {
            let parts = workspaces
                .par_iter_mut()
                .zip(gradient.par_chunks_mut(part * CHUNK * n));
            parts
                .enumerate()
                .for_each(|(number, (workspace, gradient))| {
                    for (chunk, gradient) in (number * part..).zip(gradient.chunks_mut(CHUNK * n)) {
                        vectors.run(MapGradientPass {
                            prior,
                            activations: map,
                            first: chunk * CHUNK,
                            rows: &rows,
                            scratch,
                            workspace,
                            gradient,
                        });
                    }
                });
        });
    }

    /// How many chunks a thread takes at once, with a room kept for each such part: a few parts a thread, since neither
    /// handing out work nor making room is free.
    fn part_of(&mut self, places: usize, tiles: usize) -> usize {
        let chunks = places.div_ceil(CHUNK);
        let part = chunks
            .div_ceil(PARTS_A_THREAD * rayon::current_num_threads())
            .max(1);
        self.workspaces
            .retain(|workspace| workspace.tiles() == tiles);
        if self.workspaces.len() < chunks.div_ceil(part) {
            self.workspaces
                .resize_with(chunks.div_ceil(part), || ChunkWorkspace::new(tiles));
        }
        part
    }
}

fn rows_of<'a, T>(
    tiles: usize,
    weighted: &'a [Lanes<T>],
    unweighted: Option<&'a [Lanes<f64>]>,
) -> Rows<'a, T> {
    Rows {
        tiles,
        weighted,
        unweighted,
    }
}

/// Lets a gradient be filled in order, and puts it into the caller's.
fn fill<T: Real>(
    gradient: &mut Array2<T>,
    workspace: &mut Vec<T>,
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
            workspace.resize(out.len(), T::default());
            in_order(workspace);
            let n = shape.1.max(1);
            for (&k, row) in order.iter().zip(workspace.chunks_exact(n)) {
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
