//! The corridor's plan: what is frozen for every run, and the doors and bins that differ between runs.
//!
//! The paper gives the length and what there is, not where: places and measures here are assumed, those of a university
//! building of the time, and frozen so that the corridor is the same one for every seed.

use crate::{
    error::Result,
    seed::{Seed, Stream},
    world::{
        FloorPlan, Material, Opening, OpeningKind, Room, Route, Wall, WallLine, floor_plan::round,
    },
};
use nalgebra::Point2;
use rand::RngExt;
use rand_distr::StandardNormal;
use std::f64::consts::PI;

/// Length of the route (Thrun 1998, 5.1.1), metres.
pub const LENGTH_M: f64 = 89.0;
/// Wall to wall, metres.
const WIDTH_M: f64 = 2.4;
/// Radius of the arcs that the robot takes round the corners, metres.
const BEND_RADIUS_M: f64 = 1.0;
/// First and last leg, along the middle from the route's end to the corner, metres. The middle leg makes up the rest.
const OUTER_LEG_M: f64 = 26.0;
/// The corridor goes on behind the route's start and past its end, up to a fire door, metres.
const BEYOND_M: f64 = 3.0;

const PAINTED_BLOCK: Material = Material {
    reflectivity: 0.9,
    critical_angle_rad: 0.21,
    ..Material::PLAIN
};
const WOOD: Material = Material {
    reflectivity: 0.8,
    critical_angle_rad: 0.17,
    ..Material::PLAIN
};
const STEEL_FRAME: Material = Material {
    reflectivity: 0.9,
    critical_angle_rad: 0.79,
    ..Material::PLAIN
};
const STEEL_DOOR: Material = Material {
    reflectivity: 1.0,
    critical_angle_rad: 0.12,
    ..Material::PLAIN
};
const GLASS: Material = Material {
    reflectivity: 1.0,
    critical_angle_rad: 0.12,
    ..Material::PLAIN
};
const PLASTIC: Material = Material {
    reflectivity: 0.7,
    critical_angle_rad: 0.52,
    ..Material::PLAIN
};

/// A door of the corridor: where it begins on its wall and how wide it is (metres), how often it stands open, and how
/// deep the room behind is (metres).
type Door = (f64, f64, f64, f64);

/// Offices and labs on the outer side, leg by leg, in metres along the outer wall from its start.
const OUTER_DOORS: [&[Door]; 3] = [
    &[
        (4.1, 0.9, 0.5, 4.2),
        (7.3, 0.9, 0.2, 4.2),
        (12.6, 0.9, 0.5, 5.0),
        (15.2, 0.9, 0.7, 5.0),
        (20.9, 1.2, 0.1, 6.1),
        (25.4, 0.9, 0.3, 4.2),
    ],
    &[
        (4.6, 0.9, 0.3, 4.2),
        (8.8, 0.9, 0.6, 4.2),
        (11.7, 0.9, 0.2, 4.2),
        (17.0, 1.8, 0.1, 7.5),
        (22.4, 0.9, 0.5, 4.6),
        (25.1, 0.9, 0.5, 4.6),
        (29.9, 0.9, 0.0, 2.0),
        (32.2, 1.2, 0.4, 5.5),
        (36.0, 0.9, 0.3, 4.2),
    ],
    &[
        (5.0, 0.9, 0.4, 4.2),
        (9.4, 0.9, 0.6, 4.2),
        (12.1, 0.9, 0.0, 1.6),
        (16.3, 0.9, 0.5, 4.2),
        (19.9, 1.8, 0.2, 6.8),
        (25.6, 0.9, 0.5, 4.2),
    ],
];
/// Class rooms and stairs on the inner side, likewise.
const INNER_DOORS: [&[Door]; 3] = [
    &[(8.2, 1.8, 0.2, 7.0), (18.3, 1.5, 0.3, 6.0)],
    &[(5.2, 1.5, 0.1, 5.0), (28.6, 1.8, 0.2, 7.0)],
    &[(9.8, 1.8, 0.3, 7.0), (20.4, 1.5, 0.0, 5.0)],
];
/// What else is in the walls: wall (0..3 outer, 3..6 inner), begin and width (metres), what.
const FIXTURES: [(usize, f64, f64, OpeningKind); 8] = [
    // The two windows face the robot at the end of the first and the second leg.
    (
        1,
        0.4,
        1.6,
        OpeningKind::Niche {
            depth_m: 0.15,
            back: GLASS,
        },
    ),
    (
        2,
        0.4,
        1.6,
        OpeningKind::Niche {
            depth_m: 0.15,
            back: GLASS,
        },
    ),
    (
        4,
        20.9,
        1.2,
        OpeningKind::Niche {
            depth_m: 0.3,
            back: STEEL_DOOR,
        },
    ), // the elevator
    (4, 11.6, 2.2, OpeningKind::Hallway { depth_m: 9.0 }),
    (
        4,
        23.6,
        0.4,
        OpeningKind::Bulge {
            depth_m: 0.3,
            face: STEEL_DOOR,
        },
    ), // a drinking fountain
    (
        1,
        14.2,
        0.4,
        OpeningKind::Bulge {
            depth_m: 0.15,
            face: PAINTED_BLOCK,
        },
    ), // three pilasters
    (
        1,
        27.4,
        0.4,
        OpeningKind::Bulge {
            depth_m: 0.15,
            face: PAINTED_BLOCK,
        },
    ),
    (
        0,
        18.0,
        0.4,
        OpeningKind::Bulge {
            depth_m: 0.15,
            face: PAINTED_BLOCK,
        },
    ),
];
/// Where the trash bins belong: wall and metres along it. The last one is missing from every other run or so.
const BINS: [(usize, f64); 4] = [(0, 10.3), (4, 19.6), (2, 15.0), (5, 4.5)];
const BIN_RADIUS_M: f64 = 0.2;
/// Standard deviation, over runs, of where along its wall a bin stands, metres.
const BIN_MOVED_SD_M: f64 = 0.3;

