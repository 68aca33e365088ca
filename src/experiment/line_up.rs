//! Who takes part in localisation trials by default: the learned filters, and what a user would have without learning.

use super::{
    kernels::kernels,
    maps::{MAP, MapMethods, map_methods},
    method::{FeatureAnswers, Method},
    methods::MethodContext,
    product::product,
    sequences::evidence_scale,
    signal_row::{SIGNAL_FIELD, signal_field},
};
use crate::{
    belief::{Evidence, FeatureMap, Uncertainty},
    detector::{Detector, input::Input, random_projection::RandomProjection},
    error::Result,
    model::Model,
};
use ndarray::Array2;

/// Bits of the wide random code: 8 bytes a place.
const WIDE_BITS: usize = 64;

/// The learned filters of every model first, then the baselines, then odometry alone. Whoever has more to compare pushes to
/// it. The baselines need the recording that the models learned from ([`Parts::source`](super::parts::Parts::source)).
///
/// # Errors
/// Where the run lacks the sensors that the models work from.
pub fn line_up<'a>(context: &MethodContext<'a>) -> Result<Vec<Method<'a>>> {
    let mut all = Vec::new();
    for (number, model) in context.models.iter().enumerate() {
        all.extend(learned(context, model, &labels(context.models, number))?);
    }
    if context.parts.source.is_some() {
        let n = context.model().features();
        let learned = all.len();
        match map_methods(context) {
            Ok(None) => (),
            Ok(Some(MapMethods {
                mut field,
                particles,
            })) => {
                let both = with_learned(context, &mut all[..learned], &mut field, "map")?;
                all.extend(both);
                all.push(field);
                all.extend(particles);
            }
            // A rival that this recording does not allow must not keep the others from playing.
            Err(fault) => all.push(context.left_out("likelihood_field", MAP, &fault)),
        }
        match signal_field(context) {
            Ok(None) => (),
            Ok(Some(mut field)) => {
                let both = with_learned(context, &mut all[..learned], &mut field, "field")?;
                all.extend(both);
                all.push(field);
            }
            Err(fault) => all.push(context.left_out("signal_field", SIGNAL_FIELD, &fault)),
        }
        all.extend(kernels(context)?);
        if n != WIDE_BITS {
            all.push(random_bits(context, n, context.evidence(n), "random_bits")?);
        }
        let (evidence, name) = (Evidence::MeanField, "random_bits_64");
        all.push(random_bits(context, WIDE_BITS, evidence, name)?);
    }
    all.push(context.odometry("odometry", "odometry alone"));
    Ok(all)
}

/// Every model's learned features together with another method's sensor model, which titles call `short`.
fn with_learned<'a>(
    context: &MethodContext<'a>,
    learned: &mut [Method<'a>],
    other: &mut Method<'a>,
    short: &str,
) -> Result<Vec<Method<'a>>> {
    // Tuned here, or the products and the trials would each do it again.
    let tune = |method: &mut Method<'a>| -> Result<()> {
        if method.evidence_scale.is_some() {
            return Ok(());
        }
        method.evidence_scale = evidence_scale(method, context)?.map(|tuned| tuned.scale);
        Ok(())
    };
    tune(other)?;
    // The methods of each model: as they are, and rounded to bits.
    let soft = learned.iter_mut().step_by(2);
    let products = soft.map(|soft| {
        tune(soft)?;
        let (name, title) = (
            format!("{}+{}", soft.name, other.name),
            format!("{} + {short}", soft.title),
        );
        product(context, &name, &title, &[soft, other])
    });
    let products = products.collect::<Result<Vec<_>>>()?;
    Ok(products.into_iter().flatten().collect())
}

/// What follows the name and the title of a model's rows.
struct Labels {
    name: String,
    title: String,
}

/// Nothing for a single model; else what it was trained for, with the number of features where that is not enough to tell
/// models apart, and a number where that isn't either.
fn labels(models: &[&Model], number: usize) -> Labels {
    if models.len() == 1 {
        return Labels {
            name: String::new(),
            title: String::new(),
        };
    }
    let model = models[number];
    let prior = model.header.prior;
    let alike = |other: &&&Model| other.header.prior == prior;
    let twin = |other: &&&Model| alike(other) && other.features() == model.features();
    let mut name = format!("_{}", prior.to_string().replace(',', "_"));
    if models.iter().filter(alike).count() > 1 {
        name += &format!("_{}", model.features());
    }
    let mut title = format!(", {}", words(prior));
    if models.iter().filter(twin).count() > 1 {
        let which = 1 + models[..number].iter().filter(twin).count();
        name += &format!("_{which}");
        title += &format!(" ({which})");
    }
    Labels { name, title }
}

/// A prior as tables say it.
fn words(prior: Uncertainty) -> String {
    match prior {
        Uncertainty::Global => prior.to_string(),
        Uncertainty::Window { .. } => format!("±{}", prior.to_string().replacen('m', " m", 1)),
    }
}

/// The filters of a model as they are, and rounded to bits.
fn learned<'a>(
    context: &MethodContext<'a>,
    model: &Model,
    labels: &Labels,
) -> Result<[Method<'a>; 2]> {
    let n = model.features();
    let detector = model.detector();
    let source = context.parts.source.as_ref();
    let answers = FeatureAnswers {
        run: detector.probabilities(context.parts.run)?,
        source: source
            .map(|source| detector.probabilities(&source.recording))
            .transpose()?,
    };
    let bits = |features: &Array2<f32>| features.mapv(f32::round);
    let map_of_bits = FeatureMap::new(
        model.places(),
        bits(&model.activation).mapv(f64::from),
        model.header.recipe.map.clone(),
    )?;
    let answers_in_bits = FeatureAnswers {
        run: bits(&answers.run),
        source: answers.source.as_ref().map(bits),
    };
    let rounded = (answers_in_bits, map_of_bits, Evidence::MeanField);
    let title = match labels.title.is_empty() {
        true => format!("{n} learned features"),
        false => format!("{n} learned{}", labels.title),
    };
    let soft = context.features(
        &format!("learned{}", labels.name),
        &title,
        size_of::<f32>() * n,
        (answers, model.map()?, context.config.evidence),
    )?;
    let rounded = context.features(
        &format!("learned_bits{}", labels.name),
        &format!("{n} learned, as bits{}", labels.title),
        n.div_ceil(8),
        rounded,
    )?;
    let motion = Some(model.header.motion.clone());
    let layers = model.weights.layers.iter();
    let numbers: usize = layers.map(|l| l.weight.len() + l.bias.len()).sum();
    Ok([soft, rounded].map(|method| Method {
        motion: motion.clone(),
        other_bytes: numbers * size_of::<f32>(),
        ..method
    }))
}

fn random_bits<'a>(
    context: &MethodContext<'a>,
    bits: usize,
    evidence: Evidence,
    name: &str,
) -> Result<Method<'a>> {
    let source = context.source()?;
    let config = &context.model().header.recipe.input;
    let input = Input::fit(config, &source.recording, &source.training)?;
    let detector = RandomProjection::new(input, bits, context.seed());
    let (answers, map) = context.mapped(&detector)?;
    context.features(
        name,
        &format!("{bits} random bits"),
        bits.div_ceil(8),
        (answers, map, evidence),
    )
}
