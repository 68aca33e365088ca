//! The directions that the rays of many poses have between them, so that none is followed twice from a place.

use crate::{geometry::Pose, mapping::RangeBeam};
use std::{
    collections::{BTreeMap, HashMap},
    f64::consts::TAU,
};

/// Rays through a cone are at most so far apart.
const SPACING_RAD: f64 = 2.5 * TAU / 360.0;
/// Directions that differ by less than this are one, in turns: they come of the same headings and bearings by other sums.
const SAME_TURNS: f64 = 1e-10;
/// Sensors nearer to each other than this are one, in metres, likewise.
const SAME_M: f64 = 1e-9;
/// More headings than this are no grid's, and share no directions.
const MOST_HEADINGS: usize = 720;

/// Which way a ray goes from a robot's middle, and how far out it starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Direction {
    pub(super) angle_rad: f64,
    /// From the middle to the sensor, metres east and north.
    offset_m: [f64; 2],
}

impl Direction {
    /// Aside of the axis of a beam that looks to `axis_rad`.
    pub(super) fn new(axis_rad: f64, aside_rad: f64, beam: &RangeBeam) -> Self {
        let offset_m = match beam.offset_m {
            0.0 => [0.0; 2],
            offset_m => [offset_m * axis_rad.cos(), offset_m * axis_rad.sin()],
        };
        Self {
            angle_rad: axis_rad + aside_rad,
            offset_m,
        }
    }

    /// Where the ray starts.
    pub(super) fn starts_at_m(&self, middle_m: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| middle_m[axis] + self.offset_m[axis])
    }

    /// Directions of the same key are one.
    fn key(&self) -> (i64, [i64; 2]) {
        let whole = (1.0 / SAME_TURNS).round() as i64;
        let turns = (self.angle_rad / TAU / SAME_TURNS).round() as i64;
        let steps = self.offset_m.map(|m| (m / SAME_M).round() as i64);
        (turns.rem_euclid(whole), steps)
    }
}

/// Rays through a beam's cone: one along an axis without opening.
pub(super) fn ray_count(beam: &RangeBeam) -> usize {
    (beam.opening_rad / SPACING_RAD - 1e-9).ceil() as usize + 1
}

/// Their angles off the axis, from edge to edge.
pub(super) fn rays(beam: &RangeBeam) -> impl Iterator<Item = f64> {
    let (count, opening_rad) = (ray_count(beam), beam.opening_rad);
    (0..count).map(move |ray| match count {
        1 => 0.0,
        _ => opening_rad * (ray as f64 / (count - 1) as f64 - 0.5),
    })
}

/// Poses that are the headings of some places, as a grid's are, and the directions that their rays have between them.
pub(super) struct SharedDirections {
    pub(super) sites: Vec<[f64; 2]>,
    /// Place and heading of every pose.
    pub(super) site_of: Vec<u32>,
    pub(super) heading_of: Vec<u32>,
    /// `[heading]`, ray by ray.
    pub(super) directions_of: Vec<Vec<u32>>,
    pub(super) directions: Vec<Direction>,
}

impl SharedDirections {
    /// `None` where following every beam at every pose is no more work.
    pub(super) fn of(poses: &[Pose], beams: &[RangeBeam]) -> Option<Self> {
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
        let mut directions = Vec::new();
        let mut known: BTreeMap<(i64, [i64; 2]), u32> = BTreeMap::new();
        let directions_of: Vec<Vec<u32>> = heading_rad
            .iter()
            .map(|heading_rad| {
                let of_beam = |beam: &RangeBeam| {
                    let axis_rad = heading_rad + beam.bearing_rad;
                    rays(beam)
                        .map(|aside_rad| Direction::new(axis_rad, aside_rad, beam))
                        .collect::<Vec<Direction>>()
                };
                let each = beams.iter().flat_map(of_beam);
                each.map(|direction| {
                    *known.entry(direction.key()).or_insert_with(|| {
                        directions.push(direction);
                        directions.len() as u32 - 1
                    })
                })
                .collect()
            })
            .collect();
        let rays: usize = beams.iter().map(ray_count).sum();
        let shared = sites.len() * directions.len();
        (2 * shared < poses.len() * rays).then_some(Self {
            sites,
            site_of,
            heading_of,
            directions_of,
            directions,
        })
    }
}
