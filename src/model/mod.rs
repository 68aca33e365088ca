//! A trained model: what the robot needs to recognise and to localise, as one file.
//!
//! The file is a list of named arrays and one JSON text, in either of two containers that everything reads:
//! [`safetensors`] and [`npz`]. Names and shapes:
//!
//! | array | shape | what |
//! |---|---|---|
//! | `filter.trunk.{layer}.weight` | `[out, in]` f32 | layers that all networks share, from the input; often none |
//! | `filter.trunk.{layer}.bias` | `[out]` f32 | |
//! | `filter.{i}.{layer}.weight` | `[out, in]` f32 | network of feature i, layers from trunk (or input) to output |
//! | `filter.{i}.{layer}.bias` | `[out]` f32 | |
//! | `input.mean`, `input.deviation` | `[inputs]` f32 | normalisation of the pooled values |
//! | `map.pose` | `[K, 3]` f64 | training places: m, m, rad |
//! | `map.route` | `[K]` f64 | their coordinate along the route, where they have one |
//! | `map.activation` | `[K, n]` f32 | raw activations there |
//!
//! The JSON (metadata key `ballmark`, array `meta` in `.npz`) holds [`Header`].

mod arrays;
mod file;
mod header;
mod layout;
mod note;
pub mod npz;
pub mod safetensors;
pub mod seen;
mod trained_model;
mod training;

pub use header::{Header, Scores, TrainingRecord};
pub use note::Note;
pub use trained_model::Model;
pub use training::{Learned, Resume, Training, TrainingReport};

#[cfg(test)]
mod tests;
