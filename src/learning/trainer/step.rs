//! One step of a training: forward, objective, backward, descent; and the judgement of the networks between two steps.

use super::{
    array_backend::ArrayBackend,
    batch::{Batch, Noise, Site, answers, no_number},
    phase::{Phase, of_features, put_features},
    progress::{StoppedBy, Trained},
    pseudo_patterns::PseudoPatterns,
    state::State,
    tensors::{array, limited, tensor},
};
use crate::{
    detector::{
        device::cpu,
        net::{Layered, Nets},
    },
    error::{Error, Result},
    learning::{
        error_reduction::ErrorReduction,
        optimiser::Descent,
        problem::Workspace,
        recipe::{Optimiser, Recipe},
        training_set::TrainingSet,
    },
};
use burn::tensor::{Device, Tensor};
use ndarray::Array2;
use std::sync::Arc;

/// A training between two steps.
pub struct Trainer<'a> {
    recipe: &'a Recipe,
    training_set: &'a TrainingSet<'a>,
    device: Device,
    /// The training set's inputs on the device, `[snapshot, input]`.
    inputs: Tensor<2>,
    /// The candidates' at the training places, where those are others.
    rendered: Option<Tensor<2>>,
    noise: Arc<Noise>,
    /// Where the objective is evaluated: dense on a GPU that the networks are on, by its structure on the CPU.
    site: Site,
    workspace: Workspace,
    /// Takes the steps where the networks' shape and the recipe allow; tensors take them elsewhere.
    pub(super) array_backend: Option<ArrayBackend>,
    /// Carries steps through networks on a trunk, where their shape allows; a tape does elsewhere.
    layered: Option<Layered>,
    /// What the last step was about; the next one of its series is about the same.
    batch: Option<Batch>,
    /// Where training stands; on the array backend only once it is [synchronised](Self::sync).
    pub(super) now: State,
}

impl<'a> Trainer<'a> {
    /// Before the first step.
    pub fn new(recipe: &'a Recipe, training_set: &'a TrainingSet<'a>, device: &Device) -> Self {
        let weights = training_set.weights.clone();
        let mut nets = Nets::new(&weights, device);
        nets.gain = recipe.network.gain;
        Self {
            noise: Arc::new(Noise::new(recipe)),
            site: match *device == cpu() {
                true => Site::Cpu,
                false => Site::device(recipe, training_set, device),
            },
            workspace: Workspace::default(),
            array_backend: ArrayBackend::where_it_fits(recipe, &weights, device),
            layered: (*device == cpu() && Layered::fits(&weights)).then(Layered::default),
            batch: None,
            recipe,
            training_set,
            inputs: tensor(training_set.inputs.view(), device),
            rendered: training_set
                .every_pose
                .as_ref()
                .map(|every_pose| tensor(every_pose.at_training.view(), device)),
            now: State::start(nets, Descent::new(&recipe.descent)),
            device: device.clone(),
        }
    }

    /// The same, but with every step taken on tensors, whatever the shape: what the array backend is held against.
    pub fn on_tensors(mut self) -> Self {
        self.sync();
        self.array_backend = None;
        self.layered = None;
        self
    }

    /// The same, but with the objective evaluated dense on the device, whatever the device: what a GPU does, held against
    /// the CPU's own way.
    pub fn with_dense_objective(mut self) -> Self {
        self = self.on_tensors();
        self.site = Site::device(self.recipe, self.training_set, &self.device);
        self
    }

    /// Goes on from where a training stood.
    pub(super) fn load(&mut self, now: State) -> Result<()> {
        if let Some(array_backend) = &mut self.array_backend {
            array_backend.load(&now)?;
        }
        self.now = now;
        Ok(())
    }

    /// Brings the state up to the last step, before it is read.
    pub(super) fn sync(&mut self) {
        if let Some(array_backend) = &self.array_backend {
            array_backend.store(&mut self.now, &self.device);
        }
    }

    /// Steps taken.
    pub fn steps(&self) -> usize {
        self.now.descent.steps
    }

    /// One step of the networks that learn now: forward, objective outside the tape, backward through the networks,
    /// descent. Within a series of steps on pseudo-patterns, only the first evaluates the objective.
    ///
    /// # Errors
    /// Where the objective or its gradient is no longer a finite number.
    pub fn step(&mut self) -> Result<()> {
        if let Some(array_backend) = &mut self.array_backend {
            let space = &mut self.workspace;
            return array_backend.step(
                self.recipe,
                self.training_set,
                &self.noise,
                space,
                &mut self.now,
            );
        }
        let (recipe, step) = (self.recipe, self.steps());
        let phase = Phase::at(recipe, step);
        let (place, first) = phase.place_in_series(recipe, step);
        let batch = self.batch_of(&phase, first)?;
        let d = &recipe.descent;
        if d.truths_per_step == 0
            || d.sequential
            || d.pseudo_pattern_steps > 1
            || step + 1 >= d.steps
        {
            return self.step_on(batch, &phase, place);
        }
        // The next draw asks nothing of the weights: it is made while the networks are at work on this one.
        let (training_set, noise, device) = (
            self.training_set,
            Arc::clone(&self.noise),
            self.device.clone(),
        );
        let site = self.site.clone();
        let (stepped, next) = rayon::join(
            || self.step_on(batch, &phase, place),
            || Batch::new(recipe, training_set, &noise, None, step + 1, &site, &device),
        );
        stepped?;
        self.batch = Some(next?);
        Ok(())
    }

