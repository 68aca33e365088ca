//! How likely the robot takes itself to be at each place.

use super::{places::Places, prior::Uncertainty};
use crate::error::{Error, Result};
use rayon::prelude::*;
use std::sync::Arc;

/// What is left of a mass below this is 0: no evidence will ever bring such a place back, and a filter passes by cells
/// without mass. Of a belief over n cells a step drops less than n · 10⁻¹⁰⁰.
pub(super) const NEGLIGIBLE: f64 = 1e-100;

/// Bel(ξ) (Thrun 1998, eq. 1): a mass for each of some places, the cells of a grid as a rule, that sums to 1.
///
/// ```
/// use ballmark::belief::{Belief, Places};
/// let corridor = std::sync::Arc::new(Places::Route(vec![0.5, 1.5, 2.5, 3.5]));
/// let lost = Belief::uniform(&corridor)?;
/// let truth = Places::Route(vec![0.5]);
/// assert_eq!(lost.expected_error_m(&truth, 0), (0.0 + 1.0 + 2.0 + 3.0) / 4.0);
/// assert_eq!(lost.mode(), 0); // of equals, the first
/// assert!((lost.entropy_bits() - 2.0).abs() < 1e-12);
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    places: Arc<Places>,
    mass: Vec<f64>,
}

impl Belief {
    /// All places alike: the robot has no idea (global localisation).
    ///
    /// # Errors
    /// Where there is no place.
    pub fn uniform(places: &Arc<Places>) -> Result<Self> {
        Self::from_mass(places, vec![1.0; places.len()])
    }

    /// A belief in proportion to `mass`, one number a place.
    ///
    /// # Errors
    /// Where the lengths differ, a number is negative or not finite, or all are 0.
    pub fn from_mass(places: &Arc<Places>, mass: Vec<f64>) -> Result<Self> {
        if mass.len() != places.len() {
            return Err(Error::work(format!(
                "belief: {} masses for {} places",
                mass.len(),
                places.len()
            )));
        }
        if let Some(bad) = mass.iter().position(|m| !(m.is_finite() && *m >= 0.0)) {
            return Err(Error::work(format!(
                "belief: the mass of place {bad} is {}; expected 0 or more",
                mass[bad]
            )));
        }
        let largest = mass.iter().fold(0.0_f64, |a, &b| a.max(b));
        if largest == 0.0 {
            return Err(Error::work("belief: no place has any mass"));
        }
        let mut belief = Self {
            places: Arc::clone(places),
            mass: mass.into_iter().map(|m| m / largest).collect(), // so that the sum can't overflow
        };
        belief.normalise();
        Ok(belief)
    }

    /// A known start (position tracking): a Gaussian around place `truth_index` of `truth`, with standard deviations in
    /// metres along the ground and radians of heading. The place nearest to the start counts even where the spread is
    /// far smaller than a cell.
    ///
    /// # Errors
    /// Where a spread isn't above 0.
    pub fn around(
        places: &Arc<Places>,
        truth: &Places,
        truth_index: usize,
        spread_m: f64,
        spread_rad: f64,
    ) -> Result<Self> {
        if !(spread_m > 0.0 && spread_rad > 0.0) {
            return Err(Error::usage(format!(
                "start: spreads of {spread_m} m and {spread_rad} rad; expected both above 0"
            )));
        }
        let exponent: Vec<f64> = (0..places.len())
            .map(|cell| {
                let distance = truth.distance_m(truth_index, places, cell) / spread_m;
                let turn = truth.turn_rad(truth_index, places, cell) / spread_rad;
                -0.5 * (distance * distance + turn * turn)
            })
            .collect();
        let nearest = exponent.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self::from_mass(
            places,
            exponent.iter().map(|e| (e - nearest).exp()).collect(),
        )
    }

    /// Uniform over the places that an uncertainty admits for a robot at place `truth_index` of `truth` (Thrun 1998, 5.1.7).
    ///
    /// # Errors
    /// Where it admits none.
    pub fn within(
        places: &Arc<Places>,
        truth: &Places,
        truth_index: usize,
        uncertainty: &Uncertainty,
    ) -> Result<Self> {
        let admitted = |cell| uncertainty.admits(truth, truth_index, places, cell);
        let mass: Vec<f64> = (0..places.len())
            .map(|cell| f64::from(admitted(cell)))
            .collect();
        if mass.iter().all(|m| *m == 0.0) {
            return Err(Error::work(format!(
                "belief: no place lies within {uncertainty} of the robot"
            )));
        }
        Self::from_mass(places, mass)
    }

    /// The places that the belief is about.
    pub fn places(&self) -> &Arc<Places> {
        &self.places
    }

    /// The mass of each place; sums to 1.
    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// Σ_ξ e(ξ*, ξ) Bel(ξ), in metres (Thrun 1998, eq. 21), with place `truth_index` of `truth` as ξ*.
    pub fn expected_error_m(&self, truth: &Places, truth_index: usize) -> f64 {
        self.sum(|cell, mass| mass * truth.distance_m(truth_index, &self.places, cell))
    }

    /// The place of the largest mass; of several, the first.
    pub fn mode(&self) -> usize {
        let mut best = 0;
        for (cell, mass) in self.mass.iter().enumerate() {
            if *mass > self.mass[best] {
                best = cell;
            }
        }
        best
    }

    /// Distance from the truth to the mode, in metres.
    pub fn point_error_m(&self, truth: &Places, truth_index: usize) -> f64 {
        truth.distance_m(truth_index, &self.places, self.mode())
    }

