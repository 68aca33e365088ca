//! Every formula agrees with a witness that shares no code with it.

use super::{
    laws::{bend, corridor, grid, random_activations, step},
    *,
};
use crate::{geometry::Pose, seed::Seed};
use ndarray::Array2;
use rand::RngExt;
use std::sync::Arc;

#[test]
fn exact_prediction_agrees_with_brute_force_on_a_bent_floor() {
    let grid = grid(&bend());
    let Places::Plane(cells) = &**grid.places() else {
        unreachable!()
    };
    let mut random = Seed(5).stream("masses");
    let mass: Vec<f64> = (0..grid.len()).map(|_| random.random()).collect();
    let prior = Belief::from_mass(grid.places(), mass).unwrap();
    let motion = OdometryMotion {
        stall_probability: 0.1,
        ..OdometryMotion::exact()
    };
    let movement = step(0.6, 0.35, 0.5);
    let mut robot = BayesFilter::new(&grid, motion, prior.clone()).unwrap();
    robot.predict(&movement).unwrap();

    // Each cell shares its mass among all cells by the hat function of the distance to where it lands, on each axis.
    let hat = |d: f64| (1.0 - d.abs()).max(0.0);
    let heading_cell = std::f64::consts::TAU / 8.0;
    let mut expected = vec![0.0; grid.len()];
    for (from, start) in cells.iter().enumerate() {
        for (moves, probability) in [(movement, 0.9), (step(0.0, 0.0, movement.turn_rad), 0.1)] {
            let lands = start.after(moves);
            for (to, end) in cells.iter().enumerate() {
                let turn = crate::geometry::wrapped(end.heading_rad - lands.heading_rad);
                let share = hat((end.x_m - lands.x_m) / 0.25)
                    * hat((end.y_m - lands.y_m) / 0.25)
                    * hat(turn / heading_cell);
                expected[to] += probability * share * prior.mass()[from];
            }
        }
    }
    let total: f64 = expected.iter().sum();
    assert!(total < 0.99, "some mass left the floor: {total}");
    for (cell, e) in expected.iter().enumerate() {
        let got = robot.belief().mass()[cell];
        assert!(
            (got - e / total).abs() < 1e-9,
            "cell {cell}: {got} not {}",
            e / total
        );
    }
}

/// All f of n features, f_i as 0.0 or 1.0.
fn feature_vectors(n: usize) -> Vec<Vec<f64>> {
    (0..1 << n)
        .map(|f| (0..n).map(|i| f64::from(f >> i & 1)).collect())
        .collect()
}

/// P(f) of independent features.
fn probability(f: &[f64], p: &[f64]) -> f64 {
    f.iter()
        .zip(p)
        .map(|(f, p)| if *f == 1.0 { *p } else { 1.0 - p })
        .product()
}

#[test]
fn each_evidence_agrees_with_its_definition_by_enumeration() {
    let places = Arc::new(corridor());
    let mut random = Seed(2).stream("evidence");
    let m = random_activations(places.len(), 3, &mut random);
    let mass = (0..places.len()).map(|_| random.random()).collect();
    let belief = Belief::from_mass(&places, mass).unwrap();
    let map = GridMap::new(m.clone()).unwrap();
    let row = |cell: usize| m.row(cell).to_vec();
    for g in [vec![0.3, 0.8, 0.45], vec![1.0, 0.0, 1.0]] {
        let posterior = |weight: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let joint: Vec<f64> = (0..places.len())
                .map(|cell| belief.mass()[cell] * weight(cell))
                .collect();
            let total: f64 = joint.iter().sum();
            joint.iter().map(|j| j / total).collect()
        };
        let likelihood = posterior(&|cell| {
            feature_vectors(3)
                .iter()
                .map(|f| probability(f, &g) * probability(f, &row(cell)))
                .sum()
        });
        let mean_field = posterior(&|cell| {
            let term = |(m, g): (&f64, &f64)| m.powf(*g) * (1.0 - m).powf(1.0 - g);
            row(cell).iter().zip(&g).map(term).product()
        });
        let mut jeffrey = vec![0.0; places.len()];
        for f in feature_vectors(3) {
            let given = posterior(&|cell| probability(&f, &row(cell)));
            jeffrey
                .iter_mut()
                .zip(given)
                .for_each(|(j, p)| *j += probability(&f, &g) * p);
        }
        let witnesses = [
            (Evidence::Likelihood, likelihood),
            (Evidence::MeanField, mean_field),
            (Evidence::Jeffrey, jeffrey),
        ];
        for (evidence, expected) in witnesses {
            let log = evidence
                .log_likelihood(&g, &map, &belief, &mut random)
                .unwrap();
            let mut corrected = belief.clone();
            bayes::correct(&mut corrected, &log).unwrap();
            for (cell, e) in expected.iter().enumerate() {
                assert!(
                    (corrected.mass()[cell] - e).abs() < 1e-14,
                    "{evidence}, {g:?}, cell {cell}"
                );
            }
        }
    }
}

