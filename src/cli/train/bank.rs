//! A bank of filters: a set for every prior uncertainty.

use super::{
    Arguments, checkpoint_of,
    scores::{VALIDATION, json_of, score_rows, scores_table},
    tune_evidence, warn_notes,
};
use crate::{
    belief::Uncertainty,
    cli::{Outcome, print},
    error::Result,
    learning::Recipe,
    model::{Learned, Model, ModelBank, Training},
    recording::{Recording, split::passes},
};
use std::path::{Path, PathBuf};

/// Learns the sets of a bank, one after the other, each with a checkpoint of its own and its evidence tuned, and writes them to one file.
pub(super) fn learned(
    recipe: &Recipe,
    recording: &Recording,
    output: &Path,
    learn_set: impl Fn(&Recipe, &Path) -> Result<Learned>,
) -> Result<Vec<Learned>> {
    let mut sets = Vec::new();
    for uncertainty in Uncertainty::of_a_bank() {
        let recipe = Recipe {
            uncertainty,
            ..recipe.clone()
        };
        let mut learned = learn_set(&recipe, &checkpoint_of_set(output, uncertainty))?;
        tune_evidence(&mut learned, recording);
        sets.push(learned);
    }
    let models: Vec<Model> = sets.iter().map(|set| set.model.clone()).collect();
    let training_part = recipe.split.split(recording)?.train;
    let mapped = models
        .first()
        .map(|set| set.mapped_of(recording, &training_part));
    ModelBank::new(models, passes(recording, &mapped.unwrap_or_default()))?.write(output)?;
    // The bank is safe; stale checkpoints are only in the way.
    for uncertainty in Uncertainty::of_a_bank() {
        let _ = Training::remove_checkpoints(recipe, &checkpoint_of_set(output, uncertainty));
    }
    Ok(sets)
}

/// The checkpoint of a set.
fn checkpoint_of_set(output: &Path, uncertainty: Uncertainty) -> PathBuf {
    let mut name = checkpoint_of(output).into_os_string();
    name.push(format!(".{uncertainty}"));
    name.into()
}

/// Prints a bank's notes and results, a set after the other.
pub(super) fn show(
    sets: &[Learned],
    recording: &Recording,
    arguments: &Arguments,
    seconds: f64,
) -> Result<Outcome> {
    sets.iter().for_each(warn_notes);
    let degraded = recording.columns().degraded.as_ref();
    if arguments.json {
        let sets = sets.iter().map(|set| json_of(set, degraded));
        let value = serde_json::json!({
            "sets": sets.collect::<Vec<_>>(),
            "timing": { "seconds": seconds },
        });
        print(&format!("{value}\n"))?;
        return Ok(Outcome::Done);
    }
    let mut table = scores_table("uncertainty, part");
    for set in sets {
        let recipe = &set.model.header.recipe;
        score_rows(
            &mut table,
            &format!("{}, ", recipe.uncertainty),
            &set.report.scores,
        );
    }
    if let Some(set) = sets.first() {
        let recipe = &set.model.header.recipe;
        table.caption(format!(
            "a bank of {} sets of {} filters, seed {}; {seconds:.1} s",
            sets.len(),
            recipe.features,
            recipe.seed
        ));
    }
    table.caption(VALIDATION);
    if let Some(degraded) = degraded {
        table.caption(format!("sensor degraded: {degraded}"));
    }
    table.caption(format!("model: {}", arguments.output.display()));
    print(&table.text())?;
    Ok(Outcome::Done)
}
