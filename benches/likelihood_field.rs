//! How long a map takes to be asked: `likelihood_field/step` is one scan of 36 beams at all of about 292,000 cells (0.25 m,
//! 24 headings), `likelihood_field/copy` a copy of as many sums; `monte_carlo/step` is a step of 5,000 particles, motion, one
//! scan of 36 beams and drawing anew.

use ballmark::{
    belief::{Grid, GridConfig, OdometryMotion, Places},
    geometry::Pose,
    localiser::{
        Localiser,
        likelihood_field::FieldOverGrid,
        monte_carlo::{MonteCarlo, MonteCarloConfig},
    },
    mapping::{LikelihoodField, LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig},
    recording::{Channel, Columns, Recording},
    seed::Seed,
};
use criterion::{Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use std::{f64::consts::PI, hint::black_box, sync::Arc, time::Instant};

/// A hall, metres from west to east and from south to north.
const HALL_M: [f64; 2] = [32.0, 26.0];
const BEAMS: usize = 180;

/// Metres from a pose to the hall's wall.
fn range_m(pose: &Pose, bearing_rad: f64) -> f64 {
    let (sin, cos) = (pose.heading_rad + bearing_rad).sin_cos();
    let to_wall = |at: f64, size: f64, along: f64| match along {
        a if a > 1e-9 => (size - at) / a,
        a if a < -1e-9 => -at / a,
        _ => f64::INFINITY,
    };
    to_wall(pose.x_m, HALL_M[0], cos).min(to_wall(pose.y_m, HALL_M[1], sin))
}

fn hall() -> Recording {
    let poses: Vec<Pose> = (0..30 * 24)
        .map(|k| {
            Pose::new(
                1.5 + f64::from(k % 30),
                1.5 + f64::from(k / 30),
                f64::from(k),
            )
        })
        .collect();
    let bearings: Vec<f64> = (0..BEAMS)
        .map(|beam| PI * (beam as f64 / BEAMS as f64 - 0.5))
        .collect();
    let values = Array2::from_shape_fn((poses.len(), BEAMS), |(k, beam)| {
        range_m(&poses[k], bearings[beam]) as f32
    });
    let laser = Channel {
        name: "laser".into(),
        width: BEAMS,
        unit: "m".into(),
        bearing_rad: Some(bearings),
        maximum: None,
        offset_m: None,
    };
    Recording::new(Columns {
        channels: vec![laser],
        values,
        stamp_s: (0..poses.len()).map(|k| k as f64).collect(),
        odometry: poses.clone(),
        run: vec![0; poses.len()],
        pose: poses,
        ..Columns::default()
    })
    .expect("a sound recording")
}

fn step(criterion: &mut Criterion) {
    let recording = hall();
    let all: Vec<usize> = (0..recording.len()).collect();
    let map = OccupancyMap::from_scans(&recording, &all, &OccupancyMapConfig::default())
        .expect("the walls are seen");
    let field =
        LikelihoodField::new(&map, &LikelihoodFieldConfig::default()).expect("default constants");
    let config = GridConfig {
        margin_m: 0.9,
        ..GridConfig::default()
    };
    let grid = Arc::new(Grid::over(&Places::of(&recording), &config).expect("the grid fits"));
    let over_grid = FieldOverGrid::new(&field, &grid).expect("a grid in the plane");
    let beams = field
        .beams(recording.channels(), &recording.observation(100))
        .expect("a laser");
    let mut group = criterion.benchmark_group("likelihood_field");
    group
        .sample_size(50)
        .throughput(criterion::Throughput::Elements(grid.len() as u64));
    group.bench_function("step", |bencher| {
        bencher.iter(|| over_grid.log_likelihood(black_box(&beams)));
    });
    let sums = over_grid.log_likelihood(&beams);
    group.bench_function("copy", |bencher| bencher.iter(|| black_box(&sums).clone()));
    group.finish();

    let config = MonteCarloConfig {
        least_particles: 5000, // however certain the robot is
        ..MonteCarloConfig::default()
    };
    let monte_carlo = MonteCarlo::new(Arc::new(field), OdometryMotion::default(), grid, config)
        .expect("a grid in the plane");
    // To and fro along the first row of the hall.
    let way: Vec<usize> = (0..29).chain((1..30).rev()).collect();
    let player = monte_carlo
        .prepare(&recording, &way)
        .expect("the sensor of the map");
    criterion.bench_function("monte_carlo/step", |bencher| {
        bencher.iter_custom(|steps| {
            let trial: Vec<usize> = (0..steps as usize).map(|i| way[i % way.len()]).collect();
            let start = Some(recording.poses()[0]);
            let began = Instant::now();
            let steps = player.play(&trial, start, &mut Seed(1).stream("a trial"));
            black_box(steps.expect("a sound trial"));
            began.elapsed()
        });
    });
}

criterion_group!(benches, step);
criterion_main!(benches);
