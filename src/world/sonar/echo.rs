//! Echoes: how sound sent out in a cone finds its way back, or doesn't.
//!
//! Surfaces are mirrors beyond their critical angle; right-angled corners throw sound back to the sender (Kuc & Siegel,
//! *Physically based simulation model for acoustic sensor robot navigation*, 1987).

use super::{
    SonarConfig,
    loudness::{excess_db, heard_m, incidence_db, off_axis_db},
};
use crate::{
    geometry::Pose,
    world::{Hit, Surroundings},
};
use nalgebra::{Point2, Vector2};

/// After a reflection a ray starts this much short of the wall, on the side that it came from, so that rounding can't
/// put it behind the wall or, in a corner, behind the next one.
pub(super) const STEP_BACK_M: f64 = 1e-6;

/// A transducer of the ring, in the building's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transducer {
    pub place: Point2<f64>,
    /// Where its cone points.
    pub axis_rad: f64,
    /// How much louder than usual echoes are in it at this reading, dB.
    pub fade_db: f64,
}

impl Transducer {
    /// The one mounted at `mounted_rad` on the rim of a robot while its cone points along `bearing_rad`, both in the
    /// robot's frame.
    pub fn mounted(pose: &Pose, ring_radius_m: f64, mounted_rad: f64, bearing_rad: f64) -> Self {
        let outward = unit(pose.heading_rad + mounted_rad);
        Self {
            place: Point2::new(pose.x_m, pose.y_m) + outward * ring_radius_m,
            axis_rad: pose.heading_rad + bearing_rad,
            fade_db: 0.0,
        }
    }

    /// Unit vector along the middle of its cone.
    pub fn axis(&self) -> Vector2<f64> {
        unit(self.axis_rad)
    }
}

/// Unit vectors of the rays that sample a transducer's cone, evenly from edge to edge, and how far each is from the axis, −1 to 1.
pub(super) fn cone(
    sonar: &SonarConfig,
    transducer: &Transducer,
) -> impl Iterator<Item = (Vector2<f64>, f64)> {
    let (rays, opening_rad, axis_rad) = (sonar.rays, sonar.opening_rad, transducer.axis_rad);
    let last = (rays - 1).max(1) as f64;
    (0..rays).map(move |ray| {
        let share = if rays == 1 {
            0.0
        } else {
            ray as f64 / last - 0.5
        };
        (unit(axis_rad + share * opening_rad), 2.0 * share)
    })
}

/// Where a ray goes on from, and which way, after a mirror.
pub(super) fn mirrored(
    origin: &Point2<f64>,
    direction: &Vector2<f64>,
    hit: &Hit,
) -> (Point2<f64>, Vector2<f64>) {
    (
        origin + direction * (hit.distance_m - STEP_BACK_M),
        direction + hit.normal * (2.0 * hit.cos_incidence),
    )
}

/// The nearest echo of its own pulse that a transducer hears, in metres.
pub(super) fn nearest_echo_m(
    around: &Surroundings,
    sonar: &SonarConfig,
    transducer: &Transducer,
) -> Option<f64> {
    cone(sonar, transducer)
        .filter_map(|(direction, share)| {
            let margin_db = transducer.fade_db - 2.0 * off_axis_db(sonar, share);
            ray_echo_m(around, sonar, &transducer.place, direction, margin_db)
        })
        .min_by(f64::total_cmp)
}

/// Follows one ray until it comes back: half the way it made, if that is still heard; it is `margin_db` louder than usual.
fn ray_echo_m(
    around: &Surroundings,
    sonar: &SonarConfig,
    transducer: &Point2<f64>,
    mut direction: Vector2<f64>,
    margin_db: f64,
) -> Option<f64> {
    let heard = |range_m, heard_to_m, loss_db: f64| {
        let excess_db = excess_db(sonar, range_m, heard_to_m) + margin_db - loss_db;
        heard_m(sonar, range_m, excess_db)
    };
    let mut origin = *transducer;
    let mut way_m = 0.0;
    let mut heard_to_m = sonar.maximum_m;
    for reflected in 0..=sonar.reflections {
        let hit = around.cast(&origin, &direction, 2.0 * sonar.maximum_m, sonar.height_m);
        // Two mirrors may have turned the ray back to where it came from: a corner.
        if reflected >= 2 {
            let back = transducer - origin;
            let back_m = back.dot(&direction);
            let missed_by_m = (back - direction * back_m).norm();
            let free = hit.is_none_or(|hit| hit.distance_m >= back_m);
            if back_m > 0.0 && missed_by_m <= sonar.capture_radius_m && free {
                let range_m = (way_m + back_m) / 2.0;
                return heard(range_m, heard_to_m, 0.0);
            }
        }
        let hit = hit?;
        let material = around.wall(&hit).material;
        way_m += hit.distance_m;
        heard_to_m *= material.reflectivity;
        if way_m >= 2.0 * heard_to_m {
            return None;
        }
        let critical_rad = material.critical_angle_rad;
        if hit.cos_incidence >= critical_rad.cos() {
            let loss_db = incidence_db(sonar, hit.cos_incidence, critical_rad);
            return heard(way_m, heard_to_m, loss_db); // back the way it came
        }
        (origin, direction) = mirrored(&origin, &direction, &hit);
    }
    None
}

