//! Networks that have seen many buildings before they see the user's: the same objective, each step on one of thousands of
//! simulated ones.
//!
//! Of every building the map is what its first run draws, and the candidates of a step are rendered in it; the truths are later
//! visits, with doors, furniture and people drawn anew ([`GeneratedBuilding`]). What is learned is what any building has in common: how
//! a scan that was taken answers as one that is rendered, whatever stands in its way.

mod varied_sensor;

pub use varied_sensor::VariedSensorConfig;

use super::{
    error_reduction::ErrorReduction,
    every_pose::{EveryPose, alone},
    mini_batch::{MiniBatch, blinded, draw_uncertainty},
    optimiser::InPlace,
    problem::{Problem, Workspace},
    recipe::Recipe,
    trainer::Directive,
};
use crate::{
    belief::{Places, Uncertainty},
    detector::{
        input::Input,
        net::{Layer, Layered, Weights},
    },
    error::{Error, Result},
    recording::{Recording, split::Split},
    seed::{Seed, Stream},
    world::generated::{GeneratedBuilding, GeneratedConfig},
};
use ndarray::{Array2, Axis, concatenate};
use rand::{RngExt, seq::index};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// How networks are pre-trained.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PretrainingConfig {
    /// The buildings, and the sensor that goes through them.
    pub buildings: GeneratedConfig,
    /// Sensors that are worse than theirs.
    pub sensors: VariedSensorConfig,
    /// Buildings that a step may be of; the oldest gives way to a new one …
    pub at_hand: usize,
    /// … every so many steps.
    pub steps_per_building: usize,
    /// Buildings that are kept apart, to say what was learned.
    pub held_out: usize,
}

impl Default for PretrainingConfig {
    fn default() -> Self {
        Self {
            buildings: GeneratedConfig::default(),
            sensors: VariedSensorConfig::default(),
            at_hand: 24,
            steps_per_building: 8,
            held_out: 12,
        }
    }
}

impl PretrainingConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let counts = [
            ("at_hand", self.at_hand),
            ("steps_per_building", self.steps_per_building),
            ("held_out", self.held_out),
        ];
        match counts.into_iter().find(|(_, count)| *count == 0) {
            Some((key, _)) => Err(Error::usage(format!(
                "pretrain.{key} = 0: expected at least 1"
            ))),
            None => self.sensors.check().and_then(|()| self.buildings.check()),
        }
    }
}

/// Where a pre-training stands.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PretrainingProgress {
    /// Steps taken.
    pub step: usize,
    /// Of so many.
    pub steps: usize,
    /// Buildings drawn.
    pub buildings: usize,
    /// Error reduction on the buildings kept apart when it was last asked for.
    pub held_out: Option<f64>,
}

/// Networks that have seen many buildings.
#[derive(Debug, Clone)]
pub struct Pretrained {
    /// How readings become inputs: constants of the first buildings.
    pub input: Input,
    /// The networks, the gain within the last layer.
    pub weights: Weights,
    /// Share of the prior error that one snapshot removes with no idea where, mean of the buildings kept apart.
    pub held_out: f64,
    /// Buildings drawn on the way.
    pub buildings: usize,
    /// One of those kept apart.
    pub building: GeneratedBuilding,
}

/// Later snapshots of a building that it is judged on.
const JUDGED: usize = 200;

/// One building, ready to be learned from.
struct Lesson {
    /// How the sensor's readings become inputs.
    input: Input,
    every_pose: EveryPose,
    /// Where the first run took its scans.
    mapped: Places,
    later: Recording,
}

impl Lesson {
    fn new(building: &GeneratedBuilding, recipe: &Recipe, input: Input) -> Result<Option<Self>> {
        let split = Split {
            train: (0..building.first.len()).collect(),
            ..Split::default()
        };
        let every_pose = EveryPose::prepare(recipe, &building.first, &split, &input, None)?;
        Ok(every_pose.map(|every_pose| Self {
            input,
            every_pose,
            mapped: Places::of(&building.first),
            later: building.second.clone(),
        }))
    }

