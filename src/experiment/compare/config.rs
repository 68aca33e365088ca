//! What is compared with what, as a TOML file says it. A key that nobody knows is an error.

use super::{
    dataset_config::DatasetConfig,
    registry::Registry,
    system::{System, SystemConfig},
};
use crate::{
    error::{Error, Result},
    experiment::{
        error_reduction::ErrorReductionConfig,
        landmarks::LandmarksConfig,
        localise_config::LocaliseConfig,
        protocol::{Mapping, ProtocolConfig},
        recognition::RecognitionConfig,
        standard::StandardConfig,
    },
    recording::{
        Recording,
        degraded::Degraded,
        split::{AUTO_STRETCH_M, ENOUGH_RUNS, SplitConfig, Unit},
    },
    toml_file::TomlFile,
};
use serde::{Deserialize, Serialize};
use std::{
    collections::{BTreeMap, HashSet},
    path::Path,
};

/// Most datasets, and most systems, of one comparison.
const MOST: usize = 100;

/// A comparison: every system on every dataset, and what is asked of them. Each section that is there makes a table.
///
/// From a program, systems may be values of one's own types:
/// `CompareConfig { system: vec![SystemConfig::recogniser("mine", Mine { … })], …, ..Default::default() }`
/// (`examples/own_recogniser.rs`). From a text:
///
/// ```
/// use ballmark::experiment::compare::CompareConfig;
/// let config = CompareConfig::parse(r#"
///     [[dataset]]
///     world = "worlds/duckett1998-b.toml"
///     [[system]]
///     kind = "dead_reckoning"
///     [[system]]
///     kind = "nearest"
///     name = "every 3 m"
///     spacing_m = 3.0
///     [standard]
/// "#)?;
/// assert_eq!(config.dataset[0].name, "duckett1998-b");
/// assert_eq!(config.system[0].name, "dead_reckoning");
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CompareConfig {
    /// The one seed: of learning, trials, permutations and resamples, and of the worlds that name none.
    pub seed: u64,
    /// What is played back.
    pub dataset: Vec<DatasetConfig>,
    /// Who answers.
    pub system: Vec<SystemConfig>,
    /// The sensor that all datasets are seen by; people are in the way of what every section tests on.
    #[serde(skip_serializing_if = "Degraded::is_default")]
    pub degraded: Degraded,
    /// Who maps and who is tested on, and what the truth is.
    pub protocol: ProtocolConfig,
    /// The standard experiment: trials of localisers, and of recognisers without memory (Duckett & Nehmzow 1998, 6).
    pub standard: Option<StandardConfig>,
    /// Thrun's trials: from anywhere, and from a known start (Thrun 1998, 5.2.4).
    pub localisation: Option<LocaliseConfig>,
    /// Recognisers with as many responses as each other (Duckett & Nehmzow 2000).
    pub recognition: Option<RecognitionConfig>,
    /// What one snapshot takes away of a prior uncertainty (Thrun 1998, Fig. 3).
    pub error_reduction: Option<ErrorReductionConfig>,
    /// Hand-made landmarks held against the plan.
    pub landmarks: Option<LandmarksConfig>,
}

/// The file as it stands; systems are made of their tables afterwards, as their kind decides which keys they have.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default = "first_seed")]
    seed: u64,
    #[serde(default)]
    dataset: Vec<DatasetConfig>,
    #[serde(default)]
    system: Vec<BTreeMap<String, toml::Spanned<toml::Value>>>,
    #[serde(default)]
    degraded: Degraded,
    #[serde(default, alias = "stage")]
    protocol: ProtocolConfig,
    standard: Option<StandardConfig>,
    localisation: Option<LocaliseConfig>,
    recognition: Option<RecognitionConfig>,
    error_reduction: Option<ErrorReductionConfig>,
    landmarks: Option<LandmarksConfig>,
}

fn first_seed() -> u64 {
    1
}

impl Default for CompareConfig {
    /// Nothing is compared yet.
    fn default() -> Self {
        Self {
            seed: first_seed(),
            dataset: Vec::new(),
            system: Vec::new(),
            degraded: Degraded::default(),
            protocol: ProtocolConfig::default(),
            standard: None,
            localisation: None,
            recognition: None,
            error_reduction: None,
            landmarks: None,
        }
    }
}

