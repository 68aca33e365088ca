//! The objective against the printed sums, numerical gradients and closed forms.

use super::*;
use crate::{
    belief::{Places, Uncertainty},
    geometry::Pose,
    seed::Seed,
};
use ndarray::Array2;
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
            let map_slope = difference(at(&g, &moved(&m, 1e-5)), at(&g, &moved(&m, -1e-5)));
            assert!((e.map_gradient[[row, column]] - map_slope).abs() < 1e-6);
            if row < 3 {
                let truth_slope = difference(at(&moved(&g, 1e-5), &m), at(&moved(&g, -1e-5), &m));
                assert!((e.truth_gradient[[row, column]] - truth_slope).abs() < 1e-6);
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
    let quarter = Array2::from_shape_fn((k, 1), |(place, _)| if place < k / 4 { 1.0 } else { 0.0 });
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

/// Poses anywhere in a hall of 20 m by 12 m.
fn hall(name: &str, k: usize) -> Places {
    let mut random = Seed(5).stream(name);
    let mut uniform = |width: f64| width * random.random::<f64>() - 3.0;
    Places::Plane(
        (0..k)
            .map(|_| Pose::new(uniform(20.0), uniform(12.0), uniform(6.0)))
            .collect(),
    )
}

#[test]
fn the_objective_by_cells_is_near_the_exact_one_and_meets_it() {
    let (truths, candidates) = (hall("truths", 300), hall("candidates", 400));
    let mut random = Seed(6).stream("activations");
    let mut activations = |k| Array2::from_shape_simple_fn((k, 5), || random.random::<f64>());
    let (g, m) = (activations(300), activations(400));
    let weight = equal_weights(300);
    let at = |prior: &PriorOperator| evaluate(prior, g.view(), m.view(), weight.view()).unwrap();
    let exact = at(&PriorOperator::everywhere(&truths, &candidates).unwrap());
    for side_m in [1.0, 0.25, 1e-4] {
        let cells = at(&PriorOperator::everywhere_in_cells(&truths, &candidates, side_m).unwrap());
        let off_m = (cells.posterior_error_m - exact.posterior_error_m).abs();
        assert!(off_m <= side_m * 2f64.sqrt(), "{side_m}: {off_m}");
    }
    let fine = at(&PriorOperator::everywhere_in_cells(&truths, &candidates, 1e-6).unwrap());
    for (a, b) in [
        (&fine.truth_gradient, &exact.truth_gradient),
        (&fine.map_gradient, &exact.map_gradient),
    ] {
        assert!((a - b).iter().all(|d| d.abs() < 1e-7));
    }
}

/// With a uniform belief, and the training snapshots as their own map, a robot expects what training minimises under the global prior.
#[test]
fn of_a_lost_robot_the_expected_error_is_the_objective() {
    use crate::belief::{
        Belief, GridMap,
        expected_posterior_error::{Approximation, expected_posterior_error_m},
    };
    let places = Places::Route((0..40).map(|k| 0.5 * f64::from(k)).collect());
    let mut stream = Seed(5).stream("map");
    let g = Array2::from_shape_fn((40, 4), |_| stream.random::<f64>());
    let prior = PriorOperator::new(Uncertainty::Global, &places, &places);
    let weight = equal_weights(40);
    let objective = evaluate(&prior, g.view(), g.view(), weight.view()).unwrap();
    let map = GridMap::new(g).unwrap();
    let lost = Belief::uniform(&std::sync::Arc::new(places)).unwrap();
    let sums = Approximation::default();
    let mut unused = Seed(1).stream("features");
    let expected = expected_posterior_error_m(&lost, &map, &map, sums, &mut unused).unwrap();
    assert!((expected - objective.posterior_error_m).abs() < 1e-12);
}