/// Depth of a door's frame, metres.
const SETBACK_M: f64 = 0.12;
/// Rooms reach this far to either side of their door, or halfway to the next one, metres.
const ROOM_SIDE_M: f64 = 1.8;
/// Open doors stand at angles from ajar to against the room's wall, radians.
const OPENED_RAD: std::ops::Range<f64> = 0.9..1.75;

/// The way through the middle of the corridor, 89 m long.
///
/// # Errors
/// None: the constants make a way that can be driven.
pub fn route() -> Result<Route> {
    Route::new(&middle(0.0), BEND_RADIUS_M)
}

/// The corridor as run number `run` finds it: its doors open or shut, its bins where they were left.
///
/// # Errors
/// None: the constants make a plan.
pub fn plan_of_run(seed: Seed, run: u64) -> Result<FloorPlan> {
    let lines = wall_lines();
    let mut random = seed.numbered_stream("world/corridor/doors", run);
    let mut walls = fire_doors(&lines);
    for (index, line) in lines.iter().enumerate() {
        let mut openings = openings(index, &mut random);
        openings.sort_by(|a, b| a.at_m.total_cmp(&b.at_m));
        walls.extend(line.with(&openings)?);
    }
    let mut random = seed.numbered_stream("world/corridor/bins", run);
    for (index, &(line, at_m)) in BINS.iter().enumerate() {
        let moved_m = BIN_MOVED_SD_M * random.sample::<f64, _>(StandardNormal);
        let there = index + 1 < BINS.len() || random.random_bool(0.5);
        if there {
            // Against the wall, but for a finger's breadth.
            let centre = lines[line].point(at_m + moved_m, -BIN_RADIUS_M - 0.02);
            walls.extend(round(centre, BIN_RADIUS_M, 12, PLASTIC));
        }
    }
    FloorPlan::new(walls)
}

/// The four corners of the way: east, north, west.
fn middle(beyond_m: f64) -> [Point2<f64>; 4] {
    // Each quarter bend is 2 R − π R / 2 shorter than the corner it cuts.
    let saved_m = 2.0 * (2.0 - PI / 2.0) * BEND_RADIUS_M;
    let height_m = LENGTH_M + saved_m - 2.0 * OUTER_LEG_M;
    [
        Point2::new(-beyond_m, 0.0),
        Point2::new(OUTER_LEG_M, 0.0),
        Point2::new(OUTER_LEG_M, height_m),
        Point2::new(-beyond_m, height_m),
    ]
}

