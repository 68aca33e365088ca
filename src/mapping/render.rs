//! What range sensors would see at any pose of an occupancy map.

mod shared_directions;

use super::{
    occupancy_map::OccupancyMap,
    range_sensors::{RangeBeam, RangeSensors, thinned},
    raycast::{Met, RayMap},
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::Channel,
};
use ndarray::Array2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use shared_directions::{Direction, SharedDirections, ray_count, rays};

/// How scans are rendered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderConfig {
    /// So far a beam may go through cells that were never seen and still be followed, in metres: maps of scans have gaps just
    /// before walls, and speckles.
    pub unknown_m: f64,
    /// Beams are followed so far at most, in metres; less where a channel's maximum is.
    pub reach_m: f64,
    /// Beams of a scan that are rendered, evenly spaced; 0: all.
    pub beams: usize,
    /// The sensors that are rendered. One with an opening sees the nearest thing in its cone.
    pub sensors: RangeSensors,
}

impl Default for RenderConfig {
    fn default() -> Self {
        Self {
            unknown_m: 0.4,
            reach_m: 40.0,
            beams: 0,
            sensors: RangeSensors::default(),
        }
    }
}

impl RenderConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        if !(self.unknown_m.is_finite() && self.unknown_m >= 0.0) {
            return Err(Error::usage(format!(
                "render.unknown_m = {}: expected metres, 0 or more",
                self.unknown_m
            )));
        }
        if !(self.reach_m.is_finite() && self.reach_m > 0.0) {
            return Err(Error::usage(format!(
                "render.reach_m = {}: expected metres above 0",
                self.reach_m
            )));
        }
        self.sensors.check()
    }
}

/// What a beam would see.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rendered {
    /// Something occupied at this distance, in metres.
    Hit(f32),
    /// Nothing within the beam's maximum: there would be no return.
    Free,
    /// The beam leaves what is known: nobody can say what it meets from this distance on, in metres.
    Unknown(f32),
}

impl Rendered {
    /// As a recording has it, in metres: NaN where there would be no return, and where nobody can say.
    pub fn reading_m(self) -> f32 {
        match self {
            Rendered::Hit(range_m) => range_m,
            Rendered::Free | Rendered::Unknown(_) => f32::NAN,
        }
    }
}

/// Renders the scans of some sensors in a map.
///
/// A beam starts where its sensor sits, and what it reads counts from there. It ends in the first occupied cell; one that leaves the map, or what is known of it, is unknown, not far. A cone sees the
/// nearest of what rays through it see, 2.5° apart or less. From an occupied cell nothing is seen.
///
/// ```
/// use ballmark::{geometry::Pose, mapping::{Occupancy, OccupancyMap, RenderConfig, Rendered, Renderer}, recording::Channel};
/// // A wall at 4 m, known ground before it and to one side; 5 cm cells.
/// let mut cells = vec![Occupancy::Free; 100 * 40];
/// for row in cells.chunks_mut(100) {
///     row[80] = Occupancy::Occupied;
///     row[81..].fill(Occupancy::Unknown);
/// }
/// let map = OccupancyMap::from_cells(0.05, [0.0, 0.0], 100, cells)?;
/// let laser = Channel { name: "laser".into(), width: 2, unit: "m".into(), bearing_rad: Some(vec![0.0, 3.1]), maximum: Some(1.5), offset_m: None };
/// let renderer = Renderer::new(&map, &[laser], &RenderConfig::default())?;
/// let seen = renderer.at(&Pose::new(3.0, 1.0, 0.0));
/// assert!(matches!(seen[0], Rendered::Hit(range_m) if (range_m - 1.025).abs() < 1e-3));
/// assert_eq!(seen[1], Rendered::Free);
/// assert!(matches!(renderer.at(&Pose::new(0.5, 1.0, 0.0))[1], Rendered::Unknown(_))); // leaves the map
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Renderer {
    map: RayMap,
    cell_m: f64,
    origin_m: [f64; 2],
    reach_m: f64,
    beams: Vec<RangeBeam>,
}

impl Renderer {
    /// Of the range sensors among some channels, in a map.
    ///
    /// # Errors
    /// Where a value of `config` makes no sense (a usage error), a sensor that it names is missing, or no channel has ranges
    /// with bearings.
    pub fn new(map: &OccupancyMap, channels: &[Channel], config: &RenderConfig) -> Result<Self> {
        config.check()?;
        let all = config.sensors.beams(channels);
        let all = all.map_err(|error| error.context("rendered scans"))?;
        let beams = match config.beams {
            0 => all,
            count => thinned(&all, count),
        };
        Ok(Self {
            map: RayMap::new(map, config.unknown_m / map.cell_m()),
            cell_m: map.cell_m(),
            origin_m: map.origin_m(),
            reach_m: config.reach_m,
            beams,
        })
    }

