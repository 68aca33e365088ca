//! The filter with a bank of learned sets: at every step the one that promises the least error under the belief of that moment.

use super::{
    method::{AnswersBy, Method, method},
    methods::MethodContext,
    sequences::evidence_scale,
};
use crate::{
    error::Result,
    localiser::{
        PreparedSensorModel,
        sensor_model::{Bank, BankChoice, BankSet},
    },
    model::{Model, held_apart},
};
use std::sync::Arc;

/// The bank of these models, whose own methods, in the same order, are made already; `run` is that of each training place. `None` where
/// one of the methods is no prepared sensor model.
///
/// # Errors
/// Where there is not one run a place.
pub(super) fn bank<'a>(
    context: &MethodContext<'a>,
    (models, run): (&[&Model], &[usize]),
    methods: &[&Method<'a>],
    choice: BankChoice,
    (name, title): (&str, &str),
) -> Result<Option<Method<'a>>> {
    let Some(on_run) = on_run(context, (models, run), methods, choice)? else {
        return Ok(None);
    };
    let validation = methods.iter().map(|set| set.validation.clone());
    let validation = validation
        .collect::<Option<Vec<_>>>()
        .map(|sensors| Arc::new(on_run.with_sensors(sensors)) as Arc<dyn PreparedSensorModel>);
    let bytes = methods.iter().map(|set| set.bytes_per_place);
    let answers = AnswersBy::PreparedSensor(Arc::new(on_run));
    Ok(Some(Method {
        validation,
        other_bytes: methods.iter().map(|set| set.other_bytes).sum(),
        ready_ms: methods.iter().map(|set| set.ready_ms).sum(),
        motion: methods.first().and_then(|set| set.motion.clone()),
        ..method(name, title, bytes.sum(), answers)
    }))
}

/// The same as a sensor model for the unseen part.
///
/// # Errors
/// As [`bank`].
pub(super) fn on_run<'a>(
    context: &MethodContext<'a>,
    (models, run): (&[&Model], &[usize]),
    methods: &[&Method<'a>],
    choice: BankChoice,
) -> Result<Option<Bank<Arc<dyn PreparedSensorModel + 'a>>>> {
    let mut sets = Vec::new();
    for (model, method) in models.iter().zip(methods) {
        let AnswersBy::PreparedSensor(sensor) = &method.answers else {
            return Ok(None);
        };
        let held_apart = held_apart(model, run, context.grid.places())?;
        sets.push(BankSet {
            name: model.header.prior.to_string(),
            sensor: Arc::clone(sensor),
            scale: match method.evidence_scale {
                Some(1.0) => None, // at its word
                _ => evidence_scale(method, context)?,
            },
            held_apart: Arc::new(held_apart),
        });
    }
    Bank::new(sets, choice, context.seed()).map(Some)
}
