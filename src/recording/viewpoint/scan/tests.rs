//! Geometry worked by hand, and what must hold for any sensor.

use super::*;
use crate::{geometry::Pose, seed::Seed};
use rand::RngExt;
use std::f64::consts::FRAC_PI_2;

fn step(forward_m: f64, left_m: f64, turn_deg: f64) -> Displacement {
    Displacement {
        forward_m,
        left_m,
        turn_rad: turn_deg.to_radians(),
    }
}

/// Bearings of a scanner, a beam a degree.
fn degrees(from: i32, to: i32) -> Vec<f64> {
    (from..=to).map(|d| f64::from(d).to_radians()).collect()
}

fn seen(bearing_rad: &[f64], ranges: &[f32], step: Displacement) -> Vec<f32> {
    let mut out = vec![-1.0; ranges.len()];
    Viewpoint::new(bearing_rad, Some(50.0))
        .unwrap()
        .render(ranges, step, &mut out);
    out
}

fn near(a: f32, b: f64) -> bool {
    (f64::from(a) - b).abs() < 1e-5
}

/// Range to the walls x = ±`x_m`, y = ±`y_m` of a room from a place in it.
fn in_a_room(x_m: f64, y_m: f64, at: Pose, bearing_rad: &[f64]) -> Vec<f32> {
    let range = |b: &f64| {
        let (sin, cos) = (at.heading_rad + b).sin_cos();
        let to_x = (x_m * cos.signum() - at.x_m) / cos;
        let to_y = (y_m * sin.signum() - at.y_m) / sin;
        to_x.min(to_y) as f32
    };
    bearing_rad.iter().map(range).collect()
}

#[test]
fn a_wall_ahead_comes_nearer_by_the_step() {
    let beams = degrees(-40, 40);
    let wall = |distance_m: f64| -> Vec<f32> {
        let range = |b: &f64| (distance_m / b.cos()) as f32;
        beams.iter().map(range).collect()
    };
    // All of the wall that the moved sensor looks at was in sight.
    for (moved, &exact) in seen(&beams, &wall(4.0), step(1.0, 0.0, 0.0))[15..66]
        .iter()
        .zip(&wall(3.0)[15..66])
    {
        assert!(near(*moved, f64::from(exact)), "{moved} {exact}");
    }
    assert_eq!(
        seen(&beams, &wall(4.0), step(0.0, 0.7, 0.0))[40].round(),
        4.0
    );
}

#[test]
fn a_turn_shifts_the_beams_and_repeats_the_last_one_seen() {
    let beams = degrees(0, 5);
    let scan = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5];
    assert_eq!(
        seen(&beams, &scan, step(0.0, 0.0, 2.0)),
        [1.2, 1.3, 1.4, 1.5, 1.5, 1.5]
    );
    assert_eq!(
        seen(&beams, &scan, step(0.0, 0.0, -1.0)),
        [1.0, 1.0, 1.1, 1.2, 1.3, 1.4]
    );
    // Turned away from all that was seen.
    assert!(
        seen(&beams, &scan, step(0.0, 0.0, 90.0))
            .iter()
            .all(|r| r.is_nan())
    );
}

#[test]
fn a_full_ring_wraps() {
    let ring: Vec<f64> = (0..24).map(|i| f64::from(i) * TAU / 24.0).collect();
    let scan: Vec<f32> = (0..24).map(|i| 2.0 + 0.01 * i as f32).collect();
    let turned = seen(&ring, &scan, step(0.0, 0.0, 45.0));
    for i in 0..24 {
        assert!(near(turned[i], f64::from(scan[(i + 3) % 24])), "{i}");
    }
    // Bearings from −π to π name the direction behind twice.
    let closed = degrees(-180, 180);
    let room = in_a_room(3.0, 2.0, Pose::default(), &closed);
    let moved = seen(&closed, &room, step(0.3, -0.2, 0.0));
    assert!(near(moved[0], 3.3) && near(moved[360], 3.3), "{}", moved[0]);
}

#[test]
fn a_room_looks_as_it_does_from_there() {
    let ring = degrees(-180, 179);
    let scan = in_a_room(4.0, 2.5, Pose::default(), &ring);
    for (forward_m, left_m, turn_deg) in [(0.5, 0.0, 0.0), (-0.4, 0.3, 20.5), (1.0, -1.0, -77.0)] {
        let step = step(forward_m, left_m, turn_deg);
        let exact = in_a_room(4.0, 2.5, Pose::default().after(step), &ring);
        for (bearing, (moved, exact)) in seen(&ring, &scan, step).iter().zip(exact).enumerate() {
            // A piece of wall between two beams cuts the corner by a few centimetres.
            assert!((moved - exact).abs() < 0.06, "{bearing}: {moved} {exact}");
        }
    }
}

