//! What makes [methods](Method) for localisation trials: of sensor models for the Bayes filter, detectors, recognisers and
//! whole localisers, built-in or of one's own.

use super::{
    kept_evidence::Judged,
    localise_config::LocaliseConfig,
    mapped::Mapped,
    method::{AnswersBy, FeatureAnswers, Method, method},
    once::Once,
    parts::{Parts, TrainingSource},
};
use crate::{
    belief::{Evidence, FeatureMap, Grid, Neighbours, Uncertainty},
    detector::Detector,
    error::{Error, Result},
    learning::objective::MAX_FEATURES,
    localiser::{
        Localiser, PreparedSensorModel, SensorModel,
        responses::ResponseModel,
        sensor_model::{DetectorAnswers, PreparedFeatures},
    },
    model::Model,
    recogniser::Recogniser,
    recording::Recording,
    seed::Seed,
};
use std::sync::Arc;

/// Priors that single snapshots are always judged under.
const USUAL_PRIORS: usize = 2;

/// Everything that does not depend on the method, and what makes methods.
///
/// ```no_run
/// use ballmark::{Model, detector::Detector, experiment::{line_up::line_up, localisation, localise_config::LocaliseConfig,
///     methods::MethodContext, parts::Parts}, recording::npz};
/// # fn my_detector() -> Box<dyn Detector> { Box::new(ballmark::detector::ceiling_light::CeilingLight::default()) }
/// let model = Model::read("corridor-2m.safetensors".as_ref())?;
/// let recording = npz::read("corridor.npz".as_ref())?; // the model's own: the trials run on its test part
/// let parts = Parts::new(&model, &recording, None)?;
/// let config = LocaliseConfig::default();
/// let models = [&model];
/// let context = MethodContext::new(&models, &parts, &config)?;
/// let mut methods = line_up(&context)?;
/// methods.push(context.detector("mine", "my detector", my_detector().as_ref())?);
/// let record = localisation::play(&context, methods, &mut |_| ())?;
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Clone)]
pub struct MethodContext<'a> {
    /// The models of the [default line-up](super::line_up::line_up); elsewhere there may be none.
    pub models: &'a [&'a Model],
    /// Where these models are the sets of one bank: the run that each of their places is of.
    pub bank: Option<&'a [usize]>,
    /// The places that all methods map.
    pub mapped: Mapped,
    /// What they saw and didn't.
    pub parts: &'a Parts<'a>,
    /// How trials are played.
    pub config: &'a LocaliseConfig,
    /// Cells of the belief.
    pub grid: Arc<Grid>,
    /// Training places near every cell.
    pub cells: Arc<Neighbours>,
    /// Priors for the single-snapshot figures: ±2 m, global, and what the models were trained for. None: no such figures are made.
    pub priors: Vec<Uncertainty>,
    /// Are beliefs kept along a few trials, for readers to watch ([`Record::beliefs`](super::localisation::Record::beliefs))?
    pub keeps_beliefs: bool,
    /// What follows from places and parts.
    pub(super) once: Once,
}

