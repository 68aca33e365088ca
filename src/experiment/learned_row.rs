//! The filter with features of a snapshot: those that a model learned, and, for comparison, random ones.

use super::{
    kept_evidence::Judged,
    method::{AnswersBy, FeatureAnswers, Method, method},
    methods::MethodContext,
};
use crate::{
    belief::{Evidence, FeatureMap, GridMap, Places},
    detector::{Viewed, input::Input, net::NetDetector, random_projection::RandomProjection},
    error::Result,
    localiser::{
        PreparedSensorModel,
        sensor_model::{DetectorAnswers, PreparedEveryPose},
    },
    mapping::OccupancyMap,
    model::Model,
};
use std::sync::Arc;

/// How learned features are kept and compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rounded {
    /// As probabilities.
    No,
    /// As bits: the likelier answer of each.
    ToBits,
}

/// The filters of a model and their map. It may have learned from other places than the other methods; where these lie in
/// the plane, so do its own.
///
/// # Errors
/// Where a recording lacks the sensors of the model.
pub(super) fn learned_features<'a>(
    context: &MethodContext<'a>,
    model: &Model,
    rounded: Rounded,
    name: &str,
    title: &str,
) -> Result<Method<'a>> {
    if let Some(method) = at_every_pose(context, model, rounded, name, title)? {
        return Ok(method);
    }
    let n = model.features();
    let detector = looking(context, model);
    let source = context.parts.source.as_ref();
    let as_kept = |features: &DetectorAnswers| match rounded {
        Rounded::No => features.clone(),
        Rounded::ToBits => features.mapped(f32::round),
    };
    let seen = |recording| model.seen_in(recording);
    let run = seen(context.parts.run)?;
    let source = source.map(|source| seen(&source.recording)).transpose()?;
    let answers = context.answers_of(&detector, &run, source.as_deref())?;
    let answers = FeatureAnswers {
        run: as_kept(&answers.run),
        source: answers.source.as_ref().map(as_kept),
        ..answers
    };
    let places = match context.mapped.places {
        Places::Plane(_) => Places::Plane(model.pose.clone()),
        Places::Route(_) => model.places(),
    };
    let activation = match rounded {
        Rounded::No => model.activation.mapv(f64::from),
        Rounded::ToBits => model.activation.mapv(|g| f64::from(g.round())),
    };
    let map = FeatureMap::new(places, activation, model.header.recipe.map.clone())?;
    let (bytes_per_place, evidence) = match rounded {
        Rounded::No => (size_of::<f32>() * n, context.evidence_for(n)),
        Rounded::ToBits => (n.div_ceil(8), Evidence::MeanField),
    };
    Ok(Method {
        motion: Some(model.header.motion.clone()),
        other_bytes: network_bytes(model),
        ..context.features(name, title, bytes_per_place, (answers, map, evidence))?
    })
}

/// The same where the model's map answers at every pose. Its places are the grid's cells, which the robot fills itself from the
/// occupancy map.
///
/// # Errors
/// As [`learned_features`].
fn at_every_pose<'a>(
    context: &MethodContext<'a>,
    model: &Model,
    rounded: Rounded,
    name: &str,
    title: &str,
) -> Result<Option<Method<'a>>> {
    let Places::Plane(candidates) = &context.mapped.places else {
        return Ok(None);
    };
    let as_bits = rounded == Rounded::ToBits;
    // Bits are always held against their map so; of the other ways to weigh probabilities the map of visits knows all.
    if !as_bits && context.config.evidence != Evidence::MeanField {
        return Ok(None);
    }
    let Some(map) = model.code_map(&context.grid, as_bits)? else {
        return Ok(None);
    };
    let at_candidates = match context.priors.is_empty() {
        true => None,
        false => match model.at_every_pose(candidates)? {
            None => return Ok(None),
            known => known,
        },
    };
    let detector = looking(context, model);
    let source = context.parts.source.as_ref();
    let source = source.map(|source| &*source.recording);
    let answers = context.answers_of(&detector, context.parts.run, source)?;
    let judged = match at_candidates {
        None => Judged::default(),
        Some(known) => {
            let known = map.as_kept(known.values.view()).mapv(f64::from);
            let known = Arc::new(GridMap::new(known)?);
            context.held_out_by_features(&answers, &known, Evidence::MeanField)?
        }
    };
    let map = Arc::new(map);
    let prepared = |answers| Arc::new(PreparedEveryPose::new(answers, Arc::clone(&map)));
    Ok(Some(Method {
        motion: Some(model.header.motion.clone()),
        other_bytes: network_bytes(model) + model.occupancy.as_ref().map_or(0, OccupancyMap::bytes),
        fills_map: true,
        held_out: judged.held_out,
        single_snapshots: judged.evidence,
        ready_ms: answers.ready_ms,
        validation: answers
            .source
            .map(|answers| prepared(answers) as Arc<dyn PreparedSensorModel>),
        ..method(
            name,
            title,
            Some(map.bytes_per_cell()),
            AnswersBy::PreparedSensor(prepared(answers.run)),
        )
    }))
}

/// A model's filters, as the configuration has them look at a snapshot.
fn looking(context: &MethodContext<'_>, model: &Model) -> Viewed<NetDetector> {
    let views = context.config.query_views;
    Viewed::new(model.detector(), views, context.seed())
}

/// What the networks take on a robot.
fn network_bytes(model: &Model) -> usize {
    let layers = model.weights.layers.iter();
    let numbers: usize = layers.map(|l| l.weight.len() + l.bias.len()).sum();
    numbers * size_of::<f32>()
}

/// Signs of random projections of the inputs: what learning buys is judged against them.
///
/// # Errors
/// Where the training part is not at hand, or a recording lacks a sensor.
pub(super) fn random_bits<'a>(
    context: &MethodContext<'a>,
    bits: usize,
    name: &str,
) -> Result<Method<'a>> {
    let source = context.source()?;
    let input = Input::fit(&context.mapped.input, &source.recording, &source.training)?;
    let detector = RandomProjection::new(input, bits, context.seed());
    let (answers, map) = context.map_of(&detector)?;
    context.features(
        name,
        &format!("{bits} random bits"),
        bits.div_ceil(8),
        (answers, map, context.evidence_for(bits)),
    )
}
