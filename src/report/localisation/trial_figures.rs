//! Success at a trial's end, coverage, rejection and paired tests, as CSV.

use super::{Cell, MethodResult, Record, Table};
use crate::experiment::{end_success::WITHIN_M, region_coverage::LEVELS};

/// Columns of `localisation.csv`, each figure followed by its 95 % interval.
pub(super) fn extra_headers() -> Vec<String> {
    let success = WITHIN_M.map(|m| match m < 1.0 {
        true => format!("success_{}m", m.to_string().replace('.', "")),
        false => format!("success_{m}m"),
    });
    let coverage = LEVELS.map(|level| format!("coverage_{:.0}", 100.0 * level));
    let names = success.into_iter().chain(["heading_within_5deg".into()]);
    names
        .chain(coverage)
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
    success
        .chain([heading])
        .chain(coverage)
        .flat_map(|(share, ci95)| {
            [share, ci95.map(|ci| ci[0]), ci95.map(|ci| ci[1])].map(|value| Cell::number(value, 4))
        })
        .collect()
}

/// What is left where the least sure trials are rejected, one row a method and share of rejected trials.
pub fn risk_coverage(record: &Record) -> Table {
    let mut table = Table::new(["system", "rejected", "trials", "point_error_m", "within_1m"]);
    for result in &record.results {
        for row in &result.risk_coverage {
            table.row([
                Cell::Text(result.name.clone()),
                Cell::Number(row.rejected, 1),
                Cell::Count(row.trials as u64),
                Cell::Number(row.point_error_m, 4),
                Cell::Number(row.within_1m, 4),
            ]);
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
    ]);
    for test in &record.paired_tests {
        table.row([
            Cell::Text(test.name.clone()),
            Cell::Text(test.against.clone()),
            Cell::number(test.error_difference_m, 4),
            Cell::number(test.p, 6),
            Cell::number(test.p_holm, 6),
            Cell::number(test.found_difference, 4),
            Cell::number(test.p_found, 6),
            Cell::number(test.p_found_holm, 6),
        ]);
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
            "coverage_99",
        ];
        assert_eq!(figures, expected);
        assert_eq!(headers[1..3], ["success_02m_low95", "success_02m_high95"]);
    }
}
