//! A checked polyline of wall, and the walls that one run finds of it.

use super::{
    fixture::{Fixture, What, fixtures},
    landmarks::Stretch,
    material::Materials,
    wall::{Side, WallConfig},
};
use crate::{
    error::{Error, Result},
    world::{Material, OpenDoor, Wall, WallLine},
};
use nalgebra::Point2;

/// Rooms reach this far to either side of their door where the file doesn't say, metres.
const ROOM_SIDE_M: f64 = 1.8;
/// What the robot can't measure: shorter pieces of wall are left out, metres.
const NOTHING_M: f64 = 1e-6;

/// A checked polyline.
#[derive(Debug, Clone)]
pub(super) struct Polyline {
    legs: Vec<Leg>,
    low_m: f64,
    high_m: f64,
    /// Begin and end along the polyline, and material; later ones cover earlier ones.
    paint: Vec<(f64, f64, Material)>,
}

#[derive(Debug, Clone)]
struct Leg {
    line: WallLine,
    /// Where it begins along the polyline, metres.
    start_m: f64,
    /// What is in it, in order; positions along this leg.
    fixtures: Vec<Fixture>,
}

impl Polyline {
    /// Checks wall number `number` of the file, counted from 1.
    pub(super) fn new(
        config: &WallConfig,
        number: usize,
        materials: &Materials,
        otherwise: Material,
    ) -> Result<Self> {
        let place = format!("[[wall]] {number}");
        let wrong = |fault: String| Err(Error::usage(format!("{place}: {fault}")));
        let mut points: Vec<Point2<f64>> =
            config.points.iter().map(|&point| point.into()).collect();
        if points.len() < 2 {
            return wrong(format!(
                "`points` has {}; expected at least 2",
                points.len()
            ));
        }
        if config.closed {
            points.push(points[0]);
        }
        let material = materials.named_or(config.material.as_ref(), otherwise, &place)?;
        let high_m = config.high_m.unwrap_or(f64::INFINITY);
        if !(config.low_m >= 0.0 && config.low_m < high_m) {
            return wrong(format!(
                "`low_m` is {} and `high_m` {high_m}; expected a stretch upwards from 0 or more",
                config.low_m
            ));
        }
        let mut legs = Vec::new();
        let mut start_m = 0.0;
        for pair in points.windows(2) {
            let line = WallLine {
                from: pair[0],
                to: pair[1],
                corridor_on_left: config.behind == Side::Right,
                material,
            };
            if !(1e-3..=1e6).contains(&line.length_m()) {
                return wrong(format!(
                    "from ({}, {}) to ({}, {}) it is {} m long; expected 0.001 to 1e6",
                    pair[0].x,
                    pair[0].y,
                    pair[1].x,
                    pair[1].y,
                    line.length_m()
                ));
            }
            legs.push(Leg {
                line,
                start_m,
                fixtures: Vec::new(),
            });
            start_m += line.length_m();
        }
        let length_m = start_m;
        let mut paint = Vec::new();
        for stretch in &config.paint {
            if !(stretch.from_m >= 0.0
                && stretch.from_m < stretch.to_m
                && stretch.to_m <= length_m + 1e-3)
            {
                return wrong(format!(
                    "paint from {} to {} m; expected a stretch within 0 to {length_m:.3} m",
                    stretch.from_m, stretch.to_m
                ));
            }
            let place = format!("{place}: paint from {} m", stretch.from_m);
            paint.push((
                stretch.from_m,
                stretch.to_m,
                materials.named(&stretch.material, &place)?,
            ));
        }
        for (kind, fixture) in fixtures(config, material, materials, &place)? {
            put(&mut legs, fixture, kind, &place)?;
        }
        for leg in &mut legs {
            leg.settle(config, &place)?;
        }
        Ok(Self {
            legs,
            low_m: config.low_m,
            high_m,
            paint,
        })
    }

    /// Its walls in one run; `door` draws for each door in turn, from 0 to 1, whether and how far it stands open.
    pub(super) fn walls(&self, door: &mut dyn FnMut() -> [f64; 2], mapping: bool) -> Vec<Wall> {
        let mut walls = Vec::new();
        for leg in &self.legs {
            let mut reached_m = 0.0;
            for fixture in &leg.fixtures {
                let end_m = fixture.at_m + fixture.width_m;
                self.face(
                    leg,
                    [reached_m, fixture.at_m],
                    [0.0, f64::INFINITY],
                    &mut walls,
                );
                self.inside(leg, fixture, door, mapping, &mut walls);
                reached_m = end_m;
            }
            let whole_m = leg.line.length_m();
            self.face(leg, [reached_m, whole_m], [0.0, f64::INFINITY], &mut walls);
        }
        walls
    }

