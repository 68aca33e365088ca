//! Success at a trial's end, coverage, rejection and paired tests, as CSV.

use super::{Cell, MethodResult, Record, Table};
use crate::experiment::{end_success::WITHIN_M, region_coverage::LEVELS};

/// Columns of `localisation.csv`, each figure followed by its 95 % interval.
pub(super) fn extra_headers() -> Vec<String> {
    let success = WITHIN_M.map(|m| match m < 1.0 {
        true => format!("success_{}m", m.to_string().replace('.', "")),
        false => format!("success_{m}m"),
    });
    let turned = success.clone().map(|name| format!("{name}_5deg"));
    let coverage = LEVELS.map(|level| format!("coverage_{:.0}", 100.0 * level));
    let names = success.into_iter().chain(["heading_within_5deg".into()]);
    let more = [
        "risk_coverage_area_m",
        "point_error_at_10m_m",
        "tracked_point_error_m",
    ];
    names
        .chain(coverage)
        .chain(turned)
        .chain(more.map(String::from))
        .flat_map(|name| ["", "_low95", "_high95"].map(|end| format!("{name}{end}")))
        .collect()
}

/// A method's entries in these columns.
pub(super) fn extra_figures(result: &MethodResult) -> Vec<Cell> {
    let success = (0..WITHIN_M.len()).map(|i| {
        let row = result.success_at_end.get(i);
        (row.map(|row| row.share), row.and_then(|row| row.share_ci95))
    });
    let heading = (result.heading_within_5deg, result.heading_within_5deg_ci95);
    let coverage = (0..LEVELS.len()).map(|i| {
        let row = result.coverage.get(i);
        (row.map(|row| row.share), row.and_then(|row| row.share_ci95))
    });
    let turned = (0..WITHIN_M.len()).map(|i| {
        let row = result.success_at_end.get(i);
        let ci95 = row.and_then(|row| row.share_within_5deg_ci95);
        (row.and_then(|row| row.share_within_5deg), ci95)
    });
    let more = [
        (
            result.risk_coverage_area_m,
            result.risk_coverage_area_m_ci95,
        ),
        (
            result.point_error_at_10m_m,
            result.point_error_at_10m_m_ci95,
        ),
        (
            result.tracked_point_error_m,
            result.tracked_point_error_m_ci95,
        ),
    ];
    success
        .chain([heading])
        .chain(coverage)
        .chain(turned)
        .chain(more)
        .flat_map(|(value, ci95)| with_interval(value, ci95))
        .collect()
}

fn with_interval(value: Option<f64>, ci95: Option<[f64; 2]>) -> [Cell; 3] {
    [value, ci95.map(|ci| ci[0]), ci95.map(|ci| ci[1])].map(|value| Cell::number(value, 4))
}

/// How many trials, runs or stretches, and snapshots a method's figures are over, and whether these are too few.
pub(super) const COUNTS: [&str; 4] = ["trials", "units", "recall_snapshots", "is_uncertain"];

/// A method's entries in these columns.
pub(super) fn counts(record: &Record, result: &MethodResult) -> [Cell; 4] {
    let count = |n: usize| Cell::Count(n as u64);
    [
        count(record.trials),
        count(result.global.units),
        count(result.recall_snapshots),
        yes_or_no(result.global.is_uncertain),
    ]
}

fn yes_or_no(is_so: bool) -> Cell {
    Cell::Text(if is_so { "yes" } else { "no" }.into())
}

/// What is left where the least sure trials are rejected, one row a method and share of rejected trials.
pub fn risk_coverage(record: &Record) -> Table {
    let mut table = Table::new([
        "system",
        "rejected",
        "trials",
        "point_error_m",
        "point_error_m_low95",
        "point_error_m_high95",
        "within_1m",
        "within_1m_low95",
        "within_1m_high95",
        "is_uncertain",
    ]);
    for result in &record.results {
        for row in &result.risk_coverage {
            let mut cells = vec![
                Cell::Text(result.name.clone()),
                Cell::Number(row.rejected, 1),
                Cell::Count(row.trials as u64),
            ];
            cells.extend(with_interval(
                Some(row.point_error_m),
                row.point_error_m_ci95,
            ));
            cells.extend(with_interval(Some(row.within_1m), row.within_1m_ci95));
            cells.push(yes_or_no(row.is_uncertain()));
            table.row(cells);
        }
    }
    table
}

/// Every other method against the first, one row each.
pub fn paired(record: &Record) -> Table {
    let mut table = Table::new([
        "system",
        "against",
        "error_difference_m",
        "p",
        "p_holm",
        "found_difference",
        "p_found",
        "p_found_holm",
        "distance_difference_m",
        "p_distance",
        "p_distance_holm",
        "error_difference_m_low95",
        "error_difference_m_high95",
        "found_difference_low95",
        "found_difference_high95",
        "distance_difference_m_low95",
        "distance_difference_m_high95",
        "trials",
        "units",
        "least_p_holm",
        "least_p_found_holm",
        "note",
    ]);
    for test in &record.paired_tests {
        let mut cells = vec![
            Cell::Text(test.name.clone()),
            Cell::Text(test.against.clone()),
            Cell::number(test.error_difference_m, 4),
            Cell::number(test.p, 6),
            Cell::number(test.p_holm, 6),
            Cell::number(test.found_difference, 4),
            Cell::number(test.p_found, 6),
            Cell::number(test.p_found_holm, 6),
            Cell::number(test.distance_difference_m, 4),
            Cell::number(test.p_distance, 6),
            Cell::number(test.p_distance_holm, 6),
        ];
        for ci95 in [
            test.error_difference_m_ci95,
            test.found_difference_ci95,
            test.distance_difference_m_ci95,
        ] {
            let ends = [0, 1].map(|end| ci95.map(|ci95| ci95[end]));
            cells.extend(ends.map(|end| Cell::number(end, 4)));
        }
        cells.extend([test.trials, test.units].map(|n| Cell::Count(n as u64)));
        cells.extend([test.least_p_holm, test.least_p_found_holm].map(|p| Cell::number(p, 6)));
        cells.push(test.note.clone().map_or(Cell::Missing, Cell::Text));
        table.row(cells);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_named_by_distance_and_level() {
        let headers = extra_headers();
        let figures: Vec<&str> = headers.iter().step_by(3).map(String::as_str).collect();
        let expected = [
            "success_02m",
            "success_03m",
            "success_05m",
            "success_1m",
            "heading_within_5deg",
            "coverage_50",
            "coverage_90",
            "coverage_95",
            "coverage_99",
            "success_02m_5deg",
            "success_03m_5deg",
            "success_05m_5deg",
            "success_1m_5deg",
            "risk_coverage_area_m",
            "point_error_at_10m_m",
            "tracked_point_error_m",
        ];
        assert_eq!(figures, expected);
        assert_eq!(headers[1..3], ["success_02m_low95", "success_02m_high95"]);
    }
}
