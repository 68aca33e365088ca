//! Bandwidths, and how sharply the field's likelihood counts, chosen on snapshots that the field was not learned from.

use super::{LabelledReadings, SignalField, SignalFieldConfig};
use crate::{belief::Places, error::Result};
use rayon::prelude::*;

/// Bandwidths h that are tried, in metres.
const BANDWIDTHS_M: [f64; 4] = [0.3, 0.6, 1.2, 2.4];

/// Bandwidths ρ that are tried, in radians.
const BANDWIDTHS_RAD: [Option<f64>; 3] = [Some(0.4), Some(1.0), None];

/// Powers of the likelihood that are tried: readings are less independent of each other than their product says.
const POWERS: [f64; 5] = [1.0, 0.5, 0.25, 0.125, 0.0625];

/// Of more validation snapshots or candidates than this, evenly spaced ones are judged.
const MOST_JUDGED: usize = 500;
const MOST_CANDIDATES: usize = 3000;

/// A field with the constants that served best.
#[derive(Debug, Clone)]
pub struct TunedSignalField {
    /// The field, learned with the best bandwidths.
    pub field: SignalField,
    /// The power of its likelihood that served best: multiply ln P(z | ξ) by it.
    pub power: f64,
    /// Mean over the validation snapshots of −ln of the probability that is given to the true place among the candidates;
    /// ln of their number (and one) is chance. `None` where there was nothing to validate on.
    pub negative_log_likelihood: Option<f64>,
}

/// Learns the field with the bandwidths and the power under which validation snapshots are given the greatest probability
/// at their true places, each against the candidates: of 12 bandwidths (4 along a route) and 5 powers, the first that has the
/// least mean of −ln P(ξ* | z), P(ξ* | z) = l(ξ*) / (l(ξ*) + Σ_c l(ξ_c)), with l the likelihood to the power.
///
/// This asks for honest probabilities, not for the least error: where readings change from run to run, it chooses a wide
/// kernel and a small power, under which the mean error of one snapshot can be larger than at power 1.
///
/// `config` gives all other constants, and the bandwidths where there is no validation snapshot. Validation snapshots
/// should lie where training snapshots are: of other places the field says that it knows nothing. Candidates are the places
/// of the training snapshots as a rule.
///
/// # Errors
/// As [`SignalField::fit`] and [`SignalField::at`], and where validation snapshots have other values than training ones.
pub fn fit_tuned(
    training: &LabelledReadings,
    validation: &LabelledReadings,
    candidates: &Places,
    config: &SignalFieldConfig,
) -> Result<TunedSignalField> {
    if validation.is_empty() || candidates.is_empty() {
        return Ok(TunedSignalField {
            field: SignalField::fit(training, config)?,
            power: 1.0,
            negative_log_likelihood: None,
        });
    }
    validation
        .check()
        .map_err(|error| error.context("validation"))?;
    let validation = validation.evenly(MOST_JUDGED);
    let step = candidates.len().div_ceil(MOST_CANDIDATES);
    let kept: Vec<usize> = (0..candidates.len()).step_by(step).collect();
    let candidates = candidates.select(&kept);
    let headings: &[Option<f64>] = match training.places {
        Places::Route(_) => &[None],
        Places::Plane(_) => &BANDWIDTHS_RAD,
    };
    let mut best: Option<(TunedSignalField, f64)> = None;
    for bandwidth_m in BANDWIDTHS_M {
        for &bandwidth_rad in headings {
            let config = SignalFieldConfig {
                bandwidth_m,
                bandwidth_rad,
                ..config.clone()
            };
            let field = SignalField::fit(training, &config)?;
            let found = negative_log_likelihoods(&field, &validation, &candidates)?;
            for (power, loss) in POWERS.into_iter().zip(found) {
                if best.as_ref().is_none_or(|(_, least)| loss < *least) {
                    let tuned = TunedSignalField {
                        field: field.clone(),
                        power,
                        negative_log_likelihood: Some(loss),
                    };
                    best = Some((tuned, loss));
                }
            }
        }
    }
    match best {
        Some((tuned, _)) => Ok(tuned),
        None => SignalField::fit(training, config).map(|field| TunedSignalField {
            field,
            power: 1.0,
            negative_log_likelihood: None,
        }),
    }
}

/// Mean −ln P(ξ* | z) over the validation snapshots, for every power.
fn negative_log_likelihoods(
    field: &SignalField,
    validation: &LabelledReadings,
    candidates: &Places,
) -> Result<[f64; POWERS.len()]> {
    let (at_candidates, at_truths) = (field.at(candidates)?, field.at(&validation.places)?);
    let losses: Vec<[f64; POWERS.len()]> = (0..validation.len())
        .into_par_iter()
        .map(|truth| {
            let readings = validation.values.row(truth);
            let of_truth = at_truths.log_likelihood(readings)?[truth];
            let others = at_candidates.log_likelihood(readings)?;
            Ok(POWERS.map(|power| {
                let ratio = |other: &f64| power * (other - of_truth);
                let greatest = others.iter().map(ratio).fold(0.0, f64::max);
                let sum: f64 = others.iter().map(|l| (ratio(l) - greatest).exp()).sum();
                greatest + ((-greatest).exp() + sum).ln()
            }))
        })
        .collect::<Result<_>>()?;
    let mean = |power: usize| losses.iter().map(|l| l[power]).sum::<f64>() / losses.len() as f64;
    Ok(std::array::from_fn(mean))
}
