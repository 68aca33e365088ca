//! An evaluated trajectory as tables, within 100 columns.

mod floor;
mod runs;

pub use floor::traces_plot;
pub use runs::{conditions_text, runs_tables};

use super::{Cell, Table};
use crate::score::{
    prediction_correction::{
        CorrectionFactor, ErrorSummary, PredictionCorrection, PriorInterval, RunMetric,
    },
    trajectory::{Alignment, Delta, DeltaUnit, Evaluation, Statistics},
};

/// The tables of an evaluation: its errors and, where the estimates before correction are known, the prediction–correction metric.
pub fn trajectory_tables(evaluation: &Evaluation) -> Vec<Table> {
    let mut tables = vec![errors(evaluation)];
    if let Some(metric) = &evaluation.prediction_correction {
        tables.extend(metric_tables(metric, evaluation.total));
    }
    tables
}

/// The prediction–correction metric of all runs together, out of `total` real poses.
fn metric_tables(metric: &PredictionCorrection, total: usize) -> [Table; 4] {
    [
        estimation_errors(metric, total),
        correction(metric, total),
        intervals(
            "position (m)",
            "position error before correction (m)",
            &metric.overall.by_prior_position_m,
            4,
        ),
        intervals(
            "heading (deg)",
            "heading error before correction (deg)",
            &metric.overall.by_prior_heading_deg,
            3,
        ),
    ]
}

fn errors(evaluation: &Evaluation) -> Table {
    let mut table = Table::new([
        "error", "rmse", "mean", "median", "std", "min", "max", "matched", "total",
    ]);
    let mut row = |name: &str, of: &Statistics, decimals| {
        let numbers = [of.rmse, of.mean, of.median, of.std, of.min, of.max];
        let mut cells = vec![Cell::Text(name.into())];
        cells.extend(numbers.map(|number| Cell::Number(number, decimals)));
        cells.extend([evaluation.matched, evaluation.total].map(|n| Cell::Count(n as u64)));
        table.row(cells);
    };
    row("APE, translation (m)", &evaluation.ape.translation_m, 4);
    row("APE, rotation (deg)", &evaluation.ape.rotation_deg, 3);
    row("RPE, translation (m)", &evaluation.rpe.translation_m, 4);
    row("RPE, rotation (deg)", &evaluation.rpe.rotation_deg, 3);
    let percent = 100.0 * evaluation.completeness;
    let paired = match evaluation.max_difference_s {
        Some(difference) => format!("within {difference} s"),
        None => "in order, without time stamps".into(),
    };
    table.caption(format!(
        "completeness {percent:.1} % of the reference's poses; the estimate has {}, paired {paired}",
        evaluation.estimate_poses
    ));
    table.caption(format!("RPE: {}", measured(evaluation)));
    let flat = if evaluation.in_plane {
        "; both seen from above"
    } else {
        ""
    };
    let found = &evaluation.alignment;
    table.caption(match found.kind {
        Alignment::None => format!("not aligned{flat}"),
        kind @ (Alignment::Se2 | Alignment::Se3) => format!("aligned by {kind}{flat}"),
        kind => format!("aligned by {kind}, scale {:.6}{flat}", found.scale),
    });
    table
}

/// What the relative error is measured between.
fn measured(evaluation: &Evaluation) -> String {
    let Delta {
        value,
        unit,
        all_pairs,
        from_reference,
        ..
    } = evaluation.rpe_delta.delta;
    let apart = match (unit, value) {
        (DeltaUnit::Frames, 1.0) => "1 pose apart".to_string(),
        (DeltaUnit::Frames, _) => format!("{value} poses apart"),
        _ => format!("{value} {unit} apart"),
    };
    let which = if all_pairs {
        "all pairs"
    } else {
        "consecutive pairs"
    };
    let along = if from_reference {
        "reference"
    } else {
        "estimate"
    };
    format!(
        "{} pairs of poses {apart} along the {along}, {which}",
        evaluation.rpe_delta.pairs
    )
}

