//! Bel and A = e ∘ Bel as operators: the two big matrices of the objective, never stored as such.
//!
//! Row ξ* of Bel is the prior belief of a robot that is truly at ξ*: uniform over the candidates that the prior
//! admits. Row ξ* of A is the same times e(ξ*, ξ). As every belief is uniform, all that the objective needs are sums
//! over the admitted places, weighed by e and unweighted, from truths over candidates and back; and the shape of the prior
//! says how to get them cheaply:
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
mod sparse_rows;

use super::lanes::{Lanes, Real, Vectors};
use crate::{
    belief::{Places, Uncertainty},
    error::{Error, Result},
};
use ndarray::Array1;
use std::ops::Range;

use accumulate::{TakeIn, to_take_in};
use all_pairs::AllPairs;
use block_sums::{BlockSums, Cut, Cuts};
use cells::Cells;
use route_windows::RouteWindows;
use sparse_rows::SparseRows;

/// More places than this in the plane, and a global prior takes them by cells.
pub const MOST_EXACT_PLACES: usize = 5000;

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

/// What the prior and the places allow.
enum Shape {
    /// Along a route.
    Route(RouteWindows),
    /// In the plane, within a window, or with an error of one's own.
    Sparse(SparseRows),
    /// In the plane, anywhere.
    AllPairs(AllPairs),
    /// In the plane, anywhere, by cells.
    Cells(Cells),
}

/// Whose places sum over the other side's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asking {
    Truths,
    Candidates,
}

/// What is summed: rows of the places asked about, in the operator's order, `[place, tile]` of sixteen outcomes each.
pub(super) struct Rows<'a, T> {
    /// Tiles of sixteen outcomes a place has.
    pub tiles: usize,
    /// Summed with weight e.
    pub weighted: &'a [Lanes<T>],
    /// Summed plainly; `None`: the same rows.
    pub unweighted: Option<&'a [Lanes<f64>]>,
}

/// What is known of the rows before any place asks; kept between evaluations.
#[derive(Debug, Default)]
pub(super) struct Scratch<T> {
    one: BlockSums<2>,
    two: BlockSums<3>,
    total: Vec<Lanes<f64>>,
    cell_rows: Vec<Lanes<T>>,
    cell_sums: Vec<Lanes<f64>>,
}

/// Places that ask together.
pub(super) const CHUNK: usize = 64;

/// Σ e·rows and Σ rows over the admitted places, of [`CHUNK`] places that ask, for one tile.
#[derive(Debug)]
pub(super) struct Answers {
    pub weighted: [Lanes<f64>; CHUNK],
    pub unweighted: [Lanes<f64>; CHUNK],
    cuts_of_one: Cuts<2>,
    cuts_of_two: Cuts<3>,
}

impl Answers {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self {
            weighted: [Lanes::default(); CHUNK],
            unweighted: [Lanes::default(); CHUNK],
            cuts_of_one: std::array::from_fn(|_| Cut::new()),
            cuts_of_two: std::array::from_fn(|_| Cut::new()),
        }
    }
}

