//! Everything that is said about one contingency table, under the names that users and other programs rely on.

use super::{
    bootstrap::Interval,
    contingency::Contingency,
    correction::{corrected_coefficient, permutation_p},
    uncertainty::Entropies,
};
use crate::seed::Seed;
use serde::{Deserialize, Serialize};
use std::hash::Hash;

/// How many random tables are drawn to judge one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
    /// See [`permutation_p`].
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
            permutation_p: permutation_p(&counts, effort.permutations, seed),
            ci95: Interval::by_bootstrap(table, unit_of, effort.resamples, seed)
                .map(|interval| [interval.low, interval.high]),
        }
    }
}