    /// The snapshots of a step.
    fn mini_batch(
        &self,
        config: &PretrainingConfig,
        recipe: &Recipe,
        random: &mut Stream,
    ) -> Result<MiniBatch> {
        let count = recipe.descent.truths_per_step.min(self.later.len());
        let truths = index::sample(random, self.later.len(), count).into_vec();
        let uncertainty = (0..count).map(|_| draw_uncertainty(recipe, random));
        let uncertainty = uncertainty.collect();
        let (people, dropped) = (
            recipe.augmentation.most_people(true),
            recipe.augmentation.dropped_beams,
        );
        let seen = blinded(self.later.select(&truths)?, people, dropped, random)?;
        let places = Places::of(&seen);
        let rendered = recipe.descent.rendered_per_step;
        let (candidates, rendered) = self.every_pose.draw(&places, rendered, random);
        let problem =
            Problem::for_step(recipe, &alone(&recipe.map), uncertainty, places, candidates)?;
        let inputs = [self.input.transform(&seen)?, rendered];
        let mut inputs = concatenate(Axis(0), &inputs.each_ref().map(|inputs| inputs.view()))
            .map_err(|e| Error::work(format!("inputs of a step: {e}")))?;
        if let Some(reach_m) = config.sensors.reach_m(seen.channels(), random) {
            inputs = self.input.within_reach(reach_m, inputs);
        }
        let deviation = recipe.augmentation.input_noise as f32;
        inputs.mapv_inplace(|x| {
            let noise: f32 = StandardNormal.sample(random);
            x + deviation * noise
        });
        Ok(MiniBatch {
            inputs,
            truths: count,
            problem,
        })
    }

    /// One later snapshot's error reduction with no idea where in the building the robot is.
    fn judge(&self, recipe: &Recipe, networks: &Weights) -> Result<ErrorReduction> {
        let every = self.later.len().div_ceil(JUDGED);
        let truths: Vec<usize> = (0..self.later.len()).step_by(every).collect();
        let seen = self.later.select(&truths)?;
        let global = Recipe {
            uncertainty: Uncertainty::Global,
            ..recipe.clone()
        };
        let map = alone(&recipe.map);
        let problem = Problem::reported(&global, &map, &Places::of(&seen), &self.mapped)?;
        let truths = answers(networks, &self.input.transform(&seen)?)?;
        let candidates = answers(networks, &self.every_pose.at_training)?;
        problem.judge(truths.view(), candidates.view())
    }
}

fn answers(networks: &Weights, inputs: &Array2<f32>) -> Result<Array2<f32>> {
    let mut out = Array2::zeros((inputs.nrows(), networks.features()));
    Layered::default().forward(networks, inputs.view(), out.view_mut())?;
    Ok(out)
}

/// Buildings in the order of their numbers, those passed over that are too small.
struct Buildings<'a> {
    config: &'a PretrainingConfig,
    seed: Seed,
    next: u64,
}

/// So many plans in a row without floor to go about in: no wonder of chance, but a configuration.
const MOST_REFUSED: u64 = 100;

impl Buildings<'_> {
    fn draw(&mut self) -> Result<GeneratedBuilding> {
        for _ in 0..MOST_REFUSED {
            self.next += 1;
            if let Some(building) =
                GeneratedBuilding::draw(&self.config.buildings, self.next - 1, self.seed)?
            {
                return Ok(building);
            }
        }
        Err(Error::usage(format!(
            "pretrain.buildings: {MOST_REFUSED} plans in a row have no way through them; expected shorter ways or less clearance"
        )))
    }

    fn lesson(&mut self, recipe: &Recipe, input: &Input) -> Result<Lesson> {
        loop {
            let building = self.draw()?;
            let mut random = self.seed.numbered_stream("varied sensor", self.next);
            let sensors = &self.config.sensors;
            let worsened = sensors.worsened(input, building.first.channels(), &mut random);
            if let Some(lesson) = Lesson::new(&building, recipe, worsened)? {
                return Ok(lesson);
            }
        }
    }
}

