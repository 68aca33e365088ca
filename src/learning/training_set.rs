//! What is learned from: inputs, places and priors of the training part, and of the validation part that stops it.
//!
//! This is the lower level, for benches and for loops of one's own: [`Training`](crate::model::Training) prepares it.

use super::{
    error_reduction::{ErrorReduction, Errors},
    every_pose::{EveryPose, alone},
    problem::{Problem, Workspace},
    recipe::{ObjectiveKind, Recipe},
    start::Start,
};
use crate::{
    belief::{MapConfig, Places},
    detector::{input::Input, net::Weights},
    error::{Error, Result},
    mapping::OccupancyMap,
    recording::{Recording, split::Split, viewpoint::Views},
    seed::Seed,
};
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis, CowArray, Ix2, concatenate};
use rstar::{RTree, primitives::GeomWithData};

/// A snapshot outside the training part counts in a judgement if training saw a place this near …
pub const COVERED_WITHIN_M: f64 = 0.5;
/// … and with a heading this near.
pub const COVERED_WITHIN_RAD: f64 = 0.45;

/// Most truths that a wide code is judged on: cost is truths × places.
const MAX_JUDGED: usize = 2000;

/// The training part, ready for the objective.
pub struct TrainingSet<'a> {
    /// Fitted on the training part.
    pub input: Input,
    /// Normalised inputs, `[snapshot, input]`.
    pub inputs: Array2<f32>,
    /// Where they were seen.
    pub places: Places,
    /// Indices of the training snapshots in the recording.
    pub snapshots: Vec<usize>,
    /// The run of each.
    pub runs: Vec<i64>,
    /// The recording's scans from moved places, where it has scans.
    pub views: Option<Views<'a>>,
    /// What is rendered at every pose, where the map is filled from that.
    pub every_pose: Option<EveryPose>,
    /// How a candidate's map is made of the candidates around it.
    pub map: MapConfig,
    /// The networks before the first step, without the gain.
    pub weights: Weights,
    /// Training snapshots that the objective is judged on, and steps without a draw descend on.
    truths: Vec<usize>,
    problem: Problem,
    /// What stops the training, where the recording allows.
    pub validation_set: Option<ValidationSet>,
}

/// Snapshots that training does not see, at places that it does: their error under the trained map.
pub struct ValidationSet {
    /// Normalised inputs, `[snapshot, input]`: as they are, and where training puts people in the way, once more with people.
    pub inputs: Array2<f32>,
    /// Their indices in the recording, each once.
    snapshots: Vec<usize>,
    problem: Problem,
}

impl<'a> TrainingSet<'a> {
    /// Prepares the training and validation parts of a recording.
    ///
    /// # Errors
    /// Where fewer training snapshots are left than the map has neighbours, or no window holds a second snapshot.
    pub fn prepare(recipe: &Recipe, recording: &'a Recording, split: &Split) -> Result<Self> {
        Self::in_map(recipe, recording, split, None, None)
    }

