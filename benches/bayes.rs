//! One step of the Bayes filter over a plane grid: over a million cells, of which all hold mass, beside a plain copy of
//! the masses; and over 7.2 million once the belief has settled.

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

const STEP: Displacement = Displacement {
    forward_m: 0.5,
    left_m: 0.02,
    turn_rad: 0.1,
};

/// Places every metre of a square floor, in four headings.
fn square(edge: u32) -> Places {
    let poses = (0..4 * edge * edge).map(|i| {
        let (x, y, quarter) = (i % edge, i / edge % edge, i / (edge * edge));
        Pose::new(
            f64::from(x),
            f64::from(y),
            f64::from(quarter) * std::f64::consts::FRAC_PI_2,
        )
    });
    Places::Plane(poses.collect())
}

fn million_cells(criterion: &mut Criterion) {
    // 204 × 204 sites or so.
    let mapped = square(50);
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
    let mut stream = Seed(0).stream("features");

    let mut group = criterion.benchmark_group("bayes_step");
    group
        .sample_size(20)
        .throughput(criterion::Throughput::Elements(grid.len() as u64));
    let mut copied = vec![0.0; grid.len()];
    group.bench_function("copy", |bencher| {
        bencher.iter(|| {
            copied.copy_from_slice(black_box(robot.belief().mass()));
            black_box(&mut copied);
        });
    });
    group.bench_function("predict", |bencher| {
        bencher.iter(|| robot.predict(black_box(&STEP)).expect("a finite movement"));
    });
    group.bench_function("million_cells", |bencher| {
        bencher.iter(|| {
            robot.predict(black_box(&STEP)).expect("a finite movement");
            let g = black_box([0.9, 0.2, 0.7, 0.4]);
            let log_likelihood = Evidence::Jeffrey
                .log_likelihood(&g, &map, robot.belief(), &mut stream)
                .expect("four probabilities");
            robot.correct(&log_likelihood).expect("the map has a floor");
        });
    });
    group.finish();
}

/// The robot goes a step and back again, 7.2 million states of 15 cm and 2°, the likelihood a Gaussian with a floor: after
/// 60 steps only cells around the robot have mass.
fn settled(criterion: &mut Criterion) {
    let config = GridConfig {
        cell_m: 0.15,
        headings: 180,
        ..GridConfig::default()
    };
    let grid = Arc::new(Grid::over(&square(29), &config).expect("7.2 million cells fit"));
    let start = Pose::new(14.0, 14.0, 0.4);
    let there = start.after(STEP);
    let movements = [STEP, there.displacement_to(&start)];
    let log_likelihoods = [there, start].map(|pose| {
        let truth = Places::Plane(vec![pose]);
        let places = grid.places();
        let log = (0..grid.len()).map(|cell| {
            let distance = places.distance_m(cell, &truth, 0) / 0.5;
            let turn = places.turn_rad(cell, &truth, 0) / 0.3;
            -(0.5 * (distance * distance + turn * turn)).min(8.0)
        });
        log.collect::<Vec<f64>>()
    });
    let prior = Belief::uniform(grid.places()).expect("the grid has cells");
    let mut robot =
        BayesFilter::new(&grid, OdometryMotion::default(), prior).expect("default motion");
    let mut steps = movements.iter().zip(&log_likelihoods).cycle();
    let mut step = |robot: &mut BayesFilter| {
        if let Some((movement, log_likelihood)) = steps.next() {
            robot
                .predict(black_box(movement))
                .expect("a finite movement");
            robot.correct(log_likelihood).expect("it has a floor");
        }
    };
    for _ in 0..60 {
        step(&mut robot);
    }

    let mut group = criterion.benchmark_group("bayes_step");
    group
        .sample_size(20)
        .throughput(criterion::Throughput::Elements(grid.len() as u64));
    group.bench_function("settled_7_million", |bencher| {
        bencher.iter(|| step(&mut robot));
    });
    group.finish();
}

criterion_group!(benches, million_cells, settled);
criterion_main!(benches);
