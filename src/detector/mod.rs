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
pub mod stacked;

pub use config::{BoxedDetectorConfig, DetectorConfig, HandMade};

use crate::error::Result;
use crate::recording::Recording;
use ndarray::Array2;

/// Turns sensor snapshots into the probabilities of n binary features (Thrun 1998, eq. 32).
pub trait Detector: Send + Sync {
    /// Number n of features.
    fn features(&self) -> usize;

    /// P(f_i = 1 | s) of every snapshot of a recording, in [0, 1] (a sigmoid in f32 reaches its ends), `[snapshot, feature]`.
    ///
    /// # Errors
    /// Where the recording lacks the sensors that the detector works from; the message names them.
    fn probabilities(&self, recording: &Recording) -> Result<Array2<f32>>;
}
