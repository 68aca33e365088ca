//! Which poses the relative error is measured between.

use super::{Pose3, rotation};
use crate::error::{Error, Result};
use rayon::prelude::*;
use serde::Serialize;
use std::{fmt, str::FromStr};

/// Pairs beyond which the relative error of all pairs is refused: a gigabyte of errors.
const MOST_PAIRS: usize = 40_000_000;

/// What the distance between the two poses of a pair is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub enum DeltaUnit {
    /// Poses.
    #[default]
    #[serde(rename = "frames")]
    Frames,
    /// Metres of path.
    #[serde(rename = "m")]
    Metres,
    /// Radians: turned along the way or, for all pairs, between the two poses.
    #[serde(rename = "rad")]
    Radians,
    /// Degrees, likewise.
    #[serde(rename = "deg")]
    Degrees,
}

/// How far apart the poses of a pair are; the rules are those of `evo` 1.38 (`evo.core.filters`).
///
/// ```
/// use ballmark::{Pose, score::trajectory::{Delta, DeltaUnit, Pose3}};
/// let walk: Vec<Pose3> = (0..6).map(|k| Pose3::from_plane(&Pose::new(0.4 * k as f64, 0.0, 0.0))).collect();
/// let frames = Delta { value: 2.0, ..Delta::default() };
/// assert_eq!(frames.pairs(&walk)?, [(0, 2), (2, 4)]);
/// let metre = Delta { value: 1.0, unit: DeltaUnit::Metres, ..Delta::default() };
/// assert_eq!(metre.pairs(&walk)?, [(0, 3)]);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Delta {
    /// The distance, in `unit`; above 0.
    pub value: f64,
    /// What it is measured in.
    pub unit: DeltaUnit,
    /// A pair from every pose on instead of one after the other.
    pub all_pairs: bool,
    /// Share of the distance that it may be missed by, for all pairs in metres or angles.
    pub tolerance: f64,
    /// Pairs are sought along the reference instead of the estimate.
    pub from_reference: bool,
}

impl Default for Delta {
    fn default() -> Self {
        Self {
            value: 1.0,
            unit: DeltaUnit::Frames,
            all_pairs: false,
            tolerance: 0.1,
            from_reference: false,
        }
    }
}

impl Delta {
    /// Checks the numbers.
    ///
    /// # Errors
    /// A usage error where the distance is not above 0, not a whole number of frames, or an angle above half a turn, or the tolerance
    /// is negative.
    pub fn check(&self) -> Result<()> {
        let Self {
            value, tolerance, ..
        } = *self;
        let expected = match self.unit {
            _ if !(value.is_finite() && value > 0.0) => "a number above 0",
            DeltaUnit::Frames if value.fract() != 0.0 => "a whole number of frames",
            DeltaUnit::Radians if value > std::f64::consts::PI => "an angle of at most 3.14159 rad",
            DeltaUnit::Degrees if value > 180.0 => "an angle of at most 180 deg",
            _ if !(tolerance.is_finite() && tolerance >= 0.0) => {
                return Err(Error::usage(format!(
                    "delta tolerance {tolerance}: expected a number from 0 on"
                )));
            }
            _ => return Ok(()),
        };
        Err(Error::usage(format!("delta {value}: expected {expected}")))
    }