    /// Its face on the plan from end to end, cut where something in it begins and ends.
    pub(super) fn stretches(&self) -> impl Iterator<Item = Stretch> {
        self.legs.iter().flat_map(|leg| {
            let stretch = |[from_m, to_m]: [f64; 2], is_door| Stretch {
                from: leg.line.point(from_m, 0.0),
                to: leg.line.point(to_m, 0.0),
                is_door,
            };
            let mut reached_m = 0.0;
            let mut stretches = Vec::new();
            for fixture in &leg.fixtures {
                let end_m = fixture.at_m + fixture.width_m;
                let is_door = matches!(fixture.what, What::Door(_));
                stretches.push(stretch([reached_m, fixture.at_m], false));
                stretches.push(stretch([fixture.at_m, end_m], is_door));
                reached_m = end_m;
            }
            stretches.push(stretch([reached_m, leg.line.length_m()], false));
            stretches
        })
    }

    /// The face of the wall along a stretch of a leg, between two heights at most, in its paint.
    fn face(&self, leg: &Leg, along_m: [f64; 2], heights_m: [f64; 2], walls: &mut Vec<Wall>) {
        let local = self
            .paint
            .iter()
            .map(|&(from, to, material)| (from - leg.start_m, to - leg.start_m, material));
        let local: Vec<_> = local.collect();
        let mut cuts: Vec<f64> = local
            .iter()
            .flat_map(|&(from, to, _)| [from, to])
            .filter(|cut| *cut > along_m[0] && *cut < along_m[1])
            .chain(along_m)
            .collect();
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            let middle = (pair[0] + pair[1]) / 2.0;
            let painted = local
                .iter()
                .rev()
                .find(|&&(from, to, _)| (from..to).contains(&middle));
            let material = painted.map_or(leg.line.material, |&(_, _, material)| material);
            let ends = [[pair[0], 0.0], [pair[1], 0.0]];
            self.push(leg, ends, material, heights_m, walls);
        }
    }

    /// A piece of wall between two places of a leg, each metres along and behind it, within the wall's own heights.
    fn push(
        &self,
        leg: &Leg,
        [from, to]: [[f64; 2]; 2],
        material: Material,
        [low_m, high_m]: [f64; 2],
        walls: &mut Vec<Wall>,
    ) {
        let ends = [from, to].map(|[along_m, behind_m]| leg.line.point(along_m, behind_m));
        let (low_m, high_m) = (low_m.max(self.low_m), high_m.min(self.high_m));
        if (ends[1] - ends[0]).norm() > NOTHING_M && low_m < high_m {
            walls.push(Wall::new(ends[0], ends[1], material).between(low_m, high_m));
        }
    }

    /// Side, back and side of a box behind the face, in front of it where `depth_m` is negative.
    fn cavity(
        &self,
        leg: &Leg,
        fixture: &Fixture,
        depth_m: f64,
        [side, back]: [Material; 2],
        heights_m: [f64; 2],
        walls: &mut Vec<Wall>,
    ) {
        let (start_m, end_m) = (fixture.at_m, fixture.at_m + fixture.width_m);
        for (ends, material) in [
            ([[start_m, 0.0], [start_m, depth_m]], side),
            ([[start_m, depth_m], [end_m, depth_m]], back),
            ([[end_m, depth_m], [end_m, 0.0]], side),
        ] {
            self.push(leg, ends, material, heights_m, walls);
        }
    }

    fn inside(
        &self,
        leg: &Leg,
        fixture: &Fixture,
        draw: &mut dyn FnMut() -> [f64; 2],
        mapping: bool,
        walls: &mut Vec<Wall>,
    ) {
        let along_m = [fixture.at_m, fixture.at_m + fixture.width_m];
        let own = leg.line.material;
        let everywhere = [0.0, f64::INFINITY];
        match &fixture.what {
            What::Box {
                depth_m,
                back,
                side,
                low_m,
                high_m,
            } => {
                let faces = [*side, *back];
                if *depth_m < 0.0 {
                    // The wall goes on behind what stands out of it, above and below.
                    self.face(leg, along_m, everywhere, walls);
                } else {
                    self.face(leg, along_m, [0.0, *low_m], walls);
                    self.face(leg, along_m, [*high_m, f64::INFINITY], walls);
                }
                self.cavity(leg, fixture, *depth_m, faces, [*low_m, *high_m], walls);
            }
            What::Hallway { depth_m } => {
                self.cavity(leg, fixture, *depth_m, [own; 2], everywhere, walls);
            }
            What::Door(door) => {
                let [openness, angle] = draw();
                let shut = openness >= door.open || (mapping && door.shut_while_mapping);
                let [least, most] = door.opened_rad;
                let opened_rad = least + angle * (most - least);
                if shut || opened_rad == 0.0 {
                    // What lies behind is out of every sensor's reach.
                    let faces = [door.frame, door.leaf];
                    self.cavity(leg, fixture, door.setback_m, faces, everywhere, walls);
                    return;
                }
                let open = OpenDoor {
                    at_m: fixture.at_m,
                    width_m: fixture.width_m,
                    setback_m: door.setback_m,
                    opened_rad,
                    room: door.room,
                    leaf: door.leaf,
                    frame: door.frame,
                };
                let pieces = leg.line.door(&open).into_iter();
                let some = pieces.filter(|wall| (wall.to - wall.from).norm() > NOTHING_M);
                walls.extend(some.map(|wall| wall.between(self.low_m, self.high_m)));
            }
        }
    }
}

