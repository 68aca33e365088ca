//! The front door to learning: a recording and a recipe in, a model and a report out.

use super::{
    fallback::better_random,
    header::{Header, OccupancyHeader, Scores, TrainingRecord},
    remembered::{histories, remembering},
    report::TrainingReport,
    trained_model::Model,
};
use crate::{
    belief::{OdometryMotion, Places, thinning::thinned},
    detector::{
        device::{self, Device},
        net::NetConfig,
    },
    error::{Error, Result},
    learning::{
        Recipe,
        recipe::BeginWith,
        start::Start,
        trainer::{self, Checkpoints, Directive, Progress, StoppedBy, Trained, TrainingIdentity},
        training_set::TrainingSet,
    },
    mapping::OccupancyMap,
    recording::Recording,
};
use ndarray::Axis;
use std::path::{Path, PathBuf};

/// A training to be run: splits the recording, learns, keeps checkpoints and yields a [`Model`].
///
/// ```
/// use ballmark::{learning::{Recipe, trainer::Directive}, model::{Resume, Training}, seed::Seed, world::corridor};
///
/// let config = corridor::CorridorConfig { runs: 4, spacing_m: 1.0, ..Default::default() };
/// let recording = corridor::thrun1998(Seed(1), &config)?;
/// let mut recipe = Recipe { features: 2, ..Recipe::default() };
/// recipe.descent.steps = 40;
///
/// let folder = tempfile::tempdir()?;
/// let learned = Training::new(&recipe, &recording)
///     .checkpoint(folder.path().join("corridor.checkpoint"), Resume::IfSame)
///     .on_progress(|p| match p.step {
///         30 => Directive::Stop, // and keep the best so far
///         _ => Directive::Continue,
///     })
///     .run()?;
/// assert_eq!(learned.report.steps, 30);
/// for note in &learned.report.notes {
///     eprintln!("note: {note}");
/// }
/// learned.model.write(&folder.path().join("corridor.safetensors"))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Training<'a> {
    recipe: &'a Recipe,
    recording: &'a Recording,
    given: Option<&'a OccupancyMap>,
    start: Option<(String, Start)>,
    device: Device,
    checkpoint: Option<(PathBuf, Resume)>,
    on_progress: Box<dyn FnMut(Progress) -> Directive + 'a>,
}

/// What happens to a checkpoint that is there already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Resume {
    /// It is removed: the training starts afresh.
    Never,
    /// The training goes on from it if it is of the same training: same version, data and recipe. The number of steps may
    /// be another one, no less than the checkpoint has; where that changes the learning rate of the steps before, a
    /// [`Note`](super::Note) says so. A checkpoint of any other training is an error, and stays as it is. Where there is none, the
    /// training starts afresh.
    IfSame,
}

/// A model and how its training went.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Learned {
    /// The filters with their map; the header has their scores.
    pub model: Model,
    /// How it went.
    pub report: TrainingReport,
}

impl<'a> Training<'a> {
    /// On the CPU, without checkpoints, unless said otherwise.
    pub fn new(recipe: &'a Recipe, recording: &'a Recording) -> Self {
        Self {
            recipe,
            recording,
            given: None,
            start: None,
            device: device::cpu(),
            checkpoint: None,
            on_progress: Box::new(|_| Directive::Continue),
        }
    }

    /// Renders scans in this map, in the frame of the recording's poses, instead of one that the training scans draw.
    pub fn in_map(mut self, map: &'a OccupancyMap) -> Self {
        self.given = Some(map);
        self
    }

    /// Begins with the networks of this model, pre-trained on other buildings, whatever the recipe's `begin_with` says; `name` is
    /// what reports call it.
    pub fn from_pretrained(mut self, name: &str, model: &Model) -> Self {
        self.start = Some((name.to_string(), model.as_start()));
        self
    }

    /// What it begins with: the model that was named, or one that comes with the program, or nothing.
    fn start_for(&self, recipe: &Recipe, recording: &Recording) -> Result<Option<(String, Start)>> {
        if self.start.is_some() || recipe.begin_with == BeginWith::Random {
            return Ok(self.start.clone());
        }
        let shipped = Model::shipped_for(recipe, recording)?;
        Ok(shipped.map(|(name, model)| (name, model.as_start())))
    }

    /// Where the networks compute.
    pub fn device(mut self, device: &Device) -> Self {
        self.device = device.clone();
        self
    }

    /// Keeps a checkpoint in this file (and, with restarts, in files beside it) every `descent.checkpoint_every` steps and
    /// when cancelled. It stays when the training has ended, so that the model can be put in safety first:
    /// [`remove_checkpoints`](Self::remove_checkpoints) takes it away.
    pub fn checkpoint(mut self, path: impl Into<PathBuf>, resume: Resume) -> Self {
        self.checkpoint = Some((path.into(), resume));
        self
    }

