//! What makes [methods](Method) for localisation trials: of sensor models for the Bayes filter, detectors, recognisers and
//! whole localisers, built-in or of one's own.

use super::{
    evidence_tuning, held_out,
    localise_config::LocaliseConfig,
    mapped::Mapped,
    method::{AnswersBy, FeatureAnswers, Method, method},
    parts::{Parts, TrainingSource},
};
use crate::{
    belief::{Belief, Evidence, FeatureMap, Grid, GridMap, Neighbours, Places, Uncertainty},
    detector::Detector,
    error::{Error, Result},
    learning::{error_reduction::ErrorReduction, objective::MAX_FEATURES, training_set::covered},
    localiser::{
        Localiser, PreparedSensorModel, SensorModel, responses::ResponseModel,
        sensor_model::PreparedFeatures,
    },
    model::Model,
    recogniser::Recogniser,
    seed::Seed,
};
use ndarray::{ArrayView1, Axis};
use rayon::prelude::*;
use std::sync::Arc;

/// Snapshots of the validation part that are enough to choose a power by.
const MAX_VALIDATED: usize = 300;

/// Everything that does not depend on the method, and what makes methods.
///
/// ```no_run
/// use ballmark::{Model, detector::Detector, experiment::{line_up::line_up, localisation, localise_config::LocaliseConfig,
///     methods::MethodContext, parts::Parts}, recording::npz};
/// # fn my_detector() -> Box<dyn Detector> { unimplemented!() }
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
    /// Priors for the single-snapshot figures: ±2 m, global, and what the models were trained for.
    pub priors: Vec<Uncertainty>,
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
            mapped,
            parts,
            config,
            grid,
            cells,
            priors: vec!["2m".parse()?, Uncertainty::Global],
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

    /// What a detector answers on the run and on what the models learned from, and its map of the training part.
    ///
    /// # Errors
    /// As [`MethodContext::detector`].
    pub fn map_of(&self, detector: &dyn Detector) -> Result<(FeatureAnswers, FeatureMap)> {
        let source = self.source()?;
        let on_source = detector.probabilities(&source.recording)?;
        let training = on_source.select(Axis(0), &source.training);
        let map = self.mapped.map.clone();
        let map = FeatureMap::new(self.mapped.places.clone(), training.mapv(f64::from), map)?;
        let answers = FeatureAnswers::of_run(detector, self.parts.run)?;
        Ok((answers.with_source(on_source), map))
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
        let held_out = self.judge(&answers, &map.at(&self.mapped.places)?, evidence)?;
        let at_cells = match *map.places() == self.mapped.places {
            true => map.from_neighbours(&self.cells),
            false => map.at(self.grid.places()),
        };
        let map = Arc::new(at_cells?);
        let sensor = PreparedFeatures::new(&answers.run, Arc::clone(&map), evidence);
        let on_source = |source| PreparedFeatures::new(source, map, evidence);
        let validation = answers.source.as_ref().map(on_source);
        Ok(Method {
            held_out,
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
        let held_out = self.held_out(&alone)?;
        let sensor = alone.at_cells(Arc::clone(&self.cells))?;
        let bytes = Some(size_of::<usize>());
        Ok(Method {
            held_out,
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
        Ok(Method {
            held_out: self.held_out(alone)?,
            ..method(name, title, None, AnswersBy::Sensor(at_cells.into()))
        })
    }

    /// Single-snapshot error reductions of a sensor model that answers for the training places, under every prior. The power
    /// of its evidence is that of least error on the validation part.
    fn held_out(&self, alone: &dyn SensorModel) -> Result<Vec<ErrorReduction>> {
        let places = Arc::new(self.mapped.places.clone());
        let anywhere = Belief::uniform(&places)?;
        let covered = self.parts.covered(&self.mapped.places);
        let on_run = alone.prepare(self.parts.run, &covered)?;
        let mut powers = self.tuned_powers(alone)?.into_iter();
        // What fails of one snapshot fails of all: asked once here, then not expected.
        if let Some(&first) = covered.first() {
            self.ask(on_run.as_ref(), first, &anywhere)?;
        }
        self.on_counted(|prior, truths| {
            let power = powers.next().map_or(1.0, |(power, _)| power);
            let at = self.parts.places.select(truths);
            Ok(held_out::by_likelihood(prior, &at, &places, |truth| {
                let answer = self.ask(on_run.as_ref(), truths[truth], &anywhere);
                let mut l = answer.unwrap_or_else(|_| vec![0.0; places.len()]);
                l.iter_mut().for_each(|l| *l *= power);
                l
            }))
        })
    }

    /// ln P(s | candidate) of a snapshot, from a sensor model that draws no random numbers.
    fn ask(
        &self,
        prepared: &dyn PreparedSensorModel,
        snapshot: usize,
        anywhere: &Belief,
    ) -> Result<Vec<f64>> {
        let mut unused = self.seed().stream("not drawn from");
        prepared.log_likelihood(snapshot, anywhere, &mut unused)
    }

    /// Snapshots of the validation part at places that training saw, evenly spaced: as many as settle a constant.
    pub(super) fn validated(&self) -> Result<Vec<usize>> {
        let source = self.source()?;
        let all = Places::of(&source.recording);
        let validation = covered(&all, &source.validation, &self.mapped.places);
        let every = validation.len().div_ceil(MAX_VALIDATED).max(1);
        Ok(validation.into_iter().step_by(every).collect())
    }

    /// Of every prior, the power of a sensor model's evidence that leaves least error of single snapshots of the validation part,
    /// and that error in metres (infinite where nothing can be validated). `alone` answers for the training places.
    pub(super) fn tuned_powers(&self, alone: &dyn SensorModel) -> Result<Vec<(f64, f64)>> {
        let source = self.source()?;
        let (candidates, all) = (
            Arc::new(self.mapped.places.clone()),
            Places::of(&source.recording),
        );
        let (some, anywhere) = (self.validated()?, Belief::uniform(&candidates)?);
        let prepared = alone.prepare(&source.recording, &some)?;
        let known = some.par_iter();
        let known = known.map(|&k| self.ask(prepared.as_ref(), k, &anywhere));
        let known = known.collect::<Result<Vec<_>>>()?;
        Ok(self.powers_of(&some, &known, &all))
    }

    /// The same of ln P(s | candidate) that is known, of `some` snapshots of all that the models learned from, whose places are `all`.
    fn powers_of(&self, some: &[usize], known: &[Vec<f64>], all: &Places) -> Vec<(f64, f64)> {
        let candidates = &self.mapped.places;
        let of_prior = |&prior: &Uncertainty| {
            let counted = held_out::counted(prior, all, some, candidates);
            let rows: Vec<usize> = (0..some.len())
                .filter(|&row| counted.binary_search(&some[row]).is_ok())
                .collect();
            let truths = all.select(&counted);
            evidence_tuning::tuned_power(prior, &truths, candidates, |row| known[rows[row]].clone())
        };
        self.priors.iter().map(of_prior).collect()
    }

    /// Single-snapshot error reductions of features under every prior, with a map of the training places. By the likelihood and by
    /// mean field the power of the evidence is that of least error on the validation part, as of every other sensor model; the
    /// other rules ask for the exact objective, which has none.
    pub(super) fn judge(
        &self,
        answers: &FeatureAnswers,
        at_candidates: &GridMap,
        evidence: Evidence,
    ) -> Result<Vec<ErrorReduction>> {
        let candidates = &self.mapped.places;
        let few = answers.run.ncols() <= MAX_FEATURES;
        let rule = match evidence {
            Evidence::Sampled | Evidence::Jeffrey if few => {
                return self.on_counted(|prior, truths| {
                    let seen = answers.run.select(Axis(0), truths).mapv(f64::from);
                    let truths = self.parts.places.select(truths);
                    held_out::by_features(
                        prior,
                        (&truths, seen.view()),
                        (candidates, at_candidates),
                    )
                });
            }
            Evidence::Likelihood => Evidence::Likelihood,
            _ => Evidence::MeanField,
        };
        let anywhere = Belief::uniform(&Arc::new(candidates.clone()))?;
        let ask = |answers: ArrayView1<f32>| {
            let g: Vec<f64> = answers.iter().copied().map(f64::from).collect();
            let mut unused = self.seed().stream("not drawn from");
            let said = rule.log_likelihood(&g, at_candidates, &anywhere, &mut unused);
            // What is no answer says nothing.
            said.unwrap_or_else(|_| vec![0.0; candidates.len()])
        };
        let mut powers = match (&answers.source, self.parts.source.as_ref()) {
            (Some(on_source), Some(source)) => {
                let some = self.validated()?;
                let known: Vec<_> = some.iter().map(|&k| ask(on_source.row(k))).collect();
                self.powers_of(&some, &known, &Places::of(&source.recording))
            }
            _ => Vec::new(),
        }
        .into_iter();
        self.on_counted(|prior, truths| {
            let power = powers.next().map_or(1.0, |(power, _)| power);
            let at = self.parts.places.select(truths);
            Ok(held_out::by_likelihood(prior, &at, candidates, |truth| {
                let mut l = ask(answers.run.row(truths[truth]));
                l.iter_mut().for_each(|l| *l *= power);
                l
            }))
        })
    }

    /// `score` of every prior and the unseen snapshots that count under it.
    pub(super) fn on_counted(
        &self,
        mut score: impl FnMut(Uncertainty, &[usize]) -> Result<ErrorReduction>,
    ) -> Result<Vec<ErrorReduction>> {
        let covered = self.parts.covered(&self.mapped.places);
        let candidates: Places = self.mapped.places.clone();
        let counted = |prior| held_out::counted(prior, &self.parts.places, &covered, &candidates);
        self.priors
            .iter()
            .map(|&prior| score(prior, &counted(prior)))
            .collect()
    }
}

#[cfg(test)]
mod tests;
