//! Snapshot → P(f_i = 1): what the robot recognises, learned or made by hand.

mod camera;
pub mod ceiling_light;
mod config;
pub mod device;
pub mod door;
pub mod filters;
pub mod input;
pub mod net;
pub mod random_projection;
pub mod rendered;
pub mod stacked;
mod viewed;

pub use config::{BoxedDetectorConfig, DetectorConfig, HandMade};
pub use viewed::{MOST_VIEWS, Viewed};

use crate::{
    error::{Error, Result},
    recording::{self, Channel, Observation, Recording},
};
use ndarray::{Array2, ArrayView2, Axis};

/// Turns sensor snapshots into the probabilities of n binary features (Thrun 1998, eq. 32).
pub trait Detector: Send + Sync {
    /// Number n of features.
    fn features(&self) -> usize;

    /// P(f_i = 1 | s) of raw sensor values `[snapshot, value]`, those of `channels` side by side (NaN = no return), in [0, 1]
    /// (a sigmoid in f32 reaches its ends), `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where a sensor that the detector works from is missing or differs; the message names it. Where a snapshot has another
    /// number of values than the channels say.
    fn detect_batch(&self, channels: &[Channel], values: ArrayView2<f32>) -> Result<Array2<f32>>;

    /// The same of every snapshot of a recording, `[snapshot, feature]`.
    ///
    /// # Errors
    /// As [`Detector::detect_batch`].
    fn probabilities(&self, recording: &Recording) -> Result<Array2<f32>> {
        self.detect_batch(recording.channels(), recording.values().view())
    }

    /// The same of a single observation, `[feature]`.
    ///
    /// # Errors
    /// As [`Detector::detect_batch`].
    fn detect(&self, observation: &Observation) -> Result<Vec<f32>> {
        let values = observation.values.insert_axis(Axis(0));
        let probabilities = self.detect_batch(observation.channels, values)?;
        Ok(probabilities.iter().copied().collect())
    }
}

/// # Errors
/// Where a snapshot has another number of values than the channels say.
fn check_width(channels: &[Channel], values: ArrayView2<f32>) -> Result<()> {
    let checked = recording::check_width(channels, values.ncols());
    checked.map_err(|e: Error| e.context("snapshot"))
}
