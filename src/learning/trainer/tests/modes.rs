//! Thrun's (1998) own ways of training: pseudo-patterns, conjugate gradients, sequential, online and mini-batch.

use super::{pseudo_patterns::PseudoPatterns, *};
use crate::detector::net::values;
use burn::tensor::Tensor;

/// Momentum on the objective as printed, at a rate that gets somewhere in little time.
fn thrun() -> Recipe {
    let recipe = recipe();
    let descent = DescentConfig {
        optimiser: Optimiser::Momentum,
        scale: Scale::PriorShare,
        learning_rate: 1.0,
        weight_decay: 0.0,
        map_in_objective: false,
        pseudo_pattern_steps: 1,
        steps: 200,
        patience: 200,
        ..recipe.descent
    };
    let mut recipe = Recipe { descent, ..recipe };
    recipe.augmentation.input_noise = 0.0;
    recipe
}

fn with(change: impl Fn(&mut DescentConfig)) -> Recipe {
    let mut recipe = thrun();
    change(&mut recipe.descent);
    recipe
}

fn modes() -> Vec<(&'static str, Recipe)> {
    let modes: [(_, fn(&mut DescentConfig)); 8] = [
        ("batch", |_| ()),
        ("pseudo-patterns", |d| {
            // Targets of the summed error lie far enough off for many steps towards them.
            (d.pseudo_pattern_steps, d.scale, d.learning_rate) = (20, Scale::Sum, 2e-3);
        }),
        ("conjugate gradients", |d| {
            d.optimiser = Optimiser::ConjugateGradient;
            d.steps = 60;
        }),
        ("conjugate gradients on pseudo-patterns", |d| {
            d.optimiser = Optimiser::ConjugateGradient;
            (d.pseudo_pattern_steps, d.scale) = (10, Scale::Sum);
        }),
        ("sequential", |d| d.sequential = true),
        ("sequential on pseudo-patterns", |d| {
            d.sequential = true;
            (d.pseudo_pattern_steps, d.scale, d.learning_rate) = (9, Scale::Sum, 2e-3);
        }),
        ("online", |d| {
            (d.truths_per_step, d.steps, d.learning_rate) = (1, 600, 0.1);
        }),
        ("mini-batch", |d| d.truths_per_step = 20),
    ];
    let made = modes.map(|(name, change)| (name, with(change)));
    for (name, recipe) in &made {
        assert!(recipe.check().is_ok(), "{name}: {:?}", recipe.check());
    }
    made.into()
}

/// The route's recording; the same without its route is one in the plane.
fn in_the_plane() -> Recording {
    let mut columns = recording().into_columns();
    columns.route_m = None;
    Recording::new(columns).unwrap()
}

#[test]
fn every_mode_learns_on_a_route_and_in_the_plane() {
    for (name, recipe) in modes() {
        for recording in [recording(), in_the_plane()] {
            let training_set = training_set(&recipe, &recording);
            let trained = run(&recipe, &training_set).unwrap();
            let where_ = match recording.columns().route_m {
                Some(_) => "route",
                None => "plane",
            };
            let reduction = trained.train.error_reduction;
            assert!(reduction > 0.3, "{name}, {where_}: {reduction}");
        }
    }
}

#[test]
fn every_mode_resumes_to_the_same_bits() {
    let recording = recording();
    for (name, mut recipe) in modes() {
        recipe.descent = DescentConfig {
            steps: 40,
            checkpoint_every: 1,
            validate_every: 1,
            ..recipe.descent
        };
        let training_set = training_set(&recipe, &recording);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("now");
        let kept = |step: usize| folder.path().join(format!("{step}"));
        // Within a series, at its end, at the end of a phase, just past it.
        let killed_at = [1, 9, 10, 20, 21, 33];
        let mut keep = |p: Progress| {
            // A step's checkpoint is written after its progress is reported.
            if p.step > 0 && killed_at.contains(&(p.step - 1)) {
                std::fs::copy(&path, kept(p.step - 1)).unwrap();
            }
        };
        let whole = run_with(&recipe, &training_set, (&path, "it", false), &mut keep).unwrap();
        recipe.descent.checkpoint_every = 1000; // writing takes longer than all the rest
        for step in killed_at {
            let mut first = None;
            let mut see = |p: Progress| {
                first.get_or_insert(p.step);
            };
            let path = kept(step);
            let resumed = run_with(&recipe, &training_set, (&path, "it", true), &mut see).unwrap();
            assert_eq!(first, Some(step), "{name}");
            assert_eq!(resumed.weights, whole.weights, "{name} from {step}");
            assert_eq!(resumed.evaluations, whole.evaluations, "{name} from {step}");
        }
    }
}

