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
