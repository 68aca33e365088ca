//! Does training learn, follow the gradient, and end in the same bits every time?

use super::{
    tensors::{array, tensor},
    *,
};
use crate::{
    belief::Uncertainty,
    detector::{
        device::cpu,
        net::{NetConfig, Nets, Weights},
    },
    geometry::Pose,
    learning::{
        problem::Workspace,
        recipe::{AugmentationConfig, DescentConfig, ObjectiveKind, Optimiser, Scale, Schedule},
    },
    recording::{
        Channel, Columns, Recording,
        split::{SplitConfig, Unit},
    },
    seed::Seed,
};
use ndarray::Array2;
use rand::RngExt;

mod array_backend;
mod checkpoints;
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
        offset_m: None,
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
            objective: ObjectiveKind::MeanField,
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
    run(recipe, &training_set(recipe, &recording)).unwrap()
}

/// A training on the CPU without checkpoints.
fn run(recipe: &Recipe, training_set: &TrainingSet) -> Result<Trained> {
    train(recipe, training_set, &cpu(), None, &mut |_| {
        Directive::Continue
    })
}

/// An identity with a given name; `steps` distinguishes the same training of other lengths.
fn identity(name: &str, steps: usize) -> TrainingIdentity {
    TrainingIdentity {
        whole: format!("{name} of {steps} steps"),
        but_for_steps: name.to_string(),
    }
}

/// A training with checkpoints in a file, which `on_progress` may end.
fn run_with<D: Into<Directive>>(
    recipe: &Recipe,
    training_set: &TrainingSet,
    (path, name, resume): (&Path, &str, bool),
    on_progress: &mut dyn FnMut(Progress) -> D,
) -> Result<Trained> {
    let identity = identity(name, recipe.descent.steps);
    let checkpoints = Checkpoints {
        path,
        identity: &identity,
        resume,
    };
    let on_progress = &mut |p| on_progress(p).into();
    train(
        recipe,
        training_set,
        &cpu(),
        Some(&checkpoints),
        on_progress,
    )
}

/// Ends a training when so many steps are taken.
fn at(step: usize, end: Directive) -> impl FnMut(Progress) -> Directive {
    move |p| match p.step == step {
        true => end,
        false => Directive::Continue,
    }
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
    let after = run(&recipe, &training_set).unwrap().weights;
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

/// Readings that are the same everywhere: there is nothing to find, and a quarter of the steps is enough to see it.
#[test]
fn a_training_that_learns_nothing_ends_after_a_quarter_of_its_steps() {
    let mut recipe = recipe();
    recipe.descent.steps = 400;
    recipe.descent.patience = 400;
    let mut columns = recording().into_columns();
    for (run, mut readings) in columns.run.iter().zip(columns.values.rows_mut()) {
        readings.fill(*run as f32);
    }
    let recording = Recording::new(columns).unwrap();
    let trained = run(&recipe, &training_set(&recipe, &recording)).unwrap();
    assert_eq!(trained.stopped_by, StoppedBy::NothingLearned, "{trained:?}");
    assert!((100..200).contains(&trained.steps), "{}", trained.steps);
    assert!(trained.validation.unwrap().error_reduction < NOTHING_LEARNED);
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

/// What a GPU does, on the CPU: it rounds otherwise, so it descends to nearly the same place.
#[test]
fn the_dense_objective_on_the_device_leads_to_the_same_place() {
    for (name, recipe) in [("whole", recipe()), ("draws", recipe_in_draws())] {
        let recording = recording();
        let training_set = training_set(&recipe, &recording);
        let after = |mut trainer: Trainer| {
            (0..20).for_each(|_| trainer.step().unwrap());
            trainer.sync();
            let inputs = tensor(training_set.inputs.view(), &cpu());
            let nets = trainer.now.nets.forward(inputs);
            (array(nets).unwrap(), trainer.now.batch_error_reduction)
        };
        let (structured, before) = after(Trainer::new(&recipe, &training_set, &cpu()).on_tensors());
        let (dense, found) =
            after(Trainer::new(&recipe, &training_set, &cpu()).with_dense_objective());
        assert!((found - before).abs() < 1e-3, "{name}: {found} {before}");
        assert_ne!(structured, dense, "{name}: not evaluated elsewhere");
        for (a, b) in structured.iter().zip(&dense) {
            assert!((a - b).abs() < 5e-3, "{name}: {a} {b}");
        }
    }
}
