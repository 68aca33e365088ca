//! Driving the runs of a set through a building: which way, past whom, and where the robot stops.

use super::{
    PAUSE_S,
    clearance::{check_clear, check_start, in_run},
    spacing::spacings,
};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    seed::Seed,
    world::{
        Building, Compass, FloorPlan, Outing, People, Raycaster, RunScene, Stop, Surroundings,
        TimedPose, Wall,
        building::{Journey, MAX_SNAPSHOTS, RunSet},
        driving::RouteWay,
        turret_headings,
        unsteadiness::Unsteadiness,
        visit::visit,
        wall_following::{Round, WallWay},
        way::{Halt, Way, halts, reckoned, travelled_m},
    },
};
use rayon::prelude::*;

/// Walls that begin this high above the floor don't block robots or people, metres.
const HEADROOM_M: f64 = 1.5;

/// Most walls of all runs' plans together, and most metres of all their ways: far beyond any use, small enough to hold.
const MAX_WALLS: usize = 10_000_000;
const MAX_WAY_M: f64 = 1e6;

/// People keep to the robot's way as known every so many metres, however sparse its snapshots.
const PATH_M: f64 = 0.1;

/// A run, driven: what the building was like, who came, and where the robot stopped.
pub(super) struct Drive {
    /// Its number among all the building's runs.
    pub(super) run: u64,
    /// While the robot maps, where the building is another one then, and afterwards.
    mapping: Option<(RunScene, Raycaster)>,
    later: (RunScene, Raycaster),
    people: Option<People>,
    pub(super) stops: Vec<Stop>,
    /// How far the compass's unsteadiness turns its reading at each stop, radians; empty without a compass.
    pub(super) unsteady_rad: Vec<f64>,
    /// The first stop at which the robot no longer maps.
    mapped_at: usize,
    /// When it began, on the recording's clock, seconds.
    pub(super) start_s: f64,
}

impl Drive {
    /// When it ended, on the recording's clock, seconds.
    pub(super) fn end_s(&self) -> f64 {
        self.start_s + self.stops.last().map_or(0.0, |stop| stop.stamp_s)
    }

    /// The building at a stop.
    pub(super) fn building_at(&self, stop: usize) -> (&RunScene, &Raycaster) {
        let mapping = self.mapping.as_ref().filter(|_| stop < self.mapped_at);
        let (scene, caster) = mapping.unwrap_or(&self.later);
        (scene, caster)
    }

    /// Adds who and what is passing, seconds after the run began.
    pub(super) fn passing_at(&self, stamp_s: f64, passing: &mut Vec<Wall>) {
        match &self.people {
            Some(people) => people.passing_at(stamp_s, passing),
            None => passing.extend(&self.later.0.fire_doors),
        }
    }
}

/// One run before it is driven.
struct Setting {
    run: u64,
    back: bool,
    mapping: Option<RunScene>,
    later: RunScene,
    /// What the robot may run into, while it maps (if that is another building) and afterwards.
    obstacles: (Option<Raycaster>, Raycaster),
    map_laps: f64,
}

impl Setting {
    fn new(building: &Building, seed: Seed, run: u64, first: u64, set: &RunSet) -> Result<Self> {
        let map_laps = building.people().map_or(0.0, |people| people.map_laps);
        let later = building.plan_of_run(seed, run)?;
        let mapping = match map_laps > 0.0 {
            true => Some(building.plan_while_mapping(seed, run)?),
            false => None,
        };
        let mapping = mapping.filter(|scene| *scene != later);
        let before = mapping.as_ref().map(obstacles).transpose()?;
        Ok(Self {
            run,
            back: set.both_ways && (run - first) % 2 == 1,
            obstacles: (
                before.map(Raycaster::new),
                Raycaster::new(obstacles(&later)?),
            ),
            mapping,
            later,
            map_laps,
        })
    }

    /// What the robot may run into after so many laps.
    fn obstacles_after(&self, laps: f64) -> &Raycaster {
        let before = self.obstacles.0.as_ref().filter(|_| laps < self.map_laps);
        before.unwrap_or(&self.obstacles.1)
    }
}

/// What is in a robot's way. Fire doors count as shut: it isn't let through one that a person leaves open (Duckett &
/// Nehmzow 1998, 7: "careful not to allow the robot to escape").
fn obstacles(scene: &RunScene) -> Result<FloorPlan> {
    let low = |wall: &&Wall| wall.low_m < HEADROOM_M;
    let all = scene.plan.walls().iter().chain(&scene.fire_doors);
    FloorPlan::new(all.filter(low).copied().collect())
}