#[test]
fn no_mode_depends_on_the_number_of_threads() {
    for (name, mut recipe) in modes() {
        recipe.descent.steps = 30;
        assert_eq!(with_threads(1, &recipe), with_threads(4, &recipe), "{name}");
    }
}

/// The networks after so many steps, and the evaluations on the way.
fn after(recipe: &Recipe, steps: usize) -> (Weights, usize) {
    let recording = recording();
    let training_set = training_set(recipe, &recording);
    let mut trainer = Trainer::new(recipe, &training_set, &Device::flex());
    (0..steps).for_each(|_| trainer.step().unwrap());
    trainer.sync();
    (trainer.now.nets.weights().unwrap(), trainer.now.evaluations)
}

#[test]
fn the_first_step_on_pseudo_patterns_is_the_plain_one_and_the_next_is_not() {
    let series = with(|d| d.pseudo_pattern_steps = 100);
    assert_eq!(after(&series, 1), after(&thrun(), 1));
    assert_ne!(after(&series, 2).0, after(&thrun(), 2).0);
    assert_eq!((after(&thrun(), 4).1, after(&series, 4).1), (4, 1));
}

#[test]
fn pseudo_patterns_pull_the_outputs_to_their_targets() {
    // Outputs that have moved from g to their targets have no residual left, and no error.
    let device = Device::flex();
    let of = |numbers: [f32; 2]| Tensor::<2>::from_data([numbers], &device);
    let patterns = PseudoPatterns {
        output: of([0.5, 0.25]),
        gradient: of([0.25, -0.5]),
    };
    let error = |output| patterns.error(of(output)).unwrap();
    assert_eq!(
        values(patterns.residual(of([0.5, 0.25]))).unwrap(),
        [0.25, -0.5]
    );
    assert_eq!(error([0.25, 0.75]), 0.0);
    assert_eq!(error([0.5, 0.25]), 0.5 * (0.0625 + 0.25));
}

#[test]
fn conjugate_gradients_come_further_than_momentum_on_as_many_evaluations() {
    let (momentum, conjugate) = (thrun(), &modes()[2].1);
    let recording = recording();
    let reached = |recipe: &Recipe| {
        let training_set = training_set(recipe, &recording);
        let mut trainer = Trainer::new(recipe, &training_set, &Device::flex());
        while trainer.now.evaluations < 60 {
            trainer.step().unwrap();
        }
        trainer.now.batch_error_reduction
    };
    let (momentum, conjugate) = (reached(&momentum), reached(conjugate));
    assert!(conjugate > momentum + 0.02, "{conjugate} {momentum}");
}

#[test]
fn conjugate_gradients_never_climb() {
    let recipe = &modes()[2].1;
    let recording = recording();
    let training_set = training_set(recipe, &recording);
    let mut trainer = Trainer::new(recipe, &training_set, &Device::flex());
    let mut last = f64::NEG_INFINITY;
    for step in 0..60 {
        trainer.step().unwrap();
        assert!(trainer.now.batch_error_reduction >= last, "step {step}");
        last = trainer.now.batch_error_reduction;
    }
}

