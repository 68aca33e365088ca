//! What came of a comparison: enough to draw every table and picture again without the data.

use crate::{
    experiment::{
        error_reduction::{Curve, ErrorReductionConfig},
        landmarks::{LandmarkRecord, LandmarksConfig},
        localisation,
        localise_config::LocaliseConfig,
        protocol_record::ProtocolRecord,
        recognition::{RecognitionConfig, RecognitionRecord},
        standard::{StandardConfig, StandardRecord},
    },
    recording::degraded::Degradation,
};
use serde::{Deserialize, Serialize};

/// A comparison and how long it took. As JSON the record's keys stand at the top, and beside them `timing`, which alone
/// differs from one call to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Comparison {
    /// What came of it: the same bytes for the same call.
    #[serde(flatten)]
    pub record: ComparisonRecord,
    /// How long it took.
    pub timing: Timing,
}

/// What came of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ComparisonRecord {
    /// Version of this crate that compared.
    pub version: String,
    /// The one seed.
    pub seed: u64,
    /// What was true: `pose` or `odometry`.
    pub truth: String,
    /// What was played back.
    pub datasets: Vec<DatasetRecord>,
    /// Who answered.
    pub systems: Vec<SystemRecord>,
    /// The standard experiment.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub standard: Option<Section<StandardConfig, StandardCell>>,
    /// Localisation trials.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub localisation: Option<LocalisationSection>,
    /// Recognition with as many responses as each other.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub recognition: Option<Section<RecognitionConfig, RecognitionRecord>>,
    /// Paired tests between the systems of `recognition`, with two datasets or more.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub recognition_tests: Vec<PairedTest>,
    /// Error reduction against prior uncertainty.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub error_reduction: Option<Section<ErrorReductionConfig, Curve>>,
    /// Hand-made landmarks against the plan.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub landmarks: Option<Section<LandmarksConfig, LandmarkRecord>>,
    /// The resolved configuration.
    pub config: serde_json::Value,
}

/// A dataset of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct DatasetRecord {
    /// What tables call it.
    pub name: String,
    /// Where it comes from, as its file says.
    pub source: Option<String>,
    /// SHA-256 of its file.
    pub sha256: Option<String>,
    /// What its range sensors were degraded by; none: they are as recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub degraded: Option<Degradation>,
    /// What its figures were measured on.
    #[serde(default)]
    pub protocol: ProtocolRecord,
    /// Snapshots in all.
    pub snapshots: usize,
    /// Snapshots that were learned from; none where the protocol could not be set.
    pub mapping: usize,
    /// Snapshots that were tested on.
    pub testing: usize,
    /// What a caption must say of it.
    pub notes: Vec<String>,
}

/// A system of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SystemRecord {
    /// What tables call it.
    pub name: String,
    /// Its kind.
    pub kind: String,
    /// What that is, in a sentence.
    pub what: String,
}

/// One question put to some of the systems on all datasets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Section<C, T> {
    /// How it was put.
    pub config: C,
    /// Who was asked, by their numbers among the systems.
    pub systems: Vec<usize>,
    /// What came of it, `[system][dataset]`.
    pub cells: Vec<Vec<Outcome<T>>>,
}

/// Localisation trials of all systems on all datasets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LocalisationSection {
    /// How they were played.
    pub config: LocaliseConfig,
    /// What came of them, one a dataset; who failed alone is in the record.
    pub records: Vec<Outcome<localisation::Record>>,
}

/// What came of one system on one dataset: never a hole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Outcome<T> {
    /// An answer.
    Done(T),
    /// It failed, or its dataset did.
    Failed {
        /// For whom reads the table.
        why: String,
    },
    /// The question makes no sense here, such as one about a plan where there is none.
    NotAsked,
}

impl<T> Outcome<T> {
    /// The answer, where there is one.
    pub fn done(&self) -> Option<&T> {
        match self {
            Outcome::Done(answer) => Some(answer),
            _ => None,
        }
    }
}

impl<C, T> Section<C, T> {
    /// Reasons of all that failed, `(system, dataset, why)`, the systems by their numbers among all.
    pub fn failures(&self) -> impl Iterator<Item = (usize, usize, &str)> {
        self.systems
            .iter()
            .zip(&self.cells)
            .flat_map(|(&system, row)| {
                row.iter()
                    .enumerate()
                    .filter_map(move |(dataset, cell)| match cell {
                        Outcome::Failed { why } => Some((system, dataset, why.as_str())),
                        _ => None,
                    })
            })
    }

    /// Is there an answer at all?
    pub fn any_done(&self) -> bool {
        self.cells
            .iter()
            .flatten()
            .any(|cell| cell.done().is_some())
    }
}

impl LocalisationSection {
    /// Is there an answer at all?
    pub fn any_done(&self) -> bool {
        let mut done = self.records.iter().filter_map(Outcome::done);
        done.any(|record| !record.results.is_empty())
    }
}

/// A localiser in the standard experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StandardCell {
    /// Places or patterns that it keeps.
    pub places: usize,
    /// What it keeps of one, pose included.
    pub bytes_per_place: usize,
    /// How it did.
    #[serde(flatten)]
    pub record: StandardRecord,
}

/// Student's t-test for paired samples between two systems, over the datasets on which both gave an answer (Duckett &
/// Nehmzow 2000, Table 3).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct PairedTest {
    /// Numbers of the two systems.
    pub systems: [usize; 2],
    /// Datasets.
    pub n: usize,
    /// Student's t; `None` where there are too few datasets, or all differences are the same.
    pub t: Option<f64>,
    /// Two-sided.
    pub p: Option<f64>,
    /// The same, corrected for the number of tests (Holm 1979).
    pub p_holm: Option<f64>,
}

