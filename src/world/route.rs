//! A way through a building: straight legs with rounded corners between them.

use crate::error::{Error, Result};
use nalgebra::{Point2, Vector2};

/// A smooth way with one coordinate: metres along it.
///
/// ```
/// use ballmark::world::Route;
/// use nalgebra::Point2;
/// let route = Route::new(&[Point2::new(0.0, 0.0), Point2::new(5.0, 0.0), Point2::new(5.0, 5.0)], 1.0)?;
/// assert!((route.length_m() - (4.0 + std::f64::consts::FRAC_PI_2 + 4.0)).abs() < 1e-12);
/// let (place, heading_rad, _curvature) = route.at(4.0);
/// assert!((place - Point2::new(4.0, 0.0)).norm() < 1e-12 && heading_rad.abs() < 1e-12);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    pieces: Vec<Piece>,
    length_m: f64,
    closed: bool,
}

/// A stretch of constant curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start_m: f64,
    from: Point2<f64>,
    heading_rad: f64,
    /// 1 / radius, positive to the left; 0 on a straight.
    curvature_per_m: f64,
    length_m: f64,
}

impl Piece {
    /// How far it begins from a corner, metres.
    fn past_corner_m(&self, corner: &Point2<f64>) -> f64 {
        (self.from - corner).norm()
    }
}

impl Route {
    /// The way through `corners` (first and last are its ends), each bend an arc of `bend_radius_m` that touches both
    /// legs.
    ///
    /// # Errors
    /// Where there are fewer than two corners, one is not finite, the radius is negative, or a leg is too short for its
    /// bends.
    pub fn new(corners: &[Point2<f64>], bend_radius_m: f64) -> Result<Self> {
        let wrong = |fault: String| Err(Error::work(format!("route: {fault}")));
        if corners.len() < 2 {
            return wrong(format!("{} corners; expected at least 2", corners.len()));
        }
        if let Some(at) = corners
            .iter()
            .position(|c| !(c.x.abs() <= 1e6 && c.y.abs() <= 1e6))
        {
            return wrong(format!(
                "corner {at} is ({:e}, {:e}); expected metres within ±1e6",
                corners[at].x, corners[at].y
            ));
        }
        if !(bend_radius_m >= 0.0 && bend_radius_m.is_finite()) {
            return wrong(format!("bend radius {bend_radius_m} m; expected 0 or more"));
        }
        let legs: Vec<Vector2<f64>> = corners.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let turns: Vec<f64> = legs
            .windows(2)
            .map(|pair| pair[0].perp(&pair[1]).atan2(pair[0].dot(&pair[1])))
            .collect();
        // Where a bend leaves its leg: radius · tan(turn / 2) before the corner, and as much after.
        let cuts: Vec<f64> = turns
            .iter()
            .map(|turn| bend_radius_m * (turn / 2.0).tan().abs())
            .collect();
        let mut route = Self {
            pieces: Vec::new(),
            length_m: 0.0,
            closed: false,
        };
        for (index, leg) in legs.iter().enumerate() {
            let before_m = if index > 0 { cuts[index - 1] } else { 0.0 };
            let after_m = cuts.get(index).copied().unwrap_or(0.0);
            let straight_m = leg.norm() - before_m - after_m;
            // Negated, so that a leg without length or a turn on the spot (infinite cut) fails too.
            if !(straight_m >= 0.0 && leg.norm() > 0.0) {
                return wrong(format!(
                    "leg {index} is {} m long; expected at least {} m for its bends",
                    leg.norm(),
                    before_m + after_m
                ));
            }
            let from = corners[index] + leg.normalize() * before_m;
            let heading_rad = leg.y.atan2(leg.x);
            route.add(from, heading_rad, 0.0, straight_m);
            if let Some(turn_rad) = turns.get(index).filter(|_| after_m > 0.0) {
                let curvature_per_m = turn_rad.signum() / bend_radius_m;
                route.add(
                    from + leg.normalize() * straight_m,
                    heading_rad,
                    curvature_per_m,
                    turn_rad.abs() * bend_radius_m,
                );
            }
        }
        Ok(route)
    }