#[test]
fn sequential_training_moves_one_network_after_another() {
    for optimiser in [
        Optimiser::Momentum,
        Optimiser::Adam,
        Optimiser::ConjugateGradient,
    ] {
        let mut recipe = with(|d| (d.sequential, d.steps) = (true, 30));
        recipe.features = 3;
        recipe.descent.optimiser = optimiser;
        if optimiser == Optimiser::Adam {
            recipe.descent.weight_decay = 0.1;
            recipe.descent.learning_rate = 0.03;
        }
        let bits = |weights: &Weights, feature: usize| -> Vec<u32> {
            let layers = weights.layers.iter().flat_map(|layer| {
                let weight = layer.weight.index_axis(ndarray::Axis(0), feature);
                let bias = layer.bias.index_axis(ndarray::Axis(0), feature);
                let both = weight.iter().chain(bias.iter()).copied();
                both.map(f32::to_bits).collect::<Vec<_>>()
            });
            layers.collect()
        };
        let at = [0, 10, 20, 30].map(|steps| after(&recipe, steps).0);
        for (phase, ends) in at.windows(2).enumerate() {
            for feature in 0..3 {
                let same = bits(&ends[0], feature) == bits(&ends[1], feature);
                assert_eq!(
                    same,
                    feature != phase,
                    "{optimiser:?}, phase {phase}, feature {feature}"
                );
            }
        }
    }
}

#[test]
fn a_later_feature_learns_what_the_earlier_ones_do_not_say() {
    // With the first feature frozen, the second one's gradient is that of the joint objective.
    let mut recipe = with(|d| (d.sequential, d.steps) = (true, 20));
    recipe.descent.learning_rate = 1e-2;
    let (start, end) = (after(&recipe, 10).0, after(&recipe, 11).0);
    let recording = recording();
    let training_set = training_set(&recipe, &recording);
    let device = Device::flex();
    let error = |weights: &Weights| {
        let output =
            Nets::new(weights, &device).forward(tensor(training_set.inputs.view(), &device));
        let (e, _) = training_set
            .objective(
                &mut Workspace::default(),
                array(output).unwrap().view(),
                false,
            )
            .unwrap();
        e.posterior_error_m / e.prior_error_m
    };
    let at = [1, 4, 0];
    let slope = f64::from(start.layers[1].weight[at] - end.layers[1].weight[at]) / 1e-2;
    let moved = |h: f32| {
        let mut weights = start.clone();
        weights.layers[1].weight[at] += h;
        error(&weights)
    };
    let numerical = (moved(2e-2) - moved(-2e-2)) / 4e-2;
    assert!(numerical.abs() > 1e-5, "{numerical}");
    let tolerance = 2e-2 * numerical.abs() + 2e-5;
    assert!((slope - numerical).abs() < tolerance, "{slope} {numerical}");
}

#[test]
fn the_sum_is_the_share_times_truths_and_prior_error() {
    let recording = recording();
    let training_set = training_set(&thrun(), &recording);
    let (e, _) = training_set
        .objective(
            &mut Workspace::default(),
            Array2::from_elem((training_set.places.len(), 2), 0.5).view(),
            false,
        )
        .unwrap();
    let factor = training_set.places.len() as f64 * e.prior_error_m;
    let sum = with(|d| (d.scale, d.learning_rate) = (Scale::Sum, 0.5 / factor));
    let share = with(|d| d.learning_rate = 0.5);
    let (sum, share) = (after(&sum, 3).0, after(&share, 3).0);
    for (sum, share) in sum.layers.iter().zip(&share.layers) {
        let apart = (&sum.weight - &share.weight).mapv(f32::abs);
        assert!(apart.iter().all(|d| *d < 1e-5), "{apart:?}");
    }
}

#[test]
fn what_does_not_go_together_is_refused_by_name() {
    let mut trunk = with(|d| d.sequential = true);
    trunk.network.trunk = vec![8];
    let mut noisy = modes().remove(2).1;
    noisy.augmentation.input_noise = 0.1;
    let mut wide = thrun();
    wide.descent.objective = ObjectiveKind::MeanField;
    wide.descent.scale = Scale::Sum;
    for (recipe, key) in [
        (trunk, "descent.sequential"),
        (noisy, "augmentation.input_noise"),
        (wide, "descent.scale"),
        (
            with(|d| d.pseudo_pattern_steps = 0),
            "descent.pseudo_pattern_steps",
        ),
        (
            with(|d| (d.sequential, d.steps) = (true, 1)),
            "descent.steps",
        ),
        (
            with(|d| (d.optimiser, d.truths_per_step) = (Optimiser::ConjugateGradient, 3)),
            "descent.truths_per_step",
        ),
    ] {
        let error = recipe.check().unwrap_err().to_string();
        assert!(error.contains(key) && error.contains("expected"), "{error}");
    }
}
