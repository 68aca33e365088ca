//! What the mapping part gives to every method alike: its places, and how a map of them is filled.

use super::parts::TrainingSource;
use crate::{
    belief::{MapConfig, OdometryMotion, Places},
    detector::input::InputConfig,
    model::Model,
};

/// The places of the mapping part that maps are made of, and what is known of the robot besides.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapped {
    /// Where the training snapshots were taken: the candidates of single-snapshot figures, and what the grid lies over.
    pub places: Places,
    /// How a map fills the places between.
    pub map: MapConfig,
    /// How far odometry can be trusted, as fitted on the training snapshots.
    pub motion: OdometryMotion,
    /// The channels that are worked from, and how they become inputs.
    pub input: InputConfig,
}

impl Mapped {
    /// What the training part of a recording gives by default, without a model.
    pub fn of(source: &TrainingSource) -> Self {
        let (recording, training) = (&*source.recording, &source.training);
        Self {
            places: Places::of(recording).select(training),
            map: MapConfig::default(),
            motion: OdometryMotion::fitted(recording, training),
            input: InputConfig::default(),
        }
    }
}

impl From<&Model> for Mapped {
    fn from(model: &Model) -> Self {
        let recipe = &model.header.recipe;
        Self {
            places: model.places(),
            map: recipe.map.clone(),
            motion: model.header.motion.clone(),
            // What is compared by its distance is compared in metres.
            input: recipe.input.linear(),
        }
    }
}
