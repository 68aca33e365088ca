//! Expected ranges as a file holds them: walls as plain numbers, checked before they are sorted for rays again.

use super::{
    ExpectedRanges,
    sensor::{Model, RangeSensor, in_the_way},
};
use crate::{
    error::{Error, Result},
    recording::Channel,
    world::{LaserConfig, SonarConfig},
};
use serde::{Deserialize, Serialize};

/// What a file holds of them.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Saved {
    sensors: Vec<SavedSensor>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedSensor {
    channel: Channel,
    model: SavedModel,
    /// x and y of one end, x and y of the other, metres.
    walls: Vec<[f64; 4]>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SavedModel {
    Sonar(SonarConfig),
    Laser(LaserConfig),
}

impl From<ExpectedRanges> for Saved {
    fn from(expected: ExpectedRanges) -> Self {
        let saved = |sensor: RangeSensor| SavedSensor {
            walls: in_the_way(sensor.walls.plan(), |_| true),
            channel: sensor.channel,
            model: match sensor.model {
                Model::Sonar(sonar) => SavedModel::Sonar(sonar.config().clone()),
                Model::Laser(laser) => SavedModel::Laser(laser.config().clone()),
            },
        };
        Self {
            sensors: expected.sensors.into_iter().map(saved).collect(),
        }
    }
}

impl TryFrom<Saved> for ExpectedRanges {
    type Error = Error;

    fn try_from(saved: Saved) -> Result<Self> {
        if saved.sensors.is_empty() {
            return Err(Error::work(
                "expected ranges: no sensor; expected at least one",
            ));
        }
        let sensors = saved.sensors.into_iter().map(|saved| {
            let model = match &saved.model {
                SavedModel::Sonar(config) => Model::plain_sonar(config)?,
                SavedModel::Laser(config) => Model::exact_laser(config)?,
            };
            if !model.makes(&saved.channel) {
                return Err(Error::work(format!(
                    "expected ranges: channel `{}` is not that of its sensor; expected its name, `m`, and its directions",
                    saved.channel.name.escape_debug()
                )));
            }
            RangeSensor::new(saved.channel, model, saved.walls)
        });
        Ok(Self {
            sensors: sensors.collect::<Result<_>>()?,
        })
    }
}
