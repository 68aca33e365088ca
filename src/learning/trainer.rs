//! The descent itself: forward, objective, backward, step; a look at the validation part now and then.

use super::{
    checkpoint::{self, Checkpoint},
    draw::Draw,
    lesson::Lesson,
    optimiser::Descent,
    recipe::Recipe,
};
use crate::{
    detector::net::{Nets, Weights, values},
    error::{Error, Result},
    seed::Seed,
};
use burn::tensor::{Device, Tensor, TensorData};
use ndarray::{Array2, ArrayView2, Axis};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::path::Path;

pub use restarts::{remove_checkpoints, train, train_on};

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

/// One training, from the weights that the recipe's seed gives.
fn train_once(
    device: &Device,
    recipe: &Recipe,
    lesson: &Lesson,
    checkpoint: Option<&Path>,
    resume: bool,
    identity: &str,
    progress: &mut dyn FnMut(Progress),
) -> Result<Trained> {
    let mut trainer = Trainer::new(recipe, lesson, device);
    if let Some(path) = checkpoint.filter(|path| resume && path.exists()) {
        trainer.now = checkpoint::read(path, identity, recipe, &trainer.now.nets)?;
    }
    let stopped_by = loop {
        let step = trainer.steps();
        if step.is_multiple_of(recipe.descent.validate_every) || step == recipe.descent.steps {
            let validation = trainer.validate(&trainer.now.nets)?;
            trainer
                .now
                .look(step, validation.map(|e| e.error_reduction));
            progress(trainer.now.progress(recipe));
        }
        if step >= recipe.descent.steps {
            break StoppedBy::Steps;
        }
        if trainer.now.best_validation.is_some()
            && step - trainer.now.best_step >= recipe.descent.patience
        {
            break StoppedBy::Validation;
        }
        if let Some(path) =
            checkpoint.filter(|_| step > 0 && step.is_multiple_of(recipe.descent.checkpoint_every))
        {
            checkpoint::write(path, identity, &trainer.now)?;
        }
        trainer.step()?;
    };
    trainer.finish(stopped_by)
}

/// A training between two steps.
pub struct Trainer<'a> {
    recipe: &'a Recipe,
    lesson: &'a Lesson<'a>,
    device: Device,
    /// The lesson's inputs on the device, `[snapshot, input]`.
    inputs: Tensor<2>,
    /// Normally distributed numbers; every step reads on from another place. Drawing them anew would take longer than
    /// all the rest of a step.
    noise: Vec<f32>,
    now: Checkpoint,
}

/// Numbers of noise kept.
const NOISE: usize = 1 << 20;

impl<'a> Trainer<'a> {
    /// Before the first step: networks of random weights, drawn from the recipe's seed.
    pub fn new(recipe: &'a Recipe, lesson: &'a Lesson<'a>, device: &Device) -> Self {
        let weights = Weights::random(
            &recipe.network,
            lesson.input.width(),
            recipe.features,
            &mut Seed(recipe.seed).stream("initial weights"),
        );
        let mut nets = Nets::new(&weights, device);
        nets.gain = recipe.network.gain;
        let mut random = Seed(recipe.seed).stream("noise");
        let noise = match recipe.augmentation.input_noise {
            0.0 => Vec::new(),
            _ => (0..NOISE)
                .map(|_| StandardNormal.sample(&mut random))
                .collect(),
        };
        Self {
            noise,
            recipe,
            lesson,
            inputs: tensor(lesson.inputs.view(), device),
            now: Checkpoint::start(nets, Descent::new(&recipe.descent)),
            device: device.clone(),
        }
    }

    /// Steps taken.
    pub fn steps(&self) -> usize {
        self.now.descent.steps
    }

