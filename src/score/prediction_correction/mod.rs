//! What a localiser's correction is worth, apart from its prediction: the metric of Ruiz-Mayor, Triviño & Bailador, *A
//! performance metric for mobile robot localization*, ICINCO 2006 (R06), section 3.
//!
//! A localiser predicts where a move has led (the prior estimate), then corrects that by what its sensors see (the posterior estimate).
//! Good odometry alone makes small errors, and a correction that copies its prior looks as good as its odometry. So three
//! [`Traces`] of a run are asked for: real poses, prior and posterior estimates (eq. 3-1). Their [`EstimationErrors`] (3-2 to 3-4)
//! are judged as they are (3.3): percentiles, [`TruthLimit`], share of [`Optimal`] estimates, merit μ + σ (4-2); and the
//! posterior ones relative to the prior ones (3.4): [`CorrectionFactors`] C_XY, C_T, C_XYT, and the posterior error [by intervals
//! of the prior's](PriorInterval). [`PredictionCorrection`] holds all of it, run by run and of all runs together.
//!
//! ```
//! use ballmark::{Pose, score::prediction_correction::{MetricOptions, PredictionCorrection, Traces}};
//! let real: Vec<Pose> = (0..10).map(|k| Pose::new(k as f64, 0.0, 0.0)).collect();
//! let off = |by: f64| -> Vec<Pose> { real.iter().map(|p| Pose::new(p.x_m, by, 0.0)).collect() };
//! let (prior, posterior) = (off(0.4), off(0.1));
//! let run = Traces { name: "R1", real: &real, prior: &prior, posterior: &posterior };
//! let metric = PredictionCorrection::of(&[run], &MetricOptions::default())?;
//! assert_eq!(metric.overall.correction.position.not_worse, 1.0); // C_XY
//! assert!((metric.overall.posterior.position_m.merit - 0.1).abs() < 1e-12); // μ + σ, with σ = 0
//! // A correction that copies the prior is no worse anywhere, and better nowhere.
//! let copied = Traces { posterior: &prior, ..run };
//! let metric = PredictionCorrection::of(&[copied], &MetricOptions::default())?;
//! let position = metric.overall.correction.position;
//! assert_eq!((position.not_worse, position.better, position.unchanged), (1.0, 0.0, 10));
//! # Ok::<(), ballmark::Error>(())
//! ```

mod conditions;
mod errors;
mod factors;
mod intervals;
mod limits;
mod metric;
mod quantity;

pub use conditions::{FrameworkReport, RunConditions};
pub use errors::{ErrorSummary, EstimationErrors, Percentiles, PositionAndHeading, Traces};
pub(crate) use factors::TIE;
pub use factors::{CorrectionFactor, CorrectionFactors};
pub use intervals::{PriorInterval, by_prior_error};
pub use limits::{Optimal, Precision, SearchStep, TruthLimit};
pub use metric::{MetricOptions, PredictionCorrection, RunMetric};
pub use quantity::{Edges, PositionHeading};
