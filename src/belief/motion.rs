//! How far odometry can be trusted.

use crate::{
    error::{Error, Result},
    geometry::Displacement,
};
use serde::{Deserialize, Serialize};

/// P(ξ | ξ̃, a) (Thrun 1998, eq. 2), with what odometry says as the action a: the robot went where odometry says, give or
/// take a Gaussian error whose variance grows with the movement.
///
/// The four noises are alpha1..alpha4 of the odometry motion model in Thrun, Burgard & Fox, *Probabilistic Robotics*
/// (2005), 5.4, with the turn of a step taken whole instead of split before and after the translation:
///
/// - variance of the heading = alpha1 · turn² + alpha2 · distance² + floor²,
/// - variance of x and of y = alpha3 · distance² + alpha4 · turn² + floor².
///
/// ```
/// use ballmark::{belief::OdometryMotion, geometry::Displacement};
/// let motion = OdometryMotion { translation_noise_from_translation: 0.01, translation_floor_m: 0.0, ..OdometryMotion::exact() };
/// let ahead = Displacement { forward_m: 2.0, left_m: 0.0, turn_rad: 0.0 };
/// assert!((motion.position_variance_m2(&ahead) - 0.04).abs() < 1e-15); // ±0.2 m after 2 m
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OdometryMotion {
    /// alpha1: rad² of heading variance per rad² of turn.
    pub rotation_noise_from_rotation: f64,
    /// alpha2: rad² of heading variance per m² of distance.
    pub rotation_noise_from_translation: f64,
    /// alpha3: m² of position variance per m² of distance.
    pub translation_noise_from_translation: f64,
    /// alpha4: m² of position variance per rad² of turn.
    pub translation_noise_from_rotation: f64,
    /// Standard deviation of the heading after no movement at all, in radians.
    pub rotation_floor_rad: f64,
    /// Standard deviation of x and of y after no movement at all, in metres.
    pub translation_floor_m: f64,
    /// Probability that the wheels turned and the robot stayed: the unmodelled. It also keeps a belief that odometry
    /// carries off the grid as a whole.
    pub stall_probability: f64,
}

impl Default for OdometryMotion {
    /// A wheeled robot indoors, pessimistically: 10 % of the distance, 14 % of the turn.
    fn default() -> Self {
        Self {
            rotation_noise_from_rotation: 0.02,
            rotation_noise_from_translation: 0.01,
            translation_noise_from_translation: 0.01,
            translation_noise_from_rotation: 0.01,
            rotation_floor_rad: 0.01,
            translation_floor_m: 0.01,
            stall_probability: 1e-6,
        }
    }
}

impl OdometryMotion {
    /// Odometry without error (and, so that a belief is never lost, one stall in 10⁶).
    pub fn exact() -> Self {
        Self {
            rotation_noise_from_rotation: 0.0,
            rotation_noise_from_translation: 0.0,
            translation_noise_from_translation: 0.0,
            translation_noise_from_rotation: 0.0,
            rotation_floor_rad: 0.0,
            translation_floor_m: 0.0,
            stall_probability: 1e-6,
        }
    }

    /// Variance of x, and of y, after a movement, in m².
    pub fn position_variance_m2(&self, step: &Displacement) -> f64 {
        self.translation_noise_from_translation * square(step.distance_m())
            + self.translation_noise_from_rotation * square(step.turn_rad)
            + square(self.translation_floor_m)
    }

    /// Variance of the heading after a movement, in rad².
    pub fn heading_variance_rad2(&self, step: &Displacement) -> f64 {
        self.rotation_noise_from_rotation * square(step.turn_rad)
            + self.rotation_noise_from_translation * square(step.distance_m())
            + square(self.rotation_floor_rad)
    }

    /// The parameters, if they make sense.
    ///
    /// # Errors
    /// Where a noise or a floor is negative or not finite, or the stall probability isn't in (0, 1): the call is wrong.
    pub fn checked(self) -> Result<Self> {
        let noises = [
            (
                "rotation_noise_from_rotation",
                self.rotation_noise_from_rotation,
            ),
            (
                "rotation_noise_from_translation",
                self.rotation_noise_from_translation,
            ),
            (
                "translation_noise_from_translation",
                self.translation_noise_from_translation,
            ),
            (
                "translation_noise_from_rotation",
                self.translation_noise_from_rotation,
            ),
            ("rotation_floor_rad", self.rotation_floor_rad),
            ("translation_floor_m", self.translation_floor_m),
        ];
        for (name, value) in noises {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::usage(format!(
                    "motion: `{name}` is {value}; expected 0 or more"
                )));
            }
        }
        if !(self.stall_probability > 0.0 && self.stall_probability < 1.0) {
            return Err(Error::usage(format!(
                "motion: `stall_probability` is {}; expected between 0 and 1, both excluded",
                self.stall_probability
            )));
        }
        Ok(self)
    }
}

fn square(v: f64) -> f64 {
    v * v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_grows_with_each_cause_by_its_own_noise() {
        let step = Displacement {
            forward_m: 3.0,
            left_m: 4.0,
            turn_rad: -2.0,
        };
        let motion = OdometryMotion {
            rotation_noise_from_rotation: 0.1,
            rotation_noise_from_translation: 0.2,
            translation_noise_from_translation: 0.3,
            translation_noise_from_rotation: 0.4,
            rotation_floor_rad: 0.5,
            translation_floor_m: 0.6,
            stall_probability: 0.01,
        };
        assert!((motion.heading_variance_rad2(&step) - (0.4 + 5.0 + 0.25)).abs() < 1e-12);
        assert!((motion.position_variance_m2(&step) - (7.5 + 1.6 + 0.36)).abs() < 1e-12);
    }

    #[test]
    fn senseless_parameters_are_refused_by_name() {
        let bad = OdometryMotion {
            translation_floor_m: -1.0,
            ..OdometryMotion::default()
        };
        let error = bad.checked().unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains("translation_floor_m"),
            "{error}"
        );
        for p in [0.0, 1.0, f64::NAN] {
            let bad = OdometryMotion {
                stall_probability: p,
                ..OdometryMotion::default()
            };
            assert!(
                bad.checked()
                    .unwrap_err()
                    .to_string()
                    .contains("stall_probability")
            );
        }
        assert!(OdometryMotion::default().checked().is_ok());
        assert!(OdometryMotion::exact().checked().is_ok());
    }
}
