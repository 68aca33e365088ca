//! The rival of whoever has a range sensor: an ordinary occupancy map, given as a ROS map or made of the scans that the models
//! learned from, by its likelihood field, by its beam model and in particle filters.

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
    mapping::{
        LikelihoodField, LikelihoodFieldConfig, OccupancyMap, RangeSensors, drawn_maps,
        read_fitting, rendered_as,
    },
};
use std::{path::Path, sync::Arc};

/// Scatters of a beam's end about what it hit that are tried, in metres; where nothing can be validated, the first is taken.
const DEVIATIONS_M: [f64; 3] = [0.2, 0.1, 0.4];

/// Power of a scan's evidence where nothing tunes it: some beams of 36 are worth one.
const USUAL_SCALE: f64 = 0.125;

/// The map in tables.
pub(super) const MAP: &str = "occupancy map";

/// Its beam model, in results and in tables.
pub(super) const BEAM_MODEL: &str = "beam_model";
/// See [`BEAM_MODEL`].
pub(super) const BEAM: &str = "map, beam model";

/// Particles of Monte Carlo localisation at most: what users take, and what it takes to find a robot in a building.
pub(super) const PARTICLES: [usize; 2] = [5_000, 40_000];

/// Occupancy maps to choose from, and where the training scans were taken.
pub(super) struct RangeMaps<'a, 'b> {
    context: &'b MethodContext<'a>,
    /// Of the sensors that the models work from.
    sensors: RangeSensors,
    /// The map that was given; else those that the training scans draw, those of [`drawn_maps`].
    maps: Vec<Arc<OccupancyMap>>,
    /// Pose of each training place.
    training: Vec<Vec<Pose>>,
}

/// A likelihood field, and what its map takes on a robot.
pub(super) struct Field {
    field: Arc<LikelihoodField>,
    map: Arc<OccupancyMap>,
}

impl<'a, 'b> RangeMaps<'a, 'b> {
    /// From a ROS map, where `given` names one; else from scans. `None` where there is no range sensor to work from.
    ///
    /// # Errors
    /// Where the training part is not at hand, its scans make no map, or the given one can't be read or does not fit to them.
    pub fn new(context: &'b MethodContext<'a>, given: &Path) -> Result<Option<Self>> {
        let source = context.source()?;
        let (recording, training) = (&*source.recording, &source.training);
        let mut channels = context.mapped.input.channels.clone();
        channels.retain(|name| recording.channels().iter().any(|c| c.name == *name));
        let sensors = RangeSensors {
            channels,
            ..RangeSensors::default()
        };
        if sensors.beams(recording.channels()).is_err() {
            return Ok(None);
        }
        let maps = match given.as_os_str().is_empty() {
            true => drawn_maps(recording, training, &sensors)?,
            false => vec![read_fitting(given, recording, training, &sensors)?],
        };
        let poses = recording.poses();
        Ok(Some(Self {
            context,
            sensors,
            maps: maps.into_iter().map(Arc::new).collect(),
            training: training.iter().map(|&k| vec![poses[k]]).collect(),
        }))
    }

    /// The likelihood field of the map and the deviation that suit the validation part best.
    ///
    /// # Errors
    /// Where a map gives no field, or the validation part can't be asked.
    pub fn field(&self) -> Result<Field> {
        let of = |map: &Arc<OccupancyMap>, deviation_m: f64| {
            let config = LikelihoodFieldConfig {
                deviation_m,
                sensors: self.sensors.clone(),
                ..LikelihoodFieldConfig::default()
            };
            let field = Arc::new(LikelihoodField::new(map, &config)?);
            let alone = LikelihoodFieldModel::at_poses(&field, self.training.clone())?;
            let map = Arc::clone(map);
            Ok((Field { field, map }, alone))
        };
        let of = &of;
        let maps = self.maps.iter();
        let candidates = maps.flat_map(|map| DEVIATIONS_M.into_iter().map(move |m| of(map, m)));
        Ok(self.best(candidates)?.0)
    }

    /// The field in the filter.
    ///
    /// # Errors
    /// Where the grid is too large, or the sensor model fails.
    pub fn in_filter(&self, field: &Field) -> Result<Method<'a>> {
        let Field { field, map } = field;
        let alone = LikelihoodFieldModel::at_poses(field, self.training.clone())?;
        let at_cells = match self.poses_of_cells() {
            None => LikelihoodFieldModel::over_grid(field, &self.context.grid)?,
            Some(poses) => LikelihoodFieldModel::at_poses(field, poses)?,
        };
        let labels = ("likelihood_field", MAP);
        Ok(Method {
            plan: Some(Arc::clone(map)),
            ..self.method(labels, &alone, Box::new(at_cells), map.bytes())?
        })
    }

    /// The beam model in the filter, on scans rendered from the map. Which map, and whether scans in it are rendered with cones or
    /// as rays, the validation part says.
    ///
    /// # Errors
    /// As [`RangeMaps::in_filter`].
    pub fn beam_model(&self) -> Result<Method<'a>> {
        let recording = &self.context.source()?.recording;
        let channels = recording.channels();
        let rendered = rendered_as(recording, &self.sensors)?;
        let maps = self.maps.iter();
        let pairs = maps.flat_map(|map| rendered.iter().map(move |sensors| (map, sensors)));
        let candidates = pairs.map(|(map, sensors)| {
            let config = BeamModelConfig {
                sensors: sensors.clone(),
                ..BeamModelConfig::default()
            };
            let training = self.training.clone();
            let alone = BeamModel::at_poses(map, channels, &config, training)?;
            Ok(((map, config), alone))
        });
        let ((map, config), alone) = self.best(candidates)?;
        let at_cells = match self.poses_of_cells() {
            None => BeamModel::over_grid(map, channels, &config, &self.context.grid)?,
            Some(poses) => BeamModel::at_poses(map, channels, &config, poses)?,
        };
        let labels = (BEAM_MODEL, BEAM);
        self.method(labels, &alone, Box::new(at_cells), map.bytes())
    }

    /// Monte Carlo localisation with the field, which is what AMCL does; none along a route.
    ///
    /// # Errors
    /// Where the noise of odometry makes no sense.
    pub fn monte_carlo(&self, field: &Field, particles: usize) -> Result<Option<Method<'a>>> {
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
        let localiser = MonteCarlo::new(Arc::clone(&field.field), motion, grid, config)?
            .with_sensors_of(context.source()?.recording.channels())?;
        let name = match particles {
            5_000 => "monte_carlo".to_string(),
            _ => format!("monte_carlo_{particles}"),
        };
        let title = format!("map, {},000 particles", particles / 1000);
        Ok(Some(Method {
            other_bytes: field.map.bytes(),
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
        (name, title): (&str, &str),
        alone: &dyn SensorModel,
        at_cells: Box<dyn SensorModel + 'a>,
        map_bytes: usize,
    ) -> Result<Method<'a>> {
        // Along a route, where places are no poses, the poses of the places are on the robot as well.
        let poses_bytes = match &**self.context.grid.places() {
            Places::Plane(_) => 0,
            Places::Route(_) => 3 * size_of::<f32>() * self.training.len(),
        };
        Ok(Method {
            other_bytes: map_bytes + poses_bytes,
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
