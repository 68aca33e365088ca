//! A bank of filters, a set for every prior of 5.1.7, against each of its sets alone, from a start anywhere.
//!
//! The paper trains for six priors and localises with the features for ±2 m alone (5.2.4). A robot that has no idea where it is would do
//! better with those for no idea, and change them as it becomes sure: [`Bank`](crate::localiser::sensor_model::Bank).

use super::{
    GlobalRecord, Thrun1998Config,
    global::{Corridor, SPACING_M, at_its_word, localise_config, parts as parts_of},
    reductions::Fold,
    simulated,
};
use crate::{
    belief::Belief,
    error::Result,
    experiment::{
        bank_row::{self, bank},
        learned_row::{Rounded, learned_features},
        localisation::play,
        method::Method,
        methods::MethodContext,
        product::product,
        sequences::{drawn, motion},
    },
    localiser::{
        BayesLocaliser,
        sensor_model::{BankChoice, ChosenBy},
    },
    model::Model,
    seed::Seed,
};
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The banks, by the names of their approaches: one set a step, then more.
const BANKS: [(&str, BankChoice); 5] = [
    ("bank_by_error", choice(ChosenBy::LeastError, 1)),
    ("bank_of_2_by_error", choice(ChosenBy::LeastError, 2)),
    ("bank", choice(ChosenBy::MostInformation, 1)),
    ("bank_of_2", choice(ChosenBy::MostInformation, 2)),
    ("bank_of_3", choice(ChosenBy::MostInformation, 3)),
];

const fn choice(by: ChosenBy, sets: usize) -> BankChoice {
    BankChoice { by, sets }
}

/// Name of all sets at once: 24 features, each snapshot.
pub const ALL_SETS: &str = "all_sets";

/// Resamples of the runs.
const RESAMPLES: u64 = 2000;

/// What a bank is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct BankRecord {
    /// The data set.
    pub set: String,
    /// Runs, each of which is judged on in turn.
    pub runs: usize,
    /// Trials on all of them.
    pub trials: usize,
    /// Mean errors over distance: each set of four features alone, by the prior that it was trained for, then the bank, then all
    /// sets at once.
    pub approaches: Vec<GlobalRecord>,
    /// The set whose mean error is below 1 m first.
    pub best_alone: Option<String>,
    /// How far each bank, and all sets at once, must go beside that.
    pub shares: Vec<ShareOfBest>,
    /// Which sets the bank of one set a step used.
    pub used: Vec<UsedRow>,
}

/// How far a bank must go.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ShareOfBest {
    /// Its name among the approaches.
    pub approach: String,
    /// The distance at which its mean error passes 1 m, between the rows of the curve on a straight line, as a share of what the best
    /// set alone needs.
    pub share: Option<f64>,
    /// Its 95 % interval over the runs: in each resample the best set is chosen anew. None where less than nine in ten have one.
    pub ci95: Option<[f64; 2]>,
}

/// Which sets were used after some way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct UsedRow {
    /// Metres travelled since the start.
    pub distance_m: f64,
    /// Share of the trials that used each set, by the prior that it was trained for.
    pub share: BTreeMap<String, f64>,
}

/// Tries a bank in a data set.
pub(super) fn tried(
    config: &Thrun1998Config,
    set: &str,
    next: &mut dyn FnMut(&str),
) -> Result<BankRecord> {
    let config = &Thrun1998Config {
        runs: config.bank_runs,
        ..config.clone()
    };
    let recording = simulated(config, "worlds/thrun1998.toml", set)?;
    let mut corridor = Corridor::new(set);
    let mut used: BTreeMap<usize, BTreeMap<String, usize>> = BTreeMap::new();
    for tested in 0..config.runs {
        next(&format!("a bank: run {} of {}", tested + 1, config.runs));
        let fold = Fold::bank(config, &recording, set, tested)?;
        let models: Vec<&Model> = fold.models.iter().collect();
        let (parts, localise) = (parts_of(&fold), localise_config(config));
        let context = MethodContext::new(&models, &parts, &localise)?;
        let alone = |model: &&Model| {
            let name = model.header.prior.to_string();
            let method = learned_features(&context, model, Rounded::No, &name, &name)?;
            Ok(at_its_word(method))
        };
        let mut methods = models.iter().map(alone).collect::<Result<Vec<_>>>()?;
        let run = recording.run_numbers(&fold.split.train);
        let of_bank = (&models[..], &run[..]);
        let sets: Vec<&Method> = methods.iter().collect();
        let banks =
            BANKS.map(|(name, choice)| bank(&context, of_bank, &sets, choice, (name, name)));
        let banks = banks.into_iter().collect::<Result<Vec<_>>>()?;
        let all_sets = product(&context, ALL_SETS, ALL_SETS, &sets)?;
        count_used(&context, of_bank, &sets, &mut used)?;
        let together = banks.into_iter().flatten().chain(all_sets);
        methods.extend(together.map(at_its_word));
        corridor.take(&play(&context, methods, &mut |_| ())?)?;
    }
    Ok(BankRecord::of(config, set, &corridor, used))
}

