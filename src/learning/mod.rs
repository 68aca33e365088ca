//! Making detectors better: the objective, and descending it.

pub mod checkpoint;
pub mod draw;
mod lanes;
pub mod lesson;
pub mod line_search;
pub mod mean_field;
pub mod objective;
pub mod optimiser;
pub mod prior_operator;
pub mod recipe;
pub mod smoothing;
pub mod task;
pub mod trainer;

pub use lanes::Real;
pub use recipe::Recipe;
