//! What is trained how, as data: the resolved form of a training configuration.

use crate::{
    belief::{MapConfig, Uncertainty},
    detector::{input::InputConfig, net::NetConfig},
    error::{Error, Result},
    learning::{mean_field, objective},
    recording::split::SplitConfig,
};
use serde::{Deserialize, Serialize};

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

/// How the weights descend E_posterior.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DescentConfig {
    /// What is descended.
    pub objective: Objective,
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
    pub queries: usize,
    /// Candidate places of a step, drawn anew for each in short stretches; 0: all training snapshots.
    pub places: usize,
    /// Steps between two looks at the validation part.
    pub validate_every: usize,
    /// Stop after this many steps without a better validation error.
    pub patience: usize,
    /// Steps between two checkpoints.
    pub checkpoint_every: usize,
    /// Smooth the features into a map inside the objective, as localisation will.
    pub map_in_objective: bool,
    /// Draw the truths of a step from one run, and the candidates and their map from the others.
    pub leave_run_out: bool,
    /// Trainings, each from weights of its own; the one of the least validation error is kept.
    pub restarts: usize,
}

/// The error that is descended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Objective {
    /// Sums over all 2^n outcomes (Thrun 1998, eq. 42); for few features.
    Exact,
    /// The probabilities themselves as evidence; for any number of features.
    MeanField,
}

/// What the errors of the truths are put together to, and so what a length of steps is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scale {
    /// Their mean as a share of the prior error: one rate for any number of snapshots and any uncertainty.
    PriorShare,
    /// Their sum in metres.
    Sum,
}

/// How the length of a step changes in the course of a training.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Schedule {
    /// It doesn't.
    Constant,
    /// Grows over the first steps, then falls along a half cosine to nearly nothing at the last.
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
    /// Share of a range scan's beams that come back without return, in blocks as somebody in the way makes them.
    pub dropped_beams: f64,
}

/// Which prior uncertainty a truth of a step has: the one stated, or one drawn for it. One set of features then serves
/// many uncertainties, and learns from each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PriorMix {
    /// Share of the truths that have the stated uncertainty.
    pub stated: f64,
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
pub enum Named {
    /// What holds up best on runs that training never saw: [`Recipe::default`].
    #[default]
    Default,
    /// What Thrun (1998) did: [`Recipe::thrun1998`].
    Thrun1998,
}

impl Named {
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

impl std::str::FromStr for Named {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let named = Self::ALL.into_iter().find(|named| named.name() == text);
        named.ok_or_else(|| {
            let names = Self::ALL.map(|n| format!("`{}`", n.name())).join(" or ");
            Error::usage(format!("recipe `{text}`: expected {names}"))
        })
    }
}

impl Default for PriorMix {
    fn default() -> Self {
        Self {
            stated: 0.0,
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
        }
    }
}

/// A rule for taking a step down a gradient.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Optimiser {
    /// Adam (Kingma & Ba 2015), β = (0.9, 0.999).
    Adam,
    /// Gradient descent with momentum 0.9 (Thrun 1998, 5.1.4).
    Momentum,
    /// Conjugate gradients (Polak and Ribière's rule) with a line search, on all snapshots.
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
            input: InputConfig::default(),
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
            objective: Objective::MeanField,
            optimiser: Optimiser::Adam,
            scale: Scale::PriorShare,
            learning_rate: 0.003,
            pseudo_pattern_steps: 1,
            sequential: false,
            schedule: Schedule::Cosine,
            weight_decay: 0.3,
            gradient_limit: 1.0,
            steps: 4000,
            queries: 192,
            places: 1500,
            validate_every: 50,
            patience: 4000,
            checkpoint_every: 100,
            map_in_objective: true,
            leave_run_out: false,
            restarts: 1,
        }
    }
}

impl Recipe {
    /// What `--recipe thrun1998` stands for: the networks and the descent of Thrun (1998), 5.1.4 and Table 2. Six hidden
    /// sigmoid units a network, nothing shared; the printed objective (eq. 42) over all snapshots with the stated
    /// uncertainty, no map in it; gradient descent of rate 1e-4 with momentum 0.9 and nothing else done to weights or
    /// inputs.
    pub fn thrun1998() -> Self {
        Self {
            network: NetConfig::thrun1998(),
            descent: DescentConfig {
                objective: Objective::Exact,
                optimiser: Optimiser::Momentum,
                scale: Scale::Sum,
                learning_rate: 1e-4,
                pseudo_pattern_steps: 100,
                sequential: false,
                schedule: Schedule::Constant,
                weight_decay: 0.0,
                gradient_limit: 0.0,
                steps: 10_000,
                queries: 0,
                places: 0,
                patience: 10_000,
                map_in_objective: false,
                ..DescentConfig::default()
            },
            augmentation: AugmentationConfig {
                input_noise: 0.0,
                shift_m: 0.0,
                turn_rad: 0.0,
                dropped_beams: 0.0,
            },
            priors: PriorMix {
                stated: 1.0,
                ..PriorMix::default()
            },
            ..Self::default()
        }
    }

