//! Short drives through bare rooms.

use super::*;
use crate::world::{Material, OdometryConfig, Wall};
use nalgebra::Point2;

const BRICK: Material = Material {
    reflectivity: 1.0,
    critical_angle_rad: 0.5,
    ..Material::PLAIN
};

/// A bare room of 10 × 4 m, its corners joined by `walls` of the four sides, and a straight route through it.
fn room(walls: usize) -> (FloorPlan, Route) {
    let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [0.0, 4.0], [0.0, 0.0]];
    let sides = corners.windows(2).take(walls);
    let walls = sides
        .map(|pair| Wall::new(pair[0].into(), pair[1].into(), BRICK))
        .collect();
    let route = Route::new(&[Point2::new(1.0, 2.0), Point2::new(9.0, 2.0)], 0.0).unwrap();
    (FloorPlan::new(walls).unwrap(), route)
}

fn error(walls: usize, way: [[f64; 2]; 2], spacing_m: f64, robot: RobotConfig) -> Error {
    let (plan, _) = room(walls);
    let route = Route::new(&[way[0].into(), way[1].into()], 0.0).unwrap();
    simulate(
        Seed(1),
        vec![plan],
        &route,
        &robot,
        &SonarConfig::default(),
        spacing_m,
    )
    .unwrap_err()
}

#[test]
fn each_bad_call_gets_one_clear_line() {
    let (way, robot) = ([[1.0, 2.0], [9.0, 2.0]], RobotConfig::default);
    for spacing_m in [0.0, -1.0, f64::NAN] {
        let told = error(4, way, spacing_m, robot());
        assert!(
            told.is_usage() && told.to_string().contains("spacing_m"),
            "{told}"
        );
    }
    let told = error(
        4,
        way,
        1.0,
        RobotConfig {
            speed_m_per_s: 0.0,
            ..robot()
        },
    );
    assert!(
        told.is_usage() && told.to_string().contains("`speed_m_per_s` is 0"),
        "{told}"
    );
    let told = error(
        4,
        way,
        1.0,
        RobotConfig {
            odometry: OdometryConfig {
                rotation_noise_rad: -0.1,
                ..Default::default()
            },
            ..robot()
        },
    );
    assert!(
        told.is_usage() && told.to_string().contains("`rotation_noise_rad` is -0.1"),
        "{told}"
    );
    let told = error(3, way, 1.0, robot());
    assert!(
        told.to_string()
            .contains("run 0: floor plan: a robot of radius 0.27 m gets out near"),
        "{told}"
    );
    let told = error(4, [[0.0, 0.1], [9.0, 2.0]], 1.0, robot());
    assert!(told.to_string().contains("starts in a wall"), "{told}");
    let told = error(4, [[1.0, 2.0], [9.9, 2.0]], 1.0, robot());
    assert!(told.to_string().contains("hits a wall"), "{told}");
    let told = error(4, [[1.0, 2.0], [1e5, 2.0]], 0.05, robot());
    assert!(
        told.is_usage() && told.to_string().contains("expected up to"),
        "{told}"
    );
}

#[test]
fn every_stop_is_labelled_with_its_own_place() {
    let (plan, route) = room(4);
    let recording = simulate(
        Seed(1),
        vec![plan; 2],
        &route,
        &RobotConfig::default(),
        &SonarConfig::default(),
        0.5,
    )
    .unwrap();
    assert_eq!(recording.runs().len(), 2);
    for index in 0..recording.len() {
        let snapshot = recording.snapshot(index);
        assert!((snapshot.route_m.unwrap() - (snapshot.pose.x_m - 1.0)).abs() < 1e-9);
    }
    let stamps = &recording.columns().stamp_s;
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
    assert!((stamps[1] - stamps[0] - 0.5 / 0.15).abs() < 1e-9);
}