/// Seconds on the machine that compared.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Timing {
    /// Of everything.
    pub seconds: f64,
    /// Of each recogniser on each dataset of `recognition`: one pattern compared with a snapshot, `[system][dataset]`.
    pub seconds_per_match: Vec<Vec<Option<f64>>>,
    /// Of the systems in localisation trials, on each dataset.
    #[serde(default)]
    pub localisation: Vec<localisation::Timing>,
}

impl<C, T> Section<C, T> {
    /// Does the section fit to so many systems and datasets? What doesn't, in words.
    fn check(&self, name: &str, systems: usize, datasets: usize) -> Result<(), String> {
        if let Some(number) = self.systems.iter().find(|number| **number >= systems) {
            return Err(format!("[{name}]: system {number} of {systems}"));
        }
        if self.cells.len() != self.systems.len() {
            let (rows, asked) = (self.cells.len(), self.systems.len());
            return Err(format!(
                "[{name}]: {rows} rows of cells for {asked} systems"
            ));
        }
        match self.cells.iter().find(|row| row.len() != datasets) {
            Some(row) => Err(format!(
                "[{name}]: a row of {} cells for {datasets} datasets",
                row.len()
            )),
            None => Ok(()),
        }
    }
}

impl Comparison {
    /// Do all parts of a record that was read fit together?
    ///
    /// # Errors
    /// The section and what doesn't fit, in words.
    pub fn check(&self) -> Result<(), String> {
        let record = &self.record;
        let (systems, datasets) = (record.systems.len(), record.datasets.len());
        macro_rules! check {
            ($($section:ident),*) => {
                $(if let Some(section) = &record.$section {
                    section.check(stringify!($section), systems, datasets)?;
                })*
            };
        }
        check!(standard, recognition, error_reduction, landmarks);
        if let Some(section) = &record.localisation
            && section.records.len() != datasets
        {
            let records = section.records.len();
            return Err(format!(
                "[localisation]: {records} records for {datasets} datasets"
            ));
        }
        let tests = record
            .recognition_tests
            .iter()
            .flat_map(|test| test.systems);
        if let Some(number) = tests.into_iter().find(|number| *number >= systems) {
            return Err(format!("recognition_tests: system {number} of {systems}"));
        }
        if let Some(section) = &record.error_reduction {
            let curves = section.cells.iter().flatten().filter_map(Outcome::done);
            let mut points = curves.flat_map(|curve| &curve.points);
            if let Some(point) = points.find(|p| !section.config.priors.contains(&p.prior)) {
                let prior = point.prior;
                return Err(format!(
                    "[error_reduction]: a point for {prior}, which is none of its priors"
                ));
            }
        }
        Ok(())
    }
}

impl ComparisonRecord {
    /// Reasons of all failures, in the order of the sections: section, system, dataset, why.
    pub fn failures(&self) -> Vec<[&str; 4]> {
        let mut all = Vec::new();
        macro_rules! section {
            ($name:literal, $section:expr) => {
                for (system, dataset, why) in $section.iter().flat_map(Section::failures) {
                    let (system, dataset) =
                        (&self.systems[system].name, &self.datasets[dataset].name);
                    all.push([$name, system.as_str(), dataset.as_str(), why]);
                }
            };
        }
        section!("standard", self.standard);
        for (dataset, outcome) in self
            .localisation
            .iter()
            .flat_map(|s| s.records.iter().enumerate())
        {
            let name = self.datasets[dataset].name.as_str();
            match outcome {
                Outcome::Failed { why } => {
                    let systems = self.systems.iter();
                    all.extend(systems.map(|s| ["localisation", s.name.as_str(), name, why]));
                }
                Outcome::Done(record) => {
                    let absent = record.left_out.iter();
                    all.extend(absent.map(|l| ["localisation", &*l.name, name, &*l.fault]));
                }
                Outcome::NotAsked => (),
            }
        }
        section!("recognition", self.recognition);
        section!("error_reduction", self.error_reduction);
        section!("landmarks", self.landmarks);
        all
    }

    /// Is there any answer?
    pub fn any_done(&self) -> bool {
        self.standard.as_ref().is_some_and(Section::any_done)
            || self.localisation.iter().any(LocalisationSection::any_done)
            || self.recognition.as_ref().is_some_and(Section::any_done)
            || self.error_reduction.as_ref().is_some_and(Section::any_done)
            || self.landmarks.as_ref().is_some_and(Section::any_done)
    }

    /// What a file of each system may be called: letters, digits, and no two alike.
    pub fn system_file_names(&self) -> Vec<String> {
        super::file_names(self.systems.iter().map(|system| system.name.as_str()))
    }

    /// What a file of each dataset may be called, likewise.
    pub fn file_names(&self) -> Vec<String> {
        super::file_names(self.datasets.iter().map(|dataset| dataset.name.as_str()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_that_fits_to_no_comparison_is_found() {
        let section = |systems: &[usize], cells: &[usize]| Section {
            config: (),
            systems: systems.to_vec(),
            cells: cells.iter().map(|n| vec![Outcome::Done(()); *n]).collect(),
        };
        section(&[0, 2], &[2, 2]).check("standard", 3, 2).unwrap();
        for (systems, cells, part) in [
            (&[3][..], &[2][..], "system 3 of 3"),
            (&[0, 1], &[2], "1 rows of cells for 2 systems"),
            (&[0], &[1], "a row of 1 cells for 2 datasets"),
        ] {
            let fault = section(systems, cells).check("standard", 3, 2).unwrap_err();
            assert!(
                fault.starts_with("[standard]") && fault.contains(part),
                "{fault}"
            );
        }
    }
}
