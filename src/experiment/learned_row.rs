//! The filter with features of a snapshot: those that a model learned, and, for comparison, random ones.

use super::{
    method::{FeatureAnswers, Method},
    methods::MethodContext,
};
use crate::{
    belief::{Evidence, FeatureMap, Places},
    detector::{Detector, input::Input, random_projection::RandomProjection},
    error::Result,
    model::Model,
};
use ndarray::Array2;

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
    let n = model.features();
    let detector = model.detector();
    let source = context.parts.source.as_ref();
    let as_kept = |features: Array2<f32>| match rounded {
        Rounded::No => features,
        Rounded::ToBits => features.mapv(f32::round),
    };
    let on_run = FeatureAnswers::of_run(&detector, context.parts.run)?;
    let answers = FeatureAnswers {
        run: as_kept(on_run.run),
        source: source
            .map(|source| detector.probabilities(&source.recording).map(as_kept))
            .transpose()?,
        ..on_run
    };
    let places = match context.mapped.places {
        Places::Plane(_) => Places::Plane(model.pose.clone()),
        Places::Route(_) => model.places(),
    };
    let activation = as_kept(model.activation.clone()).mapv(f64::from);
    let map = FeatureMap::new(places, activation, model.header.recipe.map.clone())?;
    let (bytes_per_place, evidence) = match rounded {
        Rounded::No => (size_of::<f32>() * n, context.config.evidence),
        Rounded::ToBits => (n.div_ceil(8), Evidence::MeanField),
    };
    let layers = model.weights.layers.iter();
    let numbers: usize = layers.map(|l| l.weight.len() + l.bias.len()).sum();
    Ok(Method {
        motion: Some(model.header.motion.clone()),
        other_bytes: numbers * size_of::<f32>(),
        ..context.features(name, title, bytes_per_place, (answers, map, evidence))?
    })
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
