//! The steps of small networks on the CPU, on plain arrays: the same numbers as on tensors, to rounding, in a fraction
//! of the time.
//!
//! Thrun's networks are so small that tensors spend more on their bookkeeping than on the numbers: a tape, fresh memory
//! for each intermediate result, a pass over it for each operation. Here the networks are [`Stacked`], the descent is
//! [`InPlace`], and nothing is allocated from one step to the next. What only tensors do goes through them: trunks, GPUs,
//! drawn snapshots, one feature after another, searches along a line.

use super::{
    batch::{Noise, no_number, reduction, scale},
    phase::Phase,
    pseudo_patterns::PseudoPatterns,
    state::State,
    tensors::{array, tensor},
};
use crate::{
    detector::{
        device,
        net::{Nets, Weights},
        stacked::Stacked,
    },
    error::Result,
    learning::{
        optimiser::InPlace,
        problem::Workspace,
        recipe::{Optimiser, Recipe},
        training_set::TrainingSet,
    },
};
use burn::tensor::Device;
use ndarray::{Array2, ArrayView2, Zip};

/// The networks with all that a step of theirs needs.
pub struct ArrayBackend {
    weights: Weights,
    gradient: Weights,
    stacked: Stacked,
    descent: InPlace,
    /// g, `[snapshot, feature]`.
    activation: Array2<f32>,
    /// Where steps follow pseudo-patterns: what these are, and g less its target, `[snapshot, feature]`.
    patterns: Option<Patterns>,
    residual: Array2<f32>,
}

/// As [`PseudoPatterns`].
struct Patterns {
    output: Array2<f32>,
    gradient: Array2<f32>,
}

impl ArrayBackend {
    /// Where these networks are trained faster here: on the CPU, small, all at once, all snapshots at every step, by a
    /// plain step down the gradient.
    pub fn where_it_fits(recipe: &Recipe, weights: &Weights, device: &Device) -> Option<Self> {
        let d = &recipe.descent;
        let fits = Stacked::fits(weights)
            && *device == device::cpu()
            && recipe.network.gain == 1.0
            && d.optimiser != Optimiser::ConjugateGradient
            && d.truths_per_step == 0
            && d.gradient_limit == 0.0
            && !d.sequential;
        fits.then(|| Self {
            gradient: weights.clone(),
            stacked: Stacked::new(weights),
            weights: weights.clone(),
            descent: InPlace::new(d),
            activation: Array2::default((0, 0)),
            patterns: None,
            residual: Array2::default((0, 0)),
        })
    }

    /// Goes on from where a training on tensors stands.
    ///
    /// # Errors
    /// Where the device does not give its data back.
    pub fn load(&mut self, now: &State) -> Result<()> {
        self.weights = now.nets.weights()?;
        self.descent = InPlace::after(&now.descent)?;
        let patterns = now.pseudo_patterns.clone().map(|patterns| {
            Ok(Patterns {
                output: array(patterns.output)?,
                gradient: array(patterns.gradient)?,
            })
        });
        self.patterns = patterns.transpose()?;
        Ok(())
    }

    /// Says where the training stands, as tensors.
    pub fn store(&self, now: &mut State, device: &Device) {
        now.nets = Nets::new(&self.weights, device);
        now.descent = self.descent.descent(&now.nets);
        now.pseudo_patterns = self.patterns.as_ref().map(|patterns| PseudoPatterns {
            output: tensor(patterns.output.view(), device),
            gradient: tensor(patterns.gradient.view(), device),
        });
    }

    /// One step of the same training as on tensors; of the state only what is counted is kept up.
    ///
    /// # Errors
    /// Where the objective or its gradient is no longer a finite number.
    pub fn step(
        &mut self,
        recipe: &Recipe,
        training_set: &TrainingSet,
        noise: &Noise,
        workspace: &mut Workspace,
        now: &mut State,
    ) -> Result<()> {
        // One way into the pool of threads for the whole step.
        let evaluated = rayon::scope(|_| self.descend(recipe, training_set, noise, workspace))?;
        if let Some(reduction) = evaluated {
            now.evaluations += 1;
            now.batch_error_reduction = reduction;
        }
        now.descent.steps = self.descent.steps;
        Ok(())
    }

    /// Forward, slope, backward, descent. The error reduction, where the objective was evaluated.
    fn descend(
        &mut self,
        recipe: &Recipe,
        training_set: &TrainingSet,
        noise: &Noise,
        workspace: &mut Workspace,
    ) -> Result<Option<f64>> {
        let step = self.descent.steps;
        let (place, first) = Phase::at(recipe, step).place_in_series(recipe, step);
        let inputs = training_set.inputs.view();
        let shape = (inputs.nrows(), recipe.features);
        if self.activation.dim() != shape {
            self.activation = Array2::zeros(shape);
        }
        let noise = noise.of(recipe, first);
        let g = self.activation.view_mut();
        self.stacked.forward(&self.weights, inputs, noise, g)?;
        let g = self.activation.view();
        let evaluated = match &self.patterns {
            Some(patterns) if place > 0 => {
                patterns.residual(g, &mut self.residual);
                let slope = self.residual.view();
                self.stacked
                    .backward(inputs, noise, slope, &mut self.gradient)?;
                None
            }
            _ => {
                let with_map = recipe.descent.map_in_objective;
                let (errors, mut slope) = training_set.objective(workspace, g, with_map)?;
                let scale = scale(recipe, errors, training_set.truths());
                slope *= scale as f32;
                let error = errors.posterior_error_m * scale;
                if !(error.is_finite() && slope.iter().all(|g| g.is_finite())) {
                    return Err(no_number(step));
                }
                self.stacked
                    .backward(inputs, noise, slope.view(), &mut self.gradient)?;
                if recipe.descent.pseudo_pattern_steps > 1 {
                    self.patterns = Some(Patterns {
                        output: g.to_owned(),
                        gradient: slope.to_owned(),
                    });
                }
                Some(reduction(errors))
            }
        };
        self.descent.step(&mut self.weights, &self.gradient)?;
        Ok(evaluated)
    }
}

impl Patterns {
    /// As [`PseudoPatterns::residual`].
    fn residual(&self, g: ArrayView2<f32>, residual: &mut Array2<f32>) {
        if residual.dim() != g.dim() {
            *residual = Array2::zeros(g.raw_dim());
        }
        Zip::from(residual)
            .and(g)
            .and(&self.output)
            .and(&self.gradient)
            .for_each(|residual, g, output, gradient| *residual = (g - output) + gradient);
    }
}
