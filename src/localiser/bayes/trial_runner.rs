//! The filter with a recording before it.

use super::Bayes;
use crate::{
    belief::Belief,
    error::Result,
    geometry::Pose,
    localiser::{BayesLocaliser, PreparedSensorModel, SensorModel, Step, TrialRunner},
    recording::Recording,
    seed::{Seed, Stream},
};
use rand::RngExt;

/// A recording, and what the sensor model says of it.
pub(super) struct Filter<'a> {
    bayes: &'a Bayes,
    recording: &'a Recording,
    sensor: Box<dyn PreparedSensorModel + 'a>,
}

impl<'a> Filter<'a> {
    pub(super) fn new(
        bayes: &'a Bayes,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Self> {
        Ok(Self {
            bayes,
            recording,
            sensor: bayes.sensor.prepare(recording, snapshots)?,
        })
    }
}

impl TrialRunner for Filter<'_> {
    fn play(&self, trial: &[usize], _: Option<Pose>, stream: &mut Stream) -> Result<Vec<Step>> {
        let features = Seed(stream.random()).stream("sampled features");
        let Bayes {
            grid,
            motion,
            sites,
            ..
        } = self.bayes;
        let no_idea = Belief::uniform(grid.places())?;
        let sensor = Some(&*self.sensor);
        let mut robot = BayesLocaliser::new(grid, motion, no_idea, sensor, features)?;
        robot.play(self.recording, trial, sites)
    }
}
