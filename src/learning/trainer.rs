//! The training loop: steps down the objective, a judgement of the validation part now and then, the best of it kept.
//!
//! This is the lower level, for benches and for loops of one's own: it knows no files of models and prepares no data.
//! [`Training`](crate::model::Training) is the front door.

mod array_backend;
mod batch;
mod checkpoint;
mod directive;
mod identity;
mod on_device;
mod phase;
mod progress;
mod pseudo_patterns;
mod restarts;
mod state;
mod step;
mod tensors;

pub use directive::Directive;
pub use identity::TrainingIdentity;
pub use progress::{Progress, StoppedBy, Trained};
pub use restarts::remove_checkpoints;
pub use step::Trainer;

use super::{recipe::Recipe, training_set::TrainingSet};
use crate::error::{Error, Result};
use burn::tensor::Device;
use phase::Phase;
use restarts::{checkpoint_of, restart_seed};
use std::path::Path;

/// Share of the steps after which a training that has learned nothing ends, …
const NOTHING_LEARNED_AFTER: f64 = 0.25;
/// … the judgements of the validation part that must have come as well (one of a few steps is not judged by its first
/// weights alone), …
const NOTHING_LEARNED_LOOKS: usize = 4;
/// … and the error reduction on that part that counts as nothing.
pub const NOTHING_LEARNED: f64 = 0.01;

/// Where a training keeps its checkpoints, and whether it goes on from one.
#[derive(Debug, Clone, Copy)]
pub struct Checkpoints<'a> {
    /// The file; for every restart but the first its number is put behind the name.
    pub path: &'a Path,
    /// What the training is: only its own checkpoints are taken up.
    pub identity: &'a TrainingIdentity,
    /// Go on from a checkpoint where there is one; otherwise it is removed.
    pub resume: bool,
}

/// Trains a recipe with the networks on a device: as often as `restarts` asks, each time from other random weights. The
/// training of the least validation error is kept; of the least training error where nothing can be validated.
///
/// A training that goes on from a checkpoint ends in the same bits as if it had never stopped. It starts afresh where there
/// is no checkpoint yet.
///
/// # Errors
/// Where a checkpoint belongs to another training or is damaged, or can't be written, and where `on_progress` cancels.
pub fn train(
    recipe: &Recipe,
    training_set: &TrainingSet,
    device: &Device,
    checkpoints: Option<&Checkpoints>,
    on_progress: &mut dyn FnMut(Progress) -> Directive,
) -> Result<Trained> {
    let restarts = recipe.descent.restarts;
    if let Some(checkpoints) = checkpoints.filter(|c| !c.resume) {
        // Another training's, or an older one's: it must not be taken up after this one is stopped.
        remove_checkpoints(checkpoints.path, restarts)?;
    }
    let judged = |t: &Trained| t.validation.unwrap_or(t.train).error_reduction;
    let mut best: Option<Trained> = None;
    for restart in 0..restarts {
        let recipe = Recipe {
            seed: restart_seed(recipe.seed, restart),
            ..recipe.clone()
        };
        let before = restart * recipe.descent.steps;
        let mut on_progress = |p: Progress| {
            on_progress(Progress {
                step: before + p.step,
                most_steps: restarts * p.most_steps,
                ..p
            })
        };
        let path = checkpoints.map(|c| checkpoint_of(c.path, restart));
        let checkpoints = checkpoints.zip(path.as_deref());
        let checkpoints = checkpoints.map(|(c, path)| Checkpoints { path, ..*c });
        let trained = train_once(
            &recipe,
            training_set,
            device,
            checkpoints.as_ref(),
            &mut on_progress,
        )?;
        let stops = trained.stopped_by == StoppedBy::Callback;
        let is_best = best.as_ref().is_none_or(|b| judged(&trained) > judged(b));
        match &mut best {
            // What was stopped is what is reported, whichever of the starts was the best.
            Some(best) if !is_best && stops => best.stopped_by = StoppedBy::Callback,
            Some(_) if !is_best => {}
            _ => best = Some(trained),
        }
        if stops {
            break;
        }
    }
    best.ok_or_else(|| Error::usage("descent.restarts = 0: expected at least 1"))
}

