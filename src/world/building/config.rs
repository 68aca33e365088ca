//! The keys of a world's file.

use super::{
    days::DaysConfig,
    furnishing::{FireDoorConfig, LightConfig, ThingConfig},
    journey::{PathConfig, RecordConfig, SetConfig},
    material::MaterialConfig,
    wall::WallConfig,
};
use crate::{error::Result, toml_file::TomlFile, world::PeopleConfig};
use serde::Deserialize;
use std::collections::BTreeMap;

/// The keys of a world's file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldConfig {
    /// Its name.
    pub name: String,
    /// The real building or paper it is modelled on, in words.
    #[serde(default)]
    pub source: String,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, MaterialConfig>,
    /// What holds for the whole building.
    #[serde(default)]
    pub building: BuildingConfig,
    /// Walls with what is in them.
    #[serde(default)]
    pub wall: Vec<WallConfig>,
    /// Round things on the floor.
    #[serde(default)]
    pub thing: Vec<ThingConfig>,
    /// Lamps in the ceiling.
    #[serde(default)]
    pub light: Vec<LightConfig>,
    /// Fire doors, which are shut except for seconds.
    #[serde(default)]
    pub fire_door: Vec<FireDoorConfig>,
    /// Keys of [`crate::world::RobotConfig`], and `kind` and `turret_north`.
    #[serde(default)]
    pub robot: toml::Table,
    /// A ring of sonars.
    pub sonar: Option<toml::Value>,
    /// A ring of infrared sensors.
    pub infrared: Option<toml::Value>,
    /// A laser scanner.
    pub laser: Option<toml::Value>,
    /// A colour camera.
    pub camera: Option<toml::Value>,
    /// A compass.
    pub compass: Option<toml::Value>,
    /// Which way the robot goes.
    #[serde(default)]
    pub path: PathConfig,
    /// Where it takes snapshots.
    #[serde(default)]
    pub record: RecordConfig,
    /// Sets of runs that differ.
    #[serde(default)]
    pub set: Vec<SetConfig>,
    /// People that walk about.
    pub people: Option<PeopleConfig>,
    /// What lasts from run to run, and changes from day to day; without it every run finds doors, things and light drawn anew.
    pub days: Option<DaysConfig>,
}

/// `[building]`: what holds for the whole building.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BuildingConfig {
    /// Height of the ceiling, metres.
    pub ceiling_m: f64,
    /// Material of the floor.
    pub floor: String,
    /// Material of the ceiling.
    pub ceiling: String,
    /// Material of the walls that name none, and of a map's walls.
    pub wall: String,
    /// A ROS map_server map (its YAML), relative to the world's file, whose occupied cells become walls.
    pub map: Option<String>,
    /// How much the brightness of all lamps varies from run to run: relative standard deviation.
    pub illumination_sd: f64,
    /// A run's daylight is drawn evenly from this range.
    pub daylight: [f64; 2],
}

impl Default for BuildingConfig {
    fn default() -> Self {
        Self {
            ceiling_m: 2.6,
            floor: "plain".into(),
            ceiling: "plain".into(),
            wall: "plain".into(),
            map: None,
            illumination_sd: 0.0,
            daylight: [1.0, 1.0],
        }
    }
}

impl WorldConfig {
    /// Parses the text of a world's file.
    ///
    /// # Errors
    /// A usage error that names the line, the key and what was expected.
    pub fn parse(text: &str) -> Result<Self> {
        TomlFile::from_text(text).parse()
    }
}
