//! The snapshots that one evaluation of the objective is about, on the device, with their noise.

use super::{
    on_device::OnDevice,
    tensors::{array, tensor},
};
use crate::{
    detector::{
        net::{AT_ONCE, Nets},
        stacked,
    },
    error::{Error, Result},
    learning::{
        error_reduction::Errors,
        mini_batch::MiniBatch,
        problem::Workspace,
        recipe::{Recipe, Scale},
        training_set::TrainingSet,
    },
    seed::Seed,
};
use burn::tensor::{Device, Tensor, TensorData};
use ndarray::{Array2, ArrayView2, Axis, concatenate};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use std::sync::Arc;

/// Numbers of noise kept.
const NOISE: usize = 1 << 20;

/// Normally distributed numbers; every batch reads on from another place. Drawing them anew would take longer than all
/// the rest of a step.
pub struct Noise(Vec<f32>);

impl Noise {
    /// Drawn from the recipe's seed; none where the recipe asks for none.
    pub fn new(recipe: &Recipe) -> Self {
        let mut random = Seed(recipe.seed).stream("noise");
        Self(match recipe.augmentation.input_noise {
            0.0 => Vec::new(),
            _ => (0..NOISE)
                .map(|_| StandardNormal.sample(&mut random))
                .collect(),
        })
    }

    /// A step's noise: the same for the same seed and step, whatever happened before.
    pub fn of(&self, recipe: &Recipe, step: usize) -> Option<stacked::Noise<'_>> {
        if self.0.is_empty() {
            return None;
        }
        let mut random = Seed(recipe.seed).numbered_stream("input noise", step as u64);
        Some(stacked::Noise {
            bank: &self.0,
            start: random.random_range(0..self.0.len()),
            deviation: recipe.augmentation.input_noise as f32,
        })
    }

    /// Inputs with a step's noise.
    fn onto(
        &self,
        recipe: &Recipe,
        step: usize,
        inputs: &Array2<f32>,
        device: &Device,
    ) -> Tensor<2> {
        let Some(noise) = self.of(recipe, step) else {
            return tensor(inputs.view(), device);
        };
        let mut at = noise.start;
        let mut noisy: Vec<f32> = inputs.iter().copied().collect();
        let mut left = noisy.as_mut_slice();
        while !left.is_empty() {
            let (now, later) = left.split_at_mut(left.len().min(noise.bank.len() - at));
            for (x, z) in now.iter_mut().zip(&noise.bank[at..]) {
                *x += noise.deviation * z;
            }
            (left, at) = (later, 0);
        }
        let shape = [inputs.nrows(), inputs.ncols()];
        Tensor::from_data(TensorData::new(noisy, shape), device)
    }
}

/// What an evaluation looks at.
pub struct Batch {
    /// Step that it is drawn for.
    pub step: usize,
    /// Truths and candidates; none: all training snapshots.
    mini_batch: Option<MiniBatch>,
    /// `[snapshot, input]`
    pub inputs: Tensor<2>,
    /// Outputs of the networks that learn no more, `[snapshot, feature]`.
    frozen: Option<Tensor<2>>,
    /// The objective on the device, where it is evaluated there.
    on_device: Option<Arc<OnDevice>>,
}

/// Where the objective is evaluated.
#[derive(Clone)]
pub enum Site {
    /// On the CPU, by the structure of the priors.
    Cpu,
    /// On the device, dense; that of all training snapshots, where it fits.
    Device(Option<Arc<OnDevice>>),
}

impl Site {
    /// The device for the objective of all training snapshots too, where every step evaluates that.
    pub fn device(recipe: &Recipe, training_set: &TrainingSet, device: &Device) -> Self {
        let whole = (recipe.descent.truths_per_step == 0).then(|| {
            OnDevice::where_it_fits(
                training_set.problem(),
                recipe.descent.map_in_objective,
                device,
            )
        });
        Self::Device(whole.flatten().map(Arc::new))
    }
}

/// The objective at some outputs.
pub struct Evaluated {
    /// As it is reported.
    pub error_reduction: f64,
    /// As it is descended.
    pub error: f64,
    /// ∂error/∂g of the networks that learn, `[snapshot, learner]`.
    pub gradient: Tensor<2>,
    /// Nothing in it is infinite or no number at all.
    pub is_finite: bool,
}

impl Batch {
    /// The batch of step `step`: the same for the same seed and step. `frozen` are the networks that learn no more.
    ///
    /// # Errors
    /// As [`MiniBatch::new`].
    pub fn new(
        recipe: &Recipe,
        training_set: &TrainingSet,
        noise: &Noise,
        frozen: Option<&Nets>,
        step: usize,
        site: &Site,
        device: &Device,
    ) -> Result<Self> {
        let mini_batch = match recipe.descent.truths_per_step {
            0 => None,
            _ => Some(MiniBatch::new(recipe, training_set, step)?),
        };
        let inputs = match &mini_batch {
            Some(mini_batch) => &mini_batch.inputs,
            None => &training_set.inputs,
        };
        let inputs = noise.onto(recipe, step, inputs, device);
        let on_device = match (site, &mini_batch) {
            (Site::Cpu, _) => None,
            (Site::Device(whole), None) => whole.clone(),
            (Site::Device(_), Some(mini_batch)) => OnDevice::where_it_fits(
                &mini_batch.problem,
                recipe.descent.map_in_objective,
                device,
            )
            .map(Arc::new),
        };
        Ok(Self {
            step,
            mini_batch,
            frozen: frozen.map(|nets| nets.forward(inputs.clone())),
            inputs,
            on_device,
        })
    }