/// One training, from the weights that the recipe's seed gives.
fn train_once(
    recipe: &Recipe,
    training_set: &TrainingSet,
    device: &Device,
    checkpoint: Option<&Checkpoints>,
    on_progress: &mut dyn FnMut(Progress) -> Directive,
) -> Result<Trained> {
    let descent = &recipe.descent;
    let mut trainer = Trainer::new(recipe, training_set, device);
    let mut resumed_at = None;
    if let Some(c) = checkpoint.filter(|c| c.resume && c.path.exists()) {
        trainer.load(checkpoint::read(
            c.path,
            c.identity,
            recipe,
            &trainer.now.nets,
        )?)?;
        resumed_at = Some(trainer.steps());
    }
    let mut validation = None;
    let stopped_by = loop {
        let step = trainer.steps();
        let judged = step.is_multiple_of(descent.validate_every) || step == descent.steps;
        if judged {
            validation = trainer.judge_and_keep()?.map(|e| e.error_reduction);
        }
        let state = &trainer.now;
        match on_progress(Progress {
            step,
            most_steps: descent.steps,
            judged,
            validation,
            best_validation: state.best_validation,
            batch_error_reduction: state.batch_error_reduction,
        }) {
            Directive::Continue => {}
            Directive::Stop => {
                if !judged {
                    trainer.judge_and_keep()?;
                }
                break StoppedBy::Callback;
            }
            Directive::Cancel => return Err(cancelled(&mut trainer, recipe, checkpoint)?),
        }
        if step >= descent.steps {
            break StoppedBy::Steps;
        }
        if let Some(reason) = reason_to_stop(recipe, &trainer) {
            break reason;
        }
        if let Some(c) =
            checkpoint.filter(|_| step > 0 && step.is_multiple_of(descent.checkpoint_every))
        {
            trainer.sync();
            checkpoint::write(c.path, c.identity, &trainer.now)?;
        }
        trainer.step()?;
    };
    trainer.finish(stopped_by, resumed_at)
}

/// What the validation part says against taking the next step.
fn reason_to_stop(recipe: &Recipe, trainer: &Trainer) -> Option<StoppedBy> {
    let (descent, state) = (&recipe.descent, &trainer.now);
    let best = state.best_validation?;
    let since_best = trainer.steps() - state.best_step;
    if !Phase::at(recipe, trainer.steps()).is_last {
        return None;
    }
    if since_best >= descent.patience {
        return Some(StoppedBy::Validation);
    }
    // One feature of a sequence may well be worth nothing by itself, and a start may lie on a plateau that is left later:
    // as long as the best still rises, however low it is, the training goes on.
    let share = (NOTHING_LEARNED_AFTER * descent.steps as f64).ceil() as usize;
    let enough = share.max(NOTHING_LEARNED_LOOKS * descent.validate_every);
    let hopeless = !descent.sequential && best < NOTHING_LEARNED && since_best >= enough;
    hopeless.then_some(StoppedBy::NothingLearned)
}

/// Writes the last checkpoint, where one is kept; the error that says so.
fn cancelled(
    trainer: &mut Trainer,
    recipe: &Recipe,
    checkpoint: Option<&Checkpoints>,
) -> Result<Error> {
    let mut message = format!(
        "the training was cancelled at step {} of {}",
        trainer.steps(),
        recipe.descent.steps
    );
    if let Some(c) = checkpoint {
        trainer.sync();
        checkpoint::write(c.path, c.identity, &trainer.now)?;
        message += &format!("; its checkpoint is {}", c.path.display());
    }
    Ok(Error::cancelled(message))
}

#[cfg(test)]
mod tests;
