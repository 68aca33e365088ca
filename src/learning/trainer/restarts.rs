//! A whole training: as many starts as the recipe asks for, the best of which is kept.

use super::{Progress, Trained, train_once};
use crate::{
    detector::device::{self, Device},
    error::{Error, Result},
    learning::{recipe::Recipe, training_set::TrainingSet},
    seed::Seed,
};
use rand::RngExt;
use std::path::{Path, PathBuf};

/// Trains a recipe on a training_set, on the CPU: see [`train_on`].
///
/// # Errors
/// As [`train_on`].
pub fn train(
    recipe: &Recipe,
    training_set: &TrainingSet,
    checkpoint: Option<&Path>,
    resume: bool,
    identity: &str,
    progress: &mut dyn FnMut(Progress),
) -> Result<Trained> {
    let device = device::cpu();
    train_on(
        &device,
        recipe,
        training_set,
        checkpoint,
        resume,
        identity,
        progress,
    )
}

/// Trains a recipe on a training_set, with the networks on a device: as often as `restarts` asks, each time from other random
/// weights. The training of the least validation error is kept; of the least training error where nothing can be
/// validated.
///
/// A checkpoint is kept at `checkpoint` where given, in place of whatever stood there (for every restart one of its own,
/// numbered); with `resume`, training goes on from it, and ends in the same bits as if it had never stopped. It starts
/// afresh where there is no checkpoint yet.
///
/// # Errors
/// Where a checkpoint belongs to another training or is damaged, or can't be written.
pub fn train_on(
    device: &Device,
    recipe: &Recipe,
    training_set: &TrainingSet,
    checkpoint: Option<&Path>,
    resume: bool,
    identity: &str,
    progress: &mut dyn FnMut(Progress),
) -> Result<Trained> {
    if !resume {
        // Another training's, or an older one's: it must not be taken up after this one is stopped.
        remove_checkpoints(checkpoint, recipe.descent.restarts)?;
    }
    let judged = |t: &Trained| t.validation.unwrap_or(t.train).error_reduction;
    let mut best: Option<Trained> = None;
    for restart in 0..recipe.descent.restarts {
        let recipe = Recipe {
            seed: restart_seed(recipe.seed, restart),
            ..recipe.clone()
        };
        let before = restart * recipe.descent.steps;
        let mut progress = |p: Progress| {
            progress(Progress {
                step: before + p.step,
                ..p
            });
        };
        let checkpoint = checkpoint.map(|path| checkpoint_of(path, restart));
        let checkpoint = checkpoint.as_deref();
        let trained = train_once(
            device,
            &recipe,
            training_set,
            checkpoint,
            resume,
            identity,
            &mut progress,
        )?;
        if best
            .as_ref()
            .is_none_or(|best| judged(&trained) > judged(best))
        {
            best = Some(trained);
        }
    }
    best.ok_or_else(|| Error::usage("descent.restarts = 0: expected at least 1"))
}

/// The seed of a restart; that of the first is the recipe's own.
fn restart_seed(seed: u64, restart: usize) -> u64 {
    match restart {
        0 => seed,
        _ => Seed(seed)
            .numbered_stream("restart", restart as u64)
            .random(),
    }
}

/// Where the checkpoint of a restart is kept: at `path` itself for the first, numbered for the others.
fn checkpoint_of(path: &Path, restart: usize) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    if restart > 0 {
        name.push(format!("-{restart}"));
    }
    name.into()
}

/// Removes the checkpoints of a training of so many restarts.
///
/// # Errors
/// Where one is there and can't be removed.
pub fn remove_checkpoints(checkpoint: Option<&Path>, restarts: usize) -> Result<()> {
    for path in (0..restarts).filter_map(|r| checkpoint.map(|path| checkpoint_of(path, r))) {
        if path.exists() {
            std::fs::remove_file(&path).map_err(|e| Error::io("cannot remove", &path, e))?;
        }
    }
    Ok(())
}
