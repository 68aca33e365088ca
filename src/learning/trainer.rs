//! The descent itself: forward, objective, backward, step; a look at the validation part now and then.

use super::{
    checkpoint::{self, Checkpoint},
    lesson::Lesson,
    objective::Evaluation,
    optimiser::Descent,
    recipe::Recipe,
};
use crate::{
    detector::net::{Nets, Weights, values},
    error::{Error, Result},
    seed::Seed,
};
use burn::tensor::{Device, Tensor, TensorData};
use ndarray::{Array2, ArrayView2};
use rand_distr::{Distribution, Normal};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What training says while it runs.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Steps taken, of at most `most_steps`.
    pub step: usize,
    /// The recipe's limit.
    pub most_steps: usize,
    /// Error reduction on the training part at the last step.
    pub training: f64,
    /// Best error reduction on the validation part so far.
    pub validation: Option<f64>,
}

/// Expected errors of a part before and after sensing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Before sensing, in metres.
    pub prior_error_m: f64,
    /// After sensing, in metres.
    pub posterior_error_m: f64,
    /// 1 − posterior/prior (Thrun 1998, eq. 46).
    pub error_reduction: f64,
    /// Snapshots that it is the mean of.
    pub snapshots: usize,
}

/// Why training ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StoppedBy {
    /// No better validation error for `patience` steps.
    Validation,
    /// The recipe's most steps were taken.
    Steps,
}

/// Trained weights and how they came about.
#[derive(Debug, Clone)]
pub struct Trained {
    /// The weights of the best validation error; of the last step where nothing could be validated.
    pub weights: Weights,
    /// Their activations on the training part, `[snapshot, feature]`.
    pub activation: Array2<f32>,
    /// On the training part, with the map that localisation uses.
    pub train: Score,
    /// On the validation part.
    pub validation: Option<Score>,
    /// Steps taken.
    pub steps: usize,
    /// Why it ended.
    pub stopped_by: StoppedBy,
}

/// Trains a recipe on a lesson.
///
/// A checkpoint is kept at `checkpoint` where given; with `resume`, training goes on from it, and ends in the same bits
/// as if it had never stopped. It starts afresh where there is no checkpoint yet.
///
/// # Errors
/// Where a checkpoint belongs to another training or is damaged, or can't be written.
pub fn train(
    recipe: &Recipe,
    lesson: &Lesson,
    checkpoint: Option<&Path>,
    resume: bool,
    identity: &str,
    progress: &mut dyn FnMut(Progress),
) -> Result<Trained> {
    let device = Device::flex();
    let seed = Seed(recipe.seed);
    let mut now = match checkpoint.filter(|path| resume && path.exists()) {
        Some(path) => checkpoint::read(path, identity, recipe, &device)?,
        None => {
            let mut random = seed.stream("initial weights");
            let weights = Weights::random(
                &recipe.network,
                lesson.input.width(),
                recipe.features,
                &mut random,
            );
            Checkpoint::start(Nets::new(&weights, &device), Descent::new(&recipe.descent))
        }
    };
    let inputs = tensor(lesson.inputs.view(), &device);
    let mut stopped_by = StoppedBy::Steps;
    loop {
        let step = now.descent.steps;
        if step % recipe.descent.validate_every == 0 || step == recipe.descent.steps {
            now.look(
                step,
                validate(lesson, &now.nets, &inputs, &device)?.map(|e| e.error_reduction()),
            );
            progress(now.progress(recipe));
        }
        if step >= recipe.descent.steps {
            break;
        }
        if now.best_validation.is_some() && step - now.best_step >= recipe.descent.patience {
            stopped_by = StoppedBy::Validation;
            break;
        }
        if let Some(path) =
            checkpoint.filter(|_| step > 0 && step % recipe.descent.checkpoint_every == 0)
        {
            checkpoint::write(path, identity, &now)?;
        }
        let noisy = with_noise(lesson, recipe, seed, step, &inputs, &device)?;
        one_step(&mut now, lesson, recipe, noisy, &device)?;
    }
    finish(now, lesson, recipe, stopped_by, &inputs, &device)
}

