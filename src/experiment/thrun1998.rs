//! The experiments of Thrun, *Bayesian Landmark Learning for Mobile Robot Localization* (1998; T98), 5.2 and 5.3, in its simulated
//! corridor: what one snapshot is worth for doors, ceiling lights and learned features (Figs. 3 and 4, Table 3), how soon a robot is
//! found (Figs. 5 and 6), how many readings that takes (5.2.4), and what the networks answer where (Figs. 7 and 8).
//!
//! Each data set is partitioned by run, three quarters to learn from and one to be judged on, in rotation (5.1.2). Networks and
//! objective are the paper's; they descend by conjugate gradients (5.1.4), which find in a hundred steps what momentum finds in
//! ten thousand, and nothing stops them (note 3).

mod bank;
mod choosing;
mod global;
mod harder;
mod readings;
mod reductions;
mod set_record;
#[cfg(test)]
mod tests;

pub use bank::{BankRecord, ShareOfBest, UsedRow};
pub use choosing::ChoiceRecord;
pub use global::{BeliefRecord, GlobalRecord, GlobalRow, Moment};
pub use harder::HarderRecord;
pub use readings::ReadingsRecord;
pub use set_record::{OutputRecord, ReductionRow, SetRecord};

use super::{printed::THRUN_1998_SETS, reproduce::Paper};
use crate::{
    belief::{Uncertainty, prior::DEFAULT_HALF_TURN_RAD},
    error::Result,
    learning::{Recipe, recipe::Optimiser},
    recording::{
        Recording,
        split::{SplitConfig, Unit},
    },
    seed::Seed,
    toml_file::out_of_range,
    world::{
        Building,
        simulation::{Choice, simulate},
    },
};
use global::Corridor;
use reductions::Fold;
use serde::{Deserialize, Serialize};

/// Length of the corridor, in metres (T98 5.1.1).
pub const CORRIDOR_M: f64 = 89.0;

/// Most features (T98 Table 3).
const MOST_FEATURES: usize = 4;

/// What is run, and how much of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Thrun1998Config {
    /// The one seed of the run: worlds, weights, starts, sampled features.
    pub seed: u64,
    /// Data sets, of `d1`, `d2` and `d3`.
    pub sets: Vec<String>,
    /// Runs of each set, each of which is judged on in turn.
    pub runs: usize,
    /// Steps of conjugate gradients.
    pub steps: usize,
    /// Localisation trials on each run that is judged on.
    pub trials: usize,
    /// Whether the corridor of twice the length is tried, too.
    pub doubled: bool,
    /// Whether guesses are tried at why the corridor is easier than the paper's.
    pub harder: bool,
    /// Runs of the first data set in which a bank of filters is tried, each judged on in turn; 0: it is not tried.
    pub bank_runs: usize,
    /// Worlds in which is tried what a robot should do so as to find out where it is; 0: it is not tried.
    pub choice_seeds: usize,
}

impl Default for Thrun1998Config {
    fn default() -> Self {
        Self {
            seed: 1,
            sets: THRUN_1998_SETS.map(String::from).to_vec(),
            runs: 4,
            steps: 100,
            trials: 35,
            doubled: true,
            harder: true,
            bank_runs: 4,
            choice_seeds: 30,
        }
    }
}

impl Thrun1998Config {
    /// One data set, two runs, few steps and trials: does it work? The figures mean little.
    pub fn toy(self) -> Self {
        Self {
            sets: vec!["d1".into()],
            runs: 2,
            steps: 15,
            trials: 8,
            doubled: false,
            harder: false,
            bank_runs: 2,
            choice_seeds: 2,
            ..self
        }
    }

    /// # Errors
    /// A usage error that names the key at fault.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, expected: &str| Err(out_of_range("thrun1998", self, key, expected));
        if self.sets.is_empty() {
            return wrong("sets", "one or more of `d1`, `d2` and `d3`");
        }
        let twice = |(k, set): (usize, &String)| self.sets[..k].contains(set);
        if !self
            .sets
            .iter()
            .all(|set| THRUN_1998_SETS.contains(&set.as_str()))
            || self.sets.iter().enumerate().any(twice)
        {
            return wrong(
                "sets",
                "each of `d1`, `d2` and `d3` at most once, and no other",
            );
        }
        if self.runs < 2 {
            return wrong(
                "runs",
                "2 or more: one to be judged on, the others to learn from",
            );
        }
        if self.bank_runs == 1 {
            return wrong("bank_runs", "0, or 2 or more");
        }
        for (key, value) in [("steps", self.steps), ("trials", self.trials)] {
            if value == 0 {
                return wrong(key, "1 or more");
            }
        }
        Ok(())
    }

    /// The paper's networks and objective for a prior, learning from all runs but `tested`.
    fn recipe(&self, features: usize, uncertainty: Uncertainty, tested: usize) -> Recipe {
        let mut recipe = Recipe {
            seed: self.seed,
            features,
            uncertainty,
            split: SplitConfig {
                unit: Unit::Runs,
                folds: self.runs,
                test_fold: Some(tested),
                validation_every: 0,
            },
            ..Recipe::thrun1998()
        };
        recipe.descent.optimiser = Optimiser::ConjugateGradient;
        recipe.descent.pseudo_pattern_steps = 1;
        recipe.descent.steps = self.steps;
        recipe
    }
}

