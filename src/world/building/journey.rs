//! `[path]`, `[record]` and `[[set]]`: which way the robot goes, how often, and where it takes snapshots.

use super::{sensors::SensorTables, wall::Side, within};
use crate::{
    error::{Error, Result},
    geometry::Pose,
    world::{Route, wall_following::Following},
};
use nalgebra::Point2;
use serde::Deserialize;
use toml::Value;

/// What the robot follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Follow {
    /// A prescribed way through corners.
    #[default]
    Route,
    /// A wall at its side, at a distance.
    Wall,
    /// Pose after pose.
    Poses,
}

/// `[path]`: which way the robot goes.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PathConfig {
    /// What it follows.
    pub follow: Follow,
    /// Corners of a route; for wall following the start, and a place that it faces from there. Metres.
    pub corners: Vec<[f64; 2]>,
    /// Radius of the arcs that a route takes round its corners, metres.
    pub bend_radius_m: f64,
    /// Does the route lead back to its first corner?
    pub closed: bool,
    /// Side of the robot that the wall is on; for wall following left where it isn't said. On a route only people who
    /// pass between robot and wall need it.
    pub side: Option<Side>,
    /// Way from the robot's rim to the wall that it follows, metres.
    pub distance_m: f64,
    /// Times around, for closed routes, wall following and poses.
    pub laps: f64,
    /// Do odd runs go the other way?
    pub both_ways: bool,
    /// The poses to stand at: x and y in metres, heading in degrees.
    pub poses: Vec<[f64; 3]>,
}

impl Default for PathConfig {
    fn default() -> Self {
        Self {
            follow: Follow::Route,
            corners: Vec::new(),
            bend_radius_m: 1.0,
            closed: false,
            side: None,
            distance_m: 0.5,
            laps: 1.0,
            both_ways: false,
            poses: Vec::new(),
        }
    }
}

/// A way, checked.
#[derive(Debug, Clone)]
pub(crate) enum Journey {
    /// Along a route and along its reverse.
    Route {
        /// There.
        outward: Route,
        /// And back.
        back: Route,
    },
    /// Along a wall from a start.
    Wall(Following),
    /// From pose to pose.
    Poses(Vec<Pose>),
}

/// `[record]`: where snapshots are taken.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecordConfig {
    /// One every so many metres of travel.
    pub every_m: Option<f64>,
    /// One every so many seconds.
    pub every_s: Option<f64>,
    /// One at each of the path's poses; need not be said where the robot follows poses.
    pub poses: Option<bool>,
    /// Number of runs.
    pub runs: Option<usize>,
    /// Exactly so many over all runs; the spacing is chosen to fit.
    pub snapshots: Option<usize>,
}

/// `[[set]]`: runs that differ from those of other sets; what it is silent about is as in the rest of the file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetConfig {
    /// Its name, for `--set`.
    pub name: String,
    /// See [`RecordConfig`].
    pub runs: Option<usize>,
    /// See [`RecordConfig`].
    pub snapshots: Option<usize>,
    /// See [`RecordConfig`].
    pub every_m: Option<f64>,
    /// See [`RecordConfig`].
    pub every_s: Option<f64>,
    /// See [`PathConfig`].
    pub laps: Option<f64>,
    /// See [`PathConfig`].
    pub both_ways: Option<bool>,
    /// Keys put over those of the sonar's table; likewise the other sensors.
    pub sonar: Option<Value>,
    /// See [`SensorTables`].
    pub infrared: Option<Value>,
    /// See [`SensorTables`].
    pub laser: Option<Value>,
    /// See [`SensorTables`].
    pub camera: Option<Value>,
    /// See [`SensorTables`].
    pub compass: Option<Value>,
}

impl SetConfig {
    pub(super) fn sensors(&self) -> SensorTables {
        SensorTables {
            sonar: self.sonar.clone(),
            infrared: self.infrared.clone(),
            laser: self.laser.clone(),
            camera: self.camera.clone(),
            compass: self.compass.clone(),
        }
    }
}

/// How often a snapshot is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Spacing {
    /// Every so many metres of travel.
    Metres(f64),
    /// So many over all runs.
    Exactly(usize),
    /// At each pose of the path.
    AtPoses,
}

/// Most runs, since each one's plan is held while it is driven, and most snapshots, a day's drive at 100 Hz: a mistyped number should end in a
/// message.
const MAX_RUNS: usize = 10_000;
pub(crate) const MAX_SNAPSHOTS: usize = 10_000_000;
const MAX_LAPS: f64 = 1000.0;

