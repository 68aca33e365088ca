//! Glass: stretches of wall that a laser goes through in some scans and not in others.

use super::{chance::Chance, plan::Plan};
use crate::world::{Material, Wall};

/// Walls shorter than this get no pane, metres.
const LEAST_WALL_M: f64 = 0.8;
/// Least and greatest width of a pane, metres.
const PANE_M: [f64; 2] = [0.6, 4.0];
/// Light that panes throw back lies below this share: what the scanner takes for clear is drawn anew in every scan.
pub(super) const CLEAREST: f64 = 0.3;

/// Makes a stretch of this share of the walls one of glass.
pub(super) fn glaze(plan: &mut Plan, share: f64, chance: &mut Chance) {
    let mut walls = Vec::with_capacity(plan.walls.len());
    for wall in &plan.walls {
        let length_m = (wall.to - wall.from).norm();
        if !chance.yes(share) || length_m < LEAST_WALL_M {
            walls.push(*wall);
            continue;
        }
        let width_m = chance.between(PANE_M[0], PANE_M[1].min(length_m));
        let begin_m = chance.between(0.0, length_m - width_m);
        let along = (wall.to - wall.from) / length_m;
        let (begin, end) = (
            wall.from + along * begin_m,
            wall.from + along * (begin_m + width_m),
        );
        let glass = Material {
            infrared: chance.between(0.0, CLEAREST),
            critical_angle_rad: 0.2,
            ..Material::PLAIN
        };
        let pieces = [
            (wall.from, begin, wall.material),
            (begin, end, glass),
            (end, wall.to, wall.material),
        ];
        let long_enough = pieces
            .into_iter()
            .filter(|(from, to, _)| (to - from).norm() > 1e-3);
        walls.extend(long_enough.map(|(from, to, material)| Wall::new(from, to, material)));
    }
    plan.walls = walls;
}