#[test]
fn what_a_near_edge_hid_copies_its_neighbour() {
    // A post's face 1 m ahead to the right, a wall 4 m ahead; from 0.5 m to the left more of the wall is in sight than
    // was, but not all that the post hid.
    let beams = degrees(-45, 45);
    let scan: Vec<f32> = beams
        .iter()
        .map(|b| (if *b < -1e-9 { 1.0 } else { 4.0 } / b.cos()) as f32)
        .collect();
    let moved = seen(&beams, &scan, step(0.0, 0.5, 0.0));
    // The edge of the post was at −1°, so at (1, 0), and is now at atan(−0.5/1) = −26.6°; the wall was seen from y = 0
    // on, which is now at atan(−0.5/4) = −7.1°.
    let at = |deg: i32| moved[(deg + 45) as usize];
    assert!(near(at(-30), 1.0 / 30_f64.to_radians().cos()));
    assert!(near(at(-7), 4.0 / 7_f64.to_radians().cos()));
    // Nothing is known in between: copies of the nearest, −27° and −7°.
    assert_eq!((at(-20), at(-18)), (at(-27), at(-27)));
    assert_eq!((at(-16), at(-8)), (at(-7), at(-7)));
}

#[test]
fn what_comes_in_front_hides_what_is_behind() {
    // The post of the test above, and its mirror image; from 0.5 m to its own side it hides a part of the wall that was
    // in sight: from atan(0.5/4) = 7.1° to 26.6°.
    let beams = degrees(-45, 45);
    for side in [-1.0, 1.0] {
        let scan: Vec<f32> = beams
            .iter()
            .map(|b| (if side * b > 1e-9 { 1.0 } else { 4.0 } / b.cos()) as f32)
            .collect();
        let moved = seen(&beams, &scan, step(0.0, side * 0.5, 0.0));
        let at = |deg: f64| moved[(45.0 - side * deg) as usize];
        for deg in [8.0, 15.0, 20.0, 25.0] {
            assert!(near(at(deg), 1.0 / f64::to_radians(deg).cos()), "{deg}");
        }
        assert!(near(at(28.0), 4.0 / 28_f64.to_radians().cos()));
    }
}

#[test]
fn a_screen_has_a_back() {
    // A screen from (1, −0.3) to (1, 0.3) in a room; from 2 m, its back is behind.
    let ring = degrees(-180, 179);
    let mut scan = in_a_room(4.0, 2.5, Pose::default(), &ring);
    for deg in -16..=16 {
        scan[(deg + 180) as usize] = (1.0 / f64::from(deg).to_radians().cos()) as f32;
    }
    let moved = seen(&ring, &scan, step(2.0, 0.0, 0.0));
    assert!(near(moved[0], 1.0) && near(moved[10], 1.0 / 10_f64.to_radians().cos()));
    assert!(moved[20] > 4.0 && near(moved[90], 2.5) && moved[270] == moved[90]);
}

#[test]
fn two_beams_the_same_way_see_the_nearer() {
    let mut random = Seed(3).stream("bearings");
    for _ in 0..1000 {
        let bearing = 7.0 * random.random::<f64>();
        let (nearer, farther) = (2.0 + random.random::<f32>(), 3.2);
        let scan = [farther, nearer, nearer];
        let ranges = seen(
            &[bearing, bearing, bearing + 0.1],
            &scan,
            step(0.0, 0.0, 0.0),
        );
        assert!(
            ranges.iter().all(|r| (r - nearer).abs() < 1e-5),
            "{ranges:?} {nearer}"
        );
    }
}

#[test]
fn standing_still_changes_nothing() {
    let mut random = Seed(1).stream("scans");
    let sensors = [
        degrees(-90, 89),
        degrees(-180, 179),
        (0..360)
            .map(|i| f64::from(i) * PI / 360.0 - FRAC_PI_2)
            .collect(),
        (0..24).map(|i| f64::from(i) * TAU / 24.0).collect(),
        [90.0, 50.0, 30.0, 10.0, -10.0, -30.0, -50.0, -90.0]
            .map(f64::to_radians)
            .to_vec(),
        vec![0.3],
        vec![2.0, -1.0],
        // Two scanners in one channel, any order.
        degrees(-30, 30)
            .into_iter()
            .chain(degrees(150, 210))
            .rev()
            .collect(),
    ];
    for beams in sensors {
        for _ in 0..20 {
            let scan: Vec<f32> = beams
                .iter()
                .map(|_| match random.random_range(0..5) {
                    0 => f32::NAN,
                    1 => random.random_range(0.0..49.0),
                    _ => 3.0 + random.random_range(0.0..0.4),
                })
                .collect();
            for (own, after) in scan.iter().zip(seen(&beams, &scan, step(0.0, 0.0, 0.0))) {
                assert!(
                    own.is_nan() && after.is_nan() || (own - after).abs() < 2e-3,
                    "{own} {after}"
                );
            }
        }
    }
}

