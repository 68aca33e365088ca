//! Thrun's corridor: the 89 m long segment of 1998, section 5.1.1, as far as the paper tells, and the rest assumed.
//!
//! The paper states: 89 m; two windows, at both corners; various doors on the outer side; on the inner side fewer and
//! wider ones; an elevator; three to four trash bins; a hallway; doors that change between runs; one travel direction
//! from a fixed start, mostly near the middle; 15 cm/s. So the segment has two bends, and the doors' sides tell which
//! way: it goes round the inside of the building, here to the left, in three legs.
//!
//! Assumed, since the hand-drawn map gives no measures: everything else in [`plan`].

pub mod plan;

use super::{RobotConfig, SonarConfig, simulate};
use crate::{
    error::{Error, Result},
    recording::{Columns, Recording},
    seed::Seed,
};
use serde::{Deserialize, Serialize};

pub use plan::{LENGTH_M, plan_of_run, route};

/// How many runs, how dense, and with which robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorridorConfig {
    /// Runs through the corridor, one way (the paper has 12).
    pub runs: usize,
    /// Metres of travel between two snapshots (the paper's mean is 0.11).
    pub spacing_m: f64,
    /// How the robot drives and dead-reckons.
    pub robot: RobotConfig,
    /// Its sonars.
    pub sonar: SonarConfig,
}

impl Default for CorridorConfig {
    fn default() -> Self {
        Self {
            runs: 12,
            spacing_m: 0.25,
            robot: RobotConfig::default(),
            sonar: SonarConfig::default(),
        }
    }
}

/// Most runs, since each one's plan is held while it is driven.
const MOST_RUNS: usize = 10_000;

/// Drives the corridor several times and records the sonars: a Recording with a route, odometry and one channel.
///
/// ```
/// use ballmark::{seed::Seed, world::corridor::{CorridorConfig, thrun1998}};
/// let recording = thrun1998(Seed(1), &CorridorConfig { runs: 2, spacing_m: 1.0, ..Default::default() })?;
/// assert_eq!(recording.runs().len(), 2);
/// assert_eq!(recording.channels()[0].width, 24);
/// assert!(recording.route_m().unwrap().iter().all(|&at_m| (0.0..=89.0).contains(&at_m)));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// A usage error where a constant is out of bounds; a work error where the robot is too big for the corridor.
pub fn thrun1998(seed: Seed, config: &CorridorConfig) -> Result<Recording> {
    if !(1..=MOST_RUNS).contains(&config.runs) {
        return Err(Error::usage(format!(
            "corridor: `runs` is {}; expected 1 to {MOST_RUNS}",
            config.runs
        )));
    }
    let plans = (0..config.runs as u64)
        .map(|run| plan_of_run(seed, run))
        .collect::<Result<_>>()?;
    let recording = simulate(
        seed,
        plans,
        &route()?,
        &config.robot,
        &config.sonar,
        config.spacing_m,
    )?;
    let source = Some(format!(
        "simulated corridor after Thrun 1998, seed {}",
        seed.0
    ));
    Recording::new(Columns {
        source,
        ..recording.into_columns()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(runs: usize, spacing_m: f64) -> CorridorConfig {
        CorridorConfig {
            runs,
            spacing_m,
            ..CorridorConfig::default()
        }
    }

    /// All that a recording holds, as bits, so that NaN equals NaN.
    fn bits(recording: &Recording, count: usize) -> Vec<u64> {
        let c = recording.columns();
        let width = c.values.ncols();
        let values = c
            .values
            .iter()
            .take(count * width)
            .map(|value| u64::from(value.to_bits()));
        let poses = c
            .pose
            .iter()
            .take(count)
            .chain(c.odometry.iter().take(count));
        let numbers = poses.flat_map(|pose| [pose.x_m, pose.y_m, pose.heading_rad]);
        let rows = c
            .stamp_s
            .iter()
            .take(count)
            .chain(c.route_m.iter().flatten().take(count))
            .copied();
        values
            .chain(numbers.chain(rows).map(f64::to_bits))
            .collect()
    }

    #[test]
    fn a_run_is_the_same_however_many_runs_and_threads_there_are() {
        let few = thrun1998(Seed(7), &config(2, 1.0)).unwrap();
        let many = thrun1998(Seed(7), &config(5, 1.0)).unwrap();
        assert_eq!(bits(&few, few.len()), bits(&many, few.len()));
        let with_threads = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| thrun1998(Seed(7), &config(5, 1.0)))
                .unwrap()
        };
        for threads in [1, 3] {
            assert_eq!(
                bits(&with_threads(threads), many.len()),
                bits(&many, many.len())
            );
        }
        let other = thrun1998(Seed(8), &config(2, 1.0)).unwrap();
        assert_ne!(bits(&other, 10), bits(&few, 10));
    }

    #[test]
    fn one_place_looks_alike_in_two_runs_and_unlike_the_rest() {
        let recording = thrun1998(Seed(1), &config(4, 0.5)).unwrap();
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
    fn calls_that_make_no_sense_are_told() {
        for (config, expected) in [
            (config(0, 1.0), "`runs` is 0"),
            (config(2, 0.0), "`spacing_m` is 0"),
            (
                CorridorConfig {
                    sonar: SonarConfig {
                        beams: 0,
                        ..Default::default()
                    },
                    ..config(1, 1.0)
                },
                "`beams` is 0",
            ),
        ] {
            let error = thrun1998(Seed(1), &config).unwrap_err();
            assert!(
                error.is_usage() && error.to_string().contains(expected),
                "{error}"
            );
        }
        let giant = RobotConfig {
            radius_m: 1.5,
            ..Default::default()
        };
        let error = thrun1998(
            Seed(1),
            &CorridorConfig {
                robot: giant,
                ..config(1, 1.0)
            },
        )
        .unwrap_err();
        assert!(error.to_string().contains("starts in a wall"), "{error}");
    }
}
