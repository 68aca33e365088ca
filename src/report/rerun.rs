//! Kept trials as a recording for the viewer [Rerun](https://rerun.io): the map, where the robot was, what it sensed, what each system
//! believed and answered, step by step.
//!
//! The recording holds two timelines, `step` and `travelled_cm` (centimetres from the start), and none of a clock. Under
//! `/trials/N` stand, of trial number N (counted from 1, as in the page's player):
//!
//! | entity | what |
//! |---|---|
//! | `robot` | the true pose, as a frame that moves; `robot/heading` an arrow ahead |
//! | `robot/scan/CHANNEL`, `robot/beams/CHANNEL` | what the beams of a range channel met, and the beams, in the robot's frame |
//! | `way` | the true way, all of it |
//! | `belief/SYSTEM` | what squares hold, as points whose area grows with the root of the mass; along a route, as a profile |
//! | `answer/SYSTEM` | the answer, and its heading where it has one |
//! | `expected_error_m/SYSTEM`, `point_error_m/SYSTEM`, `entropy_nats/SYSTEM`, `says_lost/SYSTEM` | the same numbers as the record's |
//! | `features/now`, `features/over_time` | P(f_i = 1) of the first networks, as bars and as lines |
//!
//! `/map` is the map that the likelihood field uses, `/about` says what is what. x and y are metres in the frame of the dataset, seen from
//! above; along a route x is its coordinate, and what the robot sees is drawn as if it faced along the route. A system has the
//! colour that it has in every picture.
//!
//! Numbers of rows and chunks are counted, and the name of the recording is a digest of what it holds, so the same trials are the same
//! bytes. A layout for the viewer comes with it.

mod blueprint;
mod paths;
mod scene;
mod stream;
mod trial;

#[cfg(test)]
mod tests;

use super::localisation::systems_at_first;
use crate::{
    error::{Error, Result},
    experiment::{
        belief_traces::{BeliefTraces, SensedTrial},
        localisation::Record,
    },
    storage::sha256,
};
use scene::Scene;
use stream::Stream;

/// The kept trials of a record as the bytes of an `.rrd` file. `sensed` is what the robot sensed along them
/// ([`BeliefTraces::sensed`](crate::experiment::belief_traces::BeliefTraces::sensed)); without it there are neither scans nor features.
///
/// # Errors
/// Where the record kept no beliefs, what it kept is damaged, or `sensed` is of other trials.
pub fn recording(title: &str, record: &Record, sensed: &[SensedTrial]) -> Result<Vec<u8>> {
    let traces = record.beliefs.as_ref().filter(|b| !b.trials.is_empty());
    let Some(traces) = traces else {
        return Err(Error::work(
            "no beliefs were kept, so there is nothing to record",
        ));
    };
    recorded(title, traces, sensed, &systems_at_first(record, traces))
}

fn recorded(
    title: &str,
    traces: &BeliefTraces,
    sensed: &[SensedTrial],
    shown: &[usize],
) -> Result<Vec<u8>> {
    let sound = traces.check();
    sound.map_err(|fault| Error::work(format!("kept beliefs: {fault}")))?;
    let numbers = sensed.iter().map(|trial| trial.number);
    let is_theirs = numbers.eq(traces.trials.iter().map(|trial| trial.number));
    if !sensed.is_empty() && !is_theirs {
        return Err(Error::work("what was sensed is of other trials"));
    }
    let content = serde_json::to_vec(&(title, traces, sensed));
    let content = content.map_err(|e| Error::work(format!("kept beliefs: {e}")))?;
    let mut stream = Stream::new(&sha256(&content));
    let scene = Scene::new(traces);
    stream.begin_recording(title)?;
    scene.draw(&mut stream)?;
    for (index, kept) in traces.trials.iter().enumerate() {
        trial::draw(&mut stream, &scene, kept, sensed.get(index))?;
    }
    blueprint::lay_out(&mut stream, &scene, sensed, shown)?;
    stream.into_bytes()
}
