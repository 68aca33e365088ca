//! A building at one moment: which doors stand how far open, which things are there and where.

use super::{
    chance::Chance,
    plan::{Doorway, Plan, Thing},
};
use crate::world::{Material, Wall};
use nalgebra::{Point2, Rotation2, Vector2};

/// A shut leaf stands this far to one side of the middle of its wall, metres.
const LEAF_ASIDE_M: f64 = 0.08;
/// A leaf opened farther than this leans on the wall and shows no more, radians.
const FOLDED_RAD: f64 = 2.4;
/// Least and greatest angle that doors are opened to, radians.
const OPENED_RAD: [f64; 2] = [0.3, 2.6];
/// Share of the loose things that are somewhere else when first seen.
const AWAY: f64 = 0.15;
/// Share of the loose things that were touched and are not put back.
const TAKEN_AWAY: f64 = 0.5;
/// How far loose things are moved: standard deviation on both axes, metres.
const MOVED_M: f64 = 0.4;
/// How much rarer than a door a thing that stays is changed.
const FIXED_CHANGED: f64 = 0.15;
/// Where the robot went nothing is put nearer than this, metres.
const KEPT_CLEAR_M: f64 = 0.2;

/// How a door stands.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Door {
    open: bool,
    /// Is the hinge at the doorway's first jamb?
    first_jamb: bool,
    angle_rad: f64,
    /// The side that it opens to: 1 or −1.
    side: f64,
}

/// How every door stands and where every thing is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moment {
    doors: Vec<Door>,
    /// Are things that stay there?
    fixed: Vec<bool>,
    /// Where loose things are against where they were drawn; `None`: away.
    loose: Vec<Option<Vector2<f64>>>,
}

impl Moment {
    /// The moment at which the robot comes first; this share of the doors is open.
    pub fn first(plan: &Plan, openness: f64, chance: &mut Chance) -> Self {
        let loose = plan.loose.iter();
        Self {
            doors: plan
                .doorways
                .iter()
                .map(|_| Door::draw(openness, chance))
                .collect(),
            fixed: vec![true; plan.fixed.len()],
            loose: loose
                .map(|_| (!chance.yes(AWAY)).then(Vector2::zeros))
                .collect(),
        }
    }

    /// A later moment: this share of doors and loose things has been touched, but for those that would now stand in the
    /// way at one of the `places`.
    pub fn later(
        &self,
        plan: &Plan,
        (openness, changed): (f64, f64),
        places: &[Point2<f64>],
        chance: &mut Chance,
    ) -> Self {
        let clear = |walls: &[Wall]| {
            walls
                .iter()
                .all(|wall| places.iter().all(|p| wall.distance_m(p) >= KEPT_CLEAR_M))
        };
        let door = |(doorway, &before): (&Doorway, &Door)| {
            if !chance.yes(changed) {
                return before;
            }
            let now = Door::draw(openness, chance);
            if clear(now.leaf(doorway).as_slice()) {
                now
            } else {
                before
            }
        };
        let doors = plan.doorways.iter().zip(&self.doors).map(door).collect();
        let fixed = self.fixed.iter();
        let fixed = fixed
            .map(|there| *there && !chance.yes(changed * FIXED_CHANGED))
            .collect();
        let thing = |(thing, &before): (&Thing, &Option<Vector2<f64>>)| {
            if !chance.yes(changed) {
                return before;
            }
            let step = Vector2::new(chance.normal(), chance.normal()) * MOVED_M;
            let now = (!chance.yes(TAKEN_AWAY)).then(|| before.unwrap_or_default() + step);
            match now {
                Some(shift) if !clear(&shifted(thing, shift)) => before,
                _ => now,
            }
        };
        Self {
            doors,
            fixed,
            loose: plan.loose.iter().zip(&self.loose).map(thing).collect(),
        }
    }