    /// The beams that are rendered, in order.
    pub fn beams(&self) -> &[RangeBeam] {
        &self.beams
    }

    /// Distance from which on a beam sees nothing: its maximum, or the reach where that is less, in metres.
    pub fn most_m(&self, beam: &RangeBeam) -> f64 {
        beam.maximum_m.unwrap_or(f64::INFINITY).min(self.reach_m)
    }

    /// What each beam would see at a pose, `[beam]`.
    pub fn at(&self, pose: &Pose) -> Vec<Rendered> {
        let of_beam = |beam: &RangeBeam| {
            let rays = rays(beam).map(|aside_rad| {
                let axis_rad = pose.heading_rad + beam.bearing_rad;
                self.ray(
                    [pose.x_m, pose.y_m],
                    &Direction::new(axis_rad, aside_rad, beam),
                )
            });
            self.nearest(beam, rays)
        };
        self.beams.iter().map(of_beam).collect()
    }

    /// What each beam would see at many poses, `[pose, beam]`, on all threads; the same for any number of them. Over the cells
    /// of a grid, directions that headings and beams have in common are followed once a place.
    pub fn at_all(&self, poses: &[Pose]) -> Array2<Rendered> {
        self.at_all_as(poses, |_, rendered| rendered)
    }

    /// The same, each beam's number and what it sees turned into something else, so that nothing larger is held.
    pub fn at_all_as<T: Copy + Send + Sync>(
        &self,
        poses: &[Pose],
        of: impl Fn(usize, Rendered) -> T + Sync,
    ) -> Array2<T> {
        let shared = SharedDirections::of(poses, &self.beams);
        let table = shared.as_ref().map(|shared| {
            let sites = shared.sites.par_iter();
            let rays = sites.flat_map_iter(|site| {
                let each = shared.directions.iter();
                each.map(|direction| self.ray(*site, direction))
            });
            rays.collect::<Vec<Ray>>()
        });
        let rows = poses.par_iter().enumerate().flat_map_iter(|(k, pose)| {
            let seen = match (&shared, &table) {
                (Some(shared), Some(table)) => {
                    let directions = shared.directions.len();
                    let first = shared.site_of[k] as usize * directions;
                    let rays = &table[first..first + directions];
                    let mut of_heading = shared.directions_of[shared.heading_of[k] as usize].iter();
                    let of_beam = |beam: &RangeBeam| {
                        let of_beam = of_heading.by_ref().take(ray_count(beam));
                        self.nearest(beam, of_beam.map(|&d| rays[d as usize]))
                    };
                    self.beams.iter().map(of_beam).collect()
                }
                _ => self.at(pose),
            };
            let of = &of;
            seen.into_iter()
                .enumerate()
                .map(move |(beam, rendered)| of(beam, rendered))
        });
        let flat: Vec<T> = rows.collect();
        let shape = (poses.len(), self.beams.len());
        Array2::from_shape_fn(shape, |(pose, beam)| flat[pose * shape.1 + beam])
    }

    /// One ray from a sensor of a robot at `middle_m`, followed as far as the farthest-seeing beam.
    fn ray(&self, middle_m: [f64; 2], direction: &Direction) -> Ray {
        let (sin, cos) = direction.angle_rad.sin_cos();
        let from_m = direction.starts_at_m(middle_m);
        let from = [0, 1].map(|axis| (from_m[axis] - self.origin_m[axis]) / self.cell_m);
        let most = self.beams.iter().map(|beam| self.most_m(beam));
        let most_m = most.fold(0.0, f64::max);
        match self.map.cast(from, [cos, sin], most_m / self.cell_m) {
            Met::Occupied(cells) => Ray::Hit((cells * self.cell_m) as f32),
            Met::Nothing => Ray::Hit(f32::INFINITY),
            Met::Unknown(cells) => Ray::Lost((cells * self.cell_m) as f32),
        }
    }

    /// What a beam sees of what its rays meet.
    fn nearest(&self, beam: &RangeBeam, rays: impl Iterator<Item = Ray>) -> Rendered {
        let most_m = self.most_m(beam) as f32;
        let (mut nearest_m, mut lost_m) = (f32::INFINITY, f32::INFINITY);
        for ray in rays {
            match ray {
                Ray::Hit(range_m) => nearest_m = nearest_m.min(range_m),
                Ray::Lost(range_m) => lost_m = lost_m.min(range_m),
            }
        }
        match nearest_m < most_m {
            true => Rendered::Hit(nearest_m),
            false if lost_m < most_m => Rendered::Unknown(lost_m),
            false => Rendered::Free,
        }
    }
}

/// What a ray comes to.
#[derive(Debug, Clone, Copy)]
enum Ray {
    /// Something occupied so far away, in metres; infinite: nothing within reach.
    Hit(f32),
    /// From there on nothing is known, in metres.
    Lost(f32),
}

#[cfg(test)]
mod tests;
