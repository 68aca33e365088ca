use super::*;
use crate::seed::Seed;
use rand::RngExt;

/// Cells of random states, in blotches as surroundings have them.
pub(crate) fn blotched(index: u64) -> States {
    let mut random = Seed(5).numbered_stream("blotches", index);
    let mut states = States::from_fn(|_, _| State::Unknown);
    for _ in 0..random.random_range(3..9) {
        let (x, y) = (random.random_range(0..50), random.random_range(0..50));
        let (wide, high) = (random.random_range(1..30), random.random_range(1..30));
        let state = [State::Occupied, State::Empty][random.random_range(0..2)];
        let before = states.clone();
        states = States::from_fn(|cx, cy| {
            let within = (x..x + wide).contains(&cx) && (y..y + high).contains(&cy);
            if within { state } else { before.at(cx, cy) }
        });
    }
    states
}

const MODEL: ReadingModel = ReadingModel {
    minimum_m: 0.3,
    range_error_m: 0.3,
};

fn towards(x: usize, y: usize, range_m: f64, opening_rad: f64) -> Reading {
    let middle_m = |i: usize| (i as f64 - 31.5) * CELL_M;
    Reading {
        bearing_rad: middle_m(y).atan2(middle_m(x)),
        offset_m: 0.0,
        returned: true,
        range_m,
        opening_rad,
    }
}

/// Cell (41, 41) lies at √2·1.425 = 2.01525 m; a cone along the diagonal meets it on its axis.
#[test]
fn a_cell_on_the_axis_is_updated_as_worked_by_hand() {
    let delta_m = 1.425 * 2f64.sqrt();
    let reading = towards(41, 41, 3.0, 0.2);
    let grid = OccupancyGrid::of(&[reading], &MODEL);
    // E_r = 1 − ((2.01525 − 0.3)/(3 − 0.3 − 0.3))²
    let empty = 1.0 - ((delta_m - 0.3) / 2.4f64).powi(2);
    assert!((empty - 0.489_219).abs() < 1e-6, "{empty}");
    assert!((grid.probability(41, 41) - (1.0 - empty) / 2.0).abs() < 1e-12);
    // Twice the same reading: e + e − e².
    let twice = OccupancyGrid::of(&[reading, reading], &MODEL);
    assert!((twice.probability(41, 41) - (1.0 - 0.739_103) / 2.0).abs() < 1e-6);
}

/// Cell (41, 40) is at (1.425, 1.275) m: 1.91213 m away, atan(1.275/1.425) − π/4 = −.05550 rad off the diagonal.
#[test]
fn a_cell_aside_is_known_less_and_one_beyond_the_cone_not_at_all() {
    let grid = OccupancyGrid::of(&[towards(41, 41, 3.0, 0.2)], &MODEL);
    // (1 − ((1.91213 − .3)/2.4)²)·(1 − (.05550/.1)²) = .548790·.691992
    assert!((grid.probability(41, 40) - (1.0 - 0.379_758) / 2.0).abs() < 1e-6);
    let narrow = OccupancyGrid::of(&[towards(41, 41, 3.0, 0.1)], &MODEL);
    assert_eq!(narrow.probability(41, 40), 0.5);
    assert_eq!(narrow.states().at(41, 40), State::Unknown);
}

#[test]
fn one_readings_arc_is_occupied_by_one_thing_in_all() {
    let grid = OccupancyGrid::of(&[towards(45, 38, 2.5, 0.4)], &MODEL);
    let mut misses = 1.0;
    let mut linear = 0.0;
    for cell in 0..CELLS * CELLS {
        misses *= 1.0 - grid.occupied[cell];
        linear += grid.occupied[cell];
    }
    assert!((linear - 1.0).abs() < 1e-12 && misses > 0.0, "{linear}");
}

