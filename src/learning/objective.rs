//! The objective: the error a robot is expected to make after sensing, and its gradient (Thrun 1998, eq. 36–43).
//!
//! With P[k, f] = Π_i P(f_i | s_k) the truth's outcomes, M the same of the map's places, and the prior as the operators
//! Bel and A = e ∘ Bel,
//!
//! ```text
//! N = A·M      D = Bel·M      E = Σ_k* w_k* Σ_f P[k*, f] · N[k*, f] / D[k*, f]
//! ∂E/∂P = w ∘ N/D             ∂E/∂M = Aᵀ(w ∘ P/D) − Belᵀ(w ∘ P ∘ N/D²)
//! ```
//!
//! In Thrun's objective (eq. 42) the map is the training snapshots themselves, M = P. The printed gradient (eq. 43)
//! lacks Bel_prior in both denominators; this is the derivative of eq. 42 itself.

use super::prior_operator::PriorOperator;
use crate::error::{Error, Result};
use ndarray::{Array1, Array2, ArrayView1, ArrayView2, Axis, Zip};
use rayon::prelude::*;

/// Most features that 2^n outcomes allow.
pub const MOST_FEATURES: usize = 12;

/// P(f) under a prior counts as at least this. Saturated features would give 0/0, and running sums know a P(f) only
/// to about 1e-16 of the whole; an outcome this rare adds at most its probability times the extent to the error.
const SMALLEST_PROBABILITY: f64 = 1e-12;

/// The objective at given activations, and which way is up.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// E_prior: expected error before sensing, in metres.
    pub prior_error_m: f64,
    /// E_posterior: expected error after sensing, in metres.
    pub posterior_error_m: f64,
    /// ∂E_posterior/∂g of the truths, `[truth, feature]`.
    pub truth_gradient: Array2<f64>,
    /// ∂E_posterior/∂g of the map's places, `[candidate, feature]`.
    pub map_gradient: Array2<f64>,
}

impl Evaluation {
    /// 1 − E_posterior / E_prior (Thrun 1998, eq. 46).
    pub fn error_reduction(&self) -> f64 {
        1.0 - self.posterior_error_m / self.prior_error_m
    }
}

/// E_posterior and its gradient, for activations g of the truths `[truth, feature]` and of the map's places
/// `[candidate, feature]`, and weights P(ξ*) of the truths, which sum to 1.
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
/// Where there are more than [`MOST_FEATURES`] features.
pub fn evaluate(
    prior: &PriorOperator,
    truth: ArrayView2<f64>,
    map: ArrayView2<f64>,
    weight: ArrayView1<f64>,
) -> Result<Evaluation> {
    let n = truth.ncols();
    if n > MOST_FEATURES {
        return Err(Error::work(format!(
            "{n} features have 2^{n} outcomes; the exact objective takes at most {MOST_FEATURES}"
        )));
    }
    let p = outcomes(truth); // [truth, outcome]
    let (mut numerator, mut denominator) = prior.apply(outcomes(map).view()); // N, D: [truth, outcome]
    numerator.mapv_inplace(|n| n.max(0.0));
    denominator.mapv_inplace(|d| d.max(SMALLEST_PROBABILITY));
    let error = &numerator / &denominator; // expected error at ξ* after sensing f
    let weight = weight.insert_axis(Axis(1));
    let weighted = &error * &weight; // ∂E/∂P
    let u = &(&p * &weight) / &denominator; // w ∘ P/D
    let posterior_error_m = (&p * &weighted).sum();
    let map_side = prior.apply_transposed(u.view(), (&u * &error).view()); // ∂E/∂M
    Ok(Evaluation {
        prior_error_m: (prior.prior_error_m() * &weight.remove_axis(Axis(1))).sum(),
        posterior_error_m,
        truth_gradient: to_activations(weighted.view(), truth),
        map_gradient: to_activations(map_side.view(), map),
    })
}

