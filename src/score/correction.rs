//! What of an uncertainty coefficient is owed to chance, and how likely chance reaches it.
//!
//! Chance means: the same locations and the same responses, each as often as in the table, paired at random. Under it a
//! cell is hypergeometric, and the mean mutual information E\[I\] is a finite sum (Vinh, Epps & Bailey, *Information
//! theoretic measures for clusterings comparison*, JMLR 11, 2010, eq. 24a). The corrected coefficient subtracts it from
//! what is reached and from what can be reached, as their adjusted mutual information does, but with H(L) for the
//! maximum, since U(L|R) divides by H(L):
//!
//! U_c = (I − E\[I\]) / (H(L) − E\[I\])
//!
//! It is exactly 0 on average under chance, whatever the margins, and 1 stays 1. It may be negative; cutting it at 0
//! would bring the bias back. Chance is all it corrects for: where the response does know something and the table is
//! sparse, it still lies somewhat above the value of an endless sample (20 × 20 labels, 200 rows: U .62, U_c .45, in
//! truth .41).

use super::{contingency::Counts, uncertainty::Entropies};
use crate::seed::Seed;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What is called after each random table, from any thread.
pub(super) type Drawn<'a> = &'a (dyn Fn() + Sync);

/// Relative rounding that two sums of the same terms in another order may show.
const ROUNDING: f64 = 1e-10;

/// E\[I\] in nats: the mean mutual information of location and response over all ways to pair them at random.
///
/// ```
/// use ballmark::score::{Contingency, expected_mutual_information};
/// let mut table = Contingency::new();
/// table.record("left", "a");
/// table.record("right", "b");
/// // Both ways to pair two locations with two responses tell everything: ln 2.
/// assert!((expected_mutual_information(&table.counts()) - 2f64.ln()).abs() < 1e-12);
/// ```
pub fn expected_mutual_information(counts: &Counts) -> f64 {
    let total = counts.total();
    if total == 0 {
        return 0.0;
    }
    let n_ln_n = table_of_n_ln_n(total);
    let sum = |counts: &[u64]| counts.iter().map(|&n| n_ln_n[n as usize]).sum::<f64>();
    let mut cells = 0.0;
    // Equal margins have equal cells: each distinct pair of margins is summed once.
    for (&at, &locations) in &multiplicities(counts.locations()) {
        for (&given, &responses) in &multiplicities(counts.responses()) {
            let pairs = (locations * responses) as f64;
            cells += pairs * expected_n_ln_n(total, at, given, &n_ln_n);
        }
    }
    // I = ln N + (Σ n_rl ln n_rl − Σ n_•l ln n_•l − Σ n_r• ln n_r•) / N
    let information = cells - sum(counts.locations()) - sum(counts.responses());
    ((total as f64).ln() + information / total as f64).max(0.0)
}

/// The coefficient corrected for chance, U_c: 0 on average where responses are independent of locations, 1 where they determine them.
/// `None` where U is undefined (a single location), or where every pairing tells the same (each response given once).
pub fn corrected_coefficient(counts: &Counts) -> Option<f64> {
    let entropies = Entropies::of(counts);
    let by_chance = expected_mutual_information(counts);
    let room = entropies.location - by_chance;
    (room > ROUNDING * entropies.location)
        .then(|| (entropies.mutual_information() - by_chance) / room)
}

/// How likely chance reaches the table's mutual information: (1 + reached) / (1 + `permutations`), the add-one rule,
/// never 0 (Phipson & Smyth 2010). `None` where U is undefined or no permutation is asked for.
///
/// The permutations are drawn from numbered streams of `seed`, so the result is the same for any number of threads and
/// any order of rows.
pub fn permutation_p(counts: &Counts, permutations: u64, seed: Seed) -> Option<f64> {
    permutation_p_watched(counts, permutations, seed, &|| ())
}

