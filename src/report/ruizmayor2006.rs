//! The figures of Ruiz-Mayor et al. (2006), ours beside what is printed.

use super::{
    Cell, Curve, Panel, Table, category_plot,
    comparison::Sheet,
    paper::{sheet, text, with_half},
};
use crate::{
    error::Result,
    experiment::{
        printed::RUIZMAYOR_2006,
        ruizmayor2006::{ExperimentRecord, Figures, Ruizmayor2006Record, Worlds},
    },
    score::prediction_correction::PriorInterval,
};

/// Its tables.
pub fn sheets(record: &Ruizmayor2006Record) -> Vec<Sheet> {
    let Some(printed) = record.experiments.first() else {
        return Vec::new();
    };
    vec![
        figures_beside_the_papers(record, printed),
        by_prior_error(printed),
        by_step(record),
        by_noise(record),
        by_worlds(record),
        timing(record),
    ]
}

/// Its figures, by name, as SVG: the posterior error by intervals of the prior's (Figs. 8 and 9).
///
/// # Errors
/// Where a figure can't be drawn.
pub fn pictures(record: &Ruizmayor2006Record) -> Result<Vec<(String, String)>> {
    let Some(printed) = record.experiments.first() else {
        return Ok(Vec::new());
    };
    let overall = &printed.together.overall;
    let position = by_interval(&overall.by_prior_position_m, 100.0, "cm", "position")?;
    let heading = by_interval(&overall.by_prior_heading_deg, 1.0, "°", "heading")?;
    Ok(vec![
        ("figure_8".into(), position),
        ("figure_9".into(), heading),
    ])
}

fn by_interval(intervals: &[PriorInterval], scale: f64, unit: &str, what: &str) -> Result<String> {
    let names: Vec<String> = intervals.iter().map(|i| interval(i, scale)).collect();
    let x: Vec<f64> = (0..names.len()).map(|i| i as f64).collect();
    let of = |value: fn(&PriorInterval) -> Option<f64>| -> Vec<f64> {
        let values = intervals.iter().map(value);
        values
            .map(|value| scale * value.unwrap_or(f64::NAN))
            .collect()
    };
    let curve = |name: &str, y: Vec<f64>| Curve {
        name: name.into(),
        x: x.clone(),
        y,
        band: None,
    };
    let panel = Panel {
        y_label: format!("{what} error ({unit})"),
        curves: vec![
            curve("before: mean", of(|i| i.prior_mean)),
            curve("after: mean", of(|i| i.posterior.map(|p| p.mean))),
            curve(
                "after: 95 % within",
                of(|i| i.posterior.map(|p| p.percentiles.p95)),
            ),
        ],
        y_range: None,
    };
    let title = format!("What correction leaves of the {what} error, all runs");
    category_plot(
        &title,
        &format!("{what} error before ({unit})"),
        &names,
        &panel,
    )
}

fn interval(of: &PriorInterval, scale: f64) -> String {
    let above = scale * of.above;
    match of.up_to {
        Some(up_to) => format!("{above:.0}–{:.0}", scale * up_to),
        None => format!("over {above:.0}"),
    }
}

fn figures_beside_the_papers(record: &Ruizmayor2006Record, printed: &ExperimentRecord) -> Sheet {
    let names = printed.figures.iter().map(|figures| figures.name.clone());
    let headers = ["quantity", "paper"].map(String::from).into_iter();
    let mut table = Table::new(headers.chain(names));
    let mut row = |name: &str, paper: Option<f64>, of: &dyn Fn(&Figures) -> Cell| {
        let ours = printed.figures.iter().map(of);
        table.row([text(name), Cell::number(paper, 1)].into_iter().chain(ours));
    };
    let paper = &RUIZMAYOR_2006;
    row("estimates of a repetition", Some(141.0), &|f| {
        Cell::Count(f.n as u64)
    });
    row(
        "largest position error (cm)",
        Some(paper.largest[0]),
        &|f| with_half(&f.largest_m, 100.0),
    );
    row("largest heading error (°)", Some(paper.largest[1]), &|f| {
        with_half(&f.largest_deg, 1.0)
    });
    row(
        "95 % of position errors within (cm)",
        Some(paper.p95[0]),
        &|f| with_half(&f.p95_m, 100.0),
    );
    row(
        "95 % of heading errors within (°)",
        Some(paper.p95[1]),
        &|f| with_half(&f.p95_deg, 1.0),
    );
    row(
        "optimal: within 7.1 cm and 5° (%)",
        Some(paper.optimal),
        &|f| with_half(&f.optimal, 100.0),
    );
    row("merit of position, mean + sd (cm; Fig. 7)", None, &|f| {
        with_half(&f.merit_m, 100.0)
    });
    row("merit of heading, mean + sd (°; Fig. 7)", None, &|f| {
        with_half(&f.merit_deg, 1.0)
    });
    for (number, name) in ["C_XY", "C_T", "C_XYT"].into_iter().enumerate() {
        let not_worse = format!("{name}: not worse than the prior (%)");
        row(&not_worse, Some(paper.correction[number]), &|f| {
            with_half(&f.not_worse[number], 100.0)
        });
        let better = format!("{name}: better than the prior (%)");
        row(&better, Some(paper.correction[number]), &|f| {
            with_half(&f.better[number], 100.0)
        });
    }
    table.caption(format!(
        "mean of {} repetitions ± half of its 95 % interval; the paper has one",
        record.config.repetitions
    ));
    table.caption(
        "of C the paper prints one figure, whose sign, ≤ or <, is lost: it stands beside both",
    );
    table.caption(
        "ground truth: exact, since simulated. Time of a prediction: none, since priors are drawn",
    );
    sheet(
        "figures",
        "Figs. 6 and 7: what correction leaves, all runs and each",
        table,
    )
}