    /// The same, with scans rendered in a map that was made elsewhere, or for networks that have learned already.
    ///
    /// # Errors
    /// As [`TrainingSet::prepare`], and where the recording's scans can't be rendered, or the sensors or the recipe don't fit to the
    /// networks.
    pub fn in_map(
        recipe: &Recipe,
        recording: &'a Recording,
        split: &Split,
        given: Option<&OccupancyMap>,
        start: Option<&Start>,
    ) -> Result<Self> {
        let all_places = Places::of(recording);
        let places = all_places.select(&split.train);
        recipe.map.nearness.check(places.len())?;
        let mut input = Input::fit(&recipe.input, recording, &split.train)?;
        if let Some(start) = start {
            input = start.input_for(input, recording.channels())?;
        }
        let mut random = Seed(recipe.seed).stream("initial weights");
        let mut weights =
            Weights::random(&recipe.network, input.shape(), recipe.features, &mut random);
        if let Some(start) = start {
            weights = start.weights_for(recipe, weights)?;
        }
        let all_inputs = input.transform(recording)?;
        let every_pose = EveryPose::prepare(recipe, recording, split, &input, given)?;
        let map = match every_pose {
            Some(_) => alone(&recipe.map),
            None => recipe.map.clone(),
        };
        let truths = evenly(places.len(), most_judged(recipe));
        let problem = Problem::reported(recipe, &map, &places.select(&truths), &places)?;
        if problem.window_sizes().iter().all(|&size| size < 2) {
            return Err(Error::work(format!(
                "uncertainty {}: no training snapshot has another one in its window, so there is nothing to distinguish; \
                 expected a wider window or snapshots closer together",
                recipe.uncertainty
            )));
        }
        if !problem.has_prior_error() {
            return Err(Error::work(
                "the training snapshots that could be mistaken for one another were all taken at the same place, so no \
                 mistake costs anything; expected a robot that moves",
            ));
        }
        let validation_set = ValidationSet::prepare(
            recipe,
            &map,
            (&all_places, &all_inputs),
            &places,
            &split.validation,
        )?;
        let people = recipe.augmentation.most_people(every_pose.is_some());
        let validation_set = match validation_set {
            Some(set) if people > 0.0 => {
                let crowded = recording.select(&set.snapshots)?;
                let every: Vec<usize> = (0..crowded.len()).collect();
                let crowded = crowded.with_people(&every, people, Seed(recipe.seed))?;
                Some(set.also(
                    recipe,
                    &map,
                    (&all_places, &places),
                    &input.transform(&crowded)?,
                )?)
            }
            set => set,
        };
        Ok(Self {
            inputs: all_inputs.select(Axis(0), &split.train),
            input,
            places,
            snapshots: split.train.clone(),
            runs: split
                .train
                .iter()
                .map(|&k| recording.columns().run[k])
                .collect(),
            views: Views::of(recording)?,
            every_pose,
            map,
            weights,
            truths,
            problem,
            validation_set,
        })
    }

    /// The objective at some activations of the training part, and its gradient `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn objective<'w>(
        &self,
        workspace: &'w mut Workspace,
        activation: ArrayView2<f32>,
        map_in_objective: bool,
    ) -> Result<(Errors, ArrayViewMut2<'w, f32>)> {
        let truth = self.of_truths(activation);
        let mut gradient = std::mem::take(&mut workspace.both);
        if gradient.dim() != activation.dim() {
            gradient = Array2::zeros(activation.raw_dim());
        }
        let answer =
            self.problem
                .evaluate(workspace, truth.view(), activation, map_in_objective)?;
        gradient.assign(&answer.candidate_gradient);
        if truth.dim() == activation.dim() {
            gradient += &answer.truth_gradient;
        } else {
            for (&k, slope) in self.truths.iter().zip(answer.truth_gradient.rows()) {
                let mut row = gradient.row_mut(k);
                row += &slope;
            }
        }
        let errors = answer.errors;
        workspace.both = gradient;
        Ok((errors, workspace.both.view_mut()))
    }

    /// The objective's question: all truths, all candidates, the stated prior.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// How many truths the objective is the mean of.
    pub fn truths(&self) -> usize {
        self.truths.len()
    }

    /// Inputs of the candidates at the training places: rendered where the map is filled from that, else what was recorded,
    /// `[snapshot, input]`.
    pub fn candidates(&self) -> ArrayView2<'_, f32> {
        match &self.every_pose {
            Some(every_pose) => every_pose.at_training.view(),
            None => self.inputs.view(),
        }
    }

    /// What the training part makes of its own places, with the map that localisation uses: `activation` of what was recorded
    /// there, `candidates` of [`TrainingSet::candidates`].
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn judge(
        &self,
        activation: ArrayView2<f32>,
        candidates: ArrayView2<f32>,
    ) -> Result<ErrorReduction> {
        self.problem
            .judge(self.of_truths(activation).view(), candidates)
    }

    /// The truths' rows of the training part.
    fn of_truths<'v>(&self, activation: ArrayView2<'v, f32>) -> CowArray<'v, f32, Ix2> {
        match self.truths.len() == activation.nrows() {
            true => activation.into(),
            false => activation.select(Axis(0), &self.truths).into(),
        }
    }

    /// The held-out objective: truths are the validation snapshots, the map is what training has made of its places.
    ///
    /// # Errors
    /// Where there are too many features for the exact objective.
    pub fn validate(
        &self,
        validation_set: &ValidationSet,
        truth: ArrayView2<f32>,
        training: ArrayView2<f32>,
    ) -> Result<ErrorReduction> {
        let judged = validation_set.problem.judge(truth, training)?;
        Ok(ErrorReduction {
            snapshots: validation_set.snapshots.len(),
            ..judged
        })
    }
}

