//! How a sensor sits on the robot, as directions and distances of its readings.

use nalgebra::{Isometry3, Vector3};
use std::f64::consts::PI;

/// Parts of a mounting that a recording can't hold are worth a warning from here on, in metres and radians.
const NOTED: f64 = 0.3;

/// Where readings point, in the robot's frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Directions {
    pub bearing_rad: Vec<f64>,
    /// None where the sensor sits in the robot's middle.
    pub offset_m: Option<Vec<f64>>,
    /// What of the mounting was left out, in words.
    pub left_out: Option<&'static str>,
}

/// Directions of readings that a sensor makes at some angles in its own frame.
///
/// A recording says of each reading its bearing, and how far out along this bearing it begins. So of the sensor's place the
/// part along the bearing is kept where it is above 0, and the part across, and the height, are left out.
pub(super) fn directions(base_from_sensor: &Isometry3<f64>, angles_rad: &[f64]) -> Directions {
    let place = base_from_sensor.translation.vector;
    let (mut bearing_rad, mut offset_m) = (Vec::new(), Vec::new());
    let mut steepest = 0_f64;
    for angle in angles_rad {
        let ray = base_from_sensor.rotation * Vector3::new(angle.cos(), angle.sin(), 0.0);
        let flat = ray.xy().norm();
        steepest = steepest.max(ray.z.abs().atan2(flat));
        bearing_rad.push(ray.y.atan2(ray.x));
        let along = match flat > 0.0 {
            true => place.xy().dot(&ray.xy()) / flat,
            false => 0.0,
        };
        offset_m.push(along.max(0.0));
    }
    unwrap(&mut bearing_rad);
    let left_out = if steepest > NOTED {
        Some("tilted: its readings are taken as level")
    } else if place.xy().norm() > NOTED {
        Some(
            "more than 0.3 m from the robot's middle: of its place the part along each bearing is kept, the part across not",
        )
    } else {
        None
    };
    Directions {
        bearing_rad,
        offset_m: (place.xy().norm() > 1e-9).then_some(offset_m),
        left_out,
    }
}

/// Turns a jump of a whole turn between neighbours back, so that bearings go on evenly.
fn unwrap(bearing_rad: &mut [f64]) {
    for i in 1..bearing_rad.len() {
        let turns = ((bearing_rad[i - 1] - bearing_rad[i]) / (2.0 * PI)).round();
        bearing_rad[i] += turns * 2.0 * PI;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, UnitQuaternion};
    use std::f64::consts::FRAC_PI_2;

    fn mounted(x_m: f64, y_m: f64, roll: f64, pitch: f64, yaw: f64) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        Isometry3::from_parts(Translation3::new(x_m, y_m, 0.2), turn)
    }

    #[track_caller]
    fn close(found: &[f64], expected: &[f64]) {
        let apart = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
        assert!(
            found.len() == expected.len() && apart.fold(0.0, f64::max) < 1e-9,
            "{found:?}"
        );
    }

    #[test]
    fn yaw_turns_and_roll_mirrors() {
        let angles = [-0.5, 0.0, 0.5];
        let straight = directions(&mounted(0.0, 0.0, 0.0, 0.0, 0.0), &angles);
        close(&straight.bearing_rad, &angles);
        assert_eq!((straight.offset_m, straight.left_out), (None, None));
        let turned = directions(&mounted(0.0, 0.0, 0.0, 0.0, 3.0), &angles);
        close(&turned.bearing_rad, &[2.5, 3.0, 3.5]);
        let hanging = directions(&mounted(0.0, 0.0, PI, 0.0, 0.0), &angles);
        close(&hanging.bearing_rad, &[0.5, 0.0, -0.5]);
    }

    #[test]
    fn the_place_counts_along_each_bearing() {
        let ahead = directions(
            &mounted(0.2, 0.0, 0.0, 0.0, 0.0),
            &[0.0, 1.0, FRAC_PI_2, PI],
        );
        close(
            &ahead.offset_m.unwrap(),
            &[0.2, 0.2 * 1_f64.cos(), 0.0, 0.0],
        );
        assert_eq!(ahead.left_out, None);
        let far = directions(&mounted(0.2, 0.4, 0.0, 0.0, 0.0), &[0.0]);
        assert!(far.left_out.unwrap().contains("0.3 m"));
        let tilted = directions(&mounted(0.0, 0.0, 0.0, 0.5, 0.0), &[0.0]);
        assert!(tilted.left_out.unwrap().contains("tilted"));
    }
}
