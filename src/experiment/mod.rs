//! The loop that knows everyone: truth and response meet only here.

pub mod compare;
pub mod convergence;
pub mod error_reduction;
pub mod held_out;
pub mod kernels;
pub mod landmarks;
pub mod laps;
pub mod localisation;
pub mod methods;
pub mod printed;
pub mod protocol;
pub mod recognition;
pub mod reproduce;
pub mod standard;
pub mod trials;
