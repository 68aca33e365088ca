//! Recordings in Python's hands.

use crate::faults::raised;
use ballmark::{
    Pose,
    experiment::labelled_log::{TOLERANCE_S, labelled},
    recording::{
        Channel, Columns, Recording,
        bearings::Bearings,
        format::Format,
        import::{self, ReadOptions},
        log_options::{GAP_M, LogOptions},
        npz,
        selection::Selection,
    },
    score::trajectory,
};
use numpy::{
    PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, ToPyArray,
    ndarray::{Array2, Axis},
};
use pyo3::{
    exceptions::{PyKeyError, PyValueError},
    prelude::*,
};
use std::{collections::HashMap, path::PathBuf};

/// A recording.
#[pyclass(frozen, module = "ballmark")]
pub struct Dataset {
    pub recording: Recording,
}

/// One channel as Python hands it over: name, values, unit, bearings, maximum, offsets.
type Given<'py> = (
    String,
    PyReadonlyArray2<'py, f32>,
    String,
    Option<Vec<f64>>,
    Option<f64>,
    Option<Vec<f64>>,
);

impl Dataset {
    /// With the checksum of the file that it would be written to, by which a model knows what it learned from.
    pub fn new(recording: Recording) -> PyResult<Self> {
        let folder = tempfile::tempdir()?;
        let file = folder.path().join("dataset.npz");
        npz::write(&file, &recording).map_err(raised)?;
        let recording = npz::read(&file).map_err(raised)?;
        Ok(Self { recording })
    }
}

#[pymethods]
impl Dataset {
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let recording = py.detach(|| npz::read(&path)).map_err(raised)?;
        Ok(Self { recording })
    }

    #[staticmethod]
    #[pyo3(signature = (stamp, pose, channels, odometry, run, route, compass, source))]
    #[expect(clippy::too_many_arguments, reason = "one a column; Python names them")]
    fn of_columns(
        stamp: PyReadonlyArray1<'_, f64>,
        pose: PyReadonlyArray2<'_, f64>,
        channels: Vec<Given<'_>>,
        odometry: Option<PyReadonlyArray2<'_, f64>>,
        run: Option<PyReadonlyArray1<'_, i64>>,
        route: Option<PyReadonlyArray1<'_, f64>>,
        compass: Option<PyReadonlyArray1<'_, f64>>,
        source: Option<String>,
    ) -> PyResult<Self> {
        let pose = poses("pose", &pose)?;
        let odometry = match odometry {
            Some(odometry) => poses("odometry", &odometry)?,
            None => pose.clone(),
        };
        let k = pose.len();
        let mut values = Array2::from_elem((k, 0), f32::NAN);
        let mut described = Vec::new();
        for (name, block, unit, bearing_rad, maximum, offset_m) in channels {
            let block = block.as_array();
            if block.nrows() != k {
                return Err(PyValueError::new_err(format!(
                    "channel `{name}`: {} rows; expected {k}, one a snapshot",
                    block.nrows()
                )));
            }
            let finite = block.mapv(|v| if v.is_finite() { v } else { f32::NAN });
            values
                .append(Axis(1), finite.view())
                .map_err(|e| PyValueError::new_err(e.to_string()))?;
            described.push(Channel {
                name,
                width: finite.ncols(),
                unit,
                bearing_rad,
                maximum,
                offset_m,
            });
        }
        let column = |all: PyReadonlyArray1<'_, f64>| all.as_array().to_vec();
        let recording = Recording::new(Columns {
            channels: described,
            values: values.as_standard_layout().into_owned(),
            stamp_s: stamp.as_array().to_vec(),
            run: run.map_or_else(|| vec![0; k], |run| run.as_array().to_vec()),
            pose,
            odometry,
            route_m: route.map(column),
            compass_rad: compass.map(column),
            source,
            ..Columns::default()
        });
        Self::new(recording.map_err(raised)?)
    }

    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| npz::write(&path, &self.recording))
            .map_err(raised)
    }

    fn __len__(&self) -> usize {
        self.recording.len()
    }

    /// A view of a channel's values: nothing is copied, and nothing can be written.
    fn channel<'py>(this: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let recording = &this.get().recording;
        let mut first = 0;
        for channel in recording.channels() {
            let range = first..first + channel.width;
            first = range.end;
            if channel.name == name {
                let values = recording.values();
                let view = values.slice_axis(Axis(1), range.into());
                // SAFETY: the array lives in the dataset, which is frozen, and which the view keeps alive as its base.
                let array = unsafe { PyArray2::borrow_from_array(&view, this.clone().into_any()) };
                array.readwrite().make_nonwriteable();
                return Ok(array);
            }
        }
        Err(PyKeyError::new_err(name.to_string()))
    }

    /// Name, unit, bearings, maximum and offsets of every channel.
    #[getter]
    #[expect(
        clippy::type_complexity,
        reason = "a row of plain values, which Python names"
    )]
    fn described(
        &self,
    ) -> Vec<(
        String,
        String,
        Option<Vec<f64>>,
        Option<f64>,
        Option<Vec<f64>>,
    )> {
        let channels = self.recording.channels().iter().cloned();
        channels
            .map(|c| (c.name, c.unit, c.bearing_rad, c.maximum, c.offset_m))
            .collect()
    }

    #[getter]
    fn stamp<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.recording.columns().stamp_s.to_pyarray(py)
    }

    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        pose_array(self.recording.poses()).to_pyarray(py)
    }

    #[getter]
    fn odometry<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        pose_array(&self.recording.columns().odometry).to_pyarray(py)
    }

    #[getter]
    fn run<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.recording.columns().run.to_pyarray(py)
    }

    #[getter]
    fn route<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let route_m = self.recording.columns().route_m.as_ref();
        route_m.map(|all| all.to_pyarray(py))
    }

    #[getter]
    fn compass<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        let compass_rad = self.recording.columns().compass_rad.as_ref();
        compass_rad.map(|all| all.to_pyarray(py))
    }

    #[getter]
    fn source(&self) -> Option<String> {
        self.recording.columns().source.clone()
    }

    #[getter]
    fn path_m(&self) -> f64 {
        self.recording.path_m()
    }
}

