//! A problem for the objective: truths, candidates, and the priors that join them.

use super::{
    error_reduction::{ErrorReduction, Errors},
    mean_field::{self, Priors},
    objective::{self, Evaluation, Objective as Exact},
    prior_operator::PriorOperator,
    recipe::{ObjectiveKind, Recipe},
    smoothing::Smoothing,
};
use crate::{
    belief::{MapConfig, Places, Uncertainty},
    error::Result,
};
use ndarray::{Array1, Array2, ArrayView2};

/// Room to evaluate one problem after the other: fresh arrays would cost more than what is computed in them.
#[derive(Debug, Default)]
pub struct Workspace {
    exact: Exact<f32>,
    wide: Evaluation<f32>,
    /// P(f|ξ) of the candidates, and ∂E/∂g of theirs behind it, `[candidate, feature]`.
    map: Array2<f32>,
    behind_map: Array2<f32>,
    /// ∂E/∂g of snapshots that are truth and candidate at once, `[snapshot, feature]`.
    pub(super) both: Array2<f32>,
}

/// The objective and its gradient ∂E_posterior/∂g.
pub struct Answer<'a> {
    /// The objective.
    pub errors: Errors,
    /// With respect to the truths' activations, `[truth, feature]`.
    pub truth_gradient: ArrayView2<'a, f32>,
    /// With respect to the candidates', `[candidate, feature]`.
    pub candidate_gradient: ArrayView2<'a, f32>,
}

/// Truths and candidates with the prior that joins them, and the map that is made of the candidates.
///
/// Behind it stands the exact objective or the mean-field one, whichever the recipe asks for.
pub struct Problem {
    priors: Joined,
    smoothing: Smoothing,
}

enum Joined {
    Exact(PriorOperator, Array1<f64>, Stated),
    MeanField(Priors, Array1<f64>),
}

/// What an operator was made of.
struct Stated {
    uncertainty: Uncertainty,
    truths: Places,
    candidates: Places,
}

/// A problem pair by pair, for an evaluation on a device.
pub struct Pairs {
    /// The exact objective, of all 2^n outcomes, or the mean-field one.
    pub exact: bool,
    /// e(ξ*, ξ) in metres, ∞ where the prior does not admit the candidate: `[truth, candidate]`.
    pub errors_m: Array2<f32>,
    /// Weights of the truths, which sum to 1.
    pub weight: Array1<f64>,
    /// E_prior in metres.
    pub prior_error_m: f64,
    /// Where posteriors should be, `[truth, candidate]`, and what a nat of their cross entropy counts for in metres, `[truth]`;
    /// none where the error alone is descended.
    pub targets: Option<(Array2<f32>, Array1<f64>)>,
}

impl Problem {
    /// Equal weights for the truths, who all have the stated uncertainty: what is reported. `map` says how a candidate's map is
    /// made of the candidates around it.
    ///
    /// # Errors
    /// Where there is no candidate.
    pub fn reported(
        recipe: &Recipe,
        map: &MapConfig,
        truths: &Places,
        candidates: &Places,
    ) -> Result<Self> {
        let priors = match recipe.descent.objective {
            ObjectiveKind::Exact => Joined::Exact(
                PriorOperator::new(recipe.uncertainty, truths, candidates),
                objective::equal_weights(truths.len()),
                Stated {
                    uncertainty: recipe.uncertainty,
                    truths: truths.clone(),
                    candidates: candidates.clone(),
                },
            ),
            ObjectiveKind::MeanField => {
                let stated = vec![recipe.uncertainty; truths.len()];
                let priors = Priors::new(stated, truths.clone(), candidates.clone());
                let weight = priors.equal_weights();
                Joined::MeanField(priors, weight)
            }
        };
        Ok(Self {
            priors,
            smoothing: Smoothing::new(map, candidates)?,
        })
    }

    /// A step's: every truth with an uncertainty of its own where the objective allows, its error counted as a share of
    /// its prior error.
    ///
    /// # Errors
    /// Where there is no candidate.
    pub fn for_step(
        recipe: &Recipe,
        map: &MapConfig,
        uncertainty: Vec<Uncertainty>,
        truths: Places,
        candidates: Places,
    ) -> Result<Self> {
        if recipe.descent.objective == ObjectiveKind::Exact {
            return Self::reported(recipe, map, &truths, &candidates);
        }
        let smoothing = Smoothing::new(map, &candidates)?;
        let mut priors = Priors::new(uncertainty, truths, candidates);
        priors.with_targets(recipe.descent.cross_entropy);
        let weight = priors.relative_weights();
        Ok(Self {
            priors: Joined::MeanField(priors, weight),
            smoothing,
        })
    }

