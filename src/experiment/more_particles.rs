//! Whether a particle filter had particles enough: the same trials with more of them.
//!
//! A filter that finds the robot with more particles was judged by their number, not by what it is: with 5,000 in place of 40,000 a
//! robot anywhere in a building is lost where nobody says so.

use super::paired_trials::{PairedTest, SURE_P, TrialFigures, paired_tests};
use crate::{score::holm, seed::Seed};
use serde::{Deserialize, Serialize};

/// A method that plays with fewer particles.
#[derive(Debug, Clone, PartialEq)]
pub struct FewerParticles {
    /// Its name.
    pub name: String,
    /// Its particles.
    pub fewer: usize,
    /// Those of the method that this stands by.
    pub more: usize,
}

/// A method against itself with more particles, over the trials that start anywhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MoreParticles {
    /// Particles of the method.
    pub particles: usize,
    /// Particles of the one that had more.
    pub more: usize,
    /// That one (`name`) against the method (`against`).
    pub test: PairedTest,
    /// Do more change its figures by more than chance? Of the error after 10 m, the trials found and the metres until then one has a
    /// p below 0.05, corrected for their number (Holm 1979); where there are too few runs or stretches for that, the trials found
    /// differ by ten points.
    pub changes: bool,
}

/// A difference of this share of the trials is worth a warning where no test can be made.
const WORTH_A_WARNING: f64 = 0.1;

impl MoreParticles {
    /// Of the method with fewer particles and of the one with more, each by its name, trial by trial.
    pub(super) fn of(
        particles: &FewerParticles,
        pair: &[(&str, &TrialFigures); 2],
        unit_of: &[usize],
        resamples: usize,
        seed: Seed,
    ) -> Option<Self> {
        let test = paired_tests(pair, unit_of, resamples, seed).pop()?;
        Some(Self {
            particles: particles.fewer,
            more: particles.more,
            changes: is_changed(&test),
            test,
        })
    }
}

fn is_changed(test: &PairedTest) -> bool {
    let corrected = holm(&[test.p, test.p_found, test.p_distance]);
    let is_sure = corrected.iter().flatten().any(|p| *p < SURE_P);
    let found = test.found_difference.unwrap_or(0.0).abs();
    is_sure || (test.is_too_few() && found >= WORTH_A_WARNING - 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two trials in each of so many stretches, of which the first are found with more particles alone.
    fn tested(stretches: usize, found_by_more: usize) -> PairedTest {
        let trials = 2 * stretches;
        let figures = |found: &dyn Fn(usize) -> bool| TrialFigures {
            error_m: vec![None; trials],
            found: (0..trials).map(found).collect(),
            distance_m: vec![Some(9.0); trials],
        };
        let (few, many) = (figures(&|k| k >= 2 * found_by_more), figures(&|_| true));
        let unit_of: Vec<usize> = (0..trials).map(|k| k / 2).collect();
        paired_tests(&[("few", &few), ("many", &many)], &unit_of, 100, Seed(1)).remove(0)
    }

    #[test]
    fn a_change_is_more_than_chance_or_large_where_nothing_can_be_tested() {
        assert!(is_changed(&tested(10, 9)));
        assert!(!is_changed(&tested(10, 2))); // two of ten stretches: p = .5
        let few = tested(5, 1); // 5 stretches: no p below .0625, of three .19
        assert!(few.is_too_few() && is_changed(&few));
        assert!(!is_changed(&tested(5, 0)));
    }
}
