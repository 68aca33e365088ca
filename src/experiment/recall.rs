//! One snapshot and no idea where: how often the likeliest place of the whole grid is the right one.

use super::{
    method::{AnswersBy, Method},
    methods::MethodContext,
    single_snapshot::evenly,
};
use crate::{
    belief::{BayesFilter, Belief, OdometryMotion},
    error::Result,
    localiser::{
        PreparedSensorModel,
        sensor_model::{EvidenceScale, Memory, Remembered, Scaled},
    },
};
use rayon::prelude::*;

/// Unseen snapshots that are asked, evenly spaced.
const SNAPSHOTS: usize = 200;

/// Where all snapshots are of one run, what an interval resamples is so long a piece of its way, in metres.
const PIECE_M: f64 = 20.0;

/// Metres from the truth to the likeliest cell after one snapshot, and what an interval resamples: the run, or a piece of a
/// single run's way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recalled {
    /// Run, or piece of it.
    pub unit: usize,
    /// Metres from the truth.
    pub error_m: f64,
}

/// The unseen snapshots that are asked.
pub(super) fn sampled(context: &MethodContext) -> Vec<usize> {
    evenly(context.all_covered().to_vec(), SNAPSHOTS)
}

/// Asks a sensor model for unseen snapshots at places that training saw.
fn recall(context: &MethodContext, sensor: &dyn PreparedSensorModel) -> Result<Vec<Recalled>> {
    let parts = context.parts;
    let asked = sampled(context);
    let runs = parts.run.runs();
    let run_of = |k: usize| runs.partition_point(|run| run.end <= k);
    let travelled = parts.run.travelled_m();
    let several = asked.iter().any(|&k| run_of(k) != run_of(asked[0]));
    let answer = |&k: &usize| {
        let start = Belief::uniform(context.grid.places())?;
        let mut stream = context.seed().numbered_stream("recall", k as u64);
        let log_likelihood = sensor.log_likelihood(k, &start, &mut stream)?;
        let mut filter = BayesFilter::new(&context.grid, OdometryMotion::exact(), start)?;
        filter.correct(&log_likelihood)?;
        Ok(Recalled {
            unit: match several {
                true => run_of(k),
                false => (travelled[k] / PIECE_M) as usize,
            },
            error_m: filter.belief().point_error_m(&parts.places, k),
        })
    };
    asked.par_iter().map(answer).collect()
}

/// What single snapshots say of the place, each on its own; nothing of a method that is no sensor model. `memory` is of its sensor model on the unseen
/// part alone.
///
/// # Errors
/// Where the sensor model fails.
pub fn recalled(
    method: &Method,
    context: &MethodContext,
    scale: Option<EvidenceScale>,
    memory: &Memory,
) -> Result<Vec<Recalled>> {
    let Some(scale) = scale else {
        return Ok(Vec::new());
    };
    let ask = |sensor: &dyn PreparedSensorModel| {
        let sensor = Remembered::new(sensor, memory);
        recall(context, &Scaled::new(&sensor, scale))
    };
    match &method.answers {
        AnswersBy::Odometry
        | AnswersBy::Localiser(_)
        | AnswersBy::Recorded(_)
        | AnswersBy::Nobody(_) => Ok(Vec::new()),
        AnswersBy::PreparedSensor(prepared) => ask(prepared.as_ref()),
        AnswersBy::Sensor(model) => ask(model
            .prepare(context.parts.run, &context.parts.unseen)?
            .as_ref()),
    }
}
