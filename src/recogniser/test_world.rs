//! The small world that all recognisers and localisers are tried in.

use crate::{
    geometry::{Pose, wrapped},
    recording::{Channel, Columns, Recording},
    seed::Seed,
};
use ndarray::Array2;
use rand::RngExt;
use std::f64::consts::TAU;

/// Sonars of the ring.
const SONARS: usize = 16;

/// Two laps along the walls of a room of 9 m by 6 m with a pillar, a ring of noisy sonars that reach 5 m, and a compass.
pub(crate) fn test_world() -> Recording {
    let mut noise = Seed(5).stream("noise of the room");
    let lap = (0..104).map(|i| 0.25 * f64::from(i));
    let along = |m: f64| match m {
        m if m < 8.0 => (0.5 + m, 0.5),
        m if m < 13.0 => (8.5, 0.5 + m - 8.0),
        m if m < 21.0 => (8.5 - (m - 13.0), 5.5),
        m => (0.5, 5.5 - (m - 21.0)),
    };
    let pose: Vec<Pose> = lap
        .clone()
        .chain(lap)
        .map(along)
        .map(|(x, y)| Pose::new(x, y, 0.0))
        .collect();
    let bearing = |i: usize| TAU * i as f64 / SONARS as f64;
    let values = Array2::from_shape_fn((pose.len(), SONARS), |(k, i)| {
        let range = range_m(pose[k], bearing(i)) + 0.02 * noise.random_range(-1.0..1.0);
        if range < 5.0 { range as f32 } else { f32::NAN }
    });
    recording(values, pose)
}

/// Metres to the wall or the pillar.
fn range_m(from: Pose, bearing: f64) -> f64 {
    let (dx, dy) = (bearing.cos(), bearing.sin());
    let wall = |at: f64, d: f64, size: f64| match d {
        d if d > 1e-9 => (size - at) / d,
        d if d < -1e-9 => -at / d,
        _ => f64::INFINITY,
    };
    let walls = wall(from.x_m, dx, 9.0).min(wall(from.y_m, dy, 6.0));
    let (x, y, radius) = (3.0 - from.x_m, 2.0 - from.y_m, 0.5);
    let (ahead, beside) = (x * dx + y * dy, x * dy - y * dx);
    if ahead > 0.0 && beside.abs() < radius {
        walls.min(ahead - (radius * radius - beside * beside).sqrt())
    } else {
        walls
    }
}

fn recording(values: Array2<f32>, pose: Vec<Pose>) -> Recording {
    let k = pose.len();
    let bearing = |i: usize| wrapped(TAU * i as f64 / SONARS as f64);
    Recording::new(Columns {
        channels: vec![Channel {
            name: "sonar".into(),
            width: SONARS,
            unit: "m".into(),
            bearing_rad: Some((0..SONARS).map(bearing).collect()),
            maximum: Some(5.0),
            offset_m: None,
        }],
        values,
        stamp_s: (0..k).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        pose,
        run: vec![0; k],
        compass_rad: Some(vec![0.0; k]),
        ..Columns::default()
    })
    .unwrap()
}

/// The same snapshots with other values.
pub(crate) fn seeing(seen: &Recording, value: impl Fn(usize, usize) -> f32) -> Recording {
    let values = Array2::from_shape_fn(seen.values().dim(), |(k, i)| value(k, i));
    recording(values, seen.poses().to_vec())
}
