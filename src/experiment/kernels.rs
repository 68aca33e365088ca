//! The baselines that keep the scans themselves: each training scan once, and each in many moved views.

use super::{
    evidence_tuning, held_out,
    method::{AnswersBy, Method, method},
    methods::MethodContext,
    stopwatch::ready_ms,
};
use crate::{
    belief::{Places, Uncertainty},
    detector::input::{Input, InputConfig, SectorValue},
    error::{Error, Result},
    learning::training_set::covered,
    localiser::sensor_model::{PreparedKernel, least_mean_squares},
    recording::{
        Recording,
        viewpoint::{Moves, Views},
    },
};
use ndarray::{Array2, Axis};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Moved views that a scan is kept in besides the recorded one, by default.
pub const VIEWS: usize = 24;

/// Which scans are seen from moved places as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Moved {
    /// Those of the map: many times the memory and the time.
    #[default]
    Map,
    /// The one that is asked about: the map keeps one scan a place, and the robot moves what it sees.
    Query,
}

/// Do the channels that are worked from look different from a moved place? Then scans can be kept in views.
pub(super) fn moves_show(input: &InputConfig, recording: &Recording) -> bool {
    let wanted = |name: &String| input.channels.is_empty() || input.channels.contains(name);
    recording
        .channels()
        .iter()
        .any(|c| wanted(&c.name) && c.unit == "m" && c.bearing_rad.is_some())
}

/// The raw-scan kernel: nearest reading of each sector; one common scale a channel keeps distances in proportion.
///
/// # Errors
/// Where the training part is not at hand, or a recording lacks a sensor.
pub(super) fn kernel<'a>(context: &MethodContext<'a>) -> Result<Method<'a>> {
    let scans = Scans::of(context)?;
    let recorded = std::slice::from_ref(&scans.recorded);
    let distances = |asked: &Asked| least_mean_squares(asked.recorded.view(), recorded);
    scans.method(context, recorded, &distances, &|_| Ok(Vec::new()))
}

/// The same with moved views of every scan.
///
/// # Errors
/// As [`kernel`], and where no sensor's readings tell what would be seen from beside.
pub(super) fn kernel_views<'a>(
    context: &MethodContext<'a>,
    views: usize,
    moved: Moved,
) -> Result<Method<'a>> {
    let source = context.source()?;
    if !moves_show(&context.mapped.input, &source.recording) {
        return Err(Error::work(
            "no range sensor whose beams have bearings among the channels, so nothing tells what would be seen from beside",
        ));
    }
    let scans = Scans::of(context)?;
    let drawn = |recording: &Recording, snapshots: &[usize]| -> Result<Vec<Array2<f32>>> {
        let drawing = Views::of(recording)?
            .ok_or_else(|| Error::work("no range sensor whose scans could be moved"))?;
        let view = |view: usize| {
            let mut random = context.seed().numbered_stream("moved views", view as u64);
            let moved = drawing.drawn(snapshots, &Moves::default(), &mut random)?;
            scans.input.transform(&moved)
        };
        (0..views).map(view).collect()
    };
    let mut of_map = vec![scans.recorded.clone()];
    if moved == Moved::Map {
        of_map.extend(drawn(&source.recording, &source.training)?);
        let distances = |asked: &Asked| least_mean_squares(asked.recorded.view(), &of_map);
        let method = scans.method(context, &of_map, &distances, &|_| Ok(Vec::new()));
        return Ok(with_views(method?, views));
    }
    let of_run = drawn(context.parts.run, &scans.asked)?;
    let of_validation = drawn(&source.recording, &scans.asked_of_validation)?;
    let distances = |asked: &Asked| {
        let mut least = least_mean_squares(asked.recorded.view(), &of_map);
        let views = if asked.is_run {
            &of_run
        } else {
            &of_validation
        };
        for view in views {
            let square = least_mean_squares(view.view(), &of_map);
            least.zip_mut_with(&square, |least, &square| *least = least.min(square));
        }
        least
    };
    let moved = |k: usize| drawn(context.parts.run, &[k]);
    let method = scans.method(context, &of_map, &distances, &moved)?;
    Ok(with_views(method, views))
}

/// What the kernel of recorded scans is called.
pub(super) const KERNEL: &str = "raw-scan kernel";

/// What the kernel of so many views is called.
pub(super) fn titled(views: usize) -> String {
    format!("kernel, {views} views")
}

/// Bytes of a table of distances at most: two of them are kept.
const MOST_BYTES: usize = 4 << 30;

/// Is a table of the distances of so many snapshots from so many scans small enough? It grows with the square of a log's length.
///
/// # Errors
/// Where it is too large, in words.
fn check_size(snapshots: usize, scans: usize) -> Result<()> {
    let bytes = snapshots
        .saturating_mul(scans)
        .saturating_mul(size_of::<f32>());
    match bytes > MOST_BYTES {
        false => Ok(()),
        true => Err(Error::work(format!(
            "the distances of {snapshots} snapshots from {scans} scans would take {:.1} GB; expected {:.1} GB at most, as of a \
             shorter or a thinner log",
            bytes as f64 / 1e9,
            MOST_BYTES as f64 / 1e9
        ))),
    }
}