    /// −Σ Bel log₂ Bel: the bits of place that are still missing.
    pub fn entropy_bits(&self) -> f64 {
        self.sum(|_, mass| if mass > 0.0 { -mass * mass.log2() } else { 0.0 })
    }

    /// Mass of all places no farther than `radius_m` from the truth, any heading.
    pub fn mass_within_m(&self, truth: &Places, truth_index: usize, radius_m: f64) -> f64 {
        self.sum(|cell, mass| {
            let near = truth.distance_m(truth_index, &self.places, cell) <= radius_m;
            if near { mass } else { 0.0 }
        })
    }

    pub(super) fn sum(&self, term: impl Fn(usize, f64) -> f64 + Sync) -> f64 {
        sum_in_blocks(self.mass.len(), |cell| term(cell, self.mass[cell]))
    }

    /// The masses, for the steps of the filter; they leave them normalised.
    pub(super) fn mass_mut(&mut self) -> &mut [f64] {
        &mut self.mass
    }

    /// Bel(ξ) ← (1 − share) Bel(ξ) + share · other(ξ): as if with that probability all were forgotten but `other`.
    pub(super) fn mix(&mut self, other: &[f64], share: f64) {
        let both = self.mass.par_iter_mut().zip(other);
        both.for_each(|(mass, other)| *mass += share * (other - *mass));
        self.normalise();
    }

    /// Bel(ξ) ← Bel(ξ) [∫ Bel(ξ̃) dξ̃]⁻¹ (eq. 18); what is below [`NEGLIGIBLE`] becomes 0.
    fn normalise(&mut self) {
        let total = sum_in_blocks(self.mass.len(), |cell| self.mass[cell]);
        self.mass.par_iter_mut().for_each(|mass| {
            *mass /= total;
            if *mass < NEGLIGIBLE {
                *mass = 0.0;
            }
        });
    }
}

/// Σ term(i) over 0..length: in parallel, yet added up in the same order whatever the number of threads.
pub(super) fn sum_in_blocks(length: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    const BLOCK: usize = 4096;
    let blocks: Vec<f64> = (0..length.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            (block * BLOCK..((block + 1) * BLOCK).min(length))
                .map(&term)
                .sum()
        })
        .collect();
    blocks.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    fn line(n: usize) -> Arc<Places> {
        Arc::new(Places::Route((0..n).map(|i| i as f64).collect()))
    }

    #[test]
    fn judges_itself_against_the_truth() {
        let belief = Belief::from_mass(&line(3), vec![1.0, 2.0, 1.0]).unwrap();
        let truth = Places::Route(vec![9.0, 2.5]);
        assert_eq!(belief.mass(), [0.25, 0.5, 0.25]);
        assert_eq!(belief.mode(), 1);
        let twins = Belief::from_mass(&line(3), vec![1.0, 2.0, 2.0]).unwrap();
        assert_eq!(twins.mode(), 1, "of equals, the first");
        assert_eq!(belief.point_error_m(&truth, 1), 1.5);
        assert_eq!(
            belief.expected_error_m(&truth, 1),
            (2.5 + 2.0 * 1.5 + 0.5) / 4.0
        );
        assert_eq!(belief.mass_within_m(&truth, 1, 1.5), 0.75);
        assert_eq!(belief.mass_within_m(&truth, 1, 1.4), 0.25);
        assert!((belief.entropy_bits() - 1.5).abs() < 1e-15);
    }

    #[test]
    fn starts_from_a_window_or_a_gaussian() {
        let poses: Vec<Pose> = (0..100)
            .map(|i| Pose::new((i / 10) as f64, 0.0, (i % 10) as f64 * 0.3))
            .collect();
        let places = Arc::new(Places::Plane(poses));
        let window = "2m,0.5rad".parse().unwrap();
        let belief = Belief::within(&places, &places, 55, &window).unwrap();
        // 5 positions × 3 headings
        assert_eq!(belief.mass().iter().filter(|m| **m > 0.0).count(), 15);
        assert!((belief.mass()[55] - 1.0 / 15.0).abs() < 1e-15);
        let nobody = Places::Plane(vec![Pose::new(50.0, 0.0, 0.0)]);
        let error = Belief::within(&places, &nobody, 0, &window).unwrap_err();
        assert!(error.to_string().contains("within 2m "), "{error}");

        let known = Belief::around(&places, &places, 55, 1.0, 0.3).unwrap();
        assert_eq!(known.mode(), 55);
        assert!((known.mass()[65] / known.mass()[55] - (-0.5_f64).exp()).abs() < 1e-12);
        assert!((known.mass()[56] / known.mass()[55] - (-0.5_f64).exp()).abs() < 1e-12);
        let sharp = Belief::around(&places, &nobody, 0, 1e-3, 1e-3).unwrap();
        assert!((sharp.mass()[90] - 1.0).abs() < 1e-12);
        assert!(
            Belief::around(&places, &places, 0, 0.0, 1.0)
                .unwrap_err()
                .is_usage()
        );
    }

    #[test]
    fn masses_that_mean_nothing_are_refused() {
        for mass in [
            vec![0.0; 3],
            vec![1.0, f64::NAN, 0.0],
            vec![1.0, -1.0, 1.0],
            vec![1.0; 2],
        ] {
            assert!(Belief::from_mass(&line(3), mass).is_err());
        }
        assert!(Belief::uniform(&line(0)).is_err());
        let huge = Belief::from_mass(&line(3), vec![1e308; 3]).unwrap();
        assert!((huge.mass()[0] - 1.0 / 3.0).abs() < 1e-15);
    }
}
