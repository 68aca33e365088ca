//! What becomes of one channel: ranges are clipped and pooled over neighbouring beams, other values are taken as they are.

use super::{
    ScanShape,
    config::{InputConfig, SectorValue},
    sectors::beams_of_sectors,
};
use crate::{
    error::{Error, Result},
    geometry::wrapped,
    recording::Channel,
};
use ndarray::ArrayView2;
use serde::{Deserialize, Serialize};
use std::{collections::BTreeSet, f64::consts::TAU, ops::Range};

/// What becomes of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct ChannelInput {
    pub(super) name: String,
    pub(super) width: usize,
    unit: String,
    pub(super) kind: Kind,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    /// Ranges: clipped, pooled; a missing return counts as the clip.
    Ranges {
        clip: f32,
        #[serde(default = "former_far_clip")]
        far_clip: f32,
        sectors: usize,
        sector_values: Vec<SectorValue>,
        #[serde(default)]
        ring: bool,
        /// Beams of each sector, where these are sectors of another sensor; none: neighbouring beams, evenly dealt.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        sector_beams: Option<Vec<Vec<usize>>>,
    },
    /// Anything else: taken as it is. A missing value counts as the mean; of those that were missing in training, whether they are
    /// is an input too.
    Values {
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        may_miss: Vec<usize>,
    },
}

/// Models that were written before it was a key have no statistic that asks for it.
fn former_far_clip() -> f32 {
    f32::MAX
}