/// Plays the trials once more and counts the sets that the bank uses.
fn count_used<'a>(
    context: &MethodContext<'a>,
    of_bank: (&[&Model], &[usize]),
    sets: &[&Method<'a>],
    used: &mut BTreeMap<usize, BTreeMap<String, usize>>,
) -> Result<()> {
    let Some(bank) = bank_row::on_run(context, of_bank, sets, BANKS[2].1)? else {
        return Ok(());
    };
    let seed = Seed(context.seed().0);
    for (number, trial) in drawn(context)?.iter().enumerate() {
        let stream = seed.numbered_stream("sets that a bank uses", number as u64);
        let lost = Belief::uniform(context.grid.places())?;
        let motion = motion(sets[0], context);
        let mut robot = BayesLocaliser::new(&context.grid, motion, lost, Some(&bank), stream)?;
        for (step, &k) in trial.snapshots.iter().enumerate() {
            let observation = context.parts.run.observation(k);
            for number in bank.chosen(&robot.predicted(&observation)?)? {
                let name = bank.sets()[number].name.clone();
                *used.entry(step).or_default().entry(name).or_default() += 1;
            }
            robot.observe(k, &observation)?;
        }
    }
    Ok(())
}

impl BankRecord {
    fn of(
        config: &Thrun1998Config,
        set: &str,
        corridor: &Corridor,
        used: BTreeMap<usize, BTreeMap<String, usize>>,
    ) -> Self {
        let all_runs: Vec<usize> = (0..corridor.runs()).collect();
        let below = corridor.passes_1m_at_m(&all_runs);
        let used = used.into_iter().map(|(step, sets)| {
            let all: usize = sets.values().sum();
            let share = |(name, times)| (name, times as f64 / all as f64);
            UsedRow {
                distance_m: step as f64 * SPACING_M,
                share: sets.into_iter().map(share).collect(),
            }
        });
        Self {
            set: set.into(),
            runs: config.runs,
            trials: config.runs * config.trials,
            best_alone: best_alone(&below).map(|(name, _)| name.into()),
            shares: shares(corridor, Seed(config.seed)),
            approaches: corridor.records(),
            used: used.collect(),
        }
    }
}

/// The name of every approach, and where its mean error passes 1 m.
type Below = [(String, Option<f64>)];

/// Is it one set alone?
fn is_alone(approach: &str) -> bool {
    approach != ALL_SETS && BANKS.iter().all(|(name, _)| *name != approach)
}

/// The set alone that is below 1 m first.
fn best_alone(below: &Below) -> Option<(&str, f64)> {
    let alone = below.iter().filter(|(name, _)| is_alone(name));
    let found = alone.filter_map(|(name, at_m)| Some((&name[..], (*at_m)?)));
    found.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Every bank's way as a share of the best set's; none where either never passes 1 m.
fn shares_of_best(below: &Below) -> Vec<(String, Option<f64>)> {
    let best = best_alone(below).map(|(_, at_m)| at_m);
    let banks = below.iter().filter(|(name, _)| !is_alone(name));
    let share = |at_m: &Option<f64>| Some((*at_m)? / best?);
    banks
        .map(|(name, at_m)| (name.clone(), share(at_m)))
        .collect()
}

/// The shares with their intervals, by resamples of the runs.
fn shares(corridor: &Corridor, seed: Seed) -> Vec<ShareOfBest> {
    let runs = corridor.runs();
    let all_runs: Vec<usize> = (0..runs).collect();
    let resampled: Vec<Vec<(String, Option<f64>)>> = (0..RESAMPLES)
        .map(|resample| {
            let mut stream = seed.numbered_stream("runs of a bank", resample);
            let drawn: Vec<usize> = (0..runs).map(|_| stream.random_range(0..runs)).collect();
            shares_of_best(&corridor.passes_1m_at_m(&drawn))
        })
        .collect();
    let with_interval = |(number, (approach, share)): (usize, (String, Option<f64>))| {
        let of_approach = resampled.iter().filter_map(|shares| shares.get(number)?.1);
        let mut sorted: Vec<f64> = of_approach.collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
        let enough = sorted.len() as u64 >= RESAMPLES / 10 * 9;
        ShareOfBest {
            approach,
            share,
            ci95: enough.then(|| [at(0.025), at(0.975)]),
        }
    };
    let shares = shares_of_best(&corridor.passes_1m_at_m(&all_runs));
    shares.into_iter().enumerate().map(with_interval).collect()
}
