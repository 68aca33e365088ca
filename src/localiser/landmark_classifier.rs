//! Localising by what is seen now alone: the nearest neighbour among the places of the evidence-based localiser's map.
//!
//! Duckett & Nehmzow (1998), 7.2: "the current sensory input is classified according to its nearest neighbour amongst a set
//! of stored prototypes", by eq. 1; "we used exactly the same stored prototypes created by the map building component" of
//! evidence-based localisation. Under the same `map` constants it does.

use super::{
    Learn, Localiser, TrialRunner,
    place_map::{PlaceMap, PlaceMapConfig},
    prepared::{Answers, Prepared},
};
use crate::{
    error::Result,
    recording::{Channel, Recording},
    seed::Seed,
};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The map, as for evidence-based localisation.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LandmarkClassifierConfig {
    /// D, T and the weights of the channels.
    pub map: PlaceMapConfig,
}

impl LandmarkClassifierConfig {
    /// # Errors
    /// A usage error where a constant makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        let checked = self.map.check();
        checked.map_err(|e| e.context("landmark_classifier"))
    }
}

/// Prototypes of places.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LandmarkClassifier {
    map: PlaceMap,
}

impl LandmarkClassifier {
    /// The map that was learned.
    pub fn map(&self) -> &PlaceMap {
        &self.map
    }
}

impl Localiser for LandmarkClassifier {
    fn name(&self) -> &'static str {
        "landmark_classifier"
    }

    fn places(&self) -> usize {
        self.map.places().len()
    }

    fn bytes_per_place(&self) -> usize {
        self.map.bytes_per_place()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.map.check_channels(channels)
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn TrialRunner + 'a>> {
        self.check_channels(recording.channels())?;
        let nearest = |&k: &usize| {
            let signature = self
                .map
                .signature(recording.channels(), &recording.observation(k))?;
            let differences = self.map.differences(&signature);
            self.map.nearest_in_signature(&differences)
        };
        let answers = snapshots.par_iter().map(nearest).collect();
        Ok(Box::new(Answers(Prepared::new(snapshots, answers))))
    }
}

impl Learn for LandmarkClassifier {
    type Config = LandmarkClassifierConfig;

    fn learn(
        config: &LandmarkClassifierConfig,
        recording: &Recording,
        snapshots: &[usize],
        _: Seed,
    ) -> Result<Self> {
        let map = PlaceMap::build(&config.map, recording, snapshots);
        Ok(Self {
            map: map.map_err(|e| e.context("landmark_classifier"))?,
        })
    }

    fn check(&self) -> Result<()> {
        self.map.check()
    }
}
