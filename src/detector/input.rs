//! What a detector is fed: ranges clipped, pooled over neighbouring beams, everything normalised.
//!
//! T98's inputs are a few hundred numbers of any kind; these are the same few hundred numbers whatever the sensor. All
//! constants are fitted once on the training part and kept in the model, so that the robot needs nothing else.

mod channel;
mod config;
mod sectors;
mod steps;

pub use config::{InputConfig, SectorValue};
pub use steps::ChannelSteps;

use super::check_width;
use crate::{
    error::{Error, Result},
    recording::{Channel, Recording},
};
use channel::{ChannelInput, missing};
use ndarray::{Array2, ArrayView1, ArrayView2, Axis};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What the inputs are, to networks that look for the same in every direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InputShape {
    /// Their number.
    pub width: usize,
    /// Where all are the sectors of one range sensor: how many, and what there is of each.
    pub scan: Option<ScanShape>,
}

/// The sectors of a range sensor, statistic by statistic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanShape {
    /// What is kept of every sector.
    pub statistics: usize,
    /// Sectors.
    pub sectors: usize,
    /// Whether the last sector lies beside the first.
    pub ring: bool,
}

impl From<usize> for InputShape {
    fn from(width: usize) -> Self {
        Self { width, scan: None }
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
        let mut from = 0;
        for channel in &mut input.channels {
            let to = from + channel.width;
            channel.tell_missing(raw.slice_axis(Axis(1), (from..to).into()));
            from = to;
        }
        let pooled = input.pool(raw.view());
        for column in pooled.columns() {
            let (mean, deviation) = mean_and_deviation(column);
            input.mean.push(mean);
            let varies = deviation > SMALLEST_VARIATION * mean.abs();
            input.deviation.push(if varies { deviation } else { 1.0 });
        }
        let mut from = 0;
        for channel in &input.channels {
            // Whether a value is missing counts for as much as one deviation of any, however seldom it is.
            let to = from + channel.inputs();
            input.deviation[to - channel.told_missing()..to].fill(1.0);
            from = to;
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

    /// The same channels, their inputs normalised by another's constants, of which there are as many.
    pub fn with_constants_of(self, other: &Self) -> Self {
        Self {
            channels: self.channels,
            mean: other.mean.clone(),
            deviation: other.deviation.clone(),
        }
    }

    /// The inputs of one range sensor as another fills them: the same sectors, statistics and constants, `own` being the sensor that
    /// they were fitted to. A sector that the other does not look into is at its mean. `None` where either has no bearings, the
    /// inputs are of several sensors, or the other looks into less than two thirds of the sectors.
    pub fn looked_into_by(&self, own: &[Channel], other: &Channel) -> Option<Self> {
        self.with_channel(own, |channel, own| channel.looked_into_by(own, other))
    }

    /// The same inputs where only some of the sensor's beams are there; as [`Input::looked_into_by`].
    pub(crate) fn of_beams(&self, own: &[Channel], kept: &[usize]) -> Option<Self> {
        self.with_channel(own, |channel, own| channel.of_beams(own, kept))
    }

    fn with_channel(
        &self,
        own: &[Channel],
        of: impl Fn(&ChannelInput, &Channel) -> Option<ChannelInput>,
    ) -> Option<Self> {
        let [channel] = &self.channels[..] else {
            return None;
        };
        let own = own.iter().find(|own| own.name == channel.name)?;
        Some(Self {
            channels: vec![of(channel, own)?],
            mean: self.mean.clone(),
            deviation: self.deviation.clone(),
        })
    }

    /// Inputs `[snapshot, input]` as they would be if whatever is farther than `reach_m` had no return.
    pub(crate) fn within_reach(&self, reach_m: f32, mut inputs: Array2<f32>) -> Array2<f32> {
        for mut row in inputs.rows_mut() {
            let mut from = 0;
            for channel in &self.channels {
                let own = from..from + channel.inputs();
                let constants = (&self.mean[own.clone()], &self.deviation[own.clone()]);
                if let Some(row) = row.as_slice_mut() {
                    channel.within_reach(reach_m, constants, &mut row[own.clone()]);
                }
                from = own.end;
            }
        }
        inputs
    }

    /// Number of inputs that the networks get.
    pub fn width(&self) -> usize {
        self.mean.len()
    }

    /// Their number, and whether they are the sectors of one scan.
    pub fn shape(&self) -> InputShape {
        let scan = match &self.channels[..] {
            [channel] => channel.scan(),
            _ => None,
        };
        InputShape {
            width: self.width(),
            scan,
        }
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

    /// Names of the channels that the inputs come from.
    pub fn channel_names(&self) -> impl Iterator<Item = &str> {
        self.channels.iter().map(|channel| channel.name.as_str())
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
