//! Buildings that are not all right angles: a slow wave and a shear along x, then a slow wave along y.

use super::chance::Chance;
use crate::world::Wall;
use nalgebra::Point2;

/// Longest straight piece that a bent wall is made of, metres.
const PIECE_M: f64 = 2.0;

/// A bending of the plane; the default leaves it as it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bend {
    /// Amplitude of the wave in x along y, metres, and metres a radian of it.
    wave_x_m: [f64; 2],
    /// The same of y along x.
    wave_y_m: [f64; 2],
    /// Metres in x a metre in y.
    shear: f64,
}

impl Default for Bend {
    fn default() -> Self {
        Self {
            wave_x_m: [0.0, 1.0],
            wave_y_m: [0.0, 1.0],
            shear: 0.0,
        }
    }
}

impl Bend {
    /// One drawn at random.
    pub fn draw(chance: &mut Chance) -> Self {
        let mut wave = || [chance.between(0.0, 1.5), chance.between(6.0, 15.0)];
        let (wave_x_m, wave_y_m) = (wave(), wave());
        Self {
            wave_x_m,
            wave_y_m,
            shear: chance.between(-0.3, 0.3),
        }
    }

    /// Where a point comes to lie.
    pub fn point(&self, point: &Point2<f64>) -> Point2<f64> {
        let x_m = point.x + self.aside_m(point.y);
        Point2::new(x_m, point.y + self.up_m(x_m))
    }

    /// Which point came to lie here.
    pub fn undone(&self, point: &Point2<f64>) -> Point2<f64> {
        let y_m = point.y - self.up_m(point.x);
        Point2::new(point.x - self.aside_m(y_m), y_m)
    }

    /// Walls as they come to lie, in straight pieces.
    pub fn walls(&self, walls: &[Wall]) -> Vec<Wall> {
        if *self == Self::default() {
            return walls.to_vec();
        }
        let mut bent = Vec::new();
        for wall in walls {
            let along = wall.to - wall.from;
            let pieces = (along.norm() / PIECE_M).ceil().max(1.0) as usize;
            let corner =
                |piece: usize| self.point(&(wall.from + along * (piece as f64 / pieces as f64)));
            bent.extend((0..pieces).map(|piece| Wall {
                from: corner(piece),
                to: corner(piece + 1),
                ..*wall
            }));
        }
        bent
    }

    fn aside_m(&self, y_m: f64) -> f64 {
        let [amplitude_m, scale_m] = self.wave_x_m;
        amplitude_m * (y_m / scale_m).sin() + self.shear * y_m
    }

    fn up_m(&self, x_m: f64) -> f64 {
        let [amplitude_m, scale_m] = self.wave_y_m;
        amplitude_m * (x_m / scale_m).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{seed::Seed, world::Material};

    #[test]
    fn what_was_bent_is_found_again_and_walls_stay_joined() {
        let mut chance = Chance(Seed(1).stream("bend"));
        let bend = Bend::draw(&mut chance);
        for _ in 0..50 {
            let place = Point2::new(chance.between(-20.0, 80.0), chance.between(-20.0, 40.0));
            let bent = bend.point(&place);
            assert!((bend.undone(&bent) - place).norm() < 1e-9);
        }
        let wall = Wall::new(Point2::origin(), Point2::new(11.0, 0.0), Material::PLAIN);
        let pieces = bend.walls(&[wall]);
        assert_eq!(pieces.len(), 6);
        assert!(pieces.windows(2).all(|two| two[0].to == two[1].from));
        assert_eq!(pieces[5].to, bend.point(&wall.to));
        assert!(pieces[3].from.y.abs() > 1e-3, "it is not straight any more");
    }
}
