//! Experiments: systems answer, and their answers are compared with the truth, which only this room has.

pub mod compare;
pub mod convergence;
pub mod error_reduction;
pub mod evidence_tuning;
pub mod held_out;
pub mod kernels;
pub mod landmarks;
pub mod laps;
pub mod line_up;
pub mod localisation;
mod localisation_record;
pub mod localise_config;
mod maps;
pub mod method;
pub mod methods;
pub mod parts;
pub mod printed;
pub mod product;
pub mod protocol;
pub mod recall;
pub mod recognition;
pub mod reproduce;
mod sequences;
mod signal_row;
pub mod standard;
pub mod trials;