    /// Pairs of poses that are this far apart, by their numbers.
    ///
    /// One after the other, each pair begins where the last one ended, at the first pose that is as far along the path, or has
    /// turned as far along it. For all pairs, each pose is paired with the one whose path from there comes nearest to the distance, or with
    /// every later one turned as far, within the tolerance.
    ///
    /// # Errors
    /// As [`Delta::check`], where no two poses are as far apart, or pairs are too many.
    pub fn pairs(&self, poses: &[Pose3]) -> Result<Vec<(usize, usize)>> {
        self.check()?;
        let n = poses.len();
        let angle_rad = match self.unit {
            DeltaUnit::Degrees => self.value.to_radians(),
            _ => self.value,
        };
        let pairs: Vec<(usize, usize)> = match (self.unit, self.all_pairs) {
            (DeltaUnit::Frames, _) if self.value >= n as f64 => Vec::new(),
            (DeltaUnit::Frames, all) => {
                let frames = self.value as usize;
                let step = if all { 1 } else { frames };
                (0..n - frames)
                    .step_by(step)
                    .map(|i| (i, i + frames))
                    .collect()
            }
            (DeltaUnit::Metres, false) => {
                let step = |i: usize| (poses[i].position_m - poses[i - 1].position_m).norm();
                let begun = one_after_the_other(n, self.value, step);
                begun.windows(2).map(|ends| (ends[0], ends[1])).collect()
            }
            (DeltaUnit::Metres, true) => nearest_along_path(poses, self.value, self.tolerance),
            (_, false) => {
                let step = |i: usize| poses[i].relative_to(&poses[i - 1]).angle_rad();
                let begun = one_after_the_other(n, angle_rad, step);
                begun.windows(2).map(|ends| (ends[0], ends[1])).collect()
            }
            (_, true) => all_turned(poses, angle_rad, self.tolerance)?,
        };
        if pairs.is_empty() {
            let path: f64 = poses
                .windows(2)
                .map(|pair| (pair[1].position_m - pair[0].position_m).norm())
                .sum();
            return Err(Error::work(format!(
                "no two poses are {} {} apart, of {n} poses along {path:.3} m; expected a smaller --delta",
                self.value, self.unit
            )));
        }
        Ok(pairs)
    }
}

/// The first pose and every one at which the steps since the last one taken add up to `delta`.
fn one_after_the_other(n: usize, delta: f64, step: impl Fn(usize) -> f64) -> Vec<usize> {
    let (mut taken, mut since) = (vec![0], 0.0);
    for i in 1..n {
        since += step(i);
        if since >= delta {
            taken.push(i);
            since = 0.0;
        }
    }
    taken
}

/// Every pose with the later one whose path from there is nearest to `delta`, the first of several as near.
fn nearest_along_path(poses: &[Pose3], delta: f64, tolerance: f64) -> Vec<(usize, usize)> {
    let mut path = vec![0.0];
    for (k, pair) in poses.windows(2).enumerate() {
        path.push(path[k] + (pair[1].position_m - pair[0].position_m).norm());
    }
    let mut pairs = Vec::new();
    for i in 0..path.len().saturating_sub(1) {
        let later = &path[i + 1..];
        let from_here = |end: &f64| end - path[i];
        let beyond = later.partition_point(|end| from_here(end) < delta);
        // The first of those that end where the last one short of it does: the robot may have stood there.
        let short = beyond.checked_sub(1).map(|last| {
            let there = from_here(&later[last]);
            later.partition_point(|end| from_here(end) < there)
        });
        let miss = |k: usize| (from_here(&later[k]) - delta).abs();
        let best = match (short, beyond < later.len()) {
            (Some(short), true) if miss(short) <= miss(beyond) => short,
            (Some(short), false) => short,
            _ => beyond,
        };
        if miss(best) <= delta * tolerance {
            pairs.push((i, i + 1 + best));
        }
    }
    pairs
}

/// Every two poses between which the turn is `angle_rad`, within the tolerance.
fn all_turned(poses: &[Pose3], angle_rad: f64, tolerance: f64) -> Result<Vec<(usize, usize)>> {
    let (low, high) = (
        angle_rad - angle_rad * tolerance,
        angle_rad + angle_rad * tolerance,
    );
    let quaternion: Vec<_> = poses
        .iter()
        .map(|pose| rotation::quaternion(&pose.rotation))
        .collect();
    // |qᵢ·qⱼ| is the cosine of half the angle between them: enough to pass over most pairs. Wider than its rounding.
    let (least, most) = (
        (high.min(std::f64::consts::PI) / 2.0).cos() - 1e-4,
        (low.max(0.0) / 2.0).cos() + 1e-4,
    );
    let from = |i: usize| -> Vec<(usize, usize)> {
        let turned = |j: &usize| {
            let cosine = quaternion[i].dot(&quaternion[*j]).abs();
            (least..=most).contains(&cosine) && {
                let angle = poses[*j].relative_to(&poses[i]).angle_rad();
                low <= angle && angle <= high
            }
        };
        let later = (i + 1)..poses.len();
        later.filter(turned).map(|j| (i, j)).collect()
    };
    let mut pairs = Vec::new();
    let all: Vec<usize> = (0..poses.len()).collect();
    for share in all.chunks(256) {
        let found: Vec<Vec<(usize, usize)>> = share.par_iter().map(|&i| from(i)).collect();
        found.into_iter().for_each(|found| pairs.extend(found));
        if pairs.len() > MOST_PAIRS {
            return Err(Error::work(format!(
                "more than {MOST_PAIRS} pairs of poses are turned by that angle; expected a smaller tolerance, or no --all-pairs"
            )));
        }
    }
    Ok(pairs)
}

