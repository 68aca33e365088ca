//! A trained model: what the robot needs to recognise and to localise, as one file.
//!
//! The file is a list of named arrays and one JSON text, in either of two containers that everything reads:
//! [`safetensors`] and [`npz`]. Names and shapes:
//!
//! | array | shape | what |
//! |---|---|---|
//! | `filter.convolution.{layer}.weight` | `[out, in, tap]` f32 | convolutions over the sectors of a scan; often none |
//! | `filter.convolution.{layer}.bias` | `[out]` f32 | |
//! | `filter.trunk.{layer}.weight` | `[out, in]` f32 | layers that all networks share, from the input; often none |
//! | `filter.trunk.{layer}.bias` | `[out]` f32 | |
//! | `filter.{i}.{layer}.weight` | `[out, in]` f32 | network of feature i, layers from trunk (or input) to output |
//! | `filter.{i}.{layer}.bias` | `[out]` f32 | |
//! | `input.mean`, `input.deviation` | `[inputs]` f32 | normalisation of the pooled values |
//! | `map.pose` | `[K, 3]` f64 | training places: m, m, rad |
//! | `map.route` | `[K]` f64 | their coordinate along the route, where they have one |
//! | `map.activation` | `[K, n]` f32 | raw activations there |
//! | `map.occupancy` | `[rows, columns]` u8 | from the south-west: 0 free, 100 occupied, 255 unknown; where scans are rendered |
//!
//! Several sets for several uncertainties are a [`ModelBank`]: a set's arrays stand behind `set.{uncertainty}.`.
//!
//! The JSON (metadata key `ballmark`, array `meta` in `.npz`) holds [`Header`]; in `.safetensors` its first key `sha256`
//! is a digest of the rest of it and of all arrays, which is checked where it is there.

mod arrays;
mod bank;
mod bank_file;
mod bank_names;
mod fallback;
mod file;
mod forgetting;
mod header;
mod layout;
mod memory;
mod note;
pub mod npz;
pub mod onnx;
mod pretrained;
mod remembered;
mod report;
pub mod safetensors;
pub mod seen;
mod shipped;
mod trained_model;
mod training;
mod update;
mod update_config;
mod visits;

pub use bank::{ModelBank, held_apart};
pub use header::{Header, OccupancyHeader, Scores, TrainingRecord, UpdateRecord};
pub use memory::Memory;
pub use note::Note;
pub use report::TrainingReport;
pub use trained_model::Model;
pub use training::{Learned, Resume, Training};
pub use update::{Updated, update};
pub use update_config::UpdateConfig;

#[cfg(test)]
mod tests;
