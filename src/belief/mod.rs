//! Where the robot may be.
//!
//! [`Places`] are where snapshots were taken; a [`Grid`] cuts the places where the robot can be into cells; a [`Belief`]
//! gives each of them a mass; a [`FeatureMap`] says what the detectors answer there, a [`SignalField`] what is read there; [`Evidence`] turns one answer into a
//! likelihood; [`OdometryMotion`] says how the robot moves; [`BayesFilter`] puts them together (Thrun 1998, Table 1).

pub mod bayes;
#[allow(clippy::module_inception)] // the room's main noun is its name
pub mod belief;
pub mod code_map;
mod columns;
mod combination;
mod correction;
pub mod evidence;
pub mod expected_information;
pub mod expected_posterior_error;
pub mod grid;
pub mod held_apart;
mod hindsight;
mod kernel;
mod lattice;
pub mod lost;
pub mod map;
mod modes;
mod moments;
pub mod motion;
mod motion_fit;
pub mod neighbours;
pub mod places;
pub mod prior;
pub mod signal_field;
pub mod smoothing;
mod support;
pub mod thinning;
mod transport;
mod turn;

#[cfg(test)]
mod laws;
#[cfg(test)]
mod reference_tests;

pub use bayes::BayesFilter;
pub use belief::Belief;
pub use code_map::CodeMap;
pub use evidence::Evidence;
pub use grid::{Grid, GridConfig};
pub use hindsight::{Hindsight, KEPT};
pub use map::{FeatureMap, FilledFrom, GridMap, MapConfig};
pub use modes::Mode;
pub use motion::OdometryMotion;
pub use neighbours::{Nearness, Neighbours};
pub use places::Places;
pub use prior::Uncertainty;
pub use signal_field::{SignalField, SignalFieldAt, SignalFieldConfig};
