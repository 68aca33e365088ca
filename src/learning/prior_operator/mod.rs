//! Bel and A = e ∘ Bel as operators: the two big matrices of the objective, never stored as such.
//!
//! Row ξ* of Bel is the prior belief of a robot that is truly at ξ*: uniform over the candidates that the prior
//! admits. Row ξ* of A is the same times e(ξ*, ξ). All the objective needs of them are two products and their
//! transposes, and the shape of the prior says how to get them cheaply:
//!
//! | prior | product | cost |
//! |---|---|---|
//! | any, along a route | running sums: a window is a contiguous range, e is a difference of coordinates | (T + C)·F |
//! | window, in the plane | sparse rows | T·window·F |
//! | global, in the plane | blocks of distances, made and multiplied in turn | T·C·F |
//!
//! with T truths, C candidates, F = 2^n outcomes. All sums are f64 and in a fixed order.

mod everywhere;
mod route_windows;
mod sparse_rows;

use crate::belief::{Places, Uncertainty};
use ndarray::{Array1, Array2, ArrayView2, Axis};

use everywhere::Everywhere;
use route_windows::RouteWindows;
use sparse_rows::SparseRows;

/// The prior beliefs of all truths over all candidates.
pub struct PriorOperator {
    shape: Shape,
    prior_error_m: Array1<f64>,
}

/// What the prior and the places allow.
enum Shape {
    /// Along a route.
    Route(RouteWindows),
    /// In the plane, within a window, or with an error of one's own.
    Sparse(SparseRows),
    /// In the plane, anywhere.
    Everywhere(Everywhere),
}

impl PriorOperator {
    /// The prior `uncertainty` of robots truly at `truths`, over `candidates`.
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
            (_, _, Uncertainty::Global) => {
                Self::of(Shape::Everywhere(Everywhere::new(truths, candidates)))
            }
            _ => Self::with_error(uncertainty, truths, candidates, |t, c| {
                truths.distance_m(t, candidates, c)
            }),
        }
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
        Self::of(Shape::Sparse(SparseRows::new(
            uncertainty,
            truths,
            candidates,
            error_m,
        )))
    }

    fn of(shape: Shape) -> Self {
        let mut operator = Self {
            shape,
            prior_error_m: Array1::default(0),
        };
        let ones = Array2::ones((operator.candidates(), 1));
        operator.prior_error_m = operator.apply(ones.view()).0.remove_axis(Axis(1));
        operator
    }

    /// N = A·M and D = Bel·M, both `[truth, outcome]`, of M `[candidate, outcome]`.
    ///
    /// D[ξ*, f] is P(f) under the prior of a robot at ξ* (Thrun 1998, eq. 37); N/D its expected error after sensing f.
    pub fn apply(&self, map: ArrayView2<f64>) -> (Array2<f64>, Array2<f64>) {
        match &self.shape {
            Shape::Route(route) => route.apply(map),
            Shape::Sparse(rows) => rows.apply(map),
            Shape::Everywhere(all) => all.apply(map),
        }
    }

    /// Aᵀ·U − Belᵀ·V, `[candidate, outcome]`, of U and V `[truth, outcome]`.
    pub fn apply_transposed(&self, u: ArrayView2<f64>, v: ArrayView2<f64>) -> Array2<f64> {
        match &self.shape {
            Shape::Route(route) => route.apply_transposed(u, v),
            Shape::Sparse(rows) => rows.apply_transposed(u, v),
            Shape::Everywhere(all) => all.apply_transposed(u, v),
        }
    }

    /// Prior error of every truth in metres, Σ_ξ e(ξ*, ξ)·Bel(ξ) (Thrun 1998, eq. 21).
    pub fn prior_error_m(&self) -> &Array1<f64> {
        &self.prior_error_m
    }

    /// Candidates that the prior of every truth admits.
    pub fn window_sizes(&self) -> Vec<usize> {
        match &self.shape {
            Shape::Route(route) => route.window_sizes(),
            Shape::Sparse(rows) => rows.window_sizes(),
            Shape::Everywhere(all) => all.window_sizes(),
        }
    }

    fn candidates(&self) -> usize {
        match &self.shape {
            Shape::Route(route) => route.candidates(),
            Shape::Sparse(rows) => rows.candidates(),
            Shape::Everywhere(all) => all.candidates(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn window_sizes_come_in_the_order_of_the_truths() {
        let (truths, candidates) = ([9.0, 0.0, 5.0], [5.5, 0.5, 4.5, 5.0]);
        let window: Uncertainty = "1m".parse().unwrap();
        let route = PriorOperator::new(
            window,
            &Places::Route(truths.to_vec()),
            &Places::Route(candidates.to_vec()),
        );
        assert_eq!(route.window_sizes(), [0, 1, 3]);
        let plane =
            |x: &[f64]| Places::Plane(x.iter().map(|&x_m| Pose::new(x_m, 0.0, 0.0)).collect());
        let plane = PriorOperator::new(window, &plane(&truths), &plane(&candidates));
        assert_eq!(plane.window_sizes(), [0, 1, 3]);
    }
}
