//! Has a model seen a recording? Whoever judges a model on what it has seen judges its memory.

use super::Model;
use crate::{detector::Detector, error::Result, geometry::Pose, recording::Recording};
use std::collections::HashSet;

/// Activations that a detector gives again on another machine may differ by this much.
const SAME_ACTIVATION: f32 = 1e-3;

/// Is this the very recording that the model learned from, so that the recipe's split tells which part it has seen?
///
/// It is where the split's training part has the poses of the model's map, to the last bit, and either comes from the file that
/// the model names (by its checksum), or has the sensor values that make the model answer there what its map says: a recording
/// that was never in a file, or whose file was written anew.
///
/// # Errors
/// Where the networks can't answer, which a model's own recording never makes them do.
pub fn is_source(model: &Model, recording: &Recording) -> Result<bool> {
    let Ok(split) = model.header.recipe.split.split(recording) else {
        return Ok(false);
    };
    let poses = recording.poses();
    let mut both = split.train.iter().zip(&model.pose);
    if split.train.len() != model.pose.len()
        || !both.all(|(&k, pose)| bits(&poses[k]) == bits(pose))
    {
        return Ok(false); // a part of a dataset has its checksum, but not its places
    }
    let own = recording.columns().dataset_sha256.as_deref();
    if own.is_some() && own == model.header.dataset_sha256.as_deref() {
        return Ok(true);
    }
    let detector = model.detector();
    let training = recording.select(&split.train)?;
    let Ok(activation) = detector.probabilities(&training) else {
        return Ok(false); // other sensors
    };
    let mut both = activation.iter().zip(&model.activation);
    Ok(both.all(|(a, b)| (a - b).abs() < SAME_ACTIVATION))
}

/// At how many different poses that a map was made at, to the last bit, a recording has snapshots, apart from those of
/// `except`. Two or fewer may be [chance](is_chance).
pub fn learned_poses(learned: &[Pose], recording: &Recording, except: &[usize]) -> usize {
    let poses = recording.poses();
    let except: HashSet<_> = except.iter().map(|&k| bits(&poses[k])).collect();
    let learned: HashSet<_> = learned.iter().map(bits).collect();
    let there: HashSet<_> = poses.iter().map(bits).collect();
    let seen = there.iter().filter(|pose| learned.contains(*pose));
    seen.filter(|pose| !except.contains(*pose)).count()
}

/// May a recording be at so many poses of a map without having been learned from? Runs like to begin at (0, 0, 0).
pub fn is_chance(learned_poses: usize) -> bool {
    learned_poses <= 2
}

fn bits(pose: &Pose) -> [u64; 3] {
    [pose.x_m, pose.y_m, pose.heading_rad].map(f64::to_bits)
}
