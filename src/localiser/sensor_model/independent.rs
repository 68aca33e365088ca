//! Several sensor models together.

use super::{EvidenceScale, PreparedSensorModel, Scaled, SensorModel, flat};
use crate::{
    belief::Belief,
    error::Result,
    recording::{Observation, Recording},
    seed::Stream,
};
use std::{fmt, sync::Arc};

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

    fn depends_on_belief(&self) -> bool {
        self.0.iter().any(|model| model.depends_on_belief())
    }
}

/// Prepared sensor models that err independently of each other at a given place, each [scaled](EvidenceScale): P(z | ξ) is the
/// product of theirs. None at all say nothing.
pub struct PreparedProduct<'a> {
    factors: Vec<(Arc<dyn PreparedSensorModel + 'a>, EvidenceScale)>,
}

impl<'a> PreparedProduct<'a> {
    /// Each factor with its scale.
    pub fn new(factors: Vec<(Arc<dyn PreparedSensorModel + 'a>, EvidenceScale)>) -> Self {
        Self { factors }
    }
}

impl PreparedSensorModel for PreparedProduct<'_> {
    fn log_likelihood(
        &self,
        snapshot: usize,
        belief: &Belief,
        stream: &mut Stream,
    ) -> Result<Vec<f64>> {
        let each = self.factors.iter().map(|(model, scale)| {
            Scaled::new(model.as_ref(), *scale).log_likelihood(snapshot, belief, stream)
        });
        sum(belief, each)
    }

    fn depends_on_belief(&self) -> bool {
        self.factors
            .iter()
            .any(|(model, _)| model.depends_on_belief())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_is_the_sum_of_what_its_factors_say_each_scaled() {
        struct Says([f64; 2]);
        impl PreparedSensorModel for Says {
            fn log_likelihood(&self, _: usize, _: &Belief, _: &mut Stream) -> Result<Vec<f64>> {
                Ok(self.0.to_vec())
            }
        }
        let exact = |scale: f64| EvidenceScale {
            scale,
            unmodelled: 0.0,
        };
        let product = PreparedProduct::new(vec![
            (Arc::new(Says([0.0, -2.0])), exact(0.5)),
            (Arc::new(Says([-3.0, 0.0])), exact(1.0)),
        ]);
        let places = Arc::new(crate::belief::Places::Route(vec![0.0, 1.0]));
        let belief = Belief::uniform(&places).unwrap();
        let mut stream = crate::seed::Seed(1).stream("not drawn from");
        let l = product.log_likelihood(0, &belief, &mut stream).unwrap();
        assert_eq!(l, [-3.0, -1.0]);
    }
}
