//! From floor plans, a route, a robot and its sonars to a Recording.

use super::{
    FloorPlan, Raycaster, RobotConfig, Route, Sonar, SonarConfig, Stop, enclosure::check_enclosed,
    robot::drive,
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Columns, Recording},
    seed::Seed,
};
use nalgebra::Point2;
use ndarray::Array2;
use rayon::prelude::*;

/// Most snapshots of one simulation: far beyond any use, small enough to hold.
const MOST_SNAPSHOTS: f64 = 1e6;
/// Pause between two runs, on the recording's clock, seconds.
const PAUSE_S: f64 = 600.0;

/// Drives the route once through each plan (one a run: doors and bins differ between them) and records the sonars every
/// `spacing_m` metres of travel.
///
/// Run r depends on the seed, its own plan and r only, not on how many runs there are or how many threads work.
///
/// # Errors
/// Where a constant is out of bounds, the robot could get out of a plan, or comes nearer to a wall than its radius;
/// the message names the run.
pub fn simulate(
    seed: Seed,
    plans: Vec<FloorPlan>,
    route: &Route,
    robot: &RobotConfig,
    sonar: &SonarConfig,
    spacing_m: f64,
) -> Result<Recording> {
    let sonar = Sonar::new(sonar.clone())?;
    robot.check()?;
    let expected = plans.len() as f64 * (route.length_m() / spacing_m + 1.0);
    if spacing_m > 0.0 && expected > MOST_SNAPSHOTS {
        return Err(Error::usage(format!(
            "simulation: {} runs with a snapshot every {spacing_m} m make {expected:.0}; expected up to {MOST_SNAPSHOTS}",
            plans.len()
        )));
    }
    let drives: Vec<(Raycaster, Vec<Stop>)> = plans
        .into_par_iter()
        .enumerate()
        .map(|(run, plan)| {
            let in_run = |fault: Error| {
                if fault.is_usage() {
                    fault
                } else {
                    Error::work(format!("run {run}: {fault}"))
                }
            };
            let mut started = false;
            let clear = |pose: &Pose, route_m: f64| {
                if !std::mem::replace(&mut started, true) {
                    check_enclosed(&plan, &place(pose), robot.radius_m)?;
                }
                check_clear(&plan, pose, route_m, robot.radius_m)
            };
            let stops = drive(seed, run as u64, route, robot, spacing_m, clear).map_err(in_run)?;
            Ok((Raycaster::new(plan), stops))
        })
        .collect::<Result<_>>()?;

    let places: Vec<(usize, usize)> = drives
        .iter()
        .enumerate()
        .flat_map(|(run, (_, stops))| (0..stops.len()).map(move |stop| (run, stop)))
        .collect();
    let values: Vec<f32> = places
        .par_iter()
        .flat_map_iter(|&(run, stop)| {
            // Both are below 2^32: see MOST_SNAPSHOTS.
            let mut noise = seed.numbered_stream("world/sonar", (run as u64) << 32 | stop as u64);
            sonar.read(
                &(&drives[run].0).into(),
                &drives[run].1[stop].pose,
                &mut noise,
            )
        })
        .collect();
    let run_s = 2.0 * route.length_m() / robot.speed_m_per_s + PAUSE_S;
    let of_each = |value: &dyn Fn(usize, &Stop) -> f64| -> Vec<f64> {
        places
            .iter()
            .map(|&(run, stop)| value(run, &drives[run].1[stop]))
            .collect()
    };
    let channel = sonar.channel();
    let values = Array2::from_shape_vec((places.len(), channel.width), values)
        .map_err(|fault| Error::work(format!("simulation: {fault}")))?;
    Recording::new(Columns {
        channels: vec![channel],
        values,
        stamp_s: of_each(&|run, stop| run as f64 * run_s + stop.stamp_s),
        pose: places
            .iter()
            .map(|&(run, stop)| drives[run].1[stop].pose)
            .collect(),
        odometry: places
            .iter()
            .map(|&(run, stop)| drives[run].1[stop].odometry)
            .collect(),
        run: places.iter().map(|&(run, _)| run as i64).collect(),
        route_m: Some(of_each(&|_, stop| stop.route_m)),
        ..Columns::default()
    })
}

/// Makes sure that the robot at a pose is clear of the walls.
fn check_clear(plan: &FloorPlan, pose: &Pose, route_m: f64, radius_m: f64) -> Result<()> {
    if plan.clearance_m(&place(pose)) < radius_m {
        return Err(Error::work(format!(
            "robot: hits a wall {route_m:.2} m along the route, near ({:.2}, {:.2}); expected {radius_m} m of free space around it",
            pose.x_m, pose.y_m
        )));
    }
    Ok(())
}

fn place(pose: &Pose) -> Point2<f64> {
    Point2::new(pose.x_m, pose.y_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Material, OdometryConfig, Wall};

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
}
