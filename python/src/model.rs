//! Trained filters, and training them.

use crate::{
    configuration,
    dataset::Dataset,
    faults::{in_json, raised},
    waiting::Waiting,
};
use ballmark::{
    Pose,
    detector::Detector,
    experiment::robot_constants,
    learning::trainer::Directive,
    model::{self, Training},
    recording::{Columns, Recording},
};
use numpy::{PyArray2, PyReadonlyArray2, ToPyArray, ndarray::Array2};
use pyo3::{exceptions::PyValueError, prelude::*};
use std::path::PathBuf;

/// Filters with their map.
#[pyclass(frozen, module = "ballmark")]
pub struct Model {
    pub model: model::Model,
    /// What its training should have its user know.
    notes: Vec<String>,
}

#[pymethods]
impl Model {
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let model = py.detach(|| model::Model::read(&path)).map_err(raised)?;
        Ok(Self {
            model,
            notes: Vec::new(),
        })
    }

    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.model.write(&path)).map_err(raised)
    }

    #[getter]
    fn features(&self) -> usize {
        self.model.features()
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    #[getter]
    fn header_json(&self) -> PyResult<String> {
        in_json(&self.model.header)
    }

    /// P(f_i = 1) of a dataset's snapshots.
    fn of_dataset<'py>(
        &self,
        py: Python<'py>,
        dataset: &Dataset,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let probability = py.detach(|| self.model.detector().probabilities(&dataset.recording));
        Ok(probability.map_err(raised)?.to_pyarray(py))
    }

    /// P(f_i = 1) of raw readings, channels side by side in the model's order.
    fn of_values<'py>(
        &self,
        py: Python<'py>,
        values: PyReadonlyArray2<'_, f32>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let values = values.as_array();
        let channels = self.model.header.channels.clone();
        let width: usize = channels.iter().map(|c| c.width).sum();
        let k = values.nrows();
        if values.ncols() != width {
            return Err(PyValueError::new_err(format!(
                "{} values a snapshot; expected {width}: {}",
                values.ncols(),
                channels
                    .iter()
                    .map(|c| format!("{} of `{}`", c.width, c.name))
                    .collect::<Vec<_>>()
                    .join(", ")
            )));
        }
        if k == 0 {
            return Ok(Array2::<f32>::zeros((0, self.model.features())).to_pyarray(py));
        }
        let recording = Recording::new(Columns {
            channels,
            values: values.mapv(|v| if v.is_finite() { v } else { f32::NAN }),
            stamp_s: vec![0.0; k],
            pose: vec![Pose::default(); k],
            odometry: vec![Pose::default(); k],
            run: vec![0; k],
            ..Columns::default()
        });
        let recording = recording.map_err(raised)?;
        let probability = py.detach(|| self.model.detector().probabilities(&recording));
        Ok(probability.map_err(raised)?.to_pyarray(py))
    }
}

/// Learns filters.
#[pyfunction]
#[pyo3(signature = (dataset, *, uncertainty, features, steps, seed, test_fold, recipe, config, on_progress))]
#[expect(
    clippy::too_many_arguments,
    reason = "one an option; Python names them"
)]
pub fn train(
    py: Python<'_>,
    dataset: &Dataset,
    uncertainty: Option<String>,
    features: Option<usize>,
    steps: Option<usize>,
    seed: Option<u64>,
    test_fold: Option<usize>,
    recipe: Option<String>,
    config: Option<String>,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let experiment = configuration::read(config, recipe.as_deref())?;
    let mut recipe = experiment.train;
    if let Some(uncertainty) = uncertainty {
        recipe.uncertainty = uncertainty.parse().map_err(raised)?;
    }
    recipe.features = features.unwrap_or(recipe.features);
    recipe.descent.steps = steps.unwrap_or(recipe.descent.steps);
    recipe.seed = seed.unwrap_or(recipe.seed);
    recipe.split.test_fold = test_fold.or(recipe.split.test_fold);
    let recording = experiment
        .degraded
        .sensor(dataset.recording.clone())
        .map_err(raised)?;
    let mut waiting = Waiting::new(on_progress);
    let learned = py.detach(|| {
        let training = Training::new(&recipe, &recording).on_progress(|p| {
            let goes_on = waiting.goes_on((p.step, p.most_steps, p.best_validation));
            match (goes_on, waiting.has_raised()) {
                (true, _) => Directive::Continue,
                (false, false) => Directive::Stop,
                (false, true) => Directive::Cancel,
            }
        });
        training.run()
    });
    let mut learned = waiting.done(learned.map_err(raised))?;
    let mut notes: Vec<String> = learned.report.notes.iter().map(|n| n.to_string()).collect();
    if let Err(fault) = py.detach(|| robot_constants::tune(&mut learned.model, &recording)) {
        notes.push(format!("evidence not tuned: {fault}"));
    }
    Ok(Model {
        model: learned.model,
        notes,
    })
}
