//! The beam model of a range scan as a sensor model: every beam against the range that the map predicts for it.

mod mixture;

pub use mixture::BeamModelConfig;

use super::{SensorModel, ln_mean_exp};
use crate::{
    belief::{Belief, Grid, Places},
    error::{Error, Result},
    geometry::Pose,
    mapping::{OccupancyMap, RangeBeam, RenderConfig, Rendered, Renderer},
    recording::{Channel, Observation, check_width},
    seed::Stream,
};
use mixture::{Measured, Mixture, Within};
use ndarray::Array2;
use rayon::prelude::*;
use std::sync::Arc;

/// ln p(z | ξ) of a scan by the beam model (Thrun, Burgard & Fox, *Probabilistic Robotics*, 2005, table 6.1) against scans
/// [rendered](Renderer) from an occupancy map at the cells of a grid, or at places of which poses are known.
///
/// What stands between robot and wall counts, as it does not in a likelihood field: a wall that a beam would have to pass
/// through speaks against a place, a person who stands before it hardly does. Rendered ranges are kept, two bytes a beam and
/// pose, to half a cell of the map. Beams are taken as independent of each other, which they are not: the answer has to be
/// scaled ([`EvidenceScale`](super::EvidenceScale)) before a filter may believe it.
///
/// ```
/// use ballmark::{belief::{Belief, Places}, geometry::Pose, localiser::sensor_model::{BeamModel, BeamModelConfig, SensorModel}, seed::Seed};
/// use ballmark::mapping::{OccupancyMap, OccupancyMapConfig};
/// # use ballmark::recording::{Channel, Columns, Recording};
/// # let laser = Channel { name: "laser".into(), width: 1, unit: "m".into(), bearing_rad: Some(vec![0.0]), maximum: None, offset_m: None };
/// # let recording = Recording::new(Columns { channels: vec![laser], values: ndarray::array![[2.0], [2.0]], stamp_s: vec![0.0, 1.0],
/// #     pose: vec![Pose::new(0.1, 0.1, 0.0); 2], odometry: vec![Pose::default(); 2], run: vec![0, 0], ..Columns::default() })?;
/// let map = OccupancyMap::from_scans(&recording, &[0, 1], &OccupancyMapConfig::default())?;
/// let poses = vec![Pose::new(0.1, 0.1, 0.0), Pose::new(1.1, 0.1, 0.0)];
/// let each = poses.iter().map(|pose| vec![*pose]).collect();
/// let model = BeamModel::at_poses(&map, recording.channels(), &BeamModelConfig::default(), each)?;
/// let belief = Belief::uniform(&std::sync::Arc::new(Places::Plane(poses)))?;
/// let said = model.log_likelihood(&recording.observation(0), &belief, &mut Seed(1).stream("not drawn from"))?;
/// assert!(said[0] > said[1]);
/// # Ok::<(), ballmark::Error>(())
/// ```
pub struct BeamModel {
    channels: Vec<Channel>,
    beams: Vec<RangeBeam>,
    mixtures: Vec<Mixture>,
    /// Of each beam, what may be expected of it: every stored range, then free, then unknown.
    expected: Vec<Expected>,
    /// Rendered ranges, `[pose, beam]`: the number of the step, or [`FREE`], or [`UNKNOWN`].
    rendered: Array2<u16>,
    /// Poses of each place, from one of these to the next; `None`: one each.
    first_pose: Option<Vec<usize>>,
}

/// What may be expected of a beam, and what its terms have within their ends there.
type Expected = Arc<[(Rendered, Within)]>;

const FREE: u16 = u16::MAX - 1;
const UNKNOWN: u16 = u16::MAX;

