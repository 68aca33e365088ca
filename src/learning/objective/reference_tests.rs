//! The objective against its dense reference, in both precisions, and the same bits from every number of threads and
//! every set of instructions.

use super::*;
use crate::{
    belief::{Places, Uncertainty},
    geometry::Pose,
    seed::{Seed, Stream},
    simd::InstructionSet,
};
use ndarray::{Array1, Array2};
use rand::RngExt;

struct Case {
    uncertainty: Uncertainty,
    truths: Places,
    candidates: Places,
    g: Array2<f64>,
    m: Array2<f64>,
    weight: Array1<f64>,
}

/// Places in no order, some of them several times; every second case in the plane.
fn places(random: &mut Stream, k: usize, plane: bool) -> Places {
    let mut uniform = |width: f64| width * random.random::<f64>();
    if plane {
        let mut poses: Vec<Pose> = (0..k)
            .map(|_| Pose::new(uniform(14.0), uniform(9.0), uniform(6.2)))
            .collect();
        for i in (3..k).step_by(7) {
            poses[i] = poses[i / 2];
        }
        Places::Plane(poses)
    } else {
        // Some to a quarter of a metre, so that they meet; and far from 0, as on a long route.
        let mut x = |i: usize| {
            if i.is_multiple_of(3) {
                (uniform(160.0)).round() * 0.25
            } else {
                uniform(40.0)
            }
        };
        Places::Route((0..k).map(|i| 3000.0 + x(i)).collect())
    }
}

fn cases() -> Vec<Case> {
    let windows = ["0.3m", "2m", "5m,any", "9m,1.2rad", "global", "30m"];
    let case = |number: usize| {
        let mut random = Seed(12).numbered_stream("dense cases", number as u64);
        let (plane, n) = (number % 2 == 1, 1 + number / 2 % 6);
        let truths = places(&mut random, [40, 90, 333][number % 3], plane);
        // The truths themselves, or others, as in validation.
        let candidates = match number % 4 {
            0 | 1 => truths.clone(),
            _ => places(&mut random, 150, plane),
        };
        // From nearly undecided to nearly certain.
        let sharpness = [1.0, 4.0, 9.0][number / 3 % 3];
        let mut activations = |k: usize| {
            Array2::from_shape_simple_fn((k, n), || {
                1.0 / (1.0 + (-sharpness * (2.0 * random.random::<f64>() - 1.0)).exp())
            })
        };
        // As f32 has them, so that both precisions get the same.
        let mut rounded = |k: usize| activations(k).mapv(|g| f64::from(g as f32));
        let (g, m) = (rounded(truths.len()), rounded(candidates.len()));
        let weight = Array1::from_shape_simple_fn(truths.len(), || 0.1 + random.random::<f64>());
        Case {
            uncertainty: windows[number % windows.len()].parse().unwrap(),
            truths,
            candidates,
            g,
            m,
            weight: &weight / weight.sum(),
        }
    };
    (0..48).map(case).collect()
}

fn all<T: Real>(e: &Evaluation<T>) -> (f64, Array2<f64>, Array2<f64>) {
    let wide = |a: &Array2<T>| a.mapv(T::to_f64);
    (
        e.posterior_error_m,
        wide(&e.truth_gradient),
        wide(&e.map_gradient),
    )
}

/// The farthest off of a gradient, relative to its largest entry.
fn off(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    let largest = |a: Array2<f64>| a.iter().fold(0.0, |l: f64, v| l.max(v.abs()));
    largest(a - b) / largest(b.clone()).max(1e-300)
}