/// Forward, objective outside the tape, backward through the networks, step.
fn one_step(
    now: &mut Checkpoint,
    lesson: &Lesson,
    recipe: &Recipe,
    inputs: Tensor<2>,
    device: &Device,
) -> Result<()> {
    let tracked = |t: &Tensor<3>| Tensor::from_inner(t.clone()).require_grad();
    let mut nets = now.nets.clone();
    nets.weight = nets.weight.iter().map(tracked).collect();
    nets.bias = nets.bias.iter().map(tracked).collect();

    let output = nets.forward(Tensor::from_inner(inputs)); // [snapshot, feature]
    let activation = to_f64(output.clone().inner())?;
    let (e, gradient) = lesson.objective(activation.view(), recipe.descent.map_in_objective)?;
    if !e.posterior_error_m.is_finite() || gradient.iter().any(|g| !g.is_finite()) {
        return Err(Error::work(format!(
            "the objective is no longer a number after {} steps; expected a smaller descent.learning_rate",
            now.descent.steps
        )));
    }
    now.training = e.error_reduction();
    // ∂E/∂g is known in closed form, so the tape only carries Σ g ∘ ∂E/∂g back through the networks.
    let scaled = gradient.mapv(|g| (g / e.prior_error_m) as f32);
    let surrogate = (output * Tensor::from_inner(tensor(scaled.view(), device))).sum();
    let mut gradients = surrogate.backward();
    let mut take = |t: &Tensor<3>| {
        t.grad_remove(&mut gradients)
            .ok_or_else(|| Error::work("a parameter of the networks got no gradient"))
    };
    let parameters: Vec<Tensor<3>> = nets.weight.iter().chain(&nets.bias).cloned().collect();
    let slopes = parameters
        .iter()
        .map(&mut take)
        .collect::<Result<Vec<_>>>()?;
    let mut moved = now
        .descent
        .step(parameters.into_iter().map(Tensor::inner).collect(), slopes);
    now.nets.bias = moved.split_off(nets.weight.len());
    now.nets.weight = moved;
    Ok(())
}

/// Inputs with this step's noise: the same for the same seed and step, whatever happened before.
fn with_noise(
    lesson: &Lesson,
    recipe: &Recipe,
    seed: Seed,
    step: usize,
    inputs: &Tensor<2>,
    device: &Device,
) -> Result<Tensor<2>> {
    if recipe.descent.input_noise == 0.0 {
        return Ok(inputs.clone());
    }
    let normal = Normal::new(0.0, recipe.descent.input_noise as f32)
        .map_err(|e| Error::usage(format!("descent.input_noise: {e}")))?;
    let mut random = seed.numbered_stream("input noise", step as u64);
    let noisy = lesson.inputs.mapv(|x| x + normal.sample(&mut random));
    Ok(tensor(noisy.view(), device))
}

fn validate(
    lesson: &Lesson,
    nets: &Nets,
    inputs: &Tensor<2>,
    device: &Device,
) -> Result<Option<Evaluation>> {
    let Some(exam) = &lesson.exam else {
        return Ok(None);
    };
    let training = to_f64(nets.forward(inputs.clone()))?;
    let truth = to_f64(nets.forward(tensor(exam.inputs.view(), device)))?;
    lesson
        .examine(exam, truth.view(), training.view())
        .map(Some)
}

fn finish(
    now: Checkpoint,
    lesson: &Lesson,
    recipe: &Recipe,
    stopped_by: StoppedBy,
    inputs: &Tensor<2>,
    device: &Device,
) -> Result<Trained> {
    let nets = if now.best_validation.is_some() {
        now.best_nets
    } else {
        now.nets
    };
    let activation = nets.forward(inputs.clone());
    let (train, _) = lesson.objective(
        to_f64(activation.clone())?.view(),
        recipe.descent.map_in_objective,
    )?;
    let validation = validate(lesson, &nets, inputs, device)?;
    let shape = (lesson.inputs.nrows(), recipe.features);
    Ok(Trained {
        weights: nets.weights()?,
        activation: Array2::from_shape_vec(shape, values(activation)?)
            .map_err(|e| Error::work(e.to_string()))?,
        train: score(&train, lesson.inputs.nrows()),
        validation: validation.map(|e| {
            score(
                &e,
                lesson.exam.as_ref().map_or(0, |exam| exam.inputs.nrows()),
            )
        }),
        steps: now.descent.steps,
        stopped_by,
    })
}

