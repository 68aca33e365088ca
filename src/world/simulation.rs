//! From a building, or floor plans and a route, to a Recording: drive run after run, and record what the sensors say.

use super::{
    Building, FloorPlan, Raycaster, RobotConfig, Route, RunScene, Sonar, SonarConfig, Stop,
    Surroundings, Wall,
    building::{Journey, MOST_SNAPSHOTS, RunSet, Sensors, Spacing},
    enclosure::check_enclosed,
    robot::{RouteWay, drive},
    way::{Halt, Way, stops, travelled_m},
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    recording::{Channel, Columns, Recording},
    seed::Seed,
};
use nalgebra::Point2;
use ndarray::Array2;
use rayon::prelude::*;

/// Pause between two runs, on the recording's clock, seconds.
const PAUSE_S: f64 = 600.0;
/// Walls that begin this high above the floor are in nobody's way, metres.
const HEADROOM_M: f64 = 1.5;

/// Which runs of a building are simulated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Choice {
    /// Those of this set only; of all sets, one after another, where there is none.
    pub set: Option<String>,
    /// This number of runs of each set, instead of the file's.
    pub runs: Option<usize>,
}

/// A run, driven: what the building was like, and where the robot stopped.
struct Drive {
    /// Its number among all the building's runs.
    run: u64,
    scene: RunScene,
    caster: Raycaster,
    stops: Vec<Stop>,
    /// When it began, on the recording's clock, seconds.
    start_s: f64,
}

/// Simulates a building's robot and records all its sensors.
///
/// Run r depends on the seed, the building and r only, not on how many threads work.
///
/// ```
/// use ballmark::{seed::Seed, world::{Building, simulation::{Choice, simulate_building}}};
/// let hall = Building::from_text(r#"
///     name = "hall"
///     wall = [{ points = [[0, 0], [9, 0], [9, 4], [0, 4]], closed = true }]
///     sonar = { beams = 8 }
///     path = { corners = [[1, 2], [8, 2]] }
///     record = { snapshots = 15, runs = 2 }
/// "#)?;
/// let recording = simulate_building(&hall, Seed(1), &Choice::default())?;
/// assert_eq!((recording.len(), recording.runs().len()), (15, 2));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// A usage error where the choice names no set, or the sets' sensors differ in their channels; a work error where the
/// robot could get out, starts in a wall or comes nearer to one than its radius: the message names the run.
pub fn simulate_building(building: &Building, seed: Seed, choice: &Choice) -> Result<Recording> {
    let sets = chosen(building, choice)?;
    let channels = sets[0].1.sensors.channels();
    if channels.is_empty() {
        return Err(Error::usage(
            "no sensor; expected a table of at least one, such as [sonar]",
        ));
    }
    if let Some((_, set, _)) = sets
        .iter()
        .find(|(_, set, _)| set.sensors.channels() != channels)
    {
        return Err(Error::usage(format!(
            "the sensors of sets `{}` and `{}` differ; expected --set with one of {}",
            sets[0].1.name,
            set.name,
            building.set_names().join(", ")
        )));
    }
    let mut drives: Vec<(Drive, &Sensors)> = Vec::new();
    for (first, set, runs) in sets {
        let start_s = drives
            .last()
            .map_or(0.0, |(drive, _)| drive.end_s() + PAUSE_S);
        let driven = drive_set(building, seed, first, set, runs, start_s)?;
        drives.extend(driven.into_iter().map(|drive| (drive, &set.sensors)));
    }
    let source = match building.source() {
        "" => format!("simulated world {}, seed {}", building.name(), seed.0),
        after => format!(
            "simulated world {} after {after}, seed {}",
            building.name(),
            seed.0
        ),
    };
    record(seed, &drives, Some(source))
}

/// The sets that are asked for, each with the number of its first run and how many there are.
fn chosen<'a>(building: &'a Building, choice: &Choice) -> Result<Vec<(u64, &'a RunSet, usize)>> {
    if let Some(runs) = choice.runs.filter(|runs| !(1..=10_000).contains(runs)) {
        return Err(Error::usage(format!("--runs {runs}: expected 1 to 10000")));
    }
    let mut first = 0;
    let mut sets = Vec::new();
    for set in building.sets() {
        if choice.set.as_ref().is_none_or(|name| *name == set.name) {
            sets.push((first, set, choice.runs.unwrap_or(set.runs)));
        }
        first += set.runs.max(choice.runs.unwrap_or(0)) as u64;
    }
    match &choice.set {
        Some(name) if sets.is_empty() => Err(Error::usage(format!(
            "--set {name}: no such set in the world `{}`; expected {}",
            building.name(),
            match &building.set_names()[..] {
                [] => "none, since it has no [[set]]".to_string(),
                names => format!("one of {}", names.join(", ")),
            }
        ))),
        _ => Ok(sets),
    }
}

