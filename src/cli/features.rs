//! `ballmark features`: the output of each filter at every snapshot.

use super::{
    Outcome,
    dataset::{answers, check_numbers, read, warn_of_other_sensors},
    files::{make_writable, write_text},
    page::{PAGE, call, write_page},
    picture::write_picture,
    print,
};
use crate::{
    belief::Uncertainty,
    error::{Error, Result},
    experiment::configuration::Experiment,
    model::{Model, ModelBank},
    recording::Recording,
    report::{Cell, Curve, Page, Panel, Part, Table, Trace, scatter_plot, stacked_plot},
    storage,
};
use ndarray::{Array2, Axis};
use std::{
    fmt::Write,
    path::{Path, PathBuf},
};

/// The output of each filter at every snapshot: a CSV file, and plots beside it.
///
/// Columns: index, x_m, y_m, heading_rad, f1, f2, … with f the probability that the feature is seen. Plots beside it show
/// the first eight along the route (F.svg, F.png), or in the plane where the dataset has no route (F.f1.svg, F.f2.svg, …). Of a bank of
/// filters the table has the columns of each set, 2m.f1, 2m.f2, …, and the plots stand in the page alone.
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
        .is_some_and(|ending| ending == "svg" || ending == "png")
    {
        return Err(Error::usage(format!(
            "{}: the plots are named .svg and .png; expected another ending for the table, such as .csv",
            arguments.output.display()
        )));
    }
    storage::check_target(&arguments.output)?;
    if let Some(folder) = &arguments.report {
        make_writable(folder)?;
    }
    let degraded = Experiment::read(arguments.config.as_deref(), None)?.degraded;
    let bank = ModelBank::read(&arguments.model)?;
    let recording = read(&arguments.dataset, &degraded)?;
    let models: Vec<&Model> = bank.sets().iter().collect();
    warn_of_other_sensors(&models, &recording);
    let is_bank = models.len() > 1;
    let mut columns = Vec::new();
    let mut all = Array2::zeros((recording.len(), 0));
    let (mut parts, mut plotted) = (Vec::new(), Vec::new());
    for model in &models {
        let prior = model.header.prior;
        let answers = answers(model, &recording).map_err(|e| e.in_file(&arguments.dataset))?;
        check_numbers(&arguments.model, &answers)?;
        let before = match is_bank {
            true => format!("{}.", column_name(prior)),
            false => String::new(),
        };
        columns.extend(numbered(&before, answers.ncols()));
        let title = format!("Filters for uncertainty {prior}");
        let plots = plots(&title, &recording, &answers)?;
        parts.extend(page_parts(
            is_bank.then_some(title),
            &recording,
            &answers,
            &plots,
        ));
        plotted.extend(plots);
        all.append(Axis(1), answers.view())
            .map_err(|e| Error::work(format!("features of {prior}: {e}")))?;
    }
    let output = &arguments.output;
    write_text(output, &csv(&recording, &columns, &all))?;
    let (sets, features) = (models.len(), all.ncols() / models.len().max(1));
    let what = match is_bank {
        true => format!("{sets} sets of {features} features"),
        false => format!("{features} features"),
    };
    let mut summary = format!(
        "{}: {} snapshots, {what}\n",
        output.display(),
        recording.len()
    );
    if !is_bank {
        if features > MAX_PICTURED {
            summary += &format!("plots: the first {MAX_PICTURED} features\n");
        }
        for (ending, picture) in plotted {
            let mut name = output.with_extension("").into_os_string();
            name.push(ending);
            write_picture(Path::new(&name), &picture)?;
            let name = Path::new(&name).display();
            summary += &format!("{name}.svg, {name}.png: their plot\n");
        }
    }
    if let Some(folder) = &arguments.report {
        let title = match &models[..] {
            [model] => format!("Filters for uncertainty {}", model.header.prior),
            _ => format!("A bank of {sets} sets of filters"),
        };
        let headers: Vec<_> = models.iter().map(|model| &model.header).collect();
        let content = Page {
            title,
            summary: vec![format!(
                "{what} in {} snapshots of {}; pictured are the first {MAX_PICTURED} at most.",
                recording.len(),
                arguments.dataset.display()
            )],
            command: call(),
            parts,
            config: vec![(
                "Model".into(),
                match &headers[..] {
                    [header] => to_json(header)?,
                    _ => to_json(&headers)?,
                },
            )],
        };
        write_page(folder, &content)?;
        summary += &format!("{}: all of it to look at\n", folder.join(PAGE).display());
    }
    print(&summary)?;
    Ok(Outcome::Done)
}

/// A set's name in a header of CSV, which has commas of its own: `2m`, `2m_0.3rad`.
fn column_name(prior: Uncertainty) -> String {
    prior.to_string().replace(',', "_")
}

/// A set of filters on a page, below its heading where it is one of several.
fn page_parts(
    heading: Option<String>,
    recording: &Recording,
    answers: &Array2<f32>,
    plots: &[(String, String)],
) -> Vec<Part> {
    let mut parts: Vec<Part> = heading.map(Part::Heading).into_iter().collect();
    parts.push(Part::table("How often each is seen", shares(answers)));
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
    let pictures = plots.iter();
    parts.extend(pictures.map(|(_, picture)| Part::picture(caption, alt, picture.clone())));
    parts
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

/// Pictures of the first [`MAX_PICTURED`] features, each with what its name ends with: along the route, the last run with a
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
                Ok((format!(".f{}", i + 1), picture))
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
    Ok(vec![(String::new(), picture)])
}
