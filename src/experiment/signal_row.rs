//! The rival of whoever has a sensor that no plan predicts: each reading regressed over places, the signal field.

use super::{method::Method, methods::MethodContext};
use crate::{
    belief::Places,
    belief::{
        SignalFieldConfig,
        signal_field::{LabelledReadings, fit_tuned},
    },
    error::Result,
    localiser::sensor_model::SignalFieldModel,
};
use std::sync::Arc;

/// More readings a snapshot than these are a scan or a picture: a field of each would take gigabytes over a fine grid.
const MAX_READINGS: usize = 64;

/// The signal field in tables.
pub(super) const SIGNAL_FIELD: &str = "signal field";

/// The signal field of the sensors that the models work from; none where a snapshot has more than [`MAX_READINGS`] readings.
pub(super) fn signal_field<'a>(context: &MethodContext<'a>) -> Result<Option<Method<'a>>> {
    let source = context.source()?;
    let recording = &*source.recording;
    let channels = &context.mapped.input.channels;
    let wanted = |name: &String| channels.is_empty() || channels.contains(name);
    let used = recording.channels().iter().filter(|c| wanted(&c.name));
    if used.map(|c| c.width).sum::<usize>() > MAX_READINGS {
        return Ok(None);
    }
    let candidates = context.mapped.places.clone();
    let tuned = fit_tuned(
        &LabelledReadings::of(recording, &source.training, channels)?,
        &LabelledReadings::of(recording, &context.validated()?, channels)?,
        &candidates,
        &SignalFieldConfig::default(),
    )?;
    let at = |places: &Places| -> Result<SignalFieldModel> {
        Ok(SignalFieldModel::new(Arc::new(tuned.field.at(places)?)))
    };
    let at_cells = Box::new(at(context.grid.places())?);
    let alone = at(&candidates)?;
    let method = context.judged_sensor_model("signal_field", SIGNAL_FIELD, &alone, at_cells)?;
    Ok(Some(Method {
        other_bytes: tuned.field.bytes(),
        usual_scale: tuned.power,
        ..method
    }))
}
