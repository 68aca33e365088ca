//! Places and movements in the plane: metres, radians, headings counter-clockwise from the x axis.

use nalgebra::{Isometry2, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// The angle in (−π, π] that points the same way.
///
/// ```
/// use ballmark::geometry::wrapped;
/// use std::f64::consts::PI;
/// assert!((wrapped(3.0 * PI) - PI).abs() < 1e-12);
/// assert!((wrapped(-0.5) + 0.5).abs() < 1e-12);
/// ```
pub fn wrapped(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}

/// Where a robot is and where it faces: ξ = ⟨x, y, θ⟩ (Thrun 1998, 2.1).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// East of the origin, in metres.
    pub x_m: f64,
    /// North of the origin, in metres.
    pub y_m: f64,
    /// Counter-clockwise from the x axis, in radians.
    pub heading_rad: f64,
}

/// A movement in the frame of the robot that makes it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Displacement {
    /// Ahead, in metres.
    pub forward_m: f64,
    /// To the left, in metres.
    pub left_m: f64,
    /// Counter-clockwise, in radians.
    pub turn_rad: f64,
}

impl Pose {
    /// A pose from metres, metres and radians.
    pub const fn new(x_m: f64, y_m: f64, heading_rad: f64) -> Self {
        Self {
            x_m,
            y_m,
            heading_rad,
        }
    }

    /// Are all three numbers finite?
    pub fn is_finite(&self) -> bool {
        self.x_m.is_finite() && self.y_m.is_finite() && self.heading_rad.is_finite()
    }

    /// Straight-line distance to another place, in metres.
    pub fn distance_m(&self, other: &Pose) -> f64 {
        // No hypot: it guards against overflow of numbers that no building has, at ten times the cost.
        ((self.x_m - other.x_m).powi(2) + (self.y_m - other.y_m).powi(2)).sqrt()
    }

    /// Unsigned difference of the headings, in [0, π] radians.
    pub fn turn_rad(&self, other: &Pose) -> f64 {
        wrapped(self.heading_rad - other.heading_rad).abs()
    }

    /// Where a robot at this pose is after a movement given in its own frame.
    ///
    /// ```
    /// use ballmark::geometry::{Displacement, Pose};
    /// let facing_north = Pose::new(1.0, 2.0, std::f64::consts::FRAC_PI_2);
    /// let step = Displacement { forward_m: 3.0, left_m: 0.0, turn_rad: 0.0 };
    /// let after = facing_north.after(step);
    /// assert!((after.x_m - 1.0).abs() < 1e-12 && (after.y_m - 5.0).abs() < 1e-12);
    /// assert!((facing_north.displacement_to(&after).forward_m - 3.0).abs() < 1e-12);
    /// ```
    pub fn after(&self, step: Displacement) -> Pose {
        let moved = self.isometry()
            * Isometry2::new(Vector2::new(step.forward_m, step.left_m), step.turn_rad);
        let (x_m, y_m) = (moved.translation.x, moved.translation.y);
        Pose::new(x_m, y_m, wrapped(self.heading_rad + step.turn_rad))
    }

    /// The movement, in this pose's frame, that leads to `to`.
    pub fn displacement_to(&self, to: &Pose) -> Displacement {
        let step = self.isometry().inv_mul(&to.isometry());
        Displacement {
            forward_m: step.translation.x,
            left_m: step.translation.y,
            turn_rad: wrapped(to.heading_rad - self.heading_rad),
        }
    }

    fn isometry(&self) -> Isometry2<f64> {
        Isometry2::new(Vector2::new(self.x_m, self.y_m), self.heading_rad)
    }
}

impl Displacement {
    /// Length of the straight line moved along, in metres.
    pub fn distance_m(&self) -> f64 {
        self.forward_m.hypot(self.left_m)
    }

    /// The same of a robot that drives a route: below 0 where it backs up.
    ///
    /// ```
    /// use ballmark::geometry::Displacement;
    /// let backed_up = Displacement { forward_m: -3.0, left_m: 4.0, turn_rad: 0.1 };
    /// assert_eq!((backed_up.distance_m(), backed_up.along_route_m()), (5.0, -5.0));
    /// ```
    pub fn along_route_m(&self) -> f64 {
        self.distance_m().copysign(self.forward_m)
    }
}
