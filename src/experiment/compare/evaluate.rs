//! One dataset, every system, every question.

mod trials;

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
        mapped::Mapped,
        methods::MethodContext,
        parts::Parts,
        protocol::Protocol,
        recognition::{Recognition, RecognitionConfig, recognise, seconds_per_match},
        standard::{self, StandardConfig},
    },
    recogniser::Recogniser,
    score::Binning,
    seed::Seed,
};
use std::{cell::RefCell, collections::HashMap, path::Path};

/// Asks all systems about one dataset.
pub(super) struct Evaluator<'a, 'w> {
    pub config: &'a CompareConfig,
    /// Where files lie that systems name.
    pub folder: &'a Path,
    /// Are beliefs kept along a few trials?
    pub keeps_beliefs: bool,
    pub loaded: &'a LoadedDataset,
    /// The protocol, or why it can't be applied to the dataset.
    pub protocol: &'a Result<Protocol<'a>>,
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
        let systems: Vec<Result<System>> = systems.map(|config| self.ready(config)).collect();
        let trials = self.config.trials().beside(self.folder);
        let parts = self.protocol.as_ref().map(Parts::of_protocol);
        let context = match (&parts, parts.as_ref().ok().and_then(|p| p.source.as_ref())) {
            (Ok(parts), Some(source)) => MethodContext::over(Mapped::of(source), parts, &trials),
            (Err(fault), _) => Err(Error::work(fault.to_string())),
            (Ok(_), None) => Err(Error::work("nothing to learn from")), // a protocol has a mapping part
        };
        let context = context.map(|context| MethodContext {
            keeps_beliefs: self.keeps_beliefs,
            ..context
        });
        if let Some(section) = &mut record.standard {
            // A dataset without room for a trial fails once, not once a system.
            let binning = self.binning(section.config.bin_m);
            let shared = binning.and_then(|binning| match &self.protocol {
                Ok(protocol) => standard::trials(protocol, &section.config).map(|_| binning),
                Err(fault) => Err(Error::work(fault.to_string())),
            });
            self.fill(section, &systems, shared, |this, number, asked, shared| {
                this.standard(number, asked, shared, &context)
            });
        }
        if let Some(section) = &mut record.localisation {
            let played = match &context {
                Ok(context) => self.among_people(&systems, context),
                Err(fault) => Err(Error::work(fault.to_string())),
            };
            let times = played.as_ref().map(|record| record.timing.clone());
            timing.localisation.push(times.unwrap_or_default());
            section.records.push(match played {
                Ok(record) => Outcome::Done(record),
                Err(fault) => Outcome::Failed {
                    why: named(self.dataset, &fault),
                },
            });
        }
        if let Some(section) = &mut record.recognition {
            let binning = self.binning(section.config.bin_m);
            let shared = binning.and_then(|binning| match &self.protocol {
                Ok(protocol) => {
                    let wanted = section.config.wanted(self.dataset, protocol, self.seed())?;
                    Ok((binning, wanted))
                }
                Err(fault) => Err(Error::work(fault.to_string())),
            });
            let tuned: RefCell<HashMap<usize, Box<dyn Recogniser>>> = RefCell::default();
            self.fill(section, &systems, shared, |this, number, asked, shared| {
                let recognition = this.recognition(number, asked, shared)?;
                tuned.borrow_mut().insert(number, recognition.recogniser);
                Ok(Some(recognition.record))
            });
            self.time(&section.systems, tuned.into_inner(), timing);
        }
        if let Some(section) = &mut record.error_reduction {
            self.fill(section, &systems, Ok(()), |this, _, asked, ()| {
                this.error_reduction(asked)
            });
        }
        if let Some(section) = &mut record.landmarks {
            match &self.loaded.world {
                Some(world) => self.fill(section, &systems, Ok(world), |this, _, asked, world| {
                    this.landmarks(asked, world)
                }),
                None => {
                    for row in &mut section.cells {
                        row.push(Outcome::NotAsked);
                    }
                }
            }
        }
    }

    /// Asks one question of all systems that a section asks; the question gets the system's number, and `shared`, what it
    /// needs of the dataset. `None` for an answer: the question makes no sense here.
    fn fill<C, S, T>(
        &mut self,
        section: &mut Section<C, T>,
        systems: &[Result<System>],
        shared: Result<S>,
        mut question: impl FnMut(&mut Self, usize, Asked<C>, &S) -> Result<Option<T>>,
    ) {
        for (&number, row) in section.systems.iter().zip(&mut section.cells) {
            let name = &self.config.system[number].name;
            self.progress_counter
                .next(&format!("{}: {name}", self.dataset));
            let answer = match (self.protocol, &shared, &systems[number]) {
                (Err(fault), ..) | (_, Err(fault), _) => Err(named(self.dataset, fault)),
                (.., Err(fault)) => Err(named(name, fault)),
                (Ok(protocol), Ok(shared), Ok(system)) => {
                    let asked = Asked {
                        protocol,
                        system,
                        config: &section.config,
                    };
                    let answer = question(self, number, asked, shared);
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
    fn ready(&mut self, config: &SystemConfig) -> Result<System> {
        let mut system = config.system.clone().beside(self.folder);
        if let (Some(world), Some(own)) = (system.world(), &self.loaded.world)
            && world.as_os_str().is_empty()
        {
            world.clone_from(&own.file);
        }
        if let (Some(recipe), Some(model), Ok(protocol)) =
            (config.recipe(), system.model(), self.protocol)
        {
            let (progress_counter, dataset) = (&mut *self.progress_counter, self.dataset);
            *model = self
                .model_cache
                .model(&config.name, &recipe, protocol, &mut |at| {
                    let validation = at.best_validation.map_or(String::new(), |reduction| {
                        format!(", validation {:.0} %", 100.0 * reduction)
                    });
                    progress_counter.meanwhile(&format!(
                        "{dataset}: training {}, step {}{validation}",
                        config.name, at.step
                    ));
                })?;
        }
        Ok(system)
    }

    /// Times the recognisers of this dataset, as they were tuned, one after the other.
    fn time(
        &self,
        systems: &[usize],
        tuned: HashMap<usize, Box<dyn Recogniser>>,
        timing: &mut Timing,
    ) {
        timing.seconds_per_match.resize(systems.len(), Vec::new());
        for (number, times) in systems.iter().zip(&mut timing.seconds_per_match) {
            let recogniser = tuned.get(number).zip(self.protocol.as_ref().ok());
            let seconds = recogniser.map(|(r, protocol)| seconds_per_match(protocol, r.as_ref()));
            times.push(seconds);
        }
    }

    fn seed(&self) -> Seed {
        Seed(self.config.seed)
    }

    fn binning(&self, bin_m: f64) -> Result<Binning> {
        match self.protocol {
            Ok(protocol) => protocol.binning(bin_m),
            Err(fault) => Err(Error::work(fault.to_string())),
        }
    }

    fn standard(
        &self,
        number: usize,
        asked: Asked<StandardConfig>,
        binning: &Binning,
        context: &Result<MethodContext>,
    ) -> Result<Option<StandardCell>> {
        let (protocol, seed) = (asked.protocol, self.seed());
        let (recording, mapping) = (&protocol.recording, &protocol.mapping);
        let name = &self.config.system[number].name;
        let localiser = asked
            .system
            .learn_localiser(name, recording, mapping, context, seed)?;
        let localiser = localiser.ok_or_else(|| unfit(asked.system))?;
        localiser.check_channels(recording.channels())?;
        Ok(Some(StandardCell {
            places: localiser.places(),
            bytes_per_place: localiser.bytes_per_place(),
            record: standard::play(protocol, binning, localiser.as_ref(), asked.config, seed)?,
        }))
    }

    fn recognition(
        &mut self,
        number: usize,
        asked: Asked<RecognitionConfig>,
        (binning, wanted): &(Binning, usize),
    ) -> Result<Recognition> {
        let System::Recogniser(recogniser) = asked.system else {
            return Err(unfit(asked.system));
        };
        let (dataset, name) = (self.dataset, &self.config.system[number].name);
        let (seed, progress_counter) = (self.seed(), &mut *self.progress_counter);
        let mut recognition = recognise(
            asked.protocol,
            binning,
            recogniser.as_ref(),
            Some(*wanted),
            asked.config,
            seed,
            &mut |search| progress_counter.meanwhile(&format!("{dataset}: {name}, {search}")),
        )?;
        // Where a model that was trained here lies differs from call to call: the record has the names of the configuration.
        let mut named = self.config.system[number].system.clone();
        let mut tuned = System::Recogniser(recognition.config.clone());
        if let (Some(named), Some(used)) = (named.model(), tuned.model()) {
            *used = std::mem::take(named);
        }
        recognition.record.config = tuned.to_json()?;
        Ok(recognition)
    }

    fn error_reduction(&self, asked: Asked<ErrorReductionConfig>) -> Result<Option<Curve>> {
        let (recording, config) = (&asked.protocol.recording, asked.config);
        let (mapping, testing) = (&asked.protocol.mapping[..], &asked.protocol.testing[..]);
        let places = Places::of(recording);
        let by_detector = |detector: &dyn Detector| {
            let answers = detector.probabilities(recording)?.mapv(f64::from);
            error_reduction::by_probabilities(&places, mapping, testing, answers.view(), config)
        };
        let curve = match asked.system {
            System::Recogniser(recogniser) => {
                let recogniser = recogniser.learn(recording, mapping, self.seed())?;
                recogniser.check_channels(recording.channels())?;
                match recogniser.detector() {
                    Some(detector) => by_detector(detector),
                    None => {
                        let all: Vec<usize> = (0..recording.len()).collect();
                        let responses = recogniser.respond_all(recording, &all);
                        let classes: Vec<Option<usize>> = responses
                            .iter()
                            .map(|response| response.map(|response| response.class))
                            .collect();
                        error_reduction::by_classes(&places, mapping, testing, &classes, config)
                    }
                }
            }
            System::Detector(detector) => by_detector(detector.fit(recording, mapping)?.as_ref()),
            System::Localiser(_) | System::Filter(_) | System::External(_) => {
                Err(unfit(asked.system))
            }
        };
        curve.map(Some)
    }

    /// A detector that the camera gives nothing to look for (lights, where it looks aside) is not asked.
    fn landmarks(
        &self,
        asked: Asked<LandmarksConfig>,
        world: &World,
    ) -> Result<Option<LandmarkRecord>> {
        let mut config = asked.config.clone();
        let name = match asked.system {
            System::Detector(detector) => match detector.hand_made() {
                Some(HandMade::Door(door)) => {
                    config.door = door.clone();
                    HandMade::NAMES[0]
                }
                Some(HandMade::CeilingLight(light)) => {
                    config.ceiling_light = light.clone();
                    HandMade::NAMES[1]
                }
                None => return Err(unfit(asked.system)),
            },
            _ => return Err(unfit(asked.system)),
        };
        let set = world.set.as_deref();
        let protocol = asked.protocol;
        let judged = landmarks::judge(
            &world.building,
            set,
            &protocol.recording,
            &protocol.mapping,
            &protocol.testing,
            &config,
        )?;
        let mut judged = judged.into_iter();
        Ok(judged.find(|record| record.detector == name))
    }
}

/// Who is asked, about what, and how.
struct Asked<'a, C> {
    protocol: &'a Protocol<'a>,
    system: &'a System,
    config: &'a C,
}

/// A fault after the name of the dataset or system that has it, unless it begins with that.
fn named(whose: &str, fault: &Error) -> String {
    let words = fault.to_string();
    match words.starts_with(&format!("{whose}: ")) {
        true => words,
        false => format!("{whose}: {words}"),
    }
}

fn unfit(system: &System) -> Error {
    Error::work(format!("{}: takes no part in this section", system.kind()))
}