impl CompareConfig {
    /// Reads and checks a file that names built-in kinds.
    ///
    /// # Errors
    /// Where it can't be read, or as [`CompareConfig::parse`]; the message begins with the file's name.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_with(&Registry::built_in(), path)
    }

    /// The same where the file may name kinds of one's own.
    ///
    /// # Errors
    /// As [`CompareConfig::read`].
    pub fn read_with(registry: &Registry, path: &Path) -> Result<Self> {
        Self::from_file(registry, &TomlFile::read(path)?)
    }

    /// The same from a text.
    ///
    /// # Errors
    /// A usage error that names the line, as far as one key or table is at fault: a key that is unknown or of the wrong
    /// type, a value that makes no sense, a system of unknown kind, two of one name, nothing to compare, nothing asked.
    pub fn parse(text: &str) -> Result<Self> {
        Self::parse_with(&Registry::built_in(), text)
    }

    /// The same where the text may name kinds of one's own, which `registry` knows.
    ///
    /// # Errors
    /// As [`CompareConfig::parse`].
    pub fn parse_with(registry: &Registry, text: &str) -> Result<Self> {
        Self::from_file(registry, &TomlFile::from_text(text))
    }

    fn from_file(registry: &Registry, text: &TomlFile) -> Result<Self> {
        let file: File = text.parse()?;
        let system = file.system.into_iter().map(|keys| {
            let at: BTreeMap<String, usize> = keys
                .iter()
                .map(|(key, value)| (key.clone(), text.line_at(value.span().start)))
                .collect();
            let first = at.values().min().copied().unwrap_or(1);
            let keys = keys
                .into_iter()
                .map(|(key, value)| (key, value.into_inner()));
            registry.parse(keys.collect()).map_err(|(key, fault)| {
                let line = key.and_then(|key| at.get(&key)).unwrap_or(&first);
                text.refusal(*line, format!("[[system]]: {fault}"))
            })
        });
        let config = Self {
            seed: file.seed,
            dataset: file.dataset.into_iter().map(DatasetConfig::named).collect(),
            system: system.collect::<Result<_>>()?,
            degraded: file.degraded,
            protocol: file.protocol,
            standard: file.standard,
            localisation: file.localisation,
            recognition: file.recognition,
            error_reduction: file.error_reduction,
            landmarks: file.landmarks,
        };
        config.check().map_err(|fault| text.locate(fault))?;
        Ok(config)
    }

    /// How localisation trials are played: as the section says, with the comparison's seed and people where it names none.
    pub(super) fn trials(&self) -> LocaliseConfig {
        let mut trials = self.localisation.clone().unwrap_or_default();
        trials.seed = trials.seed.or(Some(self.seed));
        trials.people = Some(self.degraded.people.unwrap_or(trials.people()));
        trials
    }

    /// The protocol for a recording. Where it is split in stretches whose length nobody named, they have room for the trials
    /// of `[standard]`: twice their length, or less where the recording is too short for as many stretches as folds.
    pub(super) fn protocol_for(&self, recording: &Recording) -> ProtocolConfig {
        let mut protocol = self.protocol.clone();
        let in_stretches = recording.runs().len() < ENOUGH_RUNS;
        if let (Some(standard), Unit::Auto, true) =
            (&self.standard, protocol.split.unit, in_stretches)
        {
            let travelled = recording.travelled_m();
            let runs = recording.runs().into_iter();
            let total_m: f64 = runs
                .map(|run| travelled[run.end - 1] - travelled[run.start])
                .sum();
            let most_m = total_m / protocol.split.folds.max(1) as f64;
            let length_m = (2.0 * standard.trial_m).min(most_m).max(AUTO_STRETCH_M);
            protocol.split.unit = Unit::Stretch(length_m);
        }
        protocol
    }

    /// The same questions with few trials, resamples and steps: it says whether everything works, and little more.
    pub fn shrink_to_toy(&mut self) {
        if let Some(standard) = &mut self.standard {
            standard.every_s = standard.every_s.max(60.0);
            (standard.permutations, standard.resamples) = (19, 20);
        }
        if let Some(localisation) = &mut self.localisation {
            localisation.trials = localisation.trials.min(8);
            localisation.resamples = 20;
        }
        if let Some(recognition) = &mut self.recognition {
            (recognition.permutations, recognition.resamples) = (19, 20);
        }
        for system in &mut self.system {
            if let Some(mut recipe) = system.recipe() {
                recipe.descent.steps = recipe.descent.steps.min(20);
                system.train = Some(recipe);
            }
        }
    }

    /// # Errors
    /// As [`CompareConfig::parse`], but for what only a text can have.
    pub fn check(&self) -> Result<()> {
        for (what, names) in [
            (
                "dataset",
                self.dataset.iter().map(|d| &d.name).collect::<Vec<_>>(),
            ),
            ("system", self.system.iter().map(|s| &s.name).collect()),
        ] {
            let mut seen = HashSet::new();
            if names.is_empty() || names.len() > MOST {
                return Err(Error::usage(format!(
                    "{} [[{what}]]; expected 1 to {MOST}",
                    names.len()
                )));
            }
            if let Some(twice) = names.iter().find(|name| !seen.insert(**name)) {
                return Err(Error::usage(format!(
                    "two [[{what}]] named `{}`; expected a `name` of its own for each",
                    twice.escape_debug()
                )));
            }
        }
        self.dataset.iter().try_for_each(DatasetConfig::check)?;
        self.system.iter().try_for_each(SystemConfig::check)?;
        let mut systems = self.system.iter();
        let mut datasets = self.dataset.iter();
        if let (Some(system), Some(dataset)) = (
            systems.find(|system| system.needs_worlds()),
            datasets.find(|dataset| dataset.world.is_none()),
        ) {
            return Err(Error::usage(format!(
                "[[system]] `{}`: `world`: none; expected the file of a world, whose walls are the plan, as [[dataset]] `{}` is \
                 not simulated in one",
                system.name.escape_debug(),
                dataset.name.escape_debug()
            )));
        }
        self.degraded.check()?;
        if let Some(localisation) = &self.localisation {
            let people = localisation.people;
            self.degraded.people_or(people, "localisation.people")?;
        }
        self.protocol.check()?;
        let deals = self.protocol.mapping == Mapping::Split;
        if deals && self.protocol.split.validation_every > 0 {
            let own_split = |system: &&SystemConfig| {
                let train = system.train.as_ref();
                train.is_some_and(|recipe| recipe.split != SplitConfig::default())
            };
            if let Some(system) = self.system.iter().find(own_split) {
                return Err(Error::usage(format!(
                    "[[system]] `{}`: train.split: [protocol.split] deals the parts of all systems; expected none, or \
                     protocol.split.validation_every = 0",
                    system.name.escape_debug()
                )));
            }
        }
        self.check_sections()
    }

    /// Every section has somebody to ask.
    fn check_sections(&self) -> Result<()> {
        self.standard
            .as_ref()
            .map_or(Ok(()), StandardConfig::check)?;
        let in_section =
            |e: Error| Error::usage(e.to_string().replace("localise.", "localisation."));
        self.localisation
            .as_ref()
            .map_or(Ok(()), |config| config.check().map_err(in_section))?;
        self.recognition
            .as_ref()
            .map_or(Ok(()), RecognitionConfig::check)?;
        self.error_reduction
            .as_ref()
            .map_or(Ok(()), ErrorReductionConfig::check)?;
        self.landmarks
            .as_ref()
            .map_or(Ok(()), LandmarksConfig::check)?;
        let unknown = |name: &&String| self.dataset.iter().all(|d| d.name != **name);
        let mut named = self.recognition.iter().flat_map(|r| r.responses_of.keys());
        if let Some(name) = named.find(unknown) {
            let names: Vec<&str> = self.dataset.iter().map(|d| d.name.as_str()).collect();
            return Err(Error::usage(format!(
                "recognition.responses_of.{}: no [[dataset]] of that name; expected one of {}",
                name.escape_debug(),
                names.join(", ").escape_debug()
            )));
        }
        type TakesPart = fn(&System) -> bool;
        let sections: [(&str, bool, TakesPart, &str); 5] = [
            (
                "standard",
                self.standard.is_some(),
                System::takes_trials,
                "localiser or recogniser",
            ),
            (
                "localisation",
                self.localisation.is_some(),
                |_| true,
                "system",
            ),
            (
                "recognition",
                self.recognition.is_some(),
                System::recognises,
                "recogniser",
            ),
            (
                "error_reduction",
                self.error_reduction.is_some(),
                System::takes_snapshots,
                "recogniser or detector",
            ),
            (
                "landmarks",
                self.landmarks.is_some(),
                System::is_hand_made,
                "hand-made landmark (door, ceiling_light)",
            ),
        ];
        if sections.iter().all(|(_, asked, ..)| !asked) {
            let names = sections.map(|(name, ..)| format!("[{name}]")).join(", ");
            return Err(Error::usage(format!(
                "nothing is asked of the systems; expected at least one of {names}"
            )));
        }
        for (name, asked, takes_part, whom) in sections {
            if asked && !self.system.iter().any(|system| takes_part(&system.system)) {
                return Err(Error::usage(format!(
                    "[{name}]: no [[system]] that it could ask; expected a {whom}"
                )));
            }
        }
        let default = LandmarksConfig::default();
        if let Some(landmarks) = &self.landmarks
            && (&landmarks.door, &landmarks.ceiling_light)
                != (&default.door, &default.ceiling_light)
        {
            return Err(Error::usage(
                "[landmarks]: constants of a detector; expected them in its [[system]]",
            ));
        }
        if self.landmarks.is_some() && self.dataset.iter().all(|d| d.world.is_none()) {
            return Err(Error::usage(
                "[landmarks]: no [[dataset]] has a `world`; expected a simulated one, whose plan is known",
            ));
        }
        Ok(())
    }
}