    /// One step on a batch.
    fn step_on(&mut self, batch: Batch, phase: &Phase, place: usize) -> Result<()> {
        let (recipe, step) = (self.recipe, self.steps());
        let nets = of_features(&self.now.nets, phase.learners.clone());
        let (error, slopes) = match self.layered.take() {
            None => self.slopes_on_tape(&batch, &nets, place)?,
            Some(mut layered) => {
                let found = self.slopes_on_arrays(&mut layered, &batch, &nets, place);
                self.layered = Some(layered);
                found?
            }
        };
        let slopes = limited(slopes, recipe.descent.gradient_limit)?;
        let moved = self.descend(&batch, nets, slopes, error)?;
        put_features(&mut self.now.nets, phase.learners.clone(), moved);
        self.batch = Some(batch);
        if Phase::at(recipe, step + 1) != *phase {
            self.now.begin_phase();
            self.batch = None;
        }
        Ok(())
    }

    /// What is descended and its slope in every parameter, weights before biases, by a tape through the networks.
    fn slopes_on_tape(
        &mut self,
        batch: &Batch,
        nets: &Nets,
        place: usize,
    ) -> Result<(f64, Vec<Tensor<3>>)> {
        let tracked = |t: &Tensor<3>| Tensor::from_inner(t.clone()).require_grad();
        let mut nets = nets.clone();
        nets.weight = nets.weight.iter().map(tracked).collect();
        nets.bias = nets.bias.iter().map(tracked).collect();
        let output = nets.forward(Tensor::from_inner(batch.inputs.clone())); // [snapshot, learner]
        // The slope is known in closed form, so the tape only carries Σ g ∘ slope back through the networks.
        let (error, slope) = self.error_and_slope(batch, output.clone().inner(), place)?;
        let surrogate = (output * Tensor::from_inner(slope)).sum();
        let mut gradients = surrogate.backward();
        let mut take = |t: &Tensor<3>| {
            t.grad_remove(&mut gradients)
                .ok_or_else(|| Error::work("a parameter of the networks got no gradient"))
        };
        let parameters = nets.weight.iter().chain(&nets.bias);
        let slopes = parameters.map(&mut take).collect::<Result<Vec<_>>>()?;
        Ok((error, slopes))
    }

    /// The same on plain arrays.
    fn slopes_on_arrays(
        &mut self,
        layered: &mut Layered,
        batch: &Batch,
        nets: &Nets,
        place: usize,
    ) -> Result<(f64, Vec<Tensor<3>>)> {
        let weights = nets.weights()?; // the gain within the last layer's
        let inputs = array(batch.inputs.clone())?;
        let mut output = Array2::zeros((inputs.nrows(), weights.features()));
        layered.forward(&weights, inputs.view(), output.view_mut())?;
        let output = tensor(output.view(), &self.device);
        let (error, slope) = self.error_and_slope(batch, output, place)?;
        let mut gradient = weights.clone();
        layered.backward(&weights, array(slope)?.view(), &mut gradient)?;
        if let Some(last) = gradient.layers.last_mut() {
            last.weight *= nets.gain;
            last.bias *= nets.gain;
        }
        let slopes = Nets::new(&gradient, &self.device);
        Ok((
            error,
            slopes.weight.into_iter().chain(slopes.bias).collect(),
        ))
    }

    /// What is descended where the networks answer `answer`, and its slope there, `[snapshot, learner]`: the objective
    /// with ∂E/∂g at a series' first step, the squared error of its pseudo-patterns at the others.
    fn error_and_slope(
        &mut self,
        batch: &Batch,
        answer: Tensor<2>,
        place: usize,
    ) -> Result<(f64, Tensor<2>)> {
        let searches = self.recipe.descent.optimiser == Optimiser::ConjugateGradient;
        if let (Some(patterns), 1..) = (&self.now.pseudo_patterns, place) {
            let error = match searches {
                true => patterns.error(answer.clone())?,
                false => f64::NAN, // not used
            };
            return Ok((error, patterns.residual(answer)));
        }
        let space = &mut self.workspace;
        let e = batch.evaluate(self.recipe, self.training_set, space, answer.clone())?;
        if !e.is_finite {
            return Err(no_number(self.steps()));
        }
        self.now.evaluations += 1;
        self.now.batch_error_reduction = e.error_reduction;
        let gradient = e.gradient;
        if self.recipe.descent.pseudo_pattern_steps == 1 {
            return Ok((e.error, gradient));
        }
        let patterns = PseudoPatterns {
            output: answer.clone(),
            gradient: gradient.clone(),
        };
        let error = patterns.error(answer)?;
        if searches {
            self.now.descent.forget(); // conjugate directions are those of one error
        }
        self.now.pseudo_patterns = Some(patterns);
        Ok((error, gradient))
    }

