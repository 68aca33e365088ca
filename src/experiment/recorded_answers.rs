//! What somebody answered elsewhere, as it was recorded.

use crate::localiser::Step;

/// What somebody answered in all trials, one entry a trial.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RecordedAnswers {
    /// From a start anywhere.
    pub anywhere: Vec<Vec<Step>>,
    /// From a known start; empty where it was not asked.
    pub known: Vec<Vec<Step>>,
    /// From a start anywhere once more, with the same seed; none where nobody asked again.
    pub same_seed: Option<Vec<Vec<Step>>>,
    /// The same with other seeds.
    pub other_seeds: Vec<Vec<Vec<Step>>>,
}
