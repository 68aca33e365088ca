//! Which snapshots sensor models are asked about at all: of a long log few, and no table need hold the others.

use super::{lost_tuning, methods::MethodContext, recall::sampled, sequences, trials::Trial};
use crate::error::Result;

/// Entries of a table of snapshots by places up to which it may hold every snapshot: 128 MB of single precision.
const WHOLE_TABLE: usize = 32 << 20;

impl MethodContext<'_> {
    /// Unseen snapshots that trials and figures of single snapshots ask about, ascending; of a short log all.
    pub(super) fn asked(&self) -> Vec<usize> {
        let unseen = &self.parts.unseen;
        if self.fits_whole(unseen.len()) {
            return unseen.clone();
        }
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
        if self.fits_whole(validation.len()) {
            return Ok(validation.clone());
        }
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
