//! The likelihood of detected features under a map that answers at every pose of a grid.

use super::{DetectorAnswers, PreparedSensorModel, SensorModel, flat, same_features};
use crate::{
    belief::{Belief, CodeMap},
    detector::Detector,
    error::{Error, Result},
    recording::{Observation, Recording},
    seed::Stream,
};
use std::sync::Arc;

/// A detector, and what it answers at every cell of a grid, kept as probabilities or bits; by mean-field evidence.
///
/// An observation for which the detector has no answer in [0, 1] says nothing about the place.
pub struct EveryPose {
    detector: Arc<dyn Detector>,
    map: Arc<CodeMap>,
}

impl EveryPose {
    /// From a detector and the map of the cells.
    ///
    /// # Errors
    /// Where they have different numbers of features.
    pub fn new(detector: Arc<dyn Detector>, map: Arc<CodeMap>) -> Result<Self> {
        same_features(detector.as_ref(), map.features())?;
        Ok(Self { detector, map })
    }
}

impl SensorModel for EveryPose {
    fn name(&self) -> &str {
        "learned"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        _: &mut Stream,
    ) -> Result<Vec<f64>> {
        answer(&self.map, &self.detector.detect(observation)?, belief)
    }

    /// The detector answers all snapshots at once.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        let answered = DetectorAnswers::of(self.detector.as_ref(), recording, snapshots)?;
        let map = Arc::clone(&self.map);
        Ok(Box::new(PreparedEveryPose::new(answered, map)))
    }
}

/// [`EveryPose`] whose detector has answered.
pub struct PreparedEveryPose {
    answered: DetectorAnswers,
    map: Arc<CodeMap>,
}

impl PreparedEveryPose {
    /// From P(f_i = 1 | s) of snapshots, and the map of the cells.
    pub fn new(answered: DetectorAnswers, map: Arc<CodeMap>) -> Self {
        Self { answered, map }
    }
}

impl PreparedSensorModel for PreparedEveryPose {
    fn log_likelihood(&self, snapshot: usize, belief: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
        let Some(activation) = self.answered.of_snapshot(snapshot) else {
            return Err(Error::work(format!(
                "learned features: not prepared for snapshot {snapshot}"
            )));
        };
        answer(&self.map, &activation.to_vec(), belief)
    }

    fn depends_on_belief(&self) -> bool {
        false
    }
}

fn answer(map: &CodeMap, activation: &[f32], belief: &Belief) -> Result<Vec<f64>> {
    if map.cells() != belief.mass().len() {
        return Err(Error::work(format!(
            "learned features: a belief over {} places; expected the {} cells of the map",
            belief.mass().len(),
            map.cells()
        )));
    }
    match activation.iter().all(|g| (0.0..=1.0).contains(g)) {
        true => map.log_likelihood(activation),
        false => Ok(flat(belief)),
    }
}
