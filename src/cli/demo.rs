//! `ballmark demo`: the main job on a simulated corridor: learn, localise, compare, report.

use super::{
    Outcome, features,
    localise::{self, write_config, write_report, write_text},
    print,
    progress::Progress,
    train, warn,
};
use crate::{
    belief::Uncertainty,
    detector::Detector,
    error::Result,
    experiment::{
        localisation::{self, LocaliseConfig, Record},
        methods::Parts,
    },
    learning::Recipe,
    model::{Model, Training},
    recording::{Recording, npz},
    report::localisation as tables,
    seed::Seed,
    storage,
    world::corridor::{CorridorConfig, thrun1998},
};
use std::{path::PathBuf, time::Instant};

/// Learn landmarks in a simulated corridor, localise with them, compare and report. About a minute.
///
/// A robot with 24 sonars drives several times along the 89 m corridor of Thrun (1998): doors open and shut, bins move,
/// odometry drifts. Four filters are learned for a robot that knows its place to ±2 m, four for one that knows nothing;
/// then both find out where they are on runs that they never saw, beside baselines that learn nothing.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark demo --toy --out demo-report")]
pub struct Arguments {
    /// Folder for the dataset, the models, the tables (CSV) and the pictures (SVG).
    #[arg(long, value_name = "DIR", default_value = "ballmark-demo")]
    out: PathBuf,
    /// The one seed of the run.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// A few runs, steps and trials only: does it work here? The figures mean little.
    #[arg(long)]
    toy: bool,
    /// One JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let started = Instant::now();
    let folder = &arguments.out;
    storage::make_folder(folder)?;

    let corridor = CorridorConfig {
        runs: if arguments.toy { 6 } else { 12 },
        ..CorridorConfig::default()
    };
    let dataset = folder.join("corridor.npz");
    npz::write(&dataset, &thrun1998(Seed(arguments.seed), &corridor)?)?;
    let recording = npz::read(&dataset)?; // with its checksum, as any user has it

    let mut record: Option<Record> = None;
    for (prior, words) in [("2m", "for ±2 m"), ("global", "for no idea where")] {
        let model = learn(&arguments, prior.parse()?, &recording)?;
        model.write(&folder.join(format!("corridor-{prior}.safetensors")))?;
        let answers = model.detector().probabilities(&recording)?;
        let plots = features::plots(
            &format!("What filters trained {words} answer"),
            &recording,
            &answers,
        )?;
        write_text(
            &folder.join(format!("features-{prior}.csv")),
            &features::csv(&recording, &answers),
        )?;
        for (ending, plot) in plots {
            write_text(&folder.join(format!("features-{prior}.{ending}")), &plot)?;
        }

        let (name, title) = (
            if prior == "2m" {
                "learned_2m"
            } else {
                "learned_global"
            },
            format!("4 learned, {}", if prior == "2m" { "±2 m" } else { prior }),
        );
        let played = localise(&arguments, &model, &recording, record.is_none(), &title)?;
        record = Some(together(record, played, name, title));
    }
    if let Some(record) = &record {
        write_report(folder, "Simulated corridor", record)?;
        let words = format!(
            "{} runs along an 89 m corridor, {} snapshots of 24 sonars; every fourth run\nis kept for the trials.\n\n{}",
            recording.runs().len(),
            recording.len(),
            tables::table(record).text()
        );
        let json = || localise::json(record, started.elapsed().as_secs_f64());
        print(&if arguments.json {
            format!("{}\n", json()?)
        } else {
            words
        })?;
    }
    warn(&format!(
        "dataset, models, tables and pictures are in {} ({:.0} s in all)",
        folder.display(),
        started.elapsed().as_secs_f64()
    ));
    Ok(Outcome::Done)
}

/// Steps of each of the demo's two trainings.
const STEPS: usize = 2500;

fn learn(arguments: &Arguments, uncertainty: Uncertainty, recording: &Recording) -> Result<Model> {
    let mut recipe = Recipe {
        seed: arguments.seed,
        uncertainty,
        ..Recipe::default()
    };
    recipe.split.test_fold = Some(3);
    // Fewer steps than the recipe has, so that the demo takes a minute: the rest would add the last per cent of the figures.
    recipe.descent.steps = if arguments.toy { 40 } else { STEPS };
    let learned = train::learn(
        Training::new(&recipe, recording),
        &recipe,
        &format!("learning for {uncertainty}"),
        || false,
    )?;
    train::warn_notes(&learned);
    Ok(learned.model)
}

/// Plays the trials with a model's filters, and, with `baselines`, with these too: they are the same for every model.
fn localise(
    arguments: &Arguments,
    model: &Model,
    recording: &Recording,
    baselines: bool,
    title: &str,
) -> Result<Record> {
    let mut parts = Parts::new(model, recording, None)?;
    if !baselines {
        parts.source = None;
    }
    let mut config = LocaliseConfig {
        seed: arguments.seed,
        ..LocaliseConfig::default()
    };
    if arguments.toy {
        config.trials = 8;
        config.resamples = 100;
    }
    write_config(&arguments.out, &config, model, recording)?;
    let mut progress = Progress::new("localising", parts.methods(model));
    let mut played = 0;
    let record = localisation::localise(model, &parts, &config, &mut |who| {
        progress.at(played, if played == 0 { title } else { who });
        played += 1;
    })?;
    progress.done();
    Ok(record)
}

/// The learned filters of both models, then the baselines: all have played the same trials.
fn together(
    first: Option<Record>,
    mut second: Record,
    name: &'static str,
    title: String,
) -> Record {
    second.results.retain(|s| s.name != "learned_bits"); // one line a model
    second.results[0].name = name;
    second.results[0].title = title;
    match first {
        None => second,
        Some(mut all) => {
            all.results.insert(1, second.results.swap_remove(0));
            all
        }
    }
}
