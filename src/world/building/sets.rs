//! Sets of runs: how many, how far apart their snapshots stand, and what the robot senses in them.

use super::{
    config::WorldConfig,
    journey::{SetConfig, Spacing, check_laps, runs_and_spacing},
    sensors::{Robot, SensorTables, Sensors},
};
use crate::error::{Error, Result};

/// Runs that belong together.
#[derive(Debug, Clone)]
pub(crate) struct RunSet {
    /// Empty where the file names no sets.
    pub(crate) name: String,
    pub(crate) runs: usize,
    pub(crate) spacing: Spacing,
    pub(crate) laps: f64,
    pub(crate) both_ways: bool,
    pub(crate) sensors: Sensors,
}

/// The sets of runs: those of the file, or one without a name.
pub(super) fn of_file(config: &WorldConfig, robot: &Robot) -> Result<Vec<RunSet>> {
    let base = SensorTables {
        sonar: config.sonar.clone(),
        infrared: config.infrared.clone(),
        laser: config.laser.clone(),
        camera: config.camera.clone(),
        compass: config.compass.clone(),
    };
    let speed_m_per_s = robot.config.speed_m_per_s;
    let made = |set: Option<&SetConfig>| -> Result<RunSet> {
        let (runs, spacing) =
            runs_and_spacing(&config.record, set, config.path.follow, speed_m_per_s)?;
        let laps = set.and_then(|set| set.laps).unwrap_or(config.path.laps);
        check_laps(laps, "[[set]]")?;
        Ok(RunSet {
            name: set.map_or_else(String::new, |set| set.name.clone()),
            runs,
            spacing,
            laps,
            both_ways: set
                .and_then(|set| set.both_ways)
                .unwrap_or(config.path.both_ways),
            sensors: robot.sensors([Some(base.clone()), set.map(SetConfig::sensors)])?,
        })
    };
    if config.set.is_empty() {
        return Ok(vec![made(None)?]);
    }
    for (index, set) in config.set.iter().enumerate() {
        let taken = config.set[..index]
            .iter()
            .any(|other| other.name == set.name);
        if taken || set.name.is_empty() {
            return Err(Error::usage(format!(
                "[[set]] {}: `name` is `{}`; expected a name of its own",
                index + 1,
                set.name
            )));
        }
    }
    config.set.iter().map(|set| made(Some(set))).collect()
}
