//! How raw channel values become inputs, as data.

use crate::{
    error::{Error, Result},
    recording::history::check_back_m,
};
use serde::{Deserialize, Serialize};

/// How raw channel values become inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InputConfig {
    /// Channels to use, by name; none named: all of the recording.
    pub channels: Vec<String>,
    /// Ranges of a scan beyond this count as this, in metres; so does "no return". A few distances whose directions nobody knows, as
    /// to beacons, are no scan: they are taken as they are.
    pub clip_m: f64,
    /// The same of the statistics that are logarithms.
    pub far_clip_m: f64,
    /// Sectors that the beams of a range sensor are pooled into; a sensor with fewer beams keeps one sector a beam.
    pub sectors: usize,
    /// What is kept of the beams of a sector.
    pub sector_values: Vec<SectorValue>,
    /// Readings of so many metres back, by odometry, are inputs as well, with where they were taken; `[]`: of now alone. Not said:
    /// where no scan can be moved or rendered, `[]` or a choice by how closely snapshots lie, whichever does better on the
    /// validation part; elsewhere `[]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history_m: Option<Vec<f64>>,
}

/// A statistic of the ranges in a sector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SectorValue {
    /// The shortest.
    Nearest,
    /// The median (of an even number: the lower).
    Middle,
    /// The longest.
    Farthest,
    /// ln(1 + r) of the median r in metres, which is clipped much farther out: halls differ where rooms end.
    MiddleLog,
    /// The same of the longest.
    FarthestLog,
}

impl SectorValue {
    /// Is it the logarithm of a range?
    pub fn is_log(self) -> bool {
        matches!(self, Self::MiddleLog | Self::FarthestLog)
    }
}

impl Default for InputConfig {
    fn default() -> Self {
        Self {
            channels: Vec::new(),
            clip_m: 8.0,
            far_clip_m: 40.0,
            sectors: 36,
            sector_values: vec![
                SectorValue::Nearest,
                SectorValue::Middle,
                SectorValue::Farthest,
            ],
            history_m: None,
        }
    }
}

impl InputConfig {
    /// The default and, for sensors that see farther than ranges are clipped, how far that is: halls and long corridors differ
    /// where rooms end.
    pub fn far() -> Self {
        let mut config = Self::default();
        let logarithms = [SectorValue::MiddleLog, SectorValue::FarthestLog];
        config.sector_values.extend(logarithms);
        config
    }

    /// The same without logarithms: readings whose distances are metres.
    pub fn linear(&self) -> Self {
        let mut config = self.clone();
        config.sector_values.retain(|value| !value.is_log());
        if config.sector_values.is_empty() {
            config.sector_values = Self::default().sector_values;
        }
        config
    }

    /// # Errors
    /// Where a value makes no sense; the message names the key.
    pub fn check(&self) -> Result<()> {
        if !(self.clip_m.is_finite() && self.clip_m > 0.0) {
            return Err(Error::usage(format!(
                "input.clip_m = {}: expected a positive number of metres",
                self.clip_m
            )));
        }
        if !(self.far_clip_m.is_finite() && self.far_clip_m >= self.clip_m) {
            return Err(Error::usage(format!(
                "input.far_clip_m = {}: expected metres, no less than input.clip_m",
                self.far_clip_m
            )));
        }
        if let Some(back_m) = &self.history_m {
            check_back_m("input.history_m", back_m)?;
        }
        if self.sectors == 0 || self.sector_values.is_empty() {
            return Err(Error::usage(
                "input.sectors and input.sector_values: expected at least one of each",
            ));
        }
        Ok(())
    }
}
