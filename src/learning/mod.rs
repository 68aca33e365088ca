//! Making detectors better: the objective, and descending it.

pub mod objective;
pub mod prior_operator;
