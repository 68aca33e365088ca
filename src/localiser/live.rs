//! Localisation of a live robot, one observation at a time, without a dataset.

mod confidence;
mod of_model;

pub use confidence::LEAST_MODE;

use super::{
    lost::LostConfig,
    restart::{Restart, RestartConfig},
    sensor_model::{BankChoice, EvidenceScale, SensorModel},
};
use crate::{
    belief::{BayesFilter, Belief, Evidence, Grid, GridConfig, Hindsight, OdometryMotion, Places},
    error::{Error, Result},
    geometry::{Displacement, Pose},
    recording::{Observation, history::Past},
    seed::Stream,
};
use ndarray::ArrayView1;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How a [`LiveLocaliser`] puts a model to use.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LiveConfig {
    /// Cells of the belief.
    pub grid: GridConfig,
    /// How the detector's answers become likelihoods.
    pub evidence: Evidence,
    /// What the filter believes of odometry; none: what the model learned of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<OdometryMotion>,
    /// Power of a snapshot's evidence, above 0; none: as tuned when the model was trained, or 1, at its word, where it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub evidence_scale: Option<f64>,
    /// From so many places beside each snapshot, up to [`MOST_VIEWS`](crate::detector::MOST_VIEWS), the features are looked for again, and their answers averaged; where scans can be
    /// drawn anew.
    pub query_views: usize,
    /// Which sets of a bank of filters speak at every step.
    pub bank: BankChoice,
    /// Of the features that sampled evidence draws, and of the views.
    pub seed: u64,
    /// When the robot counts as lost; none: as tuned when the model was trained, or the usual constants where it was not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost: Option<LostConfig>,
    /// How much of the belief is given up where sensors are explained worse than they used to be; none: nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restart: Option<RestartConfig>,
}

impl Default for LiveConfig {
    fn default() -> Self {
        Self {
            grid: GridConfig::default(),
            evidence: Evidence::MeanField,
            motion: None,
            evidence_scale: None,
            query_views: 0,
            bank: BankChoice::default(),
            seed: 0,
            lost: None,
            restart: None,
        }
    }
}

/// A robot that localises itself as it drives: the grid Bayes filter of Thrun (1998), Table 1, with a trained [`Model`](crate::model::Model) or
/// any other [`SensorModel`].
///
/// Give it an [`Observation`] whenever there is one ([`LiveLocaliser::observe`]), and ask it for the pose and how sure it is
/// of it. At first it has no idea where it is (global localisation); [`LiveLocaliser::start_at`] gives it a known start.
/// Where the model's places lie along a route, poses are places along it: `x_m` is the coordinate in metres, the rest is 0.
///
/// ```no_run
/// use ballmark::{geometry::Pose, localiser::LiveLocaliser, model::Model, recording::Observation};
/// # fn laser_scan() -> Vec<f32> { Vec::new() }
/// # fn wheel_odometry() -> Pose { Pose::default() }
/// let model = Model::read("corridor.safetensors".as_ref())?;
/// let mut robot = LiveLocaliser::new(&model)?;
/// for tick in 0..100 {
///     let scan = laser_scan(); // the values of `model.header.channels`, side by side
///     let observation = Observation::new(&model.header.channels, &scan, 0.1 * f64::from(tick), wheel_odometry())?;
///     robot.observe(&observation)?;
///     if !robot.lost() {
///         println!("{:?} ± {:.2} m", robot.mean(), robot.covariance()[(0, 0)].sqrt());
///     }
/// }
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct LiveLocaliser {
    filter: BayesFilter,
    sensor: Box<dyn SensorModel>,
    /// How much its evidence counts; none: as much as it says.
    scale: Option<EvidenceScale>,
    stream: Stream,
    odometry: Option<Pose>,
    /// What was sensed in the last metres, where the model works from it.
    past: Option<Past>,
    no_idea: Belief,
    lost: LostConfig,
    /// What was sensed on the way.
    hindsight: Hindsight,
    restart: Option<Restart>,
    /// Share of the belief to give up before the next observation.
    given_up: f64,
}

impl LiveLocaliser {
    /// The same robot, which counts as lost when these constants say so.
    ///
    /// # Errors
    /// Where one makes no sense (the call is wrong).
    pub fn counting_as_lost(mut self, lost: LostConfig) -> Result<Self> {
        lost.check()?;
        self.lost = lost;
        Ok(self)
    }

    /// The same robot, which gives up a little of its belief where it explains what is sensed worse than it used to, so that it
    /// finds itself again after it was carried away.
    ///
    /// # Errors
    /// Where a constant makes no sense (the call is wrong).
    pub fn restarting(mut self, restart: RestartConfig) -> Result<Self> {
        self.restart = Some(Restart::new(restart)?);
        Ok(self)
    }

    /// A robot with any sensor model, made for the cells of `grid`. `stream` is for models that draw random numbers.
    ///
    /// # Errors
    /// Where `motion` makes no sense.
    pub fn from_parts(
        grid: &Arc<Grid>,
        motion: OdometryMotion,
        sensor: Box<dyn SensorModel>,
        stream: Stream,
    ) -> Result<Self> {
        let no_idea = Belief::uniform(grid.places())?;
        Ok(Self {
            filter: BayesFilter::new(grid, motion, no_idea.clone())?,
            sensor,
            scale: None,
            stream,
            odometry: None,
            past: None,
            no_idea,
            lost: LostConfig::default(),
            hindsight: Hindsight::default(),
            restart: None,
            given_up: 0.0,
        })
    }

    /// The same robot, the evidence of whose sensors counts as much as that; on top of it the share that no model explains.
    pub fn scaled(self, scale: EvidenceScale) -> Self {
        Self {
            scale: Some(scale),
            ..self
        }
    }