impl DeltaUnit {
    /// What `--delta-unit` calls them.
    pub const NAMES: [&'static str; 4] = ["frames", "m", "rad", "deg"];
}

impl FromStr for DeltaUnit {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "frames" => Ok(Self::Frames),
            "m" => Ok(Self::Metres),
            "rad" => Ok(Self::Radians),
            "deg" => Ok(Self::Degrees),
            _ => Err(Error::usage(format!(
                "unit `{}`: expected one of {}",
                name.escape_debug(),
                Self::NAMES.join(", ")
            ))),
        }
    }
}

impl fmt::Display for DeltaUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Frames => "frames",
            Self::Metres => "m",
            Self::Radians => "rad",
            Self::Degrees => "deg",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn walk() -> Vec<Pose3> {
        let pose = |k: u32| {
            let t = f64::from(k);
            Pose3::from_plane(&Pose::new(0.1 * t * (1.0 + 0.1 * t.sin()), 0.0, 0.3 * t))
        };
        (0..60).map(pose).collect()
    }

    #[test]
    fn all_pairs_along_the_path_are_those_of_a_search() {
        let mut poses = walk();
        poses.splice(20..20, vec![poses[20]; 5]); // stands for a while
        let mut path = vec![0.0];
        for pair in poses.windows(2) {
            path.push(path[path.len() - 1] + (pair[1].position_m - pair[0].position_m).norm());
        }
        for (delta, tolerance) in [(0.35, 0.1), (1.0, 0.02), (2.0, 0.5), (0.05, 3.0)] {
            let mut expected = Vec::new();
            for i in 0..poses.len() - 1 {
                let miss = |j: &usize| (path[*j] - path[i] - delta).abs();
                let later: Vec<usize> = (i + 1..poses.len()).collect();
                let best = later.iter().copied().fold(i + 1, |best, j| {
                    if miss(&j) < miss(&best) { j } else { best }
                });
                if miss(&best) <= delta * tolerance {
                    expected.push((i, best));
                }
            }
            assert_eq!(nearest_along_path(&poses, delta, tolerance), expected);
        }
    }

    #[test]
    fn all_pairs_by_angle_are_those_of_a_search() {
        let poses = walk();
        for (angle, tolerance) in [(0.3, 0.1), (1.0, 0.4), (3.0, 0.01), (3.1, 0.1)] {
            let mut expected = Vec::new();
            for i in 0..poses.len() {
                for j in i + 1..poses.len() {
                    let turned = poses[j].relative_to(&poses[i]).angle_rad();
                    if (turned - angle).abs() <= angle * tolerance {
                        expected.push((i, j));
                    }
                }
            }
            assert!(!expected.is_empty());
            assert_eq!(all_turned(&poses, angle, tolerance).unwrap(), expected);
        }
    }

    #[test]
    fn what_no_two_poses_are_apart_is_said() {
        let far = Delta {
            value: 99.0,
            unit: DeltaUnit::Metres,
            ..Delta::default()
        };
        let error = far.pairs(&walk()).unwrap_err();
        assert!(error.to_string().contains("99 m apart"), "{error}");
        for (value, unit) in [
            (0.0, DeltaUnit::Metres),
            (1.5, DeltaUnit::Frames),
            (f64::NAN, DeltaUnit::Frames),
            (190.0, DeltaUnit::Degrees),
            (4.0, DeltaUnit::Radians),
        ] {
            let delta = Delta {
                value,
                unit,
                ..Delta::default()
            };
            assert!(delta.pairs(&walk()).unwrap_err().is_usage(), "{value}");
        }
        let frames = Delta {
            value: 59.0,
            ..Delta::default()
        };
        assert_eq!(frames.pairs(&walk()).unwrap(), [(0, 59)]);
    }
}
