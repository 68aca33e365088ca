//! Datasets as commands read them: one or several, as the sensor of a configuration would have made them.

use super::warn;
use crate::{
    detector::Detector,
    error::{Error, Result},
    experiment::same_sensor::other_sensor,
    model::{Model, ModelBank},
    recording::{Recording, degraded::Degraded, npz},
};
use ndarray::Array2;
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

/// P(f_i = 1 | s) of every snapshot.
///
/// # Errors
/// Where the recording lacks the model's sensors.
pub(super) fn answers(model: &Model, recording: &Recording) -> Result<Array2<f32>> {
    model.detector().probabilities(&*model.seen_in(recording)?)
}

/// Are these the answers of networks that work?
///
/// # Errors
/// Where one of them is no number: weights that are all finite may be so large. The message names the model's file.
pub(super) fn check_numbers(file: &Path, answers: &Array2<f32>) -> Result<()> {
    let mut rows = answers.rows().into_iter();
    match rows.position(|row| row.iter().any(|p| p.is_nan())) {
        None => Ok(()),
        Some(k) => Err(Error::file(
            file,
            format!("its networks answer NaN to snapshot {k}; expected probabilities"),
        )),
    }
}

/// The same of all sets of some models on a recording; one that lacks their sensors is left to who localises in it.
///
/// # Errors
/// As [`check_numbers`].
pub(super) fn check_models(
    files: &[PathBuf],
    banks: &[ModelBank],
    recording: &Recording,
) -> Result<()> {
    for (file, bank) in files.iter().zip(banks) {
        for set in bank.sets() {
            if let Ok(answers) = answers(set, recording) {
                check_numbers(file, &answers)?;
            }
        }
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_that_is_no_number_names_the_model_and_the_snapshot() {
        let file = Path::new("m.safetensors");
        let mut answers = Array2::from_elem((3, 2), 0.5);
        assert!(check_numbers(file, &answers).is_ok());
        answers[[2, 1]] = f32::NAN;
        let fault = check_numbers(file, &answers).unwrap_err().to_string();
        assert_eq!(
            fault,
            "m.safetensors: its networks answer NaN to snapshot 2; expected probabilities"
        );
    }
}
