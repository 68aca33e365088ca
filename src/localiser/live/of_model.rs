//! Live robots made of trained models, one or a bank of them.

use super::{LiveConfig, LiveLocaliser};
use crate::{
    belief::{Evidence, Grid},
    detector::{MOST_VIEWS, Viewed},
    error::{Error, Result},
    localiser::sensor_model::{
        Bank, BankSet, EveryPose, EvidenceScale, LearnedFeatures, SensorModel,
    },
    model::{Model, ModelBank},
    seed::Seed,
};
use std::sync::Arc;

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
        let lost = config.lost.as_ref().or(model.header.lost.as_ref());
        robot = robot.counting_as_lost(lost.cloned().unwrap_or_default())?;
        match &config.restart {
            Some(restart) => robot.restarting(restart.clone()),
            None => Ok(robot),
        }
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
