//! How poses are judged, as the call says.

use super::Arguments;
use crate::{
    error::{Error, Result},
    score::{
        prediction_correction::{Edges, MetricOptions, Precision, SearchStep},
        trajectory::{Delta, EvaluationOptions, Matching},
    },
};

/// The options of the call.
///
/// # Errors
/// One that is out of its range, or that needs estimates before correction where no run `has_prior`.
pub fn options(arguments: &Arguments, has_prior: bool) -> Result<EvaluationOptions> {
    let Arguments {
        max_difference,
        offset,
        ..
    } = *arguments;
    if !(max_difference.is_finite() && max_difference >= 0.0) {
        return Err(Error::usage(format!(
            "--max-difference {max_difference}: expected seconds from 0 on"
        )));
    }
    if !offset.is_finite() {
        return Err(Error::usage(format!("--offset {offset}: expected seconds")));
    }
    fn parsed<T: std::str::FromStr<Err = Error>>(
        name: &str,
        text: Option<&String>,
    ) -> Result<Option<T>> {
        text.map(|text| text.parse().map_err(|e: Error| e.context(name)))
            .transpose()
    }
    let truth_precision: Option<Precision> =
        parsed("--truth-precision", arguments.truth_precision.as_ref())?;
    let search_step: Option<SearchStep> = parsed("--search-step", arguments.search_step.as_ref())?;
    let edges: Option<Edges> = parsed("--prior-intervals", arguments.prior_intervals.as_ref())?;
    let needs_prior = [
        ("--truth-precision", truth_precision.is_some()),
        ("--search-step", search_step.is_some()),
        ("--prior-intervals", edges.is_some()),
    ];
    if let (false, Some((name, _))) = (has_prior, needs_prior.iter().find(|(_, given)| *given)) {
        return Err(Error::usage(format!(
            "{name} is for --prior, or a [[run]] with `prior`; expected both"
        )));
    }
    let delta = Delta {
        value: arguments.delta,
        unit: arguments.delta_unit.parse()?,
        all_pairs: arguments.all_pairs,
        tolerance: arguments.delta_tolerance,
        from_reference: arguments.pairs_from_reference,
    };
    delta.check().map_err(|e| e.context("--delta"))?;
    Ok(EvaluationOptions {
        matching: Matching {
            max_difference_s: max_difference,
            offset_s: offset,
        },
        alignment: arguments.align.parse()?,
        in_plane: arguments.planar,
        delta,
        allow_incomplete: arguments.allow_incomplete,
        metric: MetricOptions {
            truth_precision,
            search_step,
            edges: edges.unwrap_or_default(),
            ..MetricOptions::default()
        },
    })
}
