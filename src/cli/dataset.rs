//! Datasets as commands read them: one or several, as the sensor of a configuration would have made them.

use super::warn;
use crate::{
    error::Result,
    experiment::same_sensor::other_sensor,
    model::Model,
    recording::{Recording, degraded::Degraded, npz},
};
use std::path::{Path, PathBuf};

/// A dataset as the sensor of a configuration would have made it.
pub(super) fn read(dataset: &Path, degraded: &Degraded) -> Result<Recording> {
    let recording = npz::read(dataset)?;
    degraded.sensor(recording).map_err(|e| e.in_file(dataset))
}

/// Some datasets as one recording, likewise.
pub(super) fn read_all(datasets: &[PathBuf], degraded: &Degraded) -> Result<Recording> {
    let recordings = datasets.iter().map(|path| npz::read(path));
    let recordings = recordings.collect::<Result<Vec<_>>>()?;
    let joined = Recording::joined(recordings).and_then(|joined| degraded.sensor(joined));
    joined.map_err(|e| match datasets.first() {
        Some(path) => e.in_file(path),
        None => e,
    })
}

/// Says where a recording's sensor is another one than a model learned with.
pub(super) fn warn_of_other_sensors(models: &[&Model], recording: &Recording) {
    let mut differences = models
        .iter()
        .filter_map(|model| other_sensor(model, recording));
    if let Some(difference) = differences.next() {
        warn(&format!("note: {difference}"));
    }
}
