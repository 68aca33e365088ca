//! The filter with a recording before it.

use super::Bayes;
use crate::{
    belief::Belief,
    error::Result,
    geometry::Pose,
    localiser::{
        BayesLocaliser, Estimate, PreparedSensorModel, Probable, SensorModel, Step, TrialRunner,
    },
    recording::Recording,
    seed::{Seed, Stream},
};
use rand::RngExt;

/// A place that holds less than this share of the likeliest one's probability is left out of the posterior.
const NEGLIGIBLE: f64 = 1e-6;

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

    /// The belief of a place in the plane: its cells of all headings together.
    fn posterior(&self, belief: &Belief) -> Vec<Probable> {
        let sites = &self.bayes.sites;
        let mut mass = vec![0.0; sites.len()];
        for cells in belief.mass().chunks(sites.len()) {
            mass.iter_mut().zip(cells).for_each(|(m, cell)| *m += cell);
        }
        let least = NEGLIGIBLE * mass.iter().copied().fold(0.0, f64::max);
        let kept = || mass.iter().zip(sites).filter(|(m, _)| **m > least);
        let total: f64 = kept().map(|(m, _)| m).sum();
        kept().map(|(m, place)| (*place, m / total)).collect()
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
        let step = |&k: &usize| {
            let belief = robot.observe(k, &self.recording.observation(k))?;
            Ok(Step {
                estimate: Some(Estimate::Place(sites[belief.mode() % sites.len()])),
                posterior: self.posterior(belief),
            })
        };
        trial.iter().map(step).collect()
    }
}
