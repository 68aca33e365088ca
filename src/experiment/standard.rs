//! The standard experiment: trials of a fixed distance, played back from everywhere on the route, and what the answers
//! tell about the place after every tenth of a metre.
//!
//! D98 (Duckett & Nehmzow 1998), 6.5: "we used trials of distance 20 m, starting at 5 s intervals along the recorded route
//! data. … After running a localisation system for a large number of trials, the resulting data were split into 201
//! separate contingency tables, one for distance 0 m plus one for each 0.10 m travelled by the robot. The performance
//! measures H(L|R) and U(L|R) were then calculated for each of the tables."

mod config;
mod replay;

pub(super) use config::MAX_DRAWINGS;
pub use config::StandardConfig;
pub use replay::{Trial, trials};

use super::protocol::Protocol;
use crate::{
    error::{Error, Result},
    localiser::{Estimate, Localiser, Probable, Step, TrialRunner},
    score::{
        AnswerCount, Binning, Contingency, Effort, Entropies, Interval, Judgement, PosteriorScore,
        corrected_coefficient,
    },
    seed::Seed,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::{collections::HashSet, fmt};

/// What the answers tell at one distance into the trials.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AtDistance {
    /// Metres travelled since the trial's start.
    pub distance_m: f64,
    /// H(L), nats.
    pub entropy_of_location: f64,
    /// H(L|R), nats.
    pub entropy_of_location_given_response: f64,
    /// U(L|R); none where all trials are at one location.
    pub uncertainty_coefficient: Option<f64>,
    /// The same corrected for chance.
    pub uncertainty_coefficient_corrected: Option<f64>,
}

/// What the standard experiment says of a localiser.
///
/// Means are over the tables that have the figure. Answers counted as responses of their own: "outside", a place in
/// none of the bins, and no answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StandardRecord {
    /// Trials played.
    pub trials: usize,
    /// Location bins that the route goes through.
    pub bins: usize,
    /// Laps, runs or stretches that the trials start in: what the interval resamples.
    pub units: usize,
    /// Different responses given, over all tables.
    pub responses: usize,
    /// Share of the answers that were none.
    pub unanswered: f64,
    /// Share of the answers that were outside of all bins.
    pub outside: f64,
    /// Share of the localiser's places that a snapshot of the testing part passes for, on average; none where it does not sift
    /// them ([`Localiser::candidates`]).
    #[serde(default)]
    pub candidates: Option<f64>,
    /// Mean H(L), nats.
    pub entropy_of_location: f64,
    /// A row a table.
    pub by_distance: Vec<AtDistance>,
    /// Mean U(L|R) (D98 Table 2).
    pub mean_uncertainty_coefficient: f64,
    /// Mean of the corrected coefficient.
    pub mean_uncertainty_coefficient_corrected: Option<f64>,
    /// Mean H(L|R), nats (D98 Table 2).
    pub mean_entropy_of_location_given_response: f64,
    /// The first distance at which U(L|R) is [`StandardConfig::coefficient_to_reach`] or more, metres (D98 Table 2); none
    /// where it never is.
    pub distance_at_coefficient_m: Option<f64>,
    /// The first distance from which it is so to the end, metres: the paper doesn't say which of the two it prints.
    pub distance_from_coefficient_on_m: Option<f64>,
    /// Mean U from the posterior; none where the localiser has no posterior.
    pub mean_posterior_coefficient: Option<f64>,
    /// The last table.
    pub at_end: Judgement,
    /// Its cells: how often each answer was given at each bin.
    #[serde(default)]
    pub answers_at_end: Vec<AnswerCount>,
    /// 95 % interval of the mean corrected coefficient, over units.
    pub ci95_of_mean: Option<[f64; 2]>,
    /// What a caption must say of it.
    pub notes: Vec<String>,
}

/// What is counted as the response R.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Answer {
    /// A class, place or pattern of the localiser's own.
    Class(usize),
    /// A place in the plane, "coarse-coded into bins, using the same dotted grid as shown for the location binning" (7.1).
    Bin(usize),
    /// "Whenever the position estimate occupied one of the bins not occupied by the corrected odometer trace, the response
    /// was classified as being `outside` the environment" (7.1).
    Outside,
    None,
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Class(number) | Self::Bin(number) => write!(f, "{number}"),
            Self::Outside => write!(f, "outside"),
            Self::None => write!(f, "none"),
        }
    }
}

/// What is counted of one snapshot of a trial.
#[derive(Debug, Clone, Copy)]
struct ScoredStep {
    /// The true location L.
    location: usize,
    answer: Answer,
    /// How probable the localiser holds the true location, where it has a posterior.
    probability: Option<f64>,
}

