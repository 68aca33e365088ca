//! What localisation trials gave, as parts of a page.

use super::{
    belief_parts, best_rival, confidence, confidence_figures, correction, correction_figures,
    error_plot, figures, found_plot, kidnapping, paired, risk_coverage_plot, table,
};
use crate::{
    error::Result,
    experiment::localisation::{MethodResult, Record},
    report::{Cell, Part, Table},
};

/// What came of it in words: the first method, the one that finds the robot soonest, and the best rival.
pub fn page_summary(record: &Record) -> Vec<String> {
    let mut lines = Vec::new();
    let Some(first) = record.results.first() else {
        return lines;
    };
    lines.push(format!(
        "{} finds the robot, from a start anywhere, in {} of {} trials in {}{}.",
        first.title,
        share(
            first.global.converged_fraction,
            first.global.converged_fraction_ci95
        ),
        record.trials,
        match record.stretches {
            1 => "a single stretch".to_string(),
            n => format!("{n} stretches"),
        },
        match first.global.distance_to_converge_m {
            Some(metres) => format!(", after {metres:.1} m in the median"),
            None => String::new(),
        }
    ));
    let after = |result: &&MethodResult| result.global.distance_to_converge_m;
    let soonest = record.results.iter().filter(|r| after(r).is_some());
    let metres = |result: &MethodResult| after(&result).unwrap_or(f64::INFINITY);
    let soonest = soonest.min_by(|a, b| metres(a).total_cmp(&metres(b)));
    if let Some(soonest) = soonest.filter(|soonest| soonest.name != first.name) {
        lines.push(format!(
            "Soonest of all is {}: after {:.1} m in the median, in {} of the trials.",
            soonest.title,
            metres(soonest),
            share(
                soonest.global.converged_fraction,
                soonest.global.converged_fraction_ci95
            )
        ));
    }
    if let Some(words) = best_rival::in_words(record) {
        lines.push(words.replace("\n  ", " ") + ".");
    }
    if first.global.is_uncertain {
        lines.push("So few trials, runs or stretches say little: others might give other figures altogether.".into());
    }
    lines
}

/// A share in per cent, with its interval.
fn share(value: f64, interval: Option<[f64; 2]>) -> String {
    let words = format!("{:.0} %", 100.0 * value);
    match interval {
        Some([low, high]) => format!(
            "{words} (95 % interval {:.0} to {:.0} %)",
            100.0 * low,
            100.0 * high
        ),
        None => words,
    }
}

/// Tables and pictures; `title` says of what.
///
/// # Errors
/// None with a record that was made by an experiment.
pub fn page_parts(title: &str, record: &Record) -> Result<Vec<Part>> {
    let mut parts = vec![
        Part::table("Systems on unseen runs", table(record)),
        Part::table("The same with 95 % intervals", intervals(record)),
    ];
    for (start, is_known) in [("start anywhere", false), ("start known", true)] {
        let heading = format!("{title}: {start}");
        parts.push(Part::picture(
            format!("Mean expected error against the distance travelled, {start}; bands are 95 % intervals."),
            curves_in_words(&format!("Mean expected error, {start}"), record, |result| {
                match is_known {
                    true => result.tracked_error_m,
                    false => result.error_at_10m_m,
                }
            }),
            error_plot(&heading, record, is_known)?,
        ));
    }
    parts.push(Part::picture(
        "Share of all trials that are found, sure and right within 1 m for 5 m or to their end, by the distance travelled, start anywhere; bands are 95 % intervals.",
        format!("Share of trials found by distance; at the end: {}.", found_in_words(record)),
        found_plot(&format!("{title}: start anywhere"), record)?,
    ));
    parts.push(Part::picture(
        "Point error at the trials' end against the share of trials that are rejected, those of least confidence first.",
        curves_in_words(
            "Error that is left where the least sure trials are rejected, starting with the mean of all at the left",
            record,
            |result| result.risk_coverage.first().map(|row| row.point_error_m),
        ),
        risk_coverage_plot(&format!("{title}: start anywhere"), record)?,
    ));
    parts.extend(belief_parts(title, record)?);
    parts.push(Part::Heading("More figures".into()));
    for (heading, table) in [
        ("Prediction and correction", correction(record)),
        ("Is it lost, and does it know?", confidence(record)),
        ("Carried away", kidnapping(record)),
    ] {
        if !table.is_empty() {
            parts.push(Part::table(heading, table));
        }
    }
    for (heading, table) in [
        (
            "Every other system against the first, over the same trials",
            paired(record),
        ),
        ("All figures", figures(record)),
        ("Confidence, all figures", confidence_figures(record)),
        (
            "Prediction and correction, all figures",
            correction_figures(record),
        ),
    ] {
        if !table.is_empty() {
            parts.push(Part::folded(heading, table));
        }
    }
    Ok(parts)
}

/// How many each system finds.
fn found_in_words(record: &Record) -> String {
    let of_each = record.results.iter().map(|result| {
        let share = 100.0 * result.global.converged_fraction;
        format!("{} {share:.0} %", result.title)
    });
    of_each.collect::<Vec<_>>().join(", ")
}

/// What a picture of curves shows, for those who can't see it: a figure of each.
fn curves_in_words(
    what: &str,
    record: &Record,
    figure: impl Fn(&MethodResult) -> Option<f64>,
) -> String {
    let of_each = record.results.iter().filter_map(|result| {
        let metres = figure(result)?;
        Some(format!("{} {metres:.2} m", result.title))
    });
    let all: Vec<String> = of_each.collect();
    match what.contains("rejected") {
        true => format!("{what}: {}.", all.join(", ")),
        false => format!("{what}, after 10 m: {}.", all.join(", ")),
    }
}

/// The figures that come with intervals, one row a method.
pub fn intervals(record: &Record) -> Table {
    let mut table = Table::new([
        "system",
        "recall %",
        "found %",
        "right within 1 m at the end %",
        "error m",
        "point error m",
        "tracked m",
    ]);
    let percent = |share: Option<f64>, ends: Option<[f64; 2]>| {
        let ends = ends.map(|ends| ends.map(|end| 100.0 * end));
        Cell::interval(share.map(|share| 100.0 * share), ends, 0)
    };
    for result in &record.results {
        let global = &result.global;
        let mut ends = result.success_at_end.iter();
        let end = ends.find(|end| (end.within_m - 1.0).abs() < 1e-9);
        table.row([
            Cell::Text(result.title.clone()),
            percent(result.recall_1m, result.recall_1m_ci95),
            percent(
                Some(global.converged_fraction),
                global.converged_fraction_ci95,
            ),
            percent(end.map(|end| end.share), end.and_then(|end| end.share_ci95)),
            Cell::interval(result.error_at_10m_m, result.error_at_10m_m_ci95, 2),
            Cell::interval(
                result.point_error_at_10m_m,
                result.point_error_at_10m_m_ci95,
                2,
            ),
            Cell::interval(result.tracked_error_m, result.tracked_error_m_ci95, 2),
        ]);
    }
    table.caption(
        "in brackets the 95 % interval, by bootstrap over runs or stretches; none where there is only one",
    );
    table
}