impl BeamModel {
    /// At all cells of a grid in the plane, for the range sensors among `channels`.
    ///
    /// # Errors
    /// Where a value of `config` makes no sense, rendered scans would take more than its `most_bytes` (usage errors), the grid
    /// lies along a route, or no channel has ranges with bearings.
    pub fn over_grid(
        map: &OccupancyMap,
        channels: &[Channel],
        config: &BeamModelConfig,
        grid: &Grid,
    ) -> Result<Self> {
        let Places::Plane(poses) = &**grid.places() else {
            return Err(Error::work(
                "beam model: the grid lies along a route; expected one in the plane",
            ));
        };
        Self::new(map, channels, config, poses, None)
    }

    /// At places for each of which some poses stand, `[place]`: along a route those of the snapshots taken there. A place
    /// without any is as likely as all places are on average.
    ///
    /// # Errors
    /// As [`BeamModel::over_grid`], and where no place has a pose.
    pub fn at_poses(
        map: &OccupancyMap,
        channels: &[Channel],
        config: &BeamModelConfig,
        poses: Vec<Vec<Pose>>,
    ) -> Result<Self> {
        if poses.iter().all(Vec::is_empty) {
            return Err(Error::work(
                "beam model: no place with a known pose; expected at least one",
            ));
        }
        let mut first_pose = vec![0];
        for of_place in &poses {
            first_pose.push(first_pose[first_pose.len() - 1] + of_place.len());
        }
        Self::new(map, channels, config, &poses.concat(), Some(first_pose))
    }

    fn new(
        map: &OccupancyMap,
        channels: &[Channel],
        config: &BeamModelConfig,
        poses: &[Pose],
        first_pose: Option<Vec<usize>>,
    ) -> Result<Self> {
        config.check()?;
        let render = RenderConfig {
            unknown_m: config.unknown_m,
            reach_m: config.reach_m,
            beams: config.beams,
            sensors: config.sensors.clone(),
        };
        let renderer = Renderer::new(map, channels, &render);
        let renderer = renderer.map_err(|error| error.context("beam model"))?;
        let beams = renderer.beams().to_vec();
        let bytes = poses.len() * beams.len() * size_of::<u16>();
        if bytes > config.most_bytes {
            return Err(Error::usage(format!(
                "beam model: {} poses of {} beams are {bytes} bytes; expected at most {} (a coarser grid or fewer beams)",
                poses.len(),
                beams.len(),
                config.most_bytes
            )));
        }
        let most_m: Vec<f64> = beams.iter().map(|beam| renderer.most_m(beam)).collect();
        let farthest_m = most_m.iter().copied().fold(0.0, f64::max);
        let step_m = (0.5 * map.cell_m()).max(farthest_m / f64::from(FREE - 1));
        let stored = |_, rendered| match rendered {
            Rendered::Hit(range_m) => (f64::from(range_m) / step_m).floor() as u16,
            Rendered::Free => FREE,
            Rendered::Unknown(_) => UNKNOWN,
        };
        Ok(Self {
            channels: channels.to_vec(),
            expected: by_reach(config, &most_m, step_m),
            mixtures: most_m.iter().map(|&m| Mixture::new(config, m)).collect(),
            rendered: renderer.at_all_as(poses, stored),
            beams,
            first_pose,
        })
    }

    /// What the rendered scans take, in bytes.
    pub fn bytes(&self) -> usize {
        self.rendered.len() * size_of::<u16>()
    }

    /// What a beam reads; `None` where the reading says nothing.
    fn measured(&self, beam: usize, reading: f32) -> Option<Measured> {
        let most_m = self.mixtures[beam].most_m();
        let range_m = f64::from(reading);
        if range_m >= most_m {
            return Some(Measured::Max);
        }
        match range_m > 0.0 {
            true => Some(Measured::Range(range_m)),
            // A missing reading of a sensor without a maximum may be anything; one of 0 or less is no distance.
            false => {
                (range_m.is_nan() && self.beams[beam].maximum_m.is_some()).then_some(Measured::Max)
            }
        }
    }

    /// ln p of a beam's reading at every stored range, then where it is free, then where it is unknown.
    fn table(&self, beam: usize, measured: Measured) -> Vec<f32> {
        let mixture = &self.mixtures[beam];
        let each = self.expected[beam].iter();
        each.map(|(expected, within)| mixture.probability(measured, *expected, *within).ln() as f32)
            .collect()
    }

