//! How a training went, as it is told of a model.

use super::{header::Scores, note::Note, trained_model::Model};
use crate::learning::{
    ErrorReduction,
    trainer::{NOTHING_LEARNED, StoppedBy},
};

/// With fewer validation snapshots than this, a note says that they are few.
const FEW_VALIDATION_SNAPSHOTS: usize = 50;

/// How a training went.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TrainingReport {
    /// Expected errors reached, as in the model's header.
    pub scores: Scores,
    /// Steps taken.
    pub steps: usize,
    /// Evaluations of the objective with its gradient on the way; judgements of the validation part not counted.
    pub evaluations: usize,
    /// The pre-trained networks that it began with; none: random ones.
    pub began_with: Option<String>,
    /// Why it ended.
    pub stopped_by: StoppedBy,
    /// Step of the checkpoint that it went on from, where it did.
    pub resumed_at: Option<usize>,
    /// What the scores do not show.
    pub notes: Vec<Note>,
}

impl TrainingReport {
    /// What a model records of its training.
    pub(super) fn of(model: &Model, resumed_at: Option<usize>) -> Option<Self> {
        let record = model.header.training.as_ref()?;
        let scores = model.header.scores;
        let mut notes = Vec::new();
        match scores.validation {
            None => notes.push(Note::NoValidation),
            Some(ErrorReduction {
                snapshots,
                error_reduction,
                ..
            }) => {
                if snapshots < FEW_VALIDATION_SNAPSHOTS {
                    notes.push(Note::FewValidationSnapshots(snapshots));
                }
                if error_reduction < NOTHING_LEARNED {
                    notes.push(Note::NothingLearned);
                }
            }
        }
        notes.extend(record.random_better_than.map(Note::RandomBetter));
        let thinned = |learned_from| Note::MapThinned(model.pose.len(), learned_from);
        notes.extend(record.learned_from.map(thinned));
        notes.extend(record.extended_at.map(Note::ExtendedAt));
        Some(Self {
            scores,
            steps: record.steps,
            evaluations: record.evaluations,
            began_with: record.began_with.clone(),
            stopped_by: record.stopped_by,
            resumed_at,
            notes,
        })
    }
}
