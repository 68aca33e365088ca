//! What corrections are worth apart from predictions, method by method, for readers and as CSV.

use super::{Cell, Record, Table};
use crate::score::prediction_correction::CorrectionFactor;

/// One row a method that answers with poses: errors before and after correction, and the factors of Ruiz-Mayor et al. (2006).
pub fn correction(record: &Record) -> Table {
    let mut table = Table::new([
        "from a known start",
        "prior m",
        "95 %",
        "post m",
        "95 %",
        "prior °",
        "post °",
        "C_XY",
        "<",
        "C_T",
        "C_XYT",
    ]);
    let mut steps = None;
    for result in &record.results {
        let Some(judged) = &result.correction else {
            continue;
        };
        let metric = &judged.metric;
        steps = steps.or(Some(metric.n));
        let heading =
            |value: f64, decimals| Cell::number(judged.has_headings.then_some(value), decimals);
        let percent = |factor: &CorrectionFactor| 100.0 * factor.not_worse;
        let factors = &metric.correction;
        table.row([
            Cell::Text(result.title.clone()),
            Cell::Number(metric.prior.position_m.mean, 2),
            Cell::Number(metric.prior.position_m.percentiles.p95, 2),
            Cell::Number(metric.posterior.position_m.mean, 2),
            Cell::Number(metric.posterior.position_m.percentiles.p95, 2),
            heading(metric.prior.heading_deg.mean, 1),
            heading(metric.posterior.heading_deg.mean, 1),
            Cell::Number(percent(&factors.position), 0),
            Cell::Number(100.0 * factors.position.better, 0),
            heading(percent(&factors.heading), 0),
            heading(percent(&factors.both), 0),
        ]);
    }
    if let Some(steps) = steps {
        table.caption(format!(
            "prior = the last answer moved as odometry says, post = the answer after the sensors spoke:\n  \
             mean errors and those that 95 % do not exceed, over {steps} steps"
        ));
        table.caption(
            "C_XY % = steps at which the position is no worse for the correction (<: better), C_T of the\n  \
             heading, C_XYT of both (Ruiz-Mayor et al. 2006); 100 and 0 = the sensors change nothing",
        );
    }
    table
}

/// All of it, one row a method.
pub fn correction_figures(record: &Record) -> Table {
    let mut headers: Vec<String> = ["system", "steps"].map(String::from).to_vec();
    for estimate in ["prior", "posterior"] {
        for unit in ["position_m", "heading_deg"] {
            let figures = ["mean", "std", "merit", "p50", "p90", "p95", "p100"];
            headers.extend(figures.map(|figure| format!("{estimate}_{unit}_{figure}")));
        }
    }
    for factor in ["c_xy", "c_t", "c_xyt"] {
        let counts = ["improved", "unchanged", "worsened", "not_worse", "better"];
        headers.extend(counts.map(|count| format!("{factor}_{count}")));
    }
    headers.extend(
        [
            "c_xy_not_worse_low95",
            "c_xy_not_worse_high95",
            "c_xy_better_low95",
            "c_xy_better_high95",
            "position_gain_m",
            "position_gain_m_low95",
            "position_gain_m_high95",
            "optimal",
        ]
        .map(String::from),
    );
    let mut table = Table::new(headers);
    for result in &record.results {
        let Some(judged) = &result.correction else {
            continue;
        };
        let metric = &judged.metric;
        let mut row = vec![
            Cell::Text(result.name.clone()),
            Cell::Count(metric.n as u64),
        ];
        for of in [&metric.prior, &metric.posterior] {
            for (summary, is_known) in [
                (&of.position_m, true),
                (&of.heading_deg, judged.has_headings),
            ] {
                let at = &summary.percentiles;
                let all = [
                    summary.mean,
                    summary.std,
                    summary.merit,
                    at.p50,
                    at.p90,
                    at.p95,
                    at.p100,
                ];
                row.extend(all.map(|value| Cell::number(is_known.then_some(value), 4)));
            }
        }
        let factors = &metric.correction;
        for (factor, is_known) in [
            (&factors.position, true),
            (&factors.heading, judged.has_headings),
            (&factors.both, judged.has_headings),
        ] {
            let counts = [factor.improved, factor.unchanged, factor.worsened];
            row.extend(counts.map(|count| match is_known {
                true => Cell::Count(count as u64),
                false => Cell::number(None, 0),
            }));
            let shares = [factor.not_worse, factor.better];
            row.extend(shares.map(|share| Cell::number(is_known.then_some(share), 4)));
        }
        let ends =
            |ci95: Option<[f64; 2]>| [0, 1].map(|end| Cell::number(ci95.map(|ci95| ci95[end]), 4));
        row.extend(ends(judged.c_xy_ci95));
        row.extend(ends(judged.c_xy_better_ci95));
        row.push(Cell::Number(judged.position_gain_m, 4));
        row.extend(ends(judged.position_gain_m_ci95));
        let optimal = metric.optimal.map(|optimal| optimal.fraction);
        row.push(Cell::number(optimal, 4));
        table.row(row);
    }
    table
}
