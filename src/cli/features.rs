//! `ballmark features`: the output of each filter at every snapshot.

use super::{
    Outcome,
    dataset::{read, warn_of_other_sensors},
    files::{make_writable, write_text},
    page::{PAGE, call, write_page},
    print,
};
use crate::{
    belief::Uncertainty,
    detector::Detector,
    error::{Error, Result},
    experiment::configuration::Experiment,
    model::{Model, ModelBank},
    recording::Recording,
    report::{Cell, Curve, Page, Panel, Part, Table, Trace, scatter_plot, stacked_plot},
    storage,
};
use ndarray::{Array2, Axis};
use std::{fmt::Write, path::PathBuf};

/// The output of each filter at every snapshot: a CSV file, and plots beside it.
///
/// Columns: index, x_m, y_m, heading_rad, f1, f2, … with f the probability that the feature is seen. Plots beside it show
/// the first eight along the route (F.svg), or in the plane where the dataset has no route (F.f1.svg, F.f2.svg, …). Of a bank of
/// filters there is the table alone, and no page, with the columns of each set: 2m.f1, 2m.f2, …
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark features models/corridor-2m.safetensors \\
    datasets/corridor-small.npz -o features.csv")]
pub struct Arguments {
    /// Model, as `ballmark train` writes it.
    #[arg(value_name = "M.safetensors")]
    model: PathBuf,
    /// Dataset whose snapshots are the input.
    #[arg(value_name = "D.npz")]
    dataset: PathBuf,
    /// Configuration of the training; its section [degraded] says by which sensor the dataset is seen.
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// Folder for a page to look at (index.html) with the plots.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// CSV file to write.
    #[arg(short, long, value_name = "F.csv")]
    output: PathBuf,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    if arguments
        .output
        .extension()
        .is_some_and(|ending| ending == "svg")
    {
        return Err(Error::usage(format!(
            "{}: the plots are named .svg; expected another ending for the table, such as .csv",
            arguments.output.display()
        )));
    }
    storage::check_target(&arguments.output)?;
    if let Some(folder) = &arguments.report {
        make_writable(folder)?;
    }
    let degraded = Experiment::read(arguments.config.as_deref(), None)?.degraded;
    let bank = ModelBank::read(&arguments.model)?;
    let dataset = &arguments.dataset;
    let recording = read(dataset, &degraded)?;
    if let [model] = bank.sets() {
        return of_one(model, &recording, &arguments);
    }
    let models: Vec<&Model> = bank.sets().iter().collect();
    warn_of_other_sensors(&models, &recording);
    let mut columns = Vec::new();
    let mut all = Array2::zeros((recording.len(), 0));
    for model in models {
        let answers = answers(model, &recording).map_err(|e| e.in_file(dataset))?;
        let prior = model.header.prior;
        columns.extend(numbered(
            &format!("{}.", column_name(prior)),
            answers.ncols(),
        ));
        all.append(Axis(1), answers.view())
            .map_err(|e| Error::work(format!("features of {prior}: {e}")))?;
    }
    write_text(&arguments.output, &csv(&recording, &columns, &all))?;
    print(&format!(
        "{}: {} snapshots, {} sets of {} features\n",
        arguments.output.display(),
        recording.len(),
        bank.sets().len(),
        all.ncols() / bank.sets().len()
    ))?;
    Ok(Outcome::Done)
}

/// A set's name in a header of CSV, which has commas of its own: `2m`, `2m_0.3rad`.
fn column_name(prior: Uncertainty) -> String {
    prior.to_string().replace(',', "_")
}

/// P(f_i = 1 | s) of every snapshot.
fn answers(model: &Model, recording: &Recording) -> Result<Array2<f32>> {
    model.detector().probabilities(&*model.seen_in(recording)?)
}

