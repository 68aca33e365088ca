//! What is trained how, as data: the resolved form of a training configuration.

use crate::{
    belief::{MapConfig, Uncertainty},
    detector::{input::InputConfig, net::NetConfig},
    error::{Error, Result},
    recording::split::SplitConfig,
};
use serde::{Deserialize, Serialize};

mod check;
mod thrun1998;

/// Everything that decides a training besides the data. A model file keeps it whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Recipe {
    /// The one seed of the run.
    pub seed: u64,
    /// Prior uncertainty that the filters are trained for.
    pub uncertainty: Uncertainty,
    /// Number n of filters.
    pub features: usize,
    /// What the networks begin with.
    pub begin_with: BeginWith,
    /// What the networks are fed.
    pub input: InputConfig,
    /// Their shape.
    pub network: NetConfig,
    /// How their weights descend.
    pub descent: DescentConfig,
    /// What happens to snapshots on the way.
    pub augmentation: AugmentationConfig,
    /// Which uncertainties are trained for besides the stated one.
    pub priors: PriorMix,
    /// How P(f|ξ) is read off the training part.
    pub map: MapConfig,
    /// What training sees, what stops it, and what neither sees.
    pub split: SplitConfig,
}

/// What networks begin with, where no model is named (`ballmark train --from`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum BeginWith {
    /// Networks that come with the program, pre-trained on simulated buildings, where the sensors and the recipe fit to them; else
    /// random ones.
    #[default]
    Pretrained,
    /// Random weights.
    Random,
}

/// How the weights descend E_posterior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescentConfig {
    /// What is descended.
    pub objective: ObjectiveKind,
    /// Rule for a step.
    pub optimiser: Optimiser,
    /// What the errors of the truths are put together to.
    pub scale: Scale,
    /// Length of a step down the gradient of that; with conjugate gradients, of the first that is tried.
    pub learning_rate: f64,
    /// Steps on one evaluation of the objective, which gives the outputs targets g − ∂E/∂g that all of them then follow
    /// by backpropagation (Thrun 1998, 4.4.2 item 3). 1: every step evaluates.
    pub pseudo_pattern_steps: usize,
    /// Learn one feature after another, each with those before it, which stay as they are (Thrun 1998, 4.4.2 item 1).
    /// The steps are dealt evenly among them.
    pub sequential: bool,
    /// How the length changes in the course of the steps.
    pub schedule: Schedule,
    /// Share of its length that every weight loses a step, times the learning rate.
    pub weight_decay: f64,
    /// Longest gradient, over all parameters; a longer one is shortened to it. 0: any.
    pub gradient_limit: f64,
    /// Most steps.
    pub steps: usize,
    /// Truths of a step, drawn anew for each; 0: all training snapshots at every step.
    #[serde(alias = "queries")]
    pub truths_per_step: usize,
    /// Candidate places of a step, drawn anew for each in short stretches; 0: all training snapshots.
    #[serde(alias = "places")]
    pub candidates_per_step: usize,
    /// Candidates of a step where they are rendered: two beside each truth, the rest anywhere.
    pub rendered_per_step: usize,
    /// Steps between two looks at the validation part.
    pub validate_every: usize,
    /// Stop after this many steps without a better validation error; where the best takes away less than 1 % of it, after
    /// a quarter of all steps without a better one.
    pub patience: usize,
    /// Steps between two checkpoints.
    pub checkpoint_every: usize,
    /// What is descended besides the expected error, as a share of it: the cross entropy between the posterior and a Gaussian
    /// about the truth (0.2 m, 0.2 rad). It has a slope where the posterior is sure and wrong, and the error has none. Of the
    /// mean-field objective only.
    pub cross_entropy: f64,
    /// Smooth the features into a map inside the objective, as localisation will.
    pub map_in_objective: bool,
    /// Draw the truths of a step from one run, and the candidates and their map from the others.
    pub leave_run_out: bool,
    /// Trainings, each from weights of its own; the one of the least validation error is kept.
    pub restarts: usize,
}

/// Keys of [`DescentConfig`] and the names that they had in the version before, which are still read.
pub const FORMER_KEYS: [(&str, &str); 2] = [
    ("queries", "truths_per_step"),
    ("places", "candidates_per_step"),
];

/// The error that is descended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ObjectiveKind {
    /// Sums over all 2^n outcomes (Thrun 1998, eq. 42); for few features.
    Exact,
    /// The probabilities themselves as evidence; for any number of features.
    MeanField,
}

/// What the errors of the truths are put together to, and so what a length of steps is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Scale {
    /// Their mean as a share of the prior error: one rate for any number of snapshots and any uncertainty.
    PriorShare,
    /// Their sum in metres.
    Sum,
}

/// How the length of a step changes in the course of a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Schedule {
    /// The same length at every step.
    Constant,
    /// It grows over the first 20 steps, then falls along a half cosine to 2 % at the last.
    Cosine,
}

/// Steps over which [`Schedule::Cosine`] grows.
const WARM_UP: usize = 20;
/// Share of the length that it keeps at its end.
const COSINE_END: f64 = 0.02;

impl DescentConfig {
    /// Length of step number `step`, counted from 0.
    pub fn rate_at(&self, step: usize) -> f64 {
        let share = match self.schedule {
            Schedule::Constant => 1.0,
            Schedule::Cosine => {
                let grown = ((step + 1) as f64 / WARM_UP as f64).min(1.0);
                let through = std::f64::consts::PI * step as f64 / self.steps as f64;
                grown * (0.5 + 0.5 * through.cos() + COSINE_END)
            }
        };
        self.learning_rate * share
    }
}

