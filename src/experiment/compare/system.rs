//! Who takes part: any member of either registry, and landmarks made by hand.

use crate::{
    detector::{
        Detector,
        ceiling_light::CeilingLight,
        door::{Door, DoorConfig},
    },
    error::{Error, Result},
    learning::Recipe,
    localiser::{self, memoryless::MemorylessConfig},
    recogniser,
    recording::Recording,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A system and what tables call it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SystemConfig {
    /// What tables call it; not said: its kind.
    pub name: String,
    /// Its kind and its constants.
    #[serde(flatten)]
    pub system: System,
    /// How its model is trained, on the mapping part of each dataset, where it needs one and names none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub train: Option<Recipe>,
}

/// Any kind of system with its constants.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum System {
    /// Answers a snapshot.
    Recogniser(recogniser::Config),
    /// Answers as it goes.
    Localiser(localiser::Config),
    /// Sees landmarks that people chose.
    Detector(HandMade),
}

/// Landmarks that people chose, in place of learned ones (Thrun 1998, 5.3).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum HandMade {
    /// Doors, as of Koenig & Simmons (1996).
    Door(DoorConfig),
    /// Ceiling lights, as of King & Weiman (1990).
    CeilingLight(CeilingLight),
}

impl HandMade {
    /// What all of them are called.
    pub const NAMES: [&'static str; 2] = ["door", "ceiling_light"];

    /// What it is called.
    pub fn name(&self) -> &'static str {
        match self {
            HandMade::Door(_) => Self::NAMES[0],
            HandMade::CeilingLight(_) => Self::NAMES[1],
        }
    }

    /// The detector, fitted to the mapping part where it has something to fit.
    ///
    /// # Errors
    /// Where the recording lacks the sensors that it needs.
    pub fn detector(&self, recording: &Recording, mapping: &[usize]) -> Result<Box<dyn Detector>> {
        Ok(match self {
            HandMade::Door(config) => Box::new(Door::fit(config, recording, mapping)?),
            HandMade::CeilingLight(light) => Box::new(light.clone()),
        })
    }
}

impl System {
    /// The kind's name.
    pub fn kind(&self) -> &'static str {
        match self {
            System::Recogniser(config) => config.kind().name(),
            System::Localiser(config) => config.kind().name(),
            System::Detector(hand_made) => hand_made.name(),
        }
    }

    /// What it is, in a sentence.
    pub fn what(&self) -> &'static str {
        match self {
            System::Recogniser(config) => config.kind().what(),
            System::Localiser(config) => config.kind().what(),
            System::Detector(HandMade::Door(_)) => "Doors, as of Koenig & Simmons (1996).",
            System::Detector(HandMade::CeilingLight(_)) => {
                "Ceiling lights, as of King & Weiman (1990)."
            }
        }
    }

    /// As a localiser: a recogniser becomes one without memory.
    pub fn as_localiser(&self) -> Option<localiser::Config> {
        match self {
            System::Recogniser(config) => Some(localiser::Config::Memoryless(MemorylessConfig {
                recogniser: config.clone(),
            })),
            System::Localiser(config) => Some(config.clone()),
            System::Detector(_) => None,
        }
    }

    /// Where it names the file of a trained model: that name, which may be empty.
    pub fn model(&mut self) -> Option<&mut PathBuf> {
        match self {
            System::Recogniser(config) => model_of(config),
            System::Localiser(localiser::Config::Bayes(config)) => Some(&mut config.model),
            System::Localiser(localiser::Config::Memoryless(config)) => {
                model_of(&mut config.recogniser)
            }
            _ => None,
        }
    }

    /// Can it be played trials?
    pub fn takes_trials(&self) -> bool {
        !matches!(self, System::Detector(_))
    }

    /// Does it answer a snapshot with one response?
    pub fn recognises(&self) -> bool {
        matches!(self, System::Recogniser(_))
    }

    /// Does it answer snapshots, one by one?
    pub fn takes_snapshots(&self) -> bool {
        !matches!(self, System::Localiser(_))
    }

    /// Does it see what people chose?
    pub fn is_hand_made(&self) -> bool {
        matches!(self, System::Detector(_))
    }

    /// The same with the files that it names looked for in that folder.
    pub fn beside(mut self, folder: &Path) -> Self {
        let found = |name: &mut PathBuf| {
            if !name.as_os_str().is_empty() {
                *name = folder.join(&name);
            }
        };
        self.model().into_iter().for_each(found);
        if let System::Localiser(localiser::Config::LocalGrid(config)) = &mut self {
            found(&mut config.world);
        }
        self
    }

    fn check(&self) -> Result<()> {
        match self {
            System::Recogniser(config) => config.check(),
            System::Localiser(config) => config.check(),
            System::Detector(HandMade::Door(config)) => config.check(),
            System::Detector(HandMade::CeilingLight(light)) => light.check(),
        }
    }
}

