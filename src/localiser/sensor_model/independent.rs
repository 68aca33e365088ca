//! Several sensor models together.

use super::{PreparedSensorModel, SensorModel, flat};
use crate::{
    belief::Belief,
    error::Result,
    recording::{Observation, Recording},
    seed::Stream,
};
use std::fmt;

/// Sensor models that err independently of each other at a given place: P(z | ξ) is the product of theirs. None at all say
/// nothing.
pub struct Independent {
    name: String,
    models: Vec<Box<dyn SensorModel>>,
}

impl Independent {
    /// Named by its parts: `learned+compass`.
    pub fn new(models: Vec<Box<dyn SensorModel>>) -> Self {
        let names: Vec<&str> = models.iter().map(|model| model.name()).collect();
        Self {
            name: names.join("+"),
            models,
        }
    }
}

impl fmt::Debug for Independent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Independent").field(&self.name).finish()
    }
}

impl SensorModel for Independent {
    fn name(&self) -> &str {
        &self.name
    }

    fn log_likelihood(
        &self,
        observation: &Observation,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let each = self.models.iter();
        sum(
            belief,
            each.map(|model| model.log_likelihood(observation, belief, stream)),
        )
    }

    fn prepare<'a>(
        &'a self,
        recording: &'a Recording,
        snapshots: &[usize],
    ) -> Result<Box<dyn PreparedSensorModel + 'a>> {
        let each = self.models.iter();
        let prepared = each.map(|model| model.prepare(recording, snapshots));
        Ok(Box::new(Prepared(prepared.collect::<Result<_>>()?)))
    }
}

struct Prepared<'a>(Vec<Box<dyn PreparedSensorModel + 'a>>);

impl PreparedSensorModel for Prepared<'_> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let each = self.0.iter();
        sum(
            belief,
            each.map(|model| model.log_likelihood(snapshot, belief, stream)),
        )
    }
}

/// The sum of log-likelihoods, cell by cell.
fn sum(belief: &Belief, mut each: impl Iterator<Item = Result<Vec<f64>>>) -> Result<Vec<f64>> {
    let Some(first) = each.next() else {
        return Ok(flat(belief));
    };
    let mut sum = first?;
    for log_likelihood in each {
        let pairs = sum.iter_mut().zip(log_likelihood?);
        pairs.for_each(|(sum, one)| *sum += one);
    }
    Ok(sum)
}
