//! One question to the objective: these truths, those candidates, such priors.

use super::{
    mean_field::{self, Priors},
    objective::{self, Evaluation},
    prior_operator::PriorOperator,
    recipe::{Objective, Recipe},
    smoothing::Smoothing,
    trainer::Score,
};
use crate::{
    belief::{Places, Uncertainty},
    error::Result,
};
use ndarray::{Array1, Array2, ArrayView2};

/// Truths and candidates with the prior that joins them, and the map that is made of the candidates.
///
/// Behind it stands the exact objective or the mean-field one, whichever the recipe asks for.
pub struct Task {
    priors: Joined,
    smoothing: Smoothing,
}

enum Joined {
    Exact(PriorOperator, Array1<f64>),
    MeanField(Priors, Array1<f64>),
}

impl Task {
    /// Equal weights for the truths, who all have the stated uncertainty: what is reported.
    ///
    /// # Errors
    /// Where there is no candidate.
    pub fn stated(recipe: &Recipe, truths: &Places, candidates: &Places) -> Result<Self> {
        let priors = match recipe.descent.objective {
            Objective::Exact => Joined::Exact(
                PriorOperator::new(recipe.uncertainty, truths, candidates),
                objective::equal_weights(truths.len()),
            ),
            Objective::MeanField => {
                let stated = vec![recipe.uncertainty; truths.len()];
                let priors = Priors::new(stated, truths.clone(), candidates.clone());
                let weight = priors.equal_weights();
                Joined::MeanField(priors, weight)
            }
        };
        Ok(Self {
            priors,
            smoothing: Smoothing::new(&recipe.map, candidates)?,
        })
    }

    /// A step's: every truth with an uncertainty of its own where the objective allows, its error counted as a share of
    /// its prior error.
    ///
    /// # Errors
    /// Where there is no candidate.
    pub fn of_step(
        recipe: &Recipe,
        uncertainty: Vec<Uncertainty>,
        truths: Places,
        candidates: Places,
    ) -> Result<Self> {
        if recipe.descent.objective == Objective::Exact {
            return Self::stated(recipe, &truths, &candidates);
        }
        let smoothing = Smoothing::new(&recipe.map, &candidates)?;
        let priors = Priors::new(uncertainty, truths, candidates);
        let weight = priors.relative_weights();
        Ok(Self {
            priors: Joined::MeanField(priors, weight),
            smoothing,
        })
    }

    /// Candidates that the prior of every truth admits.
    pub fn window_sizes(&self) -> Vec<usize> {
        match &self.priors {
            Joined::Exact(operator, _) => operator.window_sizes(),
            Joined::MeanField(priors, _) => priors.window_sizes().to_vec(),
        }
    }

    /// Does any mistake cost anything?
    pub fn has_prior_error(&self) -> bool {
        match &self.priors {
            Joined::Exact(operator, _) => operator.prior_error_m().iter().any(|&e| e > 0.0),
            Joined::MeanField(priors, _) => priors.prior_error_m().iter().any(|&e| e > 0.0),
        }
    }

    /// The objective at the activations of the truths and of the candidates, `[snapshot, feature]` each, and its gradient
    /// with respect to both. Without `with_map` every candidate stands for itself alone.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn evaluate(
        &self,
        truth: ArrayView2<f32>,
        candidates: ArrayView2<f32>,
        with_map: bool,
    ) -> Result<Evaluation> {
        let map = self.map(candidates, with_map);
        let mut e = match &self.priors {
            Joined::Exact(operator, weight) => {
                let truth = truth.mapv(f64::from);
                objective::evaluate(operator, truth.view(), map.view(), weight.view())?
            }
            Joined::MeanField(priors, weight) => {
                let map = map.mapv(|m| m as f32);
                mean_field::evaluate(priors, truth, map.view(), weight.view())
            }
        };
        if with_map {
            e.map_gradient = self.smoothing.back(e.map_gradient.view());
        }
        Ok(e)
    }

    /// The objective with the map and without a gradient: what is reported.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn judge(&self, truth: ArrayView2<f32>, candidates: ArrayView2<f32>) -> Result<Score> {
        let map = self.map(candidates, true);
        let (prior_error_m, posterior_error_m) = match &self.priors {
            Joined::Exact(operator, weight) => {
                let truth = truth.mapv(f64::from);
                let e = objective::evaluate(operator, truth.view(), map.view(), weight.view())?;
                (e.prior_error_m, e.posterior_error_m)
            }
            Joined::MeanField(priors, weight) => {
                let map = map.mapv(|m| m as f32);
                let error_m = mean_field::error_m(priors, truth, map.view(), weight.view());
                let prior = priors.prior_error_m();
                (prior.iter().zip(weight).map(|(e, w)| e * w).sum(), error_m)
            }
        };
        Ok(Score {
            prior_error_m,
            posterior_error_m,
            error_reduction: 1.0 - posterior_error_m / prior_error_m,
            snapshots: truth.nrows(),
        })
    }

    fn map(&self, candidates: ArrayView2<f32>, with_map: bool) -> Array2<f64> {
        let candidates = candidates.mapv(f64::from);
        match with_map {
            true => self.smoothing.apply(candidates.view()),
            false => candidates,
        }
    }
}
