//! What a detector is fed: ranges clipped, pooled over neighbouring beams, everything normalised.
//!
//! T98's inputs are a few hundred numbers of any kind; these are the same few hundred numbers whatever the sensor. All
//! constants are fitted once on the training part and kept in the model, so that the robot needs nothing else.

use super::check_width;
use crate::{
    error::{Error, Result},
    recording::{Channel, Recording},
};
use ndarray::{Array2, ArrayView1, ArrayView2, Axis};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How raw channel values become inputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InputConfig {
    /// Channels to use, by name; none named: all of the recording.
    pub channels: Vec<String>,
    /// Ranges beyond this count as this, in metres; so does "no return".
    pub clip_m: f64,
    /// Sectors that the beams of a range sensor are pooled into; a sensor with fewer beams keeps one sector a beam.
    pub sectors: usize,
    /// What is kept of the beams of a sector.
    pub sector_values: Vec<SectorValue>,
}

/// A statistic of the ranges in a sector.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SectorValue {
    /// The shortest.
    Nearest,
    /// The median (of an even number: the lower).
    Middle,
    /// The longest.
    Farthest,
}

impl Default for InputConfig {
    fn default() -> Self {
        Self {
            channels: Vec::new(),
            clip_m: 8.0,
            sectors: 36,
            sector_values: vec![
                SectorValue::Nearest,
                SectorValue::Middle,
                SectorValue::Farthest,
            ],
        }
    }
}

impl InputConfig {
    /// # Errors
    /// Where a value makes no sense; the message names the key.
    pub fn check(&self) -> Result<()> {
        if !(self.clip_m.is_finite() && self.clip_m > 0.0) {
            return Err(Error::usage(format!(
                "input.clip_m = {}: expected a positive number of metres",
                self.clip_m
            )));
        }
        if self.sectors == 0 || self.sector_values.is_empty() {
            return Err(Error::usage(
                "input.sectors and input.sector_values: expected at least one of each",
            ));
        }
        Ok(())
    }
}

/// A fitted preprocessing: from raw values to inputs of mean 0 and deviation 1.
///
/// As JSON it has no mean and deviation: a model keeps them as arrays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Input {
    channels: Vec<ChannelInput>,
    /// Mean of every input over the training part, before normalising.
    #[serde(skip)]
    pub mean: Vec<f32>,
    /// Standard deviation of every input over the training part, never 0.
    #[serde(skip)]
    pub deviation: Vec<f32>,
}

/// What becomes of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct ChannelInput {
    name: String,
    width: usize,
    unit: String,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    /// Ranges: clipped, pooled; a missing return counts as the clip.
    Ranges {
        clip: f32,
        sectors: usize,
        sector_values: Vec<SectorValue>,
    },
    /// Anything else: taken as it is; a missing value counts as the mean.
    Values,
}

/// An input whose deviation is less than this share of its mean never varied in training: it is divided by 1, not by a
/// rounding error.
const SMALLEST_VARIATION: f32 = 1e-6;

impl Input {
    /// Fits the preprocessing to some snapshots of a recording.
    ///
    /// # Errors
    /// Where the configuration names a channel that the recording lacks.
    pub fn fit(config: &InputConfig, recording: &Recording, snapshots: &[usize]) -> Result<Self> {
        config.check()?;
        let wanted: Vec<&Channel> = if config.channels.is_empty() {
            recording.channels().iter().collect()
        } else {
            let named = |name: &String| recording.channels().iter().find(|c| c.name == *name);
            config
                .channels
                .iter()
                .map(|name| named(name).ok_or_else(|| missing(name, recording.channels())))
                .collect::<Result<_>>()?
        };
        let channels = wanted
            .into_iter()
            .map(|channel| ChannelInput::new(config, channel))
            .collect();
        let mut input = Self {
            channels,
            mean: Vec::new(),
            deviation: Vec::new(),
        };
        let all = input.arrange(recording.channels(), recording.values().view())?;
        let raw = all.select(Axis(0), snapshots);
        let pooled = input.pool(raw.view());
        for column in pooled.columns() {
            let (mean, deviation) = mean_and_deviation(column);
            input.mean.push(mean);
            let varies = deviation > SMALLEST_VARIATION * mean.abs();
            input.deviation.push(if varies { deviation } else { 1.0 });
        }
        Ok(input)
    }