    /// Calls back before every step and after the last. The callback answers whether to go on: nothing at all means yes,
    /// [`Directive::Stop`] ends the training with the best so far, [`Directive::Cancel`] with an error.
    pub fn on_progress<D: Into<Directive>>(
        mut self,
        mut callback: impl FnMut(Progress) -> D + 'a,
    ) -> Self {
        self.on_progress = Box::new(move |progress| callback(progress).into());
        self
    }

    /// Learns.
    ///
    /// # Errors
    /// Where the recipe makes no sense, the recording is not enough to learn from, a checkpoint is damaged, of another
    /// training or can't be written, and where the callback cancels ([`Error::is_cancelled`]).
    pub fn run(mut self) -> Result<Learned> {
        self.recipe.check()?;
        let histories = histories(self.recipe, self.recording)?;
        let (all, own_steps) = (histories.len(), self.most_steps());
        let mut best: Option<Learned> = None;
        let mut on_progress =
            std::mem::replace(&mut self.on_progress, Box::new(|_| Directive::Continue));
        let validation = |learned: &Learned| {
            let score = learned.report.scores.validation;
            score.map(|score| score.error_reduction)
        };
        for (number, back_m) in histories.into_iter().enumerate() {
            let best_before = best.as_ref().and_then(validation);
            let (recipe, recording) = remembering(self.recipe, self.recording, &back_m)?;
            let mut counted_on = |p: Progress| {
                on_progress(Progress {
                    step: number * own_steps + p.step,
                    most_steps: all * own_steps,
                    // What will be kept, of all trainings.
                    best_validation: p
                        .best_validation
                        .map(|own| own.max(best_before.unwrap_or(own))),
                    ..p
                })
            };
            let learned = self.run_once(&recipe, &recording, number, &mut counted_on)?;
            let stops = learned.report.stopped_by == StoppedBy::Callback;
            if best
                .as_ref()
                .is_none_or(|best| validation(&learned) > validation(best))
            {
                best = Some(learned);
            }
            // Where nothing can be validated, inputs stay as they are.
            if stops || best.as_ref().and_then(validation).is_none() {
                break;
            }
        }
        best.ok_or_else(|| Error::work("a training without inputs to try"))
    }

    /// Most steps of one training, all its restarts together.
    fn most_steps(&self) -> usize {
        self.recipe.descent.steps * self.recipe.descent.restarts
    }

    /// Learns from a recording as it is; the checkpoint is that of the training of this number.
    fn run_once(
        &self,
        recipe: &Recipe,
        recording: &Recording,
        number: usize,
        on_progress: &mut dyn FnMut(Progress) -> Directive,
    ) -> Result<Learned> {
        let start = self.start_for(recipe, recording)?;
        if recipe.descent.steps == 0 && start.is_none() {
            return Err(Error::usage(
                "descent.steps = 0: expected at least 1 where networks begin with random weights",
            ));
        }
        let identity = TrainingIdentity::new(
            recipe,
            recording,
            self.given,
            start.as_ref().map(|(_, start)| start),
        )?;
        let split = recipe.split.split(recording)?;
        let training_set = TrainingSet::in_map(
            recipe,
            recording,
            &split,
            self.given,
            start.as_ref().map(|(_, start)| start),
        )?;
        let path = self.checkpoint.as_ref();
        let path = path.map(|(path, resume)| (checkpoint_of(path, number), resume));
        let checkpoints = path.as_ref().map(|(path, resume)| Checkpoints {
            path,
            identity: &identity,
            resume: **resume == Resume::IfSame,
        });
        let trained = trainer::train(
            recipe,
            &training_set,
            &self.device,
            checkpoints.as_ref(),
            on_progress,
        )?;
        let fallback = better_random(recipe, &training_set, &trained)?;
        let (trained, better_than) = match fallback {
            Some((random, learned)) => (random, Some(learned)),
            None => (trained, None),
        };
        let resumed_at = trained.resumed_at;
        let began_with = start.map(|(name, _)| name);
        let mut model = model(
            recipe,
            recording,
            &training_set,
            (&identity, began_with),
            trained,
        );
        // A robot has its sensors; what it remembers it makes of them.
        model.header.channels = self.recording.channels().to_vec();
        if better_than.is_some() {
            model.header.recipe.network = NetConfig::single_layer(); // the shape of what is in the file
        }
        if let Some(record) = &mut model.header.training {
            record.random_better_than = better_than;
        }
        let report = TrainingReport::of(&model, resumed_at)
            .ok_or_else(|| Error::work("a model without a record of its training"))?;
        Ok(Learned { model, report })
    }

