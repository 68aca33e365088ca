//! A snapshot is recognised: one response to what the sensors say now, without memory of what they said before.
//!
//! Duckett & Nehmzow, *Performance Comparison of Landmark Recognition Systems for Navigating Mobile Robots* (2000, below
//! D00), compare such systems as black boxes: each learns from a robot's first lap, then answers every snapshot of the
//! others with the number of a class, a place or a pattern. The number identifies a class that only the recogniser can
//! interpret; [`crate::score`] measures how much it tells about the place.
//!
//! ```
//! use ballmark::{recogniser::{self, Kind, Learned}, seed::Seed, world::corridor};
//! let config = corridor::CorridorConfig { runs: 2, spacing_m: 1.0, ..Default::default() };
//! let recording = corridor::thrun1998(Seed(1), &config)?;
//! let (first, second): (Vec<usize>, Vec<usize>) = (0..recording.len()).partition(|k| recording.runs()[0].contains(k));
//!
//! let kind: Kind = "nearest".parse()?;
//! let learned = recogniser::learn(&kind.default_config(), &recording, &first, Seed(1))?;
//! let responses = learned.as_recogniser().respond_all(&recording, &second);
//!
//! # let folder = tempfile::tempdir().unwrap();
//! let path = folder.path().join("nearest.json");
//! learned.write(&path)?;
//! assert_eq!(Learned::read(&path)?.as_recogniser().respond_all(&recording, &second), responses);
//! # Ok::<(), ballmark::Error>(())
//! ```
//!
//! A recogniser of another crate implements [`Recogniser`], and its constants [`RecogniserConfig`]: `examples/own_recogniser.rs`.
//! A new built-in one is one file, which implements [`Recogniser`] and [`Learn`], one line in the registry below, and one
//! that says which of its constants changes the number of its responses ([`dial`]).

pub mod alignment;
pub mod angle_histogram;
pub mod art2;
pub mod ball;
pub mod dial;
pub mod grid_match;
pub mod growing_cells;
pub mod histogram;
pub mod histogram_match;
pub mod local_scan;
pub mod nearest;
pub mod occupancy;
mod prototypes;
pub mod rce;
pub mod signature;

use crate::{
    detector::Detector,
    error::Result,
    recording::{Channel, Observation, Recording},
    registry::{Constants, boxed_config},
    seed::Seed,
};
use dial::Dial;
use rayon::prelude::*;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use std::path::PathBuf;

/// What a recogniser answers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// The number of a class, place or pattern, below [`Recogniser::responses`].
    pub class: usize,
    /// How well it fits: finite, more is better, to be compared with other answers of the same recogniser alone.
    pub fit: f64,
}

/// A snapshot of which everything is ready but the match: gives the response.
pub type ReadyToMatch<'a> = Box<dyn Fn() -> Option<Response> + 'a>;

/// Answers snapshots, one by one.
pub trait Recogniser: Send + Sync {
    /// Its name in messages.
    fn name(&self) -> &str;

    /// Number of different responses it can give.
    fn responses(&self) -> usize;

    /// Patterns that one response is compared with: D00's T is time per match.
    fn matches(&self) -> usize;

    /// What it keeps of one pattern in memory, in bytes, and of where it was, if it keeps that.
    fn bytes_per_place(&self) -> usize;

    /// Are these the sensors that it learned from? Asked once for a recording; [`Recogniser::respond`] only falls silent.
    ///
    /// # Errors
    /// Where a channel is missing or has another width or unit; the message names it.
    fn check_channels(&self, channels: &[Channel]) -> Result<()>;

    /// The response to one snapshot, `None` where it knows nothing like it or lacks the sensors to tell. It works from
    /// the sensor values (NaN = no return) and the compass, never from odometry or truth.
    fn respond(&self, channels: &[Channel], observation: &Observation) -> Option<Response>;