    /// One step of all networks on all training snapshots: forward, objective outside the tape, backward through the
    /// networks, descent.
    ///
    /// # Errors
    /// Where the objective or its gradient is no longer a finite number.
    pub fn step(&mut self) -> Result<()> {
        let tracked = |t: &Tensor<3>| Tensor::from_inner(t.clone()).require_grad();
        let mut nets = self.now.nets.clone();
        nets.weight = nets.weight.iter().map(tracked).collect();
        nets.bias = nets.bias.iter().map(tracked).collect();

        let draw = match self.recipe.descent.queries {
            0 => None,
            _ => Some(Draw::new(self.recipe, self.lesson, self.steps())?),
        };
        let inputs = self.with_noise(match &draw {
            Some(draw) => &draw.inputs,
            None => &self.lesson.inputs,
        });
        let output = nets.forward(Tensor::from_inner(inputs)); // [snapshot, feature]
        let activation = array(output.clone().inner())?;
        let with_map = self.recipe.descent.map_in_objective;
        let (e, gradient) = match &draw {
            None => self.lesson.objective(activation.view(), with_map)?,
            Some(draw) => {
                let (truth, candidates) = activation.view().split_at(Axis(0), draw.truths);
                let e = draw.task.evaluate(truth, candidates, with_map)?;
                let gradient = [e.truth_gradient.view(), e.map_gradient.view()];
                let gradient = ndarray::concatenate(Axis(0), &gradient);
                (
                    e,
                    gradient.map_err(|e| Error::work(format!("gradient: {e}")))?,
                )
            }
        };
        if !e.posterior_error_m.is_finite() || gradient.iter().any(|g| !g.is_finite()) {
            return Err(Error::work(format!(
                "the objective is no longer a number after {} steps; expected a smaller descent.learning_rate",
                self.steps()
            )));
        }
        // No truth of a draw may have had anything to be mistaken for: such a step changes nothing but the weights' decay.
        let prior_error_m = if e.prior_error_m > 0.0 {
            e.prior_error_m
        } else {
            1.0
        };
        self.now.training = 1.0 - e.posterior_error_m / prior_error_m;
        // ∂E/∂g is known in closed form, so the tape only carries Σ g ∘ ∂E/∂g back through the networks.
        let scaled = gradient.mapv(|g| (g / prior_error_m) as f32);
        let surrogate = (output * Tensor::from_inner(tensor(scaled.view(), &self.device))).sum();
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
        let slopes = limited(slopes, self.recipe.descent.gradient_limit)?;
        let mut moved = self
            .now
            .descent
            .step(parameters.into_iter().map(Tensor::inner).collect(), slopes);
        self.now.nets.bias = moved.split_off(nets.weight.len());
        self.now.nets.weight = moved;
        Ok(())
    }

    /// Inputs with this step's noise: the same for the same seed and step, whatever happened before.
    fn with_noise(&self, inputs: &Array2<f32>) -> Tensor<2> {
        let deviation = self.recipe.augmentation.input_noise;
        if deviation == 0.0 {
            return tensor(inputs.view(), &self.device);
        }
        let mut random = Seed(self.recipe.seed).numbered_stream("input noise", self.steps() as u64);
        let mut at = random.random_range(0..self.noise.len());
        let mut noisy: Vec<f32> = inputs.iter().copied().collect();
        let mut left = noisy.as_mut_slice();
        while !left.is_empty() {
            let (now, later) = left.split_at_mut(left.len().min(self.noise.len() - at));
            for (x, noise) in now.iter_mut().zip(&self.noise[at..]) {
                *x += deviation as f32 * noise;
            }
            (left, at) = (later, 0);
        }
        let shape = [inputs.nrows(), inputs.ncols()];
        Tensor::from_data(TensorData::new(noisy, shape), &self.device)
    }

    /// The validation part under some networks, where there is one.
    fn validate(&self, nets: &Nets) -> Result<Option<Score>> {
        let Some(exam) = &self.lesson.exam else {
            return Ok(None);
        };
        let training = array(nets.forward(self.inputs.clone()))?;
        let truth = array(nets.forward(tensor(exam.inputs.view(), &self.device)))?;
        self.lesson
            .examine(exam, truth.view(), training.view())
            .map(Some)
    }

    fn finish(self, stopped_by: StoppedBy) -> Result<Trained> {
        let nets = match self.now.best_validation {
            Some(_) => &self.now.best_nets,
            None => &self.now.nets,
        };
        let activation = array(nets.forward(self.inputs.clone()))?;
        Ok(Trained {
            weights: nets.weights()?,
            train: self.lesson.judge(activation.view())?,
            activation,
            validation: self.validate(nets)?,
            steps: self.steps(),
            stopped_by,
        })
    }
}

fn tensor(array: ArrayView2<f32>, device: &Device) -> Tensor<2> {
    let shape = [array.nrows(), array.ncols()];
    Tensor::from_data(
        TensorData::new(array.iter().copied().collect::<Vec<f32>>(), shape),
        device,
    )
}

fn array(tensor: Tensor<2>) -> Result<Array2<f32>> {
    let [rows, columns] = tensor.dims();
    Array2::from_shape_vec((rows, columns), values(tensor)?).map_err(|e| Error::work(e.to_string()))
}

/// Gradients shortened to a length of `limit` over all of them, where they are longer; 0: as they are.
fn limited(slopes: Vec<Tensor<3>>, limit: f64) -> Result<Vec<Tensor<3>>> {
    if limit == 0.0 {
        return Ok(slopes);
    }
    let mut squares = 0.0;
    for slope in &slopes {
        let slope = values(slope.clone())?;
        squares += slope.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>();
    }
    let length = squares.sqrt();
    if length <= limit {
        return Ok(slopes);
    }
    let shorten = |slope: Tensor<3>| slope.mul_scalar(limit / length);
    Ok(slopes.into_iter().map(shorten).collect())
}

mod restarts;
#[cfg(test)]
mod tests;
