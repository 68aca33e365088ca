//! The beam model against the formula at every pose, in a room, and among people.

use super::*;
use crate::{
    belief::GridConfig,
    geometry::wrapped,
    mapping::OccupancyMapConfig,
    recogniser::test_world::{seeing, test_world},
    recording::{Columns, Recording},
    seed::Seed,
};
use std::sync::Arc;

/// The room's sonars are noisy rays without cones.
fn config() -> BeamModelConfig {
    let default = BeamModelConfig::default();
    BeamModelConfig {
        sensors: default.sensors.as_rays(),
        ..default
    }
}

fn map_of(recording: &Recording) -> OccupancyMap {
    let all: Vec<usize> = (0..recording.len()).collect();
    let config = OccupancyMapConfig {
        sensors: config().sensors,
        ..OccupancyMapConfig::default()
    };
    OccupancyMap::from_scans(recording, &all, &config).unwrap()
}

fn grid_of(recording: &Recording) -> Arc<Grid> {
    let config = GridConfig {
        headings: 12,
        ..GridConfig::default()
    };
    Arc::new(Grid::over(&Places::of(recording), &config).unwrap())
}

fn said(
    model: &dyn SensorModel,
    recording: &Recording,
    k: usize,
    places: &Arc<Places>,
) -> Vec<f64> {
    let belief = Belief::uniform(places).unwrap();
    let mut stream = Seed(1).stream("not drawn from");
    let said = model.log_likelihood(&recording.observation(k), &belief, &mut stream);
    said.unwrap()
}

/// How many of some snapshots each alone make a place within 0.6 m of the truth the likeliest.
fn found(model: &dyn SensorModel, recording: &Recording, places: &Arc<Places>) -> usize {
    let Places::Plane(cells) = &**places else {
        unreachable!("a grid in the plane")
    };
    let is_found = |&k: &usize| {
        let l = said(model, recording, k, places);
        let best = (0..l.len()).max_by(|&a, &b| l[a].total_cmp(&l[b])).unwrap();
        cells[best].distance_m(&recording.poses()[k]) < 0.6
    };
    (0..recording.len()).step_by(5).filter(is_found).count()
}

#[test]
fn every_cell_is_as_likely_as_the_formula_says() {
    let recording = test_world();
    let (map, grid) = (map_of(&recording), grid_of(&recording));
    let model = BeamModel::over_grid(&map, recording.channels(), &config(), &grid).unwrap();
    let render = RenderConfig {
        reach_m: 15.0,
        sensors: config().sensors,
        ..RenderConfig::default()
    };
    let renderer = Renderer::new(&map, recording.channels(), &render).unwrap();
    let mixture = Mixture::new(&config(), 5.0); // the sonars' maximum
    let Places::Plane(cells) = &**grid.places() else {
        unreachable!("a grid in the plane")
    };
    let l = said(&model, &recording, 17, grid.places());
    let values = recording.observation(17).values.to_vec();
    assert!(values.iter().any(|v| v.is_nan()) && values.iter().any(|v| v.is_finite()));
    let mut differ = 0;
    for (cell, pose) in cells.iter().enumerate() {
        let of_beam = |(expected, &reading): (Rendered, &f32)| {
            // Kept to half a cell of the map: 2.5 cm.
            let expected = match expected {
                Rendered::Hit(m) => Rendered::Hit(((m / 0.025).floor() + 0.5) * 0.025),
                other => other,
            };
            let measured = match reading.is_nan() {
                true => Measured::Max,
                false => Measured::Range(f64::from(reading)),
            };
            let within = mixture.within(expected);
            mixture.probability(measured, expected, within).ln()
        };
        let by_formula: f64 = renderer
            .at(pose)
            .into_iter()
            .zip(&values)
            .map(of_beam)
            .sum();
        // Where rounding takes a ray or a range to the other side of a border, it differs.
        differ += usize::from((by_formula - l[cell]).abs() > 1e-3);
    }
    assert!(differ * 50 < cells.len(), "{differ} of {}", cells.len());
}