fn with_views(method: Method, views: usize) -> Method {
    Method {
        name: "kernel_views".into(),
        title: titled(views),
        ..method
    }
}

/// Scans that the map is asked about.
struct Asked<'a> {
    /// As recorded, `[snapshot, input]`.
    recorded: &'a Array2<f32>,
    /// Those of the unseen part of the run, or of the validation part?
    is_run: bool,
}

/// Scans as inputs `[snapshot, input]`.
struct Scans {
    input: Input,
    /// Of the training part: the map.
    recorded: Array2<f32>,
    /// Snapshots of the validation part that are asked about.
    asked_of_validation: Vec<usize>,
    of_validation: Array2<f32>,
    /// Snapshots of the unseen part of the run that are asked about.
    asked: Vec<usize>,
    of_run: Array2<f32>,
}

impl Scans {
    fn of(context: &MethodContext) -> Result<Self> {
        let source = context.source()?;
        let (asked, asked_of_validation) = (context.asked(), context.asked_of_validation()?);
        check_size(
            asked.len().max(asked_of_validation.len()),
            source.training.len(),
        )?;
        let config = InputConfig {
            sector_values: vec![SectorValue::Nearest],
            ..context.mapped.input.clone()
        };
        let input = Input::fit(&config, &source.recording, &source.training)?.with_common_scale();
        let inputs = |recording: &Recording, snapshots: &[usize]| match snapshots.is_empty() {
            true => Ok(Array2::zeros((0, input.width()))),
            false => input.transform(&recording.select(snapshots)?),
        };
        Ok(Self {
            recorded: inputs(&source.recording, &source.training)?,
            of_validation: inputs(&source.recording, &asked_of_validation)?,
            of_run: inputs(context.parts.run, &asked)?,
            asked,
            asked_of_validation,
            input,
        })
    }

    /// The kernel with these distances `[asked, place]`; a place is kept as its scan in each of `views`, and a scan of the run
    /// is asked about as recorded and as `moved`.
    fn method<'a>(
        &self,
        context: &MethodContext<'a>,
        views: &[Array2<f32>],
        distances: &dyn Fn(&Asked) -> Array2<f32>,
        moved: &(dyn Fn(usize) -> Result<Vec<Array2<f32>>> + Sync),
    ) -> Result<Method<'a>> {
        let (mapped, parts, source) = (&context.mapped, context.parts, context.source()?);
        let places = &mapped.places;
        let source_places = Places::of(&source.recording);
        let on_validation = distances(&Asked {
            recorded: &self.of_validation,
            is_run: false,
        });
        let square = distances(&Asked {
            recorded: &self.of_run,
            is_run: true,
        });
        let ready_ms = ready_ms(&parts.unseen, |k| {
            let recorded = self.input.transform(&parts.run.select(&[k])?)?;
            for asked in [recorded].iter().chain(&moved(k)?) {
                least_mean_squares(asked.view(), views);
            }
            Ok(())
        })?;

        // The bandwidth of least error on the validation part, by prior.
        let validation = covered(&source_places, &self.asked_of_validation, places);
        let tuned = |prior: Uncertainty| {
            let counted = held_out::counted(prior, &source_places, &validation, places);
            let asked = &self.asked_of_validation;
            let is_counted = |row: &usize| counted.binary_search(&asked[*row]).is_ok();
            let rows: Vec<usize> = (0..asked.len()).filter(is_counted).collect();
            evidence_tuning::tuned_bandwidth(
                prior,
                &source_places.select(&counted),
                places,
                on_validation.select(Axis(0), &rows).view(),
            )
        };
        let held_out = context.on_counted(|prior, truths| {
            let is_counted = |row: &usize| truths.binary_search(&self.asked[*row]).is_ok();
            let rows: Vec<usize> = (0..self.asked.len()).filter(is_counted).collect();
            let (truths, square) = (parts.places.select(truths), square.select(Axis(0), &rows));
            Ok(held_out::by_kernel(
                prior,
                &truths,
                places,
                square.view(),
                tuned(prior),
            ))
        })?;
        let bandwidth = tuned(Uncertainty::Global);
        let chance = mapped.map.unmodelled_probability;
        let values: usize = views.iter().map(Array2::ncols).sum();
        let prepared = |snapshots: &[usize], square| {
            let cells = Arc::clone(&context.cells);
            PreparedKernel::new(snapshots.to_vec(), square, cells, bandwidth, chance)
        };
        let sensor = prepared(&self.asked, square);
        let validation = prepared(&self.asked_of_validation, on_validation);
        Ok(Method {
            bandwidth: Some(bandwidth),
            ready_ms,
            validation: Some(Arc::new(validation)),
            held_out,
            ..method(
                "kernel",
                KERNEL,
                Some(size_of::<f32>() * values),
                AnswersBy::PreparedSensor(Arc::new(sensor)),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_that_no_memory_holds_is_refused() {
        check_size(5_000, 20_000).unwrap();
        let fault = check_size(250_000, 750_000).unwrap_err().to_string();
        assert!(
            fault.contains("250000 snapshots from 750000 scans would take 750.0 GB"),
            "{fault}"
        );
        assert!(check_size(usize::MAX, 2).is_err());
    }
}
