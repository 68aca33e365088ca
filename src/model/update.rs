//! Learning that goes on: a model takes in newer snapshots of its building.
//!
//! Thrun (1998, section 7): "after the initial training phase, learning is discontinued. If the environment changes, it is desirable
//! that the localization routines adapt to the changes." The map forgets (file `forgetting.rs`) and is extended; then the
//! networks go on with the same objective on what is left of the old snapshots and on the new ones, a few steps from where they
//! are. Of the new snapshots one stretch in five is kept back from these steps, and judges them: weights that are worse there than
//! before are not kept. All of them come into the map.

use super::{
    forgetting::remembered,
    header::{OccupancyHeader, UpdateRecord},
    memory::Memory,
    trained_model::Model,
    update_config::UpdateConfig,
};
use crate::{
    belief::Places,
    detector::{Detector, device},
    error::{Error, Result},
    learning::{
        Recipe,
        every_pose::EveryPose,
        start::Start,
        trainer::{self, Directive, Progress},
        training_set::TrainingSet,
    },
    recording::{
        Recording,
        split::{AUTO_STRETCH_M, Split, SplitConfig, Unit},
    },
    seed::Seed,
};
use ndarray::{Axis, concatenate};

/// One stretch in so many of the new snapshots is kept back, …
const KEPT_BACK: usize = 5;
/// … the middle one of them.
const MIDDLE: usize = KEPT_BACK / 2;

/// An updated model.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Updated {
    /// The model; the last of its header's `updates` tells of this one.
    pub model: Model,
    /// What its map is made of now; none where the old snapshots were not at hand.
    pub memory: Option<Memory>,
}

/// Updates a model with labelled snapshots of runs that came after what it knows, in the frame of its map.
///
/// Without a `memory` the map alone can be updated, of a model whose map is filled from visits.
///
/// ```
/// use ballmark::{Recipe, Seed, Training, model::{Memory, UpdateConfig, update}, world::corridor};
/// let config = corridor::CorridorConfig { runs: 4, spacing_m: 1.0, ..Default::default() };
/// let (yesterday, today) = (corridor::thrun1998(Seed(1), &config)?, corridor::thrun1998(Seed(2), &config)?);
/// let mut recipe = Recipe { features: 1, uncertainty: "5m".parse()?, ..Recipe::default() };
/// recipe.descent.steps = 40;
/// let model = Training::new(&recipe, &yesterday).run()?.model;
/// let memory = Memory::of(&model, &yesterday)?;
/// let config = UpdateConfig { steps: 10, ..UpdateConfig::default() };
/// let updated = update(&model, Some(&memory), &today, &config, &mut |_| {})?;
/// let record = &updated.model.header.updates[0];
/// assert_eq!(record.added, today.len());
/// assert_eq!(updated.model.pose.len(), model.pose.len() - record.forgotten + record.added);
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where a constant makes no sense, the new snapshots lack a sensor of the model or lie along no route where its places do, and where
/// steps or a map at every pose need the old snapshots and there are none.
pub fn update(
    model: &Model,
    memory: Option<&Memory>,
    labelled: &Recording,
    config: &UpdateConfig,
    on_progress: &mut dyn FnMut(Progress),
) -> Result<Updated> {
    config.check()?;
    if memory.is_none() && (config.steps > 0 || model.occupancy.is_some()) {
        return Err(Error::usage(match config.steps {
            0 => {
                "the model's map is drawn by the scans that it learned from: expected these, to draw it anew"
            }
            _ => {
                "steps of training need the snapshots that the model learned from: expected these, or 0 steps"
            }
        }));
    }
    let seen = model.seen_in(labelled)?;
    let new = match model.places() {
        Places::Plane(_) => seen.into_owned().in_the_plane(),
        Places::Route(_) => seen.into_owned(),
    };
    let new_places = Places::of(&new);
    if std::mem::discriminant(&new_places) != std::mem::discriminant(&model.places()) {
        return Err(Error::work(
            "the model's places lie along a route, the new snapshots' do not; expected both in one frame",
        ));
    }
    let every: Vec<usize> = (0..new.len()).collect();
    let runs = new.run_numbers(&every);
    let mut random = Seed(config.seed).stream("forgetting");
    let kept = remembered(
        &model.places(),
        &new_places,
        &runs,
        config.half_life,
        &mut random,
    );
    let both = memory.map(|memory| joined(memory.recording(), &kept, &new));
    let both = both.transpose()?;
    let mut updated = model.clone();
    let mut record = UpdateRecord {
        crate_version: env!("CARGO_PKG_VERSION").to_string(),
        dataset_sha256: labelled.columns().dataset_sha256.clone(),
        config: config.clone(),
        added: new.len(),
        forgotten: model.pose.len() - kept.len(),
        steps: 0,
        validation: None,
    };
    let recipe = finer(&model.header.recipe, config);
    if let Some(both) = both.as_ref().filter(|_| config.steps > 0) {
        let split = kept_back(both, kept.len());
        let start = Start {
            same_sensors: true,
            ..model.as_start()
        };
        let set = TrainingSet::in_map(&recipe, both, &split, None, Some(&start))?;
        let mut first = None;
        let mut watch = |progress: Progress| {
            first = first.or(progress.validation);
            on_progress(progress);
            Directive::Continue
        };
        let trained = trainer::train(&recipe, &set, &device::cpu(), None, &mut watch)?;
        let last = trained.validation.map(|last| last.error_reduction);
        record.validation = first.zip(last).map(|(first, last)| [first, last]);
        record.steps = trained.steps;
        updated.weights = trained.weights;
    }
    let old_pose = kept.iter().map(|&k| model.pose[k]);
    updated.pose = old_pose.chain(new.poses().iter().copied()).collect();
    updated.route_m = model.route_m.as_ref().map(|old| {
        let old = kept.iter().map(|&k| old[k]);
        old.chain(new.route_m().into_iter().flatten().copied())
            .collect()
    });
    let detector = updated.detector();
    updated.activation = match &both {
        Some(both) => detector.probabilities(both)?,
        None => {
            let old = model.activation.select(Axis(0), &kept);
            let new = detector.probabilities(&new)?;
            concatenate(Axis(0), &[old.view(), new.view()])
                .map_err(|e| Error::work(format!("update: {e}")))?
        }
    };
    if let (Some(both), Some(_)) = (&both, &model.occupancy) {
        redraw(&mut updated, both)?;
    }
    updated.header.recipe.split = whole();
    updated.header.updates.push(record);
    updated.map()?; // as a file of it will be checked
    Ok(Updated {
        model: updated,
        memory: both.map(Memory::from_recording),
    })
}

