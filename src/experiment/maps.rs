//! The rival of whoever has a range sensor: an ordinary occupancy map of the scans that the models learned from, read as a
//! likelihood field.

use super::{method::Method, methods::MethodContext};
use crate::{
    belief::{Places, Uncertainty},
    error::{Error, Result},
    geometry::Pose,
    localiser::{
        SensorModel,
        monte_carlo::{MonteCarlo, MonteCarloConfig},
        sensor_model::{BeamModel, BeamModelConfig, LikelihoodFieldModel},
    },
    mapping::{LikelihoodField, LikelihoodFieldConfig, OccupancyMap, OccupancyMapConfig},
    recording::Recording,
};
use std::sync::Arc;

/// Scatters of a beam's end about what it hit that are tried, in metres; where nothing can be validated, the first is taken.
const DEVIATIONS_M: [f64; 3] = [0.2, 0.1, 0.4];

/// Power of a scan's evidence where nothing tunes it: some beams of 36 are worth one.
const USUAL_SCALE: f64 = 0.125;

/// Does a recording have a range sensor whose beams' directions are known, among the channels named (none: all)?
pub(super) fn has_ranges(recording: &Recording, channels: &[String]) -> bool {
    let wanted = |name: &String| channels.is_empty() || channels.contains(name);
    let mut all = recording.channels().iter();
    all.any(|c| wanted(&c.name) && c.unit == "m" && c.bearing_rad.is_some())
}

/// The map in tables.
pub(super) const MAP: &str = "occupancy map";

/// Its beam model, in results and in tables.
pub(super) const BEAM_MODEL: &str = "beam_model";
/// See [`BEAM_MODEL`].
pub(super) const BEAM: &str = "map, beam model";

/// Particles of Monte Carlo localisation at most: what users take, and what it takes to find a robot in a building.
pub(super) const PARTICLES: [usize; 2] = [5_000, 40_000];

/// The occupancy map of the training scans, and where they were taken.
pub(super) struct MapOfScans<'a, 'b> {
    context: &'b MethodContext<'a>,
    map: OccupancyMap,
    /// Pose of each training place.
    training: Vec<Vec<Pose>>,
}

impl<'a, 'b> MapOfScans<'a, 'b> {
    /// `None` where there is no range sensor to work from.
    ///
    /// # Errors
    /// Where the training part is not at hand, or its scans make no map.
    pub fn new(context: &'b MethodContext<'a>) -> Result<Option<Self>> {
        let source = context.source()?;
        if !has_ranges(&source.recording, &context.mapped.input.channels) {
            return Ok(None);
        }
        let config = OccupancyMapConfig::default();
        let map = OccupancyMap::from_scans(&source.recording, &source.training, &config)?;
        let poses = source.recording.poses();
        Ok(Some(Self {
            context,
            map,
            training: source.training.iter().map(|&k| vec![poses[k]]).collect(),
        }))
    }

    /// The map's likelihood field, of the deviation that suits the validation part best.
    ///
    /// # Errors
    /// Where the map gives no field, or the validation part can't be asked.
    pub fn field(&self) -> Result<Arc<LikelihoodField>> {
        let of = |deviation_m: f64| {
            let config = LikelihoodFieldConfig {
                deviation_m,
                ..LikelihoodFieldConfig::default()
            };
            let field = Arc::new(LikelihoodField::new(&self.map, &config)?);
            let alone = LikelihoodFieldModel::at_poses(&field, self.training.clone())?;
            Ok((field, alone))
        };
        let candidates = DEVIATIONS_M.into_iter().map(of);
        Ok(self.best(candidates)?.0)
    }

