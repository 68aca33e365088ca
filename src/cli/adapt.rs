//! `ballmark adapt`: a model learns on from what its robot sensed, labelled by the robot itself.

use super::{
    Outcome,
    dataset::{read, read_all, warn_of_other_sensors},
    print,
    progress::Progress,
    warn,
};
use crate::{
    error::{Error, Result},
    experiment::{
        adaptation::{AdaptConfig, adapt},
        configuration::Experiment,
    },
    geometry::Pose,
    localiser::self_labels::KnownStart,
    model::{Memory, Model},
    recording::{Recording, degraded::Degraded, npz},
    report::adaptation::{AdaptationRow, table},
    storage,
};
use std::{
    path::{Path, PathBuf},
    str::FromStr,
    time::Instant,
};

/// Let a model learn on from new runs, whose places it finds by itself.
///
/// The robot localises in each dataset from odometry and sensors alone and labels what it sensed with the places that the whole run
/// tells. Labels that pass a gate extend the map, which forgets what was seen before where the robot came again, and the
/// filters take a few steps of training. The datasets' own poses, where they are any good, serve to judge the labels and for nothing
/// else: the same model comes out whatever they say. A model that keeps no label is written as it was. The runs must go through places that
/// are mapped: beyond the map, among rooms that look alike, labels are wrong and may pass the gate.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark adapt models/corridor-2m.safetensors datasets/corridor-small.npz \\
    --steps 0 -o adapted.safetensors")]
pub struct Arguments {
    /// The model, as `ballmark train` or this command writes it.
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Datasets of new runs, in the order that they were driven; each is labelled with what was learned from those before.
    #[arg(value_name = "NEW.npz", required = true)]
    datasets: Vec<PathBuf>,
    /// Where the adapted model goes: a name ending in .safetensors or .npz.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// What the model's map is made of: the dataset that it was trained on (several in the order of the training), or where it was
    /// adapted before, what --memory wrote then. Needed for steps of training, and where the map is drawn by range scans.
    #[arg(long, value_name = "T.npz", num_args = 1..)]
    trained_on: Vec<PathBuf>,
    /// Write what the map is made of now, under the labels that were kept: --trained-on of the next time.
    #[arg(long, value_name = "MEM.npz")]
    memory: Option<PathBuf>,
    /// Configuration; its section [adapt] holds for all that no flag below says otherwise, [degraded] for the sensor that the
    /// datasets are seen by: the same as in training.
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// Most steps of training on old and new snapshots for each dataset; 0: the map alone.
    #[arg(long, value_name = "N")]
    steps: Option<usize>,
    /// After so many newer runs through its place half of what was seen there is forgotten; `inf`: nothing is.
    #[arg(long, value_name = "RUNS")]
    half_life: Option<f64>,
    /// Labels are kept whose lost score is at most this, 0 to 1; 1 keeps all.
    #[arg(long, value_name = "SCORE")]
    gate: Option<f64>,
    /// Where the first run begins, in the frame of the map: x and y in metres, heading in radians; along a route its coordinate. Not
    /// said: anywhere, as do all other runs.
    #[arg(long, value_name = "X,Y,RAD", allow_hyphen_values = true)]
    start: Option<Start>,
    /// The one seed of the run.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// One JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// How well a start is known that is given: standard deviations in metres and radians.
const START_SPREAD: (f64, f64) = (0.3, 0.1);

/// A pose on the command line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Start(Pose);

impl FromStr for Start {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let numbers = text.split(',').map(|number| number.trim().parse::<f64>());
        match numbers
            .collect::<std::result::Result<Vec<_>, _>>()
            .as_deref()
        {
            Ok(&[x_m, y_m, heading_rad]) => Ok(Self(Pose::new(x_m, y_m, heading_rad))),
            Ok(&[route_m]) => Ok(Self(Pose::new(route_m, 0.0, 0.0))),
            _ => Err(Error::usage(format!(
                "{text:?}: expected x,y,heading in metres and radians, or a coordinate along a route"
            ))),
        }
    }
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let experiment = Experiment::read(arguments.config.as_deref(), None)?;
    let (mut config, degraded) = (experiment.adapt, experiment.degraded);
    let update = &mut config.update;
    update.steps = arguments.steps.unwrap_or(update.steps);
    update.half_life = arguments.half_life.unwrap_or(update.half_life);
    update.seed = arguments.seed.unwrap_or(update.seed);
    config.labels.gate = arguments.gate.unwrap_or(config.labels.gate);
    config.check()?;
    Model::check_name(&arguments.output)?;
    if let Some(memory) = &arguments.memory {
        storage::check_target(memory)?;
    }
    let model = Model::read(&arguments.model)?;
    let memory = match arguments.trained_on.as_slice() {
        [] => None,
        files => {
            let recording = read_all(files, &degraded)?;
            let memory = Memory::of(&model, &recording);
            Some(memory.map_err(|e| e.in_file(&files[0]))?)
        }
    };
    check_memory(&model, memory.as_ref(), &config, arguments.memory.is_some())?;
    let started = Instant::now();
    let adapted = adapted(&arguments, &config, &degraded, model, memory)?;
    adapted.model.write(&arguments.output)?;
    if let (Some(file), Some(memory)) = (&arguments.memory, &adapted.memory) {
        npz::write(file, memory.recording())?;
    }
    show(
        &arguments,
        &config,
        &adapted,
        started.elapsed().as_secs_f64(),
    )?;
    Ok(Outcome::Done)
}

