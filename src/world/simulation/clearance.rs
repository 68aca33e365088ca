//! Whether a robot stands free, and of which run a fault is told.

use crate::{
    error::{Error, Result},
    geometry::Pose,
    world::{FloorPlan, enclosure::check_enclosed},
};
use nalgebra::Point2;

/// Makes sure that the robot starts in the free and can't get out.
pub(super) fn check_start(plan: &FloorPlan, run: u64, pose: &Pose, radius_m: f64) -> Result<()> {
    check_enclosed(plan, &place(pose), radius_m).map_err(|fault| in_run(fault, run))
}

/// A fault of a run, its number put before it once; that of the call stays as it is.
pub(super) fn in_run(fault: Error, run: u64) -> Error {
    let message = fault.to_string();
    if fault.is_usage() || message.starts_with("run ") {
        fault
    } else {
        Error::work(format!("run {run}: {message}"))
    }
}

/// Makes sure that the robot at a pose is clear of the walls.
pub(super) fn check_clear(
    plan: &FloorPlan,
    pose: &Pose,
    route_m: f64,
    radius_m: f64,
) -> Result<()> {
    if plan.clearance_m(&place(pose)) < radius_m {
        return Err(Error::work(format!(
            "robot: hits a wall {route_m:.2} m along the route, near ({:.2}, {:.2}); expected {radius_m} m of free space around it",
            pose.x_m, pose.y_m
        )));
    }
    Ok(())
}

pub(super) fn place(pose: &Pose) -> Point2<f64> {
    Point2::new(pose.x_m, pose.y_m)
}
