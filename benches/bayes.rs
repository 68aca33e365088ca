//! One step of the Bayes filter: predict and correct a belief over a million cells of a 24-heading plane grid.

use ballmark::{
    belief::{
        BayesFilter, Belief, Evidence, FeatureMap, Grid, GridConfig, MapConfig, OdometryMotion,
        Places,
    },
    geometry::{Displacement, Pose},
    seed::Seed,
};
use criterion::{Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use std::{hint::black_box, sync::Arc};

fn million_cells(criterion: &mut Criterion) {
    // Snapshots every metre on a 50 m by 50 m floor, in four headings: 204 × 204 sites or so.
    let poses = (0..10_000).map(|i| {
        let (x, y, quarter) = (i % 50, i / 50 % 50, i / 2500);
        Pose::new(
            f64::from(x),
            f64::from(y),
            f64::from(quarter) * std::f64::consts::FRAC_PI_2,
        )
    });
    let mapped = Places::Plane(poses.collect());
    let grid =
        Arc::new(Grid::over(&mapped, &GridConfig::default()).expect("the default grid fits"));
    let activation = Array2::from_shape_fn((mapped.len(), 4), |(k, i)| {
        ((7 * k + 3 * i) % 11) as f64 / 10.0
    });
    let map = FeatureMap::new(mapped, activation, MapConfig::default())
        .and_then(|map| map.at(grid.places()))
        .expect("10,000 snapshots make a map");
    let prior = Belief::uniform(grid.places()).expect("the grid has cells");
    let mut robot =
        BayesFilter::new(&grid, OdometryMotion::default(), prior).expect("default motion");
    let step = Displacement {
        forward_m: 0.5,
        left_m: 0.02,
        turn_rad: 0.1,
    };
    let mut stream = Seed(0).stream("features");

    let mut group = criterion.benchmark_group("bayes_step");
    group
        .sample_size(20)
        .throughput(criterion::Throughput::Elements(grid.len() as u64));
    group.bench_function("million_cells", |bencher| {
        bencher.iter(|| {
            robot.predict(black_box(&step)).expect("a finite movement");
            let g = black_box([0.9, 0.2, 0.7, 0.4]);
            let log_likelihood = Evidence::Jeffrey
                .log_likelihood(&g, &map, robot.belief(), &mut stream)
                .expect("four probabilities");
            robot.correct(&log_likelihood).expect("the map has a floor");
        });
    });
    group.finish();
}

criterion_group!(benches, million_cells);
criterion_main!(benches);
