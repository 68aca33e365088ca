//! Which trials are played: one every few seconds, from whole laps, as far as they have room.

use super::StandardConfig;
use crate::{
    error::{Error, Result},
    experiment::protocol::Protocol,
};
use std::ops::Range;

/// One trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Snapshots played, consecutive.
    pub snapshots: Vec<usize>,
    /// For every contingency table, the last of them that is not beyond its distance.
    pub step_at: Vec<usize>,
    /// Lap, run or stretch that it starts in.
    pub unit: usize,
}

/// Rounding of sums of distances and stamps.
const ROUNDING: f64 = 1e-9;
/// Share of a lap that may lack of a whole one.
const NEARLY_A_LAP: f64 = 0.01;

/// The trials of a protocol, in the order of their starts, and what is to be said of them.
///
/// "The number of trials was carefully chosen so that each part of the environment was equally represented in the data"
/// (D98 7): where the protocol has laps, trials start in as many whole laps as leave room for the last trial.
///
/// # Errors
/// Where no trial fits; the message tells the longest part there is.
pub fn trials(protocol: &Protocol, config: &StandardConfig) -> Result<(Vec<Trial>, Vec<String>)> {
    config.check()?;
    let blocks = blocks(protocol);
    let m = &protocol.travelled_m;
    let mut notes = Vec::new();
    let mut trials = Vec::new();
    let mut longest_m = 0.0_f64;
    for block in blocks {
        let room_m = m[block.end - 1] - m[block.start];
        longest_m = longest_m.max(room_m);
        let starts_m = room_m - config.trial_m;
        if starts_m < -ROUNDING {
            continue;
        }
        let laps = protocol
            .laps
            .as_ref()
            .filter(|laps| laps.run.contains(&block.start));
        let laps = laps.map(|laps| (laps.lap_m, (starts_m / laps.lap_m + NEARLY_A_LAP).floor()));
        let until_m = match laps {
            Some((lap_m, whole)) if whole >= 1.0 => whole * lap_m,
            Some((lap_m, _)) => {
                notes.push(format!(
                    "trials start in {:.0} % of a lap only: after it, there is no room for {} m",
                    100.0 * starts_m / lap_m,
                    config.trial_m
                ));
                f64::INFINITY
            }
            None => f64::INFINITY,
        };
        let stamps = &protocol.recording.columns().stamp_s;
        let mut due_s = stamps[block.start];
        for start in block.clone() {
            let done_m = m[start] - m[block.start];
            if done_m > starts_m + ROUNDING || done_m >= until_m {
                break;
            }
            if stamps[start] + ROUNDING < due_s {
                continue;
            }
            // The next of those due, on the grid of intervals, that is not over yet.
            let over = ((stamps[start] - due_s) / config.every_s + ROUNDING).floor();
            due_s += config.every_s * (over + 1.0);
            // Counted from the block's start, so that no few trials make a lap of their own by rounding.
            let lap = laps.map_or(0, |(lap_m, _)| (done_m / lap_m) as usize);
            let unit = protocol.unit[block.start] + lap;
            trials.push(trial(protocol, config, start..block.end, unit));
        }
    }
    match trials.is_empty() {
        false => Ok((trials, notes)),
        true => Err(Error::work(format!(
            "standard: no trial of {} m fits; the longest part to be tested on is {longest_m:.1} m; expected longer \
             parts, or a shorter standard.trial_m",
            config.trial_m
        ))),
    }
}

/// Where trials may run: consecutive snapshots of the testing part; where they are laps, from one into the next.
fn blocks(protocol: &Protocol) -> Vec<Range<usize>> {
    let mut blocks: Vec<Range<usize>> = Vec::new();
    for &k in &protocol.testing {
        match blocks.last_mut() {
            Some(block) if block.end == k && protocol.is_one_way(k - 1, k) => block.end = k + 1,
            _ => blocks.push(k..k + 1),
        }
    }
    blocks
}

fn trial(protocol: &Protocol, config: &StandardConfig, room: Range<usize>, unit: usize) -> Trial {
    let travelled = |k: usize| protocol.travelled_m[k] - protocol.travelled_m[room.start];
    let mut step = 0;
    let step_at: Vec<usize> = (0..config.tables())
        .map(|table| {
            let distance_m = config.distance_m(table) + ROUNDING;
            while room.start + step + 1 < room.end && travelled(room.start + step + 1) <= distance_m
            {
                step += 1;
            }
            step
        })
        .collect();
    Trial {
        snapshots: (room.start..=room.start + step).collect(),
        step_at,
        unit,
    }
}
