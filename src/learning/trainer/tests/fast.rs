//! Is the fast path the other one, only faster?

use super::*;
use crate::detector::net::Activation;

type Change = fn(&mut Recipe);

/// Recipes that the fast path takes, each with something of its own.
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
                r.descent.objective = Objective::MeanField;
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
        let lesson = lesson(&recipe, &recording);
        let mut fast = Trainer::new(&recipe, &lesson, &Device::flex());
        let mut slow = Trainer::new(&recipe, &lesson, &Device::flex()).on_tensors();
        assert!(fast.fast.is_some() && slow.fast.is_none(), "{name}");
        let start = slow.now.nets.weights().unwrap();
        for step in 0..20 {
            fast.step().unwrap();
            slow.step().unwrap();
            let apart = (fast.now.training - slow.now.training).abs();
            assert!(apart < 1e-5, "{name}, step {step}: {apart}");
        }
        fast.settle();
        assert_eq!(fast.now.evaluations, slow.now.evaluations, "{name}");
        assert_eq!(fast.steps(), slow.steps(), "{name}");
        assert_eq!(fast.now.descent.steps, slow.now.descent.steps, "{name}");
        let largest = |w: &ndarray::Array3<f32>| w.iter().fold(0f32, |most, w| most.max(w.abs()));
        let (fast, slow) = (fast.now.nets.weights(), slow.now.nets.weights());
        let layers = fast.unwrap().layers.into_iter().zip(slow.unwrap().layers);
        for ((fast, slow), start) in layers.zip(start.layers) {
            let all = largest(&slow.weight);
            let (apart, moved) = (slow.weight - &fast.weight, start.weight - &fast.weight);
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
        let lesson = lesson(&recipe, &recording);
        let new = || Trainer::new(&recipe, &lesson, &Device::flex());
        let (mut whole, mut first, mut second) = (new(), new(), new());
        (0..23).for_each(|_| whole.step().unwrap());
        (0..11).for_each(|_| first.step().unwrap());
        first.settle();
        second.take_up(first.now).unwrap();
        (0..12).for_each(|_| second.step().unwrap());
        whole.settle();
        second.settle();
        let (whole, second) = (whole.now, second.now);
        assert_eq!(
            whole.nets.weights().unwrap(),
            second.nets.weights().unwrap(),
            "{name}"
        );
        assert_eq!(whole.evaluations, second.evaluations, "{name}");
        assert_eq!(whole.training, second.training, "{name}");
    }
}

#[test]
fn many_snapshots_give_the_same_bits_on_any_number_of_threads() {
    // Enough of them for several shares.
    let recording = recording_of(700);
    for (name, recipe) in taken() {
        let lesson = lesson(&recipe, &recording);
        let in_pool = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| {
                let mut trainer = Trainer::new(&recipe, &lesson, &Device::flex());
                (0..10).for_each(|_| trainer.step().unwrap());
                trainer.settle();
                (trainer.now.nets.weights().unwrap(), trainer.now.training)
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
        ("draws", |r| r.descent.queries = 10),
        ("limit", |r| r.descent.gradient_limit = 1.0),
        ("sequential", |r| r.descent.sequential = true),
    ];
    for (name, change) in changes {
        let mut recipe = recipe();
        change(&mut recipe);
        let lesson = lesson(&recipe, &recording);
        let trainer = Trainer::new(&recipe, &lesson, &Device::flex());
        assert!(trainer.fast.is_none(), "{name}");
    }
}

#[test]
fn an_objective_that_is_no_number_stops_the_training() {
    let mut recipe = recipe();
    recipe.augmentation.input_noise = 0.0;
    let recording = recording();
    let mut lesson = lesson(&recipe, &recording);
    lesson.inputs[[3, 0]] = f32::NAN;
    let mut trainer = Trainer::new(&recipe, &lesson, &Device::flex());
    let error = trainer.step().unwrap_err().to_string();
    assert!(
        error.contains("no longer a number after 0 steps"),
        "{error}"
    );
}
