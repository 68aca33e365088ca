use super::*;
use crate::{
    belief::{Places, Uncertainty},
    detector::device::cpu,
    geometry::Pose,
    learning::{
        problem::Workspace,
        recipe::{ObjectiveKind, Recipe},
        trainer::tensors::array,
    },
    seed::{Seed, Stream},
};
use ndarray::{Array2, ArrayView2};
use rand::RngExt;

fn places(route: bool, count: usize, random: &mut Stream) -> Places {
    let mut at = || random.random_range(0.0..12.0);
    match route {
        true => Places::Route((0..count).map(|_| at()).collect()),
        false => Places::Plane((0..count).map(|_| Pose::new(at(), at(), at())).collect()),
    }
}

/// Are all numbers equal but for rounding, against the greatest of them?
fn near(a: ArrayView2<f32>, b: &Tensor<2>, case: &str) {
    let b = array(b.clone()).unwrap();
    let greatest = a.iter().fold(0f32, |greatest, x| greatest.max(x.abs()));
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() <= 2e-5 * greatest, "{case}: {a} and {b}");
    }
}

fn compare(problem: &Problem, truths: usize, candidates: usize, features: usize, case: &str) {
    let mut random = Seed(3).stream(case);
    let mut draw = |rows| {
        Array2::from_shape_simple_fn((rows, features), || random.random_range(0.02f32..0.98))
    };
    let (truth, map) = (draw(truths), draw(candidates));
    for with_map in [false, true] {
        let mut workspace = Workspace::default();
        let structured = problem
            .evaluate(&mut workspace, truth.view(), map.view(), with_map)
            .unwrap();
        let dense = OnDevice::where_it_fits(problem, with_map, &cpu()).unwrap();
        let found = dense
            .evaluate(tensor(truth.view(), &cpu()), tensor(map.view(), &cpu()))
            .unwrap();
        let (a, b) = (structured.errors, found.errors);
        assert!(
            (a.prior_error_m / b.prior_error_m - 1.0).abs() < 1e-6,
            "{case}"
        );
        let share = a.posterior_error_m / b.posterior_error_m;
        assert!((share - 1.0).abs() < 1e-5, "{case}: {a:?} {b:?}");
        near(structured.truth_gradient, &found.truth_gradient, case);
        near(
            structured.candidate_gradient,
            &found.candidate_gradient,
            case,
        );
    }
}

#[test]
fn the_dense_exact_objective_is_the_structured_one() {
    for (case, (route, prior, features)) in [
        (true, "2m", 1),
        (true, "global", 4),
        (false, "3m", 2),
        (false, "global", 5),
        (false, "4m,any", 3),
    ]
    .into_iter()
    .enumerate()
    {
        let mut random = Seed(2).numbered_stream("places", case as u64);
        let truths = places(route, 40, &mut random);
        let candidates = places(route, 57, &mut random);
        let recipe = Recipe {
            uncertainty: prior.parse().unwrap(),
            ..Recipe::thrun1998()
        };
        let problem = Problem::reported(&recipe, &recipe.map, &truths, &candidates).unwrap();
        compare(&problem, 40, 57, features, &format!("{prior} {route}"));
    }
}

#[test]
fn the_dense_mean_field_is_the_other_one() {
    let mut random = Seed(2).stream("places");
    let truths = places(false, 30, &mut random);
    let candidates = places(false, 90, &mut random);
    let priors: Vec<Uncertainty> = ["global", "2m", "5m,any", "0.01m"]
        .map(|prior| prior.parse().unwrap())
        .into_iter()
        .cycle()
        .take(30)
        .collect(); // the last one admits nothing
    let recipe = Recipe::default();
    let problem = Problem::for_step(&recipe, &recipe.map, priors, truths, candidates).unwrap();
    compare(&problem, 30, 90, 16, "mean field");
}

#[test]
fn a_table_of_too_many_pairs_stays_on_the_cpu() {
    let places = Places::Route((0..5001).map(f64::from).collect());
    for objective in [ObjectiveKind::Exact, ObjectiveKind::MeanField] {
        let mut recipe = Recipe::default();
        recipe.descent.objective = objective;
        let problem = Problem::reported(&recipe, &recipe.map, &places, &places).unwrap();
        assert!(OnDevice::where_it_fits(&problem, true, &cpu()).is_none());
        assert!(problem.pairs(5001 * 5001).is_some());
    }
}
