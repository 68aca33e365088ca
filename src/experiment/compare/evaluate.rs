//! One dataset, every system, every question.

use super::{
    CompareConfig, ComparisonRecord, HandMade, Outcome, Section, StandardCell, System,
    SystemConfig, Timing,
    dataset::{LoadedDataset, World},
    model_cache::ModelCache,
    progress::ProgressCounter,
};
use crate::{
    belief::Places,
    detector::Detector,
    error::{Error, Result},
    experiment::{
        error_reduction::{self, Curve, ErrorReductionConfig},
        landmarks::{self, LandmarkRecord, LandmarksConfig},
        protocol::Protocol,
        recognition::{RecognitionConfig, RecognitionRecord, recognise, seconds_per_match},
        standard::{self, StandardConfig},
    },
    localiser,
    model::Model,
    recogniser,
    score::Binning,
    seed::Seed,
};
use std::path::Path;

/// Asks all systems about one dataset.
pub(super) struct Evaluator<'a, 'w> {
    pub config: &'a CompareConfig,
    /// Where files lie that systems name.
    pub folder: &'a Path,
    pub loaded: &'a LoadedDataset,
    /// The protocol, or why it can't be set.
    pub protocol: Result<Protocol<'a>>,
    pub model_cache: ModelCache<'a>,
    pub dataset: &'a str,
    pub progress_counter: &'a mut ProgressCounter<'w>,
}

impl Evaluator<'_, '_> {
    /// Adds this dataset's cell to every row of every section.
    pub fn evaluate(&mut self, record: &mut ComparisonRecord, timing: &mut Timing) {
        self.progress_counter
            .next(&format!("{}: training", self.dataset));
        let systems = self.config.system.iter();
        let systems: Vec<Result<System>> = systems.map(|told| self.ready(told)).collect();
        if let Some(section) = &mut record.standard {
            let binning = self.binning(section.config.bin_m);
            self.fill(section, &systems, binning, Self::standard);
        }
        if let Some(section) = &mut record.recognition {
            let binning = self.binning(section.config.bin_m);
            let shared = binning.and_then(|binning| match &self.protocol {
                Ok(protocol) => Ok((binning, section.config.wanted(protocol, self.seed())?)),
                Err(fault) => Err(Error::work(fault.to_string())),
            });
            self.fill(section, &systems, shared, Self::recognition);
            self.time(section, &systems, timing);
            // Where a model that was trained here lies differs from call to call: what the configuration says is kept.
            for (&number, cells) in section.systems.iter().zip(&mut section.cells) {
                if let Some(Outcome::Done(done)) = cells.last_mut() {
                    self.forget_files(number, done);
                }
            }
        }
        if let Some(section) = &mut record.error_reduction {
            self.fill(section, &systems, Ok(()), Self::error_reduction);
        }
        if let Some(section) = &mut record.landmarks {
            match &self.loaded.world {
                Some(world) => self.fill(section, &systems, Ok(world), Self::landmarks),
                None => {
                    for row in &mut section.cells {
                        row.push(Outcome::NotAsked);
                    }
                }
            }
        }
    }

    /// Asks one question of all systems that a section asks; `shared` is what the question needs of the dataset. A question
    /// without an answer makes no sense here.
    fn fill<C, S, T>(
        &mut self,
        section: &mut Section<C, T>,
        systems: &[Result<System>],
        shared: Result<S>,
        question: impl Fn(&Self, &Protocol, &System, &C, &S) -> Result<Option<T>>,
    ) {
        for (&number, row) in section.systems.iter().zip(&mut section.cells) {
            let name = &self.config.system[number].name;
            self.progress_counter
                .next(&format!("{}: {name}", self.dataset));
            let answer = match (&self.protocol, &shared, &systems[number]) {
                (Err(fault), ..) | (_, Err(fault), _) => Err(named(self.dataset, fault)),
                (.., Err(fault)) => Err(named(name, fault)),
                (Ok(protocol), Ok(shared), Ok(system)) => {
                    let answer = question(self, protocol, system, &section.config, shared);
                    answer.map_err(|fault| named(name, &fault))
                }
            };
            row.push(match answer {
                Ok(Some(answer)) => Outcome::Done(answer),
                Ok(None) => Outcome::NotAsked,
                Err(why) => Outcome::Failed { why },
            });
        }
    }

    /// A system with its files found, and its model trained where it names none.
    fn ready(&mut self, told: &SystemConfig) -> Result<System> {
        let mut system = told.system.clone().beside(self.folder);
        if let (Some(recipe), Some(model), Ok(protocol)) =
            (told.recipe(), system.model(), &self.protocol)
        {
            let (progress_counter, dataset) = (&mut *self.progress_counter, self.dataset);
            *model = self
                .model_cache
                .model(&told.name, &recipe, protocol, &mut |at| {
                    let validation = at.best_validation.map_or(String::new(), |reduction| {
                        format!(", validation {:.0} %", 100.0 * reduction)
                    });
                    progress_counter.meanwhile(&format!(
                        "{dataset}: training {}, step {}{validation}",
                        told.name, at.step
                    ));
                })?;
        }
        Ok(system)
    }

    /// Times the recognisers of this dataset, one after the other.
    fn time(
        &self,
        section: &Section<RecognitionConfig, RecognitionRecord>,
        systems: &[Result<System>],
        timing: &mut Timing,
    ) {
        timing
            .seconds_per_match
            .resize(section.systems.len(), Vec::new());
        let rows = section.systems.iter().zip(&section.cells);
        for ((&number, cells), times) in rows.zip(&mut timing.seconds_per_match) {
            let tuned = cells.last().and_then(Outcome::done);
            times.push(tuned.and_then(|tuned| self.seconds_per_match(&systems[number], tuned)));
        }
    }

