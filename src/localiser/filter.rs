//! The Bayes filter at work on a run: odometry moves the belief, what the sensors say corrects it.

use crate::{
    belief::{Bayes, Belief, Grid, OdometryMotion},
    error::Result,
    recording::Observation,
    seed::Stream,
};
use std::sync::Arc;

/// What a snapshot says about every cell of a grid. Prepared once for a recording's observations, then asked for each.
pub trait SensorModel: Sync {
    /// ln P(snapshot | cell) at every cell, up to a constant. `belief` is the belief before, which some evidence needs;
    /// `stream` is there for evidence that is drawn.
    ///
    /// # Errors
    /// Where the belief is not about the cells that the model was prepared for.
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>>;
}

/// The Bayes filter with a sensor model: Thrun (1998), Table 1, driven by the odometry of a run.
pub struct BayesLocaliser<'a> {
    filter: Bayes,
    sensor: Option<&'a dyn SensorModel>,
    stream: Stream,
    last: Option<crate::geometry::Pose>,
}

impl<'a> BayesLocaliser<'a> {
    /// A robot whose belief is `start`; without a sensor model it only reckons.
    ///
    /// # Errors
    /// Where `start` is not about the cells of `grid`.
    pub fn new(
        grid: &Arc<Grid>,
        motion: &OdometryMotion,
        start: Belief,
        sensor: Option<&'a dyn SensorModel>,
        stream: Stream,
    ) -> Result<Self> {
        Ok(Self {
            filter: Bayes::new(grid, motion.clone(), start)?,
            sensor,
            stream,
            last: None,
        })
    }

    /// Takes in the next observation of the run, which is snapshot number `snapshot` to the sensor model: what odometry
    /// says since the last one, then what the sensors say.
    ///
    /// # Errors
    /// Where the likelihood is 0 wherever the belief has mass.
    pub fn observe(&mut self, snapshot: usize, observation: &Observation) -> Result<&Belief> {
        if let Some(last) = self.last.replace(observation.odometry) {
            self.filter
                .predict(&last.displacement_to(&observation.odometry))?;
        }
        if let Some(sensor) = self.sensor {
            let likelihood =
                sensor.log_likelihood(snapshot, self.filter.belief(), &mut self.stream)?;
            self.filter.correct(&likelihood)?;
        }
        Ok(self.filter.belief())
    }
}
