//! The preprocessing as plain steps, for whoever carries it into another program.

use super::{
    Input, SectorValue,
    channel::{ChannelInput, Kind},
};
use crate::{error::Result, recording::Channel};
use std::ops::Range;

/// What becomes of the raw values of one channel, before all is normalised ([`Input::mean`], [`Input::deviation`]).
#[derive(Debug, Clone, PartialEq)]
pub enum ChannelSteps {
    /// Ranges: NaN becomes `far_clip`, all are clamped to 0 … `far_clip`, and of each sector's beams, sorted, statistics are kept:
    /// the values of all sectors for the first statistic, then for the second. Those that are no logarithms are clamped to `clip`.
    Ranges {
        /// Columns of the channel among the raw values.
        columns: Range<usize>,
        /// Clip of the statistics, metres.
        clip: f32,
        /// Clip of the beams, metres.
        far_clip: f32,
        /// Beams of each sector, by their number in the channel; one without any is at its mean.
        sectors: Vec<Vec<usize>>,
        /// What is kept of each sector.
        statistics: Vec<SectorValue>,
    },
    /// Values as they are, a NaN being at its mean, then a 1 for each of some that is there and a 0 where it is missing.
    Values {
        /// Columns of the channel among the raw values.
        columns: Range<usize>,
        /// Values whose presence is an input, by their number in the channel.
        may_miss: Vec<usize>,
    },
}

impl Input {
    /// The steps of every channel, in the order of the inputs, for raw values of these channels side by side.
    ///
    /// # Errors
    /// Where a channel is missing or has another width or unit; the message names it.
    pub fn steps(&self, channels: &[Channel]) -> Result<Vec<ChannelSteps>> {
        let steps = self.channels.iter().map(|own| own.steps(channels));
        steps.collect()
    }
}

impl ChannelInput {
    fn steps(&self, channels: &[Channel]) -> Result<ChannelSteps> {
        let columns = self.find(channels)?;
        Ok(match &self.kind {
            Kind::Ranges {
                clip,
                far_clip,
                sectors,
                sector_values,
                sector_beams,
                ..
            } => ChannelSteps::Ranges {
                columns,
                clip: *clip,
                far_clip: *far_clip,
                sectors: sector_beams
                    .clone()
                    .unwrap_or_else(|| dealt(self.width, *sectors)),
                statistics: sector_values.clone(),
            },
            Kind::Values { may_miss } => ChannelSteps::Values {
                columns,
                may_miss: may_miss.clone(),
            },
        })
    }
}

/// Neighbouring beams, evenly dealt.
fn dealt(beams: usize, sectors: usize) -> Vec<Vec<usize>> {
    let sector = |s: usize| (s * beams / sectors..(s + 1) * beams / sectors).collect();
    (0..sectors).map(sector).collect()
}
