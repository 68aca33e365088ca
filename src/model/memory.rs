//! The snapshots that a model's map is made of.

use super::trained_model::Model;
use crate::{
    belief::Places,
    error::{Error, Result},
    geometry::Pose,
    recording::Recording,
};
use std::collections::HashMap;

/// The snapshots that a model's map is made of, in its order, with their labels: a model file holds what its filters answered there,
/// not what was sensed.
#[derive(Debug, Clone)]
pub struct Memory(Recording);

impl Memory {
    /// Looks them up, by their poses to the last bit, in what the model learned from: the dataset that it was trained on, or the
    /// memory of its last update.
    ///
    /// # Errors
    /// Where the recording lacks some of them, or one of the model's sensors.
    pub fn of(model: &Model, recording: &Recording) -> Result<Self> {
        let mut there: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
        for (k, pose) in recording.poses().iter().enumerate().rev() {
            there.entry(bits(pose)).or_default().push(k);
        }
        let own = model.pose.iter();
        let own: Vec<usize> = own
            .filter_map(|pose| there.get_mut(&bits(pose))?.pop())
            .collect();
        if own.len() < model.pose.len() {
            return Err(Error::work(format!(
                "holds {} of the {} snapshots that the model's map is made of; expected all of them: the dataset that it was \
                 trained on, or the memory of its last update",
                own.len(),
                model.pose.len()
            )));
        }
        let seen = model.seen_in(recording)?;
        let seen = seen.select(&own)?;
        Ok(Self(match model.places() {
            Places::Plane(_) => seen.in_the_plane(),
            Places::Route(_) => seen,
        }))
    }

    /// The snapshots themselves.
    pub fn recording(&self) -> &Recording {
        &self.0
    }

    pub(super) fn from_recording(recording: Recording) -> Self {
        Self(recording)
    }
}

fn bits(pose: &Pose) -> [u64; 3] {
    [pose.x_m, pose.y_m, pose.heading_rad].map(f64::to_bits)
}