/// What training does to its snapshots, so that the features hold up on those it never saw. Truths of a step are moved,
/// and blinded; noise comes on every input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AugmentationConfig {
    /// Noise added to the normalised inputs in every step (standard deviation).
    pub input_noise: f64,
    /// Range scans are rendered anew as seen from a pose so far to either side, ahead and behind (standard deviation, m).
    pub shift_m: f64,
    /// And turned by so much (standard deviation, rad).
    pub turn_rad: f64,
    /// Share of a range scan's beams that come back without return, in blocks as a person in the way makes them.
    pub dropped_beams: f64,
    /// Most of a range scan's beams that people are in the way of, as a share; how many of each truth's is drawn. Stretches of
    /// 3° to 20° end before what they met. The validation part is judged as it is and once more with so many. Not said: 0.3 where the
    /// map is filled from rendered scans, which show nobody, else 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub people: Option<f64>,
}

/// People before rendered scans' real counterparts, where nobody says how many.
const PEOPLE: f64 = 0.3;

impl AugmentationConfig {
    /// Most of a scan's beams that people are in the way of, with or without a map that is filled from rendered scans.
    pub fn most_people(&self, rendered: bool) -> f64 {
        let usual = if rendered { PEOPLE } else { 0.0 };
        self.people.unwrap_or(usual)
    }
}

/// Which prior uncertainty a truth of a step has: the one stated, or one drawn for it. One set of features then serves
/// many uncertainties, and learns from each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PriorMix {
    /// Share of the truths that have the stated uncertainty. Not said: all of them where features are few (8 at most), else a fifth:
    /// many can serve every uncertainty, and learn more from all than from one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stated: Option<f64>,
    /// Share of the others that may be anywhere.
    pub global: f64,
    /// What is left has a window of a half-width drawn log-uniformly from here …
    pub narrowest_m: f64,
    /// … to here.
    pub widest_m: f64,
}

/// A recipe by name, as `--recipe` takes it: what holds where a configuration is silent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum NamedRecipe {
    /// What holds up best on runs that training never saw: [`Recipe::default`].
    #[default]
    Default,
    /// What Thrun (1998) did: [`Recipe::thrun1998`].
    Thrun1998,
}

impl NamedRecipe {
    /// All there are.
    pub const ALL: [Self; 2] = [Self::Default, Self::Thrun1998];

    /// Name as it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::Thrun1998 => "thrun1998",
        }
    }

    /// The recipe itself.
    pub fn recipe(self) -> Recipe {
        match self {
            Self::Default => Recipe::default(),
            Self::Thrun1998 => Recipe::thrun1998(),
        }
    }
}

impl std::str::FromStr for NamedRecipe {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|named| named.name() == text);
        named.ok_or_else(|| {
            let names = Self::ALL.map(|n| format!("`{}`", n.name())).join(" or ");
            Error::usage(format!("recipe `{text}`: expected {names}"))
        })
    }
}

/// Features that serve one uncertainty alone, at most.
const FEW_FEATURES: usize = 8;
/// Share of the stated uncertainty where features are more.
const STATED_OF_MANY: f64 = 0.2;

impl Recipe {
    /// Share of a step's truths that have the stated uncertainty.
    pub fn stated_share(&self) -> f64 {
        let usual = match (self.features, self.descent.objective) {
            (..=FEW_FEATURES, _) | (_, ObjectiveKind::Exact) => 1.0,
            _ => STATED_OF_MANY,
        };
        self.priors.stated.unwrap_or(usual)
    }
}

impl Default for PriorMix {
    fn default() -> Self {
        Self {
            stated: None,
            global: 0.4,
            narrowest_m: 1.0,
            widest_m: 12.0,
        }
    }
}

impl Default for AugmentationConfig {
    fn default() -> Self {
        Self {
            input_noise: 0.1,
            shift_m: 0.3,
            turn_rad: 0.2,
            dropped_beams: 0.0,
            people: None,
        }
    }
}

/// A rule for taking a step down a gradient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Optimiser {
    /// Adam (Kingma & Ba 2015), β = (0.9, 0.999).
    Adam,
    /// Gradient descent with momentum 0.9 (Thrun 1998, 5.1.4).
    Momentum,
    /// Conjugate gradients with a line search, on all snapshots. Thrun (1998, 5.1.4) used "a version of" them without
    /// saying which; this is Polak and Ribière's, which finds its way again where the error is far from a parabola.
    /// `weight_decay`, `gradient_limit` and input noise must be 0.
    ConjugateGradient,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            seed: 1,
            uncertainty: Uncertainty::Window {
                half_width_m: 2.0,
                half_turn_rad: Some(crate::belief::prior::DEFAULT_HALF_TURN_RAD),
            },
            features: 4,
            begin_with: BeginWith::default(),
            input: InputConfig::far(),
            network: NetConfig::default(),
            descent: DescentConfig::default(),
            augmentation: AugmentationConfig::default(),
            priors: PriorMix::default(),
            map: MapConfig::default(),
            split: SplitConfig::default(),
        }
    }
}

impl Default for DescentConfig {
    fn default() -> Self {
        Self {
            objective: ObjectiveKind::MeanField,
            optimiser: Optimiser::Adam,
            scale: Scale::PriorShare,
            learning_rate: 0.006,
            pseudo_pattern_steps: 1,
            sequential: false,
            schedule: Schedule::Cosine,
            weight_decay: 0.3,
            gradient_limit: 1.0,
            steps: 1500,
            truths_per_step: 192,
            candidates_per_step: 600,
            rendered_per_step: 600,
            validate_every: 50,
            patience: 750,
            checkpoint_every: 100,
            cross_entropy: 0.1,
            map_in_objective: true,
            leave_run_out: false,
            restarts: 1,
        }
    }
}