impl PathConfig {
    pub(super) fn journey(&self) -> Result<Journey> {
        let place = "[path]";
        let wrong = |fault: String| Err(Error::usage(format!("{place}: {fault}")));
        within(self.distance_m, "distance_m", 0.0..=100.0, place)?;
        check_laps(self.laps, place)?;
        let corners: Vec<Point2<f64>> = self.corners.iter().map(|&corner| corner.into()).collect();
        if !self.poses.is_empty() && self.follow != Follow::Poses {
            return wrong("`poses` are given; expected `follow = \"poses\"` with them".into());
        }
        let around = self.closed || self.follow != Follow::Route;
        if self.laps != 1.0 && !around {
            return wrong(format!(
                "`laps` is {}; expected a closed route (`closed = true`), a wall or poses for more or less than 1",
                self.laps
            ));
        }
        match self.follow {
            Follow::Route => {
                let in_place = |fault: Error| Error::usage(format!("{place}: {fault}"));
                let route = |corners: &[Point2<f64>]| match self.closed {
                    true => Route::around(corners, self.bend_radius_m),
                    false => Route::new(corners, self.bend_radius_m),
                };
                let mut reversed = corners.clone();
                reversed.reverse();
                if self.closed {
                    // Both begin on the same leg.
                    reversed.rotate_left(corners.len().saturating_sub(2));
                }
                Ok(Journey::Route {
                    outward: route(&corners).map_err(in_place)?,
                    back: route(&reversed).map_err(in_place)?,
                })
            }
            Follow::Wall => {
                let [start, ahead] = corners[..] else {
                    return wrong(format!(
                        "`corners` has {}; expected 2 to follow a wall: the start, and a place that the robot faces from there",
                        corners.len()
                    ));
                };
                let facing = ahead - start;
                let finite = facing.norm() > 0.0 && facing.norm() < 1e6;
                if !finite {
                    return wrong("`corners` are the same place or not finite; expected a direction to start in".into());
                }
                Ok(Journey::Wall(Following {
                    start: Pose::new(start.x, start.y, facing.y.atan2(facing.x)),
                    left: self.side != Some(Side::Right),
                    distance_m: self.distance_m,
                }))
            }
            Follow::Poses => {
                if self.poses.is_empty() {
                    return wrong(
                        "`poses` is empty; expected [x, y, heading in degrees] of each".into(),
                    );
                }
                let mut poses = Vec::new();
                for &[x_m, y_m, heading_deg] in &self.poses {
                    let pose = Pose::new(x_m, y_m, heading_deg.to_radians());
                    if !(pose.is_finite() && x_m.abs() < 1e6 && y_m.abs() < 1e6) {
                        return wrong(format!(
                            "pose [{x_m}, {y_m}, {heading_deg}] is not finite or beyond 1e6; expected metres and degrees"
                        ));
                    }
                    poses.push(pose);
                }
                Ok(Journey::Poses(poses))
            }
        }
    }
}

pub(super) fn check_laps(laps: f64, place: &str) -> Result<()> {
    if laps > 0.0 && laps <= MAX_LAPS {
        return Ok(());
    }
    Err(Error::usage(format!(
        "{place}: `laps` is {laps}; expected more than 0, up to {MAX_LAPS}"
    )))
}

/// Number of runs and spacing of one set; a key of `set` overrides that of `record`.
pub(super) fn runs_and_spacing(
    record: &RecordConfig,
    set: Option<&SetConfig>,
    follow: Follow,
    speed_m_per_s: f64,
) -> Result<(usize, Spacing)> {
    let place = match set {
        Some(set) => format!("[[set]] `{}`", set.name),
        None => "[record]".to_string(),
    };
    let wrong = |fault: String| Err(Error::usage(format!("{place}: {fault}")));
    let runs = set.and_then(|s| s.runs).or(record.runs).unwrap_or(1);
    if !(1..=MAX_RUNS).contains(&runs) {
        return wrong(format!("`runs` is {runs}; expected 1 to {MAX_RUNS}"));
    }
    // A set that says how often a snapshot is taken overrides all keys of `record` about it.
    let says = |e_m: Option<f64>, e_s: Option<f64>, n: Option<usize>| {
        e_m.is_some() || e_s.is_some() || n.is_some()
    };
    let (every_m, every_s, snapshots) = match set {
        Some(s) if says(s.every_m, s.every_s, s.snapshots) => (s.every_m, s.every_s, s.snapshots),
        _ => (record.every_m, record.every_s, record.snapshots),
    };
    for (key, value) in [("every_m", every_m), ("every_s", every_s)] {
        if let Some(value) = value.filter(|value| !(*value > 0.0 && value.is_finite())) {
            return wrong(format!("`{key}` is {value}; expected more than 0"));
        }
    }
    if follow == Follow::Poses {
        return match says(every_m, every_s, snapshots) || record.poses == Some(false) {
            true => wrong(
                "the robot follows poses and records at each; expected no other spacing".into(),
            ),
            false => Ok((runs, Spacing::AtPoses)),
        };
    }
    if record.poses == Some(true) {
        return wrong("`poses` is true; expected that only with `follow = \"poses\"`".into());
    }
    let spacing = match (every_m, every_s, snapshots) {
        // Where a number of snapshots is asked for, the spacing follows from it.
        (_, _, Some(count)) => {
            if !(runs..=MAX_SNAPSHOTS).contains(&count) {
                return wrong(format!(
                    "`snapshots` is {count}; expected {runs} (one a run) to {MAX_SNAPSHOTS}"
                ));
            }
            Spacing::Exactly(count)
        }
        (Some(metres), None, None) => Spacing::Metres(metres),
        (None, Some(seconds), None) => Spacing::Metres(seconds * speed_m_per_s),
        (None, None, None) => {
            return wrong("no spacing; expected one of `every_m`, `every_s`, `snapshots`".into());
        }
        (Some(_), Some(_), None) => {
            return wrong("both `every_m` and `every_s`; expected one of them".into());
        }
    };
    Ok((runs, spacing))
}