    /// The field in the filter.
    ///
    /// # Errors
    /// Where the grid is too large, or the sensor model fails.
    pub fn in_filter(&self, field: &Arc<LikelihoodField>) -> Result<Method<'a>> {
        let alone = LikelihoodFieldModel::at_poses(field, self.training.clone())?;
        let at_cells = match self.poses_of_cells() {
            None => LikelihoodFieldModel::over_grid(field, &self.context.grid)?,
            Some(poses) => LikelihoodFieldModel::at_poses(field, poses)?,
        };
        self.method("likelihood_field", MAP, &alone, Box::new(at_cells))
    }

    /// The beam model in the filter, on scans rendered from the map. The map is drawn of rays, whatever opening a sensor has;
    /// whether scans in it are rendered with cones or as rays, too, the validation part says.
    ///
    /// # Errors
    /// As [`MapOfScans::in_filter`].
    pub fn beam_model(&self) -> Result<Method<'a>> {
        let channels = self.context.source()?.recording.channels();
        let usual = BeamModelConfig::default();
        let as_rays = BeamModelConfig {
            sensors: usual.sensors.as_rays(),
            ..usual.clone()
        };
        let has_cones = usual.sensors.beams(channels)?;
        let has_cones = has_cones.iter().any(|beam| beam.opening_rad > 0.0);
        let configs = [as_rays, usual].into_iter();
        let candidates = configs.take(1 + usize::from(has_cones)).map(|config| {
            let training = self.training.clone();
            let alone = BeamModel::at_poses(&self.map, channels, &config, training)?;
            Ok((config, alone))
        });
        let (config, alone) = self.best(candidates)?;
        let at_cells = match self.poses_of_cells() {
            None => BeamModel::over_grid(&self.map, channels, &config, &self.context.grid)?,
            Some(poses) => BeamModel::at_poses(&self.map, channels, &config, poses)?,
        };
        self.method(BEAM_MODEL, BEAM, &alone, Box::new(at_cells))
    }

    /// Monte Carlo localisation with the field, which is what AMCL does; none along a route.
    ///
    /// # Errors
    /// Where the noise of odometry makes no sense.
    pub fn monte_carlo(
        &self,
        field: &Arc<LikelihoodField>,
        particles: usize,
    ) -> Result<Option<Method<'a>>> {
        let context = self.context;
        if let Places::Route(_) = **context.grid.places() {
            return Ok(None);
        }
        let config = MonteCarloConfig {
            particles,
            start_spread_m: context.config.start_spread_m,
            start_spread_rad: context.config.start_spread_rad,
            ..MonteCarloConfig::default()
        };
        let motion = context.config.motion.as_ref();
        let motion = motion.unwrap_or(&context.mapped.motion).clone();
        let grid = Arc::clone(&context.grid);
        let localiser = MonteCarlo::new(Arc::clone(field), motion, grid, config)?
            .with_sensors_of(context.source()?.recording.channels())?;
        let name = match particles {
            5_000 => "monte_carlo".to_string(),
            _ => format!("monte_carlo_{particles}"),
        };
        let title = format!("map, {},000 particles", particles / 1000);
        Ok(Some(Method {
            other_bytes: self.map.bytes(),
            ..context.localiser(&name, &title, Box::new(localiser))
        }))
    }

    /// Along a route, the poses of the training places near each cell; in the plane a cell has its own.
    fn poses_of_cells(&self) -> Option<Vec<Vec<Pose>>> {
        let Places::Route(cells) = &**self.context.grid.places() else {
            return None;
        };
        let of_cell = |cell: usize| {
            let near = self.context.cells.of(cell).iter();
            near.map(|&k| self.training[k][0]).collect()
        };
        Some((0..cells.len()).map(of_cell).collect())
    }

    fn method(
        &self,
        name: &str,
        title: &str,
        alone: &dyn SensorModel,
        at_cells: Box<dyn SensorModel + 'a>,
    ) -> Result<Method<'a>> {
        // Along a route, where places are no poses, the poses of the places are on the robot as well.
        let poses_bytes = match &**self.context.grid.places() {
            Places::Plane(_) => 0,
            Places::Route(_) => 3 * size_of::<f32>() * self.training.len(),
        };
        Ok(Method {
            other_bytes: self.map.bytes() + poses_bytes,
            usual_scale: USUAL_SCALE,
            ..self
                .context
                .judged_sensor_model(name, title, alone, at_cells)?
        })
    }

    /// Of some constants and their sensor models at the training places, those that leave least error of no idea at all after
    /// one snapshot of the validation part, at the power that suits each best; the first where nothing can be validated.
    fn best<C, M: SensorModel>(
        &self,
        candidates: impl Iterator<Item = Result<(C, M)>>,
    ) -> Result<(C, M)> {
        let mut best: Option<(f64, (C, M))> = None;
        for candidate in candidates {
            let candidate = candidate?;
            let powers = self.context.tuned_powers(&candidate.1)?;
            let of_priors = self.context.priors.iter().zip(powers);
            let mut global = of_priors.filter(|(prior, _)| **prior == Uncertainty::Global);
            let error_m = global.next().map_or(f64::INFINITY, |(_, (_, m))| m);
            if best.as_ref().is_none_or(|(least_m, _)| error_m < *least_m) {
                best = Some((error_m, candidate));
            }
        }
        let best = best.map(|(_, candidate)| candidate);
        best.ok_or_else(|| Error::work("no constants to choose from"))
    }
}
