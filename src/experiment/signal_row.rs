//! The rival of whoever has a sensor that no plan predicts: each reading regressed over places, the signal field.

use super::{method::Method, methods::MethodContext};
use crate::{
    belief::Places,
    belief::{
        SignalFieldConfig,
        signal_field::{LabelledReadings, fit_tuned},
    },
    error::{Error, Result},
    localiser::sensor_model::SignalFieldModel,
    recording::Channel,
};
use std::sync::Arc;

/// A channel of more readings than these may be a scan or a picture, which other maps are for.
const MAX_READINGS: usize = 64;

/// Means of all readings at all places at most: 256 MB, and as much again where readings go missing.
const MOST_MEANS: usize = 64 << 20;

/// The signal field in tables.
pub(super) const SIGNAL_FIELD: &str = "signal field";

/// Is it a scan or a picture, and no number of stations that are heard?
fn is_wide_view(channel: &Channel) -> bool {
    let name = channel.name.split('@').next().unwrap_or_default(); // what was sensed before as well
    channel.width > MAX_READINGS
        && (channel.bearing_rad.is_some() || channel.unit == "m" || name == "camera")
}

/// The signal field of the sensors that the models work from; none where one of them is a scan or a picture.
///
/// # Errors
/// Where the training part is not at hand, or a field of all readings over the grid would take more than [`MOST_MEANS`].
pub(super) fn signal_field<'a>(context: &MethodContext<'a>) -> Result<Option<Method<'a>>> {
    let source = context.source()?;
    let recording = &*source.recording;
    let channels = &context.mapped.input.channels;
    let wanted = |name: &String| channels.is_empty() || channels.contains(name);
    let used = recording.channels().iter().filter(|c| wanted(&c.name));
    let used: Vec<&Channel> = used.collect();
    if used.iter().any(|channel| is_wide_view(channel)) {
        return Ok(None);
    }
    let readings: usize = used.iter().map(|channel| channel.width).sum();
    let sites = context.grid.len() / context.grid.headings();
    if readings.saturating_mul(sites) > MOST_MEANS {
        return Err(Error::work(format!(
            "{readings} readings a snapshot at {sites} places of the grid; expected {MOST_MEANS} in all at most, or a coarser grid.cell_m"
        )));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stations_are_no_scan_however_many() {
        let channel = |name: &str, unit: &str, width: usize, points: bool| Channel {
            name: name.into(),
            width,
            unit: unit.into(),
            bearing_rad: points.then(|| vec![0.0; width]),
            maximum: None,
            offset_m: None,
        };
        for (wide, is_wide_view_of) in [
            (channel("laser", "m", 180, true), true),
            (channel("laser", "m", 180, false), true),
            (channel("laser", "m", 64, true), false),
            (channel("thermopile", "K", 80, true), true),
            (channel("camera", "1", 140, false), true),
            (channel("camera@0.5m", "1", 140, false), true),
            (channel("rssi", "dBm", 520, false), false),
            (channel("rssi@6.5m", "dBm", 60, false), false),
        ] {
            assert_eq!(is_wide_view(&wide), is_wide_view_of, "{wide:?}");
        }
    }
}
