//! `ballmark features`: the output of each filter at every snapshot.

mod folder;

use super::{
    Outcome,
    dataset::{answers, check_numbers, read, warn_of_other_sensors},
    files::{make_writable, write_text},
    page::PAGE,
    picture::write_picture,
    print,
};
use crate::{
    belief::Uncertainty,
    error::{Error, Result},
    experiment::configuration::Experiment,
    model::{Model, ModelBank},
    recording::Recording,
    report::{Curve, Panel, Trace, scatter_plot, stacked_plot},
    storage,
};
use folder::{Set, shares};
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
    /// Folder for a page to look at (index.html), how often each feature is seen (JSON, text, CSV, Markdown, LaTeX), the plots (SVG, PNG)
    /// and the model's configuration.
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
    let mut sets = Vec::new();
    for model in &models {
        let prior = model.header.prior;
        let answers = answers(model, &recording).map_err(|e| e.in_file(&arguments.dataset))?;
        check_numbers(&arguments.model, &answers)?;
        let before = match is_bank {
            true => format!("{}.", column_name(prior)),
            false => String::new(),
        };
        columns.extend(numbered(&before, answers.ncols()));
        sets.push(Set {
            header: &model.header,
            shares: shares(&answers),
            plots: plots(
                &format!("Filters for uncertainty {prior}"),
                &recording,
                &answers,
            )?,
        });
        all.append(Axis(1), answers.view())
            .map_err(|e| Error::work(format!("features of {prior}: {e}")))?;
    }
    let output = &arguments.output;
    write_text(output, &csv(&recording, &columns, &all))?;
    let features = all.ncols() / sets.len().max(1);
    let what = match is_bank {
        true => format!("{} sets of {features} features", sets.len()),
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
        for (ending, picture) in sets.iter().flat_map(|set| &set.plots) {
            let mut name = output.with_extension("").into_os_string();
            name.push(ending);
            write_picture(Path::new(&name), picture)?;
            let name = Path::new(&name).display();
            summary += &format!("{name}.svg, {name}.png: their plot\n");
        }
    }
    if let Some(folder) = &arguments.report {
        let summary_of_page = format!(
            "{what} in {} snapshots of {}; pictured are the first {MAX_PICTURED} at most.",
            recording.len(),
            arguments.dataset.display()
        );
        folder::write(folder, &recording, &sets, summary_of_page)?;
        summary += &format!("{}: all of it to look at\n", folder.join(PAGE).display());
    }
    print(&summary)?;
    Ok(Outcome::Done)
}

/// A set's name in a header of CSV, which has commas of its own: `2m`, `2m_0.3rad`.
fn column_name(prior: Uncertainty) -> String {
    prior.to_string().replace(',', "_")
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
