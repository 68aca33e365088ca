//! The likelihood of a snapshot under a field of its readings: for sensors that no plan predicts.

use super::{PreparedSensorModel, SensorModel};
use crate::{
    belief::{Belief, SignalFieldAt},
    error::{Error, Result},
    recording::{Channel, Observation, Recording, check_width},
    seed::Stream,
};
use ndarray::ArrayView1;
use std::sync::Arc;

/// A [`SignalField`](crate::belief::SignalField) over the cells of a grid, read as a likelihood.
///
/// ln P(z | ξ) is finite at every cell. Its readings are taken as independent of each other, which they are not: it has to
/// be scaled ([`EvidenceScale`](super::EvidenceScale)) before a filter may believe it. For single snapshots
/// [`fit_tuned`](crate::belief::signal_field::fit_tuned) finds a power.
///
/// ```
/// use ballmark::{belief::{Belief, Grid, GridConfig, SignalField, SignalFieldConfig, signal_field::LabelledReadings}, seed::Seed};
/// use ballmark::{geometry::Pose, localiser::sensor_model::{SensorModel, SignalFieldModel}, recording::{Channel, Columns, Recording}};
/// use std::sync::Arc;
/// // Two passes along 10 m, with a lamp at the end.
/// let pose: Vec<Pose> = (0..80).map(|k| Pose::new(0.25 * f64::from(k % 40), 0.1, 0.0)).collect();
/// let light = Channel { name: "light".into(), width: 1, unit: "lux".into(), bearing_rad: None, maximum: None, offset_m: None };
/// let lux = |pose: &Pose| (500.0 / (11.0 - pose.x_m)) as f32;
/// let recording = Recording::new(Columns {
///     channels: vec![light],
///     values: ndarray::Array2::from_shape_vec((80, 1), pose.iter().map(lux).collect()).unwrap(),
///     stamp_s: (0..80).map(f64::from).collect(),
///     odometry: pose.clone(),
///     run: (0..80).map(|k| k / 40).collect(),
///     pose,
///     ..Columns::default()
/// })?;
/// let all: Vec<usize> = (0..80).collect();
/// let readings = LabelledReadings::of(&recording, &all, &[])?;
/// let field = SignalField::fit(&readings, &SignalFieldConfig::default())?;
///
/// let grid = Grid::over(&readings.places, &GridConfig::default())?;
/// let model = SignalFieldModel::new(Arc::new(field.at(grid.places())?));
/// let belief = Belief::uniform(grid.places())?;
/// let log_likelihood = model.log_likelihood(&recording.observation(36), &belief, &mut Seed(1).stream("unused"))?;
/// let cell_of = |snapshot| grid.cell_at(&readings.places, snapshot).unwrap();
/// assert!(log_likelihood[cell_of(36)] > log_likelihood[cell_of(4)] + 2.0);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct SignalFieldModel {
    at: Arc<SignalFieldAt>,
}

impl SignalFieldModel {
    /// Of a field at the cells of a grid: `field.at(grid.places())`.
    pub fn new(at: Arc<SignalFieldAt>) -> Self {
        Self { at }
    }

    /// Where the readings of the field's channels stand among those of `channels`.
    ///
    /// # Errors
    /// Where a channel is missing or has another width or unit.
    fn columns(&self, channels: &[Channel]) -> Result<Vec<usize>> {
        let mut columns = Vec::new();
        for wanted in self.at.channels() {
            let mut from = 0;
            let mut same_name = None;
            for channel in channels {
                if channel.name == wanted.name {
                    same_name = Some((from, channel));
                }
                from += channel.width;
            }
            let Some((from, channel)) = same_name else {
                let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
                return Err(Error::work(format!(
                    "signal field: no channel `{}`, which it was learned from; found {}",
                    wanted.name,
                    names.join(", ")
                )));
            };
            if channel.width != wanted.width || channel.unit != wanted.unit {
                return Err(Error::work(format!(
                    "signal field: channel `{}` has {} values in `{}`; expected {} in `{}`, as it was learned from",
                    wanted.name, channel.width, channel.unit, wanted.width, wanted.unit
                )));
            }
            columns.extend(from..from + channel.width);
        }
        Ok(columns)
    }

    /// ln P(z | ξ) of the values of an observation, those of the field's channels in `columns`.
    fn of_values(
        &self,
        values: ArrayView1<f32>,
        columns: &[usize],
        belief: &Belief,
    ) -> Result<Vec<f64>> {
        let cells = belief.mass().len();
        if cells != self.at.len() {
            return Err(Error::work(format!(
                "signal field: a belief of {cells} cells; expected {}, those of the field",
                self.at.len()
            )));
        }
        let own = columns.iter().map(|&column| values[column]).collect();
        self.at
            .log_likelihood(ndarray::Array1::from_vec(own).view())
    }
}

impl SensorModel for SignalFieldModel {
    fn name(&self) -> &str {
        "signal_field"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        check_width(observation.channels, observation.values.len())
            .map_err(|error| error.context("signal field"))?;
        let columns = self.columns(observation.channels)?;
        self.of_values(observation.values, &columns, belief)
    }

    /// Channels are looked up once; the cells are asked when a snapshot's turn comes.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        _: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        Ok(Box::new(PreparedSignalField {
            columns: self.columns(recording.channels())?,
            model: self,
            recording,
        }))
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}

/// [`SignalFieldModel`] with a recording before it.
struct PreparedSignalField<'a> {
    model: &'a SignalFieldModel,
    recording: &'a Recording,
    columns: Vec<usize>,
}

impl PreparedSensorModel for PreparedSignalField<'_> {
    fn log_likelihood(&self, snapshot: usize, belief: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
        let values = self.recording.observation(snapshot).values;
        self.model.of_values(values, &self.columns, belief)
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}