    /// Checks everything once; what passes can be trained.
    ///
    /// # Errors
    /// Where a value makes no sense; the message names the key and what was expected.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: &dyn std::fmt::Display, expected: &str| {
            Err(Error::usage(format!(
                "{key} = {value}: expected {expected}"
            )))
        };
        let d = &self.descent;
        let (most, why) = match d.objective {
            Objective::Exact => (objective::MOST_FEATURES, "2^n outcomes are summed exactly"),
            Objective::MeanField => (mean_field::MOST_FEATURES, "the mean-field objective"),
        };
        if self.features == 0 || self.features > most {
            return wrong("features", &self.features, &format!("1 to {most} ({why})"));
        }
        if !(d.learning_rate.is_finite() && d.learning_rate > 0.0) {
            return wrong(
                "descent.learning_rate",
                &d.learning_rate,
                "a positive number",
            );
        }
        if !(0.0..1.0).contains(&(d.weight_decay * d.learning_rate)) {
            return wrong(
                "descent.weight_decay",
                &d.weight_decay,
                "0 or more, and less than 1/learning_rate",
            );
        }
        let a = &self.augmentation;
        let lengths = [
            ("augmentation.input_noise", a.input_noise),
            ("augmentation.shift_m", a.shift_m),
            ("augmentation.turn_rad", a.turn_rad),
            ("descent.gradient_limit", d.gradient_limit),
        ];
        let fits = |length: &f64| length.is_finite() && *length >= 0.0;
        if let Some((key, value)) = lengths.into_iter().find(|(_, value)| !fits(value)) {
            return wrong(key, &value, "0 or more");
        }
        let p = &self.priors;
        let shares = [
            ("augmentation.dropped_beams", a.dropped_beams),
            ("priors.stated", p.stated),
            ("priors.global", p.global),
        ];
        let fits = |share: &f64| (0.0..=1.0).contains(share);
        if let Some((key, value)) = shares.into_iter().find(|(_, value)| !fits(value)) {
            return wrong(key, &value, "0 to 1");
        }
        if !(p.narrowest_m > 0.0 && p.narrowest_m <= p.widest_m && p.widest_m.is_finite()) {
            return wrong(
                "priors.narrowest_m",
                &p.narrowest_m,
                "a positive number, no more than priors.widest_m",
            );
        }
        if d.objective == Objective::Exact && p.stated < 1.0 {
            return wrong(
                "priors.stated",
                &p.stated,
                "1 with the exact objective, which knows one prior for all truths",
            );
        }
        if d.queries == 0
            && (d.places > 0
                || d.leave_run_out
                || a.shift_m > 0.0
                || a.turn_rad > 0.0
                || a.dropped_beams > 0.0)
        {
            return wrong(
                "descent.queries",
                &d.queries,
                "at least 1 where truths are moved or blinded or candidates drawn (descent.places, descent.leave_run_out, \
                 augmentation.shift_m, .turn_rad, .dropped_beams)",
            );
        }
        let counts = [
            ("descent.steps", d.steps),
            ("descent.pseudo_pattern_steps", d.pseudo_pattern_steps),
            ("descent.validate_every", d.validate_every),
            ("descent.patience", d.patience),
            ("descent.checkpoint_every", d.checkpoint_every),
            ("descent.restarts", d.restarts),
        ];
        if let Some((key, value)) = counts.into_iter().find(|(_, value)| *value == 0) {
            return wrong(key, &value, "at least 1");
        }
        if d.scale == Scale::Sum && d.objective != Objective::Exact {
            return wrong(
                "descent.scale",
                &"sum",
                "prior_share, for the sum is one of the exact objective",
            );
        }
        if d.sequential {
            if d.objective != Objective::Exact || !self.network.trunk.is_empty() {
                return wrong(
                    "descent.sequential",
                    &true,
                    "descent.objective = \"exact\" and no network.trunk: features that learn one after another share nothing",
                );
            }
            if d.steps < self.features {
                return wrong(
                    "descent.steps",
                    &d.steps,
                    &format!(
                        "at least one for each of {} features in sequence",
                        self.features
                    ),
                );
            }
        }
        if d.optimiser == Optimiser::ConjugateGradient {
            let forbidden = [
                ("descent.weight_decay", d.weight_decay),
                ("descent.gradient_limit", d.gradient_limit),
                ("descent.queries", d.queries as f64),
                ("augmentation.input_noise", a.input_noise),
            ];
            if let Some((key, value)) = forbidden.into_iter().find(|(_, value)| *value != 0.0) {
                return wrong(
                    key,
                    &value,
                    "0 with conjugate_gradient, which needs the same error at every step",
                );
            }
        }
        let unmodelled = self.map.unmodelled_probability;
        if !(0.0..1.0).contains(&unmodelled) {
            return wrong(
                "map.unmodelled_probability",
                &unmodelled,
                "0 or more, below 1",
            );
        }
        self.input.check()?;
        self.network.check()?;
        self.split.check()
    }
}