fn model_of(config: &mut recogniser::Config) -> Option<&mut PathBuf> {
    match config {
        recogniser::Config::Ball(config) => Some(&mut config.model),
        _ => None,
    }
}

/// What is wrong in a system's table: the key, where it is one key's fault, and the fault.
type Wrong = (Option<String>, String);

impl SystemConfig {
    /// A system from its table: `kind`, optional `name` and `train`, and the constants of its kind.
    pub(super) fn of_table(mut keys: toml::Table) -> std::result::Result<Self, Wrong> {
        let word = |keys: &mut toml::Table, key: &str| match keys.remove(key) {
            None => Ok(None),
            Some(toml::Value::String(word)) => Ok(Some(word)),
            Some(other) => Err((
                Some(key.to_string()),
                format!("`{key}` is {other}; expected words in quotes"),
            )),
        };
        let kind = word(&mut keys, "kind")?;
        let kind = kind.ok_or_else(|| (None, format!("no `kind`; expected {}", every_kind())))?;
        let name = word(&mut keys, "name")?.unwrap_or_else(|| kind.clone());
        let train = keys.remove("train").map(|table| {
            let recipe = table.try_into::<Recipe>();
            recipe.map_err(|e| {
                (
                    Some("train".to_string()),
                    format!("`train`: {}", e.message()),
                )
            })
        });
        let parse: fn(toml::Table) -> Parsed = if kind.parse::<recogniser::Kind>().is_ok() {
            |table| table.try_into().map(System::Recogniser)
        } else if kind.parse::<localiser::Kind>().is_ok() {
            |table| table.try_into().map(System::Localiser)
        } else if HandMade::NAMES.contains(&kind.as_str()) {
            |table| table.try_into().map(System::Detector)
        } else {
            let fault = format!(
                "no kind `{}`; expected {}",
                kind.escape_debug(),
                every_kind()
            );
            return Err((Some("kind".into()), fault));
        };
        let with_kind = |mut table: toml::Table| {
            table.insert("kind".into(), toml::Value::String(kind.clone()));
            table
        };
        // Every constant has a default, so that each key can be tried alone: that tells which one is at fault.
        for (key, value) in &keys {
            let alone = toml::Table::from_iter([(key.clone(), value.clone())]);
            parse(with_kind(alone)).map_err(|e| (Some(key.clone()), told(&kind, key, &e)))?;
        }
        let system = parse(with_kind(keys)).map_err(|e| (None, format!("{kind}: {e}")))?;
        Ok(Self {
            name,
            system,
            train: train.transpose()?,
        })
    }

    /// # Errors
    /// Where a constant makes no sense, or there is a recipe for what is not trained here.
    pub(super) fn check(&self) -> Result<()> {
        let wrong = |fault: String| {
            let name = self.name.escape_debug();
            Error::usage(format!("[[system]] `{name}`: {fault}"))
        };
        if self.name.trim().is_empty() {
            return Err(Error::usage("[[system]]: `name` is empty; expected words"));
        }
        let mut system = self.system.clone();
        let to_be_trained = match system.model() {
            Some(model) if model.as_os_str().is_empty() => {
                *model = "trained.safetensors".into(); // so that nothing else is amiss
                true
            }
            _ => false,
        };
        if let (Some(_), false) = (&self.train, to_be_trained) {
            let expected =
                "expected `train` only where `kind` is `ball` or `bayes` and no `model` is named";
            return Err(wrong(expected.into()));
        }
        if let Some(recipe) = &self.train {
            recipe.check().map_err(|e| wrong(e.to_string()))?;
            if recipe.split.test_fold.is_some() {
                let fault = "train.split.test_fold: expected none, as only the mapping part is learned from";
                return Err(wrong(fault.into()));
            }
        }
        system.check().map_err(|e| wrong(e.to_string()))
    }

    /// The recipe of the model that it needs and doesn't name.
    pub fn recipe(&self) -> Option<Recipe> {
        let mut system = self.system.clone();
        let unnamed = |model: &mut PathBuf| model.as_os_str().is_empty();
        let needed = system.model().is_some_and(unnamed);
        needed.then(|| self.train.clone().unwrap_or_default())
    }
}

type Parsed = std::result::Result<System, toml::de::Error>;

fn told(kind: &str, key: &str, fault: &toml::de::Error) -> String {
    match fault.message() {
        unknown if unknown.starts_with("unknown field") => format!("{kind}: {unknown}"),
        other => format!("{kind}: `{key}`: {other}"),
    }
}

/// All kinds, for a message.
fn every_kind() -> String {
    let recognisers = recogniser::Kind::ALL.iter().map(|kind| kind.name());
    let localisers = localiser::Kind::ALL.iter().map(|kind| kind.name());
    let all: Vec<&str> = recognisers
        .chain(localisers)
        .chain(HandMade::NAMES)
        .collect();
    format!("one of {}", all.join(", "))
}
