//! What range sensors would see at any pose of an occupancy map.

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
use std::{
    collections::{BTreeMap, HashMap},
    f64::consts::TAU,
};

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
    /// The beam leaves what is known: nobody can say.
    Unknown,
}

impl Rendered {
    /// As a recording has it, in metres: NaN where there would be no return, and where nobody can say.
    pub fn reading_m(self) -> f32 {
        match self {
            Rendered::Hit(range_m) => range_m,
            Rendered::Free | Rendered::Unknown => f32::NAN,
        }
    }
}

/// Renders the scans of some sensors in a map.
///
/// A beam ends in the first occupied cell; one that leaves the map, or what is known of it, is unknown, not far. A cone sees the
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
/// let laser = Channel { name: "laser".into(), width: 2, unit: "m".into(), bearing_rad: Some(vec![0.0, 3.1]), maximum: Some(1.5) };
/// let renderer = Renderer::new(&map, &[laser], &RenderConfig::default())?;
/// let seen = renderer.at(&Pose::new(3.0, 1.0, 0.0));
/// assert!(matches!(seen[0], Rendered::Hit(range_m) if (range_m - 1.025).abs() < 1e-3));
/// assert_eq!(seen[1], Rendered::Free);
/// assert_eq!(renderer.at(&Pose::new(0.5, 1.0, 0.0))[1], Rendered::Unknown); // leaves the map
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