    /// The objective where the networks that learn answer `output`, `[snapshot, learner]`.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective, or the device fails.
    pub fn evaluate(
        &self,
        recipe: &Recipe,
        training_set: &TrainingSet,
        workspace: &mut Workspace,
        output: Tensor<2>,
    ) -> Result<Evaluated> {
        let learners = output.dims()[1];
        let activation = match &self.frozen {
            None => output,
            Some(frozen) => Tensor::cat(vec![frozen.clone(), output], 1),
        };
        let (learned, truths) = (activation.dims()[1] - learners, self.truths(training_set));
        let (errors, gradient, is_finite) = match &self.on_device {
            Some(objective) => self.dense(objective, activation)?,
            None => {
                let device = activation.device();
                let activation = array(activation)?;
                let (errors, gradient) =
                    self.structured(recipe, training_set, workspace, activation)?;
                let is_finite = gradient.iter().all(|g| g.is_finite());
                (errors, tensor(gradient.view(), &device), is_finite)
            }
        };
        let scale = scale(recipe, errors, truths);
        let gradient = match learned {
            0 => gradient,
            _ => gradient.narrow(1, learned, learners),
        };
        let error = errors.posterior_error_m * scale;
        Ok(Evaluated {
            error_reduction: reduction(errors),
            error,
            gradient: gradient.mul_scalar(scale as f32),
            is_finite: is_finite && error.is_finite(),
        })
    }

    fn truths(&self, training_set: &TrainingSet) -> usize {
        match &self.mini_batch {
            None => training_set.truths(),
            Some(mini_batch) => mini_batch.truths,
        }
    }

    /// On the CPU: errors, and ∂E/∂g `[snapshot, feature]`.
    fn structured(
        &self,
        recipe: &Recipe,
        training_set: &TrainingSet,
        workspace: &mut Workspace,
        activation: Array2<f32>,
    ) -> Result<(Errors, Array2<f32>)> {
        let with_map = recipe.descent.map_in_objective;
        match &self.mini_batch {
            None => {
                let (e, gradient) =
                    training_set.objective(workspace, activation.view(), with_map)?;
                Ok((e, gradient.to_owned()))
            }
            Some(mini_batch) => {
                let (truth, candidates) = activation.view().split_at(Axis(0), mini_batch.truths);
                let e = mini_batch
                    .problem
                    .evaluate(workspace, truth, candidates, with_map)?;
                let sides = [e.truth_gradient, e.candidate_gradient];
                Ok((e.errors, joined(Axis(0), &sides)?))
            }
        }
    }

    /// On the device: the same, and whether all of it is finite.
    fn dense(
        &self,
        objective: &OnDevice,
        activation: Tensor<2>,
    ) -> Result<(Errors, Tensor<2>, bool)> {
        let (errors, gradient) = match &self.mini_batch {
            None => {
                let e = objective.evaluate(activation.clone(), activation)?;
                (e.errors, e.truth_gradient + e.candidate_gradient)
            }
            Some(mini_batch) => {
                let candidates = activation.dims()[0] - mini_batch.truths;
                let e = objective.evaluate(
                    activation.clone().narrow(0, 0, mini_batch.truths),
                    activation.narrow(0, mini_batch.truths, candidates),
                )?;
                let sides = vec![e.truth_gradient, e.candidate_gradient];
                (e.errors, Tensor::cat(sides, 0))
            }
        };
        Ok((errors, gradient, errors.posterior_error_m.is_finite()))
    }
}

/// What the mean error in metres is multiplied by before it is descended.
pub fn scale(recipe: &Recipe, e: Errors, truths: usize) -> f64 {
    match recipe.descent.scale {
        Scale::PriorShare => 1.0 / counted(e.prior_error_m),
        Scale::Sum => truths as f64,
    }
}

/// The error reduction as it is reported.
pub fn reduction(e: Errors) -> f64 {
    1.0 - e.posterior_error_m / counted(e.prior_error_m)
}

/// No truth of a draw may have had anything to be mistaken for: such a step changes nothing but the weights' decay.
fn counted(prior_error_m: f64) -> f64 {
    match prior_error_m > 0.0 {
        true => prior_error_m,
        false => 1.0,
    }
}

fn joined<T: Clone>(axis: Axis, parts: &[ArrayView2<T>]) -> Result<Array2<T>> {
    concatenate(axis, parts).map_err(|e| Error::work(format!("parts of a step: {e}")))
}

/// What networks answer, `[snapshot, feature]`.
///
/// # Errors
/// Where that is no number, which would count as a perfect posterior.
pub fn answers(nets: &Nets, inputs: Tensor<2>, step: usize) -> Result<Array2<f32>> {
    let all = inputs.dims()[0];
    let some = |first: usize| {
        let rows = first..(first + AT_ONCE).min(all);
        array(nets.forward(inputs.clone().slice([rows])))
    };
    let parts = (0..all).step_by(AT_ONCE).map(some);
    let parts = parts.collect::<Result<Vec<Array2<f32>>>>()?;
    let answers = match parts.len() {
        0 => array(nets.forward(inputs))?,
        _ => joined(
            Axis(0),
            &Vec::from_iter(parts.iter().map(|part| part.view())),
        )?,
    };
    match answers.iter().all(|g| g.is_finite()) {
        true => Ok(answers),
        false => Err(no_number(step)),
    }
}

pub fn no_number(step: usize) -> Error {
    Error::work(format!(
        "the objective is no longer a number after {step} steps; expected a smaller descent.learning_rate"
    ))
}
