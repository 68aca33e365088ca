//! A hall: partitions, round and square columns, and openings with what shows behind them.

use super::{
    chance::Chance,
    furnishing::{columns, furnish},
    plan::{Gap, Plan, Rectangle},
};
use nalgebra::{Point2, Vector2};
use std::f64::consts::{FRAC_PI_2, PI};

/// How far beyond its walls the next walls stand, metres.
const BEHIND_M: f64 = 4.0;

/// Draws one.
pub(super) fn hall(chance: &mut Chance) -> Plan {
    let mut plan = Plan::default();
    let size = Point2::new(chance.between(14.0, 45.0), chance.between(12.0, 35.0));
    let whole = Rectangle::new(Point2::origin(), size);
    plan.inside.push(whole);
    let corners = whole.corners();
    for (index, corner) in corners.iter().enumerate() {
        let gaps: Vec<Gap> = (0..chance.below(4))
            .map(|_| Gap {
                middle: chance.between(0.1, 0.9),
                width_m: chance.between(0.9, 4.0),
                door: chance.yes(0.5),
            })
            .collect();
        plan.wall_with_gaps(*corner, corners[(index + 1) % 4], &gaps, chance);
    }
    let beyond = Vector2::repeat(BEHIND_M);
    plan.enclose(
        &Rectangle::new(whole.low - beyond, whole.high + beyond),
        chance,
    );
    let area_m2 = whole.area_m2();
    let partitions = area_m2 / chance.between(25.0, 90.0);
    for _ in 0..chance.count(partitions) {
        let turn_rad = if chance.yes(0.7) {
            chance.one_of(&[0.0, FRAC_PI_2])
        } else {
            chance.between(0.0, PI)
        };
        let size = Vector2::new(chance.between(1.5, 8.0), chance.between(0.08, 0.5));
        let place = whole.place(chance);
        plan.fixed_box(place, size, turn_rad, chance);
    }
    let lone_columns = area_m2 / chance.between(20.0, 80.0);
    for _ in 0..chance.count(lone_columns) {
        let (place, radius_m) = (whole.place(chance), chance.between(0.1, 0.6));
        if chance.yes(0.5) {
            let turn_rad = chance.between(0.0, FRAC_PI_2);
            plan.fixed_box(place, Vector2::repeat(radius_m), turn_rad, chance);
        } else {
            plan.round_column(place, radius_m, chance);
        }
    }
    if chance.yes(0.5) {
        columns(&mut plan, &whole, 0.4, [4.0, 7.0], chance);
    }
    let density = chance.one_of(&[0.02, 0.1, 0.3]);
    furnish(&mut plan, &whole, density, chance);
    plan
}
