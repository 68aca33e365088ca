//! Everything that is said about a file of responses, under the names that users and other programs rely on.

use super::{
    judgement::{Caution, Effort, Judgement},
    label_notes,
    responses::Responses,
};
use crate::seed::Seed;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What the responses of a file are worth, over all rows and at each distance; serialised, its fields are the JSON keys.
///
/// ```
/// use ballmark::{score::{Effort, Responses, Verdict}, seed::Seed};
/// let csv = "location,response\n".to_string() + &"hall,1\ndoor,2\n".repeat(20);
/// let responses = Responses::from_reader("answers.csv", csv.as_bytes())?;
/// let verdict = Verdict::new(&responses, Effort::default(), Seed(0));
/// assert_eq!(verdict.overall.uncertainty_coefficient, Some(1.0));
/// assert!(verdict.notes.is_empty());
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Verdict {
    #[serde(flatten)]
    /// The judgement of all rows.
    pub overall: Judgement,
    /// What `ci95` is an interval of.
    pub ci95_of: &'static str,
    /// What is drawn for it: `trials` or `rows`.
    pub ci95_over: &'static str,
    /// Number of trials; none where the file doesn't tell them.
    pub trials: Option<usize>,
    /// Which logarithm the entropies are in.
    pub logarithm: &'static str,
    /// Permutations for the p-values.
    pub permutations: u64,
    /// Bootstrap resamples for the intervals.
    pub bootstrap: u64,
    /// Seed of both.
    pub seed: u64,
    /// One judgement a distance, ascending; none where the file has no distances.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_distance: Option<Vec<AtDistance>>,
    /// Why a value is missing, and what a reader may take wrongly.
    pub notes: Vec<String>,
}

/// The table of one distance travelled (Duckett & Nehmzow 1998, 6.5).
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct AtDistance {
    /// Metres travelled.
    pub distance_m: f64,
    /// The judgement of the rows at that distance.
    #[serde(flatten)]
    pub judgement: Judgement,
}

impl Verdict {
    /// Judges all rows, and those at each distance where the file has distances.
    pub fn new(responses: &Responses, effort: Effort, seed: Seed) -> Self {
        Self::watched(responses, effort, seed, &|_, _| ())
    }

    /// As [`Verdict::new`]; `progress` is told, from any thread, how many random tables of how many were drawn, the tables at each
    /// distance taken together as one.
    pub fn watched(
        responses: &Responses,
        effort: Effort,
        seed: Seed,
        progress: &(dyn Fn(usize, usize) + Sync),
    ) -> Self {
        let rounds = 1 + usize::from(responses.distance_m().is_some());
        let tables = rounds * (effort.permutations + effort.resamples) as usize;
        let rows_drawn = AtomicUsize::new(0);
        let drew = |rows: usize| {
            let before = rows_drawn.fetch_add(rows, Ordering::Relaxed);
            progress((before + rows) / responses.len().max(1), tables);
        };
        let rows: Vec<usize> = (0..responses.len()).collect();
        let unit_of = responses.trial().unwrap_or(&rows);
        let overall = Judgement::watched(&responses.table(), unit_of, effort, seed, &|| {
            drew(rows.len());
        });
        let by_distance = responses.distance_m().map(|distance_m| {
            let mut order = rows.clone();
            order.sort_by(|&a, &b| distance_m[a].total_cmp(&distance_m[b]));
            let same = |a: &usize, b: &usize| distance_m[*a] == distance_m[*b];
            let at = |rows: &[usize]| {
                let units: Vec<usize> = rows.iter().map(|&k| unit_of[k]).collect();
                let table = responses.table_of(rows.iter().copied());
                AtDistance {
                    distance_m: distance_m[rows[0]],
                    judgement: Judgement::watched(&table, &units, effort, seed, &|| {
                        drew(units.len());
                    }),
                }
            };
            order.chunk_by(same).map(at).collect::<Vec<_>>()
        });
        let last = responses.trial().and_then(|trial| trial.iter().max());
        let trials = last.map(|last| last + 1);
        let mut verdict = Self {
            overall,
            ci95_of: "uncertainty_coefficient_corrected",
            ci95_over: if trials.is_some() { "trials" } else { "rows" },
            trials,
            logarithm: "natural",
            permutations: effort.permutations,
            bootstrap: effort.resamples,
            seed: seed.0,
            by_distance,
            notes: Vec::new(),
        };
        verdict.notes = verdict.what_to_note();
        let of = label_notes::of;
        verdict
            .notes
            .extend(of(responses.location(), "location", "a place"));
        verdict
            .notes
            .extend(of(responses.response(), "response", "an answer"));
        verdict
    }

    /// Why a value is missing, and what a reader may take wrongly.
    fn what_to_note(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let overall = &self.overall;
        if overall.uncertainty_coefficient.is_none() {
            notes.push(
                "all rows have one location: H(L) = 0, so the uncertainty coefficient is undefined"
                    .into(),
            );
        } else if overall.uncertainty_coefficient_corrected.is_none() {
            notes.push("pairing locations and responses at random tells as much in every way: no corrected coefficient".into());
        } else if overall.ci95.is_none() && self.bootstrap > 0 {
            notes.push(match self.trials {
                Some(1) => "one trial only: no interval over trials".into(),
                _ => "too few resamples have a coefficient: no interval".into(),
            });
        }
        if let (Some(plain), Some(corrected)) = (
            overall.uncertainty_coefficient,
            overall.uncertainty_coefficient_corrected,
        ) {
            let (n, locations, responses) = (overall.n, overall.locations, overall.responses);
            let share = match Caution::of(n, locations, Some(plain), Some(corrected)) {
                Some(Caution::MostlyChance) => "most",
                Some(Caution::FewData) => "some",
                None => "",
            };
            if !share.is_empty() {
                notes.push(format!(
                    "{n} rows are few for {locations} locations and {responses} responses: chance alone makes {share} of \
                     U(L|R) = {plain:.3}; the corrected coefficient is {corrected:.3}"
                ));
            }
        }
        if let Some(rows) = &self.by_distance {
            let single = rows.iter().filter(|row| row.judgement.n == 1).count();
            if single > 0 {
                let all = rows.len();
                notes.push(format!("{single} of {all} distances hold a single row; round `distance_m` to bins, such as 0.1 m"));
            }
            if self.trials.is_none() {
                notes.push("`distance_m` without `trial`: the interval takes rows of one trial for independent and is too narrow".into());
            }
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    /// Whoever watches sees every random table once, the distances' as large together as the whole; and watching changes nothing.
    #[test]
    fn progress_ends_with_the_last_random_table() {
        let rows: Vec<String> = (0..40)
            .map(|k| format!("{},{},{}\n", k % 3, k % 4, k % 2))
            .collect();
        let csv = "location,response,distance_m\n".to_string() + &rows.concat();
        let responses = Responses::from_reader("answers.csv", csv.as_bytes()).unwrap();
        let effort = Effort {
            permutations: 30,
            resamples: 20,
        };
        let seen = Mutex::new(Vec::new());
        let watched = Verdict::watched(&responses, effort, Seed(1), &|done, of| {
            seen.lock().unwrap().push((done, of));
        });
        let mut seen = seen.into_inner().unwrap();
        seen.sort_unstable();
        assert_eq!((seen.len(), seen.last()), (150, Some(&(100, 100))));
        assert_eq!(
            watched.overall,
            Verdict::new(&responses, effort, Seed(1)).overall
        );
    }
}
