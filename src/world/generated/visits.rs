//! Visits of a building's places: where the robot stands at later ones, and which poses their snapshots are labelled with.

use super::{GeneratedConfig, chance::Chance, plan::Plan};
use crate::{
    geometry::{Pose, wrapped},
    world::Raycaster,
};
use nalgebra::Point2;

/// A later visit comes no nearer to a wall than this, metres.
pub(super) const LEAST_CLEARANCE_M: f64 = 0.15;
/// Where there is a wall, it is tried so often to stand nearer to the place, by this share of the last distance.
const ATTEMPTS: usize = 6;
const NEARER: f64 = 0.6;
/// Snapshots over which a label's drift changes.
const DRIFT_SNAPSHOTS: usize = 60;
/// White noise of the first run's labels, as a share of their drift.
const WHITE: f64 = 0.5;

/// Where the robot stands at a later visit of each place: beside it, on the same side of every wall.
pub(super) fn beside(
    places: &[Pose],
    plan: &Plan,
    caster: &Raycaster,
    config: &GeneratedConfig,
    chance: &mut Chance,
) -> Vec<Pose> {
    let beside_m = chance.one_of(&config.beside_m);
    let turned_rad = chance.between(config.beside_rad[0], config.beside_rad[1]);
    let reached = |place: &Point2<f64>, other: &Point2<f64>| {
        let way = other - place;
        let length_m = way.norm();
        plan.is_inside(other)
            && (length_m < 1e-9 || caster.cast(place, &(way / length_m), length_m).is_none())
            && caster.plan().clearance_m(other) > LEAST_CLEARANCE_M
    };
    let visit = |pose: &Pose| {
        let place = Point2::new(pose.x_m, pose.y_m);
        let mut step = nalgebra::Vector2::new(chance.normal(), chance.normal()) * beside_m;
        let heading_rad = wrapped(pose.heading_rad + turned_rad * chance.normal());
        let mut found = place;
        for _ in 0..ATTEMPTS {
            if reached(&place, &(place + step)) {
                found = place + step;
                break;
            }
            step *= NEARER;
        }
        Pose::new(found.x, found.y, heading_rad)
    };
    places.iter().map(visit).collect()
}

/// Labels of the first run, as mapping yields them: they drift slowly, with a little white noise on top.
pub(super) fn mapped(truth: &[Pose], config: &GeneratedConfig, chance: &mut Chance) -> Vec<Pose> {
    let strength = chance.between(0.0, 1.0);
    let scales = [config.drift_m, config.drift_m, config.drift_rad].map(|most| most * strength);
    let errors = scales.map(|scale| {
        let slow = slow(truth.len(), chance);
        let white = slow
            .into_iter()
            .map(|drift| scale * (drift + WHITE * chance.normal()));
        white.collect::<Vec<f64>>()
    });
    let [x_m, y_m, heading_rad] = errors;
    let label = |(k, pose): (usize, &Pose)| off(pose, x_m[k], y_m[k], heading_rad[k]);
    truth.iter().enumerate().map(label).collect()
}

/// Labels of later visits: each with an error of its own.
pub(super) fn localised(
    truth: &[Pose],
    config: &GeneratedConfig,
    chance: &mut Chance,
) -> Vec<Pose> {
    let label = |pose: &Pose| {
        let [x_m, y_m] = [(); 2].map(|()| config.label_noise_m * chance.normal());
        off(pose, x_m, y_m, config.label_noise_rad * chance.normal())
    };
    truth.iter().map(label).collect()
}

fn off(pose: &Pose, x_m: f64, y_m: f64, turn_rad: f64) -> Pose {
    Pose::new(
        pose.x_m + x_m,
        pose.y_m + y_m,
        wrapped(pose.heading_rad + turn_rad),
    )
}

/// Numbers of mean 0 and standard deviation 1 that change over [`DRIFT_SNAPSHOTS`]: moving sums of white noise.
fn slow(count: usize, chance: &mut Chance) -> Vec<f64> {
    let white: Vec<f64> = (0..count + DRIFT_SNAPSHOTS)
        .map(|_| chance.normal())
        .collect();
    let sums = white.windows(DRIFT_SNAPSHOTS).take(count);
    sums.map(|window| window.iter().sum::<f64>() / (DRIFT_SNAPSHOTS as f64).sqrt())
        .collect()
}