    /// The channels that beams are of must stand where they stood.
    fn check_channels(&self, observation: &Observation) -> Result<()> {
        check_width(observation.channels, observation.values.len())
            .map_err(|error| error.context("beam model"))?;
        for (i, wanted) in self.channels.iter().enumerate() {
            let same = |c: &&Channel| {
                (&c.name, c.width, &c.unit) == (&wanted.name, wanted.width, &wanted.unit)
            };
            if observation.channels.get(i).filter(same).is_none() {
                return Err(Error::work(format!(
                    "beam model: expected channel {} to be `{}`, {} values in `{}`",
                    i + 1,
                    wanted.name,
                    wanted.width,
                    wanted.unit
                )));
            }
        }
        Ok(())
    }
}

/// What may be expected of beams that see so far; those that see as far as each other share it.
fn by_reach(config: &BeamModelConfig, most_m: &[f64], step_m: f64) -> Vec<Expected> {
    let mut known: Vec<(f64, Expected)> = Vec::new();
    let mut of_beam = |&most_m: &f64| {
        if let Some((_, same)) = known.iter().find(|(other_m, _)| *other_m == most_m) {
            return Arc::clone(same);
        }
        let mixture = Mixture::new(config, most_m);
        let ranges = (most_m / step_m).ceil() as u16 + 1;
        let middle_m = |i: u16| ((f64::from(i) + 0.5) * step_m) as f32;
        let expected = (0..ranges).map(|i| Rendered::Hit(middle_m(i)));
        let expected = expected.chain([Rendered::Free, Rendered::Unknown(0.0)]);
        let each: Arc<[_]> = expected.map(|e| (e, mixture.within(e))).collect();
        known.push((most_m, Arc::clone(&each)));
        each
    };
    most_m.iter().map(&mut of_beam).collect()
}

impl SensorModel for BeamModel {
    fn name(&self) -> &str {
        "beam_model"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        self.check_channels(observation)?;
        let poses = self.rendered.nrows();
        let places = self.first_pose.as_ref().map_or(poses, |f| f.len() - 1);
        if belief.mass().len() != places {
            return Err(Error::work(format!(
                "beam model: a belief over {} places; expected the {places} that it was made for",
                belief.mass().len()
            )));
        }
        let readings = self.beams.iter().map(|beam| observation.values[beam.value]);
        // A sensor that saw nothing at all is switched off.
        let seen = readings.clone().any(|reading| reading.is_finite());
        let tables: Vec<(usize, Vec<f32>)> = readings
            .enumerate()
            .filter(|_| seen)
            .filter_map(|(beam, reading)| {
                let measured = self.measured(beam, reading)?;
                Some((beam, self.table(beam, measured)))
            })
            .collect();
        let of_pose = |pose: usize| -> f64 {
            let rendered = self.rendered.row(pose);
            let of_beam = |(beam, table): &(usize, Vec<f32>)| {
                let at = match rendered[*beam] {
                    FREE => table.len() - 2,
                    UNKNOWN => table.len() - 1,
                    range => usize::from(range),
                };
                f64::from(table[at])
            };
            tables.iter().map(of_beam).sum()
        };
        let each: Vec<f64> = (0..poses).into_par_iter().map(of_pose).collect();
        Ok(match &self.first_pose {
            None => each,
            Some(first_pose) => {
                let of_place = |w: &[usize]| ln_mean_exp(&each[w[0]..w[1]]);
                let known: Vec<f64> = first_pose.windows(2).map(of_place).collect();
                let finite = known.iter().copied().filter(|l| l.is_finite());
                let neutral = ln_mean_exp(&finite.collect::<Vec<f64>>());
                let or_neutral = |l: f64| if l.is_finite() { l } else { neutral };
                known.into_iter().map(or_neutral).collect()
            }
        })
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests;