/// Drives all runs of a set.
fn drive_set(
    building: &Building,
    seed: Seed,
    first: u64,
    set: &RunSet,
    runs: usize,
    start_s: f64,
) -> Result<Vec<Drive>> {
    let robot = building.robot();
    let numbers: Vec<u64> = (first..first + runs as u64).collect();
    let scenes: Vec<(RunScene, FloorPlan)> = numbers
        .par_iter()
        .map(|&run| {
            let scene = building.plan_of_run(seed, run)?;
            let in_the_way = |wall: &&Wall| wall.low_m < HEADROOM_M;
            let walls = scene.plan.walls().iter().filter(in_the_way).copied();
            let obstacles = FloorPlan::new(walls.collect())?;
            Ok((scene, obstacles))
        })
        .collect::<Result<_>>()?;
    let ways: Vec<Box<dyn Way + '_>> = numbers
        .par_iter()
        .map(|&run| -> Result<Box<dyn Way + '_>> {
            let back = set.both_ways && run % 2 == 1;
            match building.journey() {
                Journey::Route {
                    there,
                    back: reverse,
                } => Ok(Box::new(RouteWay::draw(
                    seed,
                    run,
                    (there, reverse),
                    back,
                    set.laps,
                    robot,
                ))),
                Journey::Wall { .. } => Err(Error::work("wall following is not there yet")),
                Journey::Poses(_) => Err(Error::work("poses are not there yet")),
            }
        })
        .collect::<Result<_>>()?;
    let lengths_m: Vec<f64> = ways
        .par_iter()
        .map(|way| travelled_m(way.as_ref()))
        .collect();
    let spacings = spacings(set, runs, &lengths_m)?;
    let driven: Vec<Vec<Halt>> = (0..runs)
        .into_par_iter()
        .map(|index| {
            let (run, (scene, obstacles)) = (numbers[index], &scenes[index]);
            let mut started = false;
            let clear = |pose: &Pose, route_m: f64| {
                if !std::mem::replace(&mut started, true) {
                    let closed = [obstacles.walls(), &scene.fire_doors].concat();
                    check_enclosed(&FloorPlan::new(closed)?, &place(pose), robot.radius_m)?;
                }
                check_clear(obstacles, pose, route_m, robot.radius_m)
            };
            stops(
                seed,
                run,
                ways[index].as_ref(),
                robot,
                spacings[index],
                clear,
            )
            .map_err(|fault| in_run(fault, run))
        })
        .collect::<Result<_>>()?;
    let mut start_s = start_s;
    let drives = numbers.iter().zip(scenes).zip(driven);
    let drives = drives.map(|((&run, (scene, _)), halts)| {
        let drive = Drive {
            run,
            caster: Raycaster::new(scene.plan.clone()),
            scene,
            stops: halts.into_iter().map(|(stop, _)| stop).collect(),
            start_s,
        };
        start_s = drive.end_s() + PAUSE_S;
        drive
    });
    Ok(drives.collect())
}

/// How far apart the snapshots of each run stand, and how many there are at most.
fn spacings(set: &RunSet, runs: usize, lengths_m: &[f64]) -> Result<Vec<(f64, usize)>> {
    let whole_m: f64 = lengths_m.iter().sum();
    match set.spacing {
        Spacing::Metres(metres) => {
            let expected = whole_m / metres + runs as f64;
            if expected > MOST_SNAPSHOTS as f64 {
                return Err(Error::usage(format!(
                    "simulation: {runs} runs with a snapshot every {metres} m make {expected:.0}; expected up to {MOST_SNAPSHOTS}"
                )));
            }
            Ok(vec![(metres, usize::MAX); runs])
        }
        Spacing::Exactly(count) => {
            // The file's number is for the file's runs.
            let count = (count as f64 * runs as f64 / set.runs as f64).round();
            // Each run gets its share by length: the whole part of what the runs up to it get, less the ones before.
            let mut reached_m = 0.0;
            let mut given = 0;
            let shares = lengths_m.iter().map(|length_m| {
                reached_m += length_m;
                let until = (count * reached_m / whole_m).round() as usize;
                let share = until - given;
                given = until;
                (length_m / share.max(1) as f64, share)
            });
            Ok(shares.collect())
        }
        Spacing::AtPoses => Ok(vec![(0.0, 0); runs]),
    }
}