    /// The networks one step further down.
    fn descend(
        &mut self,
        batch: &Batch,
        nets: Nets,
        slopes: Vec<Tensor<3>>,
        error: f64,
    ) -> Result<Nets> {
        let parameters: Vec<Tensor<3>> = nets.weight.iter().chain(&nets.bias).cloned().collect();
        let layers = nets.weight.len();
        let with = |mut parameters: Vec<Tensor<3>>| Nets {
            bias: parameters.split_off(layers),
            weight: parameters,
            ..nets.clone()
        };
        let now = &mut self.now;
        let moved = match self.recipe.descent.optimiser {
            Optimiser::Adam | Optimiser::Momentum => now.descent.step(parameters, slopes),
            Optimiser::ConjugateGradient => {
                let (patterns, evaluations) = (&now.pseudo_patterns, &mut now.evaluations);
                let (recipe, training_set, space) =
                    (self.recipe, self.training_set, &mut self.workspace);
                let mut error_at = |parameters| {
                    let output = with(parameters).forward(batch.inputs.clone());
                    if let Some(patterns) = patterns {
                        return patterns.error(output);
                    }
                    *evaluations += 1;
                    let e = batch.evaluate(recipe, training_set, space, output)?;
                    Ok(e.error)
                };
                now.descent
                    .step_along_a_line(&parameters, &slopes, error, &mut error_at)?
            }
        };
        Ok(with(moved))
    }

    /// The batch of the series that began at step `first`: the last step's, or drawn (after a resumption, again).
    fn batch_of(&mut self, phase: &Phase, first: usize) -> Result<Batch> {
        // All training snapshots without noise stay the same from series to series.
        let unchanging =
            self.recipe.descent.truths_per_step == 0 && self.recipe.augmentation.input_noise == 0.0;
        if let Some(batch) = self.batch.take()
            && (batch.step == first || unchanging)
        {
            return Ok(batch);
        }
        let frozen = match phase.learners.start {
            0 => None,
            learned => Some(of_features(&self.now.nets, 0..learned)),
        };
        Batch::new(
            self.recipe,
            self.training_set,
            &self.noise,
            frozen.as_ref(),
            first,
            &self.site,
            &self.device,
        )
    }

    /// Judges the networks on the validation part, where there is one, and keeps them if they are the best so far.
    pub(super) fn judge_and_keep(&mut self) -> Result<Option<ErrorReduction>> {
        self.sync();
        let validation = self.validate(&self.now.nets)?;
        self.now.keep_if_best(validation.map(|e| e.error_reduction));
        Ok(validation)
    }

    /// The validation part under some networks, where there is one; without those that do not learn yet.
    fn validate(&self, nets: &Nets) -> Result<Option<ErrorReduction>> {
        let Some(validation_set) = &self.training_set.validation_set else {
            return Ok(None);
        };
        let phase = Phase::at(self.recipe, self.steps());
        let nets = of_features(nets, 0..phase.learners.end);
        let candidates = self.rendered.as_ref().unwrap_or(&self.inputs);
        let training = answers(&nets, candidates.clone(), self.steps())?;
        let truth = tensor(validation_set.inputs.view(), &self.device);
        let truth = answers(&nets, truth, self.steps())?;
        self.training_set
            .validate(validation_set, truth.view(), training.view())
            .map(Some)
    }

    /// The best networks, judged on both parts.
    pub(super) fn finish(
        mut self,
        stopped_by: StoppedBy,
        resumed_at: Option<usize>,
    ) -> Result<Trained> {
        self.sync();
        let nets = match self.now.best_validation {
            Some(_) => &self.now.best_nets,
            None => &self.now.nets,
        };
        let activation = answers(nets, self.inputs.clone(), self.steps())?;
        let train = match &self.rendered {
            None => self
                .training_set
                .judge(activation.view(), activation.view())?,
            Some(rendered) => {
                let candidates = answers(nets, rendered.clone(), self.steps())?;
                self.training_set
                    .judge(activation.view(), candidates.view())?
            }
        };
        Ok(Trained {
            weights: nets.weights()?,
            train,
            activation,
            validation: self.validate(nets)?,
            steps: self.steps(),
            evaluations: self.now.evaluations,
            stopped_by,
            resumed_at,
            extended_at: self.now.extended_at,
        })
    }
}
