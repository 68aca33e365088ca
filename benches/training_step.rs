//! One whole training step (forward, objective, backward, Adam) of four networks 164→6→1 on K = 2,400 snapshots along a
//! route of 89 m: `training_step` as training takes it, `burn` on tensors. Beside it what it is made of, `objective` and `networks`.

use ballmark::{
    belief::Places,
    detector::{
        device::cpu,
        net::{NetConfig, Weights},
        stacked::{Noise, Stacked},
    },
    learning::{
        Recipe,
        objective::{Objective, equal_weights},
        optimiser::InPlace,
        prior_operator::PriorOperator,
        recipe::DescentConfig,
        trainer::Trainer,
        training_set::TrainingSet,
    },
    recording::split::Split,
    seed::Seed,
};
use criterion::{Criterion, criterion_group, criterion_main};
use ndarray::Array2;
use rand::RngExt;
use small_networks::INPUTS;

mod small_networks;

const SNAPSHOTS: usize = 2400;
const LENGTH_M: f64 = 89.0;

type Change = fn(&mut Recipe);

/// Whole steps, by plain arrays or by tensors. `2m` and `global` are the step that the peers' scripts take; the others do
/// more: noise on the inputs, the map in the objective, a hundred steps on one evaluation.
fn steps(criterion: &mut Criterion, group: &str, by_tensors: bool) {
    let recording = small_networks::recording(SNAPSHOTS, LENGTH_M);
    let everything = Split {
        train: (0..SNAPSHOTS).collect(),
        validation: Vec::new(),
        test: Vec::new(),
    };
    let plain = |_: &mut Recipe| ();
    let cases: [(&str, &str, Change); 5] = [
        ("2m", "2m", plain),
        ("global", "global", plain),
        ("2m, noise", "2m", |r| r.augmentation.input_noise = 0.3),
        ("2m, noise, map", "2m", |r| {
            r.augmentation.input_noise = 0.3;
            r.descent.map_in_objective = true;
        }),
        ("2m, pseudo-patterns", "2m", |r| {
            r.descent.pseudo_pattern_steps = 100;
        }),
    ];
    let mut group = criterion.benchmark_group(group);
    for (name, uncertainty, change) in cases {
        let mut recipe = Recipe {
            uncertainty: uncertainty.parse().expect("as users write it"),
            ..small_networks::recipe()
        };
        change(&mut recipe);
        let training_set =
            TrainingSet::prepare(&recipe, &recording, &everything).expect("enough snapshots");
        let mut trainer = Trainer::new(&recipe, &training_set, &cpu());
        if by_tensors {
            trainer = trainer.on_tensors();
        }
        group.bench_function(name, |bencher| {
            bencher.iter(|| trainer.step().expect("a finite objective"));
        });
    }
    group.finish();
}

fn fast(criterion: &mut Criterion) {
    steps(criterion, "training_step", false);
}

fn burn(criterion: &mut Criterion) {
    steps(criterion, "burn", true);
}

/// The objective alone, with its gradient.
fn objective(criterion: &mut Criterion) {
    let mut random = Seed(1).stream("bench");
    let along = |k: usize| LENGTH_M * k as f64 / (SNAPSHOTS - 1) as f64;
    let places = Places::Route((0..SNAPSHOTS).map(along).collect());
    let g = Array2::from_shape_simple_fn((SNAPSHOTS, 4), || random.random_range(0.0..1.0f32));
    let weight = equal_weights(SNAPSHOTS);
    let mut group = criterion.benchmark_group("objective");
    for name in ["2m", "global"] {
        let uncertainty = name.parse().expect("as users write it");
        let prior = PriorOperator::new(uncertainty, &places, &places);
        let mut objective = Objective::<f32>::new();
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let e = objective.evaluate(&prior, g.view(), g.view(), weight.view());
                e.expect("four features are not too many").posterior_error_m
            });
        });
    }
    group.finish();
}

/// Forward, backward and Adam without an objective between them: one whose slope never changes stands in for it.
fn networks(criterion: &mut Criterion) {
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
    let mut group = criterion.benchmark_group("networks");
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
                    .backward(inputs.view(), noise, slope.view(), &mut gradient)
                    .expect("the same inputs");
                descent
                    .step(&mut weights, &gradient)
                    .expect("weights of one shape");
            });
        });
    }
    group.finish();
}

criterion_group!(benches, fast, burn, objective, networks);
criterion_main!(benches);
