//! How a robot labels what it sensed, as a configuration says it.

use crate::{
    belief::GridConfig,
    error::{Error, Result},
    localiser::lost::LostConfig,
};
use serde::{Deserialize, Serialize};

/// Which belief a label is read off.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LabelsFrom {
    /// What the whole run tells of each of its moments.
    #[default]
    Smoothed,
    /// What was known at the moment itself.
    Filtered,
}

/// What must be believed for a label to be kept.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum GateOver {
    /// What is sensed about the label's own moment.
    Moment,
    /// The run as a whole: places that have changed contradict the map, which is no reason not to learn what they are now, as long as
    /// the way from one to the next fits the rest of the run.
    #[default]
    Run,
}

/// How a robot labels what it sensed, and which labels it believes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SelfLabelConfig {
    /// Metres, by odometry, between two snapshots that correct the belief (Thrun 1998, 5.2.4).
    pub spacing_m: f64,
    /// Which belief a label is read off.
    pub from: LabelsFrom,
    /// Labels are kept whose lost score is at most this, 0 to 1, and whose belief has one mode. 1: all labels are kept, whatever is
    /// believed of them.
    pub gate: f64,
    /// What the score is of: the whole run, all of whose labels with one mode are then kept or none, or the label's own moment.
    pub gate_over: GateOver,
    /// What makes the score, of how well the belief of all other observations predicts each; its `threshold` is not asked.
    pub lost: LostConfig,
    /// Cells of the map.
    pub grid: GridConfig,
    /// How far the belief reaches beyond the map in the plane, in metres, so that a robot that goes on into a new room is not laid over the rooms
    /// next door. What is believed to be there is not kept. 0: the robot is on the map. Along a route there is no beyond.
    pub beyond_m: f64,
}

impl Default for SelfLabelConfig {
    fn default() -> Self {
        Self {
            spacing_m: 0.5,
            from: LabelsFrom::default(),
            gate: 0.1,
            gate_over: GateOver::default(),
            // Here r is what the belief of all other observations predicts of each, and needs other constants.
            lost: LostConfig {
                short: 0.4,
                base: 1.0,
                slope: 3.0,
                ..LostConfig::default()
            },
            grid: GridConfig::default(),
            beyond_m: 5.0,
        }
    }
}

impl SelfLabelConfig {
    /// # Errors
    /// A usage error where a value makes no sense; the message names its key.
    pub fn check(&self) -> Result<()> {
        if !(0.01..=100.0).contains(&self.spacing_m) {
            return Err(Error::usage(format!(
                "labels.spacing_m = {}: expected 0.01 to 100 metres",
                self.spacing_m
            )));
        }
        if !(0.0..=1.0).contains(&self.gate) {
            return Err(Error::usage(format!(
                "labels.gate = {}: expected a lost score, 0 to 1 (1: no gate)",
                self.gate
            )));
        }
        if !(0.0..=1000.0).contains(&self.beyond_m) {
            return Err(Error::usage(format!(
                "labels.beyond_m = {}: expected 0 (the robot is on the map) to 1000 metres",
                self.beyond_m
            )));
        }
        self.grid.check()?;
        self.lost.check().map_err(|e| e.context("labels"))
    }

    /// Are all labels kept?
    pub(super) fn is_open(&self) -> bool {
        self.gate >= 1.0
    }
}
