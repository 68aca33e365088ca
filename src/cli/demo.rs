//! `ballmark demo`: the main job on a simulated corridor: learn, localise, compare, report.

use super::{
    Outcome, features,
    files::{write_for_readers, write_json, write_text},
    localise::{self, with_bar, write_config, write_report},
    page::{PAGE, call, write_page},
    picture::write_picture,
    print, train, warn,
};
use crate::{
    belief::Uncertainty,
    detector::Detector,
    error::Result,
    experiment::{
        line_up::{features_and_map, is_as_bits},
        localisation::{self, LocaliseConfig, Record},
        methods::MethodContext,
        parts::Parts,
    },
    learning::Recipe,
    model::{Model, Training},
    recording::{Recording, npz},
    report::{Page, Part, localisation as tables},
    seed::Seed,
    storage,
    world::corridor::{CorridorConfig, thrun1998},
};
use std::{path::PathBuf, time::Instant};

/// Learn landmarks in a simulated corridor, localise with them, compare and report. About a minute.
///
/// A robot with 24 sonars drives several times along the 89 m corridor of Thrun (1998): doors open and shut, bins move,
/// odometry drifts. Four filters are learned for a robot that knows its place to ±2 m, four for one that knows nothing;
/// then both find out where they are on runs that they never saw, beside baselines that learn nothing; and features and map
/// once more with people in the way.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark demo --toy --out demo-report")]
pub struct Arguments {
    /// Folder for a page to look at (index.html), the dataset, the models, the tables (CSV) and the pictures (SVG, PNG).
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

/// Share of the beams that people are in the way of in the trials that are played again.
const PEOPLE: f64 = 0.3;

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

    let (mut models, mut feature_parts) = (Vec::new(), Vec::new());
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
            &features::csv(
                &recording,
                &features::numbered("", answers.ncols()),
                &answers,
            ),
        )?;
        for (ending, plot) in plots {
            write_picture(&folder.join(format!("features-{prior}{ending}")), &plot)?;
            feature_parts.push(Part::picture(
                format!("Output of each filter trained {words} along the last run."),
                format!(
                    "Probability that each of the filters trained {words} answers, along the route"
                ),
                plot,
            ));
        }
        models.push(model);
    }
    let ([record, crowded], config) = localise(&arguments, &models, &recording)?;
    write_report(folder, "Simulated corridor", &record)?;
    let among_people = tables::figures(&crowded).csv();
    let name = "localisation_among_people";
    write_text(&folder.join(format!("{name}.csv")), &among_people)?;
    write_for_readers(folder, name, &tables::brief_table(&crowded))?;
    write_json(
        &folder.join(format!("{name}.json")),
        &tables::json(&crowded, None)?,
    )?;
    let mut parts = vec![Part::Heading("Localisation on unseen runs".into())];
    parts.extend(tables::page_parts("Simulated corridor", &record)?);
    parts.push(Part::Heading(
        "The same trials with people in the way".into(),
    ));
    parts.push(Part::table(
        "With people in the way",
        tables::brief_table(&crowded),
    ));
    parts.push(Part::Heading("What the filters answer".into()));
    parts.extend(feature_parts);
    let content = Page {
        title: "Learned landmarks in a simulated corridor".into(),
        summary: tables::page_summary(&record),
        command: call(),
        parts,
        config,
    };
    write_page(folder, &content)?;
    let words = format!(
        "{} runs along an 89 m corridor, {} snapshots of 24 sonars; every fourth run\nis kept for the trials.\n\n{}\n\
         The same trials with people in the way.\n\n{}",
        recording.runs().len(),
        recording.len(),
        tables::table(&record).text(),
        tables::brief_table(&crowded).text()
    );
    let json = || -> Result<serde_json::Value> {
        let seconds = started.elapsed().as_secs_f64();
        let mut all = tables::json(&record, Some(seconds))?;
        all["among_people"] = tables::json(&crowded, Some(seconds))?;
        Ok(all)
    };
    print(&if arguments.json {
        format!("{}\n", json()?)
    } else {
        words
    })?;
    warn(&format!(
        "dataset, models, tables and pictures are in {} ({:.0} s in all); to look at: {}",
        folder.display(),
        started.elapsed().as_secs_f64(),
        folder.join(PAGE).display()
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

/// Resolved configurations, a name and a text each.
type Resolved = Vec<(String, String)>;

/// Plays the trials with both models' filters and the baselines, one line a model; and with the filters and a map once more
/// among people. Beside the records the resolved configurations, each with its name.
fn localise(
    arguments: &Arguments,
    models: &[Model],
    recording: &Recording,
) -> Result<([Record; 2], Resolved)> {
    let mut config = LocaliseConfig {
        seed: Some(arguments.seed),
        people: Some(0.0),
        ..LocaliseConfig::default()
    };
    if arguments.toy {
        config.trials = 8;
        config.resamples = 100;
    }
    let mut resolved = Vec::new();
    for model in models {
        resolved.push(write_config(&arguments.out, &config, model, recording)?);
    }
    let models: Vec<&Model> = models.iter().collect();
    let parts = Parts::new(models[0], recording, None)?;
    let mut record = localise::play(MethodContext::new(&models, &parts, &config)?, true)?;
    record.retain(|name| !is_as_bits(name));

    config.people = Some(PEOPLE);
    let crowded = recording.with_people(&parts.unseen, PEOPLE, config.seed())?;
    let parts = parts.with_run(&crowded);
    let context = MethodContext::new(&models, &parts, &config)?;
    let mut methods = features_and_map(&context)?;
    methods.retain(|method| !is_as_bits(&method.name));
    for method in &mut methods {
        // Tuned where nobody stood, so as it was.
        let mut before = record
            .results
            .iter()
            .filter(|result| result.name == method.name);
        method.evidence_scale = before.next().and_then(|result| result.evidence_scale);
    }
    let among_people = with_bar(|progress| localisation::play(&context, methods, progress))?;
    Ok(([record, among_people], resolved))
}
