//! An office: corridors cross blocks of rooms; some blocks are open halls.

use super::{
    chance::Chance,
    frontage::{Frontage, INNER_DOOR_M},
    furnishing::furnish,
    plan::{Gap, Plan, Rectangle},
};
use nalgebra::{Point2, Vector2};

/// A stretch of the building along one axis: a row of blocks, or a corridor.
#[derive(Debug, Clone, Copy)]
struct Strip {
    from_m: f64,
    to_m: f64,
    corridor: bool,
}

/// Blocks deeper than this, between two corridors, have two rows of rooms back to back, metres.
const TWO_ROWS_M: f64 = 5.0;
/// Share of the blocks that are open halls.
const HALL_SHARE: f64 = 0.08;

/// Draws one.
pub(super) fn office(chance: &mut Chance) -> Plan {
    let mut plan = Plan::default();
    let corridor_m = chance.between(1.5, 3.0);
    let rooms = Frontage {
        width_m: chance.one_of(&[[2.2, 3.5], [3.0, 6.0], [4.0, 9.0]]),
        door_share: chance.one_of(&[0.5, 0.8, 1.0]),
        open_share: 0.08,
        niche_m: chance.one_of(&[0.0, 0.0, 0.1, 0.2, 0.4]),
        inner_door_share: 0.15,
        pilaster_share: 0.25,
        cupboard_share: 0.05,
        density: chance.one_of(&[0.2, 0.6, 1.2, 2.0]),
    };
    let upright = chance.below(4);
    let lying = 1 + chance.below(2);
    let across = strips(upright, [8.0, 30.0], corridor_m, chance);
    let up = strips(lying, [3.5, 12.0], corridor_m, chance);
    let whole = Rectangle::new(Point2::origin(), Point2::new(end_m(&across), end_m(&up)));
    plan.enclose(&whole, chance);
    plan.inside.push(whole);
    for (i, column) in across.iter().enumerate() {
        for (j, row) in up.iter().enumerate() {
            let cell = Rectangle::new(
                Point2::new(column.from_m, row.from_m),
                Point2::new(column.to_m, row.to_m),
            );
            if column.corridor || row.corridor {
                if chance.yes(0.5) {
                    furnish(&mut plan, &cell, rooms.density * 0.25, chance);
                }
            } else if cell.size().min() > 0.2 {
                let block = Block {
                    cell,
                    beside: [i > 0, i + 1 < across.len()],
                    before: [j > 0, j + 1 < up.len()],
                };
                block.build(&mut plan, &rooms, chance);
            }
        }
    }
    plan
}

fn end_m(strips: &[Strip]) -> f64 {
    strips.last().map_or(0.0, |strip| strip.to_m)
}

/// Blocks with so many corridors between them.
fn strips(corridors: usize, block_m: [f64; 2], corridor_m: f64, chance: &mut Chance) -> Vec<Strip> {
    let mut strips: Vec<Strip> = Vec::new();
    let mut add = |size_m: f64, corridor: bool| {
        let from_m = end_m(&strips);
        strips.push(Strip {
            from_m,
            to_m: from_m + size_m,
            corridor,
        });
    };
    for block in 0..=corridors {
        let outermost = block == 0 || block == corridors;
        let size_m = if outermost && corridors > 0 && chance.yes(0.25) {
            0.0 // the building ends with a corridor
        } else if !outermost && chance.yes(0.1) {
            chance.between(1.0, 3.0)
        } else {
            chance.between(block_m[0], block_m[1])
        };
        add(size_m, false);
        if block < corridors {
            add(corridor_m * chance.between(0.8, 1.3), true);
        }
    }
    strips
}

/// One block of rooms.
struct Block {
    cell: Rectangle,
    /// Are there corridors to its left and right?
    beside: [bool; 2],
    /// Are there corridors below and above?
    before: [bool; 2],
}

impl Block {
    fn build(&self, plan: &mut Plan, rooms: &Frontage, chance: &mut Chance) {
        let [left, right] = self.beside;
        let [below, above] = self.before;
        if chance.yes(HALL_SHARE) {
            let [a, b, c, d] = self.cell.corners();
            for (is_open, from, to) in [(left, d, a), (right, b, c)] {
                if is_open && chance.yes(0.5) {
                    plan.wall(from, to, chance);
                }
            }
            return furnish(plan, &self.cell, rooms.density, chance);
        }
        // Rooms lie along the corridors below and above, now and then along those at its sides.
        let turned = !(below || above) || ((left || right) && chance.yes(0.2));
        let size = self.cell.size();
        let (along, across, length_m, depth_m) = if turned {
            (Vector2::y(), Vector2::x(), size.y, size.x)
        } else {
            (Vector2::x(), Vector2::y(), size.x, size.y)
        };
        let ([first, second], ends) = if turned {
            (self.beside, self.before)
        } else {
            (self.before, self.beside)
        };
        let at = |s_m: f64, t_m: f64| self.cell.low + along * s_m + across * t_m;
        for (has_corridor, s_m) in ends.into_iter().zip([0.0, length_m]) {
            if has_corridor {
                let gap = chance.yes(0.3).then(|| Gap {
                    middle: chance.between(0.3, 0.7),
                    width_m: INNER_DOOR_M,
                    door: true,
                });
                plan.wall_with_gaps(at(s_m, 0.0), at(s_m, depth_m), gap.as_slice(), chance);
            }
        }
        let near = (at(0.0, 0.0), at(length_m, 0.0));
        let far = (at(0.0, depth_m), at(length_m, depth_m));
        match (first, second) {
            (true, true) if depth_m > TWO_ROWS_M => {
                let middle_m = chance.between(0.4, 0.6) * depth_m;
                plan.wall(at(0.0, middle_m), at(length_m, middle_m), chance);
                rooms.build(plan, near, across, middle_m, chance);
                rooms.build(plan, far, -across, depth_m - middle_m, chance);
            }
            (true, _) => {
                if second {
                    plan.wall(far.0, far.1, chance);
                }
                rooms.build(plan, near, across, depth_m, chance);
            }
            (false, _) => rooms.build(plan, far, -across, depth_m, chance),
        }
    }
}