fn unit(angle_rad: f64) -> Vector2<f64> {
    Vector2::new(angle_rad.cos(), angle_rad.sin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{
        FloorPlan, Material, OpenDoor, Raycaster, Room, Sonar, Wall, WallLine, floor_plan::round,
    };
    use std::f64::consts::PI;

    const MIRROR: Material = Material {
        reflectivity: 1.0,
        critical_angle_rad: 0.1,
        ..Material::PLAIN
    };
    const ROUGH: Material = Material {
        reflectivity: 1.0,
        critical_angle_rad: 0.35,
        ..Material::PLAIN
    };

    fn sonar() -> Sonar {
        Sonar::new(SonarConfig::default()).unwrap()
    }

    /// A wall at 2 m whose normal is turned from the x axis.
    fn wall(turned_deg: f64, material: Material) -> Wall {
        let normal = unit(turned_deg.to_radians());
        let (foot, along) = (
            Point2::origin() + normal * 2.0,
            Vector2::new(-normal.y, normal.x) * 9.0,
        );
        Wall::new(foot - along, foot + along, material)
    }

    /// What the sonar straight ahead hears from a place.
    fn ahead_m(walls: Vec<Wall>, pose: Pose) -> Option<f64> {
        sonar().echo_m(
            &(&Raycaster::new(FloorPlan::new(walls).unwrap())).into(),
            &pose,
            0,
        )
    }

    #[test]
    fn a_wall_is_heard_at_its_foot_while_that_is_in_the_cone() {
        let heard =
            |turned_deg, material| ahead_m(vec![wall(turned_deg, material)], Pose::default());
        // The transducer stands 0.26 m ahead, so it is 2 − 0.26 cos(turn) from the wall.
        for turned_deg in [0.0, 5.0, -10.0] {
            let expected_m = 2.0 - 0.26 * f64::cos(f64::to_radians(turned_deg));
            assert!((heard(turned_deg, MIRROR).unwrap() - expected_m).abs() < 1e-3);
        }
        // At 30° the ray at the cone's edge, 12.5° aside, meets the wall at 17.5°: within 0.35 rad, beyond 0.1 rad.
        let foot_m = 2.0 - 0.26 * 30_f64.to_radians().cos();
        let edge_m = foot_m / 17.5_f64.to_radians().cos();
        assert!((heard(30.0, ROUGH).unwrap() - edge_m).abs() < 1e-9);
        assert_eq!(heard(30.0, MIRROR), None);
        assert_eq!(heard(50.0, ROUGH), None);
    }

    #[test]
    fn the_nearest_thing_in_the_cone_is_heard() {
        let pole = |aside_deg: f64| {
            round(
                Point2::origin() + unit(aside_deg.to_radians()) * 1.3,
                0.05,
                16,
                ROUGH,
            )
        };
        let with_pole = |aside_deg| {
            let walls = [vec![wall(0.0, MIRROR)], pole(aside_deg)].concat();
            ahead_m(walls, Pose::default()).unwrap()
        };
        assert!((with_pole(8.0) - 1.0).abs() < 0.05, "in the cone");
        assert!((with_pole(25.0) - 1.74).abs() < 1e-9, "out of the cone");
    }

    #[test]
    fn a_corner_of_mirrors_throws_sound_back() {
        let corner = |x: f64| {
            vec![
                Wall::new(Point2::new(x, 2.0), Point2::new(x, -9.0), MIRROR),
                Wall::new(Point2::new(x, 2.0), Point2::new(-9.0, 2.0), MIRROR),
            ]
        };
        for aside_deg in [0.0, 1.0, -9.0_f64] {
            let pose = Pose::new(0.0, 0.0, (45.0 + aside_deg).to_radians());
            let transducer = Point2::origin() + unit(pose.heading_rad) * 0.26;
            let expected_m = (Point2::new(2.0, 2.0) - transducer).norm();
            let heard_m = ahead_m(corner(2.0), pose).unwrap();
            assert!(
                (heard_m - expected_m).abs() < 0.01,
                "{heard_m} for {expected_m}"
            );
        }
        let turned_away = Pose::new(0.0, 0.0, 20_f64.to_radians());
        assert_eq!(ahead_m(corner(2.0), turned_away), None);
    }

    #[test]
    fn a_door_frame_is_heard_where_the_bare_wall_is_not() {
        let (from, to) = (Point2::new(0.0, 1.0), Point2::new(10.0, 1.0));
        let line = WallLine {
            from,
            to,
            corridor_on_left: false,
            material: MIRROR,
        };
        let room = Room {
            before_m: 1.0,
            after_m: 1.0,
            depth_m: 3.0,
        };
        let door = OpenDoor {
            at_m: 4.0,
            width_m: 1.0,
            setback_m: 0.12,
            opened_rad: 0.0,
            room,
            leaf: MIRROR,
            frame: MIRROR,
        };
        let face = |from_m, to_m| Wall::new(line.point(from_m, 0.0), line.point(to_m, 0.0), MIRROR);
        let mut with_door = line.door(&door);
        with_door.extend([face(0.0, 4.0), face(5.0, 10.0)]);
        // The far corner between leaf and frame lies at (5, 1.12): 1.12 √2 away at 45°, less the ring's radius.
        let pose = Pose::new(3.88, 0.0, PI / 4.0);
        let heard_m = ahead_m(with_door, pose).unwrap();
        assert!(
            (heard_m - (1.12 * 2_f64.sqrt() - 0.26)).abs() < 0.01,
            "{heard_m}"
        );
        assert_eq!(ahead_m(vec![face(0.0, 10.0)], pose), None);
    }

    #[test]
    fn nothing_is_heard_past_the_maximum_or_off_a_dull_surface() {
        let dull = Material {
            reflectivity: 0.1,
            ..ROUGH
        };
        assert_eq!(ahead_m(vec![wall(0.0, dull)], Pose::default()), None);
        assert_eq!(
            ahead_m(vec![wall(0.0, ROUGH)], Pose::new(-9.0, 0.0, 0.0)),
            None
        );
        assert!(ahead_m(vec![wall(0.0, ROUGH)], Pose::new(-7.5, 0.0, 0.0)).is_some());
    }
}
