//! Making detectors better: the objective, and descending it.

pub mod checkpoint;
mod lanes;
pub mod lesson;
pub mod objective;
pub mod optimiser;
pub mod prior_operator;
pub mod recipe;
pub mod trainer;

pub use lanes::Real;
pub use recipe::Recipe;