    fn seed(&self) -> Seed {
        Seed(self.config.seed)
    }

    fn binning(&self, bin_m: f64) -> Result<Binning> {
        match &self.protocol {
            Ok(protocol) => protocol.binning(bin_m),
            Err(fault) => Err(Error::work(fault.to_string())),
        }
    }

    fn standard(
        &self,
        protocol: &Protocol,
        system: &System,
        config: &StandardConfig,
        binning: &Binning,
    ) -> Result<Option<StandardCell>> {
        let localiser = system.as_localiser().ok_or_else(|| unfit(system))?;
        let learned = localiser::learn(
            &localiser,
            &protocol.recording,
            &protocol.mapping,
            self.seed(),
        )?;
        let localiser = learned.as_localiser();
        localiser.check_channels(protocol.recording.channels())?;
        Ok(Some(StandardCell {
            places: localiser.places(),
            bytes_per_place: localiser.bytes_per_place(),
            record: standard::play(protocol, binning, localiser, config, self.seed())?,
        }))
    }

    fn recognition(
        &self,
        protocol: &Protocol,
        system: &System,
        config: &RecognitionConfig,
        (binning, wanted): &(Binning, usize),
    ) -> Result<Option<RecognitionRecord>> {
        match system {
            System::Recogniser(recogniser) => recognise(
                protocol,
                binning,
                recogniser,
                Some(*wanted),
                config,
                self.seed(),
            )
            .map(Some),
            _ => Err(unfit(system)),
        }
    }

    /// Seconds for one pattern to be compared with a snapshot, by a recogniser as it was tuned.
    fn seconds_per_match(&self, system: &Result<System>, tuned: &RecognitionRecord) -> Option<f64> {
        let (Ok(protocol), Ok(System::Recogniser(_))) = (&self.protocol, system) else {
            return None;
        };
        let (recording, mapping) = (&protocol.recording, &protocol.mapping);
        let learned = recogniser::learn(&tuned.config, recording, mapping, self.seed()).ok()?;
        Some(seconds_per_match(protocol, learned.as_recogniser()))
    }

    /// Gives the files in a tuned recogniser the names that the configuration gives them.
    fn forget_files(&self, number: usize, done: &mut RecognitionRecord) {
        let mut told = self.config.system[number].system.clone();
        let mut tuned = System::Recogniser(done.config.clone());
        if let (Some(named), Some(used)) = (told.model(), tuned.model()) {
            *used = std::mem::take(named);
        }
        if let System::Recogniser(config) = tuned {
            done.config = config;
        }
    }

    fn error_reduction(
        &self,
        protocol: &Protocol,
        system: &System,
        config: &ErrorReductionConfig,
        _: &(),
    ) -> Result<Option<Curve>> {
        let recording = &protocol.recording;
        let places = Places::of(recording);
        let (mapping, testing) = (&protocol.mapping[..], &protocol.testing[..]);
        let by_detector = |detector: &dyn Detector| {
            let answers = detector.probabilities(recording)?.mapv(f64::from);
            error_reduction::by_probabilities(&places, mapping, testing, answers.view(), config)
        };
        let curve = match system {
            // Its features as they are, not the number of a pattern (T98 eq. 32).
            System::Recogniser(recogniser::Config::Ball(ball)) => {
                by_detector(&Model::read(&ball.model)?.detector())
            }
            System::Recogniser(recogniser) => {
                let learned = recogniser::learn(recogniser, recording, mapping, self.seed())?;
                let recogniser = learned.as_recogniser();
                recogniser.check_channels(recording.channels())?;
                let all: Vec<usize> = (0..recording.len()).collect();
                let responses = recogniser.respond_all(recording, &all);
                let classes: Vec<Option<usize>> = responses
                    .iter()
                    .map(|said| said.map(|said| said.class))
                    .collect();
                error_reduction::by_classes(&places, mapping, testing, &classes, config)
            }
            System::Detector(hand_made) => {
                by_detector(hand_made.detector(recording, mapping)?.as_ref())
            }
            System::Localiser(_) => Err(unfit(system)),
        };
        curve.map(Some)
    }

    /// A detector that the camera gives nothing to look for (lights, where it looks aside) is not asked.
    fn landmarks(
        &self,
        protocol: &Protocol,
        system: &System,
        config: &LandmarksConfig,
        world: &&World,
    ) -> Result<Option<LandmarkRecord>> {
        let System::Detector(hand_made) = system else {
            return Err(unfit(system));
        };
        let mut config = config.clone();
        match hand_made {
            HandMade::Door(door) => config.door = door.clone(),
            HandMade::CeilingLight(light) => config.ceiling_light = light.clone(),
        }
        let set = world.set.as_deref();
        let (mapping, testing) = (&protocol.mapping, &protocol.testing);
        let building = &world.building;
        let judged = landmarks::judge(
            building,
            set,
            &protocol.recording,
            mapping,
            testing,
            &config,
        )?;
        let mut judged = judged.into_iter();
        Ok(judged.find(|record| record.detector == hand_made.name()))
    }
}

/// A fault and whose it is, unless it says so itself.
fn named(whose: &str, fault: &Error) -> String {
    let words = fault.to_string();
    match words.starts_with(&format!("{whose}: ")) {
        true => words,
        false => format!("{whose}: {words}"),
    }
}

fn unfit(system: &System) -> Error {
    Error::work(format!("{}: can't be asked this", system.kind()))
}
