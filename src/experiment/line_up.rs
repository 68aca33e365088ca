//! Who takes part in localisation trials by default: the learned filters, and what a user would have without learning.

use super::{
    bank_row::bank,
    kernels::{KERNEL, Moved, VIEWS, kernel, kernel_views, moves_show, titled},
    learned_row::{Rounded, learned_features, random_bits},
    maps::{BEAM, BEAM_MODEL, Field, MAP, PARTICLES, RangeMaps},
    method::Method,
    methods::MethodContext,
    more_particles::FewerParticles,
    product::product,
    sequences::evidence_scale,
    signal_row::{SIGNAL_FIELD, signal_field},
};
use crate::{
    belief::Uncertainty,
    error::{Error, Result},
    model::Model,
};

/// Bits of the wide random code: 8 bytes a place.
const WIDE_BITS: usize = 64;

/// The learned filters of every model first, then the baselines, then odometry alone. Whoever has more to compare pushes to
/// it. The baselines need the recording that the models learned from ([`Parts::source`](super::parts::Parts::source)).
///
/// # Errors
/// Where the run lacks the sensors that the models work from.
pub fn line_up<'a>(context: &MethodContext<'a>) -> Result<Vec<Method<'a>>> {
    let mut all = match context.bank {
        Some(run) => of_bank(context, run)?,
        None => all_learned(context)?,
    };
    let learned = match context.bank {
        Some(_) => BANK_ROWS, // its sets alone are no members of products
        None => all.len(),
    };
    if context.parts.source.is_some() {
        let n = context
            .models
            .first()
            .map_or(WIDE_BITS, |model| model.features());
        match with_map(context, &mut all[..learned]) {
            Ok(methods) => all.extend(methods),
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
        let played = |method: Result<Method<'a>>, name: &str, title: &str| {
            method.unwrap_or_else(|fault| context.left_out(name, title, &fault))
        };
        all.push(played(kernel(context), "kernel", KERNEL));
        let source = context.source()?;
        if moves_show(&context.mapped.input, &source.recording) {
            let method = kernel_views(context, VIEWS, Moved::Map);
            all.push(played(method, "kernel_views", &titled(VIEWS)));
        }
        if n != WIDE_BITS {
            all.push(random_bits(context, n, "random_bits")?);
        }
        all.push(random_bits(context, WIDE_BITS, "random_bits_64")?);
    }
    all.push(context.odometry("odometry", "odometry alone"));
    Ok(all)
}

/// The part of the [line-up](line_up) that takes least time: the learned filters of every model, an occupancy map by its likelihood
/// field, and both together.
///
/// # Errors
/// As [`line_up`], and where the scans make no map.
pub fn features_and_map<'a>(context: &MethodContext<'a>) -> Result<Vec<Method<'a>>> {
    let mut all = all_learned(context)?;
    if context.parts.source.is_some()
        && let Some(map) = RangeMaps::new(context, &context.config.map)?
    {
        let by_map = with_field(context, &mut all, &map, &map.field()?)?;
        all.extend(by_map);
    }
    Ok(all)
}

/// Rows of a bank as a whole.
const BANK_ROWS: usize = 2;

/// A bank, all its sets at once, and each of them alone.
fn of_bank<'a>(context: &MethodContext<'a>, run: &[usize]) -> Result<Vec<Method<'a>>> {
    let models = context.models;
    let alone = |(number, model): (usize, &&Model)| {
        let Labels { name, title } = labels(models, number);
        let (name, title) = (
            format!("{LEARNED}{name}"),
            format!("{} learned{title}", model.features()),
        );
        learned_features(context, model, Rounded::No, &name, &title)
    };
    let mut sets = models
        .iter()
        .enumerate()
        .map(alone)
        .collect::<Result<Vec<_>>>()?;
    for set in &mut sets {
        set.evidence_scale = evidence_scale(set, context)?.map(|tuned| tuned.scale);
    }
    let of_sets: Vec<&Method> = sets.iter().collect();
    let some = context.config.bank.sets.min(models.len());
    let title = format!("bank, {some} of {} sets", models.len());
    let choice = context.config.bank;
    let one = bank(context, (models, run), &of_sets, choice, (BANK, &title))?;
    let all_title = format!("all {} sets at once", models.len());
    let all = product(context, ALL_SETS, &all_title, &of_sets)?;
    let rows = one.into_iter().chain(all).chain(sets).collect::<Vec<_>>();
    match rows.len() == models.len() + BANK_ROWS {
        true => Ok(rows),
        false => Err(Error::work("a bank of sets that are no sensor models")),
    }
}