    /// The model in a file, with its report, if this very training made it: then there is nothing left to learn.
    ///
    /// # Errors
    /// Where the model is of the same training with another number of steps and there is no checkpoint to go on from: a
    /// training that has come to its end leaves none.
    pub fn finished(&self, file: &Path) -> Result<Option<Learned>> {
        let Ok(model) = Model::read(file) else {
            return Ok(None); // no model yet
        };
        let Some(record) = &model.header.training else {
            return Ok(None); // written before models recorded their training
        };
        if !model.header.updates.is_empty() {
            return Ok(None); // it is not what that training ended with any more
        }
        // The inputs that it chose, if it is of this training.
        let back_m = match self.recipe.input.history_m {
            Some(_) => self.recipe.input.history_m.clone().unwrap_or_default(),
            None => model.history_m().to_vec(),
        };
        let (recipe, recording) = remembering(self.recipe, self.recording, &back_m)?;
        let identity = TrainingIdentity::new(
            &recipe,
            &recording,
            self.given,
            self.start_for(&recipe, &recording)?
                .as_ref()
                .map(|(_, start)| start),
        )?;
        if record.identity == identity.whole {
            let report = TrainingReport::of(&model, None);
            return Ok(report.map(|report| Learned { model, report }));
        }
        let has_checkpoint = self.checkpoint.iter().any(|(path, _)| path.exists());
        if record.identity_but_for_steps == identity.but_for_steps && !has_checkpoint {
            return Err(Error::file(
                file,
                format!(
                    "is the model of the same training of {} steps, which has ended and left no checkpoint to go on \
                     from; train without --resume to learn all {} steps from the start",
                    model.header.recipe.descent.steps, self.recipe.descent.steps
                ),
            ));
        }
        Ok(None)
    }

    /// Removes the checkpoint of this training and those of its restarts.
    ///
    /// # Errors
    /// Where one is there and can't be removed.
    pub fn remove_checkpoints(recipe: &Recipe, path: &Path) -> Result<()> {
        let mut numbers = 0..MOST_TRIED;
        numbers.try_for_each(|number| {
            trainer::remove_checkpoints(&checkpoint_of(path, number), recipe.descent.restarts)
        })
    }
}

/// Trainings on different inputs, at most: with and without the readings of the last metres.
const MOST_TRIED: usize = 2;

/// The checkpoint of the training of this number: at `path` itself for the first.
fn checkpoint_of(path: &Path, number: usize) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    if number > 0 {
        name.push(".history");
    }
    name.into()
}

/// Puts together what training gave.
fn model(
    recipe: &Recipe,
    recording: &Recording,
    training_set: &TrainingSet<'_>,
    (identity, began_with): (&TrainingIdentity, Option<String>),
    trained: Trained,
) -> Model {
    let snapshots = &training_set.snapshots;
    let places = Places::of(recording).select(snapshots);
    let rows = thinned(&places, recipe.map.most_places);
    let (pose, route) = (recording.poses(), recording.route_m());
    let snapshot = |row: &usize| snapshots[*row];
    let every_pose = training_set.every_pose.as_ref();
    let sensed = every_pose.map(|every_pose| &every_pose.sensed);
    Model {
        header: Header {
            crate_version: env!("CARGO_PKG_VERSION").to_string(),
            recipe: recipe.clone(),
            prior: recipe.uncertainty,
            channels: recording.channels().to_vec(),
            dataset_sha256: recording.columns().dataset_sha256.clone(),
            input: training_set.input.clone(),
            activation: trained.weights.activation,
            motion: OdometryMotion::fitted(recording, snapshots),
            evidence_scale: None,
            lost: None,
            occupancy: sensed.map(|sensed| OccupancyHeader {
                cell_m: sensed.map.cell_m(),
                origin_m: sensed.map.origin_m(),
                sensors: sensed.sensors.clone(),
            }),
            scores: Scores {
                train: trained.train,
                validation: trained.validation,
            },
            training: Some(TrainingRecord {
                identity: identity.whole.clone(),
                identity_but_for_steps: identity.but_for_steps.clone(),
                steps: trained.steps,
                evaluations: trained.evaluations,
                began_with,
                stopped_by: trained.stopped_by,
                extended_at: trained.extended_at,
                learned_from: (rows.len() < snapshots.len()).then_some(snapshots.len()),
                random_better_than: None,
            }),
            updates: Vec::new(),
        },
        weights: trained.weights,
        pose: rows.iter().map(|row| pose[snapshot(row)]).collect(),
        route_m: route.map(|route| rows.iter().map(|row| route[snapshot(row)]).collect()),
        activation: match rows.len() < snapshots.len() {
            true => trained.activation.select(Axis(0), &rows),
            false => trained.activation,
        },
        occupancy: sensed.map(|sensed| sensed.map.clone()),
    }
}
