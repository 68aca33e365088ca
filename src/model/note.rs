//! What a user should know of a training besides its scores.

use crate::learning::trainer::NOTHING_LEARNED;
use std::fmt;

/// Something about a training that its scores do not show. As text it is one line for a person.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// No validation snapshot lies at a place seen in training: nothing stopped the training or chose among its weights.
    NoValidation,
    /// So few validation snapshots chose the weights that chance has chosen as well.
    FewValidationSnapshots(usize),
    /// Error reduction on the validation part is next to nothing.
    NothingLearned,
    /// Random features took away more of the validation error than what was learned, whose share this is: they are the model's.
    RandomBetter(f64),
    /// The map has so many places of so many training snapshots.
    MapThinned(usize, usize),
    /// The training went on from this step of one with another number of steps, and so under another schedule.
    ExtendedAt(usize),
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoValidation => f.write_str(
                "no validation snapshot lies at a place seen in training: nothing stopped the training early, and the \
                 weights of its last step are kept, whether or not they hold on places seen again",
            ),
            Self::FewValidationSnapshots(count) => write!(
                f,
                "only {count} validation snapshots at places seen in training chose among the weights: the validation \
                 row is flattered and may be off by much; record more passes of the same places, or keep back a \
                 larger part ([train.split] validation_every)"
            ),
            Self::NothingLearned => write!(
                f,
                "less than {:.0} % of the validation error is taken away: what was learned does not hold on snapshots \
                 that training did not see",
                100.0 * NOTHING_LEARNED
            ),
            Self::RandomBetter(learned) => write!(
                f,
                "what was learned takes away {:.1} % of the validation error, less than as many random features: the model has \
                 these, sides of random planes through the inputs; more passes of the same places may give something to learn",
                100.0 * learned
            ),
            Self::MapThinned(places, snapshots) => write!(
                f,
                "the map has {places} places, evenly over those of the {snapshots} training snapshots, all of which were learned \
                 from ([train.map] most_places; 0: all)"
            ),
            Self::ExtendedAt(step) => write!(
                f,
                "went on from step {step} of the same training with another number of steps, and so another schedule of \
                 the learning rate: not the bits of an unbroken training of these steps"
            ),
        }
    }
}
