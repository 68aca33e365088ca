//! The plain sonar of Ruiz-Mayor et al. (2006, 4.1): the distance to the nearest piece of wall inside the cone.

use super::SonarConfig;
use super::echo::Transducer;
use crate::world::{Surroundings, Wall};
use nalgebra::Vector2;

/// Distance from the transducer to the nearest point of any wall within its cone, metres, where it is below the
/// maximum. Nothing can hide that point: whatever stood before it would be nearer, and in the cone too.
pub(super) fn in_cone_m(
    around: &Surroundings,
    sonar: &SonarConfig,
    transducer: &Transducer,
) -> Option<f64> {
    let standing = |wall: &&Wall| wall.stands_at(sonar.height_m);
    around
        .caster()
        .plan()
        .walls()
        .iter()
        .chain(around.passing())
        .filter(standing)
        .filter_map(|wall| part_in_cone_m(wall, transducer, sonar.opening_rad / 2.0))
        .min_by(f64::total_cmp)
        .filter(|&metres| metres < sonar.maximum_m)
}

/// The same for one wall. In the transducer's frame (x along its axis) the cone is where two half planes meet, so the
/// wall is clipped to each; of what is left the point nearest to the origin counts.
fn part_in_cone_m(wall: &Wall, transducer: &Transducer, half_rad: f64) -> Option<f64> {
    let local = |point| {
        let away: Vector2<f64> = point - transducer.place;
        let ahead = transducer.axis();
        Vector2::new(ahead.dot(&away), ahead.perp(&away))
    };
    let (from, to) = (local(wall.from), local(wall.to));
    let (sin, cos) = half_rad.sin_cos();
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for side in [-1.0, 1.0] {
        // How far inside the cone's edge on this side, metres.
        let inside = |point: &Vector2<f64>| point.x * sin + side * point.y * cos;
        let (at_from, at_to) = (inside(&from), inside(&to));
        match (at_from >= 0.0, at_to >= 0.0) {
            (true, true) => {}
            (false, false) => return None,
            (inside_first, _) => {
                let crossing = at_from / (at_from - at_to);
                if inside_first {
                    leave = leave.min(crossing);
                } else {
                    enter = enter.max(crossing);
                }
            }
        }
    }
    if enter > leave {
        return None;
    }
    let along = to - from;
    let foot = (-from.dot(&along) / along.norm_squared()).clamp(enter, leave);
    Some((from + along * foot).norm())
}

#[cfg(test)]
mod tests {
    use crate::{
        geometry::Pose,
        seed::Seed,
        world::{
            FloorPlan, Material, Raycaster, Sonar, SonarConfig, Surroundings, Wall,
            sonar::tests::{close, scan, upright},
        },
    };
    use nalgebra::{Point2, Vector2};
    use rand::RngExt;

    #[test]
    fn a_plain_sonar_tells_the_nearest_wall_in_its_cone_whatever_it_is() {
        let plain = |walls: Vec<Wall>| {
            let config = SonarConfig {
                ring_radius_m: 0.0,
                resolution_m: 0.0,
                ..SonarConfig::sancho2()
            };
            scan(config, walls)
        };
        let turned = |deg: f64| {
            let (sin, cos) = deg.to_radians().sin_cos();
            let (foot, along) = (Point2::new(cos, sin) * 2.0, Vector2::new(-sin, cos) * 9.0);
            let mirror = upright(0.0, 0.01).material;
            Wall::new(foot - along, foot + along, mirror)
        };
        // The wall's foot lies in the cone of ±15° up to there; past it, the cone's edge meets the wall first.
        for deg in [0.0, 10.0, -14.0] {
            assert!(close(plain(vec![turned(deg)])[0], 2.0, 1e-6));
        }
        let edge_m = 2.0 / 25_f64.to_radians().cos();
        assert!(close(plain(vec![turned(40.0)])[0], edge_m, 1e-6));
        // 110° and more aside, it slants away from the cone; all twelve cones together see all round.
        assert!(plain(vec![turned(110.0)])[0].is_nan());
        let short = |x_m: f64, y1_m: f64, y2_m: f64| {
            Wall::new(
                Point2::new(x_m, y1_m),
                Point2::new(x_m, y2_m),
                Material::PLAIN,
            )
        };
        // A door frame whose edge stands 14° aside is seen, one 16° aside is not: the room behind is.
        let frame = |deg: f64| short(1.0, deg.to_radians().tan(), 5.0);
        let behind = upright(3.0, 0.2);
        assert!(close(
            plain(vec![frame(14.0), behind])[0],
            1.0 / 14_f64.to_radians().cos(),
            1e-6
        ));
        assert!(close(plain(vec![frame(16.0), behind])[0], 3.0, 1e-6));
        // Nothing past 6 m; a bench lower than the ring (0.3 m) is not there.
        assert!(plain(vec![upright(6.0, 0.2)])[0].is_nan());
        let bench = short(1.0, -1.0, 1.0).between(0.0, 0.25);
        assert!(close(plain(vec![bench, behind])[0], 3.0, 1e-6));
    }

    #[test]
    fn a_plain_sonar_tells_what_many_rays_find() {
        let mut random = Seed(8).stream("walls");
        let config = SonarConfig {
            resolution_m: 0.0,
            ..SonarConfig::sancho2()
        };
        let sonar = Sonar::new(config.clone()).unwrap();
        for _ in 0..50 {
            let mut end = || {
                Point2::new(
                    random.random_range(-3.0..3.0),
                    random.random_range(-3.0..3.0),
                )
            };
            let walls: Vec<Wall> = (0..6)
                .map(|_| Wall::new(end(), end(), Material::PLAIN))
                .collect();
            let caster = Raycaster::new(FloorPlan::new(walls).unwrap());
            let around = Surroundings::from(&caster);
            for beam in 0..12 {
                let axis_rad = sonar.bearing_rad(beam);
                let place = Point2::new(axis_rad.cos(), axis_rad.sin()) * 0.25;
                let by_rays = (0..=4000)
                    .filter_map(|ray| {
                        let angle = axis_rad + (f64::from(ray) / 4000.0 - 0.5) * config.opening_rad;
                        let direction = Vector2::new(angle.cos(), angle.sin());
                        around.cast(&place, &direction, 5.999, 0.3)
                    })
                    .map(|hit| hit.distance_m)
                    .min_by(f64::total_cmp);
                let exactly = sonar.echo_m(&around, &Pose::default(), beam);
                match (by_rays, exactly) {
                    (None, None) => {}
                    // Rays miss what is thinner than the way between them, and are never nearer than the nearest.
                    (Some(rays_m), Some(exact_m)) => {
                        assert!(
                            (-1e-9..0.01).contains(&(rays_m - exact_m)),
                            "{rays_m} {exact_m}"
                        );
                    }
                    (rays, exact) => panic!("rays: {rays:?}, exactly: {exact:?}"),
                }
            }
        }
    }

    #[test]
    fn sancho_tells_ranges_in_steps_of_four_centimetres() {
        // 2.345 − 0.25 = 2.095 m: 52.4 steps
        let reading_m = scan(SonarConfig::sancho2(), vec![upright(2.345, 0.2)])[0];
        assert!(close(reading_m, 52.0 * 0.04, 1e-6), "{reading_m}");
    }
}
