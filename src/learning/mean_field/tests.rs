use super::*;
use crate::{
    belief::{Places, Uncertainty},
    geometry::Pose,
    learning::objective,
    learning::prior_operator::PriorOperator,
    seed::Seed,
};
use ndarray::array;
use rand::RngExt;

fn plane(count: usize, random: &mut crate::seed::Stream) -> Places {
    let pose = |_| {
        let mut draw = |reach: f64| random.random_range(-reach..reach);
        Pose::new(draw(3.0), draw(3.0), draw(3.1))
    };
    Places::Plane((0..count).map(pose).collect())
}

fn probabilities(shape: (usize, usize), random: &mut crate::seed::Stream) -> Array2<f32> {
    Array2::from_shape_simple_fn(shape, || random.random_range(0.05..0.95))
}

fn mixed(count: usize) -> Vec<Uncertainty> {
    let all = ["2m,any", "global", "3m,1rad"];
    (0..count).map(|t| all[t % 3].parse().unwrap()).collect()
}

#[test]
fn gradients_are_central_differences() {
    let mut random = Seed(1).stream("mean field");
    let (truths, candidates) = (plane(20, &mut random), plane(37, &mut random));
    let priors = Priors::new(mixed(20), truths, candidates);
    let truth = probabilities((20, 5), &mut random);
    let map = probabilities((37, 5), &mut random);
    let weight = priors.relative_weights();
    let value = |truth: &Array2<f32>, map: &Array2<f32>| {
        evaluate(&priors, truth.view(), map.view(), weight.view()).posterior_error_m
    };
    let e = evaluate(&priors, truth.view(), map.view(), weight.view());
    let alone = error_m(&priors, truth.view(), map.view(), weight.view());
    assert_eq!(e.posterior_error_m.to_bits(), alone.to_bits());
    let h = 5e-3f32;
    for at in [[0, 0], [7, 3], [19, 4]] {
        let moved = |by: f32| {
            let mut truth = truth.clone();
            truth[at] += by;
            value(&truth, &map)
        };
        let difference = (moved(h) - moved(-h)) / (2.0 * f64::from(h));
        assert!(
            (difference - f64::from(e.truth_gradient[at])).abs() < 2e-4,
            "{at:?}: {difference}"
        );
    }
    for at in [[0, 0], [17, 2], [36, 4]] {
        let moved = |by: f32| {
            let mut map = map.clone();
            map[at] += by;
            value(&truth, &map)
        };
        let difference = (moved(h) - moved(-h)) / (2.0 * f64::from(h));
        assert!(
            (difference - f64::from(e.map_gradient[at])).abs() < 2e-4,
            "{at:?}: {difference}"
        );
    }
}

#[test]
fn equals_the_exact_objective_where_truths_are_certain() {
    let mut random = Seed(2).stream("mean field");
    let places = plane(25, &mut random);
    let uncertainty: Uncertainty = "3m,any".parse().unwrap();
    let truth = Array2::from_shape_simple_fn((25, 4), || f32::from(random.random_range(0..2u8)));
    let map = probabilities((25, 4), &mut random);
    let priors = Priors::new(vec![uncertainty; 25], places.clone(), places.clone());
    let weight = objective::equal_weights(25);
    let wide = evaluate(&priors, truth.view(), map.view(), weight.view());
    let operator = PriorOperator::new(uncertainty, &places, &places);
    let (truth, map) = (truth.mapv(f64::from), map.mapv(f64::from));
    let exact = objective::evaluate(&operator, truth.view(), map.view(), weight.view()).unwrap();
    assert!((wide.posterior_error_m - exact.posterior_error_m).abs() < 1e-5);
    assert!((wide.prior_error_m - exact.prior_error_m).abs() < 1e-6);
}

#[test]
fn a_narrow_prior_is_not_drowned_by_candidates_outside_of_it() {
    // The place outside the window fits far better; inside, the two answers differ by much less than that.
    let truths = Places::Route(vec![0.0]);
    let candidates = Places::Route(vec![0.0, 1.0, 50.0]);
    let priors = Priors::new(vec!["2m".parse().unwrap()], truths, candidates);
    let truth = Array2::ones((1, 64));
    let mut map = Array2::from_elem((3, 64), 0.01);
    map.row_mut(0).fill(0.02);
    map.row_mut(2).fill(0.99);
    let e = evaluate(&priors, truth.view(), map.view(), array![1.0].view());
    assert!(e.posterior_error_m < 1e-9 && (e.prior_error_m - 0.5).abs() < 1e-12);
}