    /// Candidates that the prior of every truth admits.
    pub fn window_sizes(&self) -> Vec<usize> {
        match &self.priors {
            Joined::Exact(operator, ..) => operator.window_sizes(),
            Joined::MeanField(priors, _) => priors.window_sizes().to_vec(),
        }
    }

    /// Does any mistake cost anything?
    pub fn has_prior_error(&self) -> bool {
        match &self.priors {
            Joined::Exact(operator, ..) => operator.prior_error_m().iter().any(|&e| e > 0.0),
            Joined::MeanField(priors, _) => priors.prior_error_m().iter().any(|&e| e > 0.0),
        }
    }

    /// Every pair of truth and candidate, where there are at most `most`.
    pub fn pairs(&self, most: usize) -> Option<Pairs> {
        let table = |priors: &Priors, exact, weight: &Array1<f64>, prior_error_m| {
            (priors.len() <= most).then(|| Pairs {
                exact,
                errors_m: priors.table(),
                weight: weight.clone(),
                prior_error_m,
                targets: priors.targets(),
            })
        };
        match &self.priors {
            Joined::Exact(operator, weight, stated) => {
                if operator.truths().saturating_mul(operator.candidates()) > most {
                    return None;
                }
                let uncertainty = vec![stated.uncertainty; stated.truths.len()];
                let priors = Priors::new(
                    uncertainty,
                    stated.truths.clone(),
                    stated.candidates.clone(),
                );
                table(&priors, true, weight, operator.prior_error_m().dot(weight))
            }
            Joined::MeanField(priors, weight) => {
                table(priors, false, weight, priors.prior_error_m().dot(weight))
            }
        }
    }

    /// The map that is made of the candidates.
    pub fn smoothing(&self) -> &Smoothing {
        &self.smoothing
    }

    /// The objective at the activations of the truths and of the candidates, `[snapshot, feature]` each, and its gradient
    /// with respect to both. Without `with_map` every candidate stands for itself alone.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn evaluate<'a>(
        &self,
        workspace: &'a mut Workspace,
        truth: ArrayView2<f32>,
        candidates: ArrayView2<f32>,
        with_map: bool,
    ) -> Result<Answer<'a>> {
        let Workspace {
            exact,
            wide,
            map,
            behind_map,
            ..
        } = workspace;
        let map = match with_map {
            true => {
                self.smoothing.apply(candidates, map);
                map.view()
            }
            false => candidates,
        };
        let e = match &self.priors {
            Joined::Exact(operator, weight, _) => {
                exact.evaluate(operator, truth, map, weight.view())?
            }
            Joined::MeanField(priors, weight) => {
                *wide = mean_field::evaluate(priors, truth, map, weight.view());
                wide
            }
        };
        let candidate_gradient = match with_map {
            true => {
                self.smoothing
                    .apply_transpose(e.map_gradient.view(), behind_map);
                behind_map.view()
            }
            false => e.map_gradient.view(),
        };
        Ok(Answer {
            errors: Errors {
                prior_error_m: e.prior_error_m,
                posterior_error_m: e.posterior_error_m,
            },
            truth_gradient: e.truth_gradient.view(),
            candidate_gradient,
        })
    }

    /// The objective with the map and without a gradient: what is reported.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn judge(
        &self,
        truth: ArrayView2<f32>,
        candidates: ArrayView2<f32>,
    ) -> Result<ErrorReduction> {
        let mut map = Array2::default((0, 0));
        self.smoothing.apply(candidates, &mut map);
        let (prior_error_m, posterior_error_m) = match &self.priors {
            Joined::Exact(operator, weight, _) => {
                let mut exact = Exact::<f32>::new();
                let e = exact.evaluate(operator, truth, map.view(), weight.view())?;
                (e.prior_error_m, e.posterior_error_m)
            }
            Joined::MeanField(priors, weight) => {
                let error_m = mean_field::error_m(priors, truth, map.view(), weight.view());
                let prior = priors.prior_error_m();
                (prior.iter().zip(weight).map(|(e, w)| e * w).sum(), error_m)
            }
        };
        Ok(ErrorReduction {
            prior_error_m,
            posterior_error_m,
            error_reduction: 1.0 - posterior_error_m / prior_error_m,
            snapshots: truth.nrows(),
        })
    }
}
