//! A robot as it drives and dead-reckons, and where it stops for a snapshot.

use super::{OdometryConfig, bounds::Bounds};
use crate::{error::Result, geometry::Pose};
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
    /// Wall following: time between two looks at the wall, seconds; what is measured holds until the next. 0: it looks every two
    /// centimetres.
    pub look_s: f64,
    /// Standard deviation of the distance to the wall as it is measured at a look, metres.
    pub look_range_sd_m: f64,
    /// Standard deviation of the direction in which the wall is nearest, as it is measured at a look, radians.
    pub look_bearing_sd_rad: f64,
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
            look_s: 0.0,
            look_range_sd_m: 0.0,
            look_bearing_sd_rad: 0.0,
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
        let bounds = Bounds("robot");
        bounds.positive(&[
            ("radius_m", self.radius_m),
            ("speed_m_per_s", self.speed_m_per_s),
            ("lateral_limit_m", self.lateral_limit_m),
        ])?;
        bounds.not_negative(&[
            ("lateral_sd_m", self.lateral_sd_m),
            ("heading_sd_rad", self.heading_sd_rad),
            ("look_s", self.look_s),
            ("look_range_sd_m", self.look_range_sd_m),
            ("look_bearing_sd_rad", self.look_bearing_sd_rad),
            ("start_scatter_m", self.start_scatter_m),
        ])?;
        // Slower, a second's time is no step at all; a start farther off is none on any way.
        if self.speed_m_per_s < 1e-3 {
            let speed = format!("{:e}", self.speed_m_per_s);
            return bounds.wrong("speed_m_per_s", speed, "0.001 or more");
        }
        if self.start_scatter_m > 1e3 {
            let scatter = format!("{:e}", self.start_scatter_m);
            return bounds.wrong("start_scatter_m", scatter, "up to 1000");
        }
        self.odometry.check()
    }
}
