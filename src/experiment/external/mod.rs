//! Somebody else's localiser in localisation trials: it is given what ours see, and is judged by the answers it wrote to files.
//!
//! It is played the very trials that everybody plays ([`names`] calls them, [`observed`] is what it may see of one). Its answers come
//! back as TUM poses or as tables with poses, covariances, particles or a grid's belief; a missing, short or late one is an error, so that no
//! hole can pass for a figure.

mod answers;
mod command;
mod config;
mod frame;
mod localiser;
mod trial_files;

pub use config::{ExternalConfig, Starts};
pub use localiser::CommandLocaliser;
pub use trial_files::{Start, names, observed, times};

use super::{
    method::{AnswersBy, Method, method},
    methods::MethodContext,
    recorded_answers::RecordedAnswers,
    sequences::drawn,
    trials::Trial,
};
use crate::{
    error::{Error, Result},
    localiser::Step,
};
use command::Asked;
use frame::Answered;
use std::path::Path;

impl ExternalConfig {
    /// Its answers to the trials of this context, to be judged like everybody's.
    ///
    /// # Errors
    /// Where an answer is missing, of another frame or time, or its file makes no sense: the message names the trial; and where its command
    /// fails or takes too long.
    pub fn method<'a>(&self, context: &MethodContext<'a>, name: &str) -> Result<Method<'a>> {
        let answers = AnswersBy::Recorded(self.answers(context)?);
        Ok(method(name, name, None, answers))
    }

    fn answers(&self, context: &MethodContext) -> Result<RecordedAnswers> {
        let trials = drawn(context)?;
        let starts: &[Start] = match self.start {
            Starts::Both => &[Start::Unknown, Start::Known],
            Starts::Unknown => &[Start::Unknown],
        };
        let names_of = |start| names(start, trials.len(), context.seed());
        let made;
        let folder = match self.command.is_empty() {
            true => &*self.answers,
            false => {
                made = tempfile::tempdir().map_err(|e| {
                    Error::io("cannot make a temporary folder", std::env::temp_dir(), e)
                })?;
                made.path()
            }
        };
        if self.command.is_empty() {
            let known = [Start::Unknown, Start::Known].map(names_of).concat();
            if let Some(stranger) = answers::strangers(folder, &known)?.first() {
                return Err(Error::file(
                    stranger,
                    format!(
                        "answers no trial; expected {} to {}, and the same with `known`",
                        names_in_order(&known[..trials.len()], 0),
                        names_in_order(&known[..trials.len()], trials.len() - 1)
                    ),
                ));
            }
        }
        let mut all = Vec::new();
        let seed = context.seed().0;
        for &start in starts {
            let names = names_of(start);
            let steps = self.of_start(context, &trials, (start, &names), folder, seed)?;
            all.push((start, names, steps));
        }
        let answered: Vec<Answered> = all
            .iter()
            .map(|(start, names, steps)| Answered {
                start: *start,
                names,
                trials: &trials,
                steps,
            })
            .collect();
        frame::check(context.parts.run, &answered)?;
        let again = |seed: u64| {
            let names = names_of(Start::Unknown);
            self.of_start(context, &trials, (Start::Unknown, &names), folder, seed)
        };
        let (mut same_seed, mut other_seeds) = (None, Vec::new());
        if self.repeats > 0 {
            same_seed = Some(again(seed)?);
            let others = (1..=self.repeats as u64).map(|number| again(seed.wrapping_add(number)));
            other_seeds = others.collect::<Result<_>>()?;
        }
        let mut steps = all.into_iter().map(|(_, _, steps)| steps);
        Ok(RecordedAnswers {
            same_seed,
            other_seeds,
            anywhere: steps.next().unwrap_or_default(),
            known: steps.next().unwrap_or_default(),
        })
    }

    fn of_start(
        &self,
        context: &MethodContext,
        trials: &[Trial],
        (start, names): (Start, &[String]),
        folder: &Path,
        seed: u64,
    ) -> Result<Vec<Vec<Step>>> {
        let run = context.parts.run;
        let one = |(trial, name): (&Trial, &String)| {
            if !self.command.is_empty() {
                let asked = Asked {
                    name,
                    start,
                    pose: run.poses()[trial.snapshots[0]],
                    observed: &observed(run, &trial.snapshots)?,
                    seed,
                };
                command::answer(self, &asked, folder)?;
            }
            answers::read(folder, name, &times(run, &trial.snapshots), self)
        };
        trials.iter().zip(names).map(one).collect()
    }
}

/// The name that stands at a place of their order.
fn names_in_order(names: &[String], at: usize) -> &str {
    let mut sorted: Vec<&String> = names.iter().collect();
    sorted.sort();
    sorted.get(at).map_or("", |name| name)
}

#[cfg(test)]
mod tests;
