//! The snapshots that one evaluation of the objective is about, on the device, with their noise.

use super::{array, tensor};
use crate::{
    detector::{net::Nets, stacked},
    error::{Error, Result},
    learning::{
        draw::Draw,
        lesson::Lesson,
        recipe::{Recipe, Scale},
        task::{Errors, Workspace},
    },
    seed::Seed,
};
use burn::tensor::{Device, Tensor, TensorData};
use ndarray::{Array2, ArrayView2, Axis, concatenate};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

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
    draw: Option<Draw>,
    /// `[snapshot, input]`
    pub inputs: Tensor<2>,
    /// Outputs of the networks that learn no more, `[snapshot, feature]`.
    frozen: Option<Array2<f32>>,
}

/// The objective at some outputs.
pub struct Evaluated {
    /// As it is reported.
    pub error_reduction: f64,
    /// As it is descended.
    pub error: f64,
    /// ∂error/∂g of the networks that learn, `[snapshot, learner]`.
    pub gradient: Array2<f32>,
}

impl Evaluated {
    /// Nothing in it is infinite or no number at all.
    pub fn is_finite(&self) -> bool {
        self.error.is_finite() && self.gradient.iter().all(|g| g.is_finite())
    }
}

impl Batch {
    /// The batch of step `step`: the same for the same seed and step. `frozen` are the networks that learn no more.
    ///
    /// # Errors
    /// As [`Draw::new`].
    pub fn new(
        recipe: &Recipe,
        lesson: &Lesson,
        noise: &Noise,
        frozen: Option<&Nets>,
        step: usize,
        device: &Device,
    ) -> Result<Self> {
        let draw = match recipe.descent.queries {
            0 => None,
            _ => Some(Draw::new(recipe, lesson, step)?),
        };
        let inputs = match &draw {
            Some(draw) => &draw.inputs,
            None => &lesson.inputs,
        };
        let inputs = noise.onto(recipe, step, inputs, device);
        let frozen = frozen.map(|nets| array(nets.forward(inputs.clone())));
        Ok(Self {
            step,
            draw,
            inputs,
            frozen: frozen.transpose()?,
        })
    }

    /// The objective where the networks that learn answer `output`, `[snapshot, learner]`.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn evaluate(
        &self,
        recipe: &Recipe,
        lesson: &Lesson,
        workspace: &mut Workspace,
        output: Array2<f32>,
    ) -> Result<Evaluated> {
        let activation = match &self.frozen {
            None => output,
            Some(frozen) => joined(Axis(1), &[frozen.view(), output.view()])?,
        };
        let with_map = recipe.descent.map_in_objective;
        let (errors, truths, gradient) = match &self.draw {
            None => {
                let (e, gradient) = lesson.objective(workspace, activation.view(), with_map)?;
                (e, lesson.truths(), gradient.to_owned())
            }
            Some(draw) => {
                let (truth, candidates) = activation.view().split_at(Axis(0), draw.truths);
                let e = draw.task.evaluate(workspace, truth, candidates, with_map)?;
                let sides = [e.truth_gradient, e.candidate_gradient];
                (e.errors, draw.truths, joined(Axis(0), &sides)?)
            }
        };
        let scale = scale(recipe, errors, truths);
        let learned = self.frozen.as_ref().map_or(0, |frozen| frozen.ncols());
        let (_, gradient) = gradient.view().split_at(Axis(1), learned);
        Ok(Evaluated {
            error_reduction: reduction(errors),
            error: errors.posterior_error_m * scale,
            gradient: gradient.mapv(|g| g * scale as f32),
        })
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

pub(super) fn no_number(step: usize) -> Error {
    Error::work(format!(
        "the objective is no longer a number after {step} steps; expected a smaller descent.learning_rate"
    ))
}