    /// Checks what may have come from a file, so that it can be used without fear.
    ///
    /// # Errors
    /// Where channels, sectors and constants don't fit one another; the message names the fault.
    pub fn check(&self) -> Result<()> {
        let wrong = |fault: String| Err(Error::work(fault));
        let mut inputs = 0usize;
        for channel in &self.channels {
            if !channel.is_sound() {
                return wrong(format!(
                    "channel `{}`: expected values, a clip above 0, 1 sector to one a value, and what is kept of each",
                    channel.name.escape_debug()
                ));
            }
            inputs = inputs.saturating_add(channel.inputs());
        }
        let (mean, deviation) = (self.mean.len(), self.deviation.len());
        if inputs == 0 || mean != inputs || deviation != inputs {
            return wrong(format!(
                "{mean} means and {deviation} deviations; expected {inputs} of each, one an input, and at least one"
            ));
        }
        match self
            .deviation
            .iter()
            .find(|d| !(d.is_finite() && **d > 0.0))
        {
            Some(d) => wrong(format!("a deviation of {d}; expected all above 0")),
            None => Ok(()),
        }
    }

    /// The same inputs with one deviation for all of a channel, so that distances between inputs are those between the
    /// pooled readings, in proportion.
    pub fn with_common_scale(mut self) -> Self {
        let mut from = 0;
        for channel in &self.channels {
            let own = &mut self.deviation[from..from + channel.inputs()];
            let mean_square = own.iter().map(|d| d * d).sum::<f32>() / own.len().max(1) as f32;
            own.fill(mean_square.sqrt());
            from += channel.inputs();
        }
        self
    }

    /// Number of inputs that the networks get.
    pub fn width(&self) -> usize {
        self.mean.len()
    }

    /// Normalised inputs of every snapshot, `[snapshot, input]`.
    ///
    /// # Errors
    /// Where the recording lacks a channel that the model was trained on, or has it in another width or unit.
    pub fn transform(&self, recording: &Recording) -> Result<Array2<f32>> {
        self.transform_values(recording.channels(), recording.values().view())
    }

    /// Normalised inputs of raw values `[snapshot, value]`, those of `channels` side by side: `[snapshot, input]`.
    ///
    /// # Errors
    /// As [`Input::transform`], and where a snapshot has another number of values than the channels say.
    pub fn transform_values(
        &self,
        channels: &[Channel],
        values: ArrayView2<f32>,
    ) -> Result<Array2<f32>> {
        let raw = self.arrange(channels, values)?;
        Ok(self.normalise(self.pool(raw.view())))
    }

    /// Names, widths and units of the channels that the inputs come from.
    pub fn describe(&self) -> String {
        let names: Vec<String> = self
            .channels
            .iter()
            .map(|c| format!("{} ({})", c.name, c.width))
            .collect();
        names.join(", ")
    }

