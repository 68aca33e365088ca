//! The way that a robot truly drives in one run: a pose for every metre of it, and where snapshots are taken.

use super::{OdometryConfig, RobotConfig, Stop, odometry::DeadReckoning};
use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    seed::Seed,
};
use rand::RngExt;
use rand_distr::StandardNormal;

/// The way driven is measured in steps of this length, metres.
pub(super) const STEP_M: f64 = 0.02;

/// A way driven, with a parameter in metres: about, but not quite, the metres travelled.
pub(super) trait Way: Send + Sync {
    /// Where it begins and ends.
    fn span_m(&self) -> [f64; 2];

    /// The true pose, also a little past the end.
    fn pose(&self, at_m: f64) -> Pose;

    /// Coordinate along the route, the same for the same place in every run and lap, metres.
    fn route_m(&self, at_m: f64) -> f64;

    /// Times that the robot has been round.
    fn laps(&self, at_m: f64) -> f64;
}

/// Where the robot is when a snapshot is taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Halt {
    /// The true pose.
    pub(super) pose: Pose,
    /// Coordinate along the route, metres.
    pub(super) route_m: f64,
    /// Seconds since the run began.
    pub(super) stamp_s: f64,
    /// Times that the robot has been round.
    pub(super) laps: f64,
}

/// Metres travelled from begin to end.
pub(super) fn travelled_m(way: &dyn Way) -> f64 {
    let [mut at_m, end_m] = way.span_m();
    let mut here = way.pose(at_m);
    let mut travelled_m = 0.0;
    while at_m < end_m {
        at_m = (at_m + STEP_M).min(end_m);
        let next = way.pose(at_m);
        travelled_m += here.distance_m(&next);
        here = next;
    }
    travelled_m
}

/// Stops for a snapshot every `spacing_m` metres of travel, `most` times at most.
///
/// The way doesn't depend on the spacing: denser snapshots change none of it. Every two centimetres, `clear` is asked
/// whether the robot may be at a pose and coordinate of the route after so many laps; sparse snapshots don't let it jump through walls.
///
/// # Errors
/// A usage error where the spacing is shorter than a step; the first error of `clear`.
pub(super) fn halts(
    seed: Seed,
    run: u64,
    way: &dyn Way,
    config: &RobotConfig,
    (spacing_m, most): (f64, usize),
    mut clear: impl FnMut(&Pose, f64, f64) -> Result<()>,
) -> Result<Vec<Halt>> {
    if !(spacing_m >= STEP_M && spacing_m.is_finite()) {
        return Err(Error::usage(format!(
            "robot: `spacing_m` is {spacing_m}; expected {STEP_M} m or more between snapshots"
        )));
    }
    let mut jitter = seed.numbered_stream("world/robot/heading", run);
    let mut halts: Vec<Halt> = Vec::new();
    let [mut at_m, end_m] = way.span_m();
    let mut here = way.pose(at_m);
    let (mut travelled_m, mut due_m) = (0.0, 0.0);
    while at_m <= end_m {
        clear(&here, way.route_m(at_m), way.laps(at_m))?;
        let next = way.pose(at_m + STEP_M);
        let moved_m = here.distance_m(&next);
        // The spacing is no shorter than a step, so no step holds two stops but for rounding, which `while` takes too.
        while moved_m > 0.0 && travelled_m + moved_m > due_m && halts.len() < most {
            let stop_m = at_m + STEP_M * (due_m - travelled_m) / moved_m;
            if stop_m > end_m {
                break;
            }
            let mut pose = way.pose(stop_m);
            let normal: f64 = jitter.sample(StandardNormal);
            pose.heading_rad = wrapped(pose.heading_rad + config.heading_sd_rad * normal);
            halts.push(Halt {
                pose,
                route_m: way.route_m(stop_m),
                stamp_s: due_m / config.speed_m_per_s,
                laps: way.laps(stop_m),
            });
            due_m = halts.len() as f64 * spacing_m;
        }
        travelled_m += moved_m;
        at_m += STEP_M;
        here = next;
    }
    Ok(halts)
}

/// Dead-reckons from halt to halt.
///
/// With a turret, of the true headings and the one it is held to, sensors look where it does: poses and odometry of the
/// stops are the turret's, whose angle against the base is known.
pub(super) fn reckoned(
    seed: Seed,
    run: u64,
    odometry: &OdometryConfig,
    halts: &[Halt],
    turret: Option<(&[f64], f64)>,
) -> Vec<Stop> {
    let mut slip = seed.numbered_stream("world/robot/odometry", run);
    let mut reckoning = DeadReckoning::draw(odometry, &mut slip);
    let stop = |(index, halt): (usize, &Halt)| {
        let looks_rad = turret.map(|(headings_rad, north_rad)| (headings_rad[index], north_rad));
        let error_rad = looks_rad.map_or(0.0, |(looks, north)| wrapped(looks - north));
        let mut pose = halt.pose;
        let mut odometry = reckoning.reach_beside(&pose, error_rad, &mut slip);
        if let Some((looks_rad, _)) = looks_rad {
            odometry.heading_rad = wrapped(odometry.heading_rad + looks_rad - pose.heading_rad);
            pose.heading_rad = looks_rad;
        }
        Stop {
            pose,
            route_m: halt.route_m,
            stamp_s: halt.stamp_s,
            odometry,
        }
    };
    halts.iter().enumerate().map(stop).collect()
}