impl PriorOperator {
    /// The prior `uncertainty` of robots truly at `truths`, over `candidates`.
    ///
    /// Exact, but for a global prior over more than [`MOST_EXACT_PLACES`] places in the plane: those are taken by cells
    /// of [`CELL_SIDE_M`] as in [`everywhere_in_cells`](Self::everywhere_in_cells).
    pub fn new(uncertainty: Uncertainty, truths: &Places, candidates: &Places) -> Self {
        match (truths, candidates, uncertainty) {
            (Places::Route(truths), Places::Route(candidates), _) => {
                let half_width_m = match uncertainty {
                    Uncertainty::Global => f64::INFINITY,
                    Uncertainty::Window { half_width_m, .. } => half_width_m,
                };
                Self::of(Shape::Route(RouteWindows::new(
                    half_width_m,
                    truths,
                    candidates,
                )))
            }
            (Places::Plane(t), Places::Plane(c), Uncertainty::Global) => {
                if t.len().max(c.len()) > MOST_EXACT_PLACES {
                    Self::of(Shape::Cells(Cells::new(t, c, CELL_SIDE_M)))
                } else {
                    Self::of(Shape::AllPairs(AllPairs::new(t, c)))
                }
            }
            _ => Self::of(Shape::Sparse(SparseRows::within(
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
        Ok(Self::of(Shape::AllPairs(AllPairs::new(truths, candidates))))
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
        Ok(Self::of(Shape::Cells(Cells::new(
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
        Self::of(Shape::Sparse(SparseRows::with_error(
            uncertainty,
            truths,
            candidates,
            error_m,
        )))
    }

    fn of(shape: Shape) -> Self {
        let (truths, candidates) = match &shape {
            Shape::Route(s) => s.counts(),
            Shape::Sparse(s) => s.counts(),
            Shape::AllPairs(s) => s.counts(),
            Shape::Cells(s) => s.counts(),
        };
        let window_sizes = match &shape {
            Shape::Route(s) => s.window_sizes(),
            Shape::Sparse(s) => s.window_sizes(),
            Shape::AllPairs(_) | Shape::Cells(_) => vec![candidates; truths],
        };
        let mut operator = Self {
            shape,
            truths,
            candidates,
            window_sizes,
            prior_error_m: Array1::zeros(truths),
        };
        operator.prior_error_m = operator.mean_errors();
        operator
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

    /// The order in which rows of a side's places must come; `None`: as they are.
    pub(super) fn order(&self, side: Asking) -> Option<&[usize]> {
        match &self.shape {
            Shape::Route(s) => s.order(side),
            _ => None,
        }
    }

    /// For every chunk of the map's rows, what is to be done with it before any truth asks.
    pub(super) fn take_in_map<'a, T>(
        &'a self,
        tiles: usize,
        scratch: &'a mut Scratch<T>,
    ) -> Vec<TakeIn<'a, 2>> {
        let chunks = self.candidates.div_ceil(CHUNK);
        to_take_in(
            self.asked_x_m(Asking::Truths),
            chunks,
            tiles,
            &mut scratch.one,
        )
    }

    /// For every chunk of the truths' rows, what is to be done with it before any candidate asks.
    pub(super) fn take_in_truths<'a, T>(
        &'a self,
        tiles: usize,
        scratch: &'a mut Scratch<T>,
    ) -> Vec<TakeIn<'a, 3>> {
        let chunks = self.truths.div_ceil(CHUNK);
        to_take_in(
            self.asked_x_m(Asking::Candidates),
            chunks,
            tiles,
            &mut scratch.two,
        )
    }

    fn asked_x_m(&self, asking: Asking) -> Option<&[f64]> {
        match &self.shape {
            Shape::Route(s) => Some(s.asked_x_m(asking)),
            _ => None,
        }
    }

    /// Makes ready for questions, once all chunks of rows are taken in.
    pub(super) fn prepare<T: Real>(
        &self,
        asking: Asking,
        rows: &Rows<T>,
        scratch: &mut Scratch<T>,
        vectors: Vectors,
    ) {
        match (&self.shape, rows.unweighted) {
            (Shape::Route(_), None) => scratch.one.close(rows.tiles),
            (Shape::Route(_), Some(_)) => scratch.two.close(rows.tiles),
            (Shape::Sparse(_), _) => {}
            (Shape::AllPairs(_), _) => all_pairs::add_up(rows, &mut scratch.total, vectors),
            (Shape::Cells(s), _) => s.prepare(asking, rows, scratch, vectors),
        }
    }

    /// Answers the places `asking`, numbers `places` in their order, at most [`CHUNK`] of them, from rows prepared.
    #[inline(always)]
    pub(super) fn answer<T: Real>(
        &self,
        asking: Asking,
        places: Range<usize>,
        tile: usize,
        rows: &Rows<T>,
        scratch: &Scratch<T>,
        answers: &mut Answers,
    ) {
        match &self.shape {
            Shape::Route(s) => {
                s.answer(
                    asking,
                    places,
                    tile,
                    rows,
                    &scratch.one,
                    &scratch.two,
                    answers,
                );
            }
            Shape::Sparse(s) => s.answer(asking, places, tile, rows, answers),
            Shape::AllPairs(s) => {
                let weighted = &mut answers.weighted[..places.len()];
                s.answer(asking, places.clone(), tile, rows, weighted);
                answers.unweighted[..places.len()].fill(scratch.total[tile]);
            }
            Shape::Cells(s) => s.answer(asking, places, tile, rows.tiles, scratch, answers),
        }
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