    /// All walls that stand at this moment.
    pub fn walls(&self, plan: &Plan) -> Vec<Wall> {
        let mut walls = plan.walls.clone();
        let doors = plan.doorways.iter().zip(&self.doors);
        walls.extend(doors.filter_map(|(doorway, door)| door.leaf(doorway)));
        let fixed = plan.fixed.iter().zip(&self.fixed);
        walls.extend(
            fixed
                .filter(|(_, there)| **there)
                .flat_map(|(thing, _)| thing),
        );
        for (thing, shift) in plan.loose.iter().zip(&self.loose) {
            if let Some(shift) = shift {
                walls.extend(shifted(thing, *shift));
            }
        }
        walls
    }

    /// How many doors stand another way than at an earlier moment.
    #[cfg(test)]
    pub fn doors_changed(&self, earlier: &Self) -> usize {
        let both = self.doors.iter().zip(&earlier.doors);
        both.filter(|(now, then)| now != then).count()
    }
}

impl Door {
    fn draw(openness: f64, chance: &mut Chance) -> Self {
        Self {
            open: chance.yes(openness),
            first_jamb: chance.yes(0.5),
            angle_rad: chance.between(OPENED_RAD[0], OPENED_RAD[1]),
            side: chance.one_of(&[-1.0, 1.0]),
        }
    }

    /// The leaf as a wall, where it shows.
    fn leaf(&self, doorway: &Doorway) -> Option<Wall> {
        let (hinge, other) = if self.first_jamb {
            (doorway.from, doorway.to)
        } else {
            (doorway.to, doorway.from)
        };
        let shut = other - hinge;
        let material = Material {
            critical_angle_rad: 0.3,
            ..Material::PLAIN
        };
        if !self.open {
            let aside = Vector2::new(-shut.y, shut.x).normalize() * (self.side * LEAF_ASIDE_M);
            return Some(Wall::new(hinge + aside, other + aside, material));
        }
        let turned = Rotation2::new(self.angle_rad * self.side) * shut;
        (self.angle_rad < FOLDED_RAD).then(|| Wall::new(hinge, hinge + turned, material))
    }
}

fn shifted(thing: &Thing, shift: Vector2<f64>) -> Thing {
    let moved = thing.iter().map(|wall| Wall {
        from: wall.from + shift,
        to: wall.to + shift,
        ..*wall
    });
    moved.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seed::Seed;

    /// One metre of doorway along x.
    fn doorway() -> Doorway {
        Doorway {
            from: Point2::origin(),
            to: Point2::new(1.0, 0.0),
        }
    }

    #[test]
    fn leaves_turn_on_their_hinge() {
        let door = |open, first_jamb, angle_rad, side| Door {
            open,
            first_jamb,
            angle_rad,
            side,
        };
        let ends = |door: Door| {
            let leaf = door.leaf(&doorway()).unwrap();
            [leaf.from.x, leaf.from.y, leaf.to.x, leaf.to.y]
        };
        let right = std::f64::consts::FRAC_PI_2;
        for (door, expected) in [
            (door(false, true, 1.0, 1.0), [0.0, 0.08, 1.0, 0.08]),
            (door(true, true, right, 1.0), [0.0, 0.0, 0.0, 1.0]),
            (door(true, true, right, -1.0), [0.0, 0.0, 0.0, -1.0]),
            (door(true, false, right, 1.0), [1.0, 0.0, 1.0, -1.0]),
        ] {
            let found = ends(door);
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-12, "{found:?}");
        }
        assert!(door(true, true, 2.5, 1.0).leaf(&doorway()).is_none());
    }

    #[test]
    fn doors_change_but_none_swings_to_where_the_robot_went() {
        let mut plan = Plan::default();
        plan.doorways = vec![doorway(); 40];
        let mut chance = Chance(Seed(3).stream("doors"));
        let first = Moment::first(&plan, 1.0, &mut chance);
        assert_eq!(first, first.later(&plan, (0.5, 0.0), &[], &mut chance));
        let shut = first.later(&plan, (0.0, 1.0), &[], &mut chance);
        assert_eq!(shut.doors_changed(&first), 40);
        let went = [Point2::new(0.5, 0.0)];
        let kept = first.later(&plan, (0.0, 1.0), &went, &mut chance);
        assert_eq!(kept.doors_changed(&first), 0);
    }
}
