//! Who takes part: the learned filters, and what a user would have without learning.

use super::{
    held_out,
    kernels::{kernels, moves_show},
};
use crate::{
    belief::{Evidence, FeatureMap, Grid, MapConfig, Neighbours, Places, Uncertainty},
    detector::{Detector, input::Input, random_projection::RandomProjection},
    error::{Error, Result},
    geometry::Pose,
    learning::{error_reduction::ErrorReduction, objective::MOST_FEATURES, training_set::covered},
    localiser::{PreparedSensorModel, sensor_model::PreparedFeatures},
    model::Model,
    recording::Recording,
    seed::Seed,
};
use ndarray::{Array2, Axis};
use std::{borrow::Cow, collections::HashSet};

/// Bits of the wide random code: 8 bytes a place.
const WIDE_BITS: usize = 64;

/// Which snapshots a model learned from, and which it never saw.
pub struct Parts<'a> {
    /// The recording to localise in.
    pub run: &'a Recording,
    /// Its places.
    pub places: Places,
    /// Its snapshots that the model never saw.
    pub unseen: Vec<usize>,
    /// Are these the validation part, which stopped the training?
    pub unseen_is_validation: bool,
    /// What the model learned from, where it is at hand: without it there are no baselines.
    pub source: Option<TrainingSource<'a>>,
}

/// The recording that a model learned from.
pub struct TrainingSource<'a> {
    /// The whole recording.
    pub recording: Cow<'a, Recording>,
    /// Snapshots that the weights descended on.
    pub training: Vec<usize>,
    /// Snapshots that stopped them.
    pub validation: Vec<usize>,
}

impl<'a> Parts<'a> {
    /// Finds out which part of `run` the model has not seen. `trained_on` is the dataset it learned from, where that is
    /// another one.
    ///
    /// # Errors
    /// Where `trained_on` is not the dataset that the model names, or one lies along a route and the other doesn't.
    pub fn new(model: &Model, run: &'a Recording, trained_on: Option<Recording>) -> Result<Self> {
        let known = model.header.dataset_sha256.as_deref();
        let is_school =
            |r: &Recording| known.is_some() && r.columns().dataset_sha256.as_deref() == known;
        let source = match trained_on {
            Some(recording) if is_school(&recording) => Some(Cow::Owned(recording)),
            Some(_) => {
                return Err(Error::work(format!(
                    "--trained-on names another dataset than the model learned from (sha256 {})",
                    known.unwrap_or("unknown")
                )));
            }
            None if is_school(run) => Some(Cow::Borrowed(run)),
            None => None,
        };
        refuse_the_way_back(run)?;
        let source = source
            .map(|recording| {
                let split = model.header.recipe.split.split(&recording)?;
                let test = split.test.clone();
                Ok::<_, Error>((
                    TrainingSource {
                        recording,
                        training: split.train,
                        validation: split.validation,
                    },
                    test,
                ))
            })
            .transpose()?;
        let places = Places::of(run);
        if std::mem::discriminant(&places) != std::mem::discriminant(&model.places()) {
            return Err(Error::work(
                "the model's places and the dataset's differ: one lies along a route (array `route`), the other in the plane",
            ));
        }
        if source.as_ref().is_none_or(|_| !is_school(run)) {
            refuse_the_familiar(model, run)?;
        }
        let (unseen, unseen_is_validation) = match &source {
            Some((source, test)) if is_school(run) && test.is_empty() => {
                (source.validation.clone(), true)
            }
            Some((_, test)) if is_school(run) => (test.clone(), false),
            _ => ((0..run.len()).collect(), false),
        };
        if unseen.is_empty() {
            return Err(Error::work(
                "the model saw every snapshot of this dataset; expected another recording, or a model trained with --test-fold",
            ));
        }
        Ok(Self {
            run,
            places,
            unseen,
            unseen_is_validation,
            source: source.map(|(source, _)| source),
        })
    }

    /// Number of those who will take part.
    pub fn methods(&self, model: &Model) -> usize {
        let input = &model.header.recipe.input;
        let narrow = usize::from(model.features() != WIDE_BITS);
        let baselines = |source: &TrainingSource| {
            2 + narrow + usize::from(moves_show(input, &source.recording))
        };
        3 + self.source.as_ref().map_or(0, baselines)
    }