/// A room with an alcove, seen by a laser of 72 beams from many poses of all headings.
fn room() -> Recording {
    let corners = [
        [0.0, 0.0],
        [8.0, 0.0],
        [8.0, 5.0],
        [5.0, 5.0],
        [5.0, 6.5],
        [4.0, 6.5],
        [4.0, 5.0],
        [0.0, 5.0],
    ];
    let range_m = |pose: &Pose, bearing_rad: f64| {
        let (sin, cos) = (pose.heading_rad + bearing_rad).sin_cos();
        let walls = (0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()]));
        let hits = walls.filter_map(|([ax, ay], [bx, by])| {
            let (ex, ey) = (bx - ax, by - ay);
            let cross = cos * ey - sin * ex;
            let (dx, dy) = (ax - pose.x_m, ay - pose.y_m);
            let (along, share) = ((dx * ey - dy * ex) / cross, (dx * sin - dy * cos) / cross);
            (along > 1e-6 && (0.0..=1.0).contains(&share)).then_some(along)
        });
        hits.fold(f64::INFINITY, f64::min)
    };
    let bearing_rad: Vec<f64> = (0..72).map(|i| f64::from(i) * 5f64.to_radians()).collect();
    let poses: Vec<Pose> = (0..120)
        .map(|k| {
            let k = f64::from(k);
            Pose::new(
                0.8 + (0.37 * k) % 6.4,
                0.8 + (0.53 * k) % 3.4,
                wrapped(0.7 * k),
            )
        })
        .collect();
    let values = Array2::from_shape_fn((120, 72), |(k, beam)| {
        let noise_m = 0.02 * ((k * 72 + beam) as f64).sin();
        (range_m(&poses[k], bearing_rad[beam]) + noise_m) as f32
    });
    let laser = Channel {
        name: "laser".into(),
        width: 72,
        unit: "m".into(),
        bearing_rad: Some(bearing_rad),
        maximum: Some(10.0),
        offset_m: None,
    };
    Recording::new(Columns {
        channels: vec![laser],
        values,
        stamp_s: (0..120).map(f64::from).collect(),
        odometry: poses.clone(),
        pose: poses,
        run: vec![0; 120],
        ..Columns::default()
    })
    .unwrap()
}

#[test]
fn a_robot_in_a_room_is_found_from_one_scan() {
    let recording = room();
    let map = map_of(&recording);
    let grid = Grid::over(&Places::of(&recording), &GridConfig::default()).unwrap();
    let grid = Arc::new(grid);
    let model = BeamModel::over_grid(&map, recording.channels(), &config(), &grid).unwrap();
    let (found, all) = (
        found(&model, &recording, grid.places()),
        recording.len() / 5,
    );
    assert!(10 * found >= 9 * all, "{found} of {all}");
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let recording = test_world();
    let (map, grid) = (map_of(&recording), grid_of(&recording));
    let made = |config: BeamModelConfig| {
        let model = BeamModel::over_grid(&map, recording.channels(), &config, &grid);
        model.err().unwrap()
    };
    let error = made(BeamModelConfig {
        most_bytes: 1000,
        ..config()
    });
    assert!(
        error.is_usage() && error.to_string().contains("expected at most 1000"),
        "{error}"
    );
    let error = made(BeamModelConfig {
        random: 0.0,
        ..config()
    });
    assert!(
        error.to_string().contains("beam_model.random = 0"),
        "{error}"
    );
    assert!(BeamModel::at_poses(&map, recording.channels(), &config(), vec![vec![]]).is_err());
    let here = vec![vec![recording.poses()[17]], vec![]];
    let model = BeamModel::at_poses(&map, recording.channels(), &config(), here).unwrap();
    let places = Arc::new(Places::Route(vec![0.0, 1.0]));
    let l = said(&model, &recording, 17, &places);
    assert!((l[0] - l[1]).abs() < 1e-9, "{l:?}");
    // A sensor that saw nothing at all says nothing.
    let dark = seeing(&recording, |_, _| f32::NAN);
    assert_eq!(said(&model, &dark, 17, &places), [0.0, 0.0]);
    let mut channels = recording.channels().to_vec();
    channels[0].name = "laser".into();
    let other = Observation {
        channels: &channels,
        ..recording.observation(0)
    };
    let belief = Belief::uniform(&places).unwrap();
    let mut stream = Seed(1).stream("not drawn from");
    let error = model
        .log_likelihood(&other, &belief, &mut stream)
        .unwrap_err();
    assert!(
        error.to_string().contains("channel 1 to be `sonar`"),
        "{error}"
    );
    let small = Belief::uniform(&Arc::new(Places::Route(vec![0.0]))).unwrap();
    let error = model.log_likelihood(&recording.observation(0), &small, &mut stream);
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("a belief over 1 places")
    );
}
