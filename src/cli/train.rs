//! `ballmark train`: filters for a prior uncertainty, learned from a dataset.

mod bank;
mod scores;

use super::{Outcome, dataset::read_all, interrupt::Interrupt, print, progress::Progress, warn};
use crate::{
    belief::Uncertainty,
    detector::device::{Device, DeviceChoice},
    error::{Error, Result},
    experiment::{configuration::Experiment, robot_constants},
    learning::{
        Recipe,
        recipe::{BeginWith, NamedRecipe},
        trainer::Directive,
    },
    mapping::{OccupancyMap, RangeSensors, read_fitting},
    model::{Learned, Model, Resume, Training},
    recording::Recording,
};
use scores::{json, table};
use std::{
    path::{Path, PathBuf},
    str::FromStr,
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
    /// Configuration; its section [train] holds for all that no flag below says otherwise, [degraded] for the sensor that the
    /// datasets are seen by.
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// Prior uncertainty to train for: `2m` (±2 m, and in the plane ±0.5 rad), `2m,0.3rad`, `2m,any` or `global`; or `bank`: a set
    /// each for ±1, 2, 5, 10, 50 m and global in one file, of which the filter uses at every step the one that promises most.
    #[arg(long, value_name = "U")]
    uncertainty: Option<Wanted>,
    /// What holds where neither configuration nor flags say otherwise: `default`, which holds up best on runs never seen, or
    /// `thrun1998`, the paper's own networks and descent (10,000 steps of all snapshots, unless --steps says otherwise).
    #[arg(long, value_name = "NAME")]
    recipe: Option<NamedRecipe>,
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
    /// Begin with the networks of this model, pre-trained on other buildings (`ballmark pretrain`); with --steps 0 they are used as
    /// they are. `none`: with random ones. Not said: with those that come with the program, where the sensor fits (a laser scanner of
    /// 180°), else random ones.
    #[arg(long, value_name = "T.safetensors")]
    from: Option<PathBuf>,
    /// Render scans in this ROS map (its YAML), in the frame of the dataset's poses, instead of one that the training scans draw.
    #[arg(long, value_name = "MAP.yaml")]
    map: Option<PathBuf>,
    /// Where the networks compute: `cpu`, or where it is built in `cuda`, `wgpu`, `metal` or `rocm`.
    #[arg(long, value_name = "DEVICE", default_value_t)]
    device: DeviceChoice,
    /// Go on from the checkpoint of the same training, where there is one (Ctrl-C leaves one too). With other --steps, the
    /// training goes on to these.
    #[arg(long)]
    resume: bool,
    /// One JSON object instead of a table.
    #[arg(long)]
    json: bool,
}

/// What is to be trained for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Wanted {
    One(Uncertainty),
    Bank,
}

impl FromStr for Wanted {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text.trim() {
            "bank" => Ok(Wanted::Bank),
            other => other
                .parse()
                .map(Wanted::One)
                .map_err(|e: Error| e.followed_by("or `bank`")),
        }
    }
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let experiment = Experiment::read(arguments.config.as_deref(), arguments.recipe)?;
    let mut recipe = experiment.train;
    if let Some(Wanted::One(uncertainty)) = arguments.uncertainty {
        recipe.uncertainty = uncertainty;
    }
    recipe.features = arguments.features.unwrap_or(recipe.features);
    recipe.seed = arguments.seed.unwrap_or(recipe.seed);
    recipe.descent.steps = arguments.steps.unwrap_or(recipe.descent.steps);
    recipe.split.test_fold = arguments.test_fold.or(recipe.split.test_fold);
    if arguments.from.as_deref().is_some_and(is_none) {
        recipe.begin_with = BeginWith::Random;
    }
    recipe.check()?;
    Model::check_name(&arguments.output)?;
    let device = arguments.device.open()?;
    let mut recording = read_all(&arguments.datasets, &experiment.degraded)?;
    if !recording.goes_one_way() {
        warn(
            "note: the array `route` is driven both ways or in laps: places are distinguished by their poses in the plane instead",
        );
        recording = recording.in_the_plane();
    }
    let started = Instant::now();
    let checkpoint = checkpoint_of(&arguments.output);
    let resume = match arguments.resume {
        true => Resume::IfSame,
        false => Resume::Never,
    };
    let interrupt = Interrupt::watched();
    let map = match &arguments.map {
        None => None,
        Some(map) => {
            let training_part = recipe.split.split(&recording)?.train;
            let sensors = RangeSensors {
                channels: recipe.input.channels.clone(),
                ..RangeSensors::default()
            };
            Some(read_fitting(map, &recording, &training_part, &sensors)?)
        }
    };
    let from = arguments.from.as_ref().filter(|from| !is_none(from));
    let from = match from {
        None => None,
        Some(from) => {
            let name = from.file_name().unwrap_or_default().to_string_lossy();
            Some((name.into_owned(), Model::read(from)?))
        }
    };
    let begun = Begun {
        recording: &recording,
        device: &device,
        from: from.as_ref(),
        map: map.as_ref(),
    };
    let explained = |e: Error| {
        if e.is_cancelled() {
            e.followed_by("the same command with --resume goes on from there")
        } else if e.is_io() || e.is_usage() || e.is_input() {
            e // a checkpoint at fault is named already; what is left is the dataset
        } else {
            e.in_file(&arguments.datasets[0]) // one at least: clap sees to it
        }
    };
    if arguments.uncertainty == Some(Wanted::Bank) {
        let learn_set = |recipe: &Recipe, checkpoint: &Path| {
            let name = format!("learning {}", recipe.uncertainty);
            let training = begun.training(recipe).checkpoint(checkpoint, resume);
            learn(training, recipe, &name, || interrupt.is_set()).map_err(explained)
        };
        let sets = bank::learned(&recipe, &recording, &arguments.output, learn_set)?;
        return bank::show(
            &sets,
            &recording,
            &arguments,
            started.elapsed().as_secs_f64(),
        );
    }
    let training = begun.training(&recipe).checkpoint(&checkpoint, resume);
    if arguments.resume {
        if let Some(learned) = training.finished(&arguments.output)? {
            warn(&format!(
                "note: {} is the model of this very training, which has ended: nothing is learned anew",
                arguments.output.display()
            ));
            return show(&learned, &recording, &arguments, None);
        }
        if !checkpoint.exists() {
            warn(&format!(
                "note: no checkpoint {}: the training starts afresh",
                checkpoint.display()
            ));
        }
    }
    let learned = learn(training, &recipe, "learning", || interrupt.is_set()).map_err(explained)?;
    let seconds = started.elapsed().as_secs_f64();
    let mut learned = learned;
    tune_evidence(&mut learned, &recording);
    learned.model.write(&arguments.output)?;
    // The model is safe; a stale checkpoint is only in the way.
    let _ = Training::remove_checkpoints(&recipe, &checkpoint);
    show(&learned, &recording, &arguments, Some(seconds))
}

