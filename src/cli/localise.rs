//! `ballmark localise`: global localisation and position tracking on runs that training never saw.

use super::{
    Outcome,
    dataset::{check_models, read, read_all, warn_of_other_sensors},
    files::{write_for_readers, write_json, write_text},
    page::{call, write_page},
    picture::write_picture,
    print,
    progress::Progress,
    rerun, warn,
};
use crate::{
    belief::Evidence,
    error::{Error, Result},
    experiment::{
        configuration::Experiment,
        localisation::{self, LocaliseConfig, Record},
        methods::MethodContext,
        parts::{Parts, as_learned, odometry_is_the_truth},
    },
    mapping::RosMap,
    model::{Model, ModelBank},
    recording::Recording,
    report::{Page, localisation as tables},
    storage,
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Localise on runs that training never saw, beside baselines that learn nothing.
///
/// Given the dataset that the model was trained on, the trials run on its test part (`ballmark train --test-fold`), or
/// on the validation part where there is none. Given another dataset, they run on all of it; the baselines then need
/// --trained-on. Several models, trained on the same dataset with the same split, stand in one table. A bank of filters (`ballmark
/// train --uncertainty bank`) uses at every step the set that promises most; beside it stand all its sets at once, and each alone.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark localise models/corridor-2m.safetensors \\
    datasets/corridor-small.npz --trials 20")]
pub struct Arguments {
    /// Models, as `ballmark train` writes them, one or more, and at the end the dataset to localise in.
    #[arg(value_names = ["M.safetensors", "D.npz"], num_args = 2.., required = true)]
    files: Vec<PathBuf>,
    /// The dataset that the model was trained on, where that is another one (several in the order of the training): the
    /// baselines need it.
    #[arg(long, value_name = "T.npz", num_args = 1..)]
    trained_on: Vec<PathBuf>,
    /// Folder for a page to look at (index.html), the record (JSON), the tables (text, CSV, Markdown, LaTeX), the pictures (SVG, PNG)
    /// and the resolved configuration.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// File for a recording of the page's trials for the viewer Rerun (rerun.io): map, scans, beliefs, answers, features and errors, step by
    /// step. Only in builds with the feature `rerun`.
    #[arg(long, value_name = "FILE.rrd")]
    rerun: Option<PathBuf>,
    /// Configuration; its section [localise] holds for all that no flag below says otherwise, [degraded] for the sensor that
    /// the datasets are seen by: the same as in training.
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// A ROS map (its YAML) in the frame of the dataset's poses, for those who localise in a map; otherwise the scans that the
    /// model learned from draw it.
    #[arg(long, value_name = "MAP.yaml")]
    map: Option<PathBuf>,
    /// Share of the range beams of every unseen snapshot that people are in the way of (0 to 1): stretches of 3° to 20° end
    /// before what they met.
    #[arg(long, value_name = "SHARE")]
    people: Option<f64>,
    /// Carry every filter away without a word, METRES after its start anywhere, and see how far it drives until it is found again.
    #[arg(long, value_name = "METRES")]
    kidnap: Option<f64>,
    /// Number of trials.
    #[arg(long, value_name = "N")]
    trials: Option<usize>,
    /// The one seed of the run.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// How answers become likelihoods: sampled, jeffrey, likelihood or mean-field.
    #[arg(long, value_name = "NAME")]
    evidence: Option<Evidence>,
    /// One JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    if let Some(file) = &arguments.rerun {
        rerun::check(file)?; // a wrong name fails now, not after the trials
    }
    let experiment = Experiment::read(arguments.config.as_deref(), None)?;
    let (mut config, degraded) = (experiment.localise, experiment.degraded);
    config.trials = arguments.trials.unwrap_or(config.trials);
    config.seed = Some(arguments.seed.unwrap_or(config.seed().0));
    config.evidence = arguments.evidence.unwrap_or(config.evidence);
    config.map = arguments.map.unwrap_or(config.map);
    config.people = Some(arguments.people.unwrap_or(config.people()));
    config.kidnap_m = arguments.kidnap.or(config.kidnap_m);
    config.check()?;
    if config.more_particles > 0 {
        warn("note: more_particles has no effect here: 5,000 particles stand beside 40,000 always");
    }
    if !config.map.as_os_str().is_empty() {
        RosMap::read(&config.map)?; // one that is none fails now
    }
    if let Some(folder) = &arguments.out {
        storage::make_folder(folder)?; // a wrong name fails now, not after the trials
    }
    let Some((dataset, models)) = arguments.files.split_last() else {
        return Err(Error::usage("no files; expected M.safetensors D.npz")); // clap sees to it
    };
    let files = models.iter().map(|file| ModelBank::read(file));
    let banks = files.collect::<Result<Vec<ModelBank>>>()?;
    let bank = match &banks[..] {
        [bank] if bank.sets().len() > 1 => Some(bank),
        banks if banks.iter().all(|bank| bank.sets().len() == 1) => None,
        _ => {
            return Err(Error::usage(
                "a bank of filters beside other models: expected the bank alone, or models of one set each",
            ));
        }
    };
    let models: Vec<&Model> = banks.iter().flat_map(ModelBank::sets).collect();
    let model = models[0];
    // What one of them works from, the others may leave.
    let history_m = Model::history_of_all(&models);
    let recording = as_learned(&models, read(dataset, &degraded)?);
    let recording = recording.map_err(|e| e.in_file(dataset))?;
    check_models(&arguments.files, &banks, &recording)?;
    let trained_on = match arguments.trained_on.as_slice() {
        [] => None,
        datasets => Some(as_learned(&models, read_all(datasets, &degraded)?)?),
    };
    let in_dataset = |e: Error| {
        if e.is_usage() { e } else { e.in_file(dataset) }
    };
    let parts = Parts::new(model, &recording, trained_on).map_err(in_dataset)?;
    if parts.source.is_none() {
        warn(
            "note: no baselines: they learn from the dataset that the model was trained on; name it with --trained-on",
        );
    }
    warn_of_other_sensors(&models, &recording);
    if odometry_is_the_truth(&recording) {
        warn(
            "note: the dataset's odometry repeats its poses, so whatever odometry carries is flattered",
        );
    }
    let disturbed = parts.disturbed(config.people(), &degraded, config.seed())?;
    let in_trouble = disturbed.as_ref().map(|run| parts.with_run(run));
    let parts = in_trouble.as_ref().unwrap_or(&parts);
    let started = Instant::now();
    let context = match bank {
        Some(bank) => MethodContext::of_bank(&models, bank.run(), parts, &config),
        None => MethodContext::new(&models, parts, &config),
    };
    let keeps_beliefs = arguments.out.is_some() || arguments.rerun.is_some();
    let record = context.and_then(|context| play(context, keeps_beliefs));
    let record = record.map_err(in_dataset)?;
    let seconds = started.elapsed().as_secs_f64();
    let title = "Localisation on unseen runs";
    if let Some(file) = &arguments.rerun {
        rerun::write(file, title, &record, parts.run, model)?;
    }
    if let Some(folder) = &arguments.out {
        write_report(folder, title, &record)?;
        let mut resolved = Vec::new();
        for model in models {
            resolved.push(write_config(folder, &config, model, &recording)?);
        }
        let content = Page {
            title: title.into(),
            summary: tables::page_summary(&record),
            command: call(),
            parts: tables::page_parts(title, &record)?,
            config: resolved,
        };
        write_page(folder, &content)?;
    }
    if arguments.json {
        print(&format!("{}\n", tables::json(&record, Some(seconds))?))?;
    } else {
        let mut table = tables::table(&record);
        if let Some(degraded) = &record.degraded {
            table.caption(format!("sensor degraded: {degraded}"));
        }
        if let [.., farthest_m] = &history_m[..] {
            table.caption(format!(
                "inputs of all but models trained without: readings of the last {farthest_m} m as well ({history_m:?} m back), \
                 those before a trial's start included"
            ));
        }
        table.caption(format!(
            "belief over {} cells, {} evidence, seed {}, {seconds:.1} s",
            record.cells,
            config.evidence,
            config.seed().0
        ));
        print(&table.text())?;
        for more in [
            tables::correction(&record),
            tables::confidence(&record),
            tables::kidnapping(&record),
        ] {
            if !more.is_empty() {
                print(&format!("\n{}", more.text()))?;
            }
        }
    }
    Ok(Outcome::Done)
}

