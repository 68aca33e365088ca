//! Furniture: cupboards and tables along the walls or in the room, which stay, and small things, which do not.

use super::{
    chance::Chance,
    plan::{Plan, Rectangle},
};
use nalgebra::{Point2, Vector2};
use std::f64::consts::PI;

/// Things that stay a square metre, at density 1.
const FIXED_PER_M2: f64 = 0.18;
/// Loose things a square metre, at density 1.
const LOOSE_PER_M2: f64 = 0.15;

/// Furnishes a room.
pub(super) fn furnish(plan: &mut Plan, room: &Rectangle, density: f64, chance: &mut Chance) {
    for _ in 0..chance.count(density * room.area_m2() * FIXED_PER_M2) {
        let (depth_m, length_m) = (chance.between(0.3, 1.0), chance.between(0.5, 2.0));
        let mut place = room.place(chance);
        let upright = Vector2::new(depth_m, length_m);
        let mut turn_rad = 0.0;
        let size = match chance.below(5) {
            0 => {
                place.x = room.low.x + depth_m / 2.0;
                upright
            }
            1 => {
                place.x = room.high.x - depth_m / 2.0;
                upright
            }
            2 => {
                place.y = room.low.y + depth_m / 2.0;
                upright.yx()
            }
            3 => {
                place.y = room.high.y - depth_m / 2.0;
                upright.yx()
            }
            _ => {
                if chance.yes(0.4) {
                    turn_rad = chance.between(0.0, PI);
                }
                upright
            }
        };
        plan.fixed_box(place, size, turn_rad, chance);
    }
    for _ in 0..chance.count(density * room.area_m2() * LOOSE_PER_M2) {
        let side_m = chance.between(0.04, 0.45);
        let (place, turn_rad) = (room.place(chance), chance.between(0.0, PI));
        plan.loose_box(place, Vector2::repeat(side_m), turn_rad, chance);
    }
}

/// Rows of square columns, all alike, from wall to wall.
pub(super) fn columns(
    plan: &mut Plan,
    room: &Rectangle,
    side_m: f64,
    apart_m: [f64; 2],
    chance: &mut Chance,
) {
    let [least_m, most_m] = apart_m;
    let mut marks = |low: f64, high: f64| -> Vec<f64> {
        let first = low + chance.between(1.0, least_m);
        let apart = chance.between(least_m, most_m);
        let count = ((high - first) / apart).ceil().max(0.0) as usize;
        (0..count).map(|mark| first + apart * mark as f64).collect()
    };
    let (across, up) = (
        marks(room.low.x, room.high.x),
        marks(room.low.y, room.high.y),
    );
    for &x_m in &across {
        for &y_m in &up {
            plan.fixed_box(Point2::new(x_m, y_m), Vector2::repeat(side_m), 0.0, chance);
        }
    }
}