fn by_prior_error(printed: &ExperimentRecord) -> Sheet {
    let mut table = Table::new([
        "error before",
        "estimates",
        "mean before",
        "mean after",
        "95 % after",
        "improved",
        "unchanged",
        "worsened",
    ]);
    let overall = &printed.together.overall;
    for (intervals, scale, unit) in [
        (&overall.by_prior_position_m, 100.0, "cm"),
        (&overall.by_prior_heading_deg, 1.0, "°"),
    ] {
        for of in intervals {
            let scaled = |value: Option<f64>| Cell::number(value.map(|value| scale * value), 1);
            table.row([
                text(format!("{} {unit}", interval(of, scale))),
                Cell::Count(of.correction.n as u64),
                scaled(of.prior_mean),
                scaled(of.posterior.map(|p| p.mean)),
                scaled(of.posterior.map(|p| p.percentiles.p95)),
                Cell::Count(of.correction.improved as u64),
                Cell::Count(of.correction.unchanged as u64),
                Cell::Count(of.correction.worsened as u64),
            ]);
        }
    }
    table.caption("estimates of all runs and repetitions");
    sheet(
        "by_prior_error",
        "Figs. 8 and 9: by how far the prior is off",
        table,
    )
}

fn by_step(record: &Ruizmayor2006Record) -> Sheet {
    let mut table = Table::new([
        "s_T (°)",
        "poses",
        "95 % (cm)",
        "95 % (°)",
        "optimal (%)",
        "C_XY ≤ (%)",
        "C_T ≤ (%)",
    ]);
    let steps = record.config.heading_steps_deg.len();
    for experiment in record.experiments.iter().take(steps) {
        if let Some(all) = experiment.figures.first() {
            table.row([
                Cell::Number(experiment.heading_step_deg, 0),
                Cell::Count(experiment.poses as u64),
                with_half(&all.p95_m, 100.0),
                with_half(&all.p95_deg, 1.0),
                with_half(&all.optimal, 100.0),
                with_half(&all.not_worse[0], 100.0),
                with_half(&all.not_worse[1], 100.0),
            ]);
        }
    }
    table.caption("s_T in degrees; 95 %: what so many errors stay within; optimal: within 7.1 cm and half of s_T");
    sheet("by_heading_step", "Cost against s_T (4.3)", table)
}

fn by_noise(record: &Ruizmayor2006Record) -> Sheet {
    let mut table = Table::new([
        "noise (m)",
        "95 % (cm)",
        "95 % (°)",
        "C_XY ≤ (%)",
        "C_T ≤ (%)",
        "C_XYT ≤ (%)",
    ]);
    let first = record.config.heading_steps_deg.first();
    let of_step = record
        .experiments
        .iter()
        .filter(|e| Some(&e.heading_step_deg) == first && e.worlds == Worlds::AsTheyAre);
    for experiment in of_step {
        if let Some(all) = experiment.figures.first() {
            let factors = all.not_worse.iter().map(|factor| with_half(factor, 100.0));
            let cells = [
                Cell::Number(experiment.range_noise_m, 2),
                with_half(&all.p95_m, 100.0),
                with_half(&all.p95_deg, 1.0),
            ];
            table.row(cells.into_iter().chain(factors));
        }
    }
    sheet("by_range_noise", "Degraded perception (3.4, 4.4)", table)
}

fn by_worlds(record: &Ruizmayor2006Record) -> Sheet {
    let mut table = Table::new([
        "worlds",
        "run",
        "95 % (cm)",
        "optimal (%)",
        "C_XY ≤ (%)",
        "C_T ≤ (%)",
        "C_XYT ≤ (%)",
    ]);
    let first = record.experiments.first();
    let others = record
        .experiments
        .iter()
        .filter(|e| e.worlds != Worlds::AsTheyAre);
    for experiment in first.into_iter().chain(others) {
        let worlds = match experiment.worlds {
            Worlds::AsTheyAre => "as they are".to_string(),
            Worlds::LongestReadingM(m) => format!("sonars to {m} m (6 m)"),
            Worlds::PilastersEveryM(m) => format!("pilasters every {m} m in R3"),
        };
        for figures in &experiment.figures {
            let factors = figures
                .not_worse
                .iter()
                .map(|factor| with_half(factor, 100.0));
            let cells = [
                text(worlds.clone()),
                text(figures.name.clone()),
                with_half(&figures.p95_m, 100.0),
                with_half(&figures.optimal, 100.0),
            ];
            table.row(cells.into_iter().chain(factors));
        }
    }
    table.caption(
        "the paper tells neither how far its sonars read nor what stood along the walls of R3",
    );
    sheet(
        "by_worlds",
        "Why R3 is worse here than in the paper: two guesses tried",
        table,
    )
}

/// Wall clock, which differs from call to call, apart from everything else.
fn timing(record: &Ruizmayor2006Record) -> Sheet {
    let mut table = Table::new(["s_T (°)", "ms a correction"]);
    let seconds = record.timing.correction_s.iter();
    for (step_deg, s) in record.config.heading_steps_deg.iter().zip(seconds) {
        table.row([Cell::Number(*step_deg, 0), Cell::Number(1000.0 * s, 2)]);
    }
    table.caption("median of a correction of R2 on one thread; of a prediction nothing, since priors are drawn");
    sheet("timing", "Time of a correction (2.1)", table)
}
