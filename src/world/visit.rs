//! A robot that goes from one prescribed pose to the next, straight, and takes a snapshot at each.

use super::{
    RobotConfig,
    way::{Halt, STEP_M},
};
use crate::{
    error::Result,
    geometry::{Pose, wrapped},
    seed::{Seed, Stream},
};
use rand::RngExt;
use rand_distr::StandardNormal;

/// Visits the poses in their order, `laps` times over (a share of a lap is a share of the poses), each a little off
/// (within its limit), as the robot's constants have it. `back`: in the opposite order. Coordinates along the route are
/// those of the poses as prescribed.
///
/// # Errors
/// The first error of `clear`, which is asked every two centimetres.
pub(super) fn visit(
    seed: Seed,
    run: u64,
    poses: &[Pose],
    (laps, back): (f64, bool),
    config: &RobotConfig,
    mut clear: impl FnMut(&Pose, f64, f64) -> Result<()>,
) -> Result<Vec<Halt>> {
    let mut path = seed.numbered_stream("world/robot/path", run);
    let mut jitter = seed.numbered_stream("world/robot/heading", run);
    let mut prescribed_m = vec![0.0];
    for pair in poses.windows(2) {
        prescribed_m.push(prescribed_m[prescribed_m.len() - 1] + pair[0].distance_m(&pair[1]));
    }
    let count = (laps * poses.len() as f64).round() as usize;
    let mut halts: Vec<Halt> = Vec::with_capacity(count);
    let mut travelled_m = 0.0;
    for visit in 0..count {
        let laps = visit as f64 / poses.len() as f64;
        let on = visit % poses.len();
        let index = if back { poses.len() - 1 - on } else { on };
        let asked = poses[index];
        let mut off_m = || {
            let free_m = config.lateral_sd_m * normal(&mut path);
            config.lateral_limit_m * (free_m / config.lateral_limit_m).tanh()
        };
        let turned_rad = config.heading_sd_rad * normal(&mut jitter);
        let pose = Pose::new(
            asked.x_m + off_m(),
            asked.y_m + off_m(),
            wrapped(asked.heading_rad + turned_rad),
        );
        let from = halts.last().map_or(pose, |halt| halt.pose);
        let moved_m = from.distance_m(&pose);
        for step in 0..=(moved_m / STEP_M) as usize {
            let share = (step as f64 * STEP_M / moved_m.max(STEP_M)).min(1.0);
            let between = Pose::new(
                from.x_m + share * (pose.x_m - from.x_m),
                from.y_m + share * (pose.y_m - from.y_m),
                pose.heading_rad,
            );
            clear(&between, prescribed_m[index], laps)?;
        }
        clear(&pose, prescribed_m[index], laps)?;
        travelled_m += moved_m;
        halts.push(Halt {
            pose,
            route_m: prescribed_m[index],
            stamp_s: travelled_m / config.speed_m_per_s,
            laps,
        });
    }
    Ok(halts)
}

fn normal(random: &mut Stream) -> f64 {
    random.sample(StandardNormal)
}
