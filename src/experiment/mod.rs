//! The loop that knows everyone: truth and response meet only here.

pub mod compare;
pub mod contenders;
pub mod convergence;
pub mod error_reduction;
pub mod global;
pub mod held_out;
pub mod kernels;
pub mod landmarks;
pub mod laps;
pub mod printed;
pub mod recognition;
pub mod reproduce;
pub mod stage;
pub mod standard;
pub mod trials;
