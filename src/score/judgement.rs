//! Everything that is said about one contingency table, under the names that users and other programs rely on.

use super::{
    bootstrap::Interval,
    contingency::Contingency,
    correction::{Drawn, corrected_coefficient, permutation_p_watched},
    uncertainty::Entropies,
};
use crate::seed::Seed;
use serde::{Deserialize, Serialize};
use std::hash::Hash;

/// How many random tables are drawn to judge one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Effort {
    /// Permutations for the p-value; 0: no p-value.
    pub permutations: u64,
    /// Bootstrap resamples for the interval; 0: no interval.
    pub resamples: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self {
            permutations: 999,
            resamples: 999,
        }
    }
}

/// What the responses of one table are worth. Entropies in nats; serialised, its fields are the JSON keys.
///
/// ```
/// use ballmark::{score::{Contingency, Effort, Judgement}, seed::Seed};
/// let mut table = Contingency::new();
/// for k in 0..60 {
///     table.record(["hall", "door", "desk"][k % 3], k % 3);
/// }
/// let rows: Vec<usize> = (0..60).collect();
/// let judgement = Judgement::of(&table, &rows, Effort::default(), Seed(1));
/// assert_eq!(judgement.uncertainty_coefficient, Some(1.0));
/// assert_eq!(judgement.permutation_p, Some(0.001));
/// assert_eq!(judgement.ci95, Some([1.0, 1.0]));
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Judgement {
    /// Data points N.
    pub n: usize,
    /// Different locations.
    pub locations: usize,
    /// Different responses.
    pub responses: usize,
    /// H(L).
    pub entropy_of_location: f64,
    /// H(L|R).
    pub entropy_of_location_given_response: f64,
    /// U(L|R); `None` with a single location.
    pub uncertainty_coefficient: Option<f64>,
    /// U corrected for chance, see [`corrected_coefficient`].
    pub uncertainty_coefficient_corrected: Option<f64>,
    /// See [`permutation_p`](super::permutation_p).
    pub permutation_p: Option<f64>,
    /// 95 % interval of the *corrected* coefficient, `[low, high]`, see [`Interval`].
    pub ci95: Option<[f64; 2]>,
}

impl Judgement {
    /// Judges a table. `unit_of[k]` is the trial of the k-th data point, by any number, or k itself where every row stands for
    /// itself.
    pub fn of<L: Eq + Hash, R: Eq + Hash>(
        table: &Contingency<L, R>,
        unit_of: &[usize],
        effort: Effort,
        seed: Seed,
    ) -> Self {
        Self::watched(table, unit_of, effort, seed, &|| ())
    }

    /// As [`Judgement::of`]; `drawn` is called after each random table, from any thread.
    pub(super) fn watched<L: Eq + Hash, R: Eq + Hash>(
        table: &Contingency<L, R>,
        unit_of: &[usize],
        effort: Effort,
        seed: Seed,
        drawn: Drawn<'_>,
    ) -> Self {
        let counts = table.counts();
        let entropies = Entropies::of(&counts);
        Self {
            n: table.len(),
            locations: counts.locations().len(),
            responses: counts.responses().len(),
            entropy_of_location: entropies.location,
            entropy_of_location_given_response: entropies.location_given_response(),
            uncertainty_coefficient: entropies.uncertainty_coefficient(),
            uncertainty_coefficient_corrected: corrected_coefficient(&counts),
            permutation_p: permutation_p_watched(&counts, effort.permutations, seed, drawn),
            ci95: Interval::watched(
                std::slice::from_ref(table),
                unit_of,
                effort.resamples,
                seed,
                drawn,
            )
            .map(|interval| [interval.low, interval.high]),
        }
    }
}

/// Corrected for chance, less than this share of a coefficient is left where chance makes most of it …
const MOSTLY_CHANCE: f64 = 0.5;
/// … and a coefficient below this is nothing to warn of.
const WORTH_A_WARNING: f64 = 0.1;
/// With fewer data points a location than this, chance makes a good part of a coefficient.
const FEW_A_LOCATION: usize = 5;

/// Why a coefficient U(L|R) of `n` data points must not be taken as it stands; `None` where it may.
///
/// ```
/// use ballmark::score::Caution;
/// assert_eq!(Caution::of(17, 77, Some(0.914), Some(0.225)), Some(Caution::MostlyChance));
/// assert_eq!(Caution::of(300, 77, Some(0.9), Some(0.8)), Some(Caution::FewData));
/// assert_eq!(Caution::of(800, 77, Some(0.9), Some(0.85)), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Caution {
    /// Corrected for chance, less than half of it is left.
    MostlyChance,
    /// There are fewer than five data points a location.
    FewData,
}

impl Caution {
    /// From the number of data points and of locations, the coefficient, and the coefficient corrected for chance.
    pub fn of(
        n: usize,
        locations: usize,
        coefficient: Option<f64>,
        corrected: Option<f64>,
    ) -> Option<Self> {
        let coefficient = coefficient.filter(|u| *u >= WORTH_A_WARNING)?;
        if corrected.is_some_and(|corrected| corrected < MOSTLY_CHANCE * coefficient) {
            return Some(Caution::MostlyChance);
        }
        (n < FEW_A_LOCATION * locations).then_some(Caution::FewData)
    }
}
