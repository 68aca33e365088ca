//! Which pose of an estimate belongs to which pose of a reference.

use super::Trajectory;
use crate::error::{Error, Result};
use serde::Serialize;
use std::collections::BTreeSet;

/// How poses are paired by their time stamps; the defaults are those of `evo`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Matching {
    /// Seconds that the stamps of a pair may differ by.
    pub max_difference_s: f64,
    /// Seconds that are added to the stamps of the estimate first.
    pub offset_s: f64,
}

impl Default for Matching {
    fn default() -> Self {
        Self {
            max_difference_s: 0.01,
            offset_s: 0.0,
        }
    }
}

/// Pairs of poses by their numbers, in the order of time.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pairing {
    /// Number of the estimate's pose.
    pub estimate: Vec<usize>,
    /// Number of the reference's pose that belongs to it.
    pub reference: Vec<usize>,
}

impl Pairing {
    /// Pairs the poses of two trajectories: by time where both have stamps, in order where neither has and both are of
    /// one length.
    ///
    /// By time, each pose of the trajectory with fewer poses (the estimate, where both have as many) gets the pose of the other that
    /// is nearest in time, the earlier of two as near, unless their stamps differ by more than allowed: the rule of `evo`
    /// 1.38 (`evo.core.sync`).
    ///
    /// # Errors
    /// Where only one of them has stamps, the lengths of two without stamps differ, or no pair is found; the message then says
    /// which times both span.
    ///
    /// ```
    /// use ballmark::{Pose, score::trajectory::{Matching, Pairing, Trajectory}};
    /// let at = |name: &str, stamps: &[f64]| {
    ///     Trajectory::in_plane(name, Some(stamps.to_vec()), &vec![Pose::default(); stamps.len()])
    /// };
    /// let (estimate, reference) = (at("est", &[0.0, 1.004, 2.5])?, at("ref", &[0.0, 1.0, 1.5, 2.0])?);
    /// let pairs = Pairing::of(&estimate, &reference, &Matching::default())?;
    /// assert_eq!((pairs.estimate, pairs.reference), (vec![0, 1], vec![0, 1]));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn of(estimate: &Trajectory, reference: &Trajectory, matching: &Matching) -> Result<Self> {
        let (stamps, theirs) = match (estimate.stamps(), reference.stamps()) {
            (Some(estimate), Some(reference)) => (estimate, reference),
            (None, None) if estimate.len() == reference.len() => {
                let all: Vec<usize> = (0..estimate.len()).collect();
                return Ok(Self {
                    estimate: all.clone(),
                    reference: all,
                });
            }
            (None, None) => {
                return Err(Error::work(format!(
                    "{} has {} poses and {} has {}, both without time stamps; expected as many, or stamps to pair them by",
                    estimate.name(),
                    estimate.len(),
                    reference.name(),
                    reference.len()
                )));
            }
            (stamped, _) => {
                let (with, without) = match stamped {
                    Some(_) => (estimate, reference),
                    None => (reference, estimate),
                };
                return Err(Error::work(format!(
                    "{} has time stamps and {} has none; expected both or neither",
                    with.name(),
                    without.name()
                )));
            }
        };
        // From the shorter to the longer; the offset, which moves the estimate, moves the longer one the other way.
        let by_reference = estimate.len() > reference.len();
        let offset_s = if by_reference {
            matching.offset_s
        } else {
            -matching.offset_s
        };
        let (short, long) = if by_reference {
            (theirs, stamps)
        } else {
            (stamps, theirs)
        };
        let (of_short, of_long) = nearest(short, long, offset_s, matching.max_difference_s);
        let pairing = if by_reference {
            Self {
                estimate: of_long,
                reference: of_short,
            }
        } else {
            Self {
                estimate: of_short,
                reference: of_long,
            }
        };
        if pairing.is_empty() {
            return Err(no_common_time(estimate, reference, matching));
        }
        Ok(pairing)
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.estimate.len()
    }

    /// Is there no pair?
    pub fn is_empty(&self) -> bool {
        self.estimate.is_empty()
    }

    /// Number of poses of the reference that belong to some pair, each counted once.
    pub fn covered(&self) -> usize {
        self.reference.iter().collect::<BTreeSet<_>>().len()
    }
}

/// For each stamp of `short` the nearest of `long` + `offset_s`, where it is near enough; both are rising.
fn nearest(
    short: &[f64],
    long: &[f64],
    offset_s: f64,
    max_difference_s: f64,
) -> (Vec<usize>, Vec<usize>) {
    let (mut of_short, mut of_long) = (Vec::new(), Vec::new());
    let mut after = 0; // the first of `long` that is later
    for (k, &stamp) in short.iter().enumerate() {
        while after < long.len() && long[after] + offset_s <= stamp {
            after += 1;
        }
        let before = after.checked_sub(1);
        let until = before.map_or(f64::INFINITY, |j| stamp - (long[j] + offset_s));
        let from = long
            .get(after)
            .map_or(f64::INFINITY, |later| later + offset_s - stamp);
        let (found, difference) = match before {
            Some(before) if until <= from => (before, until),
            _ => (after, from),
        };
        if difference <= max_difference_s {
            of_short.push(k);
            of_long.push(found);
        }
    }
    (of_short, of_long)
}