/// All that came of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Thrun1998Record {
    /// Of the crate.
    pub version: String,
    /// What was run.
    pub config: Thrun1998Config,
    /// One a data set.
    pub sets: Vec<SetRecord>,
    /// Errors over distance, from a start anywhere: of every data set the landmarks chosen by people, then learned features.
    pub global: Vec<GlobalRecord>,
    /// Beliefs at the first steps of one trial (Fig. 5).
    pub belief: Option<BeliefRecord>,
    /// Readings for one bit of information, in the first data set.
    pub readings: Option<ReadingsRecord>,
    /// The first data set in corridors that are harder in some way.
    pub harder: Vec<HarderRecord>,
    /// A bank of filters in the first data set.
    #[serde(default)]
    pub bank: Option<BankRecord>,
    /// What a robot should do so as to find out where it is.
    #[serde(default)]
    pub choices: Vec<ChoiceRecord>,
}

/// The priors of T98 5.1.7: ±1, 2, 5, 10 and 50 m, and no idea at all (±89 m).
pub fn priors() -> Vec<Uncertainty> {
    Uncertainty::of_a_bank().to_vec()
}

/// The prior of T98 Table 3 and Fig. 4: ±2 m.
pub fn local() -> Uncertainty {
    window(2.0)
}

/// A prior as T98 calls it: `±2 m`, and `±89 m` for no idea at all.
pub fn words(prior: Uncertainty) -> String {
    match prior {
        Uncertainty::Global => format!("±{CORRIDOR_M} m"),
        Uncertainty::Window { half_width_m, .. } => format!("±{half_width_m} m"),
    }
}

fn window(half_width_m: f64) -> Uncertainty {
    Uncertainty::Window {
        half_width_m,
        half_turn_rad: Some(DEFAULT_HALF_TURN_RAD),
    }
}

/// Runs all of it. `progress` is told how many parts are done, of how many, and what comes next.
///
/// # Errors
/// Where the configuration makes no sense, or a training or trial fails.
pub fn run(
    config: &Thrun1998Config,
    progress: &mut dyn FnMut(usize, usize, &str),
) -> Result<Thrun1998Record> {
    config.check()?;
    let guesses = if config.harder { harder::COUNT } else { 0 };
    let parts = config.sets.len() * (config.runs + 1)
        + usize::from(config.doubled)
        + guesses
        + config.bank_runs
        + config.choice_seeds;
    let mut done = 0;
    let mut next = |what: &str| {
        progress(done, parts, what);
        done += 1;
    };
    let mut record = Thrun1998Record {
        version: env!("CARGO_PKG_VERSION").to_string(),
        config: config.clone(),
        sets: Vec::new(),
        global: Vec::new(),
        belief: None,
        readings: None,
        harder: Vec::new(),
        bank: None,
        choices: Vec::new(),
    };
    for (number, set) in config.sets.iter().enumerate() {
        next(&format!("simulating {set}"));
        let recording = simulated(config, "worlds/thrun1998.toml", set)?;
        let mut folds = Vec::new();
        let mut corridor = Corridor::new(set);
        for tested in 0..config.runs {
            next(&format!(
                "{set}: run {} of {} judged on",
                tested + 1,
                config.runs
            ));
            let fold = Fold::new(config, &recording, set, tested)?;
            corridor.add(config, &fold)?;
            if number == 0 && tested == 0 {
                record.belief = global::belief(config, &fold)?;
            }
            folds.push(fold.judged()?);
        }
        let set = SetRecord::of(set, folds)?;
        if number == 0 {
            let prior_error_m = set.prior_error_m;
            record.readings = readings::readings(&corridor, prior_error_m);
        }
        record.sets.push(set);
        record.global.extend(corridor.records());
    }
    if let (true, Some(readings), Some(set)) =
        (config.doubled, &mut record.readings, config.sets.first())
    {
        next("the corridor of twice the length");
        let recording = simulated(config, "worlds/thrun1998-twice.toml", set)?;
        let mut corridor = Corridor::new(set);
        for tested in 0..config.runs {
            let fold = Fold::local(config, &recording, set, tested)?;
            corridor.add(config, &fold)?;
        }
        readings.found_in_doubled = corridor.readings();
    }
    for number in 0..guesses {
        next(&format!("a harder corridor: {} of {guesses}", number + 1));
        record
            .harder
            .extend(harder::harder(config, &config.sets[0], number)?);
    }
    if config.bank_runs > 0 {
        record.bank = Some(bank::tried(config, &config.sets[0], &mut next)?);
    }
    record.choices = choosing::tried(config, &mut next)?;
    Ok(record)
}

/// A data set of one of the paper's worlds.
fn simulated(config: &Thrun1998Config, world: &str, set: &str) -> Result<Recording> {
    let building = Building::from_text(Paper::Thrun1998.file(world)?)?;
    let choice = Choice {
        set: Some(set.into()),
        runs: Some(config.runs),
    };
    simulate(&building, Seed(config.seed), &choice)
}