/// Truths that a part is judged on; where steps descend on all of the training part, that is judged as a whole.
fn most_judged(recipe: &Recipe) -> usize {
    match (recipe.descent.objective, recipe.descent.truths_per_step) {
        (ObjectiveKind::MeanField, 1..) => MAX_JUDGED,
        _ => usize::MAX,
    }
}

/// At most so many of the numbers below `count`, evenly spaced.
fn evenly(count: usize, most: usize) -> Vec<usize> {
    match count <= most {
        true => (0..count).collect(),
        false => (0..most).map(|i| i * count / most).collect(),
    }
}

impl ValidationSet {
    fn prepare(
        recipe: &Recipe,
        map: &MapConfig,
        (all_places, all_inputs): (&Places, &Array2<f32>),
        places: &Places,
        validation: &[usize],
    ) -> Result<Option<Self>> {
        let covered = covered(all_places, validation, places);
        let judged = evenly(covered.len(), most_judged(recipe));
        let covered: Vec<usize> = judged.into_iter().map(|i| covered[i]).collect();
        let sizes =
            Problem::reported(recipe, map, &all_places.select(&covered), places)?.window_sizes();
        let counted: Vec<usize> = covered
            .into_iter()
            .zip(sizes)
            .filter(|(_, size)| *size > 1)
            .map(|(k, _)| k)
            .collect();
        if counted.is_empty() {
            return Ok(None);
        }
        let problem = Problem::reported(recipe, map, &all_places.select(&counted), places)?;
        if !problem.has_prior_error() {
            return Ok(None); // a reduction of nothing is no number
        }
        Ok(Some(Self {
            inputs: all_inputs.select(Axis(0), &counted),
            snapshots: counted,
            problem,
        }))
    }

    /// The snapshots once more, with other inputs.
    fn also(
        mut self,
        recipe: &Recipe,
        map: &MapConfig,
        (all_places, places): (&Places, &Places),
        inputs: &Array2<f32>,
    ) -> Result<Self> {
        self.inputs = concatenate(Axis(0), &[self.inputs.view(), inputs.view()])
            .map_err(|e| Error::work(format!("inputs of the validation part: {e}")))?;
        let twice = [&self.snapshots[..], &self.snapshots].concat();
        self.problem = Problem::reported(recipe, map, &all_places.select(&twice), places)?;
        Ok(self)
    }
}

/// Those of some snapshots that have a training place within [`COVERED_WITHIN_M`] and [`COVERED_WITHIN_RAD`].
pub fn covered(all: &Places, snapshots: &[usize], training: &Places) -> Vec<usize> {
    let at = |places: &Places, k: usize| match places {
        Places::Route(route) => [route[k], 0.0],
        Places::Plane(poses) => [poses[k].x_m, poses[k].y_m],
    };
    let entry = |t| GeomWithData::new(at(training, t), t);
    let tree = RTree::bulk_load((0..training.len()).map(entry).collect());
    let near = |k: usize, t: usize| {
        all.distance_m(k, training, t) < COVERED_WITHIN_M
            && all.turn_rad(k, training, t) < COVERED_WITHIN_RAD
    };
    let is_covered = |k: &usize| {
        tree.locate_within_distance(at(all, *k), COVERED_WITHIN_M * COVERED_WITHIN_M)
            .any(|found| near(*k, found.data))
    };
    snapshots.iter().copied().filter(is_covered).collect()
}