fn score(e: &Evaluation, snapshots: usize) -> Score {
    Score {
        prior_error_m: e.prior_error_m,
        posterior_error_m: e.posterior_error_m,
        error_reduction: e.error_reduction(),
        snapshots,
    }
}

fn tensor(array: ArrayView2<f32>, device: &Device) -> Tensor<2> {
    let shape = [array.nrows(), array.ncols()];
    Tensor::from_data(
        TensorData::new(array.iter().copied().collect::<Vec<f32>>(), shape),
        device,
    )
}

fn to_f64(tensor: Tensor<2>) -> Result<Array2<f64>> {
    let [rows, columns] = tensor.dims();
    let wide = values(tensor)?.into_iter().map(f64::from).collect();
    Array2::from_shape_vec((rows, columns), wide).map_err(|e| Error::work(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        belief::Uncertainty,
        geometry::Pose,
        learning::recipe::{DescentConfig, Optimiser},
        recording::{
            Channel, Columns, Recording,
            split::{SplitConfig, Unit},
        },
    };
    use rand::RngExt;

    /// Three runs along 20 m; eight readings that vary smoothly along it, with noise.
    fn recording() -> Recording {
        let per_run = 80;
        let k = 3 * per_run;
        let mut random = Seed(5).stream("toy recording");
        let x = |k: usize| (k % per_run) as f64 * 0.25;
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
        let descent = DescentConfig {
            steps: 60,
            validate_every: 5,
            patience: 60,
            checkpoint_every: 8,
            ..Default::default()
        };
        Recipe {
            features: 2,
            uncertainty: Uncertainty::Global,
            split,
            descent,
            ..Default::default()
        }
    }

    fn lesson(recipe: &Recipe) -> Lesson {
        let recording = recording();
        Lesson::prepare(recipe, &recording, &recipe.split.split(&recording).unwrap()).unwrap()
    }

    fn trained(recipe: &Recipe) -> Trained {
        train(recipe, &lesson(recipe), None, false, "", &mut |_| ()).unwrap()
    }

    #[test]
    fn learns_to_tell_places_apart() {
        for optimiser in [Optimiser::Adam, Optimiser::Momentum] {
            let mut recipe = recipe();
            recipe.descent.optimiser = optimiser;
            if optimiser == Optimiser::Momentum {
                recipe.descent.learning_rate = 1.0;
                recipe.descent.weight_decay = 0.0;
                recipe.descent.steps = 200;
            }
            let trained = trained(&recipe);
            assert!(
                trained.train.error_reduction > 0.4,
                "{optimiser:?}: {:?}",
                trained.train
            );
            assert!(
                trained.validation.unwrap().error_reduction > 0.35,
                "{optimiser:?}: {:?}",
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
            input_noise: 0.0,
            ..recipe.descent
        };
        let mut lesson = lesson(&recipe);
        lesson.exam = None; // so that the step's weights come back, not the best validated ones
        let device = Device::flex();
        let start = Weights::random(
            &recipe.network,
            8,
            2,
            &mut Seed(1).stream("initial weights"),
        );
        let error = |weights: &Weights| {
            let output = Nets::new(weights, &device).forward(tensor(lesson.inputs.view(), &device));
            let (e, _) = lesson
                .objective(to_f64(output).unwrap().view(), true)
                .unwrap();
            e.posterior_error_m / e.prior_error_m
        };
        let after = train(&recipe, &lesson, None, false, "", &mut |_| ())
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
        let recipe = recipe();
        let lesson = lesson(&recipe);
        let whole = train(&recipe, &lesson, None, false, "it", &mut |_| ()).unwrap();
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
            train(&stopped, &lesson, Some(&path), false, "it", &mut |_| ()).unwrap();
            let resumed = train(&recipe, &lesson, Some(&path), true, "it", &mut |_| ()).unwrap();
            assert_eq!(
                resumed.weights, whole.weights,
                "killed after {killed_after} steps"
            );
            assert_eq!(resumed.steps, whole.steps);
        }
        let other = train(&recipe, &lesson, Some(&path), true, "another", &mut |_| ());
        assert!(other.unwrap_err().to_string().contains("another training"));
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let in_pool = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| trained(&recipe()).weights)
        };
        assert_eq!(in_pool(1), in_pool(4));
    }
}
