//! A wall along a corridor and the rooms behind it: doors, some of them set back in niches, pilasters, cupboards.

use super::{
    chance::Chance,
    furnishing::furnish,
    plan::{Gap, Plan, Rectangle},
};
use nalgebra::{Point2, Vector2};

/// Widths of doors, metres: single ones of two standards, wide ones, double ones.
pub(super) const DOOR_WIDTHS_M: [f64; 4] = [0.85, 0.95, 1.2, 1.8];
/// Width of a door between two rooms, metres.
pub(super) const INNER_DOOR_M: f64 = 0.9;
/// Rooms no deeper than this are only hinted at: nothing divides or furnishes them.
const HINTED_M: f64 = 1.0;
/// Rooms narrower than this have no niche.
const NICHE_ROOM_M: f64 = 2.5;

/// How the rooms along one wall are drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frontage {
    /// Least and greatest width of a room, metres.
    pub width_m: [f64; 2],
    /// Share of the rooms with a door to the corridor.
    pub door_share: f64,
    /// Share of those doors that are openings without a leaf.
    pub open_share: f64,
    /// How far doors are set back, metres; 0: not at all.
    pub niche_m: f64,
    /// Share of the dividing walls with a door.
    pub inner_door_share: f64,
    /// Share of the rooms that a pilaster begins at.
    pub pilaster_share: f64,
    /// Share of the rooms with a cupboard or bin before them.
    pub cupboard_share: f64,
    /// Density of the furniture.
    pub density: f64,
}

impl Frontage {
    /// Builds the rooms from one point to another; they lie `depth_m` deep on the side that the unit vector `inward`
    /// points to. Walls at both ends and at the back are left to the caller.
    pub fn build(
        &self,
        plan: &mut Plan,
        (from, to): (Point2<f64>, Point2<f64>),
        inward: Vector2<f64>,
        depth_m: f64,
        chance: &mut Chance,
    ) {
        let length_m = (to - from).norm();
        if length_m < 0.1 {
            return;
        }
        let along = (to - from) / length_m;
        let mut done_m = 0.0;
        while done_m < length_m - 0.1 {
            let left_m = length_m - done_m;
            let mut width_m = chance.between(self.width_m[0], self.width_m[1]);
            if left_m - width_m < self.width_m[0].min(2.0) {
                width_m = left_m;
            }
            let begin = from + along * done_m;
            let end = begin + along * width_m;
            self.front(plan, begin, end, inward, chance);
            self.before(plan, begin, along * width_m, inward, chance);
            if depth_m > HINTED_M {
                if width_m < left_m {
                    let gaps = chance.yes(self.inner_door_share).then(|| Gap {
                        middle: chance.between(0.3, 0.7),
                        width_m: INNER_DOOR_M,
                        door: true,
                    });
                    plan.wall_with_gaps(end, end + inward * depth_m, gaps.as_slice(), chance);
                }
                let room = Rectangle::new(begin, end + inward * depth_m);
                furnish(plan, &room, self.density, chance);
            }
            done_m += width_m;
        }
    }

    /// The wall before one room.
    fn front(
        &self,
        plan: &mut Plan,
        begin: Point2<f64>,
        end: Point2<f64>,
        inward: Vector2<f64>,
        chance: &mut Chance,
    ) {
        if !chance.yes(self.door_share) {
            return plan.wall(begin, end, chance);
        }
        let width_m = (end - begin).norm();
        let gap = Gap {
            middle: chance.between(0.22, 0.78),
            width_m: chance.one_of(&DOOR_WIDTHS_M),
            door: !chance.yes(self.open_share),
        };
        let half = gap.width_m / 2.0 + 0.2;
        let middle_m = gap.middle * width_m;
        let fits = middle_m - half > 0.0 && middle_m + half < width_m;
        let set_back = self.niche_m > 0.0 && width_m > NICHE_ROOM_M && fits;
        if !(set_back && chance.yes(0.8)) {
            return plan.wall_with_gaps(begin, end, &[gap], chance);
        }
        let along = (end - begin) / width_m;
        let (one, other) = (
            begin + along * (middle_m - half),
            begin + along * (middle_m + half),
        );
        let back = inward * self.niche_m;
        plan.wall(begin, one, chance);
        plan.wall(one, one + back, chance);
        let centred = Gap { middle: 0.5, ..gap };
        plan.wall_with_gaps(one + back, other + back, &[centred], chance);
        plan.wall(other + back, other, chance);
        plan.wall(other, end, chance);
    }

    /// What stands in the corridor before a room.
    fn before(
        &self,
        plan: &mut Plan,
        begin: Point2<f64>,
        along: Vector2<f64>,
        inward: Vector2<f64>,
        chance: &mut Chance,
    ) {
        if chance.yes(self.pilaster_share) {
            let side_m = chance.between(0.2, 0.4);
            let centre = begin - inward * (side_m / 4.0);
            plan.fixed_box(centre, Vector2::repeat(side_m), 0.0, chance);
        }
        if chance.yes(self.cupboard_share) {
            let size = Vector2::new(chance.between(0.3, 0.9), chance.between(0.3, 0.9));
            let centre =
                begin + along * chance.between(0.0, 1.0) - inward * chance.between(0.15, 0.3);
            if chance.yes(0.5) {
                plan.fixed_box(centre, size, 0.0, chance);
            } else {
                plan.loose_box(centre, size, 0.0, chance);
            }
        }
    }
}