/// What can't be done without the snapshots that the model learned from.
fn check_memory(
    model: &Model,
    memory: Option<&Memory>,
    config: &AdaptConfig,
    is_written: bool,
) -> Result<()> {
    let needs_it = match () {
        () if memory.is_some() => return Ok(()),
        () if config.update.steps > 0 => "steps of training go through old snapshots as well",
        () if model.occupancy.is_some() => {
            "this model's map is drawn by the scans that it learned from"
        }
        () if is_written => "--memory writes old snapshots as well",
        () => return Ok(()),
    };
    Err(Error::usage(format!(
        "{needs_it}, and a model does not hold them: expected --trained-on with the dataset that it was trained on, or with the \
         memory of its last adaptation{}",
        if model.occupancy.is_none() && config.update.steps > 0 {
            "; or --steps 0, to update the map alone"
        } else {
            ""
        }
    )))
}

/// What came of all datasets.
struct Outcomes {
    model: Model,
    memory: Option<Memory>,
    rows: Vec<AdaptationRow>,
}

fn adapted(
    arguments: &Arguments,
    config: &AdaptConfig,
    degraded: &Degraded,
    mut model: Model,
    mut memory: Option<Memory>,
) -> Result<Outcomes> {
    let mut rows = Vec::new();
    let mut start = arguments.start.map(|Start(pose)| KnownStart {
        pose,
        spread_m: START_SPREAD.0,
        spread_rad: START_SPREAD.1,
    });
    for dataset in &arguments.datasets {
        let recording = read(dataset, degraded)?;
        warn_of_other_sensors(&[&model], &recording);
        warn_if_known(&model, &recording, dataset);
        let name = dataset.display().to_string();
        let mut progress = Progress::new(&format!("learning from {name}"), config.update.steps);
        let came = adapt(
            &model,
            memory.as_ref(),
            &recording,
            config,
            start.take(),
            &mut |at| progress.at(at.step, ""),
        );
        progress.done();
        let came = came.map_err(|e| if e.is_usage() { e } else { e.in_file(dataset) })?;
        let is_updated = came.labels.kept > 0;
        if !is_updated {
            warn(&format!(
                "warning: {name}: no label passes the gate of {}: nothing is learned from it",
                config.labels.gate
            ));
        }
        (model, memory) = (came.model, came.memory);
        let record = model.header.updates.last().filter(|_| is_updated);
        rows.push(AdaptationRow {
            dataset: name,
            labels: came.labels,
            update: record.map(|record| [record.added, record.forgotten, record.steps]),
        });
    }
    Ok(Outcomes {
        model,
        memory,
        rows,
    })
}

/// Says where a dataset is one that the model has taken in before.
fn warn_if_known(model: &Model, recording: &Recording, dataset: &Path) {
    let own = recording.columns().dataset_sha256.as_ref();
    let mut updates = model.header.updates.iter();
    if own.is_some() && updates.any(|update| update.dataset_sha256.as_ref() == own) {
        warn(&format!(
            "note: {}: the model was adapted to this dataset before: it counts twice",
            dataset.display()
        ));
    }
}

fn show(
    arguments: &Arguments,
    config: &AdaptConfig,
    result: &Outcomes,
    seconds: f64,
) -> Result<()> {
    let output = arguments.output.display().to_string();
    if arguments.json {
        let of_row = |row: &AdaptationRow| {
            serde_json::json!({
                "dataset": row.dataset,
                "labels": row.labels,
                "added": row.update.map_or(0, |counts| counts[0]),
                "forgotten": row.update.map_or(0, |counts| counts[1]),
                "steps": row.update.map_or(0, |counts| counts[2]),
            })
        };
        let value = serde_json::json!({
            "model": output,
            "places": result.model.pose.len(),
            "datasets": result.rows.iter().map(of_row).collect::<Vec<_>>(),
            "updates": result.model.header.updates,
            "adapt": config,
            "timing": { "seconds": seconds },
        });
        return print(&format!("{value}\n"));
    }
    let mut table = table(&result.rows);
    table.caption(format!(
        "half-life {} runs, gate {}, seed {}, {seconds:.1} s",
        config.update.half_life, config.labels.gate, config.update.seed
    ));
    table.caption(format!(
        "model: {output}, {} places",
        result.model.pose.len()
    ));
    print(&table.text())
}
