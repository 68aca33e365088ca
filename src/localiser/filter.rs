//! The Bayes filter at work on a run: odometry moves the belief, what the sensors say corrects it.

use super::{
    PreparedSensorModel, Sites, Step,
    restart::{Restart, RestartConfig},
};
use crate::{
    belief::{BayesFilter, Belief, Grid, Hindsight, OdometryMotion},
    error::Result,
    geometry::Pose,
    recording::{Observation, Recording},
    seed::Stream,
};
use std::sync::Arc;

/// The Bayes filter with a sensor model: Thrun (1998), Table 1, driven by the odometry of a run.
pub struct BayesLocaliser<'a> {
    filter: BayesFilter,
    sensor: Option<&'a dyn PreparedSensorModel>,
    stream: Stream,
    last: Option<Pose>,
    /// Where the robot may be that knows nothing; there where somebody asks for it.
    no_idea: Option<Belief>,
    /// What was sensed on the way; there where somebody watches.
    hindsight: Option<Hindsight>,
    restart: Option<Restart>,
    /// Share of the belief to give up before the next observation.
    given_up: f64,
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
            no_idea: None,
            hindsight: None,
            restart: None,
            given_up: 0.0,
        })
    }

    /// The same robot, which also says how well its estimate explains what it has sensed ([`ratios`](Self::ratios)).
    ///
    /// # Errors
    /// None: a grid has cells.
    pub fn watched(mut self) -> Result<Self> {
        self.no_idea = Some(Belief::uniform(self.filter.grid().places())?);
        self.hindsight = Some(Hindsight::default());
        Ok(self)
    }

    /// The same robot, which gives up part of its belief where it explains what is sensed worse than it used to.
    ///
    /// # Errors
    /// Where a constant makes no sense.
    pub fn restarting(mut self, config: &RestartConfig) -> Result<Self> {
        if self.no_idea.is_none() {
            self.no_idea = Some(Belief::uniform(self.filter.grid().places())?);
        }
        self.restart = Some(Restart::new(config.clone())?);
        Ok(self)
    }

    /// How well a cell of the grid, with the way that has led there, explains the last observations ([`Hindsight::ratios`]); none where nobody
    /// [watches](Self::watched) or there is no sensor.
    pub fn ratios(&self, cell: usize) -> Option<Vec<f64>> {
        let hindsight = self.hindsight.as_ref().filter(|_| self.sensor.is_some())?;
        Some(hindsight.ratios(self.filter.grid(), cell))
    }

    /// Somebody carries the robot to where its wheels will say `odometry`, and it is not aware of it.
    pub fn carried(&mut self, odometry: Pose) {
        self.last = Some(odometry);
    }

    /// Takes in the next observation of the run, which is snapshot number `snapshot` to the sensor model: what odometry
    /// says since the last one, then what the sensors say.
    ///
    /// # Errors
    /// Where the likelihood is 0 wherever the belief has mass.
    pub fn observe(&mut self, snapshot: usize, observation: &Observation) -> Result<&Belief> {
        self.predict(observation)?;
        self.correct(snapshot)
    }

    /// The first half of [`observe`](Self::observe): what odometry says since the last observation.
    ///
    /// # Errors
    /// Where the odometry is no movement.
    pub fn predict(&mut self, observation: &Observation) -> Result<&Belief> {
        if let Some(no_idea) = self.no_idea.as_ref().filter(|_| self.given_up > 0.0) {
            self.filter.mix(no_idea, self.given_up)?;
            self.given_up = 0.0;
        }
        if let Some(last) = self.last.replace(observation.odometry) {
            let step = last.displacement_to(&observation.odometry);
            self.filter.predict(&step)?;
            if let Some(hindsight) = &mut self.hindsight {
                hindsight.moved(&step);
            }
        }
        Ok(self.filter.belief())
    }

    /// The second half: what the sensors say in snapshot number `snapshot`.
    ///
    /// # Errors
    /// Where the likelihood is 0 wherever the belief has mass.
    pub fn correct(&mut self, snapshot: usize) -> Result<&Belief> {
        if let Some(sensor) = self.sensor {
            let likelihood =
                sensor.log_likelihood(snapshot, self.filter.belief(), &mut self.stream)?;
            let by_belief = self.filter.correct(&likelihood)?;
            if let (Some(no_idea), Some(hindsight)) = (&self.no_idea, &mut self.hindsight) {
                hindsight.sensed(&likelihood, no_idea.log_predictive(&likelihood));
            }
            if let Some(restart) = &mut self.restart {
                self.given_up = restart.after(by_belief);
            }
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