/// Pre-trains a recipe's networks on simulated buildings. The same seed gives the same networks, whatever the number of threads.
///
/// # Errors
/// Where recipe or configuration make no sense, the networks have no trunk, and where `on_progress` cancels.
pub fn pretrain(
    config: &PretrainingConfig,
    recipe: &Recipe,
    on_progress: &mut dyn FnMut(PretrainingProgress) -> Directive,
) -> Result<Pretrained> {
    recipe.check()?;
    config.check()?;
    let seed = Seed(recipe.seed);
    let mut buildings = Buildings {
        config,
        seed,
        next: 0,
    };
    let apart = (0..config.held_out).map(|_| buildings.draw());
    let apart = apart.collect::<Result<Vec<_>>>()?;
    // The constants of the inputs are those of several buildings, and stay.
    let several = Recording::joined(
        apart
            .iter()
            .map(|building| building.first.clone())
            .collect(),
    )?;
    let everything: Vec<usize> = (0..several.len()).collect();
    let input = Input::fit(&recipe.input, &several, &everything)?;
    let mut held_out = Vec::new();
    for building in &apart {
        held_out.extend(Lesson::new(building, recipe, input.clone())?);
    }
    let mut initial = seed.stream("initial weights");
    let mut weights = Weights::random(
        &recipe.network,
        input.shape(),
        recipe.features,
        &mut initial,
    );
    if !Layered::fits(&weights) || recipe.descent.truths_per_step == 0 {
        return Err(Error::usage(
            "pretraining: expected networks with a trunk and one layer of their own (network.trunk, network.hidden = []), and \
             truths drawn for every step (descent.truths_per_step)",
        ));
    }
    let judge = |weights: &Weights| -> Result<f64> {
        let networks = with_gain(weights, recipe.network.gain);
        let judged = held_out
            .iter()
            .map(|lesson| lesson.judge(recipe, &networks));
        let judged = judged.collect::<Result<Vec<_>>>()?;
        let sum: f64 = judged.iter().map(|judged| judged.error_reduction).sum();
        Ok(sum / judged.len().max(1) as f64)
    };
    let (mut layered, mut workspace) = (Layered::default(), Workspace::default());
    let (mut descent, mut gradient) = (InPlace::new(&recipe.descent), weights.clone());
    let mut at_hand: VecDeque<Lesson> = VecDeque::new();
    let mut judged = None;
    let steps = recipe.descent.steps;
    for step in 0..=steps {
        if step.is_multiple_of(recipe.descent.validate_every) || step == steps {
            judged = Some(judge(&weights)?);
        }
        let progress = PretrainingProgress {
            step,
            steps,
            buildings: buildings.next as usize,
            held_out: judged,
        };
        match on_progress(progress) {
            Directive::Continue if step < steps => {}
            Directive::Cancel => {
                return Err(Error::cancelled(format!(
                    "the pre-training was cancelled at step {step} of {steps}"
                )));
            }
            _ => break,
        }
        if step.is_multiple_of(config.steps_per_building) {
            at_hand.push_back(buildings.lesson(recipe, &input)?);
            if at_hand.len() > config.at_hand {
                at_hand.pop_front();
            }
        }
        let mut random = seed.numbered_stream("draw of a pre-training step", step as u64);
        let lesson = &at_hand[random.random_range(0..at_hand.len())];
        let batch = lesson.mini_batch(config, recipe, &mut random)?;
        let networks = with_gain(&weights, recipe.network.gain);
        let mut out = Array2::zeros((batch.inputs.nrows(), recipe.features));
        layered.forward(&networks, batch.inputs.view(), out.view_mut())?;
        let (truths, candidates) = out.view().split_at(Axis(0), batch.truths);
        let answer = batch
            .problem
            .evaluate(&mut workspace, truths, candidates, true)?;
        let share = match answer.errors.prior_error_m > 0.0 {
            true => 1.0 / answer.errors.prior_error_m as f32,
            false => 1.0,
        };
        let slopes = [answer.truth_gradient, answer.candidate_gradient];
        let slope = concatenate(Axis(0), &slopes)
            .map_err(|e| Error::work(format!("slopes of a step: {e}")))?
            * share;
        if !slope.iter().all(|s| s.is_finite()) {
            return Err(Error::work(format!(
                "the objective is no longer a number after {step} steps; expected a smaller descent.learning_rate"
            )));
        }
        layered.backward(&networks, slope.view(), &mut gradient)?;
        if let Some(last) = gradient.layers.last_mut() {
            last.weight *= recipe.network.gain;
            last.bias *= recipe.network.gain;
        }
        shorten(&mut gradient, recipe.descent.gradient_limit);
        descent.step(&mut weights, &gradient)?;
    }
    let networks = with_gain(&weights, recipe.network.gain);
    let Some(building) = apart.into_iter().next() else {
        return Err(Error::work("pretraining: no building kept apart"));
    };
    Ok(Pretrained {
        input,
        weights: networks,
        held_out: judged.unwrap_or(f64::NAN),
        buildings: buildings.next as usize,
        building,
    })
}

/// The gain as part of the last layer.
fn with_gain(weights: &Weights, gain: f32) -> Weights {
    let mut weights = weights.clone();
    if let Some(last) = weights.layers.last_mut() {
        last.weight *= gain;
        last.bias *= gain;
    }
    weights
}

/// Shortens a gradient to a length over all parameters, where it is longer; 0: any.
fn shorten(gradient: &mut Weights, limit: f64) {
    let square = |x: &f32| f64::from(*x).powi(2);
    let of_layer = |layer: &Layer| {
        layer.weight.iter().map(square).sum::<f64>() + layer.bias.iter().map(square).sum::<f64>()
    };
    let length = gradient.layers.iter().map(of_layer).sum::<f64>().sqrt();
    if limit > 0.0 && length > limit {
        let share = (limit / length) as f32;
        for layer in &mut gradient.layers {
            layer.weight *= share;
            layer.bias *= share;
        }
    }
}

#[cfg(test)]
mod tests;
