//! Rooms cut from one another: wide openings or doors between them, sometimes columns.

use super::{
    chance::Chance,
    frontage::DOOR_WIDTHS_M,
    furnishing::{columns, furnish},
    plan::{Gap, Plan, Rectangle},
};
use nalgebra::Point2;

/// How one such building is cut.
struct Cutting {
    /// Least size of a room, metres.
    least_m: f64,
    /// Are the rooms joined by wide openings?
    wide: bool,
    density: f64,
}

/// Draws one.
pub(super) fn rooms(chance: &mut Chance) -> Plan {
    let mut plan = Plan::default();
    let size = Point2::new(chance.between(10.0, 40.0), chance.between(10.0, 30.0));
    let whole = Rectangle::new(Point2::origin(), size);
    let cutting = Cutting {
        density: chance.one_of(&[0.2, 0.5, 1.0, 1.6]),
        least_m: chance.between(2.5, 7.0),
        wide: chance.yes(0.4),
    };
    plan.enclose(&whole, chance);
    plan.inside.push(whole);
    cutting.cut(&mut plan, whole, 0, chance);
    if chance.yes(0.3) {
        let side_m = chance.between(0.2, 0.6);
        columns(&mut plan, &whole, side_m, [3.0, 6.0], chance);
    }
    plan
}

impl Cutting {
    fn cut(&self, plan: &mut Plan, room: Rectangle, depth: usize, chance: &mut Chance) {
        let size = room.size();
        if size.max() < 2.0 * self.least_m || (depth > 2 && chance.yes(0.12)) {
            return furnish(plan, &room, self.density, chance);
        }
        let count = if size.max() > 8.0 {
            1 + chance.below(2)
        } else {
            1
        };
        let gaps: Vec<Gap> = (0..count).map(|_| self.gap(chance)).collect();
        let at = chance.between(0.3, 0.7);
        let Rectangle { low, high } = room;
        let (one, other) = if size.x > size.y {
            let x_m = low.x + at * size.x;
            (Point2::new(x_m, low.y), Point2::new(x_m, high.y))
        } else {
            let y_m = low.y + at * size.y;
            (Point2::new(low.x, y_m), Point2::new(high.x, y_m))
        };
        plan.wall_with_gaps(one, other, &gaps, chance);
        self.cut(plan, Rectangle::new(low, other), depth + 1, chance);
        self.cut(plan, Rectangle::new(one, high), depth + 1, chance);
    }

    fn gap(&self, chance: &mut Chance) -> Gap {
        Gap {
            middle: chance.between(0.1, 0.9),
            width_m: if self.wide {
                chance.between(1.0, 4.0)
            } else {
                chance.one_of(&DOOR_WIDTHS_M)
            },
            door: !(self.wide || chance.yes(0.3)),
        }
    }
}