/// As [`permutation_p`]; `drawn` is called after each permutation, from any thread.
pub(super) fn permutation_p_watched(
    counts: &Counts,
    permutations: u64,
    seed: Seed,
    drawn: Drawn<'_>,
) -> Option<f64> {
    if counts.locations().len() < 2 || permutations == 0 {
        return None;
    }
    let n_ln_n = table_of_n_ln_n(counts.total());
    // With fixed margins the mutual information grows with Σ n ln n over the cells and with nothing else.
    let observed: f64 = counts.cells().iter().map(|&n| n_ln_n[n as usize]).sum();
    let threshold = observed - ROUNDING * observed.abs();
    let in_order: Vec<usize> = (0..counts.responses().len())
        .flat_map(|response| std::iter::repeat_n(response, counts.responses()[response] as usize))
        .collect();
    let reached = (0..permutations)
        .into_par_iter()
        .map_init(
            || (in_order.clone(), vec![0; counts.responses().len()]),
            |(shuffled, cell), permutation| {
                shuffled.copy_from_slice(&in_order);
                shuffled.shuffle(&mut seed.numbered_stream("permuted responses", permutation));
                let mut rest = shuffled.as_slice();
                let mut sum = 0.0;
                for &at in counts.locations() {
                    let (here, after) = rest.split_at(at as usize);
                    here.iter().for_each(|&response| cell[response] += 1);
                    for &response in here {
                        sum += n_ln_n[std::mem::take(&mut cell[response])];
                    }
                    rest = after;
                }
                drawn();
                sum >= threshold
            },
        )
        .filter(|&reaches| reaches)
        .count();
    Some((1 + reached) as f64 / (1 + permutations) as f64)
}

/// E\[n ln n\] of a cell that lies between a location seen `at` times and a response given `given` times among `total`.
///
/// Hypergeometric weights are walked from the mode outwards by their ratios, relative to the mode's, and divided by
/// their sum: no factorial is formed, and nothing overflows.
fn expected_n_ln_n(total: u64, at: u64, given: u64, n_ln_n: &[f64]) -> f64 {
    let least = (at + given).saturating_sub(total);
    let most = at.min(given);
    // In floating point: the product of two counts may not fit 64 bits.
    let peak = ((at + 1) as f64 * (given + 1) as f64 / (total + 2) as f64) as u64;
    let mode = peak.clamp(least, most);
    // P(n + 1) / P(n) = (at − n)(given − n) / ((n + 1)(total − at − given + n + 1))
    let ratio = |n: u64| {
        let up = (at - n) as f64 * (given - n) as f64;
        up / ((n + 1) as f64 * ((total + n + 1) - at - given) as f64)
    };
    let (mut weights, mut weighted) = (1.0, n_ln_n[mode as usize]);
    let mut weight = 1.0;
    for n in mode..most {
        weight *= ratio(n);
        if weight < NEGLIGIBLE {
            break;
        }
        weights += weight;
        weighted += weight * n_ln_n[n as usize + 1];
    }
    weight = 1.0;
    for n in (least..mode).rev() {
        weight /= ratio(n);
        if weight < NEGLIGIBLE {
            break;
        }
        weights += weight;
        weighted += weight * n_ln_n[n as usize];
    }
    weighted / weights
}

/// Weight, relative to the most probable count, from which on the tail adds nothing to a 64-bit sum.
const NEGLIGIBLE: f64 = 1e-20;

/// n ln n for n = 0..=total; 0 ln 0 = 0.
fn table_of_n_ln_n(total: u64) -> Vec<f64> {
    (0..=total)
        .map(|n| n as f64 * (n.max(1) as f64).ln())
        .collect()
}

