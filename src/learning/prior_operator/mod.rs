//! Bel and A = e ∘ Bel as operators: the two big matrices of the objective, never stored as such.
//!
//! Row ξ* of Bel is the prior belief of a robot that is truly at ξ*: uniform over the candidates that the prior
//! admits. Row ξ* of A is the same times e(ξ*, ξ). As every belief is uniform, all that the objective needs are sums
//! over the admitted places, weighted by e and unweighted, for truths over candidates (`apply`) and for
//! candidates over truths (`apply_transpose`); and the shape of the prior says how to
//! get them cheaply:
//!
//! | prior | sums | cost |
//! |---|---|---|
//! | any, along a route | a window is a contiguous range, e a difference of coordinates: block sums | (T + C)·F |
//! | window, in the plane | sparse rows | T·window·F |
//! | global, in the plane | all distances, kept or made block by block | T·C·F |
//! | global, in the plane, many places | distances between cells | (T + C)·F + cells²·F |
//!
//! with T truths, C candidates, F = 2^n outcomes. All orders of summation are fixed, whatever the number of threads.

mod accumulate;
mod all_pairs;
mod block_sums;
mod cells;
mod mean_errors;
mod route_windows;
mod rows;
mod shape;
mod sparse_rows;
mod window_sums;
mod workspace;

use super::lanes::Real;
use crate::{
    belief::{Places, Uncertainty},
    error::{Error, Result},
    simd::InstructionSet,
};
use all_pairs::AllPairs;
use cells::Cells;
use mean_errors::mean_errors_m;
use ndarray::Array1;
use route_windows::RouteWindows;
use shape::Shape;
use sparse_rows::SparseRows;
use std::ops::Range;

pub(super) use accumulate::Accumulator;
pub(super) use rows::{CHUNK, Rows};
pub(super) use workspace::{PriorSums, Scratch};

/// More places than this in the plane, and a global prior takes them by cells.
pub const MAX_EXACT_PLACES: usize = 5000;

/// Side of these cells, in metres. No error e(ξ*, ξ) is off by more than their diagonal, 0.35 m.
pub const CELL_SIDE_M: f64 = 0.25;

/// The prior beliefs of all truths over all candidates.
pub struct PriorOperator {
    shape: Shape,
    truths: usize,
    candidates: usize,
    window_sizes: Vec<usize>,
    prior_error_m: Array1<f64>,
}

impl PriorOperator {
    /// The prior `uncertainty` of robots truly at `truths`, over `candidates`.
    ///
    /// Exact, but for a global prior over more than [`MAX_EXACT_PLACES`] places in the plane: those are taken by cells
    /// of [`CELL_SIDE_M`] as in [`everywhere_in_cells`](Self::everywhere_in_cells).
    pub fn new(uncertainty: Uncertainty, truths: &Places, candidates: &Places) -> Self {
        match (truths, candidates, uncertainty) {
            (Places::Route(truths), Places::Route(candidates), _) => {
                let half_width_m = match uncertainty {
                    Uncertainty::Global => f64::INFINITY,
                    Uncertainty::Window { half_width_m, .. } => half_width_m,
                };
                Self::from_shape(Shape::Route(RouteWindows::new(
                    half_width_m,
                    truths,
                    candidates,
                )))
            }
            (Places::Plane(t), Places::Plane(c), Uncertainty::Global) => {
                if t.len().max(c.len()) > MAX_EXACT_PLACES {
                    Self::from_shape(Shape::Cells(Cells::new(t, c, CELL_SIDE_M)))
                } else {
                    Self::from_shape(Shape::AllPairs(AllPairs::new(t, c)))
                }
            }
            _ => Self::from_shape(Shape::Sparse(SparseRows::within(
                uncertainty,
                truths,
                candidates,
            ))),
        }
    }

    /// A global prior in the plane over all distances exactly, however many places there are. Up to 25 million
    /// distances are kept; more are made anew in every evaluation.
    ///
    /// # Errors
    /// Where the places lie along a route: there [`new`](Self::new) is exact and cheap.
    pub fn everywhere(truths: &Places, candidates: &Places) -> Result<Self> {
        let (truths, candidates) = in_the_plane(truths, candidates)?;
        Ok(Self::from_shape(Shape::AllPairs(AllPairs::new(
            truths, candidates,
        ))))
    }

    /// A global prior in the plane by square cells of `side_m` metres (Thrun 1998, 4.4.2 item 2): e(ξ*, ξ) is taken
    /// between the middles of the cells in which ξ* and ξ lie, so the cost grows with the number of places and not with
    /// its square. No e is off by more than the diagonal of a cell, √2·`side_m`, and so no expected error is.
    ///
    /// ```
    /// use ballmark::{belief::Places, geometry::Pose, learning::prior_operator::PriorOperator};
    /// let places = Places::Plane(vec![Pose::new(0.1, 0.0, 0.0), Pose::new(9.9, 0.0, 1.5)]);
    /// let prior = PriorOperator::everywhere_in_cells(&places, &places, 0.5)?;
    /// assert!((prior.prior_error_m()[0] - 4.9).abs() < 0.5 * 2f64.sqrt());
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where the places lie along a route, or `side_m` isn't a positive number.
    pub fn everywhere_in_cells(truths: &Places, candidates: &Places, side_m: f64) -> Result<Self> {
        let (truths, candidates) = in_the_plane(truths, candidates)?;
        if !(side_m.is_finite() && side_m > 0.0) {
            return Err(Error::usage(format!(
                "cells of {side_m} m: expected a positive side"
            )));
        }
        Ok(Self::from_shape(Shape::Cells(Cells::new(
            truths, candidates, side_m,
        ))))
    }