    /// The same response, what is made of the snapshot alone (a grid, a signature) being made now and the match with what was
    /// stored left to be done: D00's T is the time of that. To be replaced where the two are apart.
    fn ready<'a>(
        &'a self,
        channels: &'a [Channel],
        observation: &'a Observation<'a>,
    ) -> ReadyToMatch<'a> {
        Box::new(move || self.respond(channels, observation))
    }

    /// The responses to many snapshots of a recording, in the order asked for: the same that [`Recogniser::respond`]
    /// gives, for any number of threads. To be replaced where many together are cheaper than one by one.
    fn respond_all(&self, recording: &Recording, snapshots: &[usize]) -> Vec<Option<Response>> {
        snapshots
            .par_iter()
            .map(|&k| self.respond(recording.channels(), &recording.observation(k)))
            .collect()
    }

    /// Where its response is a rounding of stochastic features: the detector that gives their probabilities. Error reduction
    /// is then that of the features.
    fn detector(&self) -> Option<&dyn Detector> {
        None
    }
}

/// Constants that a recogniser is learned with: a built-in [`Config`], or a type of one's own.
pub trait RecogniserConfig: Constants + BoxedRecogniserConfig {
    /// Learns from some snapshots of a recording (the mapping part), in the order given. Randomness comes from streams of
    /// `seed`.
    ///
    /// # Errors
    /// Where a constant makes no sense (a usage error), or the snapshots are not enough to learn from.
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Box<dyn Recogniser>>;

    /// The constant that is set so that the recogniser gives about so many responses. Without one it is judged as it is.
    fn dial(&self, responses: usize) -> Option<Dial> {
        let _ = responses;
        None
    }

    /// Sets that constant.
    fn turn_dial(&mut self, to: f64) {
        let _ = to;
    }
}

boxed_config!(RecogniserConfig, BoxedRecogniserConfig);

/// What a member of the registry can do besides: learn, and be kept in a file.
pub trait Learn: Recogniser + Serialize + DeserializeOwned {
    /// Its constants; the default is what the papers print, or else says why.
    type Config: Default;

    /// Learns from some snapshots of a recording (the mapping part), in the order given. Randomness comes from streams of
    /// `seed`.
    ///
    /// # Errors
    /// Where a constant makes no sense (a usage error), or the snapshots are not enough to learn from.
    fn learn(
        config: &Self::Config,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Self>;

    /// Checks what may have come from a file, so that it can be used without fear.
    ///
    /// # Errors
    /// Where its parts don't fit one another; the message names the fault.
    fn check(&self) -> Result<()>;
}

/// The registry: what a member is called in code, its file (which is its name), its constants, and what it is.
macro_rules! members {
    ($then:ident) => {
        $then! {
            GridMatch, grid_match, GridMatchConfig, "Matching of local occupancy grids, as of Yamauchi & Langley (1997).";
            HistogramMatch, histogram_match, HistogramMatchConfig, "Matching of their histograms, Duckett & Nehmzow's (2000) own.";
            Rce, rce, RceConfig, "Restricted Coulomb energy with fixed spheres, as of Kurz (1996).";
            Art2, art2, Art2Config, "ART2, with reset and search, of Carpenter & Grossberg (1987).";
            Nearest, nearest, NearestConfig, "Nearest neighbour among patterns 1.5 m apart (D00).";
            GrowingCells, growing_cells, GrowingCellsConfig, "Growing cell structures of Fritzke (1994).";
            Ball, ball, BallConfig, "BaLL's learned features, rounded to bits (Thrun 1998).";
        }
    };
}

macro_rules! registry {
    ($($members:tt)*) => {
        crate::registry::registry! {
            "recogniser", Recogniser, as_recogniser, File, "ballmark_recogniser", "recogniser";
            $($members)*
        }
    };
}
members!(registry);

impl Constants for Config {
    fn kind(&self) -> &str {
        Config::kind(self).name()
    }

    fn description(&self) -> &str {
        Config::kind(self).what()
    }

    fn check(&self) -> Result<()> {
        Config::check(self)
    }

    fn model(&mut self) -> Option<&mut PathBuf> {
        match self {
            Config::Ball(config) => Some(&mut config.model),
            _ => None,
        }
    }
}

impl RecogniserConfig for Config {
    fn learn(
        &self,
        recording: &Recording,
        snapshots: &[usize],
        seed: Seed,
    ) -> Result<Box<dyn Recogniser>> {
        learn(self, recording, snapshots, seed).map(Learned::boxed)
    }

    fn dial(&self, responses: usize) -> Option<Dial> {
        Some(Dial::of(self, responses))
    }

    fn turn_dial(&mut self, to: f64) {
        Dial::turn(self, to);
    }
}

pub mod laws;
#[cfg(test)]
pub(crate) mod test_world;
