//! Which snapshots sensor models are asked about at all: of a long log few, and no table need hold the others.

use super::{lost_tuning, methods::MethodContext, recall::sampled, sequences, trials::Trial};
use crate::error::Result;

/// Entries of a table of snapshots by places up to which it may hold every snapshot: 128 MB of single precision.
const WHOLE_TABLE: usize = 32 << 20;

impl MethodContext<'_> {
    /// Unseen snapshots that trials and figures of single snapshots ask about, ascending; of a short log all.
    pub(super) fn asked(&self) -> Vec<usize> {
        let unseen = &self.parts.unseen;
        match self.fits_whole(unseen.len()) {
            true => unseen.clone(),
            false => self.asked_of_long(),
        }
    }

    fn asked_of_long(&self) -> Vec<usize> {
        // Where none can be drawn, whoever plays them says so.
        let trials = sequences::drawn(self).unwrap_or_default();
        union([of_trials(&trials), self.covered(), sampled(self)])
    }

    /// Snapshots of the validation part that constants are tuned on, ascending; of a short log all.
    ///
    /// # Errors
    /// Where the training part is not at hand.
    pub(super) fn asked_of_validation(&self) -> Result<Vec<usize>> {
        let validation = &self.source()?.validation;
        match self.fits_whole(validation.len()) {
            true => Ok(validation.clone()),
            false => self.asked_of_long_validation(),
        }
    }

    fn asked_of_long_validation(&self) -> Result<Vec<usize>> {
        let counts = [sequences::VALIDATION_SEQUENCES, lost_tuning::SEQUENCES];
        let trials = counts.map(|count| sequences::validation_sequences(self, count));
        let trials = trials.into_iter().collect::<Result<Vec<_>>>()?.concat();
        Ok(union([of_trials(&trials), self.validated()?]))
    }

    fn fits_whole(&self, snapshots: usize) -> bool {
        snapshots.saturating_mul(self.mapped.places.len()) <= WHOLE_TABLE
    }
}

fn of_trials(trials: &[Trial]) -> Vec<usize> {
    trials
        .iter()
        .flat_map(|trial| trial.snapshots.clone())
        .collect()
}

/// All of them, each once, ascending.
fn union<const N: usize>(all: [Vec<usize>; N]) -> Vec<usize> {
    let mut all = all.concat();
    all.sort_unstable();
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        experiment::{localise_config::LocaliseConfig, mapped::Mapped, parts::Parts},
        learning::Recipe,
        model::Training,
        seed::Seed,
        world::corridor::{CorridorConfig, thrun1998},
    };

    /// Whoever is asked in trials, in figures of single snapshots or while constants are tuned is among them, and not everybody is.
    #[test]
    fn of_a_long_log_those_are_known_who_will_be_asked() {
        let config = CorridorConfig {
            runs: 8,
            spacing_m: 0.1,
        };
        let recording = thrun1998(Seed(1), &config).unwrap();
        let mut recipe = Recipe {
            features: 1,
            ..Recipe::default()
        };
        recipe.split.test_fold = Some(0);
        recipe.descent.steps = 1;
        let model = Training::new(&recipe, &recording).run().unwrap().model;
        let parts = Parts::new(&model, &recording, None).unwrap();
        let config = LocaliseConfig {
            trials: 3,
            ..LocaliseConfig::default()
        };
        let context = MethodContext::over(Mapped::from(&model), &parts, &config).unwrap();
        let asked = context.asked_of_long();
        assert!(asked.is_sorted_by(|a, b| a < b));
        assert!(asked.iter().all(|k| parts.unseen.binary_search(k).is_ok()));
        for trial in sequences::drawn(&context).unwrap() {
            assert!(
                trial
                    .snapshots
                    .iter()
                    .all(|k| asked.binary_search(k).is_ok())
            );
        }
        assert!(
            context
                .covered()
                .iter()
                .all(|k| asked.binary_search(k).is_ok())
        );

        let validation = &context.source().unwrap().validation;
        let asked = context.asked_of_long_validation().unwrap();
        assert!(asked.len() < validation.len());
        assert!(asked.iter().all(|k| validation.binary_search(k).is_ok()));
        for count in [sequences::VALIDATION_SEQUENCES, lost_tuning::SEQUENCES] {
            for trial in sequences::validation_sequences(&context, count).unwrap() {
                assert!(
                    trial
                        .snapshots
                        .iter()
                        .all(|k| asked.binary_search(k).is_ok())
                );
            }
        }
        // A log as short as this one is asked about whole.
        assert_eq!(context.asked(), parts.unseen);
        assert_eq!(&context.asked_of_validation().unwrap(), validation);
    }
}
