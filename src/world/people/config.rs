//! How many people come, and what they are like.

use crate::{error::Result, world::bounds::Bounds};
use serde::{Deserialize, Serialize};

/// People that pass during a run; by default none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PeopleConfig {
    /// Nobody comes, and fire doors stay shut, while the robot drives the first so many laps.
    pub map_laps: f64,
    /// How many walk past the robot.
    pub passing: usize,
    /// How many of these do so between the robot and the wall that it follows.
    pub between: usize,
    /// How many stand beside its way.
    pub standing: usize,
    /// How often a fire door near the robot is left open.
    pub fire_doors_opened: usize,
    /// How long, seconds: least and greatest.
    pub opened_s: [f64; 2],
    /// How many more walk past, on average, a minute.
    pub per_minute: f64,
    /// Radius of a person, metres.
    pub radius_m: f64,
    /// Least radius of one who squeezes past, metres.
    pub slim_m: f64,
    /// Height of a person, metres.
    pub height_m: f64,
    /// How fast they walk, metres a second: least and greatest.
    pub speed_m_per_s: [f64; 2],
}

impl Default for PeopleConfig {
    fn default() -> Self {
        Self {
            map_laps: 0.0,
            passing: 0,
            between: 0,
            standing: 0,
            fire_doors_opened: 0,
            opened_s: [4.0, 10.0],
            per_minute: 0.0,
            radius_m: 0.2,
            slim_m: 0.1,
            height_m: 1.75,
            speed_m_per_s: [0.8, 1.5],
        }
    }
}

/// Most people or openings in a run: far beyond any crowd, small enough to hold.
const MOST: usize = 100_000;

impl PeopleConfig {
    /// Checks every constant.
    ///
    /// # Errors
    /// A usage error that names the first one out of bounds.
    pub fn check(&self) -> Result<()> {
        let bounds = Bounds("people");
        for (key, count) in [
            ("passing", self.passing),
            ("standing", self.standing),
            ("fire_doors_opened", self.fire_doors_opened),
        ] {
            if count > MOST {
                return bounds.wrong(key, count, &format!("0 to {MOST}"));
            }
        }
        if self.between > self.passing {
            return bounds.wrong("between", self.between, "no more than `passing`");
        }
        if !(self.map_laps >= 0.0 && self.map_laps.is_finite()) {
            return bounds.wrong("map_laps", self.map_laps, "0 or more");
        }
        if !(0.0..=1000.0).contains(&self.per_minute) {
            return bounds.wrong("per_minute", self.per_minute, "0 to 1000");
        }
        bounds.positive(&[
            ("radius_m", self.radius_m),
            ("slim_m", self.slim_m),
            ("height_m", self.height_m),
        ])?;
        if self.slim_m > self.radius_m {
            return bounds.wrong("slim_m", self.slim_m, "no more than `radius_m`");
        }
        for (key, [least, most]) in [
            ("opened_s", self.opened_s),
            ("speed_m_per_s", self.speed_m_per_s),
        ] {
            if !(least > 0.0 && least <= most && most.is_finite()) {
                let value = format!("[{least}, {most}]");
                return bounds.wrong(key, value, "two numbers above 0 in rising order");
            }
        }
        Ok(())
    }
}
