//! `ballmark demo`: the main job on a simulated corridor: learn, localise, compare, report.

use super::{
    Outcome, features,
    localise::{self, write_config, write_report, write_text},
    print, train, warn,
};
use crate::{
    belief::Uncertainty,
    detector::Detector,
    error::Result,
    experiment::{
        localisation::{LocaliseConfig, Record},
        parts::Parts,
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

    let mut models = Vec::new();
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
        models.push(model);
    }
    let record = localise(&arguments, &models, &recording)?;
    write_report(folder, "Simulated corridor", &record)?;
    let words = format!(
        "{} runs along an 89 m corridor, {} snapshots of 24 sonars; every fourth run\nis kept for the trials.\n\n{}",
        recording.runs().len(),
        recording.len(),
        tables::table(&record).text()
    );
    let json = || localise::json(&record, started.elapsed().as_secs_f64());
    print(&if arguments.json {
        format!("{}\n", json()?)
    } else {
        words
    })?;
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
    let learned = train::learn(
        Training::new(&recipe, recording),
        &recipe,
        &format!("learning for {uncertainty}"),
        || false,
    )?;
    train::warn_notes(&learned);
    Ok(learned.model)
}

/// Plays the trials with both models' filters and the baselines, one line a model.
fn localise(arguments: &Arguments, models: &[Model], recording: &Recording) -> Result<Record> {
    let mut config = LocaliseConfig {
        seed: Some(arguments.seed),
        ..LocaliseConfig::default()
    };
    if arguments.toy {
        config.trials = 8;
        config.resamples = 100;
    }
    for model in models {
        write_config(&arguments.out, &config, model, recording)?;
    }
    let models: Vec<&Model> = models.iter().collect();
    let parts = Parts::new(models[0], recording, None)?;
    let mut record = localise::play(&models, &parts, &config)?;
    record
        .results
        .retain(|result| !result.name.starts_with("learned_bits"));
    Ok(record)
}
