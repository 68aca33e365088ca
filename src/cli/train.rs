//! `ballmark train`: filters for a prior uncertainty, learned from a dataset.

use super::{Outcome, config::Experiment, print, progress::Progress, warn};
use crate::{
    belief::Uncertainty,
    detector::device::{Device, DeviceChoice},
    error::{Error, Result},
    learning::{
        Recipe, error_reduction::ErrorReduction, recipe::Named, trainer, training_set::TrainingSet,
    },
    model::Model,
    recording::{Recording, npz},
    report::{Cell, Table},
};
use std::{
    path::{Path, PathBuf},
    time::Instant,
};

/// Learn filters for a prior uncertainty from a dataset.
///
/// Part of the dataset is kept back to stop the training (the validation part), and with --test-fold a part that
/// training never sees, for `ballmark localise`. Neither cuts a run or a stretch of path.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark train datasets/corridor-small.npz -o corridor.safetensors \\
    --uncertainty 2m --features 2 --steps 100")]
pub struct Arguments {
    /// Dataset to learn from, as `ballmark import` writes it; several of one building, in one frame of reference and of the
    /// same sensors, count as one.
    #[arg(value_name = "D.npz", required = true)]
    datasets: Vec<PathBuf>,
    /// Where the model goes: a name ending in .safetensors or .npz.
    #[arg(short, long, value_name = "M.safetensors")]
    output: PathBuf,
    /// Configuration; its section [train] holds for all that no flag below says otherwise.
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// Prior uncertainty to train for: `2m` (±2 m, and in the plane ±0.5 rad), `2m,0.3rad`, `2m,any` or `global`.
    #[arg(long, value_name = "U")]
    uncertainty: Option<Uncertainty>,
    /// What holds where neither configuration nor flags say otherwise: `default`, which holds up best on runs never seen, or
    /// `thrun1998`, the paper's own networks and descent (10,000 steps of all snapshots, unless --steps says otherwise).
    #[arg(long, value_name = "NAME")]
    recipe: Option<Named>,
    /// Number of filters: to 256, or to 12 where the objective is the exact one.
    #[arg(long, value_name = "N")]
    features: Option<usize>,
    /// The one seed of the run.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Most steps of descent.
    #[arg(long, value_name = "N")]
    steps: Option<usize>,
    /// Keep this one of the folds for testing (counted from 0; four folds unless the configuration says otherwise).
    #[arg(long, value_name = "K")]
    test_fold: Option<usize>,
    /// Where the networks compute: `cpu`, or where it is built in `cuda`, `wgpu`, `metal` or `rocm`.
    #[arg(long, value_name = "DEVICE", default_value_t)]
    device: DeviceChoice,
    /// Go on from the checkpoint of the same training, where there is one.
    #[arg(long)]
    resume: bool,
    /// One JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let mut recipe = Experiment::read(arguments.config.as_deref(), arguments.recipe)?.train;
    recipe.uncertainty = arguments.uncertainty.unwrap_or(recipe.uncertainty);
    recipe.features = arguments.features.unwrap_or(recipe.features);
    recipe.seed = arguments.seed.unwrap_or(recipe.seed);
    recipe.descent.steps = arguments.steps.unwrap_or(recipe.descent.steps);
    recipe.split.test_fold = arguments.test_fold.or(recipe.split.test_fold);
    recipe.check()?;
    Model::check_name(&arguments.output)?;
    let device = arguments.device.open()?;
    let mut recording = read_all(&arguments.datasets)?;
    if !recording.goes_one_way() {
        warn(
            "note: the array `route` is driven both ways or in laps: places are told apart by their poses in the plane instead",
        );
        recording = recording.in_the_plane();
    }
    let started = Instant::now();
    let learned = learn(
        &recipe,
        &recording,
        &device,
        Some(&arguments.output),
        arguments.resume,
        "learning",
    )
    .map_err(|e| {
        // A checkpoint at fault is named already; what is left is the dataset.
        if e.is_io() || e.is_usage() || e.is_input() {
            e
        } else {
            e.in_file(&arguments.datasets[0]) // one at least: clap sees to it
        }
    })?;
    let seconds = started.elapsed().as_secs_f64();
    learned.model.write(&arguments.output)?;
    // The model is safe; a stale checkpoint is only in the way.
    let checkpoint = checkpoint_of(&arguments.output);
    let _ = trainer::remove_checkpoints(checkpoint.as_deref(), recipe.descent.restarts);
    if learned.model.header.scores.validation.is_none() {
        warn(
            "note: no validation snapshot lies at a place seen in training; trained for all steps instead",
        );
    }
    print(&if arguments.json {
        learned.json(seconds)
    } else {
        learned.table(&arguments.output, seconds).text()
    })?;
    Ok(Outcome::Done)
}

