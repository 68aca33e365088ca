//! What the sensors say about the place: P(z | ξ) of an observation z, at every cell of a grid.
//!
//! A [`SensorModel`] answers one observation at a time, as a robot makes them. For a recording it is
//! [prepared](SensorModel::prepare) first, which leaves it room to work on all snapshots at once.
//!
//! One's own sensor model is a type that implements [`SensorModel`]:
//!
//! ```
//! use ballmark::{belief::{Belief, Places}, geometry::Pose, localiser::sensor_model::SensorModel, recording::{Channel, Observation}, seed::{Seed, Stream}};
//!
//! /// The range to a wall at the end of a corridor, within 0.2 m.
//! struct EndWall { at_m: f64 }
//!
//! impl SensorModel for EndWall {
//!     fn name(&self) -> &str {
//!         "end_wall"
//!     }
//!
//!     fn log_likelihood(&self, observation: &Observation, belief: &Belief, _: &mut Stream) -> ballmark::Result<Vec<f64>> {
//!         let range_m = f64::from(observation.values[0]);
//!         let Places::Route(cells) = &**belief.places() else {
//!             return Err(ballmark::Error::work("end_wall: expected places along a corridor"));
//!         };
//!         if range_m.is_nan() {
//!             return Ok(vec![0.0; cells.len()]); // no return: nothing is known
//!         }
//!         let log_gaussian = |x_m: &f64| -0.5 * ((self.at_m - x_m - range_m) / 0.2).powi(2);
//!         Ok(cells.iter().map(log_gaussian).collect())
//!     }
//! }
//!
//! let corridor = std::sync::Arc::new(Places::Route(vec![0.0, 1.0, 2.0, 3.0]));
//! let belief = Belief::uniform(&corridor)?;
//! let channels = [Channel { name: "sonar".into(), width: 1, unit: "m".into(), bearing_rad: None, maximum: None, offset_m: None }];
//! let observation = Observation::new(&channels, &[2.1], 0.0, Pose::default())?;
//! let log_likelihood = EndWall { at_m: 4.0 }.log_likelihood(&observation, &belief, &mut Seed(1).stream("unused"))?;
//! assert!(log_likelihood[2] > log_likelihood[1] && log_likelihood[2] > log_likelihood[3]);
//! # Ok::<(), ballmark::Error>(())
//! ```

pub mod bank;
pub mod beam_model;
pub mod compass;
mod detector_answers;
pub mod every_pose;
pub mod evidence_scale;
pub mod independent;
pub mod kernel;
pub mod learned;
pub mod likelihood_field;
mod of_model;
pub mod remembered;
pub mod signal_field;

pub use bank::{Bank, BankChoice, BankSet, ChosenBy};
pub use beam_model::{BeamModel, BeamModelConfig};
pub use compass::Compass;
pub use detector_answers::DetectorAnswers;
pub use every_pose::{EveryPose, PreparedEveryPose};
pub use evidence_scale::{EvidenceScale, Scaled};
pub use independent::{Independent, PreparedProduct};
pub use kernel::{PreparedKernel, RawKernel, least_mean_squares};
pub use learned::{LearnedFeatures, PreparedFeatures};
pub use likelihood_field::LikelihoodFieldModel;
pub(super) use of_model::{scale_of, sensor_of};
pub use remembered::{Memory, Remembered};
pub use signal_field::SignalFieldModel;

use crate::{
    belief::Belief,
    detector::Detector,
    error::{Error, Result},
    recording::{Observation, Recording},
    seed::Stream,
};
use std::ops::Deref;

/// P(z | ξ) of an observation z at every cell ξ of a grid.
pub trait SensorModel: Send + Sync {
    /// Its name in tables and messages.
    fn name(&self) -> &str;

    /// ln P(z | ξ) at every cell of the belief, `[cell]`, up to a constant that depends on neither cell nor belief.
    ///
    /// `belief` is the belief before the observation; its places are the cells. `stream` is there for models that draw
    /// random numbers. An observation that says nothing (all readings missing) has the same value at every cell.
    ///
    /// # Errors
    /// Where the observation lacks a sensor that the model works from or has another number of values, or the belief is not
    /// about the cells that the model was made for.
    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>>;

    /// Does what it says of an observation depend on the belief, or on random numbers? If not, it need not be asked again about an observation
    /// that is played again ([`Remembered`]).
    fn depends_on_belief(&self) -> bool {
        true
    }

    /// Gets ready to answer for these snapshots of a recording, and may work on them all at once. As it stands, it asks
    /// [`SensorModel::log_likelihood`] for each when its turn comes. It may work from [`Recording::observation`] alone, never
    /// from poses or route.
    ///
    /// # Errors
    /// Where the recording lacks a sensor that the model works from.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        let _ = snapshots;
        Ok(Box::new(OneByOne {
            model: self,
            recording,
        }))
    }
}

/// A sensor model with a recording before it.
pub trait PreparedSensorModel: Send + Sync {
    /// ln P(z | ξ) at every cell of the belief, `[cell]`, for snapshot `snapshot` of the recording, up to a constant that does
    /// not depend on the cell; otherwise as [`SensorModel::log_likelihood`].
    ///
    /// # Errors
    /// As [`SensorModel::log_likelihood`], and where the snapshot is not among those prepared.
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>>;

    /// As [`SensorModel::depends_on_belief`].
    fn depends_on_belief(&self) -> bool {
        true
    }
}

/// A recording's snapshots, each answered by a sensor model when it is asked for; `model` borrows it or shares it.
pub struct OneByOne<'a, M> {
    /// `&M` or `Arc<M>` of a [`SensorModel`].
    pub model: M,
    /// Holds the snapshots.
    pub recording: &'a Recording,
}

impl<M: Deref<Target: SensorModel> + Send + Sync> PreparedSensorModel for OneByOne<'_, M> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let observation = self.recording.observation(snapshot);
        self.model.log_likelihood(&observation, belief, stream)
    }

    fn depends_on_belief(&self) -> bool {
        self.model.depends_on_belief()
    }
}

/// # Errors
/// Where a detector and the map of what it answers have different numbers of features.
fn same_features(detector: &dyn Detector, in_map: usize) -> Result<()> {
    match detector.features() == in_map {
        true => Ok(()),
        false => Err(Error::work(format!(
            "learned features: a detector of {} features; expected {in_map}, those of the map",
            detector.features()
        ))),
    }
}

/// An answer that says nothing about the place.
fn flat(belief: &Belief) -> Vec<f64> {
    vec![0.0; belief.mass().len()]
}

/// ln of the mean of exp(l); −∞ of none.
fn ln_mean_exp(l: &[f64]) -> f64 {
    let best = l.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !best.is_finite() {
        return f64::NEG_INFINITY;
    }
    let sum: f64 = l.iter().map(|l| (l - best).exp()).sum();
    best + (sum / l.len() as f64).ln()
}

#[cfg(test)]
mod laws;
