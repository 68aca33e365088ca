//! One whole training step (noise, forward, objective with the map in it, backward, Adam) of four networks 164→6→1 on
//! K = 2,400 snapshots along a route of 89 m.

use ballmark::{
    detector::device::cpu,
    geometry::Pose,
    learning::{Recipe, lesson::Lesson, trainer::Trainer},
    recording::{Channel, Columns, Recording, split::Split},
    seed::Seed,
};
use criterion::{Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use rand::RngExt;

const SNAPSHOTS: usize = 2400;
const LENGTH_M: f64 = 89.0;
const INPUTS: usize = 164;

/// One drive along the route with sensors of no particular kind, which are fed to the networks as they are.
fn recording() -> Recording {
    let mut random = Seed(1).stream("bench");
    let along = |k: usize| LENGTH_M * k as f64 / (SNAPSHOTS - 1) as f64;
    let pose: Vec<Pose> = (0..SNAPSHOTS)
        .map(|k| Pose::new(along(k), 0.0, 0.0))
        .collect();
    Recording::new(Columns {
        channels: vec![Channel {
            name: "light".into(),
            width: INPUTS,
            unit: "lux".into(),
            bearing_rad: None,
            maximum: None,
        }],
        values: Array2::from_shape_simple_fn((SNAPSHOTS, INPUTS), || random.random_range(0.0..1.0)),
        stamp_s: (0..SNAPSHOTS).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        pose,
        run: vec![0; SNAPSHOTS],
        route_m: Some((0..SNAPSHOTS).map(along).collect()),
        ..Columns::default()
    })
    .expect("columns of one length")
}

fn training_step(criterion: &mut Criterion) {
    let recording = recording();
    let everything = Split {
        train: (0..SNAPSHOTS).collect(),
        validation: Vec::new(),
        test: Vec::new(),
    };
    let mut group = criterion.benchmark_group("training_step");
    for name in ["2m", "global"] {
        let recipe = Recipe {
            uncertainty: name.parse().expect("an uncertainty as users write it"),
            ..Recipe::default()
        };
        let lesson = Lesson::prepare(&recipe, &recording, &everything).expect("enough snapshots");
        let mut trainer = Trainer::new(&recipe, &lesson, &cpu());
        group.bench_function(name, |bencher| {
            bencher.iter(|| trainer.step().expect("a finite objective"));
        });
    }
    group.finish();
}

criterion_group!(benches, training_step);
criterion_main!(benches);
