//! Models that work from the readings of the last metres as well: which distances a training tries, and how a recording looks to
//! such a model.

use super::trained_model::Model;
use crate::{
    error::Result,
    learning::Recipe,
    recording::{
        Recording,
        history::{MOVED, Past, channels_with_history},
        viewpoint::Views,
    },
};
use std::borrow::Cow;

/// How far back a training looks that chooses for itself: once, twice and four times this, in metres, …
const NEAREST_M: f64 = 0.5;
const TIMES: [f64; 3] = [1.0, 2.0, 4.0];
/// … or where snapshots are sparser, so many times their spacing.
const OF_SPACING: f64 = 1.25;

/// More readings a snapshot than these are a picture, which tells by itself where it is.
const MOST_READINGS: usize = 100;

/// The distances that a training on this recording tries, the plain one first: one where the recipe says it, or where scans can be
/// moved and rendered.
pub(super) fn histories(recipe: &Recipe, recording: &Recording) -> Result<Vec<Vec<f64>>> {
    if let Some(back_m) = &recipe.input.history_m {
        return Ok(vec![back_m.clone()]);
    }
    let chosen = &recipe.input.channels;
    let used = |name: &String| chosen.is_empty() || chosen.contains(name);
    let channels = recording.channels().iter().filter(|c| used(&c.name));
    let readings: usize = channels.map(|channel| channel.width).sum();
    let mut channels = recording.channels().iter();
    let has_history = channels.any(|channel| channel.name.starts_with(MOVED));
    if Views::of(recording)?.is_some() || readings > MOST_READINGS || has_history {
        return Ok(vec![Vec::new()]);
    }
    let nearest_m = NEAREST_M.max(OF_SPACING * recording.spacing_m());
    let back_m = TIMES.map(|times| (times * nearest_m * 10.0).round() / 10.0);
    Ok(vec![Vec::new(), back_m.to_vec()])
}

/// A recipe with these distances, and the recording as it is learned from.
pub(super) fn remembering<'r>(
    recipe: &Recipe,
    recording: &'r Recording,
    back_m: &[f64],
) -> Result<(Recipe, Cow<'r, Recording>)> {
    let mut recipe = recipe.clone();
    if back_m.is_empty() {
        return Ok((recipe, Cow::Borrowed(recording)));
    }
    recipe.input.history_m = Some(back_m.to_vec());
    let chosen = &mut recipe.input.channels;
    if !chosen.is_empty() {
        let used = recording.channels().iter();
        let used: Vec<_> = used.filter(|c| chosen.contains(&c.name)).cloned().collect();
        let all = channels_with_history(&used, back_m);
        chosen.extend(all.into_iter().skip(used.len()).map(|channel| channel.name));
    }
    Ok((recipe, Cow::Owned(recording.with_history(back_m)?)))
}

impl Model {
    /// Distances, in metres, whose readings are inputs beside those of now; none as a rule.
    pub fn history_m(&self) -> &[f64] {
        self.header
            .recipe
            .input
            .history_m
            .as_deref()
            .unwrap_or_default()
    }

    /// All distances that any of these models works from, rising: a recording [with](Recording::with_history) them serves all.
    pub fn history_of_all(models: &[&Model]) -> Vec<f64> {
        let all = models.iter().flat_map(|model| model.history_m());
        let mut all: Vec<f64> = all.copied().collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// A recording as the model's networks are fed with it: with the readings of the last metres, where it works from them.
    ///
    /// # Errors
    /// Where the recording has channels of the names that these need.
    pub fn seen_in<'r>(&self, recording: &'r Recording) -> Result<Cow<'r, Recording>> {
        let back_m = self.history_m();
        let needed = channels_with_history(&self.header.channels, back_m);
        let has = |name: &String| recording.channels().iter().any(|c| c.name == *name);
        if back_m.is_empty() || needed.iter().all(|channel| has(&channel.name)) {
            return Ok(Cow::Borrowed(recording));
        }
        recording.with_history(back_m).map(Cow::Owned)
    }

    /// The memory of a robot that works with this model; none where it needs none.
    pub fn past(&self) -> Option<Past> {
        let back_m = self.history_m();
        (!back_m.is_empty()).then(|| Past::new(back_m))
    }
}

#[cfg(test)]
mod tests;