#[test]
fn sampled_features_come_as_often_as_they_should_and_from_the_seed() {
    let places = Arc::new(Places::Route(vec![0.0, 1.0]));
    let belief = Belief::uniform(&places).unwrap();
    let map = GridMap::new(ndarray::array![[0.9], [0.2]]).unwrap();
    let draw = |seed: u64| -> Vec<bool> {
        let mut stream = Seed(seed).stream("features");
        let mut one = || {
            Evidence::Sampled
                .log_likelihood(&[0.3], &map, &belief, &mut stream)
                .unwrap()
        };
        (0..10_000)
            .map(|_| (one()[0] - 0.9_f64.ln()).abs() < 1e-12)
            .collect()
    };
    let first = draw(1);
    let yes = first.iter().filter(|f| **f).count();
    assert!((yes as f64 - 3000.0).abs() < 4.0 * 45.8, "{yes}"); // 4 standard deviations
    assert_eq!(first, draw(1));
    assert_ne!(first, draw(2));
}

#[test]
fn wide_codes_need_another_evidence_than_jeffrey() {
    let places = Arc::new(Places::Route(vec![0.0, 1.0]));
    let belief = Belief::uniform(&places).unwrap();
    let map = GridMap::new(Array2::from_elem((2, 2000), 1e-3)).unwrap();
    let mut stream = Seed(0).stream("features");
    for evidence in Evidence::ALL {
        let log = evidence.log_likelihood(&[1.0; 2000], &map, &belief, &mut stream);
        match evidence {
            Evidence::Jeffrey => {
                let error = log.unwrap_err();
                assert!(
                    error.is_usage() && error.to_string().contains("2000 features"),
                    "{error}"
                );
            }
            _ => assert!(bayes::correct(&mut belief.clone(), &log.unwrap()).is_ok()),
        }
    }
    let wrong = Evidence::MeanField.log_likelihood(&[0.5; 3], &map, &belief, &mut stream);
    assert!(wrong.is_err());
    let small = GridMap::new(ndarray::array![[0.5], [0.5]]).unwrap();
    let error = Evidence::Likelihood.log_likelihood(&[f64::NAN], &small, &belief, &mut stream);
    assert!(error.unwrap_err().to_string().contains("feature 0 is NaN"));
}

/// Expected error after one correction by Jeffrey's rule with M = P, averaged over the truths.
fn error_after_one_step(places: &Arc<Places>, prior: &Uncertainty, g: &Array2<f64>) -> f64 {
    let map = GridMap::new(g.clone()).unwrap();
    let errors = (0..places.len()).map(|truth| {
        let mut belief = Belief::within(places, places, truth, prior).unwrap();
        let activations = g.row(truth).to_vec();
        let mut stream = Seed(0).stream("unused");
        let log = Evidence::Jeffrey.log_likelihood(&activations, &map, &belief, &mut stream);
        bayes::correct(&mut belief, &log.unwrap()).unwrap();
        belief.expected_error_m(places, truth)
    });
    errors.sum::<f64>() / places.len() as f64
}

#[test]
fn jeffrey_makes_the_error_that_training_minimises() {
    let mut random = Seed(9).stream("activations");
    let poses = (0..40).map(|i| Pose::new(0.3 * i as f64, (i % 5) as f64, 0.2 * i as f64));
    for (places, prior) in [
        (corridor(), "global"),
        (corridor(), "2m"),
        (Places::Plane(poses.clone().collect()), "global"),
        (Places::Plane(poses.collect()), "3m,any"),
    ] {
        let places = Arc::new(places);
        let prior: Uncertainty = prior.parse().unwrap();
        let k = places.len();
        let g = random_activations(k, 4, &mut random);
        // Thrun (1998), eq. 36: Σ_ξ* Σ_ξ e(ξ*, ξ) Σ_f P(f|s) Bel(ξ)/P(f) P(f|s*) P(ξ*), with P(f) = Σ_ξ̃ P(f|s̃) Bel(ξ̃).
        let mut e_posterior = 0.0;
        for truth in 0..k {
            let candidates: Vec<usize> = (0..k)
                .filter(|&j| prior.admits(&places, truth, &places, j))
                .collect();
            let bel = 1.0 / candidates.len() as f64;
            for f in feature_vectors(4) {
                let p = |j: usize| probability(&f, g.row(j).as_slice().unwrap());
                let p_f: f64 = candidates.iter().map(|&j| p(j) * bel).sum();
                for &j in &candidates {
                    let e = places.distance_m(truth, &places, j);
                    e_posterior += e * p(j) * bel / p_f * p(truth) / k as f64;
                }
            }
        }
        let filter = error_after_one_step(&places, &prior, &g);
        assert!(
            (filter - e_posterior).abs() < 1e-12,
            "{prior}: {filter} not {e_posterior}"
        );
    }
}

#[test]
fn two_places_are_confused_by_25_99ths_of_their_distance() {
    let d = 7.0;
    let places = Arc::new(Places::Route(vec![0.0, d]));
    let e = error_after_one_step(
        &places,
        &Uncertainty::Global,
        &ndarray::array![[0.9], [0.2]],
    );
    assert!((e - 25.0 / 99.0 * d).abs() < 1e-12, "{e}");
}
