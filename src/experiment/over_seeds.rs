//! A paper's comparison on the worlds that several seeds make, so that no figure rests on one draw.

use super::{
    compare::{CompareConfig, Comparison, ComparisonRecord, Folders, Progress, Section, compare},
    reproduce::Paper,
};
use crate::{
    error::{Error, Result},
    storage,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::{
    path::Path,
    sync::{Mutex, PoisonError},
};

/// Which seeds, and how much of each.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Seeds {
    /// The first of them; the others follow one by one.
    pub first: u64,
    /// How many: worlds, learning, permutations and resamples are drawn anew with each.
    pub count: usize,
    /// Few trials and resamples only, and of more than three systems the first two environments: does it work here?
    pub toy: bool,
}

impl Default for Seeds {
    fn default() -> Self {
        Self {
            first: 1,
            count: 10,
            toy: false,
        }
    }
}

/// Most seeds: far beyond any use, few enough to hold.
const MOST: usize = 1000;

impl Seeds {
    /// The same at toy size: three seeds.
    pub fn toy(self) -> Self {
        Self {
            count: 3,
            toy: true,
            ..self
        }
    }

    /// # Errors
    /// A usage error where the seeds are none, or too many.
    pub fn check(&self) -> Result<()> {
        let last = self.first.checked_add(self.count as u64);
        if !(1..=MOST).contains(&self.count) || last.is_none() {
            return Err(Error::usage(format!(
                "{} seeds from {} on; expected 1 to {MOST}, none above 2^64 - 1",
                self.count, self.first
            )));
        }
        Ok(())
    }
}

/// What came of a paper's comparison with each seed. As JSON each comparison has its `timing` beside its record, which alone differs
/// from one call to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Reproduction {
    /// Version of this crate that compared.
    pub version: String,
    /// The paper, by its [name](Paper::name).
    pub paper: String,
    /// Which seeds.
    pub seeds: Seeds,
    /// One a seed, in their order.
    pub comparisons: Vec<Comparison>,
}

/// What failed with some seeds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Failure {
    /// Section, system and dataset.
    pub place: [String; 3],
    /// With which seeds.
    pub seeds: Vec<u64>,
    /// Why, with the first of them.
    pub why: String,
}

impl Reproduction {
    /// The paper.
    ///
    /// # Errors
    /// Where its name is none.
    pub fn paper(&self) -> Result<Paper> {
        self.paper.parse()
    }

    /// Everything that failed, by section, system and dataset: with which seeds, and why with the first of them.
    pub fn failures(&self) -> Vec<Failure> {
        let mut all: Vec<Failure> = Vec::new();
        for comparison in &self.comparisons {
            for [section, system, dataset, why] in comparison.record.failures() {
                let place = [section, system, dataset].map(String::from);
                match all.iter_mut().find(|failure| failure.place == place) {
                    Some(failure) => failure.seeds.push(comparison.record.seed),
                    None => all.push(Failure {
                        place,
                        seeds: vec![comparison.record.seed],
                        why: why.to_string(),
                    }),
                }
            }
        }
        all
    }

    /// Reads a record that was written as JSON.
    ///
    /// # Errors
    /// Where the file can't be read or is no such record.
    pub fn read(file: &Path) -> Result<Self> {
        let wrong = |fault: String| {
            let expected = "expected the record of `ballmark reproduce` of this version";
            Error::file(file, format!("{fault}; {expected}"))
        };
        let read: Self = serde_json::from_slice(&storage::read_file(file)?)
            .map_err(|fault| wrong(fault.to_string()))?;
        let paper = read.paper().map_err(|fault| wrong(fault.to_string()))?;
        match paper.configuration() {
            Some(_) if !read.comparisons.is_empty() => (),
            _ => return Err(wrong("no comparisons".into())),
        }
        match read.comparisons.iter().position(|c| !is_whole(&c.record)) {
            None => Ok(read),
            Some(number) => Err(wrong(format!(
                "comparison {number} names systems or datasets that it does not have"
            ))),
        }
    }
}

/// Does a record have every system and every dataset that it speaks of?
fn is_whole(record: &ComparisonRecord) -> bool {
    fn section<C, T>(record: &ComparisonRecord, section: &Option<Section<C, T>>) -> bool {
        section.as_ref().is_none_or(|section| {
            section.cells.len() == section.systems.len()
                && section.systems.iter().all(|&s| s < record.systems.len())
                && section
                    .cells
                    .iter()
                    .all(|row| row.len() == record.datasets.len())
        })
    }
    let mut tested = record
        .recognition_tests
        .iter()
        .flat_map(|test| test.systems);
    section(record, &record.standard)
        && section(record, &record.recognition)
        && tested.all(|system| system < record.systems.len())
}

/// Compares as the paper's configuration says, with each seed; the files of the paper lie [unpacked](Paper::unpack) in `folder`.
///
/// Seeds run side by side, on as many threads as there are; each gives what it gives alone. `progress` is called as they go on.
///
/// # Errors
/// As [`compare`], the seed before the message; a usage error of a paper that has no comparison.
pub fn reproduce(
    paper: Paper,
    seeds: &Seeds,
    folder: &Path,
    progress: &mut (dyn FnMut(Progress) + Send),
) -> Result<Reproduction> {
    seeds.check()?;
    let Some(mut asked) = paper.comparison()? else {
        return Err(Error::usage(format!("{paper}: has no comparison")));
    };
    if seeds.toy {
        asked.shrink_to_toy();
        if asked.system.len() > 3 {
            asked.dataset.truncate(2);
            if let Some(recognition) = &mut asked.recognition {
                let kept = |name: &String| asked.dataset.iter().any(|kept| kept.name == *name);
                recognition.responses_of.retain(|name, _| kept(name));
            }
        }
    }
    let folders = Folders {
        configuration: folder,
        models: folder,
        keeps_beliefs: false,
    };
    // How far each seed is, and who is told.
    let report = Mutex::new((vec![0; seeds.count], progress));
    let of_seed = |number: usize| -> Result<Comparison> {
        let seed = seeds.first + number as u64;
        let asked = CompareConfig {
            seed,
            ..asked.clone()
        };
        let compared = compare(&asked, folders, &mut |at| {
            let mut report = report.lock().unwrap_or_else(PoisonError::into_inner);
            let (done, progress) = &mut *report;
            done[number] = at.done;
            progress(Progress {
                done: done.iter().sum(),
                all: at.all * seeds.count,
                now: &format!("seed {seed}, {}", at.now),
            });
        });
        compared.map_err(|fault| fault.context(format!("seed {seed}")))
    };
    let comparisons: Vec<Result<Comparison>> =
        (0..seeds.count).into_par_iter().map(of_seed).collect();
    Ok(Reproduction {
        version: env!("CARGO_PKG_VERSION").to_string(),
        paper: paper.name().to_string(),
        seeds: seeds.clone(),
        comparisons: comparisons.into_iter().collect::<Result<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_out_of_bounds_are_told() {
        for (first, count) in [(1, 0), (1, 1001), (u64::MAX, 2)] {
            let seeds = Seeds {
                first,
                count,
                toy: true,
            };
            let fault = seeds.check().unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains("seeds"),
                "{fault}"
            );
        }
        assert_eq!(Seeds::default().toy().count, 3);
    }

    #[test]
    fn a_paper_without_a_comparison_is_refused() {
        let seeds = Seeds::default();
        let asked = reproduce(Paper::Thrun1998, &seeds, Path::new("."), &mut |_| {});
        assert!(asked.unwrap_err().is_usage());
    }
}
