//! The rival of whoever has a range sensor: an ordinary occupancy map of the scans that the models learned from, read as a
//! likelihood field.

use super::{method::Method, methods::MethodContext};
use crate::{
    belief::{Places, Uncertainty},
    error::Result,
    geometry::Pose,
    localiser::{
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

/// What a user of a range sensor has.
pub(super) struct MapMethods<'a> {
    /// The map's likelihood field in the filter.
    pub field: Method<'a>,
    /// The beam model on scans rendered from the map, or why there is none.
    pub beam: Result<Method<'a>>,
    /// The same field in particle filters, in the plane.
    pub particles: Vec<Method<'a>>,
}

/// Particles of Monte Carlo localisation at most: what users take, and what it takes to find a robot in a building.
const PARTICLES: [usize; 2] = [5_000, 40_000];

/// The occupancy map, where the models work from a range sensor.
pub(super) fn map_methods<'a>(context: &MethodContext<'a>) -> Result<Option<MapMethods<'a>>> {
    let source = context.source()?;
    if !has_ranges(&source.recording, &context.mapped.input.channels) {
        return Ok(None);
    }
    let config = OccupancyMapConfig::default();
    let map = OccupancyMap::from_scans(&source.recording, &source.training, &config)?;
    let poses = source.recording.poses();
    let training: Vec<_> = source.training.iter().map(|&k| vec![poses[k]]).collect();
    let alone = |deviation_m: f64| -> Result<(Arc<LikelihoodField>, LikelihoodFieldModel)> {
        let config = LikelihoodFieldConfig {
            deviation_m,
            ..LikelihoodFieldConfig::default()
        };
        let field = Arc::new(LikelihoodField::new(&map, &config)?);
        let model = LikelihoodFieldModel::at_poses(&field, training.clone())?;
        Ok((field, model))
    };
    let mut best = None;
    for deviation_m in DEVIATIONS_M {
        let candidate = alone(deviation_m)?;
        let error_m = validation_error_m(context, &candidate.1)?;
        if best.as_ref().is_none_or(|(least_m, _)| error_m < *least_m) {
            best = Some((error_m, candidate));
        }
    }
    let Some((_, (field, alone))) = best else {
        return Ok(None);
    };
    let at_cells = match &**context.grid.places() {
        Places::Plane(_) => LikelihoodFieldModel::over_grid(&field, &context.grid)?,
        Places::Route(cells) => {
            let near = |cell: usize| context.cells.of(cell).iter();
            let of_cell = |cell: usize| near(cell).map(|&k| training[k][0]).collect();
            LikelihoodFieldModel::at_poses(&field, (0..cells.len()).map(of_cell).collect())?
        }
    };
    let method =
        context.judged_sensor_model("likelihood_field", MAP, &alone, Box::new(at_cells))?;
    // Along a route, where places are no poses, the poses of the places are on the robot as well.
    let poses_bytes = match &**context.grid.places() {
        Places::Plane(_) => 0,
        Places::Route(_) => 3 * size_of::<f32>() * training.len(),
    };
    let field_in_filter = Method {
        other_bytes: map.bytes() + poses_bytes,
        usual_scale: USUAL_SCALE,
        ..method
    };
    let beam = beam_model(context, &map, &training).map(|method| Method {
        other_bytes: map.bytes() + poses_bytes,
        usual_scale: USUAL_SCALE,
        ..method
    });
    let mut particles = Vec::new();
    if let Places::Plane(_) = &**context.grid.places() {
        for count in PARTICLES {
            particles.push(Method {
                other_bytes: map.bytes(),
                ..monte_carlo(context, &field, count)?
            });
        }
    }
    Ok(Some(MapMethods {
        field: field_in_filter,
        beam,
        particles,
    }))
}

/// The beam model on scans that are rendered from the map: in the plane at every cell, along a route at the poses near one.
fn beam_model<'a>(
    context: &MethodContext<'a>,
    map: &OccupancyMap,
    training: &[Vec<Pose>],
) -> Result<Method<'a>> {
    let source = context.source()?;
    let (channels, config) = (source.recording.channels(), BeamModelConfig::default());
    let alone = BeamModel::at_poses(map, channels, &config, training.to_vec())?;
    let at_cells = match &**context.grid.places() {
        Places::Plane(_) => BeamModel::over_grid(map, channels, &config, &context.grid)?,
        Places::Route(cells) => {
            let near = |cell: usize| context.cells.of(cell).iter();
            let of_cell = |cell: usize| near(cell).map(|&k| training[k][0]).collect();
            let poses = (0..cells.len()).map(of_cell).collect();
            BeamModel::at_poses(map, channels, &config, poses)?
        }
    };
    context.judged_sensor_model(BEAM_MODEL, BEAM, &alone, Box::new(at_cells))
}

/// Monte Carlo localisation with the map's field: what AMCL does.
fn monte_carlo<'a>(
    context: &MethodContext<'a>,
    field: &Arc<LikelihoodField>,
    particles: usize,
) -> Result<Method<'a>> {
    let config = MonteCarloConfig {
        particles,
        start_spread_m: context.config.start_spread_m,
        start_spread_rad: context.config.start_spread_rad,
        ..MonteCarloConfig::default()
    };
    let motion = context.config.motion.as_ref();
    let motion = motion.unwrap_or(&context.mapped.motion).clone();
    let localiser = MonteCarlo::new(Arc::clone(field), motion, Arc::clone(&context.grid), config)?
        .with_sensors_of(context.source()?.recording.channels())?;
    let name = match particles {
        5_000 => "monte_carlo".to_string(),
        _ => format!("monte_carlo_{particles}"),
    };
    let title = format!("map, {},000 particles", particles / 1000);
    Ok(context.localiser(&name, &title, Box::new(localiser)))
}

/// Error that one snapshot of the validation part leaves of no idea at all, at the power that suits it best, in metres.
fn validation_error_m(context: &MethodContext, alone: &LikelihoodFieldModel) -> Result<f64> {
    let tuned = context.priors.iter().zip(context.tuned_powers(alone)?);
    let mut global = tuned.filter(|(prior, _)| **prior == Uncertainty::Global);
    Ok(global
        .next()
        .map_or(f64::INFINITY, |(_, (_, error_m))| error_m))
}