/// Plays the trials of the usual line-up, with a bar; beliefs are kept for those who want to watch them.
pub(super) fn play(mut context: MethodContext, keeps_beliefs: bool) -> Result<Record> {
    context.keeps_beliefs = keeps_beliefs;
    with_bar(|progress| localisation::play_line_up(&context, progress))
}

/// Plays trials, with a bar.
pub(super) fn with_bar(
    play: impl FnOnce(&mut dyn FnMut(localisation::Progress)) -> Result<Record>,
) -> Result<Record> {
    // Maps are made, and their evidence tuned, before the first method plays.
    let mut ready = Progress::new("getting ready", 1);
    ready.at(0, "maps, and how much evidence counts");
    let mut ready = Some(ready);
    let mut bar: Option<Progress> = None;
    let record = play(&mut |at| {
        if let Some(ready) = ready.take() {
            ready.done();
        }
        let bar = bar.get_or_insert_with(|| Progress::new("localising", at.all));
        bar.at(at.done, at.next);
    })?;
    if let Some(bar) = bar {
        bar.done();
    }
    Ok(record)
}

/// Record, tables, curves, pictures and kept beliefs, in a folder that exists.
pub(super) fn write_report(folder: &Path, title: &str, record: &Record) -> Result<()> {
    write_json(
        &folder.join("localisation.json"),
        &tables::json(record, None)?,
    )?;
    if let Some(beliefs) = &record.beliefs {
        write_json(&folder.join("player.json"), beliefs)?;
    }
    write_text(
        &folder.join("localisation.csv"),
        &tables::figures(record).csv(),
    )?;
    write_text(
        &folder.join("error_by_distance.csv"),
        &tables::curves(record).csv(),
    )?;
    write_text(
        &folder.join("risk_coverage.csv"),
        &tables::risk_coverage(record).csv(),
    )?;
    write_text(&folder.join("paired.csv"), &tables::paired(record).csv())?;
    let confidence = tables::confidence_figures(record);
    write_text(&folder.join("confidence.csv"), &confidence.csv())?;
    let correction = tables::correction_figures(record);
    write_text(&folder.join("correction.csv"), &correction.csv())?;
    for (name, table) in [
        ("localisation", tables::table(record)),
        ("intervals", tables::intervals(record)),
        ("confidence", tables::confidence(record)),
        ("correction", tables::correction(record)),
        ("kidnapping", tables::kidnapping(record)),
    ] {
        if !table.is_empty() {
            write_for_readers(folder, name, &table)?;
        }
    }
    let kidnapping = tables::kidnapping_figures(record);
    if !kidnapping.is_empty() {
        write_text(&folder.join("kidnapping.csv"), &kidnapping.csv())?;
    }
    let anywhere = tables::error_plot(&format!("{title}: start anywhere"), record, false)?;
    write_picture(&folder.join("error_by_distance"), &anywhere)?;
    let found = tables::found_plot(&format!("{title}: start anywhere"), record)?;
    write_picture(&folder.join("found_by_distance"), &found)?;
    let risk = tables::risk_coverage_plot(&format!("{title}: start anywhere"), record)?;
    write_picture(&folder.join("risk_coverage"), &risk)?;
    let known = tables::error_plot(&format!("{title}: start known"), record, true)?;
    write_picture(&folder.join("tracking_error"), &known)
}

/// All that decided the result: configuration, motion model, model and data, and the version that computed it. Written to a file,
/// whose name is returned with its text.
pub(super) fn write_config(
    folder: &Path,
    config: &LocaliseConfig,
    model: &Model,
    dataset: &Recording,
) -> Result<(String, String)> {
    let resolved = serde_json::json!({
        "crate_version": env!("CARGO_PKG_VERSION"),
        "localise": config,
        "motion": config.motion.as_ref().unwrap_or(&model.header.motion),
        "dataset_sha256": dataset.columns().dataset_sha256,
        "degraded": dataset.columns().degraded,
        "model": model.header,
    });
    let name = format!("config-{}.json", model.header.prior);
    let text = format!("{resolved:#}\n");
    write_text(&folder.join(&name), &text)?;
    Ok((name, text))
}
