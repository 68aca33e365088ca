//! The way that a robot truly drives in one run: a pose for every metre of it, and where snapshots are taken.

use super::{RobotConfig, Stop, odometry::DeadReckoning};
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

/// A stop, and how often the robot had been round.
pub(super) type Halt = (Stop, f64);

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
/// whether the robot may be at a pose and coordinate of the route; sparse snapshots don't let it jump through walls.
///
/// # Errors
/// A usage error where the spacing is shorter than a step; the first error of `clear`.
pub(super) fn stops(
    seed: Seed,
    run: u64,
    way: &dyn Way,
    config: &RobotConfig,
    (spacing_m, most): (f64, usize),
    mut clear: impl FnMut(&Pose, f64) -> Result<()>,
) -> Result<Vec<Halt>> {
    if !(spacing_m >= STEP_M && spacing_m.is_finite()) {
        return Err(Error::usage(format!(
            "robot: `spacing_m` is {spacing_m}; expected {STEP_M} m or more between snapshots"
        )));
    }
    let mut jitter = seed.numbered_stream("world/robot/heading", run);
    let mut slip = seed.numbered_stream("world/robot/odometry", run);
    let mut reckoning = DeadReckoning::draw(&config.odometry, &mut slip);
    let mut halts: Vec<Halt> = Vec::new();
    let [mut at_m, end_m] = way.span_m();
    let mut here = way.pose(at_m);
    let (mut travelled_m, mut due_m) = (0.0, 0.0);
    while at_m <= end_m {
        clear(&here, way.route_m(at_m))?;
        let next = way.pose(at_m + STEP_M);
        let moved_m = here.distance_m(&next);
        // The spacing is no shorter than a step, so no step holds two stops but for rounding, which `while` takes too.
        while travelled_m + moved_m > due_m && halts.len() < most {
            let stop_m = at_m + STEP_M * (due_m - travelled_m) / moved_m;
            if stop_m > end_m {
                break;
            }
            let mut pose = way.pose(stop_m);
            let normal: f64 = jitter.sample(StandardNormal);
            pose.heading_rad = wrapped(pose.heading_rad + config.heading_sd_rad * normal);
            let odometry = reckoning.reach(&pose, &mut slip);
            let stop = Stop {
                pose,
                route_m: way.route_m(stop_m),
                stamp_s: due_m / config.speed_m_per_s,
                odometry,
            };
            halts.push((stop, way.laps(stop_m)));
            due_m = halts.len() as f64 * spacing_m;
        }
        travelled_m += moved_m;
        at_m += STEP_M;
        here = next;
    }
    Ok(halts)
}
