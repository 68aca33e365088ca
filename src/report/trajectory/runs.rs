//! Several runs as tables, and what is known of their conditions as text.

use super::{Cell, Table, metric_tables};
use crate::score::{
    prediction_correction::{FrameworkReport, RunConditions, RunMetric},
    trajectory::{RunFacts, RunsEvaluation},
};

/// The tables of several runs: errors run by run and, where estimates before correction are known, the prediction–correction metric of each
/// and of all together.
pub fn runs_tables(all: &RunsEvaluation) -> Vec<Table> {
    let mut tables = vec![errors_by_run(all)];
    if let Some(metric) = &all.prediction_correction {
        let mut by_run = Table::new([
            "run", "n", "prior m", "post m", "95 %", "merit", "prior °", "post °", "95 %", "merit",
            "C_XY", "C_T", "C_XYT",
        ]);
        metric
            .runs
            .iter()
            .for_each(|run| correction_row(&mut by_run, run));
        if metric.runs.len() > 1 {
            correction_row(&mut by_run, &metric.overall);
        }
        by_run.caption(
            "mean error before and after correction, what 95 % of those after do not exceed, merit = mean + std;\n\
             C in %, with ties counted (Ruiz-Mayor et al. 2006, 3.3 and 3.4)",
        );
        tables.push(by_run);
        let total = all.runs.iter().map(|run| run.evaluation.total).sum();
        tables.extend(metric_tables(metric, total));
    }
    tables.push(conditions(all));
    tables
}

fn errors_by_run(all: &RunsEvaluation) -> Table {
    let mut table = Table::new([
        "run", "APE m", "mean", "max", "APE °", "RPE m", "RPE °", "matched", "total",
    ]);
    for run in &all.runs {
        let of = &run.evaluation;
        table.row([
            Cell::Text(run.name.clone()),
            Cell::Number(of.ape.translation_m.rmse, 4),
            Cell::Number(of.ape.translation_m.mean, 4),
            Cell::Number(of.ape.translation_m.max, 4),
            Cell::Number(of.ape.rotation_deg.rmse, 3),
            Cell::Number(of.rpe.translation_m.rmse, 4),
            Cell::Number(of.rpe.rotation_deg.rmse, 3),
            Cell::Count(of.matched as u64),
            Cell::Count(of.total as u64),
        ]);
    }
    table.caption("APE, RPE: root of the mean square; mean and max of the APE in metres");
    table
}

fn correction_row(table: &mut Table, of: &RunMetric) {
    let percent = |share: f64| Cell::Number(100.0 * share, 1);
    table.row([
        Cell::Text(of.name.clone()),
        Cell::Count(of.n as u64),
        Cell::Number(of.prior.position_m.mean, 3),
        Cell::Number(of.posterior.position_m.mean, 3),
        Cell::Number(of.posterior.position_m.percentiles.p95, 3),
        Cell::Number(of.posterior.position_m.merit, 3),
        Cell::Number(of.prior.heading_deg.mean, 2),
        Cell::Number(of.posterior.heading_deg.mean, 2),
        Cell::Number(of.posterior.heading_deg.percentiles.p95, 2),
        Cell::Number(of.posterior.heading_deg.merit, 2),
        percent(of.correction.position.not_worse),
        percent(of.correction.heading.not_worse),
        percent(of.correction.both.not_worse),
    ]);
}

/// What the poses tell of each run's conditions.
fn conditions(all: &RunsEvaluation) -> Table {
    let mut table = Table::new([
        "run", "poses", "way m", "s", "per m", "per s", "m/s", "°/m", "x m", "y m",
    ]);
    for run in &all.runs {
        let RunFacts {
            poses,
            way_m,
            duration_s,
            per_m,
            per_s,
            speed_m_per_s,
            turning_deg_per_m,
            extent_m,
            ..
        } = run.facts;
        table.row([
            Cell::Text(run.name.clone()),
            Cell::Count(poses as u64),
            Cell::Number(way_m, 1),
            Cell::number(duration_s, 1),
            Cell::number(per_m, 2),
            Cell::number(per_s, 2),
            Cell::number(speed_m_per_s, 2),
            Cell::number(turning_deg_per_m, 1),
            Cell::Number(extent_m[0], 1),
            Cell::Number(extent_m[1], 1),
        ]);
    }
    table.caption(
        "run conditions as the poses tell them: way of the real poses, estimates a metre and a second, speed,\n\
         turning, extent (Ruiz-Mayor et al. 2006, 3.1 and 3.2)",
    );
    table
}

/// The experiments framework report and each run's conditions, as stated; what is not is said to be missing.
pub fn conditions_text(framework: &FrameworkReport, runs: &[(&str, &RunConditions)]) -> String {
    let mut text = String::from("experiments framework (Ruiz-Mayor et al. 2006, 3.1)\n");
    let report = |text: &mut String, aspects: Vec<(&str, Option<&str>)>| {
        for (aspect, stated) in aspects {
            let stated = stated.map_or("missing".to_string(), one_line);
            text.push_str(&format!("  {aspect}: {stated}\n"));
        }
    };
    report(&mut text, framework.aspects());
    for (name, conditions) in runs {
        text.push_str(&format!("run conditions of {name} (3.2)\n"));
        report(&mut text, conditions.aspects());
    }
    text
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
