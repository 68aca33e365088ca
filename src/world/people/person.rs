//! One person: where they are at a time, and the walls that they are to sensors.

use super::People;
use crate::{
    geometry::Pose,
    world::{Look, Material, Surroundings, Wall, floor_plan::round},
};
use nalgebra::{Point2, Vector2};

/// People farther along the robot's way than this are not there yet, or not any more, metres.
pub(super) const SIGHT_M: f64 = 12.0;
/// Nobody brushes against robot or wall: air left on either side, metres.
pub(super) const MARGIN_M: f64 = 0.02;
/// Faces of the prism that a person is.
const FACES: usize = 12;
/// Where there is no wall within this, there is room enough, metres.
const REACH_M: f64 = 5.0;
/// Heights at which a wall is in a person's way, metres: a bin's, a body's.
const HEIGHTS_M: [f64; 2] = [0.3, 1.0];

/// Clothes: rough, and dull to sound and light. Assumed.
const CLOTH: Material = Material {
    reflectivity: 0.4,
    critical_angle_rad: 1.05,
    infrared: 0.4,
    look: Look {
        contrast: 0.15,
        grain_m: 0.03,
        ..Look::PLAIN
    },
};

/// Someone who keeps to the robot's way, to one side of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Person {
    /// When, and how far along its way, they meet the robot.
    pub met_s: f64,
    pub met_m: f64,
    /// Along the robot's way; negative: towards it; 0: they stand.
    pub speed_m_per_s: f64,
    /// To the left of that way, metres.
    pub aside_m: f64,
    pub body_m: f64,
    pub colour: [f64; 3],
}

impl Person {
    pub fn walks(&self) -> bool {
        self.speed_m_per_s != 0.0
    }

    /// How far along the robot's way they are at a time.
    pub fn way_m(&self, stamp_s: f64) -> f64 {
        self.met_m + self.speed_m_per_s * (stamp_s - self.met_s)
    }

    /// Their walls so far along the way; `None` before its start, past its end, and where the robot leaves no room.
    pub fn body(&self, way_m: f64, robot: &Pose, people: &People) -> Option<Vec<Wall>> {
        let ways_m = people.path.ways_m();
        if !(0.0..=ways_m[ways_m.len() - 1]).contains(&way_m) {
            return None;
        }
        // Where the corridor is narrower than where they met the robot, they keep to this side of its wall.
        let left = self.aside_m > 0.0;
        // All along the body: a door's frame or a pilaster may stand out beside it.
        let first = ways_m.partition_point(|&there_m| there_m <= way_m - self.body_m);
        let past = ways_m.partition_point(|&there_m| there_m <= way_m + self.body_m);
        let free_m = (first.saturating_sub(1)..=past.min(ways_m.len() - 1))
            .map(|index| people.free_m(index, left))
            .fold(f64::INFINITY, f64::min);
        let aside_m = self.aside_m.abs().min(free_m - self.body_m - MARGIN_M);
        let (here, _) = people.path.at_way(way_m);
        let to_left = Vector2::new(-here.heading_rad.sin(), here.heading_rad.cos());
        let signed_m = if left { aside_m } else { -aside_m };
        let centre = Point2::new(here.x_m, here.y_m) + to_left * signed_m;
        // The robot, too, may have come nearer meanwhile: they draw themselves in.
        let room_m = (centre - Point2::new(robot.x_m, robot.y_m)).norm() - people.radius_m;
        let body_m = self.body_m.min(room_m - MARGIN_M / 2.0);
        if body_m < people.config.slim_m / 2.0 {
            return None;
        }
        let mut clothes = CLOTH;
        clothes.look.colour = self.colour;
        let walls = round(centre, body_m, FACES, clothes).into_iter();
        Some(
            walls
                .map(|wall| wall.between(0.0, people.config.height_m))
                .collect(),
        )
    }
}

/// Free way to either side of a pose, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Room {
    left_m: f64,
    right_m: f64,
}

impl Room {
    pub fn beside(pose: &Pose, around: &Surroundings) -> Self {
        let place = Point2::new(pose.x_m, pose.y_m);
        let left = Vector2::new(-pose.heading_rad.sin(), pose.heading_rad.cos());
        let free_m = |direction: Vector2<f64>| {
            HEIGHTS_M
                .iter()
                .filter_map(|&height_m| around.cast(&place, &direction, REACH_M, height_m))
                .map(|hit| hit.distance_m)
                .fold(REACH_M, f64::min)
        };
        Self {
            left_m: free_m(left),
            right_m: free_m(-left),
        }
    }

    pub fn free_m(&self, left: bool) -> f64 {
        if left { self.left_m } else { self.right_m }
    }
}
