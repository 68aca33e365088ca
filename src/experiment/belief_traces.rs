//! What systems believed along a few trials, step by step, kept so that a reader can watch it (Thrun 1998, Fig. 5).
//!
//! Kept are, of trials that start anywhere, the first one and those in which the first system's mean expected error is least and
//! largest; all systems play the same. Of a belief stays what each square holds, headings together, in 8 bits: the root of the mass
//! in 255ths, so that both a peak and a spread can be seen. Squares are as large as it takes for [`MOST_CELLS`] of them. Of a trial the first 200 steps
//! are kept, and of the trials as many as take 2.5 million letters all together, one at least.

mod record;
mod sensed;
mod squares;
mod watch;

pub use record::{BeliefTraces, ErrorsAt, Plan, TracedSystem, TracedTrial};
pub use sensed::{Beam, SensedScan, SensedTrial};
pub(super) use watch::Watch;

/// Most squares, or pieces of a route, that a belief is reduced to.
pub const MOST_CELLS: usize = 3000;