/// Drives `runs` runs of a set, the first of them number `first` and at `start_s` on the recording's clock.
///
/// # Errors
/// Where snapshots would be too many or too dense, or the robot starts in a wall, gets out or hits something: the
/// message names the run.
pub(super) fn drive_set(
    building: &Building,
    seed: Seed,
    first: u64,
    set: &RunSet,
    runs: usize,
    start_s: f64,
) -> Result<Vec<Drive>> {
    let walls = building.plan_of_run(seed, first)?.plan.walls().len();
    if walls.saturating_mul(runs) > MAX_WALLS {
        return Err(Error::usage(format!(
            "simulation: {runs} runs, each with a plan of {walls} walls; expected up to {MAX_WALLS} walls in all"
        )));
    }
    let numbers: Vec<u64> = (first..first + runs as u64).collect();
    let settings = each_run(numbers.par_iter(), |&run| {
        Setting::new(building, seed, run, first, set)
    })?;
    let driven: Vec<Driven> = match building.journey() {
        Journey::Poses(poses) => {
            let visits = runs as f64 * set.laps * poses.len() as f64;
            if visits > MAX_SNAPSHOTS as f64 {
                return Err(Error::usage(format!(
                    "simulation: {runs} runs of {} laps through {} poses make {visits:.0} snapshots; expected up to {MAX_SNAPSHOTS}",
                    set.laps,
                    poses.len()
                )));
            }
            each_run(settings.par_iter(), |setting| {
                let order = (set.laps, setting.back);
                let clear = guard(setting, building.robot().radius_m);
                let halts = visit(seed, setting.run, poses, order, building.robot(), clear)
                    .map_err(|fault| in_run(fault, setting.run))?;
                let path = timed(&halts);
                Ok(Driven { halts, path })
            })?
        }
        journey => along_ways(building, seed, set, journey, &settings)?,
    };
    let finished = each_run(settings.par_iter().zip(&driven), |(setting, driven)| {
        finish(building, seed, set, setting, driven).map_err(|fault| in_run(fault, setting.run))
    })?;
    let mut start_s = start_s;
    let drives = settings.into_iter().zip(finished);
    let drives = drives.map(|(setting, finished)| {
        let with_caster = |scene: RunScene| {
            let caster = Raycaster::new(scene.plan.clone());
            (scene, caster)
        };
        let drive = Drive {
            run: setting.run,
            mapping: setting.mapping.map(with_caster),
            later: with_caster(setting.later),
            people: finished.people,
            stops: finished.stops,
            unsteady_rad: finished.unsteady_rad,
            mapped_at: finished.mapped_at,
            start_s,
        };
        start_s = drive.end_s() + PAUSE_S;
        drive
    });
    Ok(drives.collect())
}

/// Drives a route, or along a wall, and stops by the set's spacing.
fn along_ways(
    building: &Building,
    seed: Seed,
    set: &RunSet,
    journey: &Journey,
    settings: &[Setting],
) -> Result<Vec<Driven>> {
    let robot = building.robot();
    // All runs measure their progress along one and the same way round.
    let round = match (journey, settings.first()) {
        (Journey::Wall(following), Some(setting)) => {
            let plan = obstacles(&building.plan_while_mapping(seed, setting.run)?)?;
            check_start(&plan, setting.run, &following.start, robot.radius_m)?;
            Some(Round::drive(&Raycaster::new(plan), following, robot)?)
        }
        _ => None,
    };
    let once_m = match (journey, &round) {
        (Journey::Route { outward, .. }, _) => outward.length_m(),
        (_, Some(round)) => round.length_m(),
        _ => 0.0,
    };
    let all_m = once_m * set.laps * settings.len() as f64;
    if all_m > MAX_WAY_M {
        return Err(Error::usage(format!(
            "simulation: {} runs of {} laps of {once_m:.0} m; expected up to {MAX_WAY_M} m in all",
            settings.len(),
            set.laps
        )));
    }
    if let Journey::Route { outward, .. } = journey
        && !outward.is_closed()
        && robot.start_scatter_m >= outward.length_m()
    {
        return Err(Error::usage(format!(
            "robot: `start_scatter_m` is {}; expected less than the route's {:.2} m",
            robot.start_scatter_m,
            outward.length_m()
        )));
    }
    let ways = each_run(settings.par_iter(), |setting| {
        let (run, back) = (setting.run, setting.back);
        let way: Box<dyn Way + '_> = match (journey, &round) {
            (Journey::Wall(following), Some(round)) => {
                let following = match back {
                    true => following.back(),
                    false => *following,
                };
                let caster_at = |laps| setting.obstacles_after(laps);
                let own = own_seed(building, seed, set);
                let way = WallWay::drive((own, run), caster_at, &following, round, set.laps, robot);
                Box::new(way.map_err(|fault| in_run(fault, run))?)
            }
            (
                Journey::Route {
                    outward,
                    back: reverse,
                },
                _,
            ) => {
                let routes = (outward, reverse);
                Box::new(RouteWay::draw(seed, run, routes, back, set.laps, robot))
            }
            _ => {
                let fault = "simulation: no way to drive; expected a route or a wall";
                return Err(Error::work(fault));
            }
        };
        Ok(way)
    })?;
    let lengths_m: Vec<f64> = ways
        .par_iter()
        .map(|way| travelled_m(way.as_ref()))
        .collect();
    let spacings = spacings(set.spacing, set.runs, &lengths_m)?;
    let set_out = settings.par_iter().zip(&ways).zip(&spacings);
    each_run(set_out, |((setting, way), &spacing)| {
        let clear = guard(setting, robot.radius_m);
        let (run, way) = (setting.run, way.as_ref());
        let halts_at = |spacing, clear: &mut dyn FnMut(&Pose, f64, f64) -> Result<()>| {
            halts(seed, run, way, robot, spacing, clear).map_err(|fault| in_run(fault, run))
        };
        let mut clear = clear;
        Ok(Driven {
            halts: halts_at(spacing, &mut clear)?,
            path: timed(&halts_at((PATH_M, usize::MAX), &mut |_, _, _| Ok(()))?),
        })
    })
}

