//! Does training learn, follow the gradient, and end in the same bits every time?

use super::*;
use crate::{
    belief::Uncertainty,
    detector::net::NetConfig,
    geometry::Pose,
    learning::recipe::{AugmentationConfig, DescentConfig, Objective, Optimiser, Scale},
    recording::{
        Channel, Columns, Recording,
        split::{SplitConfig, Unit},
    },
};
use ndarray::Array2;
use rand::RngExt;

mod array_backend;
mod modes;

/// Three runs along 20 m; eight readings that vary smoothly along it, with noise.
fn recording() -> Recording {
    recording_of(80)
}

fn recording_of(per_run: usize) -> Recording {
    let k = 3 * per_run;
    let mut random = Seed(5).stream("toy recording");
    let x = |k: usize| (k % per_run) as f64 * 20.0 / per_run as f64;
    let pose: Vec<Pose> = (0..k).map(|k| Pose::new(x(k), 0.0, 0.0)).collect();
    let values = Array2::from_shape_fn((k, 8), |(k, c)| {
        let noise: f64 = random.random_range(-0.1..0.1);
        (2.0 + (x(k) * (0.3 + 0.17 * c as f64) + c as f64).sin() + noise) as f32
    });
    let channel = Channel {
        name: "light".into(),
        width: 8,
        unit: "lux".into(),
        bearing_rad: None,
        maximum: None,
    };
    Recording::new(Columns {
        channels: vec![channel],
        values,
        stamp_s: (0..k).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        route_m: Some((0..k).map(x).collect()),
        pose,
        run: (0..k).map(|k| (k / per_run) as i64).collect(),
        ..Columns::default()
    })
    .unwrap()
}

fn recipe() -> Recipe {
    let split = SplitConfig {
        unit: Unit::Runs,
        folds: 3,
        test_fold: None,
        validation_every: 3,
    };
    let thrun1998 = Recipe::thrun1998();
    let descent = DescentConfig {
        optimiser: Optimiser::Adam,
        scale: Scale::PriorShare,
        pseudo_pattern_steps: 1,
        learning_rate: 0.03,
        weight_decay: 0.01,
        map_in_objective: true,
        steps: 60,
        validate_every: 5,
        patience: 60,
        checkpoint_every: 8,
        ..thrun1998.descent
    };
    Recipe {
        features: 2,
        uncertainty: Uncertainty::Global,
        split,
        descent,
        augmentation: AugmentationConfig {
            input_noise: 0.3,
            ..thrun1998.augmentation
        },
        ..thrun1998
    }
}

/// The same data learned in draws, with a trunk and a wide objective.
fn recipe_in_draws() -> Recipe {
    let classic = recipe();
    let default = Recipe::default();
    Recipe {
        features: 20,
        network: NetConfig {
            trunk: vec![24],
            ..default.network
        },
        descent: DescentConfig {
            objective: Objective::MeanField,
            learning_rate: 0.01,
            truths_per_step: 30,
            candidates_per_step: 50,
            gradient_limit: 1.0,
            ..classic.descent
        },
        priors: default.priors,
        ..classic
    }
}

fn training_set<'a>(recipe: &Recipe, recording: &'a Recording) -> TrainingSet<'a> {
    TrainingSet::prepare(recipe, recording, &recipe.split.split(recording).unwrap()).unwrap()
}

fn trained(recipe: &Recipe) -> Trained {
    let recording = recording();
    train(
        recipe,
        &training_set(recipe, &recording),
        None,
        false,
        "",
        &mut |_| (),
    )
    .unwrap()
}

#[test]
fn learns_to_tell_places_apart() {
    let mut momentum = recipe();
    momentum.descent.optimiser = Optimiser::Momentum;
    momentum.descent.learning_rate = 1.0;
    momentum.descent.weight_decay = 0.0;
    momentum.descent.steps = 200;
    let mut without_the_truths_run = recipe_in_draws();
    without_the_truths_run.descent.leave_run_out = true;
    for recipe in [
        recipe(),
        momentum,
        recipe_in_draws(),
        without_the_truths_run,
    ] {
        let what = (recipe.descent.optimiser, recipe.descent.objective);
        let trained = trained(&recipe);
        assert!(
            trained.train.error_reduction > 0.4,
            "{what:?}: {:?}",
            trained.train
        );
        assert!(
            trained.validation.unwrap().error_reduction > 0.35,
            "{what:?}: {:?}",
            trained.validation
        );
    }
}

