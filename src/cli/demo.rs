//! `ballmark demo`: the main job on a simulated corridor: learn, localise, compare, report.

use super::{
    Outcome, features,
    localise::{write_report, write_text},
    print,
    progress::Progress,
    train, warn,
};
use crate::{
    belief::Uncertainty,
    detector::Detector,
    error::Result,
    experiment::{
        contenders::Parts,
        global::{self, LocaliseConfig, Record},
    },
    learning::Recipe,
    model::Model,
    recording::{Recording, npz},
    report::localisation,
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

    let mut told = format!(
        "{} runs along an 89 m corridor, {} snapshots of 24 sonars; every fourth run is kept for the trials.\n",
        recording.runs().len(),
        recording.len()
    );
    for (prior, words) in [
        ("2m", "trained for ±2 m"),
        ("global", "trained for no idea where"),
    ] {
        let model = learn(&arguments, prior.parse()?, &recording)?;
        model.write(&folder.join(format!("corridor-{prior}.safetensors")))?;
        let answers = model.detector().probabilities(&recording)?;
        let plot = features::plot(&format!("Filters {words}"), &recording, &answers)?;
        write_text(
            &folder.join(format!("features-{prior}.csv")),
            &features::csv(&recording, &answers),
        )?;
        write_text(&folder.join(format!("features-{prior}.svg")), &plot)?;

        let record = localise(&arguments, &model, &recording)?;
        let report = folder.join(format!("localisation-{prior}"));
        storage::make_folder(&report)?;
        write_report(&report, &format!("Filters {words}"), &record)?;
        told += &format!("\nFilters {words}\n{}", localisation::table(&record).text());
    }
    print(&told)?;
    warn(&format!(
        "dataset, models, tables and pictures are in {} ({:.0} s in all)",
        folder.display(),
        started.elapsed().as_secs_f64()
    ));
    Ok(Outcome::Done)
}

fn learn(arguments: &Arguments, uncertainty: Uncertainty, recording: &Recording) -> Result<Model> {
    let mut recipe = Recipe {
        seed: arguments.seed,
        uncertainty,
        ..Recipe::default()
    };
    recipe.split.test_fold = Some(3);
    if arguments.toy {
        recipe.descent.steps = 40;
    }
    Ok(train::learn(
        &recipe,
        recording,
        None,
        false,
        &format!("learning for {uncertainty}"),
    )?
    .model)
}

fn localise(arguments: &Arguments, model: &Model, recording: &Recording) -> Result<Record> {
    let parts = Parts::new(model, recording, None)?;
    let mut config = LocaliseConfig {
        seed: arguments.seed,
        ..LocaliseConfig::default()
    };
    if arguments.toy {
        config.trials = 8;
        config.resamples = 100;
    }
    let mut progress = Progress::new("localising", 5);
    let mut played = 0;
    let record = global::localise(model, &parts, &config, &mut |who| {
        progress.at(played, who);
        played += 1;
    })?;
    progress.done();
    Ok(record)
}
