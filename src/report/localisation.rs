//! What localisation trials gave, for readers: one table, the curves as CSV, and their picture.

mod beliefs;
mod best_rival;
mod confidence;
mod correction;
mod found_plot;
mod json;
mod kidnapping;
mod more_particles;
mod on_page;
mod repeats;
mod risk_plot;
mod trial_figures;

pub use beliefs::belief_parts;
#[cfg(feature = "rerun")]
pub(super) use beliefs::systems_at_first;
pub use confidence::{confidence, confidence_figures};
pub use correction::{correction, correction_figures};
pub use found_plot::found_plot;
pub use json::json;
pub use kidnapping::{kidnapping, kidnapping_figures};
pub use more_particles::more_particles;
pub use on_page::{intervals, page_parts, page_summary};
pub use risk_plot::risk_coverage_plot;
pub use trial_figures::{paired, risk_coverage};

use super::{Cell, Curve, Table, line_plot};
use crate::{
    error::Result,
    experiment::localisation::{MethodResult, Record},
};
use trial_figures::{COUNTS, counts, extra_figures, extra_headers};

/// The snapshots that single-snapshot figures are over.
fn judged(record: &Record) -> String {
    let (covered, unseen) = (record.covered, record.unseen);
    match record.judged {
        judged if judged > 0 && judged < covered => format!(
            "{judged} of {unseen} unseen snapshots: evenly chosen of the {covered} at places seen in training"
        ),
        _ => format!("{covered} of {unseen} unseen snapshots: those at places seen in training"),
    }
}

/// One row a method, and below it what the columns mean.
pub fn table(record: &Record) -> Table {
    let (mut table, is_marked) = rows(record);
    let priors: Vec<String> = record.priors.iter().map(ToString::to_string).collect();
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
    caption_people(&mut table, record);
    table.caption(format!(
        "{} % = share of the prior error that one snapshot removes,\n  over {}",
        priors
            .iter()
            .map(|prior| plus_minus(prior))
            .collect::<Vec<_>>()
            .join(", "),
        judged(record)
    ));
    for line in [
        "recall % = unseen snapshots each of which alone, from no idea, makes a place within 1 m\n  of the truth the likeliest of all",
        "found % = trials that end up sure and right within 1 m, from a start anywhere;\n  after m = median metres until then (–: fewer than half)",
        "error m = mean expected error after 10 m, over the trials that go so far;\n  tracked m = the same from a known start (–: no trial is that long)",
        "kB = what the robot must hold: places with their poses, networks or map",
    ] {
        table.caption(line);
    }
    caption_marks(&mut table, is_marked);
    for line in repeats::captions(record)
        .into_iter()
        .chain(more_particles(record))
    {
        table.caption(line);
    }
    if let Some(line) = best_rival::in_words(record) {
        table.caption(line);
    }
    table
}

/// The same rows for those who have read what the columns mean.
pub fn brief_table(record: &Record) -> Table {
    let (mut table, is_marked) = rows(record);
    caption_people(&mut table, record);
    caption_marks(&mut table, is_marked);
    table
}

fn caption_people(table: &mut Table, record: &Record) {
    if record.people > 0.0 {
        table.caption(format!(
            "people before {:.0} % of the beams of every unseen snapshot; what was learned knows nothing of them",
            100.0 * record.people
        ));
    }
    if let Some(noise) = &record.noise {
        table.caption(format!(
            "noise on every unseen snapshot: {noise}; what was learned knows nothing of it"
        ));
    }
}

fn caption_marks(table: &mut Table, is_marked: bool) {
    if is_marked {
        table.caption(
            "* over fewer than 10 trials or snapshots, or those of a single run or stretch: uncertain",
        );
    }
}

/// One row a method, those left out below; and whether a figure is marked as uncertain.
fn rows(record: &Record) -> (Table, bool) {
    let priors: Vec<String> = record.priors.iter().map(ToString::to_string).collect();
    let mut headers = vec!["system".to_string()];
    let reduction = |prior: &String| format!("{} %", plus_minus(prior));
    headers.extend(priors.iter().map(reduction));
    headers.extend(
        [
            "recall %",
            "found %",
            "after m",
            "error m",
            "tracked m",
            "kB",
        ]
        .map(String::from),
    );
    let mut table = Table::new(headers);
    let mut is_marked = false;
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
        let mut figure = |value: Option<f64>, decimals: usize, is_uncertain: bool| match value {
            Some(value) if is_uncertain => {
                is_marked = true;
                Cell::Uncertain(value, decimals)
            }
            value => Cell::number(value, decimals),
        };
        let recall = result.recall_1m.map(|share| 100.0 * share);
        row.push(figure(recall, 0, result.recall_is_uncertain()));
        let found = Some(100.0 * global.converged_fraction);
        row.push(figure(found, 0, global.is_uncertain));
        row.push(figure(
            global.distance_to_converge_m,
            1,
            global.is_uncertain,
        ));
        for summary in [global, &result.tracking] {
            let at = summary.reported();
            let is_uncertain = at.is_some_and(|at| at.is_uncertain());
            row.push(figure(at.map(|at| at.expected_error_m), 2, is_uncertain));
        }
        let kilobytes = result.robot_bytes.map(|bytes| bytes as f64 / 1000.0);
        row.push(Cell::number(kilobytes, 1));
        table.row(row);
    }
    for absent in &record.left_out {
        table.caption(format!("{}: left out: {}", absent.title, absent.fault));
    }
    (table, is_marked)
}

