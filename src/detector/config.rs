//! Constants that a detector is fitted with: landmarks that people chose, and anybody's own detector.

use super::{
    Detector,
    ceiling_light::CeilingLight,
    door::{Door, DoorConfig},
};
use crate::{
    error::Result,
    recording::Recording,
    registry::{Constants, boxed_config},
};
use serde::{Deserialize, Serialize};

/// Constants that a detector is fitted with: [`HandMade`], or a type of one's own.
pub trait DetectorConfig: Constants + BoxedDetectorConfig {
    /// The detector, fitted to some snapshots of a recording (the mapping part) where it has something to fit.
    ///
    /// # Errors
    /// Where a constant makes no sense (a usage error), or the recording lacks the sensors that it needs.
    fn fit(&self, recording: &Recording, mapping: &[usize]) -> Result<Box<dyn Detector>>;

    /// What it looks for, where that is something a plan has: it can then be judged by the plan.
    fn hand_made(&self) -> Option<&HandMade> {
        None
    }
}

boxed_config!(DetectorConfig, BoxedDetectorConfig);

/// Landmarks that people chose, in place of learned ones (Thrun 1998, 5.3).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum HandMade {
    /// Doors, as of Koenig & Simmons (1996).
    Door(DoorConfig),
    /// Ceiling lights, as of King & Weiman (1990).
    CeilingLight(CeilingLight),
}

impl HandMade {
    /// The names of all of them.
    pub const NAMES: [&'static str; 2] = ["door", "ceiling_light"];
}

impl Constants for HandMade {
    fn kind(&self) -> &str {
        match self {
            HandMade::Door(_) => Self::NAMES[0],
            HandMade::CeilingLight(_) => Self::NAMES[1],
        }
    }

    fn description(&self) -> &str {
        match self {
            HandMade::Door(_) => "Doors, as of Koenig & Simmons (1996).",
            HandMade::CeilingLight(_) => "Ceiling lights, as of King & Weiman (1990).",
        }
    }

    fn check(&self) -> Result<()> {
        match self {
            HandMade::Door(config) => config.check(),
            HandMade::CeilingLight(light) => light.check(),
        }
    }
}

impl DetectorConfig for HandMade {
    fn fit(&self, recording: &Recording, mapping: &[usize]) -> Result<Box<dyn Detector>> {
        Ok(match self {
            HandMade::Door(config) => Box::new(Door::fit(config, recording, mapping)?),
            HandMade::CeilingLight(light) => Box::new(light.clone()),
        })
    }

    fn hand_made(&self) -> Option<&HandMade> {
        Some(self)
    }
}
