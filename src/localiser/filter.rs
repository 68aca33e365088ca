//! The Bayes filter at work on a run: odometry moves the belief, what the sensors say corrects it.

use super::{PreparedSensorModel, Sites, Step};
use crate::{
    belief::{BayesFilter, Belief, Grid, OdometryMotion},
    error::Result,
    recording::{Observation, Recording},
    seed::Stream,
};
use std::sync::Arc;

/// The Bayes filter with a sensor model: Thrun (1998), Table 1, driven by the odometry of a run.
pub struct BayesLocaliser<'a> {
    filter: BayesFilter,
    sensor: Option<&'a dyn PreparedSensorModel>,
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
        sensor: Option<&'a dyn PreparedSensorModel>,
        stream: Stream,
    ) -> Result<Self> {
        Ok(Self {
            filter: BayesFilter::new(grid, motion.clone(), start)?,
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

    /// The belief of the moment before the sensors of the next observation speak: what [`observe`](Self::observe) would hold against
    /// them.
    ///
    /// # Errors
    /// Where the odometry is no movement.
    pub fn predicted(&self, observation: &Observation) -> Result<Belief> {
        let mut ahead = self.filter.clone();
        if let Some(last) = self.last {
            ahead.predict(&last.displacement_to(&observation.odometry))?;
        }
        Ok(ahead.belief().clone())
    }

    /// What a localiser says after each snapshot of a trial: places at `sites` of the grid, with their probabilities.
    ///
    /// # Errors
    /// As [`BayesLocaliser::observe`].
    pub fn play(
        &mut self,
        recording: &Recording,
        trial: &[usize],
        sites: &Sites,
    ) -> Result<Vec<Step>> {
        let step = |&k: &usize| {
            let belief = self.observe(k, &recording.observation(k))?;
            Ok(sites.step(belief))
        };
        trial.iter().map(step).collect()
    }
}
