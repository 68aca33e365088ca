//! What becomes of one channel: ranges are clipped and pooled over neighbouring beams, other values are taken as they are.

use super::{
    ScanShape,
    config::{InputConfig, SectorValue},
};
use crate::{
    error::{Error, Result},
    geometry::wrapped,
    recording::Channel,
};
use serde::{Deserialize, Serialize};
use std::{f64::consts::TAU, ops::Range};

/// What becomes of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ChannelInput {
    pub(super) name: String,
    pub(super) width: usize,
    unit: String,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    /// Ranges: clipped, pooled; a missing return counts as the clip.
    Ranges {
        clip: f32,
        #[serde(default = "former_far_clip")]
        far_clip: f32,
        sectors: usize,
        sector_values: Vec<SectorValue>,
        #[serde(default)]
        ring: bool,
    },
    /// Anything else: taken as it is; a missing value counts as the mean.
    Values,
}

/// Models that were written before it was a key have no statistic that asks for it.
fn former_far_clip() -> f32 {
    f32::MAX
}

impl ChannelInput {
    pub(super) fn new(config: &InputConfig, channel: &Channel) -> Self {
        let kind = if channel.unit == "m" {
            let within = |clip_m: f64| {
                channel
                    .maximum
                    .map_or(clip_m, |maximum| maximum.min(clip_m))
            };
            let (clip, far_clip) = (
                within(config.clip_m) as f32,
                within(config.far_clip_m) as f32,
            );
            let sectors = config.sectors.min(channel.width);
            let sector_values = kept(config, channel.width == sectors, far_clip > clip);
            Kind::Ranges {
                clip,
                far_clip,
                sectors,
                sector_values,
                ring: channel.bearing_rad.as_deref().is_some_and(is_ring),
            }
        } else {
            Kind::Values
        };
        Self {
            name: channel.name.clone(),
            width: channel.width,
            unit: channel.unit.clone(),
            kind,
        }
    }

    /// Columns of this channel among a recording's values.
    pub(super) fn find(&self, channels: &[Channel]) -> Result<Range<usize>> {
        let mut from = 0;
        for channel in channels {
            if channel.name == self.name {
                if channel.width != self.width || channel.unit != self.unit {
                    return Err(Error::work(format!(
                        "channel `{}` has {} values in `{}`; the model was trained on {} in `{}`",
                        self.name, channel.width, channel.unit, self.width, self.unit
                    )));
                }
                return Ok(from..from + self.width);
            }
            from += channel.width;
        }
        Err(missing(&self.name, channels))
    }

    pub(super) fn is_sound(&self) -> bool {
        self.width > 0
            && match &self.kind {
                Kind::Ranges {
                    clip,
                    far_clip,
                    sectors,
                    sector_values,
                    ring: _,
                } => {
                    clip.is_finite()
                        && *clip > 0.0
                        && far_clip.is_finite()
                        && far_clip >= clip
                        && (1..=self.width).contains(sectors)
                        && !sector_values.is_empty()
                }
                Kind::Values => true,
            }
    }

    /// The sectors, where there are any.
    pub(super) fn scan(&self) -> Option<ScanShape> {
        match &self.kind {
            Kind::Ranges {
                sectors,
                sector_values,
                ring,
                ..
            } => Some(ScanShape {
                statistics: sector_values.len(),
                sectors: *sectors,
                ring: *ring,
            }),
            Kind::Values => None,
        }
    }

    pub(super) fn inputs(&self) -> usize {
        match &self.kind {
            Kind::Ranges {
                sectors,
                sector_values,
                ..
            } => sectors * sector_values.len(),
            Kind::Values => self.width,
        }
    }

    pub(super) fn pool(&self, raw: &[f32], out: &mut Vec<f32>) {
        let Kind::Ranges {
            clip,
            far_clip,
            sectors,
            sector_values,
            ring: _,
        } = &self.kind
        else {
            out.extend_from_slice(raw);
            return;
        };
        let clipped: Vec<f32> = raw
            .iter()
            .map(|r| {
                if r.is_nan() {
                    *far_clip
                } else {
                    r.clamp(0.0, *far_clip)
                }
            })
            .collect();
        let mut sorted: Vec<Vec<f32>> = Vec::with_capacity(*sectors);
        for sector in 0..*sectors {
            let mut beams =
                clipped[sector * raw.len() / sectors..(sector + 1) * raw.len() / sectors].to_vec();
            beams.sort_by(f32::total_cmp);
            sorted.push(beams);
        }
        for value in sector_values {
            out.extend(sorted.iter().map(|beams| match value {
                SectorValue::Nearest => beams[0].min(*clip),
                SectorValue::Middle => beams[(beams.len() - 1) / 2].min(*clip),
                SectorValue::Farthest => beams[beams.len() - 1].min(*clip),
                SectorValue::MiddleLog => beams[(beams.len() - 1) / 2].ln_1p(),
                SectorValue::FarthestLog => beams[beams.len() - 1].ln_1p(),
            }));
        }
    }
}

/// The statistics that tell something new: of a sector of one beam all are that beam, and where a sensor sees no farther than
/// ranges are clipped, their logarithms are the same once more.
fn kept(config: &InputConfig, one_beam: bool, sees_farther: bool) -> Vec<SectorValue> {
    let mut kept: Vec<SectorValue> = Vec::new();
    for &value in &config.sector_values {
        let known = one_beam && kept.iter().any(|k| k.is_log() == value.is_log());
        if !known && (sees_farther || !value.is_log()) {
            kept.push(value);
        }
    }
    match kept.is_empty() {
        true => config.sector_values.clone(),
        false => kept,
    }
}

/// Beams that go all round: from one to the next they turn by a whole turn in all, the way from the last to the first included.
fn is_ring(bearing_rad: &[f64]) -> bool {
    let (Some(first), Some(last)) = (bearing_rad.first(), bearing_rad.last()) else {
        return false;
    };
    let steps = bearing_rad.windows(2).map(|w| wrapped(w[1] - w[0]));
    let turned_rad: f64 = steps.sum();
    let apart_rad = turned_rad.abs() / (bearing_rad.len() - 1).max(1) as f64;
    let gap_rad = wrapped(first - last).abs();
    turned_rad.abs() > TAU / 2.0 && gap_rad <= 1.5 * apart_rad
}

pub(super) fn missing(name: &str, channels: &[Channel]) -> Error {
    let found: Vec<String> = channels
        .iter()
        .map(|c| format!("`{}` ({} values)", c.name, c.width))
        .collect();
    Error::work(format!(
        "no channel `{name}`; the recording has {}",
        found.join(", ")
    ))
}

#[cfg(test)]
mod tests;
