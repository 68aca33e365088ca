//! Long corridors: straight ones, and rings around a block; rooms behind the doors, or only a hint of them.

use super::{
    chance::Chance,
    frontage::{Frontage, INNER_DOOR_M},
    plan::{Gap, Plan, Rectangle},
};
use nalgebra::{Point2, Vector2};

/// How far behind a door the next wall stands where rooms are only hinted at, metres.
const HINT_M: f64 = 0.5;
/// Depth of what lies behind the doors at a straight corridor's ends, metres.
const LOBBY_M: f64 = 3.0;

/// Draws one.
pub(super) fn corridor(chance: &mut Chance) -> Plan {
    let width_m = chance.between(1.5, 3.2);
    let length_m = chance.between(25.0, 75.0);
    let ring = chance.yes(0.65);
    let regular_m = chance.between(2.5, 7.0);
    let rooms = Frontage {
        width_m: if chance.yes(0.6) {
            [regular_m; 2]
        } else {
            [2.2, 9.0]
        },
        door_share: chance.one_of(&[0.5, 0.8, 1.0]),
        open_share: 0.07,
        niche_m: chance.one_of(&[0.0, 0.0, 0.15, 0.3, 0.5]),
        inner_door_share: 0.1,
        pilaster_share: 0.12,
        cupboard_share: 0.1,
        density: chance.one_of(&[0.2, 0.6, 1.2]),
    };
    let drawn_m = chance.between(3.0, 6.5);
    let depth_m = if chance.yes(0.85) { drawn_m } else { HINT_M };
    let height_m = if ring {
        chance.between(12.0, 30.0)
    } else {
        width_m
    };
    let mut plan = Plan::default();
    let whole = Rectangle::new(Point2::origin(), Point2::new(length_m, height_m));
    let [a, b, c, d] = whole.corners();
    let (down, up, left, right) = (-Vector2::y(), Vector2::y(), -Vector2::x(), Vector2::x());
    row(&mut plan, &rooms, (a, b), down, depth_m, chance);
    row(&mut plan, &rooms, (c, d), up, depth_m, chance);
    if !ring {
        plan.inside.push(whole);
        for (from, to, outward) in [(d, a, left), (b, c, right)] {
            lobby(&mut plan, (from, to), outward, chance);
        }
        return plan;
    }
    row(&mut plan, &rooms, (b, c), right, depth_m, chance);
    row(&mut plan, &rooms, (d, a), left, depth_m, chance);
    let inset = Vector2::repeat(width_m);
    let block = Rectangle::new(a + inset, c - inset);
    let [e, f, g, h] = block.corners();
    // The court within is not for the robot, even where a door stands open to it.
    for (one, other) in [(a, f), (b, g), (c, h), (d, e)] {
        plan.inside.push(Rectangle::new(one, other));
    }
    let inner_m = drawn_m.min(block.size().min() / 2.0 - 0.1);
    row(&mut plan, &rooms, (e, f), up, inner_m, chance);
    row(&mut plan, &rooms, (g, h), down, inner_m, chance);
    row(&mut plan, &rooms, (h, e), right, HINT_M, chance);
    row(&mut plan, &rooms, (f, g), left, HINT_M, chance);
    plan
}

/// Rooms along one side of the corridor, with their back and end walls.
fn row(
    plan: &mut Plan,
    rooms: &Frontage,
    (from, to): (Point2<f64>, Point2<f64>),
    inward: Vector2<f64>,
    depth_m: f64,
    chance: &mut Chance,
) {
    let back = inward * depth_m;
    rooms.build(plan, (from, to), inward, depth_m, chance);
    if depth_m > HINT_M {
        for (one, other) in [
            (from, from + back),
            (from + back, to + back),
            (to + back, to),
        ] {
            plan.wall(one, other, chance);
        }
        plan.inside.push(Rectangle::new(from, to + back));
    }
}

/// The end of a straight corridor: a door, and what shows behind it.
fn lobby(
    plan: &mut Plan,
    (from, to): (Point2<f64>, Point2<f64>),
    outward: Vector2<f64>,
    chance: &mut Chance,
) {
    let door = Gap {
        middle: 0.5,
        width_m: INNER_DOOR_M,
        door: true,
    };
    plan.wall_with_gaps(from, to, &[door], chance);
    let back = outward * LOBBY_M;
    for (one, other) in [
        (from, from + back),
        (from + back, to + back),
        (to + back, to),
    ] {
        plan.wall(one, other, chance);
    }
}