/// Some datasets as one recording.
pub(super) fn read_all(datasets: &[PathBuf]) -> Result<Recording> {
    let read = |path: &PathBuf| npz::read(path);
    let recordings = datasets.iter().map(read).collect::<Result<Vec<_>>>()?;
    Recording::joined(recordings).map_err(|e| match datasets.first() {
        Some(path) => e.in_file(path),
        None => e,
    })
}

/// A model and how its training went.
pub(super) struct Learned {
    pub(super) model: Model,
    steps: usize,
    evaluations: usize,
    stopped_by: trainer::StoppedBy,
}

/// Learns a recipe from a recording; with `output`, a checkpoint is kept beside it.
pub(super) fn learn(
    recipe: &Recipe,
    recording: &Recording,
    device: &Device,
    output: Option<&Path>,
    resume: bool,
    what: &str,
) -> Result<Learned> {
    let split = recipe.split.split(recording)?;
    let data = recording
        .columns()
        .dataset_sha256
        .clone()
        .unwrap_or_default();
    let words = serde_json::to_string(recipe).map_err(|e| Error::work(format!("recipe: {e}")))?;
    let identity = format!("{} {data} {words}", env!("CARGO_PKG_VERSION"));
    let checkpoint = output.and_then(checkpoint_of);
    let training_set = TrainingSet::prepare(recipe, recording, &split)?;
    let mut progress = Progress::new(what, recipe.descent.steps * recipe.descent.restarts);
    let trained = trainer::train_on(
        device,
        recipe,
        &training_set,
        checkpoint.as_deref(),
        resume,
        &identity,
        &mut |p| {
            let validation = p.validation.map_or(String::new(), |v| {
                format!(", best on validation {:.1} %", 100.0 * v)
            });
            progress.at(
                p.step,
                &format!("error reduction {:.1} %{validation}", 100.0 * p.training),
            );
        },
    )?;
    progress.done();
    let (steps, stopped_by) = (trained.steps, trained.stopped_by);
    let evaluations = trained.evaluations;
    Ok(Learned {
        model: Model::new(recipe, recording, &training_set, trained),
        steps,
        evaluations,
        stopped_by,
    })
}

fn checkpoint_of(output: &Path) -> Option<PathBuf> {
    let mut name = output.file_name()?.to_os_string();
    name.push(".checkpoint");
    Some(output.with_file_name(name))
}

impl Learned {
    fn json(&self, seconds: f64) -> String {
        let scores = &self.model.header.scores;
        let value = serde_json::json!({
            "train": scores.train,
            "validation": scores.validation,
            "steps": self.steps,
            "evaluations": self.evaluations,
            "stopped_by": self.stopped_by,
            "recipe": self.model.header.recipe,
            "timing": { "seconds": seconds },
        });
        format!("{value}\n")
    }

    fn table(&self, output: &Path, seconds: f64) -> Table {
        let scores = &self.model.header.scores;
        let mut table = Table::new([
            "part",
            "snapshots",
            "prior error (m)",
            "posterior error (m)",
            "error reduction (%)",
        ]);
        let mut row = |part: &str, score: Option<&ErrorReduction>| {
            let number =
                |get: fn(&ErrorReduction) -> f64, decimals| Cell::number(score.map(get), decimals);
            table.row([
                Cell::Text(part.into()),
                score.map_or(Cell::Missing, |s| Cell::Count(s.snapshots as u64)),
                number(|s| s.prior_error_m, 3),
                number(|s| s.posterior_error_m, 3),
                number(|s| 100.0 * s.error_reduction, 1),
            ]);
        };
        row("training", Some(&scores.train));
        row("validation", scores.validation.as_ref());
        let recipe = &self.model.header.recipe;
        let why = match self.stopped_by {
            trainer::StoppedBy::Validation => "no better on the validation part",
            trainer::StoppedBy::Steps => "all steps taken",
        };
        table.caption(format!(
            "{} filters for uncertainty {}, seed {}; {} steps ({why}), {seconds:.1} s",
            recipe.features, recipe.uncertainty, recipe.seed, self.steps
        ));
        table.caption("validation: unseen snapshots at places seen in training; the map from training snapshots only");
        table.caption(format!("model: {}", output.display()));
        table
    }
}