/// Plays the trials of a protocol to a localiser, and judges its answers by these bins, which must be the protocol's own.
///
/// ```
/// use ballmark::{experiment::{protocol::{Mapping, Protocol, ProtocolConfig}, standard::{self, StandardConfig}},
///     localiser::{self, Kind}, seed::Seed, world::corridor};
/// let config = corridor::CorridorConfig { runs: 2, spacing_m: 0.5, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let config = ProtocolConfig { mapping: Mapping::FirstRun, ..Default::default() };
/// let protocol = Protocol::new(&recording, &config)?;
///
/// let dead_reckoning = Kind::DeadReckoning.default_config();
/// let learned = localiser::learn(&dead_reckoning, &protocol.recording, &protocol.mapping, Seed(1))?;
/// let config = StandardConfig { every_s: 1.0, ..Default::default() };
/// let binning = protocol.binning(config.bin_m)?;
/// let record = standard::play(&protocol, &binning, learned.as_localiser(), &config, Seed(1))?;
/// assert_eq!(record.by_distance.len(), 201);
/// assert_eq!(record.by_distance[0].uncertainty_coefficient, Some(1.0)); // it knows the start
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// A usage error where a constant makes no sense; a work error where no trial fits the testing part, where all trials
/// stay at one location, or where the localiser fails.
pub fn play(
    protocol: &Protocol,
    binning: &Binning,
    localiser: &dyn Localiser,
    config: &StandardConfig,
    seed: Seed,
) -> Result<StandardRecord> {
    config.check()?;
    let (trials, mut notes) = trials(protocol, config)?;
    let player = localiser.prepare(&protocol.recording, &protocol.testing)?;
    let scored: Vec<Vec<ScoredStep>> = trials
        .par_iter()
        .enumerate()
        .map(|(number, trial)| {
            let steps = replay(protocol, localiser, &*player, trial, number, seed)?;
            scored(protocol, binning, trial, &steps, localiser.is_blind())
        })
        .collect::<Result<_>>()?;
    let at = |table: usize| {
        let each = trials.iter().zip(&scored);
        each.map(move |(trial, scored)| scored[trial.step_at[table]])
    };
    let tables: Vec<Contingency<usize, Answer>> = (0..config.tables())
        .map(|number| {
            let mut table = Contingency::new();
            at(number).for_each(|scored| table.record(scored.location, scored.answer));
            table
        })
        .collect();
    let mut soft = Vec::new();
    for number in 0..config.tables() {
        let mut score = PosteriorScore::new();
        for scored in at(number) {
            score.record(scored.location, scored.probability)?;
        }
        soft.push(score);
    }
    let has_posterior = soft.iter().any(|score| score.answered() > 0);
    let soft = mean(soft.iter().filter_map(PosteriorScore::coefficient));
    let counted = || (0..tables.len()).flat_map(at).map(|scored| scored.answer);
    let share = |answer: Answer| {
        let same = counted().filter(|&given| given == answer).count();
        same as f64 / (trials.len() * tables.len()) as f64
    };
    let by_distance: Vec<AtDistance> = tables
        .par_iter()
        .enumerate()
        .map(|(at, table)| at_distance(config.distance_m(at), table))
        .collect();
    let Some(mean_uncertainty_coefficient) = mean(
        by_distance
            .iter()
            .filter_map(|row| row.uncertainty_coefficient),
    ) else {
        return Err(Error::work(format!(
            "standard: {} trials, all in one location bin at every distance; expected more trials, or smaller bins than \
             {} m",
            trials.len(),
            config.bin_m
        )));
    };
    let unit_of: Vec<usize> = trials.iter().map(|trial| trial.unit).collect();
    let units = unit_of.iter().collect::<HashSet<_>>().len();
    let of_mean = Interval::of_mean(&tables, &unit_of, config.resamples, seed);
    let reaches = |row: &AtDistance| {
        row.uncertainty_coefficient
            .is_some_and(|u| u >= config.coefficient_to_reach)
    };
    let first = by_distance.iter().position(reaches);
    let below = by_distance.iter().rposition(|row| !reaches(row));
    let from = below.map_or(0, |last| last + 1);
    if units < 2 {
        notes.push("all trials start in one lap, run or stretch: no interval".to_string());
    }
    let mut responses: Vec<Answer> = counted().collect();
    responses.sort_unstable();
    responses.dedup();
    let effort = Effort {
        permutations: config.permutations,
        resamples: config.resamples,
    };
    Ok(StandardRecord {
        trials: trials.len(),
        bins: binning.bins(),
        units,
        responses: responses.len(),
        unanswered: share(Answer::None),
        outside: share(Answer::Outside),
        candidates: localiser.candidates(&protocol.recording, &protocol.testing),
        entropy_of_location: mean(by_distance.iter().map(|row| row.entropy_of_location))
            .unwrap_or_default(),
        mean_uncertainty_coefficient,
        mean_uncertainty_coefficient_corrected: mean(
            by_distance
                .iter()
                .filter_map(|row| row.uncertainty_coefficient_corrected),
        ),
        mean_entropy_of_location_given_response: mean(
            by_distance
                .iter()
                .map(|row| row.entropy_of_location_given_response),
        )
        .unwrap_or_default(),
        distance_at_coefficient_m: first.map(|at| config.distance_m(at)),
        distance_from_coefficient_on_m: (from < tables.len()).then(|| config.distance_m(from)),
        mean_posterior_coefficient: soft.filter(|_| has_posterior),
        at_end: Judgement::of(&tables[tables.len() - 1], &unit_of, effort, seed),
        answers_at_end: AnswerCount::all(
            at(tables.len() - 1).map(|scored| (scored.location, scored.answer.to_string())),
        ),
        ci95_of_mean: of_mean.map(|interval| [interval.low, interval.high]),
        by_distance,
        notes,
    })
}