/// What every training of a call begins with.
struct Begun<'a> {
    recording: &'a Recording,
    device: &'a Device,
    /// Name and pre-trained model.
    from: Option<&'a (String, Model)>,
    map: Option<&'a OccupancyMap>,
}

impl Begun<'_> {
    fn training<'b>(&'b self, recipe: &'b Recipe) -> Training<'b> {
        let mut training = Training::new(recipe, self.recording).device(self.device);
        if let Some((name, from)) = self.from {
            training = training.from_pretrained(name, from);
        }
        if let Some(map) = self.map {
            training = training.in_map(map);
        }
        training
    }
}

/// Finds how much a model's evidence counts, and when its robot is lost.
fn tune_evidence(learned: &mut Learned, recording: &Recording) {
    // A model that learned well is worth keeping, whatever a grid over its places would need.
    if let Err(fault) = robot_constants::tune(&mut learned.model, recording) {
        warn(&format!("note: evidence not tuned: {fault}"));
    }
}

/// No pre-trained networks, as `--from` says it.
fn is_none(from: &Path) -> bool {
    from == Path::new("none")
}

/// Prints the notes and the result.
fn show(
    learned: &Learned,
    recording: &Recording,
    arguments: &Arguments,
    seconds: Option<f64>,
) -> Result<Outcome> {
    warn_notes(learned);
    let degraded = recording.columns().degraded.as_ref();
    print(&if arguments.json {
        json(learned, degraded, seconds.unwrap_or(0.0))
    } else {
        let mut table = table(learned, seconds);
        if let Some(degraded) = degraded {
            table.caption(format!("sensor degraded: {degraded}"));
        }
        table.caption(format!("model: {}", arguments.output.display()));
        table.text()
    })?;
    Ok(Outcome::Done)
}

/// What a user should know of a training besides its scores.
pub(super) fn warn_notes(learned: &Learned) {
    for note in &learned.report.notes {
        warn(&format!("note: {note}"));
    }
}

/// Runs a training with its progress shown under a name, until `is_cancelled`.
pub(super) fn learn(
    training: Training,
    recipe: &Recipe,
    name: &str,
    is_cancelled: impl Fn() -> bool,
) -> Result<Learned> {
    let mut progress = Progress::new(name, recipe.descent.steps);
    let mut message = String::new();
    let learned = training
        .on_progress(|p| {
            if p.judged || message.is_empty() {
                message = p
                    .best_validation
                    .map_or("validation –".to_string(), |reduction| {
                        format!("validation {:.1} %", 100.0 * reduction)
                    });
            }
            progress.of(p.most_steps);
            progress.at(p.step, &message);
            match is_cancelled() {
                true => Directive::Cancel,
                false => Directive::Continue,
            }
        })
        .run();
    progress.done();
    learned
}

fn checkpoint_of(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_os_string();
    name.push(".checkpoint");
    name.into()
}