/// Reads logs; answers the dataset and what became of them, as JSON.
#[pyfunction]
#[pyo3(signature = (logs, *, format, max_range, columns, drop, units, bearings, offsets, gap, poses, pose_times, pose_tolerance, pose_topic, topics))]
#[expect(
    clippy::too_many_arguments,
    reason = "one an option; Python names them"
)]
pub fn import_log(
    py: Python<'_>,
    logs: Vec<PathBuf>,
    format: Option<String>,
    max_range: Option<f64>,
    columns: Vec<String>,
    drop: Vec<String>,
    units: HashMap<String, String>,
    bearings: HashMap<String, Vec<f64>>,
    offsets: HashMap<String, f64>,
    gap: Option<f64>,
    poses: Option<PathBuf>,
    pose_times: Option<PathBuf>,
    pose_tolerance: Option<f64>,
    pose_topic: Option<String>,
    topics: Option<Vec<String>>,
) -> PyResult<(Dataset, String)> {
    fn sorted<T>(all: HashMap<String, T>) -> Vec<(String, T)> {
        let mut all: Vec<_> = all.into_iter().collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    }
    let each = |(name, deg)| (name, Bearings::Each(deg));
    let options = ReadOptions {
        format: format
            .as_deref()
            .map(Format::named)
            .transpose()
            .map_err(raised)?,
        log: LogOptions {
            max_range_m: max_range,
            sensors: Selection {
                take: columns,
                leave: drop,
            },
            units: sorted(units),
            bearings: sorted(bearings).into_iter().map(each).collect(),
            offsets_m: sorted(offsets),
            gap_m: gap,
            poses_elsewhere: poses.is_some(),
            pose_topic,
            topics,
        },
    };
    let log = py.detach(|| {
        let log = import::read(&logs, &options)?;
        let Some(poses) = poses else { return Ok(log) };
        let mut track = trajectory::read(&poses, None)?;
        if let Some(times) = pose_times {
            track = track.with_stamps(trajectory::read_times(times)?)?;
        }
        labelled(
            log,
            &track,
            pose_tolerance.unwrap_or(TOLERANCE_S),
            gap.unwrap_or(GAP_M),
        )
    });
    let log = log.map_err(raised)?;
    let account = serde_json::json!({
        "odometry": log.odometry.describe(),
        "used": log.account.used_counts(),
        "passed_over": log.account.passed_over_counts(),
        "warnings": log.account.warning_counts(),
        "notes": log.account.notes(),
        "dropped": log.account.lost_count(),
        "dropped_records": log.account.lost_records(),
    });
    Ok((Dataset::new(log.recording)?, account.to_string()))
}

fn poses(name: &str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Pose>> {
    let array = array.as_array();
    if array.ncols() != 3 {
        return Err(PyValueError::new_err(format!(
            "`{name}`: {} columns; expected 3: x and y in metres, heading in radians",
            array.ncols()
        )));
    }
    let rows = array.rows().into_iter();
    Ok(rows.map(|p| Pose::new(p[0], p[1], p[2])).collect())
}

fn pose_array(poses: &[Pose]) -> Array2<f64> {
    Array2::from_shape_fn((poses.len(), 3), |(k, i)| match i {
        0 => poses[k].x_m,
        1 => poses[k].y_m,
        _ => poses[k].heading_rad,
    })
}
