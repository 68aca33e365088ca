//! The landmarks that people would choose, where the plan has them: doors and lamps. What finders of them are judged by;
//! nothing that a robot could know.

use super::Building;
use nalgebra::{Point2, Vector2};

/// A straight stretch of a wall's face on the floor plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub(super) from: Point2<f64>,
    pub(super) to: Point2<f64>,
    pub(super) is_door: bool,
}

impl Stretch {
    /// How far away a ray of length 1 along `towards` meets it, metres.
    fn distance_m(&self, from: &Point2<f64>, towards: &Vector2<f64>) -> Option<f64> {
        let (along, apart) = (self.to - self.from, self.from - from);
        let crossing = towards.perp(&along);
        let (distance_m, share) = (
            apart.perp(&along) / crossing,
            apart.perp(towards) / crossing,
        );
        // Parallel ones make it infinite or no number, which is in no range.
        ((0.0..f64::INFINITY).contains(&distance_m) && (0.0..=1.0).contains(&share))
            .then_some(distance_m)
    }
}

impl Building {
    /// Is the first wall in a direction (radians, from the x axis) a door's at the point where it is met, shut or open?
    /// False too where there is no wall. Walls are as the plan draws them: rooms behind doors, bins and people are not on it,
    /// and the mouths of hallways, windows and niches are part of their wall.
    ///
    /// ```
    /// use ballmark::world::Building;
    /// use nalgebra::Point2;
    /// use std::f64::consts::FRAC_PI_2;
    /// let hall = Building::from_text(r#"
    ///     name = "hall"
    ///     [[wall]]
    ///     points = [[0, 0], [9, 0]]
    ///     door = [{ at_m = 4, width_m = 1 }]
    ///     [sonar]
    ///     beams = 8
    ///     [path]
    ///     corners = [[1, 1], [8, 1]]
    ///     [record]
    ///     every_m = 0.5
    /// "#)?;
    /// assert!(hall.is_door_towards(&Point2::new(4.5, 1.0), -FRAC_PI_2));
    /// assert!(!hall.is_door_towards(&Point2::new(3.5, 1.0), -FRAC_PI_2));
    /// assert!(!hall.is_door_towards(&Point2::new(4.5, 1.0), FRAC_PI_2));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn is_door_towards(&self, from: &Point2<f64>, direction_rad: f64) -> bool {
        let (sin, cos) = direction_rad.sin_cos();
        let towards = Vector2::new(cos, sin);
        let map = self.map_walls.iter().map(|wall| Stretch {
            from: wall.from,
            to: wall.to,
            is_door: false,
        });
        let stretches = self.walls.iter().flat_map(|wall| wall.stretches());
        let met = stretches.chain(map).filter_map(|stretch| {
            let distance_m = stretch.distance_m(from, &towards)?;
            Some((distance_m, stretch.is_door))
        });
        met.min_by(|a, b| a.0.total_cmp(&b.0))
            .is_some_and(|(_, is_door)| is_door)
    }

    /// Does the middle of a lamp that burns hang within so many metres of a place?
    pub fn has_lamp_within(&self, place: &Point2<f64>, metres: f64) -> bool {
        let mut lit = self.lights.iter().filter(|light| light.lit);
        lit.any(|light| (light.at - place).norm() <= metres)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn the_first_wall_counts_and_only_its_doors() {
        let world = Building::from_text(
            r#"
            name = "hall"
            [[wall]]
            points = [[0, 0], [9, 0], [9, 4]]
            door = [{ at_m = 2, width_m = 1, open = 1 }, { at_m = 10, width_m = 2 }]
            window = [{ at_m = 5, width_m = 1 }]
            hallway = [{ at_m = 7, width_m = 1, depth_m = 3 }]
            [[wall]]
            points = [[9, 6], [0, 6]]
            door = [{ at_m = 1, width_m = 2 }]
            [[wall]]
            points = [[7, 4.5], [8, 4.5]]
            [[light]]
            at = [2, 2]
            [[light]]
            at = [6, 2]
            lit = false
            [sonar]
            beams = 8
            [path]
            corners = [[1, 2], [8, 2]]
            [record]
            every_m = 0.5
            "#,
        )
        .unwrap();
        let at =
            |x: f64, y: f64, direction: f64| world.is_door_towards(&Point2::new(x, y), direction);
        let (east, north, west, south) = (0.0, PI / 2.0, PI, -PI / 2.0);
        // An open door is one, and so is one round the corner.
        assert!(at(2.5, 2.0, south) && !at(1.9, 2.0, south) && !at(3.1, 2.0, south));
        assert!(at(4.0, 2.0, east) && !at(4.0, 0.5, east) && !at(4.0, 3.5, east));
        // A window and a hallway are none; nor is there a wall to the west.
        assert!(!at(5.5, 2.0, south) && !at(7.5, 2.0, south) && !at(4.0, 2.0, west));
        // The door of the far wall, from 6 to 8 m, is hidden from 7 m on by a wall before it.
        assert!(at(6.5, 2.0, north) && !at(7.5, 2.0, north) && at(7.5, 5.0, north));
        // From behind the robot nothing is met.
        assert!(!at(2.5, -1.0, south));

        let lamp = |x: f64, y: f64| world.has_lamp_within(&Point2::new(x, y), 0.8);
        assert!(lamp(2.0, 1.21) && !lamp(2.0, 1.19) && !lamp(6.0, 2.0));
    }
}
