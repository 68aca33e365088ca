//! Trials: stretches of unseen runs, each from some start, with a snapshot every half metre.

use crate::{
    error::{Error, Result},
    recording::Recording,
    seed::Seed,
};
use rand::RngExt;
use std::ops::Range;

/// One trial: the snapshots a robot takes in from its start on.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Stretch of unseen snapshots that it runs in; trials of one stretch are no independent evidence.
    pub stretch: usize,
    /// Indices in the recording.
    pub snapshots: Vec<usize>,
    /// Metres travelled from the start, one a snapshot.
    pub travelled_m: Vec<f64>,
}

/// Consecutive unseen snapshots of one run.
pub fn stretches(recording: &Recording, unseen: &[usize]) -> Vec<Range<usize>> {
    let runs = recording.runs();
    let run_of = |k: usize| runs.partition_point(|run| run.end <= k);
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for &k in unseen {
        match stretches.last_mut() {
            Some(last) if last.end == k && run_of(k) == run_of(last.start) => last.end = k + 1,
            _ => stretches.push(k..k + 1),
        }
    }
    stretches
}

/// Draws `count` trials of at most `longest_m` metres whose starts leave at least `shortest_m` of their stretch, evenly
/// over all such starts; a snapshot every `spacing_m` or, where the log is sparser, every one.
///
/// # Errors
/// Where no stretch is long enough.
pub fn draw(
    recording: &Recording,
    unseen: &[usize],
    count: usize,
    spacing_m: f64,
    shortest_m: f64,
    longest_m: f64,
    seed: Seed,
) -> Result<Vec<Trial>> {
    let travelled = recording.travelled_m();
    let stretches = stretches(recording, unseen);
    let starts: Vec<(usize, usize)> = stretches
        .iter()
        .enumerate()
        .flat_map(|(s, stretch)| stretch.clone().map(move |k| (s, k)))
        .filter(|&(s, k)| travelled[stretches[s].end - 1] - travelled[k] >= shortest_m)
        .collect();
    if starts.is_empty() {
        let longest = stretches
            .iter()
            .map(|s| travelled[s.end - 1] - travelled[s.start])
            .fold(0.0, f64::max);
        return Err(Error::work(format!(
            "no unseen stretch is {shortest_m} m long (the longest: {longest:.1} m); expected longer stretches or runs \
             (split.stretch_m) or shorter trials (localise.shortest_m)"
        )));
    }
    let mut random = seed.stream("trial starts");
    let mut drawn: Vec<(usize, usize)> = (0..count)
        .map(|_| starts[random.random_range(0..starts.len())])
        .collect();
    drawn.sort_unstable();
    Ok(drawn
        .into_iter()
        .map(|(stretch, start)| {
            let mut trial = Trial {
                stretch,
                snapshots: vec![start],
                travelled_m: vec![0.0],
            };
            for k in start + 1..stretches[stretch].end {
                let distance = travelled[k] - travelled[start];
                let last = trial.travelled_m[trial.travelled_m.len() - 1];
                if distance > longest_m {
                    break;
                }
                // A thousandth of slack, or a log with a snapshot every 0.5 m would give one every metre.
                if distance - last >= spacing_m * 0.999 {
                    trial.snapshots.push(k);
                    trial.travelled_m.push(distance);
                }
            }
            trial
        })
        .collect())
}