/// P(f | s) = Π_i P(f_i | s) for all 2^n outcomes f; bit i of the column's number is f_i (Thrun 1998, eq. 33).
pub fn outcomes(activation: ArrayView2<f64>) -> Array2<f64> {
    let (k, n) = activation.dim();
    let mut outcomes = Array2::zeros((k, 1 << n));
    Zip::from(outcomes.rows_mut())
        .and(activation.rows())
        .par_for_each(|mut p, g| {
            p[0] = 1.0;
            for (i, &g) in g.iter().enumerate() {
                // Every outcome of the features before i, once with f_i = 1 and once with f_i = 0.
                for f in 0..1 << i {
                    p[f + (1 << i)] = p[f] * g;
                    p[f] *= 1.0 - g;
                }
            }
        });
    outcomes
}

/// ∂E/∂g_i = Σ_f ∂E/∂P[f] · (±1) · Π_{j≠i} P(f_j | s): leave-one-out products, so that g = 0 and g = 1 are fine.
fn to_activations(outcome_gradient: ArrayView2<f64>, activation: ArrayView2<f64>) -> Array2<f64> {
    let mut gradient = Array2::zeros(activation.raw_dim());
    let blocks = gradient
        .axis_chunks_iter_mut(Axis(0), ROWS)
        .into_par_iter()
        .zip(outcome_gradient.axis_chunks_iter(Axis(0), ROWS))
        .zip(activation.axis_chunks_iter(Axis(0), ROWS));
    blocks.for_each(|((mut out, dp), g)| {
        let (mut open, mut difference) = (Vec::new(), Vec::new());
        for ((mut out, dp), g) in out.rows_mut().into_iter().zip(dp.rows()).zip(g.rows()) {
            // The last feature first: what comes after it is summed over already, what comes before it still is open.
            open.clear();
            open.extend(dp);
            for i in (0..g.len()).rev() {
                let (without, with) = open.split_at(1 << i);
                difference.clear();
                difference.extend(with.iter().zip(without).map(|(w, o)| w - o));
                for j in (0..i).rev() {
                    sum_out(&mut difference, j, g[j]);
                }
                out[i] = difference[0];
                sum_out(&mut open, i, g[i]);
            }
        }
    });
    gradient
}

/// Rows that a thread takes at once.
const ROWS: usize = 128;

/// Sums over f_i, the last open feature: what is left are the outcomes of those before it.
fn sum_out(open: &mut Vec<f64>, i: usize, g: f64) {
    let (without, with) = open.split_at_mut(1 << i);
    for (o, w) in without.iter_mut().zip(&*with) {
        *o = (1.0 - g) * *o + g * w;
    }
    open.truncate(1 << i);
}