impl ChannelInput {
    pub(super) fn new(config: &InputConfig, channel: &Channel) -> Self {
        // Distances in unknown directions are a scan if they are many, else ranges to single things, which may be far.
        let is_scan = channel.bearing_rad.is_some() || channel.width > config.sectors;
        let kind = if channel.unit == "m" && is_scan {
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
                sector_beams: None,
            }
        } else {
            Kind::Values {
                may_miss: Vec::new(),
            }
        };
        Self {
            name: channel.name.clone(),
            width: channel.width,
            unit: channel.unit.clone(),
            kind,
        }
    }

    /// Has the values that some of these snapshots lack, `[snapshot, value]`, told as inputs of their own; of those that are always
    /// missing together, the first.
    pub(super) fn tell_missing(&mut self, raw: ArrayView2<f32>) {
        let Kind::Values { may_miss } = &mut self.kind else {
            return;
        };
        may_miss.clear();
        let mut known: BTreeSet<Vec<bool>> = BTreeSet::new();
        for (value, column) in raw.columns().into_iter().enumerate() {
            let lacks: Vec<bool> = column.iter().map(|value| value.is_nan()).collect();
            if lacks.contains(&true) && known.insert(lacks) {
                may_miss.push(value);
            }
        }
    }

    /// How many of the inputs, the last ones, say whether a value is missing.
    pub(super) fn told_missing(&self) -> usize {
        match &self.kind {
            Kind::Values { may_miss } => may_miss.len(),
            Kind::Ranges { .. } => 0,
        }
    }

    /// These sectors and their statistics for another sensor's beams, by the bearings of both; `None` where a bearing is not known, or
    /// where that sensor looks into less than two thirds of the sectors.
    pub(super) fn looked_into_by(&self, own: &Channel, other: &Channel) -> Option<Self> {
        let (own_rad, other_rad) = (own.bearing_rad.as_ref()?, other.bearing_rad.as_ref()?);
        let mut looked_into = self.clone();
        looked_into.name.clone_from(&other.name);
        looked_into.width = other.width;
        let Kind::Ranges {
            sectors,
            sector_beams,
            ..
        } = &mut looked_into.kind
        else {
            return None;
        };
        let beams = beams_of_sectors(own_rad, *sectors, other_rad);
        let filled = beams.iter().filter(|beams| !beams.is_empty()).count();
        *sector_beams = Some(beams);
        (other.unit == self.unit && 3 * filled >= 2 * *sectors).then_some(looked_into)
    }

    /// The same sectors where only some beams of the sensor are there.
    pub(super) fn of_beams(&self, own: &Channel, kept: &[usize]) -> Option<Self> {
        let bearing_rad = own.bearing_rad.as_ref()?;
        let thinned = Channel {
            width: kept.len(),
            bearing_rad: Some(kept.iter().map(|&beam| bearing_rad[beam]).collect()),
            offset_m: None, // sectors are of directions alone
            ..own.clone()
        };
        let mut of_beams = self.looked_into_by(own, &thinned)?;
        of_beams.width = self.width;
        if let Kind::Ranges {
            sector_beams: Some(beams),
            ..
        } = &mut of_beams.kind
        {
            beams
                .iter_mut()
                .flatten()
                .for_each(|beam| *beam = kept[*beam]);
        }
        Some(of_beams)
    }

    /// What of its inputs are, with mean and deviation taken off, if whatever is farther than `reach_m` has no return. That is known of
    /// pooled values: no return is the longest range, and order is kept.
    pub(super) fn within_reach(
        &self,
        reach_m: f32,
        (mean, deviation): (&[f32], &[f32]),
        inputs: &mut [f32],
    ) {
        let Kind::Ranges {
            clip,
            far_clip,
            sectors,
            sector_values,
            ..
        } = &self.kind
        else {
            return;
        };
        for (k, value) in inputs.iter_mut().enumerate() {
            let (limit, none) = match sector_values[k / sectors].is_log() {
                true => (reach_m.ln_1p(), far_clip.ln_1p()),
                false => (reach_m, *clip),
            };
            if *value * deviation[k] + mean[k] > limit {
                *value = (none - mean[k]) / deviation[k];
            }
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
                    sector_beams,
                } => {
                    let is_filled = match sector_beams {
                        None => (1..=self.width).contains(sectors),
                        Some(beams) => {
                            let all = || beams.iter().flatten();
                            beams.len() == *sectors
                                && all().next().is_some()
                                && all().all(|&beam| beam < self.width)
                        }
                    };
                    clip.is_finite()
                        && *clip > 0.0
                        && far_clip.is_finite()
                        && far_clip >= clip
                        && is_filled
                        && !sector_values.is_empty()
                }
                Kind::Values { may_miss } => may_miss.iter().all(|&value| value < self.width),
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
            Kind::Values { .. } => None,
        }
    }

    pub(super) fn inputs(&self) -> usize {
        match &self.kind {
            Kind::Ranges {
                sectors,
                sector_values,
                ..
            } => sectors * sector_values.len(),
            Kind::Values { may_miss } => self.width + may_miss.len(),
        }
    }

    pub(super) fn pool(&self, raw: &[f32], out: &mut Vec<f32>) {
        let (clip, far_clip, sectors, sector_values, sector_beams) = match &self.kind {
            Kind::Ranges {
                clip,
                far_clip,
                sectors,
                sector_values,
                ring: _,
                sector_beams,
            } => (clip, far_clip, sectors, sector_values, sector_beams),
            Kind::Values { may_miss } => {
                out.extend_from_slice(raw);
                let is_there = |&value: &usize| f32::from(u8::from(!raw[value].is_nan()));
                out.extend(may_miss.iter().map(is_there));
                return;
            }
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
            let mut beams: Vec<f32> = match sector_beams {
                Some(beams) => beams[sector].iter().map(|&beam| clipped[beam]).collect(),
                None => {
                    let dealt = sector * raw.len() / sectors..(sector + 1) * raw.len() / sectors;
                    clipped[dealt].to_vec()
                }
            };
            beams.sort_by(f32::total_cmp);
            sorted.push(beams);
        }
        for value in sector_values {
            out.extend(sorted.iter().map(|beams| match (value, beams.len()) {
                (_, 0) => f32::NAN, // nothing looks there
                (SectorValue::Nearest, _) => beams[0].min(*clip),
                (SectorValue::Middle, n) => beams[(n - 1) / 2].min(*clip),
                (SectorValue::Farthest, n) => beams[n - 1].min(*clip),
                (SectorValue::MiddleLog, n) => beams[(n - 1) / 2].ln_1p(),
                (SectorValue::FarthestLog, n) => beams[n - 1].ln_1p(),
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
