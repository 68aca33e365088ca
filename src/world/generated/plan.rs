//! The plan of a generated building as its kinds draw it: walls with gaps, doorways, things that stay and things that
//! move, and which part of the plane is inside.

use super::{bend::Bend, chance::Chance};
use crate::world::{Material, Wall, floor_plan};
use nalgebra::{Point2, Rotation2, Vector2};

/// Pieces of wall shorter than this are left out, metres.
const SHORTEST_M: f64 = 0.01;
/// Wall that stays between two gaps, or a gap and the wall's end, metres.
const JAMB_M: f64 = 0.1;
/// Faces of a round column.
const FACES: usize = 8;

/// An upright box in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    pub low: Point2<f64>,
    pub high: Point2<f64>,
}

impl Rectangle {
    /// The one with these two opposite corners.
    pub fn new(one: Point2<f64>, other: Point2<f64>) -> Self {
        Self {
            low: one.inf(&other),
            high: one.sup(&other),
        }
    }

    /// Width and height, metres.
    pub fn size(&self) -> Vector2<f64> {
        self.high - self.low
    }

    /// Square metres.
    pub fn area_m2(&self) -> f64 {
        self.size().product()
    }

    /// The corners, counter-clockwise from the lower left.
    pub fn corners(&self) -> [Point2<f64>; 4] {
        let Self { low, high } = *self;
        [
            low,
            Point2::new(high.x, low.y),
            high,
            Point2::new(low.x, high.y),
        ]
    }

    /// A place in it, drawn evenly.
    pub fn place(&self, chance: &mut Chance) -> Point2<f64> {
        Point2::new(
            chance.between(self.low.x, self.high.x),
            chance.between(self.low.y, self.high.y),
        )
    }

    pub(super) fn holds(&self, point: &Point2<f64>) -> bool {
        (self.low.x..=self.high.x).contains(&point.x)
            && (self.low.y..=self.high.y).contains(&point.y)
    }
}

/// A gap in a wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    /// Where its middle is, as a share of the wall's length.
    pub middle: f64,
    /// Metres.
    pub width_m: f64,
    /// Does a door hang in it?
    pub door: bool,
}

/// Where a door hangs: from jamb to jamb.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Doorway {
    pub from: Point2<f64>,
    pub to: Point2<f64>,
}

/// One thing as the walls around it.
pub(super) type Thing = Vec<Wall>;

/// Everything that a building is made of, whatever state its doors are in.
#[derive(Debug, Clone, Default)]
pub(super) struct Plan {
    pub walls: Vec<Wall>,
    pub doorways: Vec<Doorway>,
    /// Things that nearly never move.
    pub fixed: Vec<Thing>,
    /// Things that somebody moves now and then.
    pub loose: Vec<Thing>,
    /// Where the robot may be, before bending.
    pub inside: Vec<Rectangle>,
    /// How the building was bent.
    bend: Bend,
}

impl Plan {
    /// A wall without gaps.
    pub fn wall(&mut self, from: Point2<f64>, to: Point2<f64>, chance: &mut Chance) {
        self.wall_with_gaps(from, to, &[], chance);
    }

    /// A wall with those of the gaps, in the order of their middles, for which there is room.
    pub fn wall_with_gaps(
        &mut self,
        from: Point2<f64>,
        to: Point2<f64>,
        gaps: &[Gap],
        chance: &mut Chance,
    ) {
        let length_m = (to - from).norm();
        if length_m < SHORTEST_M {
            return;
        }
        let along = (to - from) / length_m;
        let material = plaster(chance);
        let mut ordered = gaps.to_vec();
        ordered.sort_by(|a, b| a.middle.total_cmp(&b.middle));
        let mut done_m = 0.0;
        for gap in ordered {
            let begin_m = gap.middle * length_m - gap.width_m / 2.0;
            let end_m = begin_m + gap.width_m;
            if begin_m < done_m + JAMB_M || end_m > length_m - JAMB_M {
                continue;
            }
            let (begin, end) = (from + along * begin_m, from + along * end_m);
            self.piece(from + along * done_m, begin, material);
            if gap.door {
                self.doorways.push(Doorway {
                    from: begin,
                    to: end,
                });
            }
            done_m = end_m;
        }
        self.piece(from + along * done_m, to, material);
    }

    fn piece(&mut self, from: Point2<f64>, to: Point2<f64>, material: Material) {
        if (to - from).norm() >= SHORTEST_M {
            self.walls.push(Wall::new(from, to, material));
        }
    }

    /// The four walls of a rectangle.
    pub fn enclose(&mut self, room: &Rectangle, chance: &mut Chance) {
        let corners = room.corners();
        for (index, corner) in corners.iter().enumerate() {
            self.wall(*corner, corners[(index + 1) % 4], chance);
        }
    }

    /// A column with as many sides as round ones have here.
    pub fn round_column(&mut self, centre: Point2<f64>, radius_m: f64, chance: &mut Chance) {
        let material = wood(chance);
        self.fixed
            .push(floor_plan::round(centre, radius_m, FACES, material));
    }

    /// A box that stays.
    pub fn fixed_box(
        &mut self,
        centre: Point2<f64>,
        size: Vector2<f64>,
        turn_rad: f64,
        chance: &mut Chance,
    ) {
        self.fixed.push(boxed(centre, size, turn_rad, wood(chance)));
    }

    /// A box that somebody may move.
    pub fn loose_box(
        &mut self,
        centre: Point2<f64>,
        size: Vector2<f64>,
        turn_rad: f64,
        chance: &mut Chance,
    ) {
        self.loose.push(boxed(centre, size, turn_rad, wood(chance)));
    }

    /// The same building bent; it must not have been bent before.
    pub fn bent(self, bend: Bend) -> Self {
        let things = |all: Vec<Thing>| all.iter().map(|thing| bend.walls(thing)).collect();
        Self {
            walls: bend.walls(&self.walls),
            doorways: self
                .doorways
                .iter()
                .map(|door| Doorway {
                    from: bend.point(&door.from),
                    to: bend.point(&door.to),
                })
                .collect(),
            fixed: things(self.fixed),
            loose: things(self.loose),
            inside: self.inside,
            bend,
        }
    }

    /// May the robot be at a place, as far as walls and things allow it?
    pub fn is_inside(&self, place: &Point2<f64>) -> bool {
        let straight = self.bend.undone(place);
        self.inside.iter().any(|part| part.holds(&straight))
    }
}

fn boxed(centre: Point2<f64>, size: Vector2<f64>, turn_rad: f64, material: Material) -> Thing {
    let turn = Rotation2::new(turn_rad);
    let half = Rectangle::new(Point2::from(-size / 2.0), Point2::from(size / 2.0));
    let corners = half.corners().map(|corner| centre + turn * corner.coords);
    (0..4)
        .map(|side| Wall::new(corners[side], corners[(side + 1) % 4], material))
        .collect()
}

/// A wall's surface: some are smooth to sound, some rough.
fn plaster(chance: &mut Chance) -> Material {
    Material {
        critical_angle_rad: chance.between(0.2, 0.7),
        ..Material::PLAIN
    }
}

/// A thing's surface.
pub(super) fn wood(chance: &mut Chance) -> Material {
    Material {
        critical_angle_rad: chance.between(0.3, 1.2),
        ..Material::PLAIN
    }
}