impl Drive {
    fn end_s(&self) -> f64 {
        self.start_s + self.stops.last().map_or(0.0, |stop| stop.stamp_s)
    }
}

impl Sensors {
    /// Channels in their fixed order.
    fn channels(&self) -> Vec<Channel> {
        self.sonar.iter().map(Sonar::channel).collect()
    }

    /// One reading of every sensor, channels side by side.
    fn read(&self, seed: Seed, number: u64, drive: &Drive, stop: &Stop) -> Vec<f32> {
        let around = Surroundings::new(&drive.caster, &drive.scene.fire_doors);
        let mut values = Vec::new();
        if let Some(sonar) = &self.sonar {
            let mut noise = seed.numbered_stream("world/sonar", number);
            values.extend(sonar.read(&around, &stop.pose, &mut noise));
        }
        values
    }
}

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
    if spacing_m > 0.0 && expected > MOST_SNAPSHOTS as f64 {
        return Err(Error::usage(format!(
            "simulation: {} runs with a snapshot every {spacing_m} m make {expected:.0}; expected up to {MOST_SNAPSHOTS}",
            plans.len()
        )));
    }
    let run_s = 2.0 * route.length_m() / robot.speed_m_per_s + PAUSE_S;
    let sensors = Sensors { sonar: Some(sonar) };
    let drives: Vec<(Drive, &Sensors)> = plans
        .into_par_iter()
        .enumerate()
        .map(|(run, plan)| {
            let mut started = false;
            let clear = |pose: &Pose, route_m: f64| {
                if !std::mem::replace(&mut started, true) {
                    check_enclosed(&plan, &place(pose), robot.radius_m)?;
                }
                check_clear(&plan, pose, route_m, robot.radius_m)
            };
            let stops = drive(seed, run as u64, route, robot, spacing_m, clear)
                .map_err(|fault| in_run(fault, run as u64))?;
            let drive = Drive {
                run: run as u64,
                caster: Raycaster::new(plan.clone()),
                scene: RunScene::of(plan),
                stops,
                start_s: run as f64 * run_s,
            };
            Ok((drive, &sensors))
        })
        .collect::<Result<_>>()?;
    record(seed, &drives, None)
}

/// Reads the sensors at every stop.
fn record(seed: Seed, drives: &[(Drive, &Sensors)], source: Option<String>) -> Result<Recording> {
    let places: Vec<(usize, usize)> = drives
        .iter()
        .enumerate()
        .flat_map(|(run, (drive, _))| (0..drive.stops.len()).map(move |stop| (run, stop)))
        .collect();
    let values: Vec<f32> = places
        .par_iter()
        .flat_map_iter(|&(run, stop)| {
            let (drive, sensors) = &drives[run];
            // Both are below 2^32: see MOST_SNAPSHOTS.
            let number = drive.run << 32 | stop as u64;
            sensors.read(seed, number, drive, &drive.stops[stop])
        })
        .collect();
    let of_each = |value: &dyn Fn(&Drive, &Stop) -> f64| -> Vec<f64> {
        let each = places.iter().map(|&(run, stop)| (&drives[run].0, stop));
        each.map(|(drive, stop)| value(drive, &drive.stops[stop]))
            .collect()
    };
    let pose_of_each = |pose: fn(&Stop) -> Pose| -> Vec<Pose> {
        let each = places.iter().map(|&(run, stop)| &drives[run].0.stops[stop]);
        each.map(pose).collect()
    };
    let channels = drives
        .first()
        .map_or_else(Vec::new, |(_, sensors)| sensors.channels());
    let width = channels.iter().map(|channel| channel.width).sum();
    let values = Array2::from_shape_vec((places.len(), width), values)
        .map_err(|fault| Error::work(format!("simulation: {fault}")))?;
    Recording::new(Columns {
        channels,
        values,
        stamp_s: of_each(&|drive, stop| drive.start_s + stop.stamp_s),
        pose: pose_of_each(|stop| stop.pose),
        odometry: pose_of_each(|stop| stop.odometry),
        run: places.iter().map(|&(run, _)| run as i64).collect(),
        route_m: Some(of_each(&|_, stop| stop.route_m)),
        source,
        ..Columns::default()
    })
}

/// A fault of a run, told with its number; that of the call stays as it is.
fn in_run(fault: Error, run: u64) -> Error {
    if fault.is_usage() {
        fault
    } else {
        Error::work(format!("run {run}: {fault}"))
    }
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
