//! Localising, comparing and scoring; results as JSON text, for Python's own `json`.

use crate::{
    configuration,
    dataset::Dataset,
    faults::{in_json, raised},
    model::Model,
    waiting::Waiting,
};
use ballmark::{
    experiment::{
        compare::{CompareConfig, Folders, compare as compare_all},
        localisation,
        parts::{Parts, as_learned},
    },
    model,
    report::localisation as tables,
    score::{Effort, Entropies, Responses, Verdict},
    seed::Seed,
};
use pyo3::{exceptions::PyValueError, prelude::*};
use std::{path::PathBuf, time::Instant};

/// Localises on runs that training never saw; the record and its table.
#[pyfunction]
#[pyo3(signature = (models, dataset, *, trained_on, trials, seed, config, on_progress))]
#[expect(
    clippy::too_many_arguments,
    reason = "one an option; Python names them"
)]
pub fn localise(
    py: Python<'_>,
    models: Vec<Bound<'_, Model>>,
    dataset: &Dataset,
    trained_on: Option<Bound<'_, Dataset>>,
    trials: Option<usize>,
    seed: Option<u64>,
    config: Option<String>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let experiment = configuration::read(config, None)?;
    let mut config = experiment.localise;
    config.trials = trials.unwrap_or(config.trials);
    config.seed = Some(seed.unwrap_or(config.seed().0));
    config.people = Some(config.people());
    config.check().map_err(raised)?;
    let models: Vec<&model::Model> = models.iter().map(|model| &model.get().model).collect();
    let Some(first) = models.first() else {
        return Err(PyValueError::new_err("no model; expected at least one"));
    };
    let learned = |dataset: &Dataset| {
        let recording = experiment.degraded.sensor(dataset.recording.clone())?;
        as_learned(&models, recording)
    };
    let recording = learned(dataset).map_err(raised)?;
    let trained_on = trained_on.map(|source| learned(source.get())).transpose();
    let parts = Parts::new(first, &recording, trained_on.map_err(raised)?).map_err(raised)?;
    let disturbed = parts.disturbed(config.people(), &experiment.degraded, config.seed());
    let disturbed = disturbed.map_err(raised)?;
    let in_trouble = disturbed.as_ref().map(|run| parts.with_run(run));
    let parts = in_trouble.as_ref().unwrap_or(&parts);
    let mut waiting = Waiting::new(on_progress);
    let started = Instant::now();
    let record = py.detach(|| {
        localisation::localise(&models, parts, &config, &mut |at| {
            waiting.goes_on((at.done, at.all, at.next.to_string()));
        })
    });
    let record = waiting.done(record.map_err(raised))?;
    let seconds = started.elapsed().as_secs_f64();
    let json = tables::json(&record, Some(seconds)).map_err(raised)?;
    Ok((json.to_string(), tables::table(&record).text()))
}

/// Compares systems on datasets, as a configuration file says; the record.
#[pyfunction]
#[pyo3(signature = (config, *, seed, toy, models, on_progress))]
pub fn compare(
    py: Python<'_>,
    config: PathBuf,
    seed: Option<u64>,
    toy: bool,
    models: Option<PathBuf>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let mut comparison = CompareConfig::read(&config).map_err(raised)?;
    comparison.seed = seed.unwrap_or(comparison.seed);
    if toy {
        comparison.shrink_to_toy();
    }
    let temporary = tempfile::tempdir()?;
    let folders = Folders {
        configuration: config.parent().unwrap_or(std::path::Path::new("")),
        models: models.as_deref().unwrap_or(temporary.path()),
        keeps_beliefs: false,
    };
    let mut waiting = Waiting::new(on_progress);
    let compared = py.detach(|| {
        compare_all(&comparison, folders, &mut |at| {
            waiting.goes_on((at.done, at.all, at.now.to_string()));
        })
    });
    let compared = waiting.done(compared.map_err(raised))?;
    in_json(&compared)
}

/// Judges responses; the verdict.
#[pyfunction]
#[pyo3(signature = (location, response, *, trial, distance_m, permutations, resamples, seed))]
#[expect(
    clippy::too_many_arguments,
    reason = "one an option; Python names them"
)]
pub fn score(
    py: Python<'_>,
    location: Vec<String>,
    response: Vec<String>,
    trial: Option<Vec<String>>,
    distance_m: Option<Vec<f64>>,
    permutations: u64,
    resamples: u64,
    seed: u64,
) -> PyResult<String> {
    let responses = Responses::new(location, response, trial, distance_m).map_err(raised)?;
    let effort = Effort {
        permutations,
        resamples,
    };
    let verdict = py.detach(|| Verdict::new(&responses, effort, Seed(seed)));
    in_json(&verdict)
}

/// U(L|R); none where all locations are one.
#[pyfunction]
pub fn uncertainty_coefficient(
    location: Vec<String>,
    response: Vec<String>,
) -> PyResult<Option<f64>> {
    let responses = Responses::new(location, response, None, None).map_err(raised)?;
    Ok(Entropies::of(&responses.table().counts()).uncertainty_coefficient())
}
