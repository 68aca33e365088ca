//! Is the array backend the other one, only faster?

use super::*;
use crate::detector::net::Activation;

type Change = fn(&mut Recipe);

/// Recipes that the array backend takes, each with something of its own.
fn taken() -> Vec<(&'static str, Recipe)> {
    let with = |change: Change| {
        let mut recipe = recipe();
        change(&mut recipe);
        recipe
    };
    vec![
        ("Adam, map, noise", recipe()),
        (
            "momentum, neither",
            with(|r| {
                r.descent.optimiser = Optimiser::Momentum;
                r.descent.learning_rate = 10.0;
                r.descent.map_in_objective = false;
                r.augmentation.input_noise = 0.0;
            }),
        ),
        (
            "pseudo-patterns",
            with(|r| {
                r.descent.optimiser = Optimiser::Momentum;
                (r.descent.pseudo_pattern_steps, r.descent.scale) = (7, Scale::Sum);
                r.descent.learning_rate = 2e-3;
            }),
        ),
        (
            "mean field, two layers",
            with(|r| {
                r.descent.objective = ObjectiveKind::MeanField;
                r.network.hidden = vec![4, 2];
                r.network.activation = Activation::Tanh;
                r.features = 3;
                r.uncertainty = "2m".parse().unwrap();
            }),
        ),
    ]
}

#[test]
fn twenty_steps_end_where_tensors_end() {
    let recording = recording();
    for (name, recipe) in taken() {
        let training_set = training_set(&recipe, &recording);
        let mut array_backend = Trainer::new(&recipe, &training_set, &Device::flex());
        let mut slow = Trainer::new(&recipe, &training_set, &Device::flex()).on_tensors();
        assert!(
            array_backend.array_backend.is_some() && slow.array_backend.is_none(),
            "{name}"
        );
        let start = slow.now.nets.weights().unwrap();
        for step in 0..20 {
            array_backend.step().unwrap();
            slow.step().unwrap();
            let apart =
                (array_backend.now.batch_error_reduction - slow.now.batch_error_reduction).abs();
            assert!(apart < 1e-5, "{name}, step {step}: {apart}");
        }
        array_backend.sync();
        assert_eq!(
            array_backend.now.evaluations, slow.now.evaluations,
            "{name}"
        );
        assert_eq!(array_backend.steps(), slow.steps(), "{name}");
        assert_eq!(
            array_backend.now.descent.steps, slow.now.descent.steps,
            "{name}"
        );
        let largest = |w: &ndarray::Array3<f32>| w.iter().fold(0f32, |most, w| most.max(w.abs()));
        let (array_backend, slow) = (array_backend.now.nets.weights(), slow.now.nets.weights());
        let layers = array_backend
            .unwrap()
            .layers
            .into_iter()
            .zip(slow.unwrap().layers);
        for ((array_backend, slow), start) in layers.zip(start.layers) {
            let all = largest(&slow.weight);
            let (apart, moved) = (
                slow.weight - &array_backend.weight,
                start.weight - &array_backend.weight,
            );
            let (apart, moved) = (largest(&apart), largest(&moved));
            assert!(
                apart < 1e-4 * all && moved > 1e-2 * all,
                "{name}: {apart}, {moved} of {all}"
            );
        }
    }
}

#[test]
fn a_settled_training_goes_on_to_the_same_bits() {
    let recording = recording();
    for (name, recipe) in taken() {
        let training_set = training_set(&recipe, &recording);
        let new = || Trainer::new(&recipe, &training_set, &Device::flex());
        let (mut whole, mut first, mut second) = (new(), new(), new());
        (0..23).for_each(|_| whole.step().unwrap());
        (0..11).for_each(|_| first.step().unwrap());
        first.sync();
        second.load(first.now).unwrap();
        (0..12).for_each(|_| second.step().unwrap());
        whole.sync();
        second.sync();
        let (whole, second) = (whole.now, second.now);
        assert_eq!(
            whole.nets.weights().unwrap(),
            second.nets.weights().unwrap(),
            "{name}"
        );
        assert_eq!(whole.evaluations, second.evaluations, "{name}");
        assert_eq!(
            whole.batch_error_reduction, second.batch_error_reduction,
            "{name}"
        );
    }
}

#[test]
fn many_snapshots_give_the_same_bits_on_any_number_of_threads() {
    // Enough of them for several shares.
    let recording = recording_of(700);
    for (name, recipe) in taken() {
        let training_set = training_set(&recipe, &recording);
        let in_pool = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| {
                let mut trainer = Trainer::new(&recipe, &training_set, &Device::flex());
                (0..10).for_each(|_| trainer.step().unwrap());
                trainer.sync();
                (
                    trainer.now.nets.weights().unwrap(),
                    trainer.now.batch_error_reduction,
                )
            })
        };
        assert_eq!(in_pool(1), in_pool(4), "{name}");
    }
}

#[test]
fn what_only_tensors_do_is_left_to_them() {
    let recording = recording();
    let changes: [(&str, Change); 6] = [
        ("trunk", |r| {
            r.network.trunk = vec![4];
        }),
        ("gain", |r| r.network.gain = 2.0),
        ("conjugate gradient", |r| {
            r.descent.optimiser = Optimiser::ConjugateGradient;
        }),
        ("draws", |r| r.descent.truths_per_step = 10),
        ("limit", |r| r.descent.gradient_limit = 1.0),
        ("sequential", |r| r.descent.sequential = true),
    ];
    for (name, change) in changes {
        let mut recipe = recipe();
        change(&mut recipe);
        let training_set = training_set(&recipe, &recording);
        let trainer = Trainer::new(&recipe, &training_set, &Device::flex());
        assert!(trainer.array_backend.is_none(), "{name}");
    }
}

#[test]
fn an_objective_that_is_no_number_stops_the_training() {
    let mut recipe = recipe();
    recipe.augmentation.input_noise = 0.0;
    let recording = recording();
    let mut training_set = training_set(&recipe, &recording);
    training_set.inputs[[3, 0]] = f32::NAN;
    let mut trainer = Trainer::new(&recipe, &training_set, &Device::flex());
    let error = trainer.step().unwrap_err().to_string();
    assert!(
        error.contains("no longer a number after 0 steps"),
        "{error}"
    );
}
