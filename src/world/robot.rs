//! A robot as it drives and dead-reckons, and where it stops for a snapshot.

use super::OdometryConfig;
use crate::{
    error::{Error, Result},
    geometry::Pose,
};
use serde::{Deserialize, Serialize};

/// How the robot drives and dead-reckons. Its speed is that of Thrun 1998, 5.1.2; the rest is assumed for a B21 with
/// synchro drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RobotConfig {
    /// Radius of the round robot, metres.
    pub radius_m: f64,
    /// Speed, metres a second.
    pub speed_m_per_s: f64,
    /// Standard deviation of the deviation to either side, metres.
    pub lateral_sd_m: f64,
    /// Deviations bend softly towards this limit, as obstacle avoidance keeps off the walls, metres.
    pub lateral_limit_m: f64,
    /// Standard deviation of the heading around the way actually driven, radians, anew at each snapshot.
    pub heading_sd_rad: f64,
    /// Runs start up to this far along the route, metres.
    pub start_scatter_m: f64,
    /// How its odometry drifts.
    pub odometry: OdometryConfig,
}

impl Default for RobotConfig {
    fn default() -> Self {
        Self {
            radius_m: 0.27,
            speed_m_per_s: 0.15,
            lateral_sd_m: 0.12,
            lateral_limit_m: 0.4,
            heading_sd_rad: 0.05,
            start_scatter_m: 0.25,
            odometry: OdometryConfig::default(),
        }
    }
}

/// Where a snapshot is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// The true pose.
    pub pose: Pose,
    /// Metres along the route.
    pub route_m: f64,
    /// Seconds since the run began.
    pub stamp_s: f64,
    /// Dead-reckoned pose; the run starts at the origin.
    pub odometry: Pose,
}

impl RobotConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let positive = [
            ("radius_m", self.radius_m),
            ("speed_m_per_s", self.speed_m_per_s),
            ("lateral_limit_m", self.lateral_limit_m),
        ];
        let not_negative = [
            ("lateral_sd_m", self.lateral_sd_m),
            ("heading_sd_rad", self.heading_sd_rad),
            ("start_scatter_m", self.start_scatter_m),
        ];
        let bad = positive
            .iter()
            .find(|(_, value)| !(*value > 0.0 && value.is_finite()));
        if let Some((key, value)) = bad {
            return Err(Error::usage(format!(
                "robot: `{key}` is {value}; expected more than 0"
            )));
        }
        let bad = not_negative
            .iter()
            .find(|(_, value)| !(*value >= 0.0 && value.is_finite()));
        if let Some((key, value)) = bad {
            return Err(Error::usage(format!(
                "robot: `{key}` is {value}; expected 0 or more"
            )));
        }
        // Slower, a second's time is no step at all; a start farther off is none on any way.
        if self.speed_m_per_s < 1e-3 {
            return Err(Error::usage(format!(
                "robot: `speed_m_per_s` is {:e}; expected 0.001 or more",
                self.speed_m_per_s
            )));
        }
        if self.start_scatter_m > 1e3 {
            return Err(Error::usage(format!(
                "robot: `start_scatter_m` is {:e}; expected up to 1000",
                self.start_scatter_m
            )));
        }
        self.odometry.check()
    }
}