/// Equal weights P(ξ*) for `truths` places.
pub fn equal_weights(truths: usize) -> Array1<f64> {
    Array1::from_elem(truths, 1.0 / truths.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        belief::{Places, Uncertainty},
        geometry::Pose,
        seed::Seed,
    };
    use rand::RngExt;

    /// Thrun (1998), eq. 42, sum by sum as printed; shares no code with `evaluate` but e and the window.
    fn as_printed(uncertainty: Uncertainty, places: &Places, g: &Array2<f64>) -> (f64, f64) {
        let (k, n) = g.dim();
        let p = |f: &[usize], s: usize| -> f64 {
            (0..n)
                .map(|i| {
                    if f[i] == 1 {
                        g[[s, i]]
                    } else {
                        1.0 - g[[s, i]]
                    }
                })
                .product()
        };
        let (mut posterior, mut prior) = (0.0, 0.0);
        for truth in 0..k {
            let admitted: Vec<usize> = (0..k)
                .filter(|&j| uncertainty.admits(places, truth, places, j))
                .collect();
            let belief = 1.0 / admitted.len() as f64;
            for &j in &admitted {
                prior += places.distance_m(truth, places, j) * belief / k as f64;
                let mut f = vec![0; n];
                loop {
                    let normaliser: f64 = admitted.iter().map(|&l| p(&f, l) * belief).sum();
                    let joint = p(&f, truth) * p(&f, j) / normaliser;
                    posterior += places.distance_m(truth, places, j) * belief * joint / k as f64;
                    let Some(next) = f.iter().position(|&bit| bit == 0) else {
                        break;
                    };
                    f[..next].fill(0);
                    f[next] = 1;
                }
            }
        }
        (prior, posterior)
    }

    fn cases() -> Vec<(Uncertainty, Places, Array2<f64>)> {
        let mut cases = Vec::new();
        for case in 0..24u64 {
            let mut random = Seed(11).numbered_stream("objective cases", case);
            let k = 2 + (case as usize * 7) % 23;
            let n = 1 + case as usize % 4;
            let uncertainty = ["2m", "global", "5m,any", "9m,1.2rad"][(case / 2) as usize % 4]
                .parse()
                .unwrap();
            let places = if case % 2 == 0 {
                // Snapshots of several runs may share a coordinate exactly.
                Places::Route(
                    (0..k)
                        .map(|_| (random.random::<f64>() * 40.0).round() * 0.5)
                        .collect(),
                )
            } else {
                let pose = |_| {
                    Pose::new(
                        random.random::<f64>() * 12.0,
                        random.random::<f64>() * 8.0,
                        random.random::<f64>() * 6.0,
                    )
                };
                Places::Plane((0..k).map(pose).collect())
            };
            let g = Array2::from_shape_simple_fn((k, n), || random.random::<f64>());
            cases.push((uncertainty, places, g));
        }
        cases
    }

    fn error_and_gradient(
        uncertainty: Uncertainty,
        places: &Places,
        g: &Array2<f64>,
    ) -> (Evaluation, Array2<f64>) {
        let prior = PriorOperator::new(uncertainty, places, places);
        let e = evaluate(&prior, g.view(), g.view(), equal_weights(g.nrows()).view()).unwrap();
        let gradient = &e.truth_gradient + &e.map_gradient;
        (e, gradient)
    }

    #[test]
    fn equals_the_printed_sums() {
        for (uncertainty, places, g) in cases() {
            let (prior, posterior) = as_printed(uncertainty, &places, &g);
            let (e, _) = error_and_gradient(uncertainty, &places, &g);
            assert!(
                (e.prior_error_m - prior).abs() < 1e-10 * (1.0 + prior),
                "{uncertainty}: {prior} {e:?}"
            );
            assert!(
                (e.posterior_error_m - posterior).abs() < 1e-10 * (1.0 + posterior),
                "{uncertainty}"
            );
        }
    }

    #[test]
    fn gradient_equals_central_differences() {
        for (uncertainty, places, g) in cases() {
            let (_, gradient) = error_and_gradient(uncertainty, &places, &g);
            for k in 0..g.nrows() {
                for i in 0..g.ncols() {
                    let at = |h: f64| {
                        let mut moved = g.clone();
                        moved[[k, i]] += h;
                        error_and_gradient(uncertainty, &places, &moved)
                            .0
                            .posterior_error_m
                    };
                    let numerical = (at(1e-5) - at(-1e-5)) / 2e-5;
                    assert!(
                        (gradient[[k, i]] - numerical).abs() < 1e-6,
                        "{uncertainty} {k} {i}: {numerical}"
                    );
                }
            }
        }
    }

    #[test]
    fn map_and_truth_each_have_their_own_gradient() {
        let truths = Places::Route(vec![0.0, 3.0, 7.0]);
        let candidates = Places::Route(vec![0.5, 2.0, 4.0, 6.5, 9.0]);
        let mut random = Seed(3).stream("map and truth");
        let g = Array2::from_shape_simple_fn((3, 2), || random.random::<f64>());
        let m = Array2::from_shape_simple_fn((5, 2), || random.random::<f64>());
        for window in ["global", "3m"] {
            let prior = PriorOperator::new(window.parse().unwrap(), &truths, &candidates);
            let at = |g: &Array2<f64>, m: &Array2<f64>| {
                evaluate(&prior, g.view(), m.view(), equal_weights(3).view()).unwrap()
            };
            let e = at(&g, &m);
            for (row, column) in [(0, 0), (2, 1), (4, 0)] {
                let moved = |a: &Array2<f64>, h: f64| {
                    let mut a = a.clone();
                    a[[row, column]] += h;
                    a
                };
                let difference = |up: Evaluation, down: Evaluation| {
                    (up.posterior_error_m - down.posterior_error_m) / 2e-5
                };
                let of_map = difference(at(&g, &moved(&m, 1e-5)), at(&g, &moved(&m, -1e-5)));
                assert!((e.map_gradient[[row, column]] - of_map).abs() < 1e-6);
                if row < 3 {
                    let of_truth = difference(at(&moved(&g, 1e-5), &m), at(&moved(&g, -1e-5), &m));
                    assert!((e.truth_gradient[[row, column]] - of_truth).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn prior_errors_of_the_corridor() {
        // method: mean over x of (a² + b²)/(2(a + b)), a = min(w, x), b = min(w, L − x), for dense places on 89 m
        let k = 8900;
        let places = Places::Route((0..k).map(|i| (i as f64 + 0.5) * 89.0 / k as f64).collect());
        for (w, expected) in [
            (1.0, 0.4987),
            (2.0, 0.9949),
            (5.0, 2.4681),
            (10.0, 4.8722),
            (50.0, 21.7928),
            (89.0, 29.6667),
        ] {
            let window = Uncertainty::Window {
                half_width_m: w,
                half_turn_rad: None,
            };
            let error = PriorOperator::new(window, &places, &places)
                .prior_error_m()
                .mean()
                .unwrap();
            assert!(
                (error - expected).abs() < 4e-3,
                "±{w} m: {error}, expected {expected}"
            );
        }
    }

    #[test]
    fn perfect_bits_halve_the_error_each() {
        // Global prior on a line, 2^n equal segments told apart without error: reduction 1 − 2^−n.
        let k = 4096;
        let places = Places::Route((0..k).map(|i| i as f64 + 0.5).collect());
        for n in 1..=4usize {
            let bit = |(place, i): (usize, usize)| ((place * (1 << n) / k) >> i & 1) as f64;
            let g = Array2::from_shape_fn((k, n), bit);
            let reduction = error_and_gradient(Uncertainty::Global, &places, &g)
                .0
                .error_reduction();
            assert!(
                (reduction - (1.0 - 0.5f64.powi(n as i32))).abs() < 1e-3,
                "n = {n}: {reduction}"
            );
        }
        let quarter =
            Array2::from_shape_fn((k, 1), |(place, _)| if place < k / 4 { 1.0 } else { 0.0 });
        let reduction = error_and_gradient(Uncertainty::Global, &places, &quarter)
            .0
            .error_reduction();
        assert!((reduction - 0.375).abs() < 1e-3, "{reduction}");
    }

    #[test]
    fn saturated_features_give_finite_gradients() {
        let places = Places::Route((0..300).map(|i| f64::from(i) * 0.3).collect());
        let g = Array2::from_shape_fn((300, 4), |(k, i)| {
            [0.0, 1.0, 1e-9, 1.0 - 1e-9][(k * 7 + i * 3) % 4]
        });
        for window in ["1m", "global"] {
            let (e, gradient) = error_and_gradient(window.parse().unwrap(), &places, &g);
            assert!(
                e.posterior_error_m >= 0.0 && e.posterior_error_m <= e.prior_error_m * 1.001,
                "{e:?}"
            );
            assert!(gradient.iter().all(|v| v.is_finite()));
        }
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        for (uncertainty, places, g) in cases() {
            let in_pool = |threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .unwrap();
                pool.install(|| error_and_gradient(uncertainty, &places, &g).1)
            };
            assert_eq!(in_pool(1), in_pool(3));
        }
    }
}