/// A stamp above this is none in seconds: the year 5138.
const MOST_SECONDS: f64 = 1e11;

fn no_common_time(estimate: &Trajectory, reference: &Trajectory, matching: &Matching) -> Error {
    let ends = |trajectory: &Trajectory| {
        let stamps = trajectory.stamps().unwrap_or_default();
        (
            stamps.first().copied().unwrap_or(f64::NAN),
            stamps.last().copied().unwrap_or(f64::NAN),
        )
    };
    let ((from, to), (their_from, their_to)) = (ends(estimate), ends(reference));
    let overlap = from + matching.offset_s <= their_to && their_from <= to + matching.offset_s;
    let ratio = (from.max(to) / their_from.max(their_to)).abs();
    // Seconds since 1970 have ten digits, milliseconds thirteen.
    let too_many = [to, their_to]
        .iter()
        .any(|stamp| stamp.abs() > MOST_SECONDS);
    let hint = if too_many
        || [1e3, 1e6, 1e9].iter().any(|unit| {
            let near = |ratio: f64| (0.5..2.0).contains(&(ratio / unit));
            near(ratio) || near(1.0 / ratio)
        }) {
        "; are both in seconds?"
    } else if overlap {
        "; a larger --max-difference or an --offset may pair them"
    } else {
        ""
    };
    let offset = match matching.offset_s {
        0.0 => String::new(),
        offset => format!(" ({offset} s added)"),
    };
    Error::work(format!(
        "no pose of {} lies within {} s of one of {}: stamps {from} to {to} s{offset} and {their_from} to {their_to} s{hint}",
        estimate.name(),
        matching.max_difference_s,
        reference.name()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn at(name: &str, stamps: &[f64]) -> Trajectory {
        let poses = vec![Pose::default(); stamps.len()];
        Trajectory::in_plane(name, Some(stamps.to_vec()), &poses).unwrap()
    }

    fn pairs(estimate: &[f64], reference: &[f64], matching: Matching) -> Vec<(usize, usize)> {
        let pairing = Pairing::of(&at("e", estimate), &at("r", reference), &matching).unwrap();
        pairing
            .estimate
            .into_iter()
            .zip(pairing.reference)
            .collect()
    }

    #[test]
    fn the_nearest_in_time_is_taken_and_the_earlier_of_two() {
        let wide = Matching {
            max_difference_s: 1.0,
            offset_s: 0.0,
        };
        assert_eq!(
            pairs(&[0.5, 1.75, 9.0], &[0.0, 1.0, 2.0, 3.0], wide),
            [(0, 0), (1, 2)]
        );
        // From the shorter, whichever it is.
        assert_eq!(
            pairs(&[0.0, 1.0, 2.0, 3.0], &[0.5, 1.75, 9.0], wide),
            [(0, 0), (2, 1)]
        );
    }

    #[test]
    fn the_offset_is_added_to_the_estimate() {
        let matching = Matching {
            offset_s: 10.0,
            ..Matching::default()
        };
        for estimate in [&[0.0, 1.0][..], &[0.0, 1.0, 1.5, 1.7]] {
            assert_eq!(
                pairs(estimate, &[10.0, 11.0, 12.0], matching),
                [(0, 0), (1, 1)]
            );
        }
    }

    #[test]
    fn a_pose_of_the_reference_counts_once() {
        let estimate = [0.0, 0.001, 0.002];
        let reference = [0.0, 1.0, 2.0, 3.0];
        let pairing = Pairing::of(
            &at("e", &estimate),
            &at("r", &reference),
            &Matching::default(),
        )
        .unwrap();
        assert_eq!((pairing.len(), pairing.covered()), (3, 1));
    }

    #[test]
    fn what_has_no_common_time_is_told_with_both_spans() {
        let error = |estimate: &[f64], reference: &[f64]| {
            Pairing::of(
                &at("e.tum", estimate),
                &at("r.tum", reference),
                &Matching::default(),
            )
            .unwrap_err()
            .to_string()
        };
        let apart = error(&[0.0, 1.0], &[5.0, 6.5]);
        assert!(
            apart.contains("e.tum") && apart.contains("stamps 0 to 1 s and 5 to 6.5 s"),
            "{apart}"
        );
        let near = error(&[0.0, 1.0], &[0.5, 0.75]);
        assert!(near.contains("--max-difference"), "{near}");
        let nanoseconds = error(&[1.5e18, 1.6e18], &[1.5e9, 1.6e9]);
        assert!(nanoseconds.contains("in seconds?"), "{nanoseconds}");
    }
}