/// A recipe for a few steps from where its networks are.
fn finer(recipe: &Recipe, config: &UpdateConfig) -> Recipe {
    let mut recipe = recipe.clone();
    recipe.seed = config.seed;
    recipe.split = whole();
    let descent = &mut recipe.descent;
    descent.steps = config.steps;
    descent.learning_rate *= config.rate;
    descent.restarts = 1;
    descent.sequential = false;
    descent.validate_every = config.steps.div_ceil(KEPT_BACK).max(1);
    descent.patience = config.steps.max(1);
    recipe
}

/// Nothing is held back: what a map is made of now is all that it was learned from.
fn whole() -> SplitConfig {
    SplitConfig {
        unit: Unit::Runs,
        test_fold: None,
        validation_every: 0,
        ..SplitConfig::default()
    }
}

/// What stays of the old snapshots, and behind it the new ones.
fn joined(old: &Recording, kept: &[usize], new: &Recording) -> Result<Recording> {
    if kept.is_empty() {
        return Ok(new.clone());
    }
    let (mut old, mut new) = (old.select(kept)?.into_columns(), new.clone().into_columns());
    if old.compass_rad.is_some() != new.compass_rad.is_some() {
        (old.compass_rad, new.compass_rad) = (None, None);
    }
    // A part of a dataset is not that dataset.
    (old.dataset_sha256, new.dataset_sha256) = (None, None);
    Recording::joined(vec![Recording::new(old)?, Recording::new(new)?])
}

/// The middle one of every five stretches of the new snapshots is for validation; they come after the `old` ones.
fn kept_back(both: &Recording, old: usize) -> Split {
    let travelled_m = both.travelled_m();
    let middle = |k: &usize| (travelled_m[*k] / AUTO_STRETCH_M) as usize % KEPT_BACK == MIDDLE;
    let (validation, new): (Vec<usize>, Vec<usize>) = (old..both.len()).partition(middle);
    Split {
        train: (0..old).chain(new).collect(),
        validation,
        test: Vec::new(),
    }
}

/// The map that scans draw, of all snapshots there are now.
fn redraw(model: &mut Model, both: &Recording) -> Result<()> {
    let split = Split {
        train: (0..both.len()).collect(),
        ..Split::default()
    };
    let (recipe, input) = (&model.header.recipe, &model.header.input);
    let drawn = EveryPose::prepare(recipe, both, &split, input, None)?;
    let drawn = drawn.ok_or_else(|| Error::work("update: the scans draw no map"))?;
    model.header.occupancy = Some(OccupancyHeader {
        cell_m: drawn.sensed.map.cell_m(),
        origin_m: drawn.sensed.map.origin_m(),
        sensors: drawn.sensed.sensors.clone(),
    });
    model.occupancy = Some(drawn.sensed.map);
    Ok(())
}

#[cfg(test)]
mod tests;
