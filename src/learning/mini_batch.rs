//! The snapshots of a step: all training snapshots, or a draw of truths, moved and blinded, and a draw of candidates.

use super::{
    problem::Problem,
    recipe::{AugmentationConfig, Recipe},
    training_set::TrainingSet,
};
use crate::{
    belief::{Places, Uncertainty, prior::DEFAULT_HALF_TURN_RAD},
    error::{Error, Result},
    recording::{Recording, viewpoint::Moves},
    seed::{Seed, Stream},
};
use ndarray::{Array2, Axis, concatenate};
use rand::RngExt;

/// Snapshots for one step.
pub struct MiniBatch {
    /// Normalised inputs of the truths, then of the candidates, `[snapshot, input]`.
    pub inputs: Array2<f32>,
    /// How many of them are truths.
    pub truths: usize,
    /// The objective on their activations.
    pub problem: Problem,
}

impl MiniBatch {
    /// The draw of step `step`, the same for the same seed and step whatever happened before.
    ///
    /// # Errors
    /// Where a whole run is to be left out and there is only one.
    pub fn new(recipe: &Recipe, training_set: &TrainingSet, step: usize) -> Result<Self> {
        let mut random = Seed(recipe.seed).numbered_stream("draw of a step", step as u64);
        let all = training_set.snapshots.len();
        let (truths, candidates) = match recipe.descent.leave_run_out {
            true => {
                let run = training_set.runs[random.random_range(0..all)];
                let (own, others) = (0..all).partition(|&k| training_set.runs[k] == run);
                (Some(own), Some(others))
            }
            false => (None, None),
        };
        let truths = Pool::of(all, &truths);
        let candidates = Pool::of(all, &candidates);
        if candidates.count == 0 {
            return Err(Error::work(
                "descent.leave_run_out: all training snapshots are of one run; expected at least two runs",
            ));
        }
        let truths = truths.some(recipe.descent.truths_per_step, &mut random);
        let visited = match training_set.every_pose {
            Some(_) => Vec::new(), // its candidates are drawn beside the truths, once these have moved
            None => candidates.stretches(recipe.descent.candidates_per_step, &mut random),
        };
        let uncertainty = truths.iter().map(|_| draw_uncertainty(recipe, &mut random));
        let uncertainty = uncertainty.collect();

        let seen = training_set.seen_from_beside(&recipe.augmentation, &truths, &mut random)?;
        let (truth_inputs, truth_places) = match &seen {
            Some(recording) => (
                training_set.input.transform(recording)?,
                Places::of(recording),
            ),
            None => (
                training_set.inputs.select(Axis(0), &truths),
                training_set.places.select(&truths),
            ),
        };
        let (candidate_places, candidate_inputs) = match &training_set.every_pose {
            Some(every_pose) => {
                every_pose.draw(&truth_places, recipe.descent.rendered_per_step, &mut random)
            }
            None => (
                training_set.places.select(&visited),
                training_set.inputs.select(Axis(0), &visited),
            ),
        };
        let problem = Problem::for_step(
            recipe,
            &training_set.map,
            uncertainty,
            truth_places,
            candidate_places,
        )?;
        let inputs = concatenate(Axis(0), &[truth_inputs.view(), candidate_inputs.view()])
            .map_err(|e| Error::work(format!("inputs of a step: {e}")))?;
        Ok(Self {
            inputs,
            truths: truths.len(),
            problem,
        })
    }
}

/// Snapshots to draw from. Where it is all of them, nothing is written down: a step must not cost more the more there are.
struct Pool<'a> {
    count: usize,
    /// Their numbers, ascending; `None`: the first `count`.
    numbers: Option<&'a [usize]>,
}

impl<'a> Pool<'a> {
    fn of(all: usize, numbers: &'a Option<Vec<usize>>) -> Self {
        Self {
            count: numbers.as_ref().map_or(all, Vec::len),
            numbers: numbers.as_deref(),
        }
    }

    fn number(&self, place: usize) -> usize {
        self.numbers.map_or(place, |numbers| numbers[place])
    }

    /// So many of them, ascending; all where `count` is 0 or more than there are.
    fn some(&self, count: usize, random: &mut Stream) -> Vec<usize> {
        let places = some(self.count, count, random).into_iter();
        places.map(|place| self.number(place)).collect()
    }

