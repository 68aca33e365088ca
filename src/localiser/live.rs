//! Localisation of a live robot, one observation at a time, without a dataset.

use super::sensor_model::{
    Bank, BankChoice, BankSet, EveryPose, EvidenceScale, LearnedFeatures, SensorModel,
};
use crate::{
    belief::{BayesFilter, Belief, Evidence, Grid, GridConfig, OdometryMotion, Places},
    detector::{MOST_VIEWS, Viewed},
    error::{Error, Result},
    geometry::{Displacement, Pose},
    model::{Model, ModelBank},
    recording::{Observation, history::Past},
    seed::{Seed, Stream},
};
use nalgebra::Matrix3;
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
    /// From so many places beside each snapshot, up to [`MOST_VIEWS`], the features are looked for again, and their answers averaged; where scans can be
    /// drawn anew.
    pub query_views: usize,
    /// Which sets of a bank of filters speak at every step.
    pub bank: BankChoice,
    /// Of the features that sampled evidence draws, and of the views.
    pub seed: u64,
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
        }
    }
}

/// Expected error of the mode from which on the robot counts as lost, metres.
pub const LOST_SPREAD_M: f64 = 1.0;

/// Evidence against the belief, in nats, from which on the robot counts as lost: a robot anywhere on the map explains what
/// was sensed lately e⁶ ≈ 400 times better than the belief does.
pub const LOST_EVIDENCE: f64 = 6.0;

/// Most evidence that a single observation gives for or against the belief, in nats, so that one reading out of order is not
/// enough.
const MAX_EVIDENCE: f64 = 2.0;

/// A robot that localises itself as it drives: the grid Bayes filter of Thrun (1998), Table 1, with a trained [`Model`] or
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
    /// Evidence for the belief since it was last refuted or in doubt, nats: 0 or below.
    evidence: f64,
}

impl LiveLocaliser {
    /// A robot with a trained model, and the defaults of [`LiveConfig`].
    ///
    /// # Errors
    /// As [`LiveLocaliser::with_config`].
    pub fn new(model: &Model) -> Result<Self> {
        Self::with_config(model, &LiveConfig::default())
    }

    /// A robot with a trained model.
    ///
    /// # Errors
    /// Where a constant makes no sense (the call is wrong), the model has fewer places than neighbours that its map asks for,
    /// or the grid would have too many cells.
    pub fn with_config(model: &Model, config: &LiveConfig) -> Result<Self> {
        let grid = Arc::new(Grid::over(&model.places(), &config.grid)?);
        let sensor = sensor_of(model, &grid, config)?;
        let mut robot = Self::of_model(model, &grid, sensor, config)?;
        robot.scale = scale_of(model, config)?;
        Ok(robot)
    }

    /// A robot with a bank of filters, of which it uses at every step the set that promises most.
    ///
    /// # Errors
    /// As [`LiveLocaliser::with_config`].
    pub fn with_bank(bank: &ModelBank, config: &LiveConfig) -> Result<Self> {
        let Some(first) = bank.sets().first() else {
            return Err(Error::usage("bank: no set; expected one or more"));
        };
        let grid = Arc::new(Grid::over(&first.places(), &config.grid)?);
        let set = |model: &Model| {
            Ok(BankSet {
                name: model.header.prior.to_string(),
                sensor: Arc::from(sensor_of(model, &grid, config)?),
                scale: scale_of(model, config)?,
                held_apart: Arc::new(bank.held_apart(model, grid.places())?),
            })
        };
        let sets: Vec<BankSet<Arc<dyn SensorModel>>> =
            bank.sets().iter().map(set).collect::<Result<_>>()?;
        let seed = Seed(config.seed);
        let sensor = Bank::new(sets, config.bank, seed)?;
        Self::of_model(first, &grid, Box::new(sensor), config)
    }

