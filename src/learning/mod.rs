//! Making detectors better: the objective, and descending it.

pub mod error_reduction;
pub mod every_pose;
mod lanes;
pub mod line_search;
pub mod mean_field;
pub mod mini_batch;
pub mod objective;
pub mod optimiser;
pub mod pretraining;
pub mod prior_operator;
pub mod problem;
pub mod recipe;
pub mod smoothing;
pub mod start;
pub mod trainer;
pub mod training_set;

pub use error_reduction::{ErrorReduction, Errors};
pub use lanes::Real;
pub use recipe::Recipe;
