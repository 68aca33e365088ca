//! A straight wall, and the doors that open in it into rooms.

use super::{Material, Wall};
use nalgebra::{Point2, Rotation2, Vector2};

/// A straight wall of a corridor, before anything is cut into it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallLine {
    /// Where it starts, metres.
    pub from: Point2<f64>,
    /// Where it ends, metres.
    pub to: Point2<f64>,
    /// Is the corridor on its left, seen from `from` to `to`? Rooms and niches lie on the other side.
    pub corridor_on_left: bool,
    /// What it is made of.
    pub material: Material,
}

/// A door, set back in its frame, that swings into the room behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenDoor {
    /// Where it begins, in metres from the start of the wall.
    pub at_m: f64,
    /// How wide it is, in metres.
    pub width_m: f64,
    /// Depth of the frame, metres.
    pub setback_m: f64,
    /// 0: shut; π/2: wide open.
    pub opened_rad: f64,
    /// What lies behind it.
    pub room: Room,
    /// Material of the leaf.
    pub leaf: Material,
    /// Material of the two sides of the frame.
    pub frame: Material,
}

/// A rectangular room behind a door.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// How far it reaches before the door, along the wall, metres.
    pub before_m: f64,
    /// How far it reaches past the door, metres.
    pub after_m: f64,
    /// Depth behind the frame, metres.
    pub depth_m: f64,
}

impl WallLine {
    /// Length in metres.
    pub fn length_m(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// The point `along_m` metres from the start and `behind_m` metres behind the face (negative: in the corridor).
    pub fn point(&self, along_m: f64, behind_m: f64) -> Point2<f64> {
        let along = (self.to - self.from).normalize();
        let left = Vector2::new(-along.y, along.x);
        let behind = if self.corridor_on_left { -left } else { left };
        self.from + along * along_m + behind * behind_m
    }

    /// The walls of a door: its frame, the room behind it, and its leaf. The wall itself, cut where the door begins and
    /// ends, is not among them.
    ///
    /// ```
    /// use ballmark::world::{Material, OpenDoor, Room, WallLine};
    /// use nalgebra::Point2;
    /// let plain = Material::PLAIN;
    /// let line = WallLine { from: Point2::origin(), to: Point2::new(9.0, 0.0), corridor_on_left: true, material: plain };
    /// let room = Room { before_m: 1.0, after_m: 0.0, depth_m: 3.0 };
    /// let door = OpenDoor { at_m: 2.0, width_m: 1.0, setback_m: 0.1, opened_rad: 0.0, room, leaf: plain, frame: plain };
    /// let walls = line.door(&door);
    /// assert_eq!(walls.len(), 7); // two sides of the frame, three of the room, one piece beside the door, the leaf
    /// let leaf = walls[6];
    /// assert!((leaf.to - Point2::new(3.0, -0.1)).norm() < 1e-12); // shut
    /// ```
    pub fn door(&self, door: &OpenDoor) -> Vec<Wall> {
        let (start_m, end_m) = (door.at_m, door.at_m + door.width_m);
        let OpenDoor {
            setback_m,
            room,
            frame,
            ..
        } = *door;
        let (left_m, right_m) = (start_m - room.before_m, end_m + room.after_m);
        let back_m = setback_m + room.depth_m;
        let mut outline = vec![
            ([start_m, 0.0], [start_m, setback_m], frame),
            ([end_m, setback_m], [end_m, 0.0], frame),
            ([left_m, setback_m], [left_m, back_m], self.material),
            ([left_m, back_m], [right_m, back_m], self.material),
            ([right_m, back_m], [right_m, setback_m], self.material),
        ];
        if room.before_m > 0.0 {
            outline.push(([left_m, setback_m], [start_m, setback_m], self.material));
        }
        if room.after_m > 0.0 {
            outline.push(([end_m, setback_m], [right_m, setback_m], self.material));
        }
        let swung = Rotation2::new(door.opened_rad) * Vector2::new(door.width_m, 0.0);
        let tip = [start_m + swung.x, setback_m + swung.y];
        outline.push(([start_m, setback_m], tip, door.leaf));
        let wall = |(from, to, material): ([f64; 2], [f64; 2], Material)| {
            Wall::new(
                self.point(from[0], from[1]),
                self.point(to[0], to[1]),
                material,
            )
        };
        outline.into_iter().map(wall).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{FloorPlan, Raycaster};
    use std::f64::consts::FRAC_PI_2;

    /// Distance straight up from (x, 0) in the corridor to a wall with a door from 4 m to 5 m.
    fn ahead_m(opened_rad: f64, x_m: f64) -> f64 {
        let plain = Material::PLAIN;
        let line = WallLine {
            from: Point2::new(0.0, 1.0),
            to: Point2::new(10.0, 1.0),
            corridor_on_left: false,
            material: plain,
        };
        let room = Room {
            before_m: 1.0,
            after_m: 0.5,
            depth_m: 3.0,
        };
        let mut walls = line.door(&OpenDoor {
            at_m: 4.0,
            width_m: 1.0,
            setback_m: 0.1,
            opened_rad,
            room,
            leaf: plain,
            frame: plain,
        });
        for [from_m, to_m] in [[0.0, 4.0], [5.0, 10.0]] {
            walls.push(Wall::new(
                line.point(from_m, 0.0),
                line.point(to_m, 0.0),
                plain,
            ));
        }
        let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
        let hit = caster.cast(&Point2::new(x_m, 0.0), &Vector2::y(), 20.0);
        hit.unwrap().distance_m
    }

    #[test]
    fn a_shut_door_is_set_back_and_an_open_one_shows_the_room() {
        assert!((ahead_m(0.0, 2.0) - 1.0).abs() < 1e-12);
        assert!((ahead_m(0.0, 4.5) - 1.1).abs() < 1e-12);
        assert!((ahead_m(FRAC_PI_2, 4.5) - 4.1).abs() < 1e-12);
        // Half open: the leaf leads from the hinge at (4, 1.1) diagonally into the room.
        assert!((ahead_m(FRAC_PI_2 / 2.0, 4.5) - 1.6).abs() < 1e-12);
    }
}
