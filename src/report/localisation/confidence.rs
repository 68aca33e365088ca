//! Whether methods know when they are lost, for readers and as CSV.

use super::{Cell, Record, Table};
use crate::score::Auroc;

/// One row a method with a belief: how sure it is of the truth, and whether it knows when it is lost. All numbers are of steps of
/// trials that start anywhere.
pub fn confidence(record: &Record) -> Table {
    let mut table = Table::new([
        "system", "nats", "50 %", "90 %", "95 %", "lost %", "AUROC", "from", "mass", "says %",
        "risk %",
    ]);
    let mut no_idea_nats = None;
    for result in &record.results {
        let Some(judged) = &result.confidence else {
            continue;
        };
        no_idea_nats = Some(judged.nats_of_no_idea);
        let inside = |level: f64| {
            let mut rows = result.coverage.iter();
            let row = rows.find(|row| (row.level - level).abs() < 1e-9);
            Cell::number(row.map(|row| 100.0 * row.share), 0)
        };
        let value = |auroc: Option<Auroc>| Cell::number(auroc.map(|auroc| auroc.value), 3);
        let low = judged.lost_auroc.and_then(|auroc| auroc.ci95);
        table.row([
            Cell::Text(result.title.clone()),
            Cell::number(judged.nats_of_true_place, 2),
            inside(0.5),
            inside(0.9),
            inside(0.95),
            Cell::Number(100.0 * judged.lost, 0),
            value(judged.lost_auroc),
            Cell::number(low.map(|ci95| ci95[0]), 3),
            value(judged.mass_auroc),
            Cell::Number(100.0 * judged.flagged, 0),
            Cell::number(judged.risk.map(|risk| 100.0 * risk), 1),
        ]);
    }
    if let Some(nats) = no_idea_nats {
        table.caption(format!(
            "nats = mean −ln of what the belief gives to the true place, a cell wide (no idea: {nats:.2})"
        ));
        for line in [
            "50 %, … = steps at which the truth lies in the belief's densest 50, 90, 95 %: fewer, too sure",
            "lost % = steps whose estimate is more than 1 m off; AUROC = how well the lost score tells them\n  from the others, from = lower end of its 95 % interval, mass = the same by the belief's word alone",
            "says % = steps at which the robot says that it is lost, risk % = lost ones among all others\n  (score and threshold fitted on the validation part)",
        ] {
            table.caption(line);
        }
    }
    table
}

/// All of it, one row a method, with intervals.
pub fn confidence_figures(record: &Record) -> Table {
    let mut table = Table::new([
        "system",
        "steps",
        "lost",
        "nats_of_true_place",
        "nats_of_true_place_low95",
        "nats_of_true_place_high95",
        "nats_of_no_idea",
        "lost_auroc",
        "lost_auroc_low95",
        "lost_auroc_high95",
        "mass_auroc",
        "mass_auroc_low95",
        "mass_auroc_high95",
        "threshold",
        "flagged",
        "risk",
        "risk_low95",
        "risk_high95",
        "caught",
        "end_entropy_nats",
        "end_modes",
        "base",
        "slope",
    ]);
    for result in &record.results {
        let Some(judged) = &result.confidence else {
            continue;
        };
        let three = |value: Option<f64>, ci95: Option<[f64; 2]>| {
            let ends = [0, 1].map(|end| ci95.map(|ci95| ci95[end]));
            [value, ends[0], ends[1]].map(|value| Cell::number(value, 4))
        };
        let area = |auroc: Option<Auroc>| {
            three(auroc.map(|a| a.value), auroc.and_then(|auroc| auroc.ci95))
        };
        let alone = |value: f64| Cell::Number(value, 4);
        let mut row = vec![
            Cell::Text(result.name.clone()),
            Cell::Count(judged.steps as u64),
            alone(judged.lost),
        ];
        row.extend(three(
            judged.nats_of_true_place,
            judged.nats_of_true_place_ci95,
        ));
        row.push(alone(judged.nats_of_no_idea));
        row.extend(area(judged.lost_auroc));
        row.extend(area(judged.mass_auroc));
        row.extend([judged.threshold, judged.flagged].map(alone));
        row.extend(three(judged.risk, judged.risk_ci95));
        let score = judged.score.as_ref();
        row.extend(
            [
                judged.caught,
                judged.end_entropy_nats,
                judged.end_modes,
                score.map(|score| score.base),
                score.map(|score| score.slope),
            ]
            .map(|value| Cell::number(value, 4)),
        );
        table.row(row);
    }
    table
}
