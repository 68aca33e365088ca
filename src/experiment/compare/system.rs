//! Who takes part: recognisers, localisers, detectors and filters with any sensor model, built-in or of one's own.

use crate::{
    detector::DetectorConfig,
    error::{Error, Result},
    experiment::{
        external::{CommandLocaliser, ExternalConfig, Starts},
        filter_config::FilterConfig,
        method::Method,
        method_localiser::FilterLocaliser,
        methods::MethodContext,
        sequences::evidence_scale,
    },
    learning::Recipe,
    localiser::{Localiser, LocaliserConfig, memoryless::AsLocaliser},
    recogniser::RecogniserConfig,
    recording::Recording,
    registry::{self, Constants},
    seed::Seed,
};
use serde::{Serialize, Serializer, ser::Error as _};
use serde_json::Value;
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
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum System {
    /// Answers a snapshot.
    Recogniser(Box<dyn RecogniserConfig>),
    /// Answers as it goes.
    Localiser(Box<dyn LocaliserConfig>),
    /// Says how probable features are, in place of learned ones.
    Detector(Box<dyn DetectorConfig>),
    /// Answers as it goes: the grid Bayes filter with any sensor models.
    Filter(FilterConfig),
    /// Answers as it goes, elsewhere: somebody else's localiser.
    External(ExternalConfig),
}

impl System {
    /// Its constants, whatever it is.
    pub fn constants(&self) -> &dyn Constants {
        match self {
            System::Recogniser(config) => config.as_ref(),
            System::Localiser(config) => config.as_ref(),
            System::Detector(config) => config.as_ref(),
            System::Filter(config) => config,
            System::External(config) => config,
        }
    }

    fn constants_mut(&mut self) -> &mut dyn Constants {
        match self {
            System::Recogniser(config) => config.as_mut(),
            System::Localiser(config) => config.as_mut(),
            System::Detector(config) => config.as_mut(),
            System::Filter(config) => config,
            System::External(config) => config,
        }
    }

    /// The kind's name.
    pub fn kind(&self) -> &str {
        self.constants().kind()
    }

    /// What it is, in a sentence.
    pub fn description(&self) -> &str {
        self.constants().description()
    }

    /// Its constants as JSON, with the key `kind`.
    ///
    /// # Errors
    /// Where a constant has no JSON.
    pub fn to_json(&self) -> Result<Value> {
        match self {
            System::Recogniser(config) => config.to_json(),
            System::Localiser(config) => config.to_json(),
            System::Detector(config) => config.to_json(),
            System::Filter(config) => registry::with_kind(config.kind(), config),
            System::External(config) => registry::with_kind(config.kind(), config),
        }
    }

    /// What it learns from the mapping part, as a localiser: a recogniser becomes one without memory. A filter learns from the
    /// training part of the context, and plays its run. `None` for a detector, and for who answered elsewhere, with no command to run.
    ///
    /// # Errors
    /// Where it can't learn.
    pub fn learn_localiser<'a>(
        &self,
        name: &str,
        recording: &Recording,
        mapping: &[usize],
        context: &Result<MethodContext<'a>>,
        seed: Seed,
    ) -> Result<Option<Box<dyn Localiser + 'a>>> {
        Ok(match self {
            System::Recogniser(config) => {
                let recogniser = config.learn(recording, mapping, seed)?;
                Some(Box::new(AsLocaliser(recogniser)))
            }
            System::Localiser(config) => Some(config.learn(recording, mapping, seed)?),
            System::Filter(config) => {
                let context = context.as_ref().map_err(|e| Error::work(e.to_string()))?;
                let method = config.method(context, name)?;
                Some(Box::new(FilterLocaliser::new(context, method)?))
            }
            System::External(config) => {
                CommandLocaliser::new(config).map(|localiser| Box::new(localiser) as Box<_>)
            }
            System::Detector(_) => None,
        })
    }

    /// Itself in localisation trials: a recogniser as P(response | ξ), a detector with its map, a localiser as it is.
    ///
    /// # Errors
    /// Where it can't learn, or the recording lacks a sensor.
    pub fn method<'a>(&self, context: &MethodContext<'a>, name: &str) -> Result<Method<'a>> {
        let source = context.source()?;
        let (recording, training) = (&source.recording, &source.training);
        match self {
            System::Recogniser(config) => {
                let recogniser = config.learn(recording, training, context.seed())?;
                context.recogniser(name, name, recogniser)
            }
            System::Localiser(config) => {
                let mut mapping = [&training[..], &source.validation].concat();
                mapping.sort_unstable();
                let localiser = config.learn(recording, &mapping, context.seed())?;
                localiser.check_channels(context.parts.run.channels())?;
                // The validation part, which its evidence is tuned on, must not be what it learned from.
                let is_tuned = localiser.with_evidence_scale(1.0).is_some();
                let tuned = is_tuned.then(|| {
                    let alone = config.learn(recording, training, context.seed())?;
                    evidence_scale(&context.localiser(name, name, alone), context)
                });
                let tuned = tuned.transpose()?.flatten();
                Ok(Method {
                    evidence_scale: tuned.map(|tuned| tuned.scale),
                    ..context.localiser(name, name, localiser)
                })
            }
            System::Detector(config) => {
                let detector = config.fit(recording, training)?;
                context.detector(name, name, detector.as_ref())
            }
            System::Filter(config) => config.method(context, name),
            System::External(config) => config.method(context, name),
        }
    }

    /// Where it names the file of a trained model: that name, which may be empty.
    pub fn model(&mut self) -> Option<&mut PathBuf> {
        self.constants_mut().model()
    }

    /// The same with so many times as many particles, and how many it has and had; none where it names no number of them.
    /// It is asked about starts anywhere alone, and not again with other seeds.
    pub(super) fn with_more_particles(&self, times: usize) -> Option<(Self, [usize; 2])> {
        let mut more = self.clone();
        let particles = more.constants_mut().particles()?;
        let before = *particles;
        *particles = before.checked_mul(times)?;
        let both = [*particles, before];
        if let System::External(config) = &mut more {
            config.start = Starts::Unknown;
            config.repeats = 0;
        }
        Some((more, both))
    }

    /// Can it be played trials here?
    pub fn takes_trials(&self) -> bool {
        match self {
            System::External(config) => !config.command.is_empty(),
            System::Detector(_) => false,
            _ => true,
        }
    }

    /// File of the world whose plan it is given, where it is given one.
    pub(super) fn world(&mut self) -> Option<&mut PathBuf> {
        self.constants_mut().world()
    }

    /// Does it answer a snapshot with one response?
    pub fn recognises(&self) -> bool {
        matches!(self, System::Recogniser(_))
    }

    /// Does it answer snapshots, one by one?
    pub fn takes_snapshots(&self) -> bool {
        matches!(self, System::Recogniser(_) | System::Detector(_))
    }

    /// Does it look for landmarks that a plan has?
    pub fn is_hand_made(&self) -> bool {
        matches!(self, System::Detector(config) if config.hand_made().is_some())
    }

    /// The same with the files that it names looked for in that folder.
    pub fn beside(mut self, folder: &Path) -> Self {
        for name in self.constants_mut().files() {
            if !name.as_os_str().is_empty() {
                *name = folder.join(&name);
            }
        }
        self
    }
}