fn holds<T: Real>(tolerance: f64) {
    let mut worst = [0.0; 3];
    // One set of buffers for all: what was evaluated before must leave no trace.
    let mut objective = Objective::<T>::new();
    for (number, case) in cases().iter().enumerate() {
        let Case {
            uncertainty,
            truths,
            candidates,
            g,
            m,
            weight,
        } = case;
        let (bel, e_m) = reference::prior(*uncertainty, truths, candidates);
        let d = bel.dot(&reference::outcomes(m));
        assert!(d.iter().all(|&d| d == 0.0 || d > SMALLEST_PROBABILITY));
        let expected = reference::evaluate(&bel, &e_m, g, m, weight);
        let prior_error_m = expected.prior_error_m;
        let expected = all(&expected);
        let prior = PriorOperator::new(*uncertainty, truths, candidates);
        let (g, m) = (g.mapv(T::from_f64), m.mapv(T::from_f64));
        let found = objective
            .evaluate(&prior, g.view(), m.view(), weight.view())
            .unwrap();
        assert!((found.prior_error_m - prior_error_m).abs() <= 1e-12 * prior_error_m);
        let found = all(found);
        let errors = [
            (found.0 - expected.0).abs() / expected.0.max(1e-300),
            off(&found.1, &expected.1),
            off(&found.2, &expected.2),
        ];
        for (worst, error) in worst.iter_mut().zip(errors) {
            *worst = f64::max(*worst, error);
            assert!(
                error < tolerance,
                "case {number}, {uncertainty}: {errors:?}"
            );
        }
    }
    println!("worst: {worst:?}");
}

#[test]
fn double_precision_equals_the_dense_reference() {
    holds::<f64>(1e-10);
}

#[test]
fn single_precision_equals_the_dense_reference() {
    holds::<f32>(1e-6);
}

/// The bits of E and of both gradients.
fn bits<T: Real>(instructions: InstructionSet, case: &Case) -> Vec<u64> {
    let prior = PriorOperator::new(case.uncertainty, &case.truths, &case.candidates);
    let mut objective = Objective::<T>::with_instructions(instructions);
    let (g, m) = (case.g.mapv(T::from_f64), case.m.mapv(T::from_f64));
    let e = objective.evaluate(&prior, g.view(), m.view(), case.weight.view());
    let (error_m, truth_gradient, map_gradient) = all(e.unwrap());
    let gradients = truth_gradient
        .iter()
        .chain(&map_gradient)
        .map(|v| v.to_bits());
    std::iter::once(error_m.to_bits())
        .chain(gradients)
        .collect()
}

#[test]
fn one_two_and_four_threads_give_the_same_bits() {
    for case in cases() {
        let in_pool = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| {
                [
                    bits::<f32>(InstructionSet::Best, &case),
                    bits::<f64>(InstructionSet::Best, &case),
                ]
            })
        };
        let one = in_pool(1);
        assert_eq!(one, in_pool(2), "{}", case.uncertainty);
        assert_eq!(one, in_pool(4), "{}", case.uncertainty);
    }
}

#[test]
fn the_best_instructions_and_none_give_the_same_bits() {
    for case in cases() {
        assert_eq!(
            bits::<f32>(InstructionSet::Best, &case),
            bits::<f32>(InstructionSet::Portable, &case)
        );
        assert_eq!(
            bits::<f64>(InstructionSet::Best, &case),
            bits::<f64>(InstructionSet::Portable, &case)
        );
    }
}

#[test]
fn an_outcome_that_the_map_never_shows_leaves_the_prior_error() {
    let places = Places::Route(vec![0.0, 3.0, 6.0]);
    let prior = PriorOperator::new(Uncertainty::Global, &places, &places);
    let (truth, map) = (
        ndarray::array![[1.0], [1.0], [1.0]],
        ndarray::array![[0.0], [0.0], [0.0]],
    );
    let e = evaluate(&prior, truth.view(), map.view(), equal_weights(3).view()).unwrap();
    assert!(
        (e.posterior_error_m - e.prior_error_m).abs() < 1e-12,
        "{e:?}"
    );
}

#[test]
fn shapes_that_do_not_fit_are_reported() {
    let places = Places::Route(vec![0.0, 3.0, 6.0]);
    let prior = PriorOperator::new(Uncertainty::Global, &places, &places);
    let message = |truths: usize, map: usize, weights: usize, n: usize| {
        let g = |k: usize| Array2::<f64>::zeros((k, n));
        evaluate(
            &prior,
            g(truths).view(),
            g(map).view(),
            equal_weights(weights).view(),
        )
        .unwrap_err()
        .to_string()
    };
    assert!(message(2, 3, 3, 1).contains("activations of (2, 1) truths"));
    assert!(message(3, 4, 3, 1).contains("expected (3, 1), (3, 1) and 3"));
    assert!(message(3, 3, 2, 1).contains("with 2 weights"));
    assert!(message(3, 3, 3, 13).contains("at most 12"));
    assert!(message(3, 3, 3, 0).contains("at least one"));
}
