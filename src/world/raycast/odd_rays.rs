//! Plans and rays that are hard on a grid of cells.

use super::Raycaster;
use crate::{
    seed::Seed,
    world::{FloorPlan, Material, Wall},
};
use nalgebra::{Point2, Vector2};
use rand::RngExt;
use std::f64::consts::{PI, TAU};

/// How far the rays are to be followed, metres.
pub(super) const REACH_M: f64 = 12.0;

/// Asks about every ray through every plan: wide plans, flat plans, upright and slanted walls, and coordinates on round
/// numbers, so that rays run along cell edges and meet two walls at once.
pub(super) fn odd_rays(mut ask: impl FnMut(&FloorPlan, &Raycaster, &Point2<f64>, &Vector2<f64>)) {
    let mut random = Seed(3).stream("walls");
    for case in 0..40 {
        let height = [20.0, 0.5, 4.0, 0.0][case % 4];
        let mut point = || {
            let (x, y) = (
                random.random_range(-10.0..10.0_f64),
                random.random_range(-0.5..=0.5) * height,
            );
            if case % 2 == 0 {
                Point2::new(x.round(), f64::round(y))
            } else {
                Point2::new(x, y)
            }
        };
        let walls: Vec<Wall> = (0..1 + case * 3)
            .map(|_| Wall::new(point(), point(), Material::PLAIN))
            .filter(|wall| wall.from != wall.to)
            .collect();
        let Ok(plan) = FloorPlan::new(walls) else {
            continue;
        };
        let caster = Raycaster::new(plan.clone());
        for ray in 0..600 {
            let origin = Point2::new(
                random.random_range(-15.0..15.0_f64),
                random.random_range(-12.0..12.0_f64),
            );
            let origin = if ray % 3 == 0 {
                origin.map(f64::round)
            } else {
                origin
            };
            let angle = if ray % 4 == 0 {
                (ray / 4) as f64 * PI / 4.0
            } else {
                random.random_range(0.0..TAU)
            };
            let direction = Vector2::new(angle.cos(), angle.sin());
            ask(&plan, &caster, &origin, &direction);
        }
    }
}