#[test]
fn weights_leave_out_who_has_nothing_to_be_mistaken_for() {
    let places = Places::Route(vec![0.0, 1.0, 3.0, 90.0]);
    let priors = Priors::new(vec!["2m".parse().unwrap(); 4], places.clone(), places);
    assert_eq!(priors.window_sizes(), [2, 3, 2, 1]);
    assert_eq!(
        priors.equal_weights().to_vec(),
        [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0]
    );
    let relative = priors.relative_weights(); // prior errors 1/2, 1, 1
    assert!((relative[0] - 0.5).abs() < 1e-12 && (relative[1] - 0.25).abs() < 1e-12);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut random = Seed(3).stream("mean field");
    let places = plane(200, &mut random);
    let priors = Priors::new(mixed(200), places.clone(), places);
    let (truth, map) = (
        probabilities((200, 64), &mut random),
        probabilities((200, 64), &mut random),
    );
    let weight = priors.equal_weights();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let e = pool.install(|| evaluate(&priors, truth.view(), map.view(), weight.view()));
        (
            e.posterior_error_m.to_bits(),
            e.truth_gradient,
            e.map_gradient,
        )
    };
    assert_eq!(on(1), on(3));
}

/// Σ w (E + c·CE) word for word: the posterior of every truth over what its prior admits, its expected error in metres, and
/// its cross entropy with a Gaussian of 0.2 m and 0.2 rad about the truth, a share of the prior error a nat.
fn with_cross_entropy(
    (uncertainty, truths, candidates): (&[Uncertainty], &Places, &Places),
    share: f64,
    (truth, map): (&Array2<f32>, &Array2<f32>),
    weight: &ndarray::Array1<f64>,
) -> f64 {
    let of_truth = |t: usize| {
        let admitted: Vec<usize> = (0..candidates.len())
            .filter(|&k| {
                let turn = || truths.turn_rad(t, candidates, k);
                uncertainty[t].admits_at(truths.distance_m(t, candidates, k), turn)
            })
            .collect();
        let e = |k: usize| truths.distance_m(t, candidates, k);
        let l = |k: usize| -> f64 {
            let terms = truth.row(t).into_iter().zip(map.row(k));
            terms
                .map(|(&g, &m)| {
                    let (g, m) = (f64::from(g), f64::from(m));
                    g * m.ln() + (1.0 - g) * (1.0 - m).ln()
                })
                .sum()
        };
        let normal = |weights: Vec<f64>| {
            let sum: f64 = weights.iter().sum();
            weights.into_iter().map(|w| w / sum).collect::<Vec<f64>>()
        };
        let q = normal(admitted.iter().map(|&k| l(k).exp()).collect());
        let gaussian = |&k: &usize| {
            let turn = truths.turn_rad(t, candidates, k);
            (-0.5 * ((e(k) / 0.2).powi(2) + (turn / 0.2).powi(2))).exp()
        };
        let target = normal(admitted.iter().map(gaussian).collect());
        let prior: f64 = admitted.iter().map(|&k| e(k)).sum::<f64>() / admitted.len() as f64;
        let error: f64 = admitted.iter().zip(&q).map(|(&k, q)| q * e(k)).sum();
        let cross: f64 = target.iter().zip(&q).map(|(t, q)| -t * q.ln()).sum();
        error + share * prior * cross
    };
    (0..truths.len())
        .filter(|&t| weight[t] > 0.0)
        .map(|t| weight[t] * of_truth(t))
        .sum()
}

#[test]
fn a_cross_entropy_adds_its_own_slope() {
    let mut random = Seed(5).stream("mean field");
    let (truths, candidates) = (plane(12, &mut random), plane(25, &mut random));
    let uncertainty = mixed(12);
    let mut priors = Priors::new(uncertainty.clone(), truths.clone(), candidates.clone());
    priors.with_targets(0.7);
    let truth = probabilities((12, 4), &mut random);
    let map = probabilities((25, 4), &mut random);
    let weight = priors.relative_weights();
    let value = |truth: &Array2<f32>, map: &Array2<f32>| {
        let asked = (&uncertainty[..], &truths, &candidates);
        with_cross_entropy(asked, 0.7, (truth, map), &weight)
    };
    let e = evaluate(&priors, truth.view(), map.view(), weight.view());
    let h = 1e-3f32;
    for at in [[0, 0], [7, 3], [11, 1]] {
        let moved = |by: f32| {
            let mut truth = truth.clone();
            truth[at] += by;
            value(&truth, &map)
        };
        let difference = (moved(h) - moved(-h)) / (2.0 * f64::from(h));
        let found = f64::from(e.truth_gradient[at]);
        assert!(
            (difference - found).abs() < 2e-4 * (1.0 + difference.abs()),
            "{at:?}: {difference} {found}"
        );
    }
    for at in [[0, 0], [17, 2], [24, 3]] {
        let moved = |by: f32| {
            let mut map = map.clone();
            map[at] += by;
            value(&truth, &map)
        };
        let difference = (moved(h) - moved(-h)) / (2.0 * f64::from(h));
        let found = f64::from(e.map_gradient[at]);
        assert!(
            (difference - found).abs() < 2e-4 * (1.0 + difference.abs()),
            "{at:?}: {difference} {found}"
        );
    }
    // What is reported stays the error alone.
    let without = Priors::new(uncertainty.clone(), truths.clone(), candidates.clone());
    let error_alone = evaluate(&without, truth.view(), map.view(), weight.view());
    assert_eq!(
        e.posterior_error_m.to_bits(),
        error_alone.posterior_error_m.to_bits()
    );
}