/// Three outer walls, then three inner ones, in travel direction.
fn wall_lines() -> [WallLine; 6] {
    let half_m = WIDTH_M / 2.0;
    let [a, b, c, d] = middle(BEYOND_M);
    // Outwards is down, right, up; the ends lie half a width aside, the corners diagonally.
    let side = |out_m: f64| {
        [
            Point2::new(a.x, a.y - out_m),
            Point2::new(b.x + out_m, b.y - out_m),
            Point2::new(c.x + out_m, c.y + out_m),
            Point2::new(d.x, d.y + out_m),
        ]
    };
    let (outer, inner) = (side(half_m), side(-half_m));
    std::array::from_fn(|index| {
        let (corners, corridor_on_left) = if index < 3 {
            (outer, true)
        } else {
            (inner, false)
        };
        WallLine {
            from: corners[index % 3],
            to: corners[index % 3 + 1],
            corridor_on_left,
            material: PAINTED_BLOCK,
        }
    })
}

/// The doors that close the corridor behind the start and past the end.
fn fire_doors(lines: &[WallLine; 6]) -> Vec<Wall> {
    vec![
        Wall::new(lines[0].from, lines[3].from, STEEL_DOOR),
        Wall::new(lines[2].to, lines[5].to, STEEL_DOOR),
    ]
}

/// Everything in one wall in one run; doors draw their state in the order of the tables.
fn openings(line: usize, random: &mut Stream) -> Vec<Opening> {
    let doors = if line < 3 {
        OUTER_DOORS[line]
    } else {
        INNER_DOORS[line - 3]
    };
    let half_gap_m = |from_m: f64, to_m: f64| ((to_m - from_m) / 2.0 - 0.05).min(ROOM_SIDE_M);
    let mut openings: Vec<Opening> = doors
        .iter()
        .enumerate()
        .map(|(index, &(at_m, width_m, open_share, depth_m))| {
            let open = random.random_bool(open_share);
            let angle_rad = random.random_range(OPENED_RAD);
            let before_m = index.checked_sub(1).map_or(ROOM_SIDE_M, |previous| {
                half_gap_m(doors[previous].0 + doors[previous].1, at_m)
            });
            let after_m = doors
                .get(index + 1)
                .map_or(ROOM_SIDE_M, |next| half_gap_m(at_m + width_m, next.0));
            let kind = OpeningKind::Door {
                setback_m: SETBACK_M,
                opened_rad: if open { angle_rad } else { 0.0 },
                room: Room {
                    before_m,
                    after_m,
                    depth_m,
                },
                leaf: WOOD,
                frame: STEEL_FRAME,
            };
            Opening {
                at_m,
                width_m,
                kind,
            }
        })
        .collect();
    let fixtures = FIXTURES.iter().filter(|fixture| fixture.0 == line);
    openings.extend(fixtures.map(|&(_, at_m, width_m, kind)| Opening {
        at_m,
        width_m,
        kind,
    }));
    openings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::enclosure::check_enclosed;

    #[test]
    fn the_route_is_89_m_and_free_in_every_run() {
        let route = route().unwrap();
        assert!((route.length_m() - LENGTH_M).abs() < 1e-9);
        for run in 0..30 {
            let plan = plan_of_run(Seed(9), run).unwrap();
            check_enclosed(&plan, &route.at(0.0).0, 0.27).unwrap();
            for step in 0..=890 {
                let clearance_m = plan.clearance_m(&route.at(f64::from(step) / 10.0).0);
                // Bins reach in to 1.2 − 0.42 = 0.78 m of the middle: the deviation's limit and the robot still fit.
                assert!(clearance_m > 0.4 + 0.27, "run {run}, {step}: {clearance_m}");
                assert!(clearance_m < 2.2, "the widest place is the hallway's mouth");
            }
        }
    }

    #[test]
    fn doors_and_bins_differ_between_runs_and_walls_do_not() {
        let plans: Vec<FloorPlan> = (0..20)
            .map(|run| plan_of_run(Seed(4), run).unwrap())
            .collect();
        let of = |plan: &FloorPlan, material| -> Vec<Wall> {
            plan.walls()
                .iter()
                .filter(|wall| wall.material == material)
                .copied()
                .collect()
        };
        let bins: Vec<usize> = plans
            .iter()
            .map(|plan| of(plan, PLASTIC).len() / 12)
            .collect();
        assert!(
            bins.contains(&3)
                && bins.contains(&4)
                && bins.iter().all(|bins| (3..=4).contains(bins)),
            "{bins:?}"
        );
        for plan in &plans[1..] {
            assert_ne!(of(plan, WOOD), of(&plans[0], WOOD));
            assert_ne!(of(plan, PLASTIC), of(&plans[0], PLASTIC));
            assert_eq!(of(plan, PAINTED_BLOCK), of(&plans[0], PAINTED_BLOCK));
        }
    }
}