impl Leg {
    /// Sorts what is in it, makes sure that nothing overlaps, and gives rooms their sizes.
    fn settle(&mut self, config: &WallConfig, place: &str) -> Result<()> {
        self.fixtures.sort_by(|a, b| a.at_m.total_cmp(&b.at_m));
        for index in 1..self.fixtures.len() {
            let (before, after) = (&self.fixtures[index - 1], &self.fixtures[index]);
            let end_m = before.at_m + before.width_m;
            if after.at_m < end_m - 1e-9 {
                return Err(Error::usage(format!(
                    "{place}: what begins at {:.3} m overlaps what ends at {:.3} m; expected one thing at a place",
                    after.at_m + self.start_m,
                    end_m + self.start_m
                )));
            }
        }
        let free: Vec<[f64; 2]> = (0..self.fixtures.len())
            .map(|index| {
                let (at_m, width_m) = (self.fixtures[index].at_m, self.fixtures[index].width_m);
                let before_m = index.checked_sub(1).map(|other| {
                    let other = &self.fixtures[other];
                    (at_m - other.at_m - other.width_m) / 2.0
                });
                let after_m = self
                    .fixtures
                    .get(index + 1)
                    .map(|other| (other.at_m - at_m - width_m) / 2.0);
                [before_m, after_m].map(|m| m.unwrap_or(ROOM_SIDE_M).clamp(0.0, ROOM_SIDE_M))
            })
            .collect();
        for (fixture, free) in self.fixtures.iter_mut().zip(free) {
            let at_m = fixture.at_m + self.start_m;
            if let What::Door(door) = &mut fixture.what {
                let door_config = config
                    .door
                    .iter()
                    .find(|door_config| (door_config.at_m - at_m).abs() < 1e-9);
                door.room.before_m = door_config.and_then(|d| d.room_before_m).unwrap_or(free[0]);
                door.room.after_m = door_config.and_then(|d| d.room_after_m).unwrap_or(free[1]);
            }
        }
        Ok(())
    }
}

/// Puts something into the leg that it lies in.
fn put(legs: &mut [Leg], mut fixture: Fixture, kind: &str, place: &str) -> Result<()> {
    let (at_m, end_m) = (fixture.at_m, fixture.at_m + fixture.width_m);
    let wrong = |fault: String| {
        Err(Error::usage(format!(
            "{place}: {kind} at {at_m} m: {fault}"
        )))
    };
    if fixture.width_m.is_nan() || fixture.width_m <= 1e-3 {
        return wrong(format!(
            "`width_m` is {}; expected more than 0.001",
            fixture.width_m
        ));
    }
    let whole_m = legs
        .last()
        .map_or(0.0, |leg| leg.start_m + leg.line.length_m());
    if !(at_m >= 0.0 && end_m <= whole_m + 1e-6) {
        return wrong(format!(
            "ends at {end_m:.3} m; expected it within 0 to {whole_m:.3} m"
        ));
    }
    let corners: Vec<f64> = legs.iter().map(|leg| leg.start_m).collect();
    let index = corners.partition_point(|start| *start <= at_m + 1e-9) - 1;
    let leg = &mut legs[index];
    let corner_m = leg.start_m + leg.line.length_m();
    if end_m > corner_m + 1e-6 {
        return wrong(format!(
            "reaches to {end_m:.3} m, over the corner at {corner_m:.3} m; expected it on one straight stretch"
        ));
    }
    fixture.at_m = (at_m - leg.start_m).max(0.0);
    leg.fixtures.push(fixture);
    Ok(())
}
