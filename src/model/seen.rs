//! Has a model seen a recording? Whoever judges a model on what it has seen judges its memory.

use super::Model;
use crate::{detector::Detector, error::Result, geometry::Pose, recording::Recording};
use std::collections::HashSet;

/// Activations that a detector gives again on another machine may differ by this much.
const SAME_ACTIVATION: f32 = 1e-3;

/// Is this the very recording that the model learned from, so that the recipe's split tells which part it has seen?
///
/// It is where the split's training part, or what of it came into the map, has the poses of the model's map, to the last bit, and either comes from the file that
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
    let mapped = model.mapped_of(recording, &split.train);
    let mut both = mapped.iter().zip(&model.pose);
    if mapped.len() != model.pose.len() || !both.all(|(&k, pose)| bits(&poses[k]) == bits(pose)) {
        return Ok(false); // a part of a dataset has its checksum, but not its places
    }
    let own = recording.columns().dataset_sha256.as_deref();
    if own.is_some() && own == model.header.dataset_sha256.as_deref() {
        return Ok(true);
    }
    let detector = model.detector();
    let training = recording.select(&mapped)?;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        seed::Seed,
        world::corridor::{CorridorConfig, thrun1998},
    };
    use std::path::Path;

    fn model() -> Model {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
        Model::read(&folder.join("corridor-2m.safetensors")).unwrap()
    }

    fn corridor(seed: u64) -> Recording {
        thrun1998(Seed(seed), &CorridorConfig::default()).unwrap()
    }

    fn with_checksum(recording: &Recording, sha256: Option<String>) -> Recording {
        let mut columns = recording.columns().clone();
        columns.dataset_sha256 = sha256;
        Recording::new(columns).unwrap()
    }

    /// What the model learned from is known with its checksum, and in memory, without.
    #[test]
    fn a_recording_is_known_by_its_content() {
        let (model, own) = (model(), corridor(1));
        assert_eq!(own.columns().dataset_sha256, None);
        assert!(is_source(&model, &own).unwrap());
        let sha256 = model.header.dataset_sha256.clone();
        assert!(is_source(&model, &with_checksum(&own, sha256.clone())).unwrap());
        assert!(!is_source(&model, &corridor(2)).unwrap());
        // A part of the dataset has its checksum, but another split.
        let half: Vec<usize> = (0..own.len() / 2).collect();
        let half = with_checksum(&own.select(&half).unwrap(), sha256);
        assert!(!is_source(&model, &half).unwrap());
        // The same way with other readings is another recording.
        let mut columns = own.into_columns();
        columns.values.mapv_inplace(|v| 0.5 * v);
        assert!(!is_source(&model, &Recording::new(columns).unwrap()).unwrap());
    }

    #[test]
    fn poses_that_a_map_has_are_counted_once() {
        let (model, own, other) = (model(), corridor(1), corridor(2));
        assert!(is_chance(learned_poses(&model.pose, &other, &[])));
        let seen = learned_poses(&model.pose, &own, &[]);
        assert!(!is_chance(seen) && seen <= model.pose.len());
        let all: Vec<usize> = (0..own.len()).collect();
        assert_eq!(learned_poses(&model.pose, &own, &all), 0);
    }
}