#[test]
fn no_return_stays_none_and_maxima_are_none() {
    let ring = degrees(-180, 179);
    let nothing = vec![f32::NAN; 360];
    for step in [step(0.0, 0.0, 0.0), step(0.4, -0.3, 33.3)] {
        assert!(seen(&ring, &nothing, step).iter().all(|r| r.is_nan()));
        let maxima = vec![50.0; 360];
        assert!(seen(&ring, &maxima, step).iter().all(|r| r.is_nan()));
    }
    // An open door 60° wide in a round wall of 2 m: of the same width after a turn.
    let door: Vec<f32> = (-180..180)
        .map(|d: i32| if d.abs() < 30 { f32::NAN } else { 2.0 })
        .collect();
    let open = |scan: &[f32]| scan.iter().filter(|r| r.is_nan()).count();
    assert_eq!(open(&seen(&ring, &door, step(0.0, 0.0, 100.0))), 59);
    // From half a metre closer the jambs, (1.741, ±0.985), are at ±38.4°; the open space was seen to ±29.5°, at 50 m: now
    // ±29.8°. Nobody knows what is between the two: half copies the jamb, half the open space.
    assert_eq!(open(&seen(&ring, &door, step(0.5, 0.0, 0.0))), 67);
    // Beyond the sensor's reach after a step back.
    let far = vec![49.9; 360];
    let back = seen(&ring, &far, step(-1.0, 0.0, 0.0));
    assert!(back[180].is_nan() && near(back[0], 48.9));
}

#[test]
fn bearings_that_are_none_are_refused() {
    assert!(Viewpoint::new(&[], None).is_err());
    let message = Viewpoint::new(&[0.0, f64::NAN], None)
        .unwrap_err()
        .to_string();
    assert!(message.contains("beam 1"), "{message}");
}

#[test]
fn any_scan_and_any_step_give_ranges_or_none() {
    let mut random = Seed(2).stream("anything");
    let ring = degrees(-180, 180);
    for _ in 0..300 {
        let odd = [0.0, -1.0, f32::INFINITY, f32::NAN, 1e-30, 1e30, 49.99, 50.0];
        let scan: Vec<f32> = ring
            .iter()
            .map(|_| match random.random_range(0..3) {
                0 => odd[random.random_range(0..odd.len())],
                _ => random.random_range(0.1..9.0),
            })
            .collect();
        let mut normal = |size: f64| size * (random.random::<f64>() - 0.5);
        let step = step(normal(20.0), normal(20.0), normal(2000.0));
        let ranges = seen(&ring, &scan, step);
        assert!(
            ranges.iter().all(|r| r.is_nan() || (0.0..50.0).contains(r)),
            "{ranges:?}"
        );
    }
}

/// The law of the ring: what a moved ring sees is what the moved middle sees, less the ring's radius.
#[test]
fn sensors_on_a_ring_see_the_same_walls_from_where_they_sit() {
    let bearing_rad: Vec<f64> = (0..72).map(|i| TAU * f64::from(i) / 72.0).collect();
    let room = |b: &f64| {
        let (sin, cos) = b.sin_cos();
        ((2.5 / cos.abs()).min(1.5 / sin.abs())) as f32
    };
    let scan: Vec<f32> = bearing_rad.iter().map(room).collect();
    let step = Displacement {
        forward_m: 0.3,
        left_m: -0.2,
        turn_rad: 0.4,
    };
    let radius_m = 0.22;
    let seen = |offset_m: Option<f64>, scan: &[f32]| {
        let viewpoint = Viewpoint::new(&bearing_rad, Some(6.5 - offset_m.unwrap_or(0.0))).unwrap();
        let viewpoint = match offset_m {
            Some(m) => viewpoint.with_offset_m(&[m; 72]),
            None => viewpoint,
        };
        let mut seen = vec![0.0; 72];
        viewpoint.render(scan, step, &mut seen);
        seen
    };
    let less: Vec<f32> = scan.iter().map(|r| r - radius_m as f32).collect();
    let (middle, ring) = (seen(None, &scan), seen(Some(radius_m), &less));
    for (middle, ring) in middle.iter().zip(&ring) {
        assert!(
            (middle - ring - radius_m as f32).abs() < 1e-5,
            "{middle} {ring}"
        );
    }
    let mistaken = seen(None, &less);
    let off = |(a, b): (&f32, &f32)| (a - b).abs();
    assert!(mistaken.iter().zip(&ring).map(off).fold(0.0, f32::max) > 0.05);
}
