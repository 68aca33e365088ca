//! One sonar ring or laser, and the walls in its way.

use crate::{
    error::{Error, Result},
    geometry::{Pose, wrapped},
    recording::Channel,
    world::{FloorPlan, Laser, LaserConfig, Material, Raycaster, Sonar, SonarConfig, Wall},
};
use nalgebra::Point2;
use std::ops::Range;

#[derive(Debug, Clone)]
pub(super) struct RangeSensor {
    pub(super) channel: Channel,
    pub(super) model: Model,
    /// The walls in its way, at its height.
    pub(super) walls: Raycaster,
}

#[derive(Debug, Clone)]
pub(super) enum Model {
    Sonar(Sonar),
    Laser(Laser),
}

/// Bearings of a channel and of the sensor that is to be it may differ by this much, radians.
const BEARING_SLACK_RAD: f64 = 1e-6;

pub(super) fn in_the_way(plan: &FloorPlan, standing: impl Fn(&&Wall) -> bool) -> Vec<[f64; 4]> {
    let walls = plan.walls().iter().filter(standing);
    let ends = walls.map(|wall| [wall.from.x, wall.from.y, wall.to.x, wall.to.y]);
    ends.collect()
}

impl Model {
    /// A ring without rebounds, cross-talk, noise and outliers, where all walls stand at its height.
    pub(super) fn plain_sonar(config: &SonarConfig) -> Result<Self> {
        let plain = SonarConfig {
            plain: true,
            firing: Vec::new(),
            ..config.clone()
        };
        Sonar::new(plain).map(Model::Sonar)
    }

    pub(super) fn exact_laser(config: &LaserConfig) -> Result<Self> {
        Laser::new(config.clone()).map(Model::Laser)
    }

    fn channel(&self) -> Channel {
        match self {
            Model::Sonar(sonar) => sonar.channel(),
            Model::Laser(laser) => laser.channel(),
        }
    }

    /// Is this the channel of the sensor: its name, its unit, and readings in its directions?
    pub(super) fn makes(&self, channel: &Channel) -> bool {
        let own = self.channel();
        let bearings = |c: &Channel| c.bearing_rad.clone().unwrap_or_default();
        let (one, other) = (bearings(&own), bearings(channel));
        let alike = |(a, b): (&f64, &f64)| wrapped(a - b).abs() < BEARING_SLACK_RAD;
        own.name == channel.name
            && own.unit == channel.unit
            && one.len() == other.len()
            && one.iter().zip(&other).all(alike)
    }

    /// How far from the robot's centre a wall may be and still be measured, metres.
    fn reach_m(&self) -> f64 {
        match self {
            Model::Sonar(sonar) => sonar.config().ring_radius_m + sonar.config().maximum_m,
            Model::Laser(laser) => laser.config().ahead_m.abs() + laser.config().maximum_m,
        }
    }
}

impl RangeSensor {
    pub(super) fn new(channel: Channel, model: Model, walls: Vec<[f64; 4]>) -> Result<Self> {
        let height_m = match &model {
            Model::Sonar(sonar) => sonar.config().height_m,
            Model::Laser(laser) => laser.config().height_m,
        };
        let upright = |[x1, y1, x2, y2]: [f64; 4]| {
            Wall::new(Point2::new(x1, y1), Point2::new(x2, y2), OPAQUE).between(0.0, 1.0 + height_m)
        };
        let plan = FloorPlan::new(walls.into_iter().map(upright).collect())?;
        Ok(Self {
            channel,
            model,
            walls: Raycaster::new(plan),
        })
    }

    /// A reading that says no more than that nothing is nearer, metres.
    pub(super) fn longest_m(&self) -> f64 {
        let own_m = match &self.model {
            Model::Sonar(sonar) => sonar.config().maximum_m,
            Model::Laser(laser) => laser.config().maximum_m,
        };
        self.channel
            .maximum
            .map_or(own_m, |told_m| told_m.min(own_m))
    }

    pub(super) fn expected_at(&self, pose: &Pose) -> impl Iterator<Item = f64> {
        let (pose, longest_m) = (*pose, self.longest_m());
        (0..self.channel.width).map(move |value| {
            let around = (&self.walls).into();
            let range_m = match &self.model {
                Model::Sonar(sonar) => sonar.echo_m(&around, &pose, value),
                Model::Laser(laser) => laser.range_m(&around, &pose, value),
            };
            range_m.map_or(longest_m, |metres| metres.min(longest_m))
        })
    }

    pub(super) fn near(&self, centre: &Pose, radius_m: f64) -> Self {
        let within_m = self.model.reach_m() + radius_m;
        let centre = Point2::new(centre.x_m, centre.y_m);
        let walls = self.walls.plan().walls().iter();
        let near: Vec<Wall> = walls
            .copied()
            .filter(|wall| wall.distance_m(&centre) <= within_m)
            .collect();
        Self {
            // Where no wall is near any will do: all of them are out of reach.
            walls: FloorPlan::new(near).map_or_else(|_| self.walls.clone(), Raycaster::new),
            channel: self.channel.clone(),
            model: self.model.clone(),
        }
    }

    /// Columns of this channel among a recording's values.
    pub(super) fn columns(&self, channels: &[Channel]) -> Result<Range<usize>> {
        let mut from = 0;
        for channel in channels {
            if channel.name == self.channel.name {
                if self.model.makes(channel) {
                    return Ok(from..from + channel.width);
                }
                return Err(Error::work(format!(
                    "channel `{}`: {} values in `{}`; expected {} in `m`, in the directions of the plan's {}",
                    channel.name, channel.width, channel.unit, self.channel.width, channel.name
                )));
            }
            from += channel.width;
        }
        let names: Vec<&str> = channels.iter().map(|c| c.name.as_str()).collect();
        Err(Error::work(format!(
            "no channel `{}`; the recording has {}",
            self.channel.name,
            names.join(", ")
        )))
    }
}

/// What all walls of a sensor are made of: those that it sees through have been left out.
const OPAQUE: Material = Material {
    infrared: 1.0,
    ..Material::PLAIN
};