    /// Does a recording with these channels have all that the inputs come from?
    ///
    /// # Errors
    /// Where a channel is missing or has another width or unit; the message names it.
    pub fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        let mut wanted = self.channels.iter();
        wanted.try_for_each(|wanted| wanted.find(channels).map(|_| ()))
    }

    /// The raw values of our channels side by side, `[snapshot, value]`.
    fn arrange(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>> {
        check_width(channels, values)?;
        let mut columns = Vec::new();
        for wanted in &self.channels {
            columns.extend(wanted.find(channels)?);
        }
        Ok(values.select(Axis(1), &columns))
    }

    fn pool(&self, raw: ArrayView2<f32>) -> Array2<f32> {
        let inputs = self.channels.iter().map(ChannelInput::inputs).sum();
        let mut pooled = Array2::zeros((raw.nrows(), inputs));
        pooled
            .axis_iter_mut(Axis(0))
            .into_par_iter()
            .zip(raw.axis_iter(Axis(0)))
            .for_each(|(mut pooled, raw)| {
                let raw: Vec<f32> = raw.to_vec();
                let (mut from, mut values) = (0, Vec::with_capacity(pooled.len()));
                for channel in &self.channels {
                    channel.pool(&raw[from..from + channel.width], &mut values);
                    from += channel.width;
                }
                pooled.assign(&ArrayView1::from(&values));
            });
        pooled
    }

    fn normalise(&self, mut pooled: Array2<f32>) -> Array2<f32> {
        for mut row in pooled.rows_mut() {
            for (value, (mean, deviation)) in
                row.iter_mut().zip(self.mean.iter().zip(&self.deviation))
            {
                *value = if value.is_nan() {
                    0.0
                } else {
                    (*value - mean) / deviation
                };
            }
        }
        pooled
    }
}

impl ChannelInput {
    fn new(config: &InputConfig, channel: &Channel) -> Self {
        let kind = if channel.unit == "m" {
            let clip = channel
                .maximum
                .map_or(config.clip_m, |maximum| maximum.min(config.clip_m))
                as f32;
            let sectors = config.sectors.min(channel.width);
            // Where every sector has one beam only, all statistics of it are that beam.
            let kept = if channel.width == sectors {
                1
            } else {
                config.sector_values.len()
            };
            let sector_values = config.sector_values[..kept].to_vec();
            Kind::Ranges {
                clip,
                sectors,
                sector_values,
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
    fn find(&self, channels: &[Channel]) -> Result<Range<usize>> {
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

    fn is_sound(&self) -> bool {
        self.width > 0
            && match &self.kind {
                Kind::Ranges {
                    clip,
                    sectors,
                    sector_values,
                } => {
                    clip.is_finite()
                        && *clip > 0.0
                        && (1..=self.width).contains(sectors)
                        && !sector_values.is_empty()
                }
                Kind::Values => true,
            }
    }

    fn inputs(&self) -> usize {
        match &self.kind {
            Kind::Ranges {
                sectors,
                sector_values,
                ..
            } => sectors * sector_values.len(),
            Kind::Values => self.width,
        }
    }

    fn pool(&self, raw: &[f32], out: &mut Vec<f32>) {
        let Kind::Ranges {
            clip,
            sectors,
            sector_values,
        } = &self.kind
        else {
            out.extend_from_slice(raw);
            return;
        };
        let clipped: Vec<f32> = raw
            .iter()
            .map(|r| {
                if r.is_nan() {
                    *clip
                } else {
                    r.clamp(0.0, *clip)
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
                SectorValue::Nearest => beams[0],
                SectorValue::Middle => beams[(beams.len() - 1) / 2],
                SectorValue::Farthest => beams[beams.len() - 1],
            }));
        }
    }
}

fn missing(name: &str, channels: &[Channel]) -> Error {
    let found: Vec<String> = channels
        .iter()
        .map(|c| format!("`{}` ({} values)", c.name, c.width))
        .collect();
    Error::work(format!(
        "no channel `{name}`; the recording has {}",
        found.join(", ")
    ))
}

fn mean_and_deviation(column: ArrayView1<f32>) -> (f32, f32) {
    let known: Vec<f64> = column
        .iter()
        .filter(|v| !v.is_nan())
        .map(|&v| f64::from(v))
        .collect();
    let n = known.len().max(1) as f64;
    let mean = known.iter().sum::<f64>() / n;
    let variance = known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    (mean as f32, variance.sqrt() as f32)
}