impl<'a> MethodContext<'a> {
    /// The methods of these models, the first one's places, map and odometry serving all others.
    ///
    /// # Errors
    /// Where there is no model, the models learned from different parts of a recording, or the configuration makes no sense.
    pub fn new(
        models: &'a [&'a Model],
        parts: &'a Parts<'a>,
        config: &'a LocaliseConfig,
    ) -> Result<Self> {
        let Some(&first) = models.first() else {
            return Err(Error::usage("no model; expected one or more"));
        };
        let same = |model: &&Model| model.pose == first.pose && model.route_m == first.route_m;
        if !models.iter().all(same) {
            return Err(Error::work(
                "the models learned from different places; expected models trained on the same dataset with the same split \
                 (train.split)",
            ));
        }
        let mut context = Self::over(first.into(), parts, config)?;
        context.models = models;
        for model in models {
            if !context.priors.contains(&model.header.prior) {
                context.priors.push(model.header.prior);
            }
        }
        Ok(context)
    }

    /// The methods of a bank whose sets are these models; `run` is that of each training place. Single snapshots are judged under ±2 m
    /// and global priors alone.
    ///
    /// # Errors
    /// As [`MethodContext::new`].
    pub fn of_bank(
        sets: &'a [&'a Model],
        run: &'a [usize],
        parts: &'a Parts<'a>,
        config: &'a LocaliseConfig,
    ) -> Result<Self> {
        let mut context = Self::new(sets, parts, config)?;
        context.priors.truncate(USUAL_PRIORS);
        context.bank = Some(run);
        Ok(context)
    }

    /// The same without a model: methods over these places. Sensor models of one's own answer for the cells of
    /// [`grid`](Self::grid).
    ///
    /// # Errors
    /// Where the places can't carry a grid or a map, or the configuration makes no sense.
    pub fn over(mapped: Mapped, parts: &'a Parts<'a>, config: &'a LocaliseConfig) -> Result<Self> {
        config.check()?;
        let grid = Arc::new(Grid::over(&mapped.places, &config.grid)?);
        let nearness = &mapped.map.nearness;
        let cells = Arc::new(Neighbours::find(&mapped.places, grid.places(), nearness)?);
        Ok(Self {
            models: &[],
            bank: None,
            mapped,
            parts,
            config,
            grid,
            cells,
            priors: vec!["2m".parse()?, Uncertainty::Global],
            keeps_beliefs: false,
            once: Once::default(),
        })
    }

    /// The seed of the run.
    pub fn seed(&self) -> Seed {
        self.config.seed()
    }

    /// What methods learn from besides the models.
    ///
    /// # Errors
    /// Where the recording that the models learned from is not at hand.
    pub fn source(&self) -> Result<&'a TrainingSource<'a>> {
        self.parts.source.as_ref().ok_or_else(|| {
            Error::work("this method learns from the dataset that the model was trained on; expected it (--trained-on)")
        })
    }

    /// How a code of so many features is held against its map: as the configuration says, but by mean field where that asks
    /// for all outcomes and there are too many.
    pub fn evidence_for(&self, features: usize) -> Evidence {
        match self.config.evidence {
            Evidence::Jeffrey if features > MAX_FEATURES => Evidence::MeanField,
            evidence => evidence,
        }
    }

    /// A method that could not be made: the others play, and the table says why this one doesn't.
    pub fn left_out(&self, name: &str, title: &str, fault: &Error) -> Method<'a> {
        method(name, title, None, AnswersBy::Nobody(fault.to_string()))
    }

    /// The filter with odometry alone.
    pub fn odometry(&self, name: &str, title: &str) -> Method<'a> {
        method(name, title, None, AnswersBy::Odometry)
    }

    /// The filter with a sensor model that answers for the cells of [`grid`](Self::grid). Its error reduction by one snapshot is
    /// not known; [`judged_sensor_model`](Self::judged_sensor_model) finds it.
    pub fn sensor_model(
        &self,
        name: &str,
        title: &str,
        sensor: Box<dyn SensorModel + 'a>,
    ) -> Method<'a> {
        method(name, title, None, AnswersBy::Sensor(sensor.into()))
    }

    /// A localiser that has learned. It must answer with places in the plane; where it has no posterior it counts as sure of
    /// its answer, and where it has no answer as knowing nothing. Its error reduction by one snapshot is not known.
    pub fn localiser(
        &self,
        name: &str,
        title: &str,
        localiser: Box<dyn Localiser + 'a>,
    ) -> Method<'a> {
        let bytes = Some(localiser.bytes_per_place()).filter(|&bytes| bytes > 0);
        method(name, title, bytes, AnswersBy::Localiser(localiser))
    }

    /// The filter with a detector, mapped on the training part.
    ///
    /// # Errors
    /// Where the training part is not at hand, or a recording lacks the detector's sensors.
    pub fn detector(&self, name: &str, title: &str, detector: &dyn Detector) -> Result<Method<'a>> {
        let n = detector.features();
        let evidence = self.evidence_for(n);
        let (answers, map) = self.map_of(detector)?;
        self.features(name, title, size_of::<f32>() * n, (answers, map, evidence))
    }

    /// What a detector answers on the run and on the validation part, and its map of the training part.
    ///
    /// # Errors
    /// As [`MethodContext::detector`].
    pub fn map_of(&self, detector: &dyn Detector) -> Result<(FeatureAnswers, FeatureMap)> {
        let source = self.source()?;
        let training = detector.probabilities(&source.recording.select(&source.training)?)?;
        let map = self.mapped.map.clone();
        let map = FeatureMap::new(self.mapped.places.clone(), training.mapv(f64::from), map)?;
        Ok((
            self.answers_of(detector, self.parts.run, Some(&*source.recording))?,
            map,
        ))
    }

    /// What a detector answers to the snapshots that are asked about: of the run, and of what the models learned from, where it is at
    /// hand.
    pub(super) fn answers_of(
        &self,
        detector: &dyn Detector,
        run: &Recording,
        source: Option<&Recording>,
    ) -> Result<FeatureAnswers> {
        let on_run = FeatureAnswers::of_run(detector, run, &self.asked())?;
        let of_validation = |recording| {
            let asked = self.asked_of_validation()?;
            DetectorAnswers::of(detector, recording, &asked)
        };
        Ok(FeatureAnswers {
            source: source.map(of_validation).transpose()?,
            ..on_run
        })
    }

    /// The filter with features: what they are, their map, and how they are held against it; `bytes_per_place` is what the map
    /// keeps of a place.
    ///
    /// # Errors
    /// Where the map lies along a route and the grid in the plane, or the other way round.
    pub fn features(
        &self,
        name: &str,
        title: &str,
        bytes_per_place: usize,
        (answers, map, evidence): (FeatureAnswers, FeatureMap, Evidence),
    ) -> Result<Method<'a>> {
        let judged = match self.priors.is_empty() {
            true => Judged::default(),
            false => {
                let at_candidates = Arc::new(map.at(&self.mapped.places)?);
                self.held_out_by_features(&answers, &at_candidates, evidence)?
            }
        };
        let at_cells = match *map.places() == self.mapped.places {
            true => map.from_neighbours(&self.cells),
            false => map.at(self.grid.places()),
        };
        let map = Arc::new(at_cells?);
        let sensor = PreparedFeatures::new(answers.run, Arc::clone(&map), evidence);
        let on_source = |source| PreparedFeatures::new(source, map, evidence);
        let validation = answers.source.map(on_source);
        Ok(Method {
            held_out: judged.held_out,
            single_snapshots: judged.evidence,
            ready_ms: answers.ready_ms,
            validation: validation.map(|v| Arc::new(v) as Arc<dyn PreparedSensorModel>),
            ..method(
                name,
                title,
                Some(bytes_per_place),
                AnswersBy::PreparedSensor(Arc::new(sensor)),
            )
        })
    }

    /// The filter with a recogniser that has learned: P(response | ξ) is what it answers to the training part, see
    /// [`ResponseModel`].
    ///
    /// # Errors
    /// Where the training part is not at hand, or a recording lacks the recogniser's sensors.
    pub fn recogniser(
        &self,
        name: &str,
        title: &str,
        recogniser: Box<dyn Recogniser>,
    ) -> Result<Method<'a>> {
        let source = self.source()?;
        recogniser.check_channels(source.recording.channels())?;
        recogniser.check_channels(self.parts.run.channels())?;
        let responses = recogniser.respond_all(&source.recording, &source.training);
        let classes: Vec<Option<usize>> = responses.iter().map(|r| r.map(|r| r.class)).collect();
        let map = &self.mapped.map;
        let chance = map.unmodelled_probability;

        // One snapshot, with the training places for cells.
        let places = Arc::new(self.mapped.places.clone());
        let near = Neighbours::find(&places, &places, &map.nearness)?;
        let alone = ResponseModel::new(recogniser, classes, Arc::new(near), chance)?;
        let judged = self.held_out(&alone)?;
        let sensor = alone.at_cells(Arc::clone(&self.cells))?;
        let bytes = Some(size_of::<usize>());
        Ok(Method {
            held_out: judged.held_out,
            single_snapshots: judged.evidence,
            ..method(name, title, bytes, AnswersBy::Sensor(Arc::new(sensor)))
        })
    }

    /// The filter with a sensor model of one's own, given twice: `alone` answers for the training places
    /// ([`Model::places`]), from which its figures for single snapshots are found; `at_cells` for the cells of
    /// [`grid`](Self::grid).
    ///
    /// # Errors
    /// Where the training part is not at hand, or a sensor model fails.
    pub fn judged_sensor_model(
        &self,
        name: &str,
        title: &str,
        alone: &dyn SensorModel,
        at_cells: Box<dyn SensorModel + 'a>,
    ) -> Result<Method<'a>> {
        let judged = self.held_out(alone)?;
        Ok(Method {
            held_out: judged.held_out,
            single_snapshots: judged.evidence,
            ..method(name, title, None, AnswersBy::Sensor(at_cells.into()))
        })
    }
}