/// Where a second cone says empty, the first one's echo is moved to the rest of its arc: (1 − Emp) weighs.
#[test]
fn emptiness_cancels_occupancy() {
    let near = towards(41, 41, 2.0, 0.3);
    let alone = OccupancyGrid::of(&[near], &MODEL);
    let through = OccupancyGrid::of(&[near, towards(41, 41, 4.5, 0.1)], &MODEL);
    let at = 41 * CELLS + 41;
    let emptied = through.empty[at] - alone.empty[at];
    assert!(emptied > 0.5);
    let arc: f64 = alone
        .occupied
        .iter()
        .zip(through.empty.iter().zip(&alone.empty))
        .map(|(o, (now, before))| o * (1.0 - now) / (1.0 - before))
        .sum();
    let expected = alone.occupied[at] * (1.0 - through.empty[at]) / (1.0 - alone.empty[at]);
    let echo = through.occupied[at];
    assert!((echo - expected / arc).abs() < 1e-12, "{echo}");
    assert!(through.probability(41, 41) < 0.5 && alone.probability(41, 41) > 0.5);
}

#[test]
fn cones_wrap_round_and_the_order_of_readings_says_nothing() {
    let west = |bearing_rad: f64| Reading {
        bearing_rad,
        offset_m: 0.0,
        returned: true,
        range_m: 2.0,
        opening_rad: 0.5,
    };
    let pi = TAU / 2.0;
    let states = |r: &[Reading]| OccupancyGrid::of(r, &MODEL).states();
    assert_eq!(states(&[west(pi)]), states(&[west(-pi)]));
    let east = states(&[west(0.0)]);
    assert_eq!(states(&[west(TAU)]), east);
    // Mirror images above and below the x axis: the cone across bearing 0 is whole.
    for x in 0..CELLS {
        for y in 0..CELLS {
            assert_eq!(east.at(x, y), east.at(x, CELLS - 1 - y));
        }
    }
    let upright = states(&[west(pi / 2.0)]);
    assert_eq!(east.quarter_turn(), upright);
    let scan = [west(0.0), west(0.3), west(0.6)];
    let back = [scan[2], scan[1], scan[0]];
    assert_eq!(states(&scan), states(&back));
}

#[test]
fn what_is_no_reading_says_nothing() {
    let odd = [f64::NAN, f64::INFINITY, -1.0, 0.0, 0.29];
    let readings = odd.map(|range_m| Reading {
        bearing_rad: 0.0,
        offset_m: 0.0,
        returned: true,
        range_m,
        opening_rad: 0.5,
    });
    let grid = OccupancyGrid::of(&readings, &MODEL);
    assert_eq!(grid.states(), States::UNKNOWN);
    assert_eq!(grid.states().known(), 0);
}

#[test]
fn a_cone_begins_at_its_sensor() {
    let ring = |offset_m: f64, range_m: f64| Reading {
        bearing_rad: 0.0,
        offset_m,
        range_m,
        returned: true,
        opening_rad: 0.5,
    };
    let grid = |offset_m, range_m| OccupancyGrid::of(&[ring(offset_m, range_m)], &MODEL);
    // On the axis, ten cells out: a sensor three cells out says what one in the middle says of seven cells.
    let [out_m, here_m] = [3.0, 0.0].map(|cells| cells * CELL_M);
    let (moved, middle) = (grid(out_m, 2.4), grid(here_m, 2.4));
    for x in 32..60 {
        for y in [31, 32] {
            assert!((moved.probability(x + 3, y) - middle.probability(x, y)).abs() < 1e-9);
        }
    }
    // Aside of the axis it is the cone of the sensor: of cells as far aside, those are left out that lie before it opens.
    let inside = |grid: &OccupancyGrid, x: usize| grid.probability(x, 34) != 0.5;
    let first = |grid: &OccupancyGrid| (32..60).find(|&x| inside(grid, x)).unwrap();
    assert_eq!(first(&moved), first(&middle) + 3);
}

#[test]
fn where_nothing_came_back_the_cone_is_empty_as_far_as_the_sensor_reaches() {
    let silent = Reading {
        bearing_rad: 0.0,
        offset_m: 0.2,
        range_m: 2.0,
        returned: false,
        opening_rad: 0.5,
    };
    let states = OccupancyGrid::of(&[silent], &MODEL).states();
    assert!((0..CELLS).all(|x| (0..CELLS).all(|y| states.at(x, y) != State::Occupied)));
    assert_eq!(states.at(32 + 8, 32), State::Empty); // 1.275 m
    assert_eq!(states.at(32 + 16, 32), State::Unknown); // 2.475 m
}