fn plus_minus(prior: &str) -> String {
    if prior.starts_with(|c: char| c.is_ascii_digit()) {
        format!("±{prior}")
    } else {
        prior.to_string()
    }
}

/// Every figure of every method, one row each: what [`table`] shows, with 95 % intervals and what it has no room
/// for.
pub fn figures(record: &Record) -> Table {
    let mut headers = vec!["system".to_string()];
    let priors = record.priors.iter();
    headers.extend(priors.map(|prior| format!("error_reduction_{prior}")));
    for shared in [
        "recall_1m",
        "recall_05m",
        "converged_fraction",
        "error_at_10m_m",
        "tracked_error_m",
    ] {
        headers.extend(["", "_low95", "_high95"].map(|end| format!("{shared}{end}")));
    }
    headers.extend(extra_headers());
    let alone = [
        "distance_to_converge_m",
        "mean_error_below_1m_at_m",
        "evidence_scale",
        "bandwidth",
        "bytes_per_place",
        "robot_bytes",
    ];
    headers.extend(alone.map(String::from));
    headers.extend(COUNTS.map(String::from));
    let mut table = Table::new(headers);
    for result in &record.results {
        let mut row = vec![Cell::Text(result.name.clone())];
        for i in 0..record.priors.len() {
            let reduction = result.held_out.get(i).map(|h| h.score.error_reduction);
            row.push(Cell::number(reduction, 4));
        }
        let global = &result.global;
        for (value, interval) in [
            (result.recall_1m, result.recall_1m_ci95),
            (result.recall_05m, result.recall_05m_ci95),
            (
                Some(global.converged_fraction),
                global.converged_fraction_ci95,
            ),
            (result.error_at_10m_m, result.error_at_10m_m_ci95),
            (result.tracked_error_m, result.tracked_error_m_ci95),
        ] {
            row.push(Cell::number(value, 4));
            row.push(Cell::number(interval.map(|ci| ci[0]), 4));
            row.push(Cell::number(interval.map(|ci| ci[1]), 4));
        }
        row.extend(extra_figures(result));
        row.push(Cell::number(global.distance_to_converge_m, 2));
        row.push(Cell::number(global.mean_error_below_1m_at_m, 2));
        row.push(Cell::number(result.evidence_scale, 6));
        row.push(Cell::number(result.bandwidth, 4));
        for bytes in [result.bytes_per_place, result.robot_bytes] {
            row.push(bytes.map_or(Cell::Missing, |bytes| Cell::Count(bytes as u64)));
        }
        row.extend(counts(record, result));
        table.row(row);
    }
    table
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
        "point_low95_m",
        "point_high95_m",
        "found",
        "found_low95",
        "found_high95",
    ]);
    for result in &record.results {
        for (start, summary) in [("anywhere", &result.global), ("known", &result.tracking)] {
            for row in &summary.error_by_distance {
                table.row([
                    Cell::Text(result.name.clone()),
                    Cell::Text(start.into()),
                    Cell::Number(row.distance_m, 2),
                    Cell::Number(row.expected_error_m, 4),
                    Cell::Number(row.point_error_m, 4),
                    Cell::number(row.ci95_m.map(|ci| ci[0]), 4),
                    Cell::number(row.ci95_m.map(|ci| ci[1]), 4),
                    Cell::Count(row.trials as u64),
                    Cell::number(row.point_ci95_m.map(|ci| ci[0]), 4),
                    Cell::number(row.point_ci95_m.map(|ci| ci[1]), 4),
                    Cell::Number(row.found, 4),
                    Cell::number(row.found_ci95.map(|ci| ci[0]), 4),
                    Cell::number(row.found_ci95.map(|ci| ci[1]), 4),
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