fn all_learned<'a>(context: &MethodContext<'a>) -> Result<Vec<Method<'a>>> {
    let models = context.models.iter().enumerate();
    let of_each =
        models.map(|(number, model)| learned(context, model, &labels(context.models, number)));
    Ok(of_each
        .collect::<Result<Vec<_>>>()?
        .into_iter()
        .flatten()
        .collect())
}

/// What a user of a range sensor has: an occupancy map, by its likelihood field and by its beam model, each alone and with learned
/// features, and in particle filters.
fn with_map<'a>(
    context: &MethodContext<'a>,
    learned: &mut [Method<'a>],
) -> Result<Vec<Method<'a>>> {
    let Some(map) = RangeMaps::new(context, &context.config.map)? else {
        return Ok(Vec::new());
    };
    let field = map.field()?;
    let mut methods = with_field(context, learned, &map, &field)?;
    match map.beam_model() {
        Ok(mut beam) => {
            methods.extend(with_learned(context, learned, &mut beam, "beams")?);
            methods.push(beam);
        }
        Err(fault) => methods.push(context.left_out(BEAM_MODEL, BEAM, &fault)),
    }
    let mut smaller: Option<(String, usize)> = None;
    for particles in PARTICLES {
        let Some(method) = map.monte_carlo(&field, particles)? else {
            break;
        };
        let fewer_particles = smaller.map(|(name, fewer)| FewerParticles {
            name,
            fewer,
            more: particles,
        });
        smaller = Some((method.name.clone(), particles));
        methods.push(Method {
            fewer_particles,
            ..method
        });
    }
    Ok(methods)
}

/// A map by its likelihood field, after every model's features together with it.
fn with_field<'a>(
    context: &MethodContext<'a>,
    learned: &mut [Method<'a>],
    map: &RangeMaps<'a, '_>,
    field: &Field,
) -> Result<Vec<Method<'a>>> {
    let mut in_filter = map.in_filter(field)?;
    let mut methods = with_learned(context, learned, &mut in_filter, "map")?;
    methods.push(in_filter);
    Ok(methods)
}

/// Is a method of this name one of a model's own, and no rival?
pub(super) fn is_own(name: &str) -> bool {
    (name.starts_with(LEARNED) || name == BANK) && !name.contains('+')
}

/// Is a method of this name a model's features rounded to bits?
pub fn is_as_bits(name: &str) -> bool {
    is_own(name) && name.starts_with(LEARNED_BITS)
}

/// How the names of a model's own methods begin.
const LEARNED: &str = "learned";
/// The name of a bank of filters, of which one set is used at every step.
const BANK: &str = "bank";
/// The name of all its sets at once.
const ALL_SETS: &str = "bank_all_sets";
/// How those begin that round to bits.
const LEARNED_BITS: &str = "learned_bits";

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
    let title = match labels.title.is_empty() {
        true => format!("{n} learned features"),
        false => format!("{n} learned{}", labels.title),
    };
    Ok([
        learned_features(
            context,
            model,
            Rounded::No,
            &format!("{LEARNED}{}", labels.name),
            &title,
        )?,
        learned_features(
            context,
            model,
            Rounded::ToBits,
            &format!("{LEARNED_BITS}{}", labels.name),
            &format!("{n} learned, as bits{}", labels.title),
        )?,
    ])
}

#[cfg(test)]
mod tests {
    use super::is_own;

    #[test]
    fn products_and_rivals_are_no_models_own() {
        let own = [
            "learned",
            "learned_bits",
            "learned_2m",
            "learned_bits_global_16_2",
        ];
        assert!(own.into_iter().all(is_own));
        let rivals = [
            "learned+likelihood_field",
            "learned_2m+signal_field",
            "kernel",
            "odometry",
        ];
        assert!(!rivals.into_iter().any(is_own));
    }
}