#[test]
fn one_step_follows_the_numerical_gradient() {
    // Momentum descent's first step is −η ∂(E/E_prior)/∂w: read the gradient off it and hold it to differences.
    let mut recipe = recipe();
    recipe.descent = DescentConfig {
        optimiser: Optimiser::Momentum,
        learning_rate: 1e-2,
        weight_decay: 0.0,
        steps: 1,
        ..recipe.descent
    };
    recipe.augmentation.input_noise = 0.0;
    let recording = recording();
    let mut training_set = training_set(&recipe, &recording);
    training_set.validation_set = None; // so that the step's weights come back, not the best validated ones
    let device = Device::flex();
    let start = Weights::random(
        &recipe.network,
        8,
        2,
        &mut Seed(1).stream("initial weights"),
    );
    let error = |weights: &Weights| {
        let output =
            Nets::new(weights, &device).forward(tensor(training_set.inputs.view(), &device));
        let (e, _) = training_set
            .objective(
                &mut Workspace::default(),
                array(output).unwrap().view(),
                true,
            )
            .unwrap();
        e.posterior_error_m / e.prior_error_m
    };
    let after = train(&recipe, &training_set, None, false, "", &mut |_| ())
        .unwrap()
        .weights;
    for (layer, at) in [
        (0, [0, 3, 2]),
        (0, [1, 7, 5]),
        (1, [0, 4, 0]),
        (1, [1, 1, 0]),
    ] {
        let slope =
            f64::from(start.layers[layer].weight[at] - after.layers[layer].weight[at]) / 1e-2;
        let moved = |h: f32| {
            let mut weights = start.clone();
            weights.layers[layer].weight[at] += h;
            error(&weights)
        };
        let numerical = (moved(2e-2) - moved(-2e-2)) / 4e-2;
        assert!(
            (slope - numerical).abs() < 2e-2 * numerical.abs() + 2e-5,
            "{layer} {at:?}: {slope} {numerical}"
        );
    }
}

#[test]
fn a_resumed_training_ends_in_the_same_bits() {
    resumes(&recipe());
    resumes(&recipe_in_draws());
}

fn resumes(recipe: &Recipe) {
    let recording = recording();
    let training_set = training_set(recipe, &recording);
    let whole = train(recipe, &training_set, None, false, "it", &mut |_| ()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.checkpoint");
    for killed_after in [3, 8, 29] {
        let _ = std::fs::remove_file(&path);
        let stopped = Recipe {
            descent: DescentConfig {
                steps: killed_after,
                ..recipe.descent.clone()
            },
            ..recipe.clone()
        };
        train(
            &stopped,
            &training_set,
            Some(&path),
            false,
            "it",
            &mut |_| (),
        )
        .unwrap();
        let resumed = train(recipe, &training_set, Some(&path), true, "it", &mut |_| ()).unwrap();
        assert_eq!(
            resumed.weights, whole.weights,
            "killed after {killed_after} steps"
        );
        assert_eq!(resumed.steps, whole.steps);
    }
    let other = train(
        recipe,
        &training_set,
        Some(&path),
        true,
        "another",
        &mut |_| (),
    );
    assert!(other.unwrap_err().to_string().contains("another training"));
}

/// What training ends in where so many threads work.
fn with_threads(threads: usize, recipe: &Recipe) -> Weights {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(|| trained(recipe).weights)
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    for recipe in [recipe(), recipe_in_draws()] {
        assert_eq!(with_threads(1, &recipe), with_threads(4, &recipe));
    }
}

/// Stopped before its own first checkpoint, a training must not find another one's when it is taken up.
#[test]
fn an_old_checkpoint_does_not_outlive_a_fresh_start() {
    let recipe = recipe();
    let recording = recording();
    let training_set = training_set(&recipe, &recording);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.checkpoint");
    train(
        &recipe,
        &training_set,
        Some(&path),
        false,
        "old",
        &mut |_| (),
    )
    .unwrap();
    assert!(path.exists());
    let mut short = recipe.clone();
    short.descent.steps = 3;
    train(
        &short,
        &training_set,
        Some(&path),
        false,
        "new",
        &mut |_| (),
    )
    .unwrap();
    let resumed = train(
        &recipe,
        &training_set,
        Some(&path),
        true,
        "new",
        &mut |_| (),
    )
    .unwrap();
    let whole = train(&recipe, &training_set, None, false, "new", &mut |_| ()).unwrap();
    assert_eq!(resumed.weights, whole.weights);
}

/// What a GPU does, on the CPU: it rounds otherwise, so it descends to nearly the same place.
#[test]
fn the_dense_objective_on_the_device_leads_to_the_same_place() {
    for (name, recipe) in [("whole", recipe()), ("draws", recipe_in_draws())] {
        let recording = recording();
        let training_set = training_set(&recipe, &recording);
        let after = |mut trainer: Trainer| {
            (0..20).for_each(|_| trainer.step().unwrap());
            trainer.sync();
            let nets = trainer.now.nets.forward(trainer.inputs.clone());
            (array(nets).unwrap(), trainer.now.training)
        };
        let (structured, before) = after(Trainer::new(&recipe, &training_set, &cpu()).on_tensors());
        let (dense, told) =
            after(Trainer::new(&recipe, &training_set, &cpu()).with_dense_objective());
        assert!((told - before).abs() < 1e-3, "{name}: {told} {before}");
        assert_ne!(structured, dense, "{name}: not evaluated elsewhere");
        for (a, b) in structured.iter().zip(&dense) {
            assert!((a - b).abs() < 5e-3, "{name}: {a} {b}");
        }
    }
}
