//! A long wall with things in it: doors with rooms behind them, windows, an elevator, side hallways.

use super::{Material, Wall};
use crate::error::{Error, Result};
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

/// Something in a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// Where it begins, in metres from the start of the wall.
    pub at_m: f64,
    /// How wide it is, in metres.
    pub width_m: f64,
    /// What it is.
    pub kind: OpeningKind,
}

/// What is in a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OpeningKind {
    /// A door, set back in its frame, that swings into the room behind it.
    Door {
        /// Depth of the frame, metres.
        setback_m: f64,
        /// 0: shut; π/2: wide open.
        opened_rad: f64,
        /// What lies behind it.
        room: Room,
        /// The leaf.
        leaf: Material,
        /// The two sides of the frame.
        frame: Material,
    },
    /// A niche with a back of its own material: a window, an elevator, a built-in cupboard.
    Niche {
        /// Depth, metres.
        depth_m: f64,
        /// The back wall.
        back: Material,
    },
    /// Something that stands out into the corridor: a pilaster, a drinking fountain.
    Bulge {
        /// How far it stands out, metres.
        depth_m: f64,
        /// Its three faces.
        face: Material,
    },
    /// A hallway that branches off, as wide as the opening, with a wall at its end.
    Hallway {
        /// Length, metres.
        depth_m: f64,
    },
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

    /// The walls that remain, with everything in them.
    ///
    /// ```
    /// use ballmark::world::{Material, Opening, OpeningKind, WallLine};
    /// use nalgebra::Point2;
    /// let brick = Material { reflectivity: 1.0, critical_angle_rad: 0.5, ..Material::PLAIN };
    /// let glass = Material { reflectivity: 1.0, critical_angle_rad: 0.1, ..Material::PLAIN };
    /// let line = WallLine { from: Point2::origin(), to: Point2::new(9.0, 0.0), corridor_on_left: true, material: brick };
    /// let window = Opening { at_m: 2.0, width_m: 1.5, kind: OpeningKind::Niche { depth_m: 0.2, back: glass } };
    /// let walls = line.with(&[window])?;
    /// assert_eq!(walls.len(), 5); // before, the niche's side, back and side, after
    /// assert_eq!(walls[2].from, Point2::new(2.0, -0.2));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// Where an opening has no width, overlaps the one before it or reaches past the wall.
    pub fn with(&self, openings: &[Opening]) -> Result<Vec<Wall>> {
        let mut walls = Vec::new();
        let mut reached_m = 0.0;
        for (index, opening) in openings.iter().enumerate() {
            let end_m = opening.at_m + opening.width_m;
            if !(opening.width_m > 0.0 && opening.at_m >= reached_m && end_m <= self.length_m()) {
                return Err(Error::work(format!(
                    "floor plan: opening {index} spans {} to {end_m} m; expected a stretch within {reached_m} to {} m of its wall",
                    opening.at_m,
                    self.length_m()
                )));
            }
            if opening.at_m > reached_m {
                walls.push(self.stretch([reached_m, 0.0], [opening.at_m, 0.0], self.material));
            }
            walls.extend(self.inside(opening));
            reached_m = end_m;
        }
        if self.length_m() > reached_m {
            walls.push(self.stretch([reached_m, 0.0], [self.length_m(), 0.0], self.material));
        }
        Ok(walls)
    }

    fn stretch(&self, from: [f64; 2], to: [f64; 2], material: Material) -> Wall {
        Wall::new(
            self.point(from[0], from[1]),
            self.point(to[0], to[1]),
            material,
        )
    }

    /// Side, back and side of a box `depth_m` behind the face; in front of it where negative.
    fn box_behind(
        &self,
        start_m: f64,
        end_m: f64,
        depth_m: f64,
        back: Material,
        side: Material,
    ) -> Vec<Wall> {
        vec![
            self.stretch([start_m, 0.0], [start_m, depth_m], side),
            self.stretch([start_m, depth_m], [end_m, depth_m], back),
            self.stretch([end_m, depth_m], [end_m, 0.0], side),
        ]
    }

    /// The walls of what is in it.
    pub(super) fn inside(&self, opening: &Opening) -> Vec<Wall> {
        let (start_m, end_m) = (opening.at_m, opening.at_m + opening.width_m);
        match opening.kind {
            OpeningKind::Niche { depth_m, back } => {
                self.box_behind(start_m, end_m, depth_m, back, self.material)
            }
            OpeningKind::Bulge { depth_m, face } => {
                self.box_behind(start_m, end_m, -depth_m, face, face)
            }
            OpeningKind::Hallway { depth_m } => {
                self.box_behind(start_m, end_m, depth_m, self.material, self.material)
            }
            OpeningKind::Door {
                setback_m,
                opened_rad,
                room,
                leaf,
                frame,
            } => {
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
                let swung = Rotation2::new(opened_rad) * Vector2::new(opening.width_m, 0.0);
                outline.push((
                    [start_m, setback_m],
                    [start_m + swung.x, setback_m + swung.y],
                    leaf,
                ));
                outline
                    .into_iter()
                    .map(|(from, to, material)| self.stretch(from, to, material))
                    .collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{FloorPlan, Raycaster};
    use std::f64::consts::FRAC_PI_2;

    const BRICK: Material = Material {
        reflectivity: 1.0,
        critical_angle_rad: 0.5,
        ..Material::PLAIN
    };

    fn line() -> WallLine {
        let (from, to) = (Point2::new(0.0, 1.0), Point2::new(10.0, 1.0));
        WallLine {
            from,
            to,
            corridor_on_left: false,
            material: BRICK,
        }
    }

    fn door(opened_rad: f64) -> Opening {
        let room = Room {
            before_m: 1.0,
            after_m: 0.5,
            depth_m: 3.0,
        };
        let kind = OpeningKind::Door {
            setback_m: 0.1,
            opened_rad,
            room,
            leaf: BRICK,
            frame: BRICK,
        };
        Opening {
            at_m: 4.0,
            width_m: 1.0,
            kind,
        }
    }

    /// Distance straight up from (x, 0) in the corridor.
    fn ahead_m(opening: Opening, x_m: f64) -> f64 {
        let caster = Raycaster::new(FloorPlan::new(line().with(&[opening]).unwrap()).unwrap());
        caster
            .cast(&Point2::new(x_m, 0.0), &Vector2::y(), 20.0)
            .unwrap()
            .distance_m
    }

    #[test]
    fn a_shut_door_is_set_back_and_an_open_one_shows_the_room() {
        assert!((ahead_m(door(0.0), 2.0) - 1.0).abs() < 1e-12);
        assert!((ahead_m(door(0.0), 4.5) - 1.1).abs() < 1e-12);
        assert!((ahead_m(door(FRAC_PI_2), 4.5) - 4.1).abs() < 1e-12);
        // Half open: the leaf leads from the hinge at (4, 1.1) diagonally into the room.
        assert!((ahead_m(door(FRAC_PI_2 / 2.0), 4.5) - 1.6).abs() < 1e-12);
    }

    #[test]
    fn bulges_stand_out_and_hallways_lead_away() {
        let bulge = OpeningKind::Bulge {
            depth_m: 0.3,
            face: BRICK,
        };
        assert!(
            (ahead_m(
                Opening {
                    at_m: 4.0,
                    width_m: 1.0,
                    kind: bulge
                },
                4.5
            ) - 0.7)
                .abs()
                < 1e-12
        );
        let hallway = OpeningKind::Hallway { depth_m: 8.0 };
        assert!(
            (ahead_m(
                Opening {
                    at_m: 4.0,
                    width_m: 2.0,
                    kind: hallway
                },
                4.5
            ) - 9.0)
                .abs()
                < 1e-12
        );
    }

    #[test]
    fn openings_that_overlap_or_reach_past_the_wall_are_told() {
        let niche = |at_m, width_m| Opening {
            at_m,
            width_m,
            kind: OpeningKind::Hallway { depth_m: 1.0 },
        };
        for openings in [
            vec![niche(9.5, 1.0)],
            vec![niche(2.0, 2.0), niche(3.0, 1.0)],
            vec![niche(1.0, 0.0)],
            vec![niche(f64::NAN, 1.0)],
        ] {
            let message = line().with(&openings).unwrap_err().to_string();
            assert!(
                message.contains(&format!("opening {}", openings.len() - 1)),
                "{message}"
            );
        }
    }
}