    /// The way round through `corners` and back: it begins where the bend at the first corner ends, and after one round
    /// leads into itself.
    ///
    /// ```
    /// use ballmark::world::Route;
    /// use nalgebra::Point2;
    /// let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(Point2::from);
    /// let round = Route::around(&square, 1.0)?;
    /// assert!((round.length_m() - (4.0 * 2.0 + std::f64::consts::TAU)).abs() < 1e-9);
    /// assert!((round.at(0.5 + 3.0 * round.length_m()).0 - Point2::new(1.5, 0.0)).norm() < 1e-9);
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Route::new`]; fewer than three corners make no way round.
    pub fn around(corners: &[Point2<f64>], bend_radius_m: f64) -> Result<Self> {
        if corners.len() < 3 {
            return Err(Error::work(format!(
                "route: {} corners; expected at least 3 for a way round",
                corners.len()
            )));
        }
        // Once round and one leg more: what lies between the ends of the bend at the first corner is the way round.
        let (first, second) = (corners[0], corners[1]);
        let once: Vec<Point2<f64>> = corners.iter().copied().chain([first, second]).collect();
        let mut route = Self::new(&once, bend_radius_m)?;
        let bend_m = route
            .pieces
            .last()
            .map_or(0.0, |piece| piece.past_corner_m(&first));
        route.pieces.pop();
        route.length_m = route.pieces.iter().map(|piece| piece.length_m).sum();
        // The first leg as yet begins at the corner, not past its bend.
        let leg = &mut route.pieces[0];
        if leg.length_m < bend_m {
            return Err(Error::work(format!(
                "route: leg 0 is {} m long up to its bend; expected at least {bend_m} m for the one at its start",
                leg.length_m
            )));
        }
        leg.from += Vector2::new(leg.heading_rad.cos(), leg.heading_rad.sin()) * bend_m;
        leg.length_m -= bend_m;
        let mut start_m = 0.0;
        for piece in &mut route.pieces {
            piece.start_m = start_m;
            start_m += piece.length_m;
        }
        route.length_m = start_m;
        route.closed = true;
        Ok(route)
    }

    /// Length of its first straight stretch, in metres: how far from the start a way round begins that takes the same
    /// corners the other way, from the other end of that stretch.
    pub(super) fn first_straight_m(&self) -> f64 {
        self.pieces.first().map_or(0.0, |piece| piece.length_m)
    }

    /// Does it lead back to its start?
    pub fn is_closed(&self) -> bool {
        self.closed
    }

    fn add(&mut self, from: Point2<f64>, heading_rad: f64, curvature_per_m: f64, length_m: f64) {
        self.pieces.push(Piece {
            start_m: self.length_m,
            from,
            heading_rad,
            curvature_per_m,
            length_m,
        });
        self.length_m += length_m;
    }

    /// Length of the way, in metres.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Place, heading (radians, not wrapped) and curvature (1/m, positive to the left) at a coordinate; before the
    /// start and past the end the first and last piece go on, or a way round begins anew.
    pub fn at(&self, route_m: f64) -> (Point2<f64>, f64, f64) {
        let route_m = if self.closed {
            route_m.rem_euclid(self.length_m)
        } else {
            route_m
        };
        let after = self
            .pieces
            .partition_point(|piece| piece.start_m <= route_m);
        let piece = &self.pieces[after.saturating_sub(1)];
        let (s, k, h) = (
            route_m - piece.start_m,
            piece.curvature_per_m,
            piece.heading_rad,
        );
        let moved = if k == 0.0 {
            Vector2::new(h.cos(), h.sin()) * s
        } else {
            Vector2::new((h + k * s).sin() - h.sin(), h.cos() - (h + k * s).cos()) / k
        };
        (piece.from + moved, h + k * s, k)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn points(corners: &[[f64; 2]]) -> Vec<Point2<f64>> {
        corners.iter().map(|&corner| corner.into()).collect()
    }

    #[test]
    fn the_coordinate_is_arc_length_and_the_heading_the_tangent() {
        // Left, right and slanted bends.
        let route = Route::new(
            &points(&[[0.0, 0.0], [6.0, 0.0], [6.0, 5.0], [11.0, 5.0], [15.0, 2.0]]),
            0.9,
        )
        .unwrap();
        let step_m = 1e-4;
        let mut at_m = 0.0;
        while at_m + step_m < route.length_m() {
            let ((a, heading_rad, _), (b, ..)) = (route.at(at_m), route.at(at_m + step_m));
            let moved = (b - a) / step_m;
            assert!((moved.norm() - 1.0).abs() < 1e-4, "at {at_m}");
            assert!(
                (moved - Vector2::new(heading_rad.cos(), heading_rad.sin())).norm() < 1e-3,
                "at {at_m}"
            );
            at_m += 0.0137;
            // No jump or kink where two pieces meet: neither place nor heading runs ahead of the coordinate.
            let (next, next_heading_rad, _) = route.at(at_m);
            assert!((next - a).norm() < 0.0138, "at {at_m}");
            assert!(
                (next_heading_rad - heading_rad).abs() < 0.0137 / 0.9 + 1e-9,
                "at {at_m}"
            );
        }
        assert!((route.at(route.length_m()).0 - Point2::new(15.0, 2.0)).norm() < 1e-9);
        let (_, heading_rad, curvature) = route.at(6.0 - 0.9 + 0.45 * FRAC_PI_2);
        assert!(
            (heading_rad - FRAC_PI_2 / 2.0).abs() < 1e-9 && (curvature - 1.0 / 0.9).abs() < 1e-9
        );
    }

    #[test]
    fn ways_that_cannot_be_driven_are_told() {
        for (corners, radius, expected) in [
            (vec![[0.0, 0.0]], 1.0, "1 corners"),
            (vec![[0.0, 0.0], [f64::NAN, 0.0]], 1.0, "corner 1"),
            (vec![[0.0, 0.0], [1.0, 0.0]], -1.0, "bend radius -1"),
            (vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]], 0.8, "leg 1"),
            (vec![[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]], 0.1, "leg 0"),
            (vec![[0.0, 0.0], [0.0, 0.0]], 0.0, "leg 0"),
        ] {
            let message = Route::new(&points(&corners), radius)
                .unwrap_err()
                .to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
