//! Several sensor models in one filter: learned features and a map, or a radio and a laser.

use super::{
    method::{AnswersBy, Method, method},
    methods::MethodContext,
    sequences::evidence_scale,
};
use crate::{
    error::Result,
    localiser::{
        PreparedSensorModel, SensorModel,
        sensor_model::{OneByOne, PreparedProduct},
    },
    recording::Recording,
};
use std::sync::Arc;

/// The filter with several methods' sensor models at once, as if they erred independently of each other: each has the
/// power of evidence that it is tuned to alone, and their product one more. `None` where one of them is no sensor model.
/// So it is of one snapshot, where both kept what they say of each.
///
/// # Errors
/// Where a sensor model fails on the validation part.
pub fn product<'a>(
    context: &MethodContext<'a>,
    name: &str,
    title: &str,
    methods: &[&Method<'a>],
) -> Result<Option<Method<'a>>> {
    let parts = context.parts;
    let source = parts.source.as_ref();
    let (mut on_run, mut on_validation) = (Vec::new(), Vec::new());
    let mut bytes_per_place = None;
    let (mut other_bytes, mut ready_ms) = (0, 0.0);
    for factor in methods {
        let Some(scale) = evidence_scale(factor, context)? else {
            return Ok(None);
        };
        let shared = |model: &Arc<dyn SensorModel + 'a>, recording: &'a Recording| {
            let model = Arc::clone(model);
            Arc::new(OneByOne { model, recording }) as Arc<dyn PreparedSensorModel>
        };
        let (run, validation) = match &factor.answers {
            AnswersBy::PreparedSensor(sensor) => (Arc::clone(sensor), factor.validation.clone()),
            AnswersBy::Sensor(model) => (
                shared(model, parts.run),
                source.map(|source| shared(model, &source.recording)),
            ),
            AnswersBy::Odometry
            | AnswersBy::Localiser(_)
            | AnswersBy::Recorded(_)
            | AnswersBy::Nobody(_) => {
                return Ok(None);
            }
        };
        on_run.push((run, scale));
        on_validation.extend(validation.map(|v| (v, scale)));
        bytes_per_place = match (bytes_per_place, factor.bytes_per_place) {
            (Some(a), Some(b)) => Some(a + b),
            (a, b) => a.or(b),
        };
        other_bytes += factor.other_bytes;
        ready_ms += factor.ready_ms;
    }
    let single = methods
        .iter()
        .map(|factor| factor.single_snapshots.as_deref());
    let judged = context.held_out_of_product(&single.collect::<Vec<_>>())?;
    let complete = on_validation.len() == on_run.len();
    let on_validation = PreparedProduct::new(on_validation);
    let answers = AnswersBy::PreparedSensor(Arc::new(PreparedProduct::new(on_run)));
    Ok(Some(Method {
        held_out: judged.held_out,
        fills_map: methods.iter().any(|factor| factor.fills_map),
        other_bytes,
        ready_ms,
        motion: methods.first().and_then(|factor| factor.motion.clone()),
        validation: complete.then(|| Arc::new(on_validation) as Arc<dyn PreparedSensorModel>),
        ..method(name, title, bytes_per_place, answers)
    }))
}