/// Two systems are the same where they have the same kind and constants.
impl PartialEq for System {
    fn eq(&self, other: &Self) -> bool {
        let same_room = std::mem::discriminant(self) == std::mem::discriminant(other);
        same_room && matches!((self.to_json(), other.to_json()), (Ok(a), Ok(b)) if a == b)
    }
}

impl Serialize for System {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        self.to_json()
            .map_err(S::Error::custom)?
            .serialize(serializer)
    }
}

impl SystemConfig {
    /// A system that is to be called so.
    ///
    /// ```
    /// use ballmark::{experiment::compare::{System, SystemConfig}, recogniser::Kind};
    /// let mut nearest = Kind::Nearest.default_config();
    /// let system = SystemConfig::recogniser("nearest", nearest);
    /// assert!(system.system.recognises() && system.system.kind() == "nearest");
    /// ```
    pub fn recogniser(name: &str, config: impl RecogniserConfig + 'static) -> Self {
        Self::new(name, System::Recogniser(Box::new(config)))
    }

    /// The same of a localiser.
    pub fn localiser(name: &str, config: impl LocaliserConfig + 'static) -> Self {
        Self::new(name, System::Localiser(Box::new(config)))
    }

    /// The same of the grid Bayes filter with sensor models.
    pub fn filter(name: &str, config: FilterConfig) -> Self {
        Self::new(name, System::Filter(config))
    }

    /// The same of somebody else's localiser.
    pub fn external(name: &str, config: ExternalConfig) -> Self {
        Self::new(name, System::External(config))
    }

    /// The same of a detector.
    pub fn detector(name: &str, config: impl DetectorConfig + 'static) -> Self {
        Self::new(name, System::Detector(Box::new(config)))
    }

    fn new(name: &str, system: System) -> Self {
        Self {
            name: name.into(),
            system,
            train: None,
        }
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
        if let Some(world) = system.world().filter(|world| world.as_os_str().is_empty()) {
            *world = "world.toml".into(); // that of each dataset
        }
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
        system.constants().check().map_err(|e| wrong(e.to_string()))
    }

    /// Is it given the plan of whichever world a dataset is simulated in?
    pub(super) fn needs_worlds(&self) -> bool {
        let mut system = self.system.clone();
        system
            .world()
            .is_some_and(|world| world.as_os_str().is_empty())
    }

    /// The recipe of the model that it needs and doesn't name.
    pub fn recipe(&self) -> Option<Recipe> {
        let mut system = self.system.clone();
        let unnamed = |model: &mut PathBuf| model.as_os_str().is_empty();
        let needed = system.model().is_some_and(unnamed);
        needed.then(|| self.train.clone().unwrap_or_default())
    }
}
