//! `[robot]` and the tables of its sensors: a preset, with the file's keys put over it.

use crate::{
    error::{Error, Result},
    world::{RobotConfig, Sonar, SonarConfig},
};
use serde::{Deserialize, de::DeserializeOwned};
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

/// The robots of the four papers: what their text states of them; the rest is as in the defaults.
const PRESETS: [(&str, &str); 3] = [
    // Duckett & Nehmzow 1998, section 5, and 2000: 16 sonars, 16 infrared sensors, turret held north by the compass.
    (
        "nomad200",
        "[robot]
        radius_m = 0.23
        speed_m_per_s = 0.122
        [sonar]
        beams = 16
        ring_radius_m = 0.23
        [infrared]
        [compass]",
    ),
    // Thrun 1998, 5.1.2 and 5.1.3: 24 sonars and a camera, 15 cm/s.
    (
        "b21",
        "[robot]
        radius_m = 0.27
        speed_m_per_s = 0.15
        [sonar]
        beams = 24
        [camera]",
    ),
    // Ruiz-Mayor et al. 2006: 12 sonars with cones of 30°, read to 4 cm.
    (
        "sancho2",
        "[robot]
        radius_m = 0.25
        speed_m_per_s = 0.2
        [sonar]
        beams = 12
        ring_radius_m = 0.25
        opening_rad = 0.5235987755982988
        resolution_m = 0.04",
    ),
];

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
}

impl Robot {
    pub(super) fn new(told: &Table) -> Result<Self> {
        let mut told = told.clone();
        let wrong = |fault: String| Error::usage(format!("[robot]: {fault}"));
        let mut preset = Table::new();
        match told.remove("kind") {
            None => (),
            Some(kind) => {
                let known = PRESETS.iter().find(|(name, _)| kind.as_str() == Some(name));
                let (_, text) = known.ok_or_else(|| {
                    wrong(format!(
                        "`kind` is {kind}; expected \"nomad200\", \"b21\" or \"sancho2\""
                    ))
                })?;
                preset = toml::from_str(text).map_err(|e| wrong(e.message().to_string()))?;
            }
        }
        let turret_north = match told.remove("turret_north") {
            None => false,
            Some(Value::Boolean(yes)) => yes,
            Some(other) => {
                return Err(wrong(format!(
                    "`turret_north` is {other}; expected true or false"
                )));
            }
        };
        let mut keys = preset.remove("robot").unwrap_or(Value::Table(Table::new()));
        put_over(&mut keys, &Value::Table(told));
        let config: RobotConfig = parsed(keys, "robot")?;
        config.check()?;
        let preset = parsed(Value::Table(preset), "robot")?;
        Ok(Self {
            config,
            turret_north,
            preset,
        })
    }

    /// The sensors: those of the preset, then of the file, then of a set, each put over the one before.
    pub(super) fn sensors(&self, told: [Option<SensorTables>; 2]) -> Result<Sensors> {
        let merged =
            |name: &str, of: fn(&SensorTables) -> &Option<Value>| -> Result<Option<Value>> {
                let layers = [Some(&self.preset), told[0].as_ref(), told[1].as_ref()];
                let mut keys: Option<Value> = None;
                for layer in layers
                    .into_iter()
                    .flatten()
                    .filter_map(|layer| of(layer).as_ref())
                {
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
                Ok(keys)
            };
        let sonar = merged("sonar", |tables| &tables.sonar)?
            .map(|keys| parsed::<SonarConfig>(keys, "sonar").and_then(Sonar::new))
            .transpose()?;
        Ok(Sensors { sonar })
    }
}

/// A table as its checked type; the fault is told with the table's name.
fn parsed<T: DeserializeOwned>(keys: Value, table: &str) -> Result<T> {
    keys.try_into().map_err(|e: toml::de::Error| {
        Error::usage(format!("[{table}]: {}", e.message().replace('\n', " ")))
    })
}

/// Puts the keys of one table over those of another, table by table.
fn put_over(under: &mut Value, over: &Value) {
    match (under, over) {
        (Value::Table(under), Value::Table(over)) => {
            for (key, value) in over {
                match under.get_mut(key) {
                    Some(place) => put_over(place, value),
                    None => {
                        under.insert(key.clone(), value.clone());
                    }
                }
            }
        }
        (under, over) => *under = over.clone(),
    }
}
