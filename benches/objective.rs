//! One evaluation of the objective with its gradient, K = 2,400 snapshots, four features, in `f32` as training has it
//! and in `f64`: along a route of 89 m, and in the plane on a drive to and fro through ten rows of 8.9 m.

use ballmark::{
    belief::{Places, Uncertainty},
    geometry::Pose,
    learning::{
        objective::{Objective, equal_weights},
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
const ROWS: usize = 10;

fn route() -> Places {
    let along = |k: usize| LENGTH_M * k as f64 / (SNAPSHOTS - 1) as f64;
    Places::Route((0..SNAPSHOTS).map(along).collect())
}

/// Rows 1 m apart, driven there and back in turn.
fn plane() -> Places {
    let in_row = SNAPSHOTS / ROWS;
    let pose = |k: usize| {
        let (row, x_m) = (
            k / in_row,
            LENGTH_M / ROWS as f64 * (k % in_row) as f64 / in_row as f64,
        );
        match row % 2 {
            0 => Pose::new(x_m, row as f64, 0.0),
            _ => Pose::new(
                LENGTH_M / ROWS as f64 - x_m,
                row as f64,
                std::f64::consts::PI,
            ),
        }
    };
    Places::Plane((0..SNAPSHOTS).map(pose).collect())
}

fn objective(criterion: &mut Criterion) {
    let mut random = Seed(1).stream("bench");
    let fine = Array2::from_shape_simple_fn((SNAPSHOTS, 4), || random.random_range(0.0..1.0f64));
    let coarse = fine.mapv(|g| g as f32);
    let weight = equal_weights(SNAPSHOTS);
    let mut group = criterion.benchmark_group("objective");
    for (where_, places) in [("route", route()), ("plane", plane())] {
        for name in ["2m", "global"] {
            let uncertainty: Uncertainty = name.parse().expect("an uncertainty as users write it");
            let prior = PriorOperator::new(uncertainty, &places, &places);
            let mut objective = Objective::<f32>::new();
            group.bench_function(format!("{where_}, {name}, f32"), |bencher| {
                // Within the thread pool, as a training step evaluates it.
                rayon::scope(|_| {
                    bencher.iter(|| {
                        let g = black_box(coarse.view());
                        let e = objective.evaluate(&prior, g, g, weight.view());
                        e.expect("four features are not too many").posterior_error_m
                    });
                });
            });
            let mut objective = Objective::<f64>::new();
            group.bench_function(format!("{where_}, {name}, f64"), |bencher| {
                bencher.iter(|| {
                    let g = black_box(fine.view());
                    let e = objective.evaluate(&prior, g, g, weight.view());
                    e.expect("four features are not too many").posterior_error_m
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, objective);
criterion_main!(benches);
