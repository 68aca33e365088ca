//! How far an estimated trajectory is from a reference: absolute and relative pose errors, as `evo` (1.38) measures them.
//!
//! A [`Trajectory`] is read from a file ([`read`]) or made from poses. Its poses are paired with those of the reference
//! ([`Pairing`]), moved onto them where that is asked for ([`Alignment`]), and compared: [`PoseErrors`], between poses or between
//! the movements that a [`Delta`] names, summed up in [`Statistics`]. [`evaluate`] does all of it, and the
//! [prediction–correction metric](super::prediction_correction) where the estimates before correction are known, too.
//!
//! ```
//! use ballmark::{Pose, score::trajectory::{EvaluationOptions, Trajectory, evaluate}};
//! let stamps: Vec<f64> = (0..20).map(f64::from).collect();
//! let truth: Vec<Pose> = stamps.iter().map(|&t| Pose::new(t, 0.0, 0.0)).collect();
//! let answers: Vec<Pose> = stamps.iter().map(|&t| Pose::new(t, 0.3, 0.0)).collect();
//! let reference = Trajectory::in_plane("truth", Some(stamps.clone()), &truth)?;
//! let estimate = Trajectory::in_plane("my filter", Some(stamps), &answers)?;
//! let evaluation = evaluate(&estimate, &reference, None, &EvaluationOptions::default())?;
//! assert_eq!((evaluation.matched, evaluation.total), (20, 20));
//! assert!((evaluation.ape.translation_m.rmse - 0.3).abs() < 1e-12);
//! assert!(evaluation.rpe.translation_m.max < 1e-12); // it does not drift
//! # Ok::<(), ballmark::Error>(())
//! ```

mod alignment;
mod association;
mod errors;
mod evaluation;
mod format;
mod pairs;
mod pose3;
mod poses;
mod rotation;
mod runs;
mod statistics;
mod traces;

pub use alignment::{Alignment, Similarity};
pub use association::{Matching, Pairing};
pub use errors::{ErrorStatistics, PoseErrors};
pub use evaluation::{
    AppliedAlignment, Evaluation, EvaluationOptions, LEAST_COMPLETENESS, MeasuredPairs, evaluate,
};
pub use format::{Format, OutputFormat, read, read_times, write};
pub use pairs::{Delta, DeltaUnit};
pub use pose3::Pose3;
pub use poses::Trajectory;
pub use runs::{RunEvaluation, RunFacts, RunsEvaluation};
pub use statistics::Statistics;
pub use traces::RunTraces;
