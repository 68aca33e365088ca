//! What a robot should do so as to find out where it is: section 7 of the paper asks for it, and leaves it open.
//!
//! One sum answers all three questions ([`HeldApart::expected_posterior_error_m`](crate::belief::held_apart::HeldApart)): which way to
//! turn the camera at the next step, which camera to mount for good, whether to drive ahead or back. Each is tried in worlds of seeds of
//! their own, against the other answers and against chance, and each has a control in which the answer should make no difference.

mod eye;
mod robot;

use super::Thrun1998Config;
use crate::{error::Result, score::MeanInterval, seed::Seed};
use eye::Eyes;
use rayon::prelude::*;
use robot::{Question, Robot};
use serde::{Deserialize, Serialize};

/// Readings of a trial: one every half metre, or after every drive.
pub(super) const READINGS: usize = 8;

/// Trials a seed.
pub(super) const TRIALS: usize = 20;

/// Standard deviation of the start of a robot that knows it, in metres.
const SURE_M: f64 = 0.3;

/// Worlds that are tried side by side.
const AT_ONCE: usize = 4;

/// The questions, and whether each is a control.
const QUESTIONS: [(&str, Question, bool); 6] = [
    ("heading", Question::Heading, false),
    ("heading_control", Question::Heading, true),
    ("mount", Question::Mount, false),
    ("mount_control", Question::Mount, true),
    ("action", Question::Action, false),
    ("action_control", Question::Action, true),
];

/// A question, and what choosing by least expected error is worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ChoiceRecord {
    /// `heading`, `mount` or `action`, and each with `_control`.
    pub question: String,
    /// Worlds, each of its own seed.
    pub seeds: usize,
    /// Mean expected error over the readings of a trial, in metres, where the choice is by least expected error.
    pub chosen_m: MeanInterval,
    /// The same where it is left to chance.
    pub chance_m: MeanInterval,
    /// Chosen less chance, seed by seed.
    pub less_than_chance_m: MeanInterval,
    /// The answer that is best in the mean over all seeds, if it is given always.
    pub best_fixed: String,
    /// Its error.
    pub best_fixed_m: MeanInterval,
    /// Chosen less that.
    pub less_than_best_fixed_m: MeanInterval,
}

/// Errors of one question in one world, in metres.
#[derive(Debug, Clone)]
pub(super) struct Tried {
    chosen_m: f64,
    chance_m: f64,
    /// By the answer's name.
    fixed_m: Vec<(&'static str, f64)>,
}

/// Tries all questions. `next` is told what comes.
pub(super) fn tried(
    config: &Thrun1998Config,
    next: &mut dyn FnMut(&str),
) -> Result<Vec<ChoiceRecord>> {
    let worlds: Vec<usize> = (0..config.choice_seeds).collect();
    let mut tried: Vec<Vec<Tried>> = vec![Vec::new(); QUESTIONS.len()];
    for some in worlds.chunks(AT_ONCE) {
        some.iter().for_each(|number| {
            next(&format!(
                "what to do: world {} of {}",
                number + 1,
                worlds.len()
            ));
        });
        let answers = some.par_iter().map(|number| in_world(config, *number));
        for answers in answers.collect::<Result<Vec<_>>>()? {
            tried
                .iter_mut()
                .zip(answers)
                .for_each(|(all, one)| all.push(one));
        }
    }
    let records = QUESTIONS.iter().zip(&tried);
    let record = |(question, tried): (&(&str, Question, bool), &Vec<Tried>)| {
        ChoiceRecord::of(question.0, tried)
    };
    Ok(records.filter_map(record).collect())
}

/// All questions in one world.
fn in_world(config: &Thrun1998Config, number: usize) -> Result<Vec<Tried>> {
    let seed = Seed(config.seed.wrapping_add(1 + number as u64));
    let eyes = Eyes::open(config, seed)?;
    let ask = |&(_, question, is_control): &(&str, Question, bool)| {
        let (cameras, start_spread_m) = match (question, is_control) {
            // Ahead or back makes no difference to a robot that knows where it is.
            (Question::Action, true) => (eyes.headings(), Some(SURE_M)),
            // Nor does which of three copies of a camera looks.
            (_, true) => (eyes.copies(), None),
            (_, false) => (eyes.headings(), None),
        };
        Robot::new(&eyes, seed, start_spread_m)?.asked(question, &cameras)
    };
    QUESTIONS.iter().map(ask).collect()
}

impl ChoiceRecord {
    fn of(question: &str, tried: &[Tried]) -> Option<Self> {
        let mean = |get: &dyn Fn(&Tried) -> f64| {
            MeanInterval::of(&tried.iter().map(get).collect::<Vec<f64>>())
        };
        let fixed = |number: usize| mean(&|tried| tried.fixed_m[number].1);
        let names = tried.first()?.fixed_m.iter().map(|(name, _)| *name);
        let fixed_of_all = names
            .enumerate()
            .filter_map(|(n, name)| Some((n, name, fixed(n)?)));
        let (best, name, best_fixed_m) =
            fixed_of_all.min_by(|a, b| a.2.mean.total_cmp(&b.2.mean))?;
        Some(Self {
            question: question.into(),
            seeds: tried.len(),
            chosen_m: mean(&|tried| tried.chosen_m)?,
            chance_m: mean(&|tried| tried.chance_m)?,
            less_than_chance_m: mean(&|tried| tried.chosen_m - tried.chance_m)?,
            best_fixed: name.into(),
            best_fixed_m,
            less_than_best_fixed_m: mean(&|tried| tried.chosen_m - tried.fixed_m[best].1)?,
        })
    }
}
