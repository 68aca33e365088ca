//! BaLL's learned features as a recogniser: the response is the pattern of their bits.
//!
//! Thrun (1998), 4.2: f_i is 1 with probability g_i(s). A response is one answer, so each g_i is rounded; the pattern
//! f ∈ {0, 1}ⁿ is the class. Of 2ⁿ patterns only those count that the mapping part showed: 64 features have few of theirs,
//! and those of two laps are rarely the same to the bit. A snapshot with another pattern gets the likeliest known one, the f
//! of largest P(f|s) = Π_i P(f_i|s) (T98 eq. 33); a known pattern is that itself.

use super::{Learn, Recogniser, Response};
use crate::{
    detector::{Detector, filters::Filters},
    error::{Error, Result},
    model::Model,
    recording::{Channel, Columns, Observation, Recording},
    seed::Seed,
};
use ndarray::{Array2, ArrayView1};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Which model, and how many of its patterns.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BallConfig {
    /// File of the trained model. It must not have seen what is answered later; of the mapping part it may have.
    pub model: PathBuf,
    /// Number of patterns to keep, those the mapping part showed most often; none named: all.
    pub most_patterns: Option<usize>,
}

impl BallConfig {
    /// # Errors
    /// Where no model is named, or no pattern is to be kept.
    pub fn check(&self) -> Result<()> {
        if self.model.as_os_str().is_empty() {
            return Err(Error::usage(
                "ball.model: none; expected the file of a trained model",
            ));
        }
        self.check_patterns()
    }

    fn check_patterns(&self) -> Result<()> {
        match self.most_patterns {
            Some(0) => Err(Error::usage(
                "ball.most_patterns = 0: expected at least 1 pattern",
            )),
            _ => Ok(()),
        }
    }
}

/// A trained detector and the patterns of bits that the mapping part showed, from the most frequent on.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    filters: Filters,
    patterns: Vec<Vec<bool>>,
}

impl Ball {
    /// A recogniser from trained filters; [`Learn::learn`] takes them from a model file.
    ///
    /// # Errors
    /// Where the recording lacks a channel that the detector works from, or there is nothing to learn from.
    pub fn new(
        config: &BallConfig,
        filters: Filters,
        recording: &Recording,
        snapshots: &[usize],
    ) -> Result<Self> {
        config.check_patterns()?;
        let shown = recording.select(snapshots)?;
        let mut patterns: Vec<(Vec<bool>, usize)> = Vec::new();
        for g in filters.probabilities(&shown)?.rows() {
            let bits: Vec<bool> = g.iter().map(|&g| g > 0.5).collect();
            match patterns.iter_mut().find(|(known, _)| *known == bits) {
                Some((_, times)) => *times += 1,
                None => patterns.push((bits, 1)),
            }
        }
        // Stable: of two shown as often, the one shown first.
        patterns.sort_by_key(|(_, times)| std::cmp::Reverse(*times));
        patterns.truncate(config.most_patterns.unwrap_or(usize::MAX));
        Ok(Self {
            filters,
            patterns: patterns.into_iter().map(|(bits, _)| bits).collect(),
        })
    }

    /// The likeliest of the patterns, the first of several. The fit is the geometric mean of its P(f_i|s): P(f|s) of wide
    /// codes is too small for a number.
    fn likeliest(&self, g: ArrayView1<f32>) -> Option<Response> {
        let log_of = |f: bool, g: f32| {
            let probability = if f { f64::from(g) } else { 1.0 - f64::from(g) };
            // A sigmoid in f32 reaches its ends.
            probability.max(f64::from(f32::MIN_POSITIVE)).ln()
        };
        let mut best: Option<(usize, f64)> = None;
        for (class, bits) in self.patterns.iter().enumerate() {
            let log: f64 = bits.iter().zip(g).map(|(f, g)| log_of(*f, *g)).sum();
            if best.is_none_or(|(_, most)| log > most) {
                best = Some((class, log));
            }
        }
        best.map(|(class, log)| Response {
            class,
            fit: (log / g.len().max(1) as f64).exp(),
        })
    }

    fn answers(&self, recording: &Recording) -> Result<Vec<Option<Response>>> {
        let g = self.filters.probabilities(recording)?;
        Ok(g.rows().into_iter().map(|g| self.likeliest(g)).collect())
    }
}

impl Learn for Ball {
    type Config = BallConfig;

    fn learn(
        config: &BallConfig,
        recording: &Recording,
        snapshots: &[usize],
        _seed: Seed,
    ) -> Result<Self> {
        config.check()?;
        let model = Model::read(&config.model)?;
        let filters = Filters::new(model.header.input, model.weights);
        Self::new(config, filters, recording, snapshots)
    }

    fn check(&self) -> Result<()> {
        let n = self.filters.features();
        match self.patterns.iter().all(|bits| bits.len() == n) && !self.patterns.is_empty() {
            true => Ok(()),
            false => Err(Error::work(format!(
                "ball: expected at least one pattern, and {n} bits in each"
            ))),
        }
    }
}

impl Recogniser for Ball {
    fn name(&self) -> &'static str {
        "ball"
    }

    fn responses(&self) -> usize {
        self.patterns.len()
    }

    fn matches(&self) -> usize {
        self.patterns.len()
    }

    fn bytes_per_place(&self) -> usize {
        self.filters.features() * size_of::<bool>()
    }

    fn check_channels(&self, channels: &[Channel]) -> Result<()> {
        self.filters.check_channels(channels)
    }

    /// The likeliest known pattern; the fit is the geometric mean of its P(f_i|s).
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response> {
        let one = alone(channels, observation.values.to_vec()).ok()?;
        self.answers(&one).ok()?.into_iter().next()?
    }

    /// As one batch through the networks. Its sums may differ from those of a snapshot alone in the last bit, and so may
    /// the fit.
    fn respond_all(&self, recording: &Recording, snapshots: &[usize]) -> Vec<Option<Response>> {
        let answers = recording.select(snapshots).and_then(|r| self.answers(&r));
        answers.unwrap_or_else(|_| vec![None; snapshots.len()])
    }

    /// Its features as they are, not the number of a pattern (T98 eq. 32).
    fn detector(&self) -> Option<&dyn Detector> {
        Some(&self.filters)
    }
}

/// A recording of one snapshot, as detectors want it.
fn alone(channels: &[Channel], values: Vec<f32>) -> Result<Recording> {
    let columns = values.len();
    Recording::new(Columns {
        channels: channels.to_vec(),
        values: Array2::from_shape_vec((1, columns), values)
            .map_err(|e| Error::work(format!("a snapshot: {e}")))?,
        stamp_s: vec![0.0],
        pose: vec![Default::default()],
        odometry: vec![Default::default()],
        run: vec![0],
        ..Columns::default()
    })
}

#[cfg(test)]
mod tests;
