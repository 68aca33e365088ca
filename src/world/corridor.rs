//! Thrun's corridor, ready to be driven: the world of `configs/worlds/thrun1998.toml`, which is part of the program, with
//! sonars alone and no people. What is known of it and what is assumed: `docs/worlds/thrun1998.md`.

use super::{
    Building,
    building::{RecordConfig, WorldConfig},
    simulation::{Choice, simulate},
};
use crate::{error::Result, recording::Recording, seed::Seed};
use serde::{Deserialize, Serialize};

/// The world's file.
pub const WORLD: &str = include_str!("../../configs/worlds/thrun1998.toml");

/// How many runs and how dense.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorridorConfig {
    /// Runs through the corridor, one way (the paper has 12).
    pub runs: usize,
    /// Metres of travel between two snapshots (the paper's mean is 0.11).
    pub spacing_m: f64,
}

impl Default for CorridorConfig {
    fn default() -> Self {
        Self {
            runs: 12,
            spacing_m: 0.25,
        }
    }
}

/// The corridor with its robot, which has 24 sonars.
///
/// # Errors
/// A usage error where a constant is out of bounds.
pub fn building(config: &CorridorConfig) -> Result<Building> {
    let mut world = WorldConfig::parse(WORLD)?;
    world.camera = Some(toml::Value::Boolean(false));
    world.people = None;
    world.set.clear();
    world.record = RecordConfig {
        runs: Some(config.runs),
        every_m: Some(config.spacing_m),
        ..RecordConfig::default()
    };
    Building::new(&world, None)
}

/// Drives the corridor several times and records the sonars: a Recording with a route, odometry and one channel.
///
/// Ranges are said to count from the robot's middle, as in the dataset and the models of the repository that come of this
/// corridor, though the sonars sit on a ring: whoever works from these knows no better. `ballmark simulate` says where they sit.
///
/// ```
/// use ballmark::{seed::Seed, world::corridor::{CorridorConfig, thrun1998}};
/// let recording = thrun1998(Seed(1), &CorridorConfig { runs: 2, spacing_m: 1.0 })?;
/// assert_eq!(recording.runs().len(), 2);
/// assert_eq!((recording.channels().len(), recording.channels()[0].width), (1, 24));
/// assert!(recording.route_m().unwrap().iter().all(|&at_m| (0.0..=89.0).contains(&at_m)));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// As [`building`].
pub fn thrun1998(seed: Seed, config: &CorridorConfig) -> Result<Recording> {
    let recording = simulate(&building(config)?, seed, &Choice::default())?;
    let mut columns = recording.into_columns();
    for channel in &mut columns.channels {
        channel.offset_m = None;
    }
    Recording::new(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_place_looks_alike_in_two_runs_and_unlike_the_rest() {
        let config = CorridorConfig {
            runs: 4,
            spacing_m: 0.5,
        };
        let recording = thrun1998(Seed(1), &config).unwrap();
        let (route, values) = (recording.route_m().unwrap(), recording.values());
        let seen = |reading: f32| {
            if reading.is_nan() {
                4.0
            } else {
                reading.min(4.0)
            }
        };
        let unlike = |a: usize, b: usize| -> f64 {
            values
                .row(a)
                .iter()
                .zip(values.row(b))
                .map(|(&x, &y)| f64::from((seen(x) - seen(y)).abs()))
                .sum()
        };
        let (mut near, mut far) = (Vec::new(), Vec::new());
        let last = recording.runs()[3].clone();
        for a in last.clone() {
            for b in 0..last.start {
                let apart_m = (route[a] - route[b]).abs();
                if apart_m < 0.25 {
                    near.push(unlike(a, b))
                } else if apart_m > 5.0 {
                    far.push(unlike(a, b))
                }
            }
        }
        let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
        assert!(
            mean(&near) < 0.75 * mean(&far),
            "{} and {}",
            mean(&near),
            mean(&far)
        );
    }

    #[test]
    fn a_run_is_the_same_however_many_runs_there_are() {
        let run = |runs, seed| {
            let config = CorridorConfig {
                runs,
                spacing_m: 2.0,
            };
            let recording = thrun1998(Seed(seed), &config).unwrap();
            let first = recording.runs()[0].clone();
            let values = recording.values().rows().into_iter().take(first.len());
            values
                .flat_map(|row| row.iter().map(|v| v.to_bits()).collect::<Vec<_>>())
                .collect::<Vec<u32>>()
        };
        assert_eq!(run(1, 7), run(3, 7));
        assert_ne!(run(1, 7), run(1, 8));
    }

    #[test]
    fn calls_that_make_no_sense_are_told() {
        for (runs, spacing_m, expected) in [(0, 1.0, "`runs` is 0"), (2, 0.0, "`every_m` is 0")] {
            let error = thrun1998(Seed(1), &CorridorConfig { runs, spacing_m }).unwrap_err();
            assert!(
                error.is_usage() && error.to_string().contains(expected),
                "{error}"
            );
        }
    }
}
