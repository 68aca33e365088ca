//! One evaluation of the objective with its gradient: K = 2,400 snapshots on a route of 89 m, four features.

use ballmark::{
    belief::{Places, Uncertainty},
    learning::{
        objective::{equal_weights, evaluate},
        prior_operator::PriorOperator,
    },
    seed::Seed,
};
use criterion::{Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use rand::RngExt;
use std::hint::black_box;

const SNAPSHOTS: usize = 2400;
const LENGTH_M: f64 = 89.0;

fn objective(criterion: &mut Criterion) {
    let mut random = Seed(1).stream("bench");
    let along = |k: usize| LENGTH_M * k as f64 / (SNAPSHOTS - 1) as f64;
    let places = Places::Route((0..SNAPSHOTS).map(along).collect());
    let activation = Array2::from_shape_simple_fn((SNAPSHOTS, 4), || random.random_range(0.0..1.0));
    let weight = equal_weights(SNAPSHOTS);
    let mut group = criterion.benchmark_group("objective");
    for name in ["2m", "global"] {
        let uncertainty: Uncertainty = name.parse().expect("an uncertainty as users write it");
        let prior = PriorOperator::new(uncertainty, &places, &places);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let g = black_box(activation.view());
                evaluate(&prior, g, g, weight.view()).expect("four features are not too many")
            });
        });
    }
    group.finish();
}

criterion_group!(benches, objective);
criterion_main!(benches);
