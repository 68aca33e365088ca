//! The baselines that keep the scans themselves: each training scan once, and each in many moved views.

use super::{
    evidence_tuning, held_out,
    method::{AnswersBy, Method},
    methods::MethodContext,
    parts::TrainingSource,
};
use crate::{
    belief::{Places, Uncertainty},
    detector::input::{Input, InputConfig, SectorValue},
    error::Result,
    learning::training_set::covered,
    localiser::sensor_model::{PreparedKernel, least_mean_squares},
    recording::{
        Recording,
        viewpoint::{Moves, Views},
    },
};
use ndarray::{Array2, Axis};
use std::sync::Arc;

/// Moved views that a scan is kept in besides the recorded one.
const VIEWS: usize = 24;

/// Do the channels that a model works from look different from a moved place? Then scans can be kept in views.
fn moves_show(input: &InputConfig, recording: &Recording) -> bool {
    let wanted = |name: &String| input.channels.is_empty() || input.channels.contains(name);
    recording
        .channels()
        .iter()
        .any(|c| wanted(&c.name) && c.unit == "m" && c.bearing_rad.is_some())
}

/// The raw-scan kernel, and where moves show, the same with [`VIEWS`] moved views of every scan: 25 times the memory and
/// the time.
pub(super) fn kernels<'a>(context: &MethodContext<'a>) -> Result<Vec<Method<'a>>> {
    let source = context.source()?;
    // Raw scans, nearest reading of each sector; one common scale a channel keeps distances in proportion.
    let config = InputConfig {
        sector_values: vec![SectorValue::Nearest],
        ..context.model().header.recipe.input.clone()
    };
    let input = Input::fit(&config, &source.recording, &source.training)?.with_common_scale();
    let of_source = input.transform(&source.recording)?;
    let recorded = of_source.select(Axis(0), &source.training);
    let queries = Queries {
        of_source,
        unseen: input
            .transform(context.parts.run)?
            .select(Axis(0), &context.parts.unseen),
    };

    let mut views = vec![recorded];
    let mut all = vec![queries.method(context, source, &views)?];
    let drawing = Views::of(&source.recording)?.filter(|_| moves_show(&config, &source.recording));
    if let Some(drawing) = drawing {
        for view in 0..VIEWS {
            let mut random = context.seed().numbered_stream("moved views", view as u64);
            let moved = drawing.drawn(&source.training, &Moves::default(), &mut random)?;
            views.push(input.transform(&moved)?);
        }
        all.push(Method {
            name: "kernel_views".into(),
            title: format!("kernel, {VIEWS} views"),
            ..queries.method(context, source, &views)?
        });
    }
    Ok(all)
}

/// What is asked, as inputs `[snapshot, input]`.
struct Queries {
    /// All that the source recorded.
    of_source: Array2<f32>,
    /// The unseen part of the run.
    unseen: Array2<f32>,
}

impl Queries {
    fn method<'a>(
        &self,
        context: &MethodContext<'a>,
        source: &TrainingSource,
        views: &[Array2<f32>],
    ) -> Result<Method<'a>> {
        let (model, parts) = (context.model(), context.parts);
        let places = model.places();
        let source_places = Places::of(&source.recording);
        let validation = covered(&source_places, &source.validation, &places);
        let tuned = self.tuning(&source_places, &validation, &places, views);
        let square = least_mean_squares(self.unseen.view(), views);
        let held_out = context.on_counted(|prior, truths| {
            let is_counted = |row: &usize| truths.binary_search(&parts.unseen[*row]).is_ok();
            let rows: Vec<usize> = (0..parts.unseen.len()).filter(is_counted).collect();
            let (truths, square) = (parts.places.select(truths), square.select(Axis(0), &rows));
            Ok(held_out::by_kernel(
                prior,
                &truths,
                &places,
                square.view(),
                tuned(prior),
            ))
        })?;
        let bandwidth = tuned(Uncertainty::Global);
        let chance = model.header.recipe.map.unmodelled_probability;
        let values: usize = views.iter().map(Array2::ncols).sum();
        let prepared = |snapshots: &[usize], square| {
            let cells = Arc::clone(&context.cells);
            PreparedKernel::new(snapshots.to_vec(), square, cells, bandwidth, chance)
        };
        let sensor = prepared(&parts.unseen, square);
        let of_validation = self.of_source.select(Axis(0), &source.validation);
        let square = least_mean_squares(of_validation.view(), views);
        let on_validation = prepared(&source.validation, square);
        Ok(Method {
            name: "kernel".into(),
            title: "raw-scan kernel".into(),
            bandwidth: Some(bandwidth),
            bytes_per_place: Some(size_of::<f32>() * values),
            other_bytes: 0,
            motion: None,
            evidence_scale: None,
            usual_scale: 1.0,
            validation: Some(Arc::new(on_validation)),
            held_out,
            answers: AnswersBy::PreparedSensor(Arc::new(sensor)),
        })
    }

    /// The bandwidth of least error on the validation part, by prior.
    fn tuning<'a>(
        &self,
        source_places: &'a Places,
        validation: &'a [usize],
        places: &'a Places,
        views: &[Array2<f32>],
    ) -> impl Fn(Uncertainty) -> f64 + 'a {
        let seen = self.of_source.select(Axis(0), validation);
        let square = least_mean_squares(seen.view(), views);
        move |prior| {
            let counted = held_out::counted(prior, source_places, validation, places);
            let rows: Vec<usize> = (0..validation.len())
                .filter(|&row| counted.contains(&validation[row]))
                .collect();
            evidence_tuning::tuned_bandwidth(
                prior,
                &source_places.select(&counted),
                places,
                square.select(Axis(0), &rows).view(),
            )
        }
    }
}
