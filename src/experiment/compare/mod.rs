//! Any systems on any datasets, each asked the same questions: one table instead of one paper a system.
//!
//! Systems are values: a program may add recognisers, localisers and detectors of its own to a [`CompareConfig`], and kinds
//! that configurations may name to a [`Registry`].
//!
//! A system that fails on a dataset has the reason in its cell, and the others go on; where the protocol can't be applied to
//! a dataset, all its cells have the reason. The same configuration gives the same record, with any number of threads; only [`Timing`] differs.

mod beliefs;
mod config;
mod dataset;
mod dataset_config;
mod evaluate;
mod file_names;
mod join;
mod model_cache;
mod progress;
mod record;
mod registry;
mod significance;
mod system;
mod trial_set;

pub use crate::detector::HandMade;
pub use config::CompareConfig;
pub use dataset_config::DatasetConfig;
pub use file_names::file_names;
pub use progress::Progress;
pub use record::{
    Comparison, ComparisonRecord, DatasetRecord, LocalisationSection, Outcome, PairedTest, Section,
    StandardCell, SystemRecord, Timing,
};
pub use registry::Registry;
pub use system::{System, SystemConfig};
pub use trial_set::{TrialOfSet, TrialSet};

use crate::{
    error::{Error, Result},
    experiment::protocol_record::ProtocolRecord,
};
use dataset::LoadedDataset;
use evaluate::Evaluator;
use model_cache::ModelCache;
use progress::ProgressCounter;
use std::{path::Path, time::Instant};

/// Where a comparison finds its files and leaves its models.
#[derive(Debug, Clone, Copy)]
pub struct Folders<'a> {
    /// What file names in the configuration are relative to.
    pub configuration: &'a Path,
    /// Where trained models go; made when there is one.
    pub models: &'a Path,
    /// Are beliefs kept along a few localisation trials, for readers to watch ([`Record::beliefs`](crate::experiment::localisation::Record::beliefs))?
    pub keeps_beliefs: bool,
}

/// Compares all systems on all datasets. `progress` is called as it goes on.
///
/// # Errors
/// Where the configuration makes no sense, or a dataset can't be read or simulated. What fails after that fails in its cell.
pub fn compare(
    config: &CompareConfig,
    folders: Folders,
    progress: &mut dyn FnMut(Progress),
) -> Result<Comparison> {
    let started = Instant::now();
    config.check()?;
    let mut record = ComparisonRecord::new(config)?;
    let steps = config.dataset.len()
        * (2 + config
            .localisation
            .as_ref()
            .map_or(0, |_| config.system.len())
            + record
                .sections()
                .map(|systems| systems.len())
                .sum::<usize>());
    let mut progress_counter = ProgressCounter::new(steps, progress);
    // All of them first: a wrong name is an error before the work, not after half of it.
    let mut loaded = Vec::with_capacity(config.dataset.len());
    for dataset in &config.dataset {
        progress_counter.next(&dataset.name);
        loaded.push(LoadedDataset::open(
            dataset,
            folders.configuration,
            config.seed,
            &config.degraded,
        )?);
    }
    let names = file_names(config.dataset.iter().map(|dataset| dataset.name.as_str()));
    let mut timing = Timing::default();
    for ((dataset, loaded), name) in config.dataset.iter().zip(&loaded).zip(&names) {
        let recording = &loaded.recording;
        let mut dataset_record = DatasetRecord {
            name: dataset.name.clone(),
            source: recording.columns().source.clone(),
            sha256: recording.columns().dataset_sha256.clone(),
            degraded: recording.columns().degraded.clone(),
            protocol: ProtocolRecord::default(),
            snapshots: recording.len(),
            mapping: 0,
            testing: 0,
            notes: loaded.notes.clone(),
        };
        let protocol = loaded.protocol(config);
        if let Ok(protocol) = &protocol {
            dataset_record.protocol = ProtocolRecord::of_protocol(protocol);
            (dataset_record.mapping, dataset_record.testing) =
                (protocol.mapping.len(), protocol.testing.len());
            dataset_record.notes.extend(protocol.notes.iter().cloned());
        }
        record.datasets.push(dataset_record);
        let mut evaluator = Evaluator {
            config,
            folder: folders.configuration,
            keeps_beliefs: folders.keeps_beliefs,
            loaded,
            protocol: &protocol,
            model_cache: ModelCache::new(folders.models, name),
            dataset: &dataset.name,
            progress_counter: &mut progress_counter,
        };
        evaluator.evaluate(&mut record, &mut timing);
        if let Some(dataset) = record.datasets.last_mut() {
            dataset.notes.append(&mut evaluator.model_cache.notes);
        }
    }
    record.recognition_tests = record
        .recognition
        .as_ref()
        .filter(|_| config.dataset.len() > 1)
        .map(significance::paired_tests)
        .unwrap_or_default();
    timing.seconds = started.elapsed().as_secs_f64();
    Ok(Comparison { record, timing })
}

impl ComparisonRecord {
    /// Before anybody was asked.
    fn new(config: &CompareConfig) -> Result<Self> {
        let who = |takes_part: fn(&System) -> bool| -> Vec<usize> {
            let all = config.system.iter().enumerate();
            all.filter(|(_, system)| takes_part(&system.system))
                .map(|(number, _)| number)
                .collect()
        };
        let unreadable = |e: serde_json::Error| Error::work(format!("configuration: {e}"));
        let resolved = serde_json::to_value(config).map_err(unreadable)?;
        Ok(Self {
            version: env!("CARGO_PKG_VERSION").to_string(),
            seed: config.seed,
            truth: resolved["protocol"]["truth"]
                .as_str()
                .unwrap_or_default()
                .to_string(),
            datasets: Vec::new(),
            systems: config
                .system
                .iter()
                .map(|system| SystemRecord {
                    name: system.name.clone(),
                    kind: system.system.kind().to_string(),
                    what: system.system.description().to_string(),
                })
                .collect(),
            standard: Section::new(&config.standard, who(System::takes_trials)),
            localisation: config.localisation.as_ref().map(|_| LocalisationSection {
                config: config.trials(),
                records: Vec::new(),
            }),
            recognition: Section::new(&config.recognition, who(System::recognises)),
            recognition_tests: Vec::new(),
            error_reduction: Section::new(&config.error_reduction, who(System::takes_snapshots)),
            landmarks: Section::new(&config.landmarks, who(System::is_hand_made)),
            config: resolved,
        })
    }

    /// Who is asked in each section.
    fn sections(&self) -> impl Iterator<Item = &Vec<usize>> {
        let standard = self.standard.iter().map(|section| &section.systems);
        let recognition = self.recognition.iter().map(|section| &section.systems);
        let reduction = self.error_reduction.iter().map(|section| &section.systems);
        let landmarks = self.landmarks.iter().map(|section| &section.systems);
        standard
            .chain(recognition)
            .chain(reduction)
            .chain(landmarks)
    }
}

impl<C: Clone, T> Section<C, T> {
    fn new(config: &Option<C>, systems: Vec<usize>) -> Option<Self> {
        config.clone().map(|config| Self {
            config,
            cells: systems.iter().map(|_| Vec::new()).collect(),
            systems,
        })
    }
}

#[cfg(test)]
mod tests;
