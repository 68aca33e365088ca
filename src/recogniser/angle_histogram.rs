//! Which way the walls run: the main direction of a scan, for robots without a compass.
//!
//! Hinkel & Knieriemen, *Environment perception with a laser radar in a fast moving robot* (1988), count the directions of the
//! lines between neighbouring points of a scan; in a building they gather round the directions of its walls. Most walls
//! stand at right angles, so a main direction is known to a quarter turn only: whoever matches scans tries all four.

use super::occupancy::Reading;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Degrees of a quarter turn, a bin each.
const BINS: usize = 90;
/// Points of a scan farther apart than this are not taken to be of one wall, metres.
const JOINED_M: f64 = 1.5;
/// Bins on either side of the highest that its middle is taken over.
const AROUND: isize = 3;

/// The direction in [0, π/2) that most of the length between neighbouring points runs in, or at right angles to;
/// `None` where no two neighbours are near enough to one another.
///
/// ```
/// use ballmark::recogniser::{angle_histogram::main_direction, occupancy::Reading};
/// // A wall two metres to the left of a robot that is turned 0.3 rad to the right.
/// let scan: Vec<Reading> = (-5..=5)
///     .map(|i| f64::from(i) * 0.1)
///     .map(|aside| Reading {
///         bearing_rad: 1.57 + 0.3 + aside, offset_m: 0.0, range_m: 2.0 / aside.cos(), returned: true, opening_rad: 0.02
///     })
///     .collect();
/// assert!((main_direction(&scan).unwrap() - 0.3).abs() < 0.01);
/// ```
pub fn main_direction(readings: &[Reading]) -> Option<f64> {
    let mut points: Vec<(f64, f64, f64)> = readings
        .iter()
        .filter(|r| r.returned && r.range_m.is_finite() && r.bearing_rad.is_finite())
        .map(|r| {
            let bearing_rad = r.bearing_rad.rem_euclid(TAU);
            let (sin, cos) = bearing_rad.sin_cos();
            let from_middle_m = r.offset_m + r.range_m;
            (bearing_rad, from_middle_m * cos, from_middle_m * sin)
        })
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let next = points.iter().cycle().skip(1);
    let mut length_m = [0.0; BINS];
    for (a, b) in points.iter().zip(next) {
        let (x_m, y_m) = (b.1 - a.1, b.2 - a.2);
        let apart_m = x_m.hypot(y_m);
        if apart_m > 0.0 && apart_m <= JOINED_M {
            let share = y_m.atan2(x_m).rem_euclid(FRAC_PI_2) / FRAC_PI_2;
            length_m[((share * BINS as f64) as usize).min(BINS - 1)] += apart_m;
        }
    }
    peak(&length_m)
}

/// The middle of the mass round the highest bin, after light smoothing; bins go round.
fn peak(length_m: &[f64; BINS]) -> Option<f64> {
    let at = |bin: isize| length_m[bin.rem_euclid(BINS as isize) as usize];
    let smooth = |bin: isize| {
        let near = (-2..=2).map(|d: isize| (3 - d.abs()) as f64 * at(bin + d));
        near.sum::<f64>()
    };
    // The first of equally high ones.
    let highest = (0..BINS as isize)
        .rev()
        .max_by(|&a, &b| smooth(a).total_cmp(&smooth(b)))?;
    let around = || (-AROUND..=AROUND).map(|d| (d as f64, at(highest + d)));
    let mass: f64 = around().map(|(_, m)| m).sum();
    if mass <= 0.0 {
        return None;
    }
    let aside = around().map(|(d, m)| d * m).sum::<f64>() / mass;
    let bin = highest as f64 + 0.5 + aside;
    let direction = (bin / BINS as f64).rem_euclid(1.0) * FRAC_PI_2;
    // Rounding may make it a whole quarter.
    Some(if direction < FRAC_PI_2 {
        direction
    } else {
        0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::wrapped;

    /// The inside of a room 5 m by 3 m, seen from its middle by a robot of this heading.
    fn room(heading_rad: f64, beams: usize) -> Vec<Reading> {
        (0..beams)
            .map(|i| {
                let bearing_rad = TAU * i as f64 / beams as f64;
                let (sin, cos) = (bearing_rad + heading_rad).sin_cos();
                let range_m = (2.5 / cos.abs()).min(1.5 / sin.abs());
                Reading {
                    bearing_rad,
                    offset_m: 0.0,
                    returned: true,
                    range_m,
                    opening_rad: 0.02,
                }
            })
            .collect()
    }

    #[test]
    fn the_walls_of_a_room_are_found_whatever_the_heading() {
        for i in 0..40 {
            let heading_rad = f64::from(i) * 0.17;
            let found = main_direction(&room(heading_rad, 180)).unwrap();
            // 4 times the angle, so that quarter turns vanish.
            let off = wrapped(4.0 * (found + heading_rad)) / 4.0;
            assert!(
                (0.0..FRAC_PI_2).contains(&found) && off.abs() < 0.02,
                "{heading_rad}: {off}"
            );
        }
    }

    #[test]
    fn no_walls_no_direction() {
        let mut scan = room(0.2, 24);
        scan.iter_mut().for_each(|r| r.range_m = f64::NAN);
        assert_eq!(main_direction(&scan), None);
        assert_eq!(main_direction(&[]), None);
        assert_eq!(main_direction(&room(0.2, 1)), None);
    }
}