/// The table and the plots of a single model.
fn of_one(model: &Model, recording: &Recording, arguments: &Arguments) -> Result<Outcome> {
    let in_dataset = |e: Error| e.in_file(&arguments.dataset);
    let answers = answers(model, recording).map_err(in_dataset)?;
    warn_of_other_sensors(&[model], recording);
    let columns = numbered("", answers.ncols());
    write_text(&arguments.output, &csv(recording, &columns, &answers))?;
    let title = format!("Filters for uncertainty {}", model.header.prior);
    let mut summary = format!(
        "{}: {} snapshots, {} features\n",
        arguments.output.display(),
        recording.len(),
        answers.ncols()
    );
    if answers.ncols() > MAX_PICTURED {
        summary += &format!("plots: the first {MAX_PICTURED} features\n");
    }
    let mut parts = vec![Part::table("How often each is seen", shares(&answers))];
    for (name, picture) in plots(&title, recording, &answers)? {
        let path = arguments.output.with_extension(name);
        write_text(&path, &picture)?;
        summary += &format!("{}: their plot\n", path.display());
        let (caption, alt) = match recording.route_m() {
            Some(_) => (
                "Output of each filter along the last run.",
                "Probability that each feature is seen, along the route",
            ),
            None => (
                "Output of a filter over the plan.",
                "Probability that a feature is seen, over the plan",
            ),
        };
        parts.push(Part::picture(caption, alt, picture));
    }
    if let Some(folder) = &arguments.report {
        let content = Page {
            title,
            summary: vec![format!(
                "{} features in {} snapshots of {}; pictured are the first {MAX_PICTURED} at most.",
                answers.ncols(),
                recording.len(),
                arguments.dataset.display()
            )],
            command: call(),
            parts,
            config: vec![("Model".into(), to_json(&model.header)?)],
        };
        write_page(folder, &content)?;
        summary += &format!("{}: all of it to look at\n", folder.join(PAGE).display());
    }
    print(&summary)?;
    Ok(Outcome::Done)
}

/// How often each feature is seen, by its probabilities and by the snapshots at which it is more likely than not.
fn shares(answers: &Array2<f32>) -> Table {
    let mut table = Table::new([
        "feature",
        "mean P(f = 1)",
        "P(f = 1) above ½, % of snapshots",
    ]);
    for (i, column) in answers.columns().into_iter().enumerate() {
        let (count, sum) = (
            column.len().max(1) as f64,
            column.iter().map(|&p| f64::from(p)).sum::<f64>(),
        );
        let seen = column.iter().filter(|p| **p > 0.5).count() as f64;
        table.row([
            Cell::Text(format!("f{}", i + 1)),
            Cell::Number(sum / count, 3),
            Cell::Number(100.0 * seen / count, 1),
        ]);
    }
    table
}

fn to_json(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(value).map_err(|e| Error::work(format!("the model's header: {e}")))
}

/// Features that are pictured: more are not worth looking at one by one; the table has them all.
const MAX_PICTURED: usize = 8;

/// Names of the columns of so many features: `f1`, `f2`, …, with what stands before each.
pub(super) fn numbered(before: &str, features: usize) -> Vec<String> {
    (1..=features).map(|i| format!("{before}f{i}")).collect()
}

/// One row a snapshot.
pub(super) fn csv(recording: &Recording, columns: &[String], answers: &Array2<f32>) -> String {
    let mut text = String::from("index,x_m,y_m,heading_rad");
    for column in columns {
        let _ = write!(text, ",{column}"); // writing to a String can't fail
    }
    text.push('\n');
    for (k, row) in answers.rows().into_iter().enumerate() {
        let p = recording.poses()[k];
        let _ = write!(text, "{k},{},{},{}", p.x_m, p.y_m, p.heading_rad);
        for f in row {
            let _ = write!(text, ",{f}");
        }
        text.push('\n');
    }
    text
}

/// Pictures of the first [`MAX_PICTURED`] features, each with the ending of its name: along the route, the last run with a
/// panel a feature; in the plane, a picture a feature.
pub(super) fn plots(
    title: &str,
    recording: &Recording,
    answers: &Array2<f32>,
) -> Result<Vec<(String, String)>> {
    let pictured = answers.ncols().min(MAX_PICTURED);
    let Some(route) = recording.route_m() else {
        let (x, y): (Vec<f64>, Vec<f64>) = recording.poses().iter().map(|p| (p.x_m, p.y_m)).unzip();
        return (0..pictured)
            .map(|i| {
                let values: Vec<f64> = answers.column(i).iter().map(|&f| f64::from(f)).collect();
                let label = format!("P(f{} = 1)", i + 1);
                let picture = scatter_plot(title, &label, &x, &y, &values, Some((0.0, 1.0)))?;
                Ok((format!("f{}.svg", i + 1), picture))
            })
            .collect();
    };
    let runs = recording.runs();
    let run = runs[runs.len() - 1].clone();
    let mut order: Vec<usize> = run.collect();
    order.sort_by(|&a, &b| route[a].total_cmp(&route[b]));
    let panels: Vec<Panel> = (0..pictured)
        .map(|i| Panel {
            y_label: format!("P(f{} = 1)", i + 1),
            curves: vec![Curve {
                name: String::new(),
                x: order.iter().map(|&k| route[k]).collect(),
                y: order.iter().map(|&k| f64::from(answers[[k, i]])).collect(),
                band: None,
            }],
            y_range: Some((0.0, 1.0)),
        })
        .collect();
    let picture = stacked_plot(title, "along the route (m)", &panels, Trace::Line)?;
    Ok(vec![("svg".into(), picture)])
}
