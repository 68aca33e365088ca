//! One whole training step (noise, forward, objective with the map in it, backward, Adam) of four networks 164→6→1 on
//! K = 2,400 snapshots along a route of 89 m; and, as `fast`, all of it but the objective by stacked networks.

use ballmark::{
    detector::{
        device::cpu,
        net::{NetConfig, Weights},
        stacked::{Noise, Stacked},
    },
    geometry::Pose,
    learning::{
        Recipe,
        lesson::Lesson,
        optimiser::in_place::InPlace,
        recipe::{DescentConfig, Optimiser},
        trainer::Trainer,
    },
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

/// Four networks of six hidden units, all snapshots at every step, Adam, noise on the inputs, the map in the objective.
fn small_networks() -> Recipe {
    let mut recipe = Recipe::thrun1998();
    recipe.descent = DescentConfig {
        optimiser: Optimiser::Adam,
        learning_rate: 0.03,
        weight_decay: 0.01,
        map_in_objective: true,
        pseudo_pattern_steps: 1,
        ..recipe.descent
    };
    recipe.augmentation.input_noise = 0.3;
    recipe
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
            ..small_networks()
        };
        let lesson = Lesson::prepare(&recipe, &recording, &everything).expect("enough snapshots");
        let mut trainer = Trainer::new(&recipe, &lesson, &cpu());
        group.bench_function(name, |bencher| {
            bencher.iter(|| trainer.step().expect("a finite objective"));
        });
    }
    group.finish();
}

/// Forward, backward and Adam without an objective between them: one whose slope never changes stands in for it.
fn fast(criterion: &mut Criterion) {
    let mut random = Seed(1).stream("bench");
    let mut draw = |rows, columns| {
        Array2::from_shape_simple_fn((rows, columns), || random.random_range(-1f32..1.0))
    };
    let (inputs, slope) = (draw(SNAPSHOTS, INPUTS), draw(SNAPSHOTS, 4) * 1e-4);
    let bank = draw(1, 1 << 20).into_raw_vec_and_offset().0;
    let net = NetConfig::thrun1998();
    let mut weights = Weights::random(&net, INPUTS, 4, &mut Seed(1).stream("weights"));
    let mut gradient = weights.clone();
    let mut activation = Array2::zeros((SNAPSHOTS, 4));
    let mut stacked = Stacked::new(&weights);
    let mut descent = InPlace::new(&DescentConfig::default());
    let mut group = criterion.benchmark_group("fast");
    for name in ["without noise", "with noise"] {
        let mut step = 0;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                step += 1;
                let noise = (name == "with noise").then(|| Noise {
                    bank: &bank,
                    start: step * 7919 % bank.len(),
                    deviation: 0.3,
                });
                stacked
                    .forward(&weights, inputs.view(), noise, activation.view_mut())
                    .expect("networks of this shape");
                stacked
                    .backward(slope.view(), &mut gradient)
                    .expect("the same inputs");
                descent
                    .step(&mut weights, &gradient)
                    .expect("weights of one shape");
            });
        });
    }
    group.finish();
}

criterion_group!(benches, training_step, fast);
criterion_main!(benches);