    /// Unseen snapshots at places that training saw.
    pub fn covered(&self, model: &Model) -> Vec<usize> {
        covered(&self.places, &self.unseen, &model.places())
    }
}

/// A recording under another name or checksum may still hold what the model learned from: the same poses to the last bit.
fn refuse_the_familiar(model: &Model, run: &Recording) -> Result<()> {
    let bits = |p: &Pose| [p.x_m.to_bits(), p.y_m.to_bits(), p.heading_rad.to_bits()];
    let learned: HashSet<[u64; 3]> = model.pose.iter().map(bits).collect();
    let known = run
        .poses()
        .iter()
        .filter(|p| learned.contains(&bits(p)))
        .count();
    // One or two may be chance: runs like to begin at (0, 0, 0).
    if known > 2 && known * 20 > run.len() {
        return Err(Error::work(format!(
            "{known} of {} snapshots are at the very places that the model learned from: it is the same recording, \
             made anew; expected an unseen one, or the very dataset file that the model was trained on",
            run.len()
        )));
    }
    Ok(())
}

/// A belief along a route knows no heading, so odometry can only carry it forwards.
fn refuse_the_way_back(run: &Recording) -> Result<()> {
    if !run.goes_one_way() {
        return Err(Error::work(
            "array `route`: it is driven backwards, too; a belief along a route knows one direction only: leave `route` \
             out (training and localising then go by the poses in the plane), or localise in runs of one direction",
        ));
    }
    Ok(())
}

/// Does odometry say just what the true poses say? Then whatever it carries is flattered.
pub fn odometry_is_the_truth(recording: &Recording) -> bool {
    let poses = recording.poses();
    recording.runs().into_iter().all(|run| {
        (run.start + 1..run.end).all(|k| {
            let (a, b) = (
                recording.observation(k - 1).odometry,
                recording.observation(k).odometry,
            );
            let (said, was) = (
                a.displacement_to(&b),
                poses[k - 1].displacement_to(&poses[k]),
            );
            (said.forward_m - was.forward_m).abs() < 1e-9
                && (said.left_m - was.left_m).abs() < 1e-9
                && (said.turn_rad - was.turn_rad).abs() < 1e-9
        })
    })
}

/// Someone who can be asked where the robot is.
pub struct Method {
    /// Key in results.
    pub name: &'static str,
    /// In words, for tables.
    pub title: String,
    /// Of a kernel, as tuned on the validation part for a global prior.
    pub bandwidth: Option<f64>,
    /// What the map keeps of a place besides its pose, in bytes.
    pub bytes_per_place: Option<usize>,
    /// Error reduction of one snapshot on the unseen part, under the priors asked for.
    pub held_out: Vec<ErrorReduction>,
    /// Likelihood of every cell; `None`: odometry alone.
    pub sensor: Option<Box<dyn PreparedSensorModel>>,
}

/// Everything that does not depend on the method.
pub struct BaselineContext<'a> {
    /// The model that was learned.
    pub model: &'a Model,
    /// What it saw and didn't.
    pub parts: &'a Parts<'a>,
    /// Cells of the belief.
    pub grid: &'a Grid,
    /// How answers become likelihoods.
    pub evidence: Evidence,
    /// Priors for the single-snapshot figures.
    pub priors: &'a [Uncertainty],
    /// Of the random planes.
    pub seed: Seed,
}

