//! The plain sonar of Ruiz-Mayor et al. (2006, 4.1): the distance to the nearest piece of wall inside the cone.

use super::SonarConfig;
use crate::world::{Surroundings, Wall, echo::Transducer};
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
