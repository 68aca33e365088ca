//! What `--report` writes: everything that is known of some runs.

use crate::{
    cli::{
        files::write_text,
        page::{CONFIG, call, write_page},
        picture::write_picture,
        sheets::write_sheets,
    },
    error::Result,
    geometry::Pose,
    report::{
        Cell, Page, Part, Table,
        comparison::{Reader, Sheet},
        traces_plot,
    },
    score::trajectory::{RunTraces, RunsEvaluation},
};
use std::{collections::BTreeSet, path::Path};

/// What programs read.
pub(super) struct Records<'a> {
    /// All figures.
    pub result: &'a serde_json::Value,
    /// All that decided them.
    pub config: &'a serde_json::Value,
}

/// Writes it into a folder that exists.
///
/// # Errors
/// Where a file can't be written.
pub(super) fn write(
    folder: &Path,
    all: &RunsEvaluation,
    records: Records,
    (text, tables): (&str, Vec<Table>),
) -> Result<()> {
    let sheets: Vec<Sheet> = (1..)
        .zip(tables)
        .map(|(number, table)| Sheet {
            name: match number {
                1 => "errors".into(),
                number => format!("errors-{number}"),
            },
            title: match number {
                1 => "Errors".into(),
                _ => "More errors".into(),
            },
            table,
            reader: Reader::Everyone,
        })
        .collect();
    write_sheets(folder, &sheets, &[])?;
    let json = format!("{:#}\n", records.result);
    write_text(&folder.join("trajectory.json"), &json)?;
    let config = format!("{:#}\n", records.config);
    write_text(&folder.join(CONFIG), &config)?;
    write_text(&folder.join("trajectory.txt"), text)?;
    let mut parts: Vec<Part> = sheets
        .into_iter()
        .map(|sheet| Part::table(sheet.title, sheet.table))
        .collect();
    let mut names = BTreeSet::new();
    for (number, run) in all.runs.iter().enumerate() {
        let mut name = file_name(&run.name);
        if !names.insert(name.clone()) {
            name = format!("{name}-{}", number + 1);
        }
        let traces = &run.evaluation.traces;
        let csv = table(traces).csv();
        write_text(&folder.join(format!("traces-{name}.csv")), &csv)?;
        let plot = traces_plot(&run.name, traces)?;
        write_picture(&folder.join(format!("traces-{name}")), &plot)?;
        parts.push(Part::picture(
            format!(
                "The reference, the estimate and, where there is one, the prior: {}.",
                run.name
            ),
            format!(
                "Traces of {} in the plane; the figures are in the tables",
                run.name
            ),
            plot,
        ));
    }
    let runs: Vec<&str> = all.runs.iter().map(|run| run.name.as_str()).collect();
    let content = Page {
        title: format!("Trajectories: {}", runs.join(", ")),
        parts,
        command: call(),
        config: vec![
            ("Result as text".into(), text.to_string()),
            (CONFIG.into(), config),
        ],
        ..Page::default()
    };
    write_page(folder, &content)
}

/// What any file system takes of a name.
fn file_name(name: &str) -> String {
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || "._-".contains(c) {
            c
        } else {
            '-'
        }
    };
    name.chars().take(80).map(plain).collect()
}

/// RP, PEprio and PEpost (R06 eq. 3-1), a row a pose.
fn table(traces: &RunTraces) -> Table {
    let mut headers = vec!["stamp_s".to_string()];
    for trace in ["real", "prior", "estimate"] {
        headers.extend(["x_m", "y_m", "heading_rad"].map(|what| format!("{trace}_{what}")));
    }
    let mut table = Table::new(headers);
    for (k, real) in traces.real.iter().enumerate() {
        let stamp_s = traces.stamp_s.as_ref().map(|stamps| stamps[k]);
        let mut row = vec![Cell::number(stamp_s, 6)];
        let prior = traces.prior.get(k).copied().flatten();
        for pose in [Some(*real), prior, Some(traces.posterior[k])] {
            let number = |of: fn(Pose) -> f64| Cell::number(pose.map(of), 6);
            row.extend([
                number(|p| p.x_m),
                number(|p| p.y_m),
                number(|p| p.heading_rad),
            ]);
        }
        table.row(row);
    }
    table
}