fn estimation_errors(metric: &PredictionCorrection, total: usize) -> Table {
    let mut table = Table::new([
        "estimate", "mean", "std", "merit", "50 %", "90 %", "95 %", "100 %", "matched", "total",
    ]);
    let mut row = |name: &str, of: &ErrorSummary, decimals| {
        let at = &of.percentiles;
        let numbers = [of.mean, of.std, of.merit, at.p50, at.p90, at.p95, at.p100];
        let mut cells = vec![Cell::Text(name.into())];
        cells.extend(numbers.map(|number| Cell::Number(number, decimals)));
        cells.extend([of.n, total].map(|n| Cell::Count(n as u64)));
        table.row(cells);
    };
    let of = &metric.overall;
    row("prior, position (m)", &of.prior.position_m, 4);
    row("posterior, position (m)", &of.posterior.position_m, 4);
    row("prior, heading (deg)", &of.prior.heading_deg, 3);
    row("posterior, heading (deg)", &of.posterior.heading_deg, 3);
    table.caption("Ruiz-Mayor et al. 2006, 3.3: prior and posterior, before and after correction");
    table.caption(
        "merit = mean + std; 95 % of the errors are no larger than what stands below 95 %",
    );
    truth_and_search(of).for_each(|line| table.caption(line));
    let time = |seconds: Option<f64>| {
        seconds.map_or("not known from poses".to_string(), |s| format!("{s:.6} s"))
    };
    table.caption(format!(
        "time of a prediction: {}; of a correction: {}",
        time(metric.prediction_s),
        time(metric.correction_s)
    ));
    table
}

/// What is known of the limits of truth and search, in a line each.
fn truth_and_search(of: &RunMetric) -> impl Iterator<Item = String> {
    let truth = match &of.truth {
        None => "precision of the truth: not stated (--truth-precision)".to_string(),
        Some(truth) => {
            let part = |precision: Option<f64>, within: Option<usize>, unit| {
                let (precision, within) = (precision?, within?);
                Some(format!(
                    "{within} of {} errors within {precision} {unit}",
                    of.n
                ))
            };
            let parts = [
                part(truth.position_m, truth.positions_within, "m"),
                part(truth.heading_deg, truth.headings_within, "deg"),
            ];
            let parts: Vec<String> = parts.into_iter().flatten().collect();
            format!("precision of the truth: {}", parts.join(", "))
        }
    };
    let search = match &of.optimal {
        None => "steps of the search: not stated (--search-step)".to_string(),
        Some(optimal) => {
            let limits = [
                optimal.limit_position_m.map(|l| format!("{l:.4} m")),
                optimal.limit_heading_deg.map(|l| format!("{l:.3} deg")),
            ];
            let limits: Vec<String> = limits.into_iter().flatten().collect();
            format!(
                "optimal for the search, within {}: {:.1} % ({} of {})",
                limits.join(" and "),
                100.0 * optimal.fraction,
                optimal.count,
                of.n
            )
        }
    };
    [truth, search].into_iter()
}

fn correction(metric: &PredictionCorrection, total: usize) -> Table {
    let mut table = Table::new([
        "factor",
        "improved",
        "unchanged",
        "worsened",
        "C with <= (%)",
        "C with < (%)",
        "matched",
        "total",
    ]);
    let mut row = |name: &str, of: &CorrectionFactor| {
        let mut cells = vec![Cell::Text(name.into())];
        cells.extend([of.improved, of.unchanged, of.worsened].map(|n| Cell::Count(n as u64)));
        cells.extend([of.not_worse, of.better].map(|share| Cell::Number(100.0 * share, 1)));
        cells.extend([of.n, total].map(|n| Cell::Count(n as u64)));
        table.row(cells);
    };
    let of = &metric.overall.correction;
    row("C_XY, position", &of.position);
    row("C_T, heading", &of.heading);
    row("C_XYT, both", &of.both);
    table.caption("Ruiz-Mayor et al. 2006, 3.4: posterior error against prior error, pose by pose");
    table.caption(
        "both: improved where neither error is larger and one is less; < asks for both to be less",
    );
    table
}

fn intervals(what: &str, before: &str, of: &[PriorInterval], decimals: usize) -> Table {
    let mut table = Table::new([
        format!("prior {what}"),
        "mean".into(),
        "posterior mean".into(),
        "95 %".into(),
        "improved".into(),
        "unchanged".into(),
        "worsened".into(),
        "poses".into(),
    ]);
    for interval in of {
        let up_to = interval
            .up_to
            .map_or("more".to_string(), |end| format!("{end:.decimals$}"));
        let after = interval.posterior;
        let factor = &interval.correction;
        let number = |value: Option<f64>| Cell::number(value, decimals);
        table.row([
            Cell::Text(format!("{:.decimals$} to {up_to}", interval.above)),
            number(interval.prior_mean),
            number(after.map(|of| of.mean)),
            number(after.map(|of| of.percentiles.p95)),
            Cell::Count(factor.improved as u64),
            Cell::Count(factor.unchanged as u64),
            Cell::Count(factor.worsened as u64),
            Cell::Count(factor.n as u64),
        ]);
    }
    table.caption(format!("posterior error by intervals of the {before}"));
    table
}