/// Rays through a cone are at most so far apart.
const SPACING_RAD: f64 = 2.5 * TAU / 360.0;
/// Directions that differ by less than this are one, in turns: they come of the same headings and bearings by other sums.
const SAME_TURNS: f64 = 1e-10;
/// More headings than this are no grid's, and share no directions.
const MOST_HEADINGS: usize = 720;

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
                let angle_rad = pose.heading_rad + beam.bearing_rad + aside_rad;
                self.ray([pose.x_m, pose.y_m], angle_rad)
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
                let each = shared.direction_rad.iter();
                each.map(|&angle_rad| self.ray(*site, angle_rad))
            });
            rays.collect::<Vec<Ray>>()
        });
        let rows = poses.par_iter().enumerate().flat_map_iter(|(k, pose)| {
            let seen = match (&shared, &table) {
                (Some(shared), Some(table)) => {
                    let directions = shared.direction_rad.len();
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

    /// One ray, followed as far as the farthest-seeing beam.
    fn ray(&self, from_m: [f64; 2], angle_rad: f64) -> Ray {
        let (sin, cos) = angle_rad.sin_cos();
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
        let (mut nearest_m, mut lost) = (f32::INFINITY, false);
        for ray in rays {
            match ray {
                Ray::Hit(range_m) => nearest_m = nearest_m.min(range_m),
                Ray::Lost(range_m) => lost |= range_m < most_m,
            }
        }
        match nearest_m < most_m {
            true => Rendered::Hit(nearest_m),
            false if lost => Rendered::Unknown,
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

/// Rays through a beam's cone: one along an axis without opening.
fn ray_count(beam: &RangeBeam) -> usize {
    (beam.opening_rad / SPACING_RAD - 1e-9).ceil() as usize + 1
}

/// Their angles off the axis, from edge to edge.
fn rays(beam: &RangeBeam) -> impl Iterator<Item = f64> {
    let (count, opening_rad) = (ray_count(beam), beam.opening_rad);
    (0..count).map(move |ray| match count {
        1 => 0.0,
        _ => opening_rad * (ray as f64 / (count - 1) as f64 - 0.5),
    })
}

/// Poses that are the headings of some places, as a grid's are, and the directions that their rays have between them.
struct SharedDirections {
    sites: Vec<[f64; 2]>,
    /// Place and heading of every pose.
    site_of: Vec<u32>,
    heading_of: Vec<u32>,
    /// `[heading]`, ray by ray.
    directions_of: Vec<Vec<u32>>,
    direction_rad: Vec<f64>,
}

impl SharedDirections {
    /// `None` where following every beam at every pose is no more work.
    fn of(poses: &[Pose], beams: &[RangeBeam]) -> Option<Self> {
        let mut headings: HashMap<u64, u32> = HashMap::new();
        let mut heading_rad = Vec::new();
        let mut numbers: HashMap<[u64; 2], u32> = HashMap::new();
        let mut sites = Vec::new();
        let (mut site_of, mut heading_of) = (Vec::new(), Vec::new());
        for pose in poses {
            let heading = *headings
                .entry(pose.heading_rad.to_bits())
                .or_insert_with(|| {
                    heading_rad.push(pose.heading_rad);
                    heading_rad.len() as u32 - 1
                });
            if heading_rad.len() > MOST_HEADINGS {
                return None;
            }
            heading_of.push(heading);
            let at = [pose.x_m, pose.y_m];
            site_of.push(*numbers.entry(at.map(f64::to_bits)).or_insert_with(|| {
                sites.push(at);
                sites.len() as u32 - 1
            }));
        }
        let mut direction_rad = Vec::new();
        let mut known: BTreeMap<i64, u32> = BTreeMap::new();
        let directions_of: Vec<Vec<u32>> = heading_rad
            .iter()
            .map(|heading_rad| {
                let of_beam = |beam: &RangeBeam| {
                    let axis_rad = heading_rad + beam.bearing_rad;
                    rays(beam)
                        .map(move |aside_rad| axis_rad + aside_rad)
                        .collect::<Vec<f64>>()
                };
                let angles = beams.iter().flat_map(of_beam);
                angles
                    .map(|angle_rad| {
                        let whole = (1.0 / SAME_TURNS).round() as i64;
                        let turns = (angle_rad / TAU / SAME_TURNS).round() as i64;
                        *known.entry(turns.rem_euclid(whole)).or_insert_with(|| {
                            direction_rad.push(angle_rad);
                            direction_rad.len() as u32 - 1
                        })
                    })
                    .collect()
            })
            .collect();
        let rays: usize = beams.iter().map(ray_count).sum();
        let shared = sites.len() * direction_rad.len();
        (2 * shared < poses.len() * rays).then_some(Self {
            sites,
            site_of,
            heading_of,
            directions_of,
            direction_rad,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{mapping::Occupancy, seed::Seed};
    use rand::RngExt;

    /// A room of 6 m by 4 m with a gap in its western wall, 5 cm cells, what is outside unknown.
    fn room() -> OccupancyMap {
        let size = [160, 120];
        let mut cells = vec![Occupancy::Unknown; size[0] * size[1]];
        for (row, column) in (20..100).flat_map(|r| (20..140).map(move |c| (r, c))) {
            let wall = row == 20 || row == 99 || column == 20 || column == 139;
            let gap = column == 20 && (50..60).contains(&row);
            cells[row * size[0] + column] = match wall && !gap {
                true => Occupancy::Occupied,
                false => Occupancy::Free,
            };
        }
        OccupancyMap::from_cells(0.05, [-1.0, -1.0], size[0], cells).unwrap()
    }

    fn channel(name: &str, beams: usize, maximum: Option<f64>) -> Channel {
        Channel {
            name: name.into(),
            width: beams,
            unit: "m".into(),
            bearing_rad: Some((0..beams).map(|b| TAU * b as f64 / beams as f64).collect()),
            maximum,
        }
    }

    #[test]
    fn a_scan_in_a_room_has_its_walls_its_maximum_and_what_nobody_knows() {
        let renderer = |maximum| {
            let channels = [channel("laser", 4, maximum)];
            Renderer::new(&room(), &channels, &RenderConfig::default()).unwrap()
        };
        let hit = |r: Rendered, m: f32| matches!(r, Rendered::Hit(x) if (x - m).abs() < 0.03);
        // In the middle, facing east; the gap lies behind.
        let middle = Pose::new(3.0, 1.75, 0.0);
        let seen = renderer(None).at(&middle);
        assert!(
            hit(seen[0], 2.975) && hit(seen[1], 2.225) && hit(seen[3], 1.725),
            "{seen:?}"
        );
        assert_eq!(seen[2], Rendered::Unknown);
        let seen = renderer(Some(2.0)).at(&middle);
        assert_eq!(seen[..3], [Rendered::Free; 3]);
        assert!(hit(seen[3], 1.725) && seen[0].reading_m().is_nan());
        // What is unknown past the maximum is no matter, what is before it is.
        assert_eq!(renderer(Some(2.9)).at(&middle)[2], Rendered::Free);
        assert_eq!(renderer(Some(3.5)).at(&middle)[2], Rendered::Unknown);
        // In a wall, and outside.
        for nowhere in [Pose::new(0.02, 0.5, 0.0), Pose::new(-50.0, 0.5, 0.0)] {
            assert_eq!(renderer(None).at(&nowhere), [Rendered::Unknown; 4]);
        }
    }

    #[test]
    fn a_cone_sees_the_nearest_of_what_lies_in_it() {
        let of = |name| {
            let channels = [channel(name, 1, None)];
            Renderer::new(&room(), &channels, &RenderConfig::default()).unwrap()
        };
        // 45° to the wall: the cone's edge, 15° nearer to head-on, meets it first.
        let pose = Pose::new(3.0, 1.0, -TAU / 8.0);
        let range_m = |name| match of(name).at(&pose)[0] {
            Rendered::Hit(range_m) => range_m,
            other => panic!("{name}: {other:?}"),
        };
        assert!((range_m("laser") - 0.975 * 2f32.sqrt()).abs() < 0.06);
        assert!((range_m("sonar") - 0.975 / 30_f32.to_radians().cos()).abs() < 0.06);
        // Beside the gap the ray is lost, the cone is not.
        let before_gap = Pose::new(1.0, 1.75, TAU / 2.0);
        assert_eq!(of("laser").at(&before_gap)[0], Rendered::Unknown);
        assert!(matches!(of("sonar").at(&before_gap)[0], Rendered::Hit(m) if m > 0.9 && m < 1.1));
    }

    #[test]
    fn many_poses_see_what_each_alone_sees_whether_they_share_directions_or_not() {
        let mut random = Seed(2).stream("poses");
        let channels = [channel("laser", 12, None), channel("sonar", 8, Some(3.0))];
        let renderer = Renderer::new(&room(), &channels, &RenderConfig::default()).unwrap();
        let mut at = || {
            let (x_m, y_m) = (random.random_range(0.0..6.0), random.random_range(0.0..4.0));
            (x_m, y_m, random.random_range(0.0..TAU))
        };
        let alone: Vec<Pose> = (0..50)
            .map(|_| at())
            .map(|(x, y, h)| Pose::new(x, y, h))
            .collect();
        assert!(SharedDirections::of(&alone, renderer.beams()).is_none());
        let turning: Vec<Pose> = (0..24)
            .flat_map(|h| {
                alone
                    .iter()
                    .map(move |p| (p.x_m, p.y_m, f64::from(h) * TAU / 24.0))
            })
            .map(|(x, y, h)| Pose::new(x, y, h))
            .collect();
        let shared = SharedDirections::of(&turning, renderer.beams()).unwrap();
        assert_eq!(shared.direction_rad.len(), 144); // 2.5° apart
        for poses in [alone, turning] {
            let all = renderer.at_all(&poses);
            let mut differ = 0;
            for (row, pose) in all.rows().into_iter().zip(&poses) {
                let each = renderer.at(pose);
                differ += row.iter().zip(&each).filter(|(a, b)| a != b).count();
            }
            // The same direction by another sum may pass a corner on its other side.
            assert!(differ * 200 < all.len(), "{differ} of {}", all.len());
            let one_thread = rayon::ThreadPoolBuilder::new()
                .num_threads(1)
                .build()
                .unwrap();
            assert_eq!(one_thread.install(|| renderer.at_all(&poses)), all);
        }
    }

    #[test]
    fn values_without_sense_are_refused_by_name() {
        for (config, expected) in [
            (
                RenderConfig {
                    unknown_m: -1.0,
                    ..RenderConfig::default()
                },
                "render.unknown_m = -1",
            ),
            (
                RenderConfig {
                    reach_m: 0.0,
                    ..RenderConfig::default()
                },
                "render.reach_m = 0",
            ),
        ] {
            let error = Renderer::new(&room(), &[channel("laser", 1, None)], &config).unwrap_err();
            assert!(
                error.is_usage() && error.to_string().contains(expected),
                "{error}"
            );
        }
        let camera = Channel {
            bearing_rad: None,
            ..channel("camera", 3, None)
        };
        let error = Renderer::new(&room(), &[camera], &RenderConfig::default()).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("rendered scans: no channel in metres"),
            "{error}"
        );
    }
}
