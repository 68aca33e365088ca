//! What localisation trials gave, for readers: one table, the curves as CSV, and their picture.

use super::{Cell, Curve, Table, line_plot};
use crate::{
    error::Result,
    experiment::localisation::{MethodResult, Record, TrialSummary},
};

/// Distances at which the table shows the mean expected error, in metres.
const SHOWN_AT_M: f64 = 10.0;

/// One row a method.
pub fn table(record: &Record) -> Table {
    let priors: Vec<String> = record.results.first().map_or(Vec::new(), |s| {
        s.held_out.iter().map(|h| h.prior.to_string()).collect()
    });
    let mut headers = vec!["system".to_string()];
    headers.extend(
        priors
            .iter()
            .map(|prior| format!("{} %", plus_minus(prior))),
    );
    headers.extend(["found %", "in m", "<1m", "10m", "tracked", "bytes"].map(String::from));
    let mut table = Table::new(headers);
    for result in &record.results {
        let mut row = vec![Cell::Text(result.title.clone())];
        for i in 0..priors.len() {
            let reduction = result
                .held_out
                .get(i)
                .map(|h| 100.0 * h.score.error_reduction);
            row.push(Cell::number(reduction, 1));
        }
        let global = &result.global;
        row.push(Cell::Number(100.0 * global.converged_fraction, 0));
        row.push(Cell::number(global.distance_to_converge_m, 1));
        row.push(Cell::number(global.mean_error_below_1m_at_m, 1));
        row.push(Cell::number(error_at(global, SHOWN_AT_M), 2));
        row.push(Cell::number(error_at(&result.tracking, SHOWN_AT_M), 2));
        let bytes = result.bytes_per_place.map(|bytes| bytes as u64);
        row.push(bytes.map_or(Cell::Missing, Cell::Count));
        table.row(row);
    }
    table.caption(format!(
        "{} trials in {} stretches that training never saw{}",
        record.trials,
        record.stretches,
        if record.unseen_is_validation {
            ", but that stopped it: somewhat flattering"
        } else {
            ""
        },
    ));
    table.caption(format!(
        "{} % = share of the prior error that one snapshot takes away,\n  over {} of {} unseen snapshots: those at places seen in training",
        priors.iter().map(|prior| plus_minus(prior)).collect::<Vec<_>>().join(", "),
        record.covered,
        record.unseen
    ));
    for line in [
        "found % = trials that end up sure and right within 1 m, from a start anywhere;\n  in m = median metres until then (–: fewer than half)",
        "<1m = metres after which the mean expected error first falls under 1 m;\n  10m = that mean after 10 m, in metres, over the trials that go so far",
        "tracked = the same from a known start (–: no trial is that long)",
        "bytes = what the map keeps of each place, besides its pose",
    ] {
        table.caption(line);
    }
    table
}

fn plus_minus(prior: &str) -> String {
    if prior.starts_with(|c: char| c.is_ascii_digit()) {
        format!("±{prior}")
    } else {
        prior.to_string()
    }
}

fn error_at(summary: &TrialSummary, distance_m: f64) -> Option<f64> {
    summary
        .error_by_distance
        .iter()
        .find(|row| row.distance_m >= distance_m - 1e-9)
        .map(|row| row.expected_error_m)
}

/// All mean curves, one row a method, kind of start and distance.
pub fn curves(record: &Record) -> Table {
    let mut table = Table::new([
        "system",
        "start",
        "distance_m",
        "expected_error_m",
        "point_error_m",
        "low95_m",
        "high95_m",
        "trials",
    ]);
    for result in &record.results {
        for (start, summary) in [("anywhere", &result.global), ("known", &result.tracking)] {
            for row in &summary.error_by_distance {
                table.row([
                    Cell::Text(result.name.into()),
                    Cell::Text(start.into()),
                    Cell::Number(row.distance_m, 2),
                    Cell::Number(row.expected_error_m, 4),
                    Cell::Number(row.point_error_m, 4),
                    Cell::number(row.ci95_m.map(|ci| ci[0]), 4),
                    Cell::number(row.ci95_m.map(|ci| ci[1]), 4),
                    Cell::Count(row.trials as u64),
                ]);
            }
        }
    }
    table
}

/// Expected error against distance, with 95 % bands, from an unknown or a known start.
///
/// # Errors
/// None with a record that was made by an experiment.
pub fn error_plot(title: &str, record: &Record, known_start: bool) -> Result<String> {
    let curve = |result: &MethodResult| {
        let rows = &if known_start {
            &result.tracking
        } else {
            &result.global
        }
        .error_by_distance;
        Curve {
            name: result.title.clone(),
            x: rows.iter().map(|row| row.distance_m).collect(),
            y: rows.iter().map(|row| row.expected_error_m).collect(),
            band: Some((
                rows.iter()
                    .map(|row| row.ci95_m.map_or(f64::NAN, |ci| ci[0]))
                    .collect(),
                rows.iter()
                    .map(|row| row.ci95_m.map_or(f64::NAN, |ci| ci[1]))
                    .collect(),
            )),
        }
    };
    let curves: Vec<Curve> = record.results.iter().map(curve).collect();
    line_plot(
        title,
        "distance travelled (m)",
        "expected error (m)",
        &curves,
    )
}
