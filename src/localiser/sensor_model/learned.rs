//! The likelihood of detected features under the map: P(f | ξ), whatever detector the features come from.

use super::{DetectorAnswers, PreparedSensorModel, SensorModel, flat, same_features};
use crate::{
    belief::{Belief, Evidence, GridMap},
    detector::Detector,
    error::{Error, Result},
    recording::{Observation, Recording},
    seed::Stream,
};
use std::sync::Arc;

/// A detector, and the map of what it answers at the cells of a grid: Thrun (1998), Table 1.
///
/// An observation for which the detector has no answer in [0, 1] (readings past all bounds make networks answer NaN) says
/// nothing about the place. What P(z | ξ) is depends on the rule of evidence: [`Evidence::predictive_log_likelihood`].
pub struct LearnedFeatures {
    pub(super) detector: Arc<dyn Detector>,
    pub(super) map: Arc<GridMap>,
    evidence: Evidence,
}

impl LearnedFeatures {
    /// From a detector, P(f_i = 1 | ξ) at the cells, and how the one is held against the other.
    ///
    /// # Errors
    /// Where detector and map have different numbers of features.
    pub fn new(detector: Arc<dyn Detector>, map: Arc<GridMap>, evidence: Evidence) -> Result<Self> {
        same_features(detector.as_ref(), map.features())?;
        Ok(Self {
            detector,
            map,
            evidence,
        })
    }
}

impl SensorModel for LearnedFeatures {
    fn name(&self) -> &str {
        "learned"
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let probabilities = self.detector.detect(observation)?;
        let activation: Vec<f64> = probabilities.into_iter().map(f64::from).collect();
        if !are_probabilities(&activation) {
            return Ok(flat(belief));
        }
        self.evidence
            .predictive_log_likelihood(&activation, &self.map, belief, stream)
    }

    /// The detector answers all snapshots at once.
    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        let answered = DetectorAnswers::of(self.detector.as_ref(), recording, snapshots)?;
        let map = Arc::clone(&self.map);
        Ok(Box::new(PreparedFeatures::new(
            answered,
            map,
            self.evidence,
        )))
    }
}

fn are_probabilities(activation: &[f64]) -> bool {
    activation.iter().all(|g| (0.0..=1.0).contains(g))
}

/// [`LearnedFeatures`] whose detector has answered.
pub struct PreparedFeatures {
    answered: DetectorAnswers,
    map: Arc<GridMap>,
    evidence: Evidence,
}

impl PreparedFeatures {
    /// From P(f_i = 1 | s) of snapshots, and the map of P(f_i = 1 | ξ) at the cells.
    pub fn new(answered: DetectorAnswers, map: Arc<GridMap>, evidence: Evidence) -> Self {
        Self {
            answered,
            map,
            evidence,
        }
    }
}

impl PreparedSensorModel for PreparedFeatures {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let Some(activation) = self.answered.of_snapshot(snapshot) else {
            return Err(Error::work(format!(
                "learned features: not prepared for snapshot {snapshot}"
            )));
        };
        let activation: Vec<f64> = activation.iter().map(|&g| g.into()).collect();
        if !are_probabilities(&activation) {
            return Ok(flat(belief));
        }
        self.evidence
            .log_likelihood(&activation, &self.map, belief, stream)
    }

    fn depends_on_belief(&self) -> bool {
        !matches!(self.evidence, Evidence::MeanField | Evidence::Likelihood)
    }
}