    /// Begins anew at a known pose: a Gaussian around it with standard deviations in metres along the ground and radians of
    /// heading. Along a route `x_m` is the coordinate.
    ///
    /// # Errors
    /// Where the pose is not finite, off the grid, or a spread isn't above 0 (the call is wrong).
    pub fn start_at(&mut self, pose: Pose, spread_m: f64, spread_rad: f64) -> Result<()> {
        let places = self.filter.grid().places();
        let start = match **places {
            Places::Route(_) => Places::Route(vec![pose.x_m]),
            Places::Plane(_) => Places::Plane(vec![pose]),
        };
        if !pose.is_finite() || self.filter.grid().cell_at(&start, 0).is_none() {
            return Err(Error::work(format!(
                "start: {pose:?} is off the grid; expected a place of the map"
            )));
        }
        let belief = Belief::around(places, &start, 0, spread_m, spread_rad)?;
        self.restart(belief)
    }

    /// Begins anew with any belief over the cells of the grid, and forgets odometry, evidence and what was sensed before.
    ///
    /// # Errors
    /// Where the belief is about other places.
    pub fn restart(&mut self, belief: Belief) -> Result<()> {
        self.filter.restart(belief)?;
        self.odometry = None;
        self.hindsight.forget();
        self.given_up = 0.0;
        if let Some(restart) = &mut self.restart {
            restart.forget();
        }
        if let Some(past) = &mut self.past {
            past.forget();
        }
        Ok(())
    }

    /// Moves the belief along with the robot, by a movement in the robot's own frame (eq. 19).
    ///
    /// # Errors
    /// Where the movement is not finite: the belief stays as it was.
    pub fn predict(&mut self, step: &Displacement) -> Result<()> {
        self.filter.predict(step)?;
        self.hindsight.moved(step);
        Ok(())
    }

    /// Moves the belief by what odometry has reckoned since it was last asked; the first pose only sets the start. Wheels that
    /// report a cumulative pose are used like this, those that report movements by [`LiveLocaliser::predict`].
    ///
    /// # Errors
    /// Where the pose is not finite: the belief stays as it was.
    pub fn predict_to(&mut self, odometry: &Pose) -> Result<()> {
        if !odometry.is_finite() {
            return Err(Error::work(format!(
                "odometry: {odometry:?}; expected finite numbers"
            )));
        }
        if let Some(last) = self.odometry {
            self.predict(&last.displacement_to(odometry))?;
        }
        self.odometry = Some(*odometry);
        Ok(())
    }

    /// Corrects the belief by what the sensors say (eq. 17), and returns ln P(z) = ln Σ_ξ Bel(ξ) P(z|ξ): how likely the belief
    /// held this observation to be, in nats, up to a constant that does not depend on the belief.
    ///
    /// With learned features that is, by the rule of evidence, what [`Evidence::predictive_log_likelihood`] says: the
    /// probability of the drawn features (sampled), the probability that features drawn from belief and map are those drawn
    /// from the filters (Jeffrey, likelihood), or exp of the mean cross-entropy (mean field), each without a constant. With a
    /// raw kernel the constant is the distance to the most similar scan. Where the evidence is scaled, all of this is of the
    /// scaled likelihood, whose best is 1.
    ///
    /// Odometry is not looked at: that is [`LiveLocaliser::predict`]'s part. A model that works from the readings of the last metres
    /// ([`Model::history_m`](crate::model::Model::history_m)) finds by the observations' odometry where they were taken, so it must be there.
    ///
    /// # Errors
    /// Where the observation lacks a sensor or has another number of values (the message says which), or is held impossible
    /// wherever the belief has mass: the belief stays as it was.
    pub fn correct(&mut self, observation: &Observation) -> Result<f64> {
        let Some(past) = &mut self.past else {
            return self.correct_by(observation);
        };
        observation.check()?; // what is refused must not be remembered
        let (channels, values) = past.observed(observation);
        self.correct_by(&Observation {
            channels: &channels,
            values: ArrayView1::from(&values),
            stamp_s: observation.stamp_s,
            odometry: observation.odometry,
            compass_rad: observation.compass_rad,
        })
    }

    /// The same of an observation as the sensor model takes it.
    fn correct_by(&mut self, observation: &Observation) -> Result<f64> {
        self.filter.mix(&self.no_idea, self.given_up)?;
        self.given_up = 0.0; // once, whatever comes of the observation
        let belief = self.filter.belief();
        let mut log_likelihood =
            self.sensor
                .log_likelihood(observation, belief, &mut self.stream)?;
        if let Some(scale) = self.scale {
            scale.apply(&mut log_likelihood);
        }
        // ln Σ_ξ Bel(ξ) P(z|ξ), from the model as it is scaled, and the same for a robot that may be anywhere.
        let log_predictive = self.filter.correct(&log_likelihood)?;
        let anywhere = self.no_idea.log_predictive(&log_likelihood);
        self.hindsight.sensed(&log_likelihood, anywhere);
        self.given_up = match &mut self.restart {
            Some(restart) => restart.after(log_predictive),
            None => 0.0,
        };
        Ok(log_predictive)
    }

    /// [`LiveLocaliser::predict_to`] the observation's odometry, then [`LiveLocaliser::correct`], with its result.
    ///
    /// # Errors
    /// As these two.
    pub fn observe(&mut self, observation: &Observation) -> Result<f64> {
        self.predict_to(&observation.odometry)?;
        self.correct(observation)
    }

    /// The belief, over the cells of the grid.
    pub fn belief(&self) -> &Belief {
        self.filter.belief()
    }

    /// The cells.
    pub fn grid(&self) -> &Arc<Grid> {
        self.filter.grid()
    }
}

#[cfg(test)]
mod tests;