fn multiplicities(counts: &[u64]) -> BTreeMap<u64, u64> {
    let mut times = BTreeMap::new();
    for &count in counts {
        *times.entry(count).or_insert(0) += 1;
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::Contingency;
    use rand::RngExt;

    fn counts(points: impl Iterator<Item = (usize, usize)>) -> Counts {
        let mut table = Contingency::new();
        points.for_each(|(location, response)| table.record(location, response));
        table.counts()
    }

    /// scikit-learn 1.9.1, `sklearn.metrics.cluster.expected_mutual_information`.
    #[test]
    fn expected_information_agrees_with_scikit_learn() {
        let location = [0, 0, 0, 1, 1, 1, 2, 2, 2, 3];
        let response = [0, 0, 1, 1, 1, 2, 2, 2, 0, 3];
        let confused = |i: usize| {
            if i.is_multiple_of(3) {
                i * 7 % 6
            } else {
                i % 13 / 2
            }
        };
        let cases = [
            (counts(location.into_iter().zip(response)), 0.568143111763),
            (counts((0..60).map(|i| (i % 7, i * i % 5))), 0.115457742811),
            (
                counts((0..200).map(|i| (i % 13, confused(i)))),
                0.209473374140,
            ),
        ];
        for (counts, theirs) in cases {
            let ours = expected_mutual_information(&counts);
            assert!((ours - theirs).abs() < 1e-11, "{ours} {theirs}");
        }
    }

    /// Every one of the 6! pairings of a small table, written out.
    #[test]
    fn expected_information_is_the_mean_over_all_pairings() {
        fn pairings(responses: &mut Vec<usize>, from: usize, visit: &mut impl FnMut(&[usize])) {
            if from == responses.len() {
                return visit(responses);
            }
            for k in from..responses.len() {
                responses.swap(from, k);
                pairings(responses, from + 1, visit);
                responses.swap(from, k);
            }
        }
        let locations = [0, 0, 0, 1, 1, 2];
        let mut responses = vec![0, 0, 1, 1, 1, 2];
        let (mut sum, mut number) = (0.0, 0.0);
        pairings(&mut responses, 0, &mut |responses| {
            let counts = counts(locations.into_iter().zip(responses.iter().copied()));
            sum += Entropies::of(&counts).mutual_information();
            number += 1.0;
        });
        let counts = counts(locations.into_iter().zip(responses));
        assert_eq!(number, 720.0);
        assert!((expected_mutual_information(&counts) - sum / number).abs() < 1e-12);
    }

    #[test]
    fn chance_averages_zero_where_the_plain_coefficient_averages_a_half() {
        let (mut plain, mut corrected, tables) = (0.0, 0.0, 400);
        for table in 0..tables {
            let mut stream = Seed(3).numbered_stream("independent", table);
            let counts =
                counts((0..100).map(|_| (stream.random_range(0..50), stream.random_range(0..16))));
            plain += Entropies::of(&counts).uncertainty_coefficient().unwrap() / tables as f64;
            corrected += corrected_coefficient(&counts).unwrap() / tables as f64;
        }
        assert!((0.48..0.52).contains(&plain), "{plain}");
        assert!(corrected.abs() < 0.005, "{corrected}"); // one table varies by .016
    }

    #[test]
    fn what_tells_all_stays_one_and_what_cannot_be_told_is_none() {
        assert_eq!(
            corrected_coefficient(&counts((0..50).map(|k| (k % 5, k % 5)))),
            Some(1.0)
        );
        assert_eq!(
            corrected_coefficient(&counts((0..50).map(|k| (k % 5, k)))),
            None
        );
        assert_eq!(
            corrected_coefficient(&counts((0..50).map(|k| (7, k % 5)))),
            None
        );
    }

    #[test]
    fn p_is_small_for_knowledge_and_even_for_chance() {
        let seed = Seed(1);
        let known = counts((0..100).map(|k| (k % 5, k % 5)));
        assert_eq!(permutation_p(&known, 199, seed), Some(1.0 / 200.0));
        let flat = counts((0..25).map(|k| (k % 5, k / 5))); // no pairing tells less
        assert_eq!(permutation_p(&flat, 199, seed), Some(1.0));
        assert_eq!(
            permutation_p(&counts((0..9).map(|k| (1, k))), 199, seed),
            None
        );
        let below_a_tenth = (0..200)
            .filter(|&table| {
                let mut stream = seed.numbered_stream("independent", table);
                let counts =
                    counts((0..60).map(|_| (stream.random_range(0..6), stream.random_range(0..4))));
                permutation_p(&counts, 99, Seed(table)).is_some_and(|p| p <= 0.1)
            })
            .count();
        assert!((8..=32).contains(&below_a_tenth), "{below_a_tenth} of 200"); // 20 expected, sd 4.2
    }

    #[test]
    fn threads_do_not_change_p() {
        let counts = counts((0..300).map(|k| (k % 17, k * k % 11)));
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| permutation_p(&counts, 500, Seed(9)))
        };
        assert_eq!(with(1), with(4));
    }
}
