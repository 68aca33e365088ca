//! `[robot]` and the tables of its sensors: a preset, with the file's keys put over it.

use crate::{
    error::{Error, Result},
    toml_file::put_over,
    world::{
        Camera, CameraConfig, CompassConfig, Infrared, InfraredConfig, Laser, LaserConfig,
        OdometryConfig, RobotConfig, Sonar, SonarConfig,
    },
};
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use toml::{Table, Value};

/// The sensors' tables as the file has them; `false` takes away one that the preset brings.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorTables {
    /// A ring of sonars.
    pub sonar: Option<Value>,
    /// A ring of infrared sensors.
    pub infrared: Option<Value>,
    /// A laser scanner.
    pub laser: Option<Value>,
    /// A colour camera.
    pub camera: Option<Value>,
    /// A compass.
    pub compass: Option<Value>,
}

/// The robots of the four papers.
const KINDS: &str = "\"nomad200\", \"b21\" or \"sancho2\"";

/// `[robot]` as resolved: how it drives, and whether its sensors keep their direction to north.
#[derive(Debug, Clone)]
pub(super) struct Robot {
    pub(super) config: RobotConfig,
    pub(super) turret_north: bool,
    /// Sensors that the preset brings.
    preset: SensorTables,
}

/// The sensors of a robot, checked.
#[derive(Debug, Clone)]
pub(crate) struct Sensors {
    pub(crate) sonar: Option<Sonar>,
    pub(crate) infrared: Option<Infrared>,
    pub(crate) laser: Option<Laser>,
    pub(crate) camera: Option<Camera>,
    pub(crate) compass: Option<CompassConfig>,
}

/// What the papers state of their robots; all else is as in the defaults.
fn preset(kind: &str, turret: Option<bool>) -> Result<Option<Robot>> {
    let robot = |config, turret_north, preset| Robot {
        config,
        turret_north,
        preset,
    };
    let default = RobotConfig::default();
    Ok(match kind {
        // Duckett & Nehmzow 1998, 5: 16 sonars, 16 infrared sensors, a turret held north by the compass, 0.122 m/s.
        "nomad200" => {
            let turret_north = turret.unwrap_or(true);
            let config = RobotConfig {
                radius_m: 0.23,
                speed_m_per_s: 0.122,
                // It follows walls by its sonars: eight pairs, one every 25 ms; readings in whole inches with the ring's noise; and
                // which of 16 reads least tells the direction to an even 22.5°, of standard deviation 22.5° / √12.
                look_s: 0.2,
                look_range_sd_m: 0.016,
                look_bearing_sd_rad: 0.113,
                odometry: match turret_north {
                    true => OdometryConfig::by_compass(),
                    false => OdometryConfig::default(),
                },
                ..default
            };
            let sensors = SensorTables {
                sonar: as_value(&SonarConfig::nomad200())?,
                infrared: as_value(&InfraredConfig::default())?,
                compass: as_value(&CompassConfig::default())?,
                ..SensorTables::default()
            };
            Some(robot(config, turret_north, sensors))
        }
        // Thrun 1998, 5.1.2 and 5.1.3: 24 sonars and a camera, 15 cm/s.
        "b21" => {
            let sensors = SensorTables {
                sonar: as_value(&SonarConfig::default())?,
                camera: as_value(&CameraConfig::default())?,
                ..SensorTables::default()
            };
            Some(robot(default, turret.unwrap_or(false), sensors))
        }
        // Ruiz-Mayor et al. 2006, 4.1: 12 sonars with cones of 30°. Assumed: size and speed.
        "sancho2" => {
            let config = RobotConfig {
                radius_m: 0.25,
                speed_m_per_s: 0.2,
                ..default
            };
            let sensors = SensorTables {
                sonar: as_value(&SonarConfig::sancho2())?,
                ..SensorTables::default()
            };
            Some(robot(config, turret.unwrap_or(false), sensors))
        }
        _ => None,
    })
}

impl Robot {
    pub(super) fn new(table: &Table) -> Result<Self> {
        let mut table = table.clone();
        let wrong = |fault: String| Error::usage(format!("[robot]: {fault}"));
        let kind = table.remove("kind");
        let turret = match table.remove("turret_north") {
            None => None,
            Some(Value::Boolean(yes)) => Some(yes),
            Some(other) => {
                return Err(wrong(format!(
                    "`turret_north` is {other}; expected true or false"
                )));
            }
        };
        let mut robot = match &kind {
            None => Self {
                config: RobotConfig::default(),
                turret_north: turret.unwrap_or(false),
                preset: SensorTables::default(),
            },
            Some(kind) => preset(kind.as_str().unwrap_or(""), turret)?
                .ok_or_else(|| wrong(format!("`kind` is {kind}; expected {KINDS}")))?,
        };
        let mut keys = as_value(&robot.config)?.unwrap_or(Value::Table(Table::new()));
        put_over(&mut keys, &Value::Table(table));
        robot.config = parsed(keys, "robot")?;
        robot.config.check()?;
        Ok(robot)
    }

    /// The sensors: those of the preset, then of the file, then of a set, each put over the one before.
    pub(super) fn sensors(&self, tables: [Option<SensorTables>; 2]) -> Result<Sensors> {
        let layers: Vec<&SensorTables> =
            [Some(&self.preset), tables[0].as_ref(), tables[1].as_ref()]
                .into_iter()
                .flatten()
                .collect();
        let sensors = Sensors {
            sonar: merged::<SonarConfig>("sonar", layers.iter().map(|t| &t.sonar))?
                .map(Sonar::new)
                .transpose()?,
            infrared: merged::<InfraredConfig>("infrared", layers.iter().map(|t| &t.infrared))?
                .map(Infrared::new)
                .transpose()?,
            laser: merged::<LaserConfig>("laser", layers.iter().map(|t| &t.laser))?
                .map(Laser::new)
                .transpose()?,
            camera: merged::<CameraConfig>("camera", layers.iter().map(|t| &t.camera))?
                .map(Camera::new)
                .transpose()?,
            compass: merged("compass", layers.iter().map(|t| &t.compass))?,
        };
        if let Some(compass) = &sensors.compass {
            compass.check()?;
        }
        if self.turret_north && sensors.compass.is_none() {
            return Err(Error::usage(
                "[robot]: `turret_north` is true without a compass; expected a [compass]",
            ));
        }
        Ok(sensors)
    }
}

/// A sensor's constants, layer over layer; none where no layer has it or the last word is `false`.
fn merged<'a, T: DeserializeOwned>(
    name: &str,
    layers: impl Iterator<Item = &'a Option<Value>>,
) -> Result<Option<T>> {
    let mut keys: Option<Value> = None;
    for layer in layers.flatten() {
        match layer {
            Value::Boolean(false) => keys = None,
            Value::Table(_) => put_over(
                keys.get_or_insert_with(|| Value::Table(Table::new())),
                layer,
            ),
            other => {
                return Err(Error::usage(format!(
                    "[{name}]: is {other}; expected a table, or false for none"
                )));
            }
        }
    }
    keys.map(|keys| parsed(keys, name)).transpose()
}

/// Constants as the value that a file would have.
fn as_value(constants: &impl Serialize) -> Result<Option<Value>> {
    Value::try_from(constants)
        .map(Some)
        .map_err(|e| Error::work(format!("preset: {e}")))
}

/// A table as its checked type; the fault begins with the table's name.
fn parsed<T: DeserializeOwned>(keys: Value, table: &str) -> Result<T> {
    keys.try_into().map_err(|e: toml::de::Error| {
        Error::usage(format!("[{table}]: {}", e.message().replace('\n', " ")))
    })
}
