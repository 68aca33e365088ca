//! The likelihood of detected features under the map.

use super::SensorModel;
use crate::{
    belief::{Belief, Evidence, GridMap},
    error::Result,
    seed::Stream,
};
use ndarray::Array2;

/// A detector's answers to a recording, and the map of a grid's cells to hold them against.
pub struct FeatureModel {
    answers: Array2<f64>,
    map: GridMap,
    evidence: Evidence,
}

impl FeatureModel {
    /// From P(f_i = 1 | s), `[snapshot, feature]`, and the map of P(f_i = 1 | ξ) at the cells.
    pub fn new(answers: &Array2<f32>, map: GridMap, evidence: Evidence) -> Self {
        Self {
            answers: answers.mapv(f64::from),
            map,
            evidence,
        }
    }
}

impl SensorModel for FeatureModel {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        self.evidence.log_likelihood(
            &self.answers.row(snapshot).to_vec(),
            &self.map,
            belief,
            stream,
        )
    }
}