/// A run's way: where snapshots are taken, and where the robot is between them.
struct Driven {
    halts: Vec<Halt>,
    path: Vec<TimedPose>,
}

/// When the robot is where.
fn timed(halts: &[Halt]) -> Vec<TimedPose> {
    let timed = |halt: &Halt| TimedPose {
        stamp_s: halt.stamp_s,
        pose: halt.pose,
    };
    halts.iter().map(timed).collect()
}

/// The same for each run, on all cores; of several faults that of the first run, whichever was found first.
pub(super) fn each_run<I: IndexedParallelIterator, T: Send>(
    runs: I,
    work: impl Fn(I::Item) -> Result<T> + Sync + Send,
) -> Result<Vec<T>> {
    let all: Vec<Result<T>> = runs.map(work).collect();
    all.into_iter().collect()
}

/// What is known once a run is driven.
struct Finished {
    stops: Vec<Stop>,
    unsteady_rad: Vec<f64>,
    people: Option<People>,
    mapped_at: usize,
}

/// What is left once the stops are known: who comes, where the turret looks, and what odometry says.
fn finish(
    building: &Building,
    seed: Seed,
    set: &RunSet,
    setting: &Setting,
    driven: &Driven,
) -> Result<Finished> {
    let (robot, halts) = (building.robot(), &driven.halts[..]);
    let mapped_at = halts.partition_point(|halt| halt.laps < setting.map_laps);
    let people = match building.people() {
        Some(config) if !halts.is_empty() => {
            let caster = Raycaster::new(setting.later.plan.clone());
            let on_left = building.wall_on_left();
            let outing = Outing {
                path: &driven.path,
                map_until_s: halts.get(mapped_at).map_or(f64::MAX, |halt| halt.stamp_s),
                around: Surroundings::new(&caster, &setting.later.fire_doors),
                radius_m: robot.radius_m,
                wall_on_left: on_left.map(|left| left != setting.back),
            };
            Some(People::new(config, seed, setting.run, &outing)?)
        }
        _ => None,
    };
    let own = own_seed(building, seed, set);
    let mut random = own.numbered_stream("world/turret", setting.run);
    let (mut turret, mut unsteady_rad) = (None, Vec::new());
    match &set.sensors.compass {
        Some(config) if building.turret_north() && !halts.is_empty() => {
            let compass = Compass::new(config.clone(), own)?;
            let turrets = turret_headings(&compass, &timed(halts), &mut random)?;
            unsteady_rad = turrets.iter().map(|turret| turret.unsteady_rad).collect();
            let headings_rad: Vec<f64> = turrets.iter().map(|turret| turret.heading_rad).collect();
            turret = Some((headings_rad, config.north_rad));
        }
        Some(config) => {
            let mut unsteadiness = Unsteadiness::draw(config, &mut random);
            let mut now_s = 0.0;
            unsteady_rad.extend(halts.iter().map(|halt| {
                unsteadiness.pass(config, halt.stamp_s - now_s, &mut random);
                now_s = halt.stamp_s;
                unsteadiness.error_rad(config)
            }));
        }
        None => {}
    }
    let turret = turret.as_ref();
    let turret = turret.map(|(headings_rad, north_rad)| (&headings_rad[..], *north_rad));
    let stops = reckoned(own, setting.run, &robot.odometry, halts, turret);
    Ok(Finished {
        stops,
        unsteady_rad,
        people,
        mapped_at,
    })
}

/// What a robot's odometry and compass, and its way along a wall, are drawn from. A robot with a compass draws anew in each
/// environment, or one draw would serve all that a comparison lines up; one without keeps to the run's own seed, as its recordings
/// always did.
pub(super) fn own_seed(building: &Building, seed: Seed, set: &RunSet) -> Seed {
    match set.sensors.compass {
        Some(_) => seed.within(building.name()),
        None => seed,
    }
}

/// Watches over a run: at its first pose whether the robot stands free and can't get out, from then on whether it hits
/// anything.
fn guard(setting: &Setting, radius_m: f64) -> impl FnMut(&Pose, f64, f64) -> Result<()> + '_ {
    let mut started = false;
    move |pose, route_m, laps| {
        if !std::mem::replace(&mut started, true) {
            let (before, after) = &setting.obstacles;
            for plan in before.iter().chain([after]).map(Raycaster::plan) {
                check_start(plan, setting.run, pose, radius_m)?;
            }
        }
        let plan = setting.obstacles_after(laps).plan();
        check_clear(plan, pose, route_m, radius_m)
    }
}
