//! What is learned from: inputs, places and priors of the training part, and of the validation part that stops it.

use super::{
    objective::{Evaluation, equal_weights, evaluate},
    prior_operator::PriorOperator,
    recipe::Recipe,
};
use crate::{
    belief::{Neighbours, Places},
    detector::input::Input,
    error::{Error, Result},
    recording::{Recording, split::Split},
};
use ndarray::{Array2, ArrayView2, Axis};

/// A snapshot outside the training part counts in a judgement if training saw a place this near …
pub const COVERED_WITHIN_M: f64 = 0.5;
/// … and with a heading this near.
pub const COVERED_WITHIN_RAD: f64 = 0.45;

/// The training part, ready for the objective.
pub struct Lesson {
    /// Fitted on the training part.
    pub input: Input,
    /// Normalised inputs, `[snapshot, input]`.
    pub inputs: Array2<f32>,
    /// Where they were seen.
    pub places: Places,
    /// Indices of the training snapshots in the recording.
    pub snapshots: Vec<usize>,
    prior: PriorOperator,
    smoothing: Smoothing,
    /// What stops the training, where the recording allows.
    pub exam: Option<Exam>,
}

/// Snapshots that training does not see, at places that it does: their error under the trained map.
pub struct Exam {
    /// Normalised inputs, `[snapshot, input]`.
    pub inputs: Array2<f32>,
    prior: PriorOperator,
}

/// P(f_i|ξ) of every training place as [`crate::belief::FeatureMap`] has it: the mean activation over its nearest
/// training snapshots (Thrun 1998, 5.1.6), kept off 0 and 1.
struct Smoothing {
    neighbours: Neighbours,
    unmodelled_probability: f64,
}

impl Lesson {
    /// Prepares the training and validation parts of a recording.
    ///
    /// # Errors
    /// Where fewer training snapshots are left than the map has neighbours, or no window holds a second snapshot.
    pub fn prepare(recipe: &Recipe, recording: &Recording, split: &Split) -> Result<Self> {
        let all_places = Places::of(recording);
        let places = all_places.select(&split.train);
        let input = Input::fit(&recipe.input, recording, &split.train)?;
        let all_inputs = input.of(recording)?;
        let prior = PriorOperator::new(recipe.uncertainty, &places, &places);
        if prior.window_sizes().iter().all(|&size| size < 2) {
            return Err(Error::work(format!(
                "uncertainty {}: no training snapshot has another one in its window, so there is nothing to tell apart; \
                 expected a wider window or snapshots closer together",
                recipe.uncertainty
            )));
        }
        if prior.prior_error_m().iter().all(|&error_m| error_m == 0.0) {
            return Err(Error::work(
                "the training snapshots that could be mistaken for one another were all taken at the same place, so no \
                 mistake costs anything; expected a robot that moves",
            ));
        }
        let smoothing = Smoothing {
            neighbours: Neighbours::find(&places, &places, &recipe.map.nearness)?,
            unmodelled_probability: recipe.map.unmodelled_probability,
        };
        let exam = Exam::prepare(recipe, &all_places, &all_inputs, &places, &split.validation);
        let inputs = all_inputs.select(Axis(0), &split.train);
        Ok(Self {
            input,
            inputs,
            places,
            snapshots: split.train.clone(),
            prior,
            smoothing,
            exam,
        })
    }

    /// The objective at some activations of the training part, and its gradient `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn objective(
        &self,
        activation: ArrayView2<f64>,
        map_in_objective: bool,
    ) -> Result<(Evaluation, Array2<f64>)> {
        let weight = equal_weights(activation.nrows());
        if map_in_objective {
            let map = self.smoothing.apply(activation);
            let e = evaluate(&self.prior, activation, map.view(), weight.view())?;
            let gradient = self.smoothing.back(e.map_gradient.view()) + &e.truth_gradient;
            Ok((e, gradient))
        } else {
            let e = evaluate(&self.prior, activation, activation, weight.view())?;
            let gradient = &e.truth_gradient + &e.map_gradient;
            Ok((e, gradient))
        }
    }

    /// The held-out objective: truths are the validation snapshots, the map is what training has made of its places.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn examine(
        &self,
        exam: &Exam,
        truth: ArrayView2<f64>,
        training: ArrayView2<f64>,
    ) -> Result<Evaluation> {
        let map = self.smoothing.apply(training);
        evaluate(
            &exam.prior,
            truth,
            map.view(),
            equal_weights(truth.nrows()).view(),
        )
    }
}

impl Exam {
    fn prepare(
        recipe: &Recipe,
        all_places: &Places,
        all_inputs: &Array2<f32>,
        places: &Places,
        validation: &[usize],
    ) -> Option<Self> {
        let covered = covered(all_places, validation, places);
        let prior = PriorOperator::new(recipe.uncertainty, &all_places.select(&covered), places);
        let sizes = prior.window_sizes();
        let counted: Vec<usize> = covered
            .into_iter()
            .zip(sizes)
            .filter(|(_, size)| *size > 1)
            .map(|(k, _)| k)
            .collect();
        if counted.is_empty() {
            return None;
        }
        let prior = PriorOperator::new(recipe.uncertainty, &all_places.select(&counted), places);
        if prior.prior_error_m().iter().all(|&error_m| error_m == 0.0) {
            return None; // a reduction of nothing is no number
        }
        Some(Self {
            inputs: all_inputs.select(Axis(0), &counted),
            prior,
        })
    }
}

/// Those of some snapshots that have a training place within [`COVERED_WITHIN_M`] and [`COVERED_WITHIN_RAD`].
pub fn covered(all: &Places, snapshots: &[usize], training: &Places) -> Vec<usize> {
    let near = |k: usize, t: usize| {
        all.distance_m(k, training, t) < COVERED_WITHIN_M
            && all.turn_rad(k, training, t) < COVERED_WITHIN_RAD
    };
    snapshots
        .iter()
        .copied()
        .filter(|&k| (0..training.len()).any(|t| near(k, t)))
        .collect()
}

impl Smoothing {
    fn apply(&self, activation: ArrayView2<f64>) -> Array2<f64> {
        let mut map = Array2::zeros(activation.raw_dim());
        let chance = self.unmodelled_probability;
        for (place, mut probability) in map.rows_mut().into_iter().enumerate() {
            for &k in self.neighbours.of(place) {
                probability += &activation.row(k);
            }
            let share = 1.0 / self.neighbours.k() as f64;
            probability.mapv_inplace(|sum| (1.0 - chance) * sum * share + 0.5 * chance);
        }
        map
    }

    /// The transpose: from ∂E/∂map to ∂E/∂activation.
    fn back(&self, gradient: ArrayView2<f64>) -> Array2<f64> {
        let mut out = Array2::zeros(gradient.raw_dim());
        let share = (1.0 - self.unmodelled_probability) / self.neighbours.k() as f64;
        for (place, slope) in gradient.rows().into_iter().enumerate() {
            for &k in self.neighbours.of(place) {
                out.row_mut(k).scaled_add(share, &slope);
            }
        }
        out
    }
}