/// Plays one trial: the same for any number of threads, as its stream is its own.
fn replay(
    protocol: &Protocol,
    localiser: &dyn Localiser,
    player: &dyn TrialRunner,
    trial: &Trial,
    number: usize,
    seed: Seed,
) -> Result<Vec<Step>> {
    let start = protocol.recording.poses()[trial.snapshots[0]];
    let needs_it = localiser.asks_for_the_start() && !localiser.can_start_anywhere();
    let start = needs_it.then_some(start);
    let mut stream = seed.numbered_stream("standard trial", number as u64);
    let steps = player.play(&trial.snapshots, start, &mut stream)?;
    match steps.len() == trial.snapshots.len() {
        true => Ok(steps),
        false => Err(Error::work(format!(
            "{}: {} answers to a trial of {} snapshots; expected one each",
            localiser.name(),
            steps.len(),
            trial.snapshots.len()
        ))),
    }
}

/// What is counted of a trial, snapshot by snapshot. One who never looks stays outside once there, "for the rest of that
/// trial" (7.1).
fn scored(
    protocol: &Protocol,
    binning: &Binning,
    trial: &Trial,
    steps: &[Step],
    blind: bool,
) -> Result<Vec<ScoredStep>> {
    // With a thousandth of slack for rounding.
    let diagonal_squared = 2.001 * binning.size_m().powi(2);
    let mut lost = false;
    let of_step = |(&snapshot, step): (&usize, &Step)| {
        let location = location(protocol, binning, snapshot)?;
        let answer = match step.estimate {
            _ if lost => Answer::Outside,
            None => Answer::None,
            Some(Estimate::Class(class)) => Answer::Class(class),
            Some(Estimate::Place(p)) => binning.bin_of(p).map_or(Answer::Outside, Answer::Bin),
        };
        lost |= blind && answer == Answer::Outside;
        // Most of a posterior lies too far away to be in the same bin, which is cheap to see.
        let [x, y] = protocol.place[snapshot];
        let near = |p: [f64; 2]| (p[0] - x).powi(2) + (p[1] - y).powi(2) <= diagonal_squared;
        let at_location =
            |(place, _): &&Probable| near(*place) && binning.bin_of(*place) == Some(location);
        let probability = step
            .posterior
            .iter()
            .filter(at_location)
            .map(|(_, p)| p)
            .sum();
        Ok(ScoredStep {
            location,
            answer,
            probability: (!step.posterior.is_empty()).then_some(probability),
        })
    };
    trial.snapshots.iter().zip(steps).map(of_step).collect()
}

fn location(protocol: &Protocol, binning: &Binning, snapshot: usize) -> Result<usize> {
    let place = protocol.place[snapshot];
    binning.bin_of(place).ok_or_else(|| {
        Error::work(format!(
            "standard: snapshot {snapshot} at ({}, {}) is in none of the bins; expected bins laid over this protocol",
            place[0], place[1]
        ))
    })
}

fn at_distance(distance_m: f64, table: &Contingency<usize, Answer>) -> AtDistance {
    let counts = table.counts();
    let entropies = Entropies::of(&counts);
    AtDistance {
        distance_m,
        entropy_of_location: entropies.location,
        entropy_of_location_given_response: entropies.location_given_response(),
        uncertainty_coefficient: entropies.uncertainty_coefficient(),
        uncertainty_coefficient_corrected: corrected_coefficient(&counts),
    }
}

fn mean(figures: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, number) = figures.fold((0.0, 0.0), |(sum, n), figure| (sum + figure, n + 1.0));
    (number > 0.0).then(|| sum / number)
}

#[cfg(test)]
mod tests;
