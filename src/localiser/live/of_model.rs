//! Live robots made of trained models, one or a bank of them.

use super::{LiveConfig, LiveLocaliser};
use crate::{
    belief::Grid,
    error::{Error, Result},
    localiser::sensor_model::{Bank, BankSet, SensorModel, scale_of, sensor_of},
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
        let sensor = as_configured(model, &grid, config)?;
        let mut robot = Self::of_model(model, &grid, sensor, config)?;
        if let (None, Some(tuned)) = (&config.lost, &model.header.lost) {
            robot = robot.counting_as_lost(tuned.clone())?;
        }
        Ok(match scale_of(model, config.evidence_scale)? {
            Some(scale) => robot.scaled(scale),
            None => robot,
        })
    }

    /// A robot with a bank of filters, of which it uses at every step the set that promises most. It counts as lost by the usual
    /// constants, where the configuration says none: those of its sets were tuned for each set alone.
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
                sensor: Arc::from(as_configured(model, &grid, config)?),
                scale: scale_of(model, config.evidence_scale)?,
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
        robot = robot.counting_as_lost(config.lost.clone().unwrap_or_default())?;
        match &config.restart {
            Some(restart) => robot.restarting(restart.clone()),
            None => Ok(robot),
        }
    }
}

/// What a model's answers say at the cells of a grid, as a configuration has it look at them.
fn as_configured(model: &Model, grid: &Grid, config: &LiveConfig) -> Result<Box<dyn SensorModel>> {
    let seed = Seed(config.seed);
    sensor_of(model, grid, config.evidence, config.query_views, seed)
}
