//! The objective in dense matrices, line by line as the [module above](super) writes it: slow, in `f64`, to be read beside
//! the paper and to test the fast evaluation with.
//!
//! ```
//! use ballmark::{belief::{Places, Uncertainty}, learning::{objective::{self, reference}, prior_operator::PriorOperator}};
//! use ndarray::array;
//! let places = Places::Route(vec![0.0, 2.0, 3.0, 7.0]);
//! let (g, weight) = (array![[0.9, 0.2], [0.6, 0.4], [0.3, 0.7], [0.1, 0.8]], objective::equal_weights(4));
//! for prior in ["3m", "global"] {
//!     let uncertainty: Uncertainty = prior.parse()?;
//!     let (bel, e_m) = reference::prior(uncertainty, &places, &places);
//!     let dense = reference::evaluate(&bel, &e_m, &g, &g, &weight);
//!
//!     let operator = PriorOperator::new(uncertainty, &places, &places);
//!     let fast = objective::evaluate(&operator, g.view(), g.view(), weight.view())?;
//!     assert!((dense.posterior_error_m - fast.posterior_error_m).abs() < 1e-12);
//!     assert!((dense.prior_error_m - fast.prior_error_m).abs() < 1e-12);
//!     assert!((&dense.map_gradient - &fast.map_gradient).iter().all(|off| off.abs() < 1e-12));
//! }
//! # Ok::<(), ballmark::Error>(())
//! ```

use super::{Evaluation, SMALLEST_PROBABILITY};
use crate::belief::{Places, Uncertainty};
use ndarray::{Array1, Array2, Axis};

/// E, and ∂E/∂g of the truths and of the map, from Bel and e `[truth, candidate]`, activations of the truths
/// `[truth, feature]` and of the map `[candidate, feature]`, and weights of the truths that sum to 1.
///
/// # Panics
/// Where the shapes do not fit one another.
pub fn evaluate(
    bel: &Array2<f64>,
    e_m: &Array2<f64>,
    truth: &Array2<f64>,
    map: &Array2<f64>,
    weight: &Array1<f64>,
) -> Evaluation {
    let w = weight.view().insert_axis(Axis(1)); // [truth, 1]
    let p = outcomes(truth); // [truth, outcome]
    let m = outcomes(map); // [candidate, outcome]
    let a = e_m * bel; // A = e ∘ Bel

    let n = a.dot(&m); // N = A·M: [truth, outcome]
    let d = bel.dot(&m).mapv(|d| d.max(SMALLEST_PROBABILITY)); // D = Bel·M = P(f) (eq. 37)
    let expected_m = n / &d; // ē = N/D
    let posterior_error_m = (&w * &p * &expected_m).sum(); // E (eq. 42)

    let u = &w * &p / &d; // U = w ∘ P/D
    let slope_p = &w * &expected_m; // ∂E/∂P = w ∘ N/D
    let slope_m = a.t().dot(&u) - bel.t().dot(&(&u * &expected_m)); // ∂E/∂M = Aᵀ·U − Belᵀ·(U ∘ ē)

    Evaluation {
        prior_error_m: (&w * &a).sum(), // Σ_k* w_k* Σ_k A[k*, k] (eq. 21)
        posterior_error_m,
        truth_gradient: gradient(&slope_p, truth),
        map_gradient: gradient(&slope_m, map),
    }
}

/// Bel and e in metres of a prior, `[truth, candidate]`: each row of Bel is uniform over what the prior admits.
pub fn prior(
    uncertainty: Uncertainty,
    truths: &Places,
    candidates: &Places,
) -> (Array2<f64>, Array2<f64>) {
    let shape = (truths.len(), candidates.len());
    let admitted = Array2::from_shape_fn(shape, |(t, c)| {
        f64::from(u8::from(uncertainty.admits(truths, t, candidates, c)))
    });
    let sizes = admitted.sum_axis(Axis(1)).insert_axis(Axis(1));
    let e_m = Array2::from_shape_fn(shape, |(t, c)| truths.distance_m(t, candidates, c));
    (admitted / sizes.mapv(|size| size.max(1.0)), e_m)
}

/// P(f | s) = Π_i P(f_i | s) of all 2^n outcomes (eq. 33), `[place, outcome]`: bit i of an outcome's number is f_i.
pub fn outcomes(g: &Array2<f64>) -> Array2<f64> {
    let (places, n) = g.dim();
    Array2::from_shape_fn((places, 1 << n), |(k, f)| {
        (0..n).map(|i| probability(g[[k, i]], f, i)).product()
    })
}

/// ∂E/∂g_i = Σ_f ∂E/∂P[f] · (2 δ(f_i, 1) − 1) · Π_{j≠i} P(f_j | s) (eq. 40), `[place, feature]`.
fn gradient(slope: &Array2<f64>, g: &Array2<f64>) -> Array2<f64> {
    let n = g.ncols();
    Array2::from_shape_fn(g.raw_dim(), |(k, i)| {
        let sign = |f: usize| if f >> i & 1 == 1 { 1.0 } else { -1.0 };
        let others = |f: usize| {
            let others = (0..n).filter(|&j| j != i);
            others
                .map(|j| probability(g[[k, j]], f, j))
                .product::<f64>()
        };
        (0..1 << n)
            .map(|f| slope[[k, f]] * sign(f) * others(f))
            .sum()
    })
}

/// P(f_i | s) (eq. 32), given g_i(s) and the outcome's number.
fn probability(g: f64, f: usize, i: usize) -> f64 {
    if f >> i & 1 == 1 { g } else { 1.0 - g }
}