/// The learned filters first, then the baselines, then odometry alone.
///
/// # Errors
/// Where the run lacks the sensors that the model works from.
pub fn methods(context: &BaselineContext) -> Result<Vec<Method>> {
    let BaselineContext {
        model,
        parts,
        grid,
        evidence,
        ..
    } = context;
    let places = model.places();
    let config = &model.header.recipe.map;
    let cells = Neighbours::find(&places, grid.places(), &config.nearness)?;
    let n = model.features();
    let answers = model.detector().probabilities(parts.run)?;
    let bits = |features: &Array2<f32>| features.mapv(f32::round);
    let map_of_bits = FeatureMap::new(
        places.clone(),
        bits(&model.activation).mapv(f64::from),
        config.clone(),
    )?;
    let rounded = (bits(&answers), map_of_bits, Evidence::MeanField);
    let mut all = vec![
        context.features(
            "learned",
            format!("{n} learned features"),
            size_of::<f32>() * n,
            &cells,
            (answers, model.map()?, *evidence),
        )?,
        context.features(
            "learned_bits",
            format!("{n} learned, as bits"),
            n.div_ceil(8),
            &cells,
            rounded,
        )?,
    ];
    if let Some(source) = &parts.source {
        all.extend(kernels(context, source, &cells)?);
        if n != WIDE_BITS {
            let evidence = if n > MOST_FEATURES {
                Evidence::MeanField
            } else {
                *evidence
            };
            all.push(context.random_bits(source, &cells, config, (n, evidence, "random_bits"))?);
        }
        let wide = (WIDE_BITS, Evidence::MeanField, "random_bits_64");
        all.push(context.random_bits(source, &cells, config, wide)?);
    }
    all.push(Method {
        name: "odometry_only",
        title: "odometry alone".into(),
        bandwidth: None,
        bytes_per_place: None,
        held_out: Vec::new(),
        sensor: None,
    });
    Ok(all)
}

impl BaselineContext<'_> {
    fn random_bits(
        &self,
        source: &TrainingSource,
        cells: &Neighbours,
        map: &MapConfig,
        (bits, evidence, name): (usize, Evidence, &'static str),
    ) -> Result<Method> {
        let input = Input::fit(
            &self.model.header.recipe.input,
            &source.recording,
            &source.training,
        )?;
        let detector = RandomProjection::new(input, bits, self.seed);
        let of_school = detector
            .probabilities(&source.recording)?
            .select(Axis(0), &source.training);
        let map = FeatureMap::new(self.model.places(), of_school.mapv(f64::from), map.clone())?;
        let answers = detector.probabilities(self.parts.run)?;
        self.features(
            name,
            format!("{bits} random bits"),
            bits.div_ceil(8),
            cells,
            (answers, map, evidence),
        )
    }

    /// A method who answers by features: what they are on the run, their map, and how they are held against it.
    fn features(
        &self,
        name: &'static str,
        title: String,
        bytes_per_place: usize,
        cells: &Neighbours,
        (answers, map, evidence): (Array2<f32>, FeatureMap, Evidence),
    ) -> Result<Method> {
        let held_out = self.judge(&answers, &map, evidence)?;
        let sensor = PreparedFeatures::new(&answers, map.from_neighbours(cells)?.into(), evidence);
        Ok(Method {
            name,
            title,
            bandwidth: None,
            bytes_per_place: Some(bytes_per_place),
            held_out,
            sensor: Some(Box::new(sensor)),
        })
    }

    /// Single-snapshot error reductions of features under every prior asked for: by mean field where that is the evidence,
    /// else by the exact objective.
    fn judge(
        &self,
        answers: &Array2<f32>,
        map: &FeatureMap,
        evidence: Evidence,
    ) -> Result<Vec<ErrorReduction>> {
        let candidates = self.model.places();
        let at_candidates = map.at(&candidates)?;
        self.on_counted(|prior, truths| {
            let seen = answers.select(Axis(0), truths).mapv(f64::from);
            let truths = self.parts.places.select(truths);
            let (truths, map) = ((&truths, seen.view()), (&candidates, &at_candidates));
            match evidence {
                Evidence::MeanField => Ok(held_out::by_mean_field(prior, truths, map)),
                _ => held_out::by_features(prior, truths, map),
            }
        })
    }

    pub(super) fn on_counted(
        &self,
        score: impl Fn(Uncertainty, &[usize]) -> Result<ErrorReduction>,
    ) -> Result<Vec<ErrorReduction>> {
        let covered = self.parts.covered(self.model);
        let candidates = self.model.places();
        let counted = |prior| held_out::counted(prior, &self.parts.places, &covered, &candidates);
        self.priors
            .iter()
            .map(|&prior| score(prior, &counted(prior)))
            .collect()
    }
}
