//! Where things stand in the recording.

use crate::experiment::belief_traces::TracedTrial;
use re_log_types::{EntityPath, entity_path};

/// The map.
pub(super) fn map() -> EntityPath {
    entity_path!("map")
}

/// What is what, in words.
pub(super) fn about() -> EntityPath {
    entity_path!("about")
}

/// All of one trial, numbered as in the page's player.
pub(super) fn trial(trial: &TracedTrial) -> EntityPath {
    entity_path!("trials", trial.number + 1)
}

/// What of one trial is of one kind and name: a system's or a channel's may hold any character.
pub(super) fn named(trial: &EntityPath, kind: &'static str, name: &str) -> EntityPath {
    trial.join(&entity_path!(kind, name))
}

/// The robot's frame along a trial.
pub(super) fn robot(trial: &EntityPath) -> EntityPath {
    trial.join(&entity_path!("robot"))
}