    /// About so many of them, ascending, in stretches of consecutive ones.
    fn stretches(&self, count: usize, random: &mut Stream) -> Vec<usize> {
        if count == 0 || count >= self.count {
            return self.some(0, random);
        }
        let stretches = self.count.div_ceil(STRETCH);
        let drawn = some(stretches, count.div_ceil(STRETCH), random).into_iter();
        let places = drawn.flat_map(|s| s * STRETCH..self.count.min((s + 1) * STRETCH));
        places.map(|place| self.number(place)).collect()
    }
}

/// So many of the numbers below `total`, ascending; all where `count` is 0 or more than there are.
fn some(total: usize, count: usize, random: &mut Stream) -> Vec<usize> {
    if count == 0 || count >= total {
        return (0..total).collect();
    }
    let mut drawn = rand::seq::index::sample(random, total, count).into_vec();
    drawn.sort_unstable();
    drawn
}

/// Snapshots that are drawn together as candidates: the map of a place is made of its neighbours, which a draw must not
/// tear away from it.
const STRETCH: usize = 16;

/// The uncertainty of one truth.
pub(super) fn draw_uncertainty(recipe: &Recipe, random: &mut Stream) -> Uncertainty {
    let mix = &recipe.priors;
    let half_turn_rad = match recipe.uncertainty {
        Uncertainty::Window { half_turn_rad, .. } => half_turn_rad,
        Uncertainty::Global => Some(DEFAULT_HALF_TURN_RAD),
    };
    if random.random_range(0.0..1.0) < recipe.stated_share() {
        return recipe.uncertainty;
    }
    if random.random_range(0.0..1.0) < mix.global {
        return Uncertainty::Global;
    }
    let log = mix.narrowest_m.ln()..=mix.widest_m.ln();
    Uncertainty::Window {
        half_width_m: random.random_range(log).exp(),
        half_turn_rad,
    }
}

impl TrainingSet<'_> {
    /// Some training snapshots (by their place in the training part) as seen from beside, with people in the way and beams
    /// dropped; `None` where the recipe has none of that or the recording has no scans that could be drawn anew.
    fn seen_from_beside(
        &self,
        config: &AugmentationConfig,
        truths: &[usize],
        random: &mut Stream,
    ) -> Result<Option<Recording>> {
        let Some(views) = &self.views else {
            return Ok(None);
        };
        let AugmentationConfig {
            shift_m,
            turn_rad,
            dropped_beams,
            ..
        } = *config;
        let people = config.most_people(self.every_pose.is_some());
        if [shift_m, turn_rad, dropped_beams, people] == [0.0; 4] {
            return Ok(None);
        }
        let snapshots: Vec<usize> = truths.iter().map(|&k| self.snapshots[k]).collect();
        let moves = Moves { shift_m, turn_rad };
        let seen = views.drawn(&snapshots, &moves, random)?;
        blinded(seen, people, dropped_beams, random).map(Some)
    }
}

/// Snapshots with people in the way of up to `people` of their beams, and `dropped` of them without return.
pub(super) fn blinded(
    mut seen: Recording,
    people: f64,
    dropped: f64,
    random: &mut Stream,
) -> Result<Recording> {
    if people > 0.0 {
        seen = seen.with_people_drawn(people, random)?;
    }
    if dropped > 0.0 {
        seen = drop_beams(seen, dropped, random)?;
    }
    Ok(seen)
}

/// Beams that a person in the way hides together, as a share of a scan: about 20° of a half circle.
const BLOCK: f64 = 1.0 / 9.0;

/// Takes blocks of beams out of every range scan with bearings: each block of a scan with probability `share`.
fn drop_beams(recording: Recording, share: f64, random: &mut Stream) -> Result<Recording> {
    let mut columns = recording.into_columns();
    let mut from = 0;
    for channel in &columns.channels {
        if channel.unit == "m" && channel.bearing_rad.is_some() {
            let width = ((channel.width as f64 * BLOCK).ceil() as usize).max(1);
            for mut scan in columns.values.rows_mut() {
                for block in (0..channel.width).step_by(width) {
                    if random.random_range(0.0..1.0) < share {
                        let end = (block + width).min(channel.width);
                        scan.slice_axis_mut(Axis(0), (from + block..from + end).into())
                            .fill(f32::NAN);
                    }
                }
            }
        }
        from += channel.width;
    }
    Recording::new(columns)
}

#[cfg(test)]
mod tests;