    /// The same with another error than the straight way or the way along the route: `error_m(truth, candidate)` is
    /// e(ξ*, ξ), such as the way around walls, or a distance with a weight on the turn. Every admitted pair is kept,
    /// also under a global prior.
    ///
    /// ```
    /// use ballmark::{belief::Places, geometry::Pose, learning::prior_operator::PriorOperator};
    /// let places = Places::Plane(vec![Pose::new(0.0, 0.0, 0.0), Pose::new(1.0, 0.0, 1.5)]);
    /// let with_turn = |a, b| places.distance_m(a, &places, b) + 0.5 * places.turn_rad(a, &places, b);
    /// let prior = PriorOperator::with_error("global".parse()?, &places, &places, with_turn);
    /// assert_eq!(prior.prior_error_m().to_vec(), [0.875, 0.875]); // half of 1 m + 0.75
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn with_error(
        uncertainty: Uncertainty,
        truths: &Places,
        candidates: &Places,
        error_m: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        Self::from_shape(Shape::Sparse(SparseRows::with_error(
            uncertainty,
            truths,
            candidates,
            error_m,
        )))
    }

    fn from_shape(shape: Shape) -> Self {
        let (truths, candidates) = shape.counts();
        Self {
            truths,
            candidates,
            window_sizes: shape.window_sizes(),
            prior_error_m: mean_errors_m(&shape),
            shape,
        }
    }

    /// Prior error of every truth in metres, Σ_ξ e(ξ*, ξ)·Bel(ξ) (Thrun 1998, eq. 21).
    pub fn prior_error_m(&self) -> &Array1<f64> {
        &self.prior_error_m
    }

    /// Candidates that the prior of every truth admits.
    pub fn window_sizes(&self) -> Vec<usize> {
        self.window_sizes.clone()
    }

    /// Number of truths.
    pub fn truths(&self) -> usize {
        self.truths
    }

    /// Number of candidates.
    pub fn candidates(&self) -> usize {
        self.candidates
    }

    /// The same as a slice.
    pub(super) fn prior_errors_m(&self) -> &[f64] {
        self.prior_error_m.as_slice().unwrap_or_default() // a standard layout is a slice
    }

    /// How many candidates the prior of one truth admits.
    pub(super) fn window_size(&self, truth: usize) -> usize {
        self.window_sizes[truth]
    }

    /// The order in which rows of the truths must come; `None`: as they are.
    pub(super) fn truth_order(&self) -> Option<&[usize]> {
        self.shape.truth_order()
    }

    /// The order in which rows of the candidates must come; `None`: as they are.
    pub(super) fn candidate_order(&self) -> Option<&[usize]> {
        self.shape.candidate_order()
    }

    /// One for every chunk of the map's rows, to be given them before [`prepare`](Self::prepare).
    pub(super) fn map_accumulators<'a, T>(
        &'a self,
        tiles: usize,
        scratch: &'a mut Scratch<T>,
    ) -> Vec<Accumulator<'a, 2>> {
        self.shape.map_accumulators(tiles, scratch)
    }

    /// One for every chunk of the truths' rows, to be given them before [`prepare_transpose`](Self::prepare_transpose).
    pub(super) fn truth_accumulators<'a, T>(
        &'a self,
        tiles: usize,
        scratch: &'a mut Scratch<T>,
    ) -> Vec<Accumulator<'a, 3>> {
        self.shape.truth_accumulators(tiles, scratch)
    }

    /// What [`apply`](Self::apply) needs of the map's rows as a whole.
    pub(super) fn prepare<T: Real>(
        &self,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        instructions: InstructionSet,
    ) {
        self.shape.prepare(rows, scratch, instructions);
    }

    /// What [`apply_transpose`](Self::apply_transpose) needs of the truths' rows as a whole.
    pub(super) fn prepare_transpose<T: Real>(
        &self,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        instructions: InstructionSet,
    ) {
        self.shape.prepare_transpose(rows, scratch, instructions);
    }

    /// A·rows and Bel·rows but for the height of each belief: Σ e·rows and Σ rows over the candidates that the priors of
    /// `truths` admit, numbers in their order and at most [`CHUNK`] of them, one tile of the map's rows.
    #[inline(always)]
    pub(super) fn apply<T: Real>(
        &self,
        truths: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        self.shape.apply(truths, tile, rows, scratch, sums);
    }

    /// Aᵀ·rows and Belᵀ·rows likewise: Σ e·rows and Σ rows over the truths whose priors admit `candidates`, one tile of
    /// the truths' rows, whose weighted and unweighted rows differ.
    #[inline(always)]
    pub(super) fn apply_transpose<T: Real>(
        &self,
        candidates: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        scratch: &Scratch<T>,
        sums: &mut PriorSums,
    ) {
        let shape = &self.shape;
        shape.apply_transpose(candidates, tile, rows, scratch, sums);
    }
}

fn in_the_plane<'a>(
    truths: &'a Places,
    candidates: &'a Places,
) -> Result<(&'a [crate::geometry::Pose], &'a [crate::geometry::Pose])> {
    match (truths, candidates) {
        (Places::Plane(truths), Places::Plane(candidates)) => Ok((truths, candidates)),
        _ => Err(Error::work(
            "a global prior over distances: places lie along a route; expected poses in the plane",
        )),
    }
}

#[cfg(test)]
mod tests;