    /// A robot with the odometry and the memory of a model.
    fn of_model(
        model: &Model,
        grid: &Arc<Grid>,
        sensor: Box<dyn SensorModel>,
        config: &LiveConfig,
    ) -> Result<Self> {
        let motion = config.motion.as_ref().unwrap_or(&model.header.motion);
        let stream = Seed(config.seed).stream("sampled features");
        let mut robot = Self::from_parts(grid, motion.clone(), sensor, stream)?;
        robot.past = model.past();
        Ok(robot)
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
            evidence: 0.0,
        })
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
        self.evidence = 0.0;
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
        self.filter.predict(step)
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
            self.filter.predict(&last.displacement_to(odometry))?;
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
    /// ([`Model::history_m`]) finds by the observations' odometry where they were taken, so it must be there.
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
        let ratio = (log_predictive - anywhere).clamp(-MAX_EVIDENCE, MAX_EVIDENCE);
        // Page, *Continuous inspection schemes*, Biometrika 41 (1954): what speaks for the belief is not saved up.
        self.evidence = (self.evidence + ratio).clamp(-2.0 * LOST_EVIDENCE, 0.0);
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

    /// [`Belief::mean`]: mean of x and y, circular mean of the heading.
    pub fn mean(&self) -> Pose {
        self.belief().mean()
    }

    /// [`Belief::covariance`] of x, y (m²) and heading (rad²) about that mean.
    pub fn covariance(&self) -> Matrix3<f64> {
        self.belief().covariance()
    }

    /// The centre of the cell of the largest mass.
    pub fn mode(&self) -> Pose {
        self.belief().places().pose(self.belief().mode())
    }

    /// [`Belief::entropy`], in nats.
    pub fn entropy(&self) -> f64 {
        self.belief().entropy()
    }

    /// Mass of all places no farther than `radius_m` from the mode, any heading: how sure the robot is of it.
    pub fn mass_within(&self, radius_m: f64) -> f64 {
        let (belief, mode) = (self.belief(), self.belief().mode());
        belief.mass_within_m(belief.places(), mode, radius_m)
    }

    /// Expected distance from the mode to the truth, as the belief has it, in metres.
    pub fn spread_m(&self) -> f64 {
        let (belief, mode) = (self.belief(), self.belief().mode());
        belief.expected_error_m(belief.places(), mode)
    }

    /// Evidence that the sensors give against the belief, in nats, 0 or more. Each observation z adds
    /// ln [P(z | anywhere on the grid) / P(z | belief)], within ±2; the sum never falls below 0 nor rises above twice
    /// [`LOST_EVIDENCE`], so that it is about the last few observations.
    ///
    /// This is Page's test (1954) for the moment from which on a belief predicts what is sensed worse than knowing nothing. As
    /// long as the robot is where it believes, the belief predicts better, and the sum stays near 0. A robot that was carried
    /// away, or has left the map, is sure of places where it is not; there its sensors contradict it again and again.
    pub fn contradiction(&self) -> f64 {
        -self.evidence
    }

    /// Is the robot lost? It is while its belief is spread (the expected error of the mode, [`LiveLocaliser::spread_m`], is
    /// above [`LOST_SPREAD_M`]), or the sensors contradict it ([`LiveLocaliser::contradiction`] is [`LOST_EVIDENCE`] or more).
    ///
    /// It needs three observations at the least to contradict a sure belief. Where nothing can be told apart, sensors don't
    /// contradict anything: a robot that was carried from one such place to another is not noticed before it comes to
    /// others.
    pub fn lost(&self) -> bool {
        self.spread_m() > LOST_SPREAD_M || self.contradiction() >= LOST_EVIDENCE
    }
}

/// What a model's answers say at the cells of a grid.
fn sensor_of(model: &Model, grid: &Grid, config: &LiveConfig) -> Result<Box<dyn SensorModel>> {
    if config.query_views > MOST_VIEWS {
        return Err(Error::usage(format!(
            "query_views = {}: expected at most {MOST_VIEWS}",
            config.query_views
        )));
    }
    let detector = Viewed::new(model.detector(), config.query_views, Seed(config.seed));
    let detector = Arc::new(detector);
    let at_every_pose = match config.evidence {
        Evidence::MeanField => model.code_map(grid, false)?,
        _ => None,
    };
    Ok(match at_every_pose {
        Some(map) => Box::new(EveryPose::new(detector, Arc::new(map))?),
        None => {
            let map = Arc::new(model.map()?.at(grid.places())?);
            Box::new(LearnedFeatures::new(detector, map, config.evidence)?)
        }
    })
}

/// How much a model's evidence counts; none: as much as it says.
fn scale_of(model: &Model, config: &LiveConfig) -> Result<Option<EvidenceScale>> {
    match config.evidence_scale.or(model.header.evidence_scale) {
        Some(scale) if !(scale.is_finite() && scale > 0.0) => Err(Error::usage(format!(
            "evidence_scale = {scale}: expected a number above 0"
        ))),
        scale => Ok(scale.map(EvidenceScale::of)),
    }
}

#[cfg(test)]
mod tests;
