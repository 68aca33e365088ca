//! `ballmark trials`: the trials of a comparison for somebody else's localiser, without the truth.

use super::{
    Outcome,
    files::{make_writable, write_text},
    print,
    progress::Progress,
    warn,
};
use crate::{
    error::{Error, Result},
    experiment::{
        compare::{CompareConfig, DatasetConfig, SystemConfig, TrialSet},
        external::{ExternalConfig, Start},
        localisation::LocaliseConfig,
        protocol::{Mapping, ProtocolConfig},
    },
    mapping::{OccupancyMap, OccupancyMapConfig, RangeSensors},
    recording::{
        Channel,
        degraded::Degraded,
        write::{Format, write},
    },
    report::{Cell, Table},
    storage,
    toml_file::TomlFile,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Write localisation trials for somebody else's localiser, without the truth, and a configuration that judges its answers.
///
/// The folder then holds `mapping/`, what may be learned and mapped from: the mapping part with its poses, and the occupancy map that its
/// scans draw; `trials/`, what a robot senses in each trial: odometry from the origin on, sensors, seconds from 1 on; and `compare.toml`, by
/// which `ballmark compare` judges the answers in `answers/` beside localisers of ours. Give away `mapping` and `trials` alone: the
/// dataset that `compare.toml` names has the truth.
///
/// For the trial `unknown-001` the localiser is to write `answers/unknown-001.tum` (a pose a snapshot: time x y z qx qy qz qw) or `.csv` with a
/// header: `time_s,x_m,y_m`, perhaps `heading_rad`, and where it has a belief `xx_m2,xy_m2,yy_m2` (covariance), or several rows a time with
/// `weight` (particles) or `probability` (cells of a grid). Metres and radians in the frame of the mapping part's poses.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  ballmark trials datasets/corridor-small.npz -o corridor-trials")]
pub struct Arguments {
    /// The dataset.
    #[arg(value_name = "D.npz")]
    dataset: PathBuf,
    /// The folder that they go to; made where it isn't there.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Configuration: its sections [protocol], [localisation] and [degraded] and its seed hold; other sections of a comparison are passed
    /// over. Not said: every fourth stretch is unseen, 60 trials.
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// Trials that start anywhere (unknown), and the same told where they start (both).
    #[arg(long, value_name = "START", default_value = "both", value_parser = ["both", "unknown"])]
    start: String,
    /// Formats of the trials: csv, carmen, mcap, npz. Not said: csv, and what else holds these sensors.
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', value_parser = ["csv", "carmen", "mcap", "npz"])]
    format: Vec<String>,
    /// The one seed of the run, in place of the configuration's.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

/// A section that says nothing of trials.
type PassedOver = Option<serde::de::IgnoredAny>;

/// What a configuration says of trials; the rest of a comparison's is passed over.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct TrialsFile {
    seed: Option<u64>,
    protocol: Option<ProtocolConfig>,
    localisation: LocaliseConfig,
    degraded: Degraded,
    dataset: PassedOver,
    system: PassedOver,
    standard: PassedOver,
    recognition: PassedOver,
    error_reduction: PassedOver,
    landmarks: PassedOver,
}

/// The comparison that judges: as it is written down.
#[derive(Debug, Serialize)]
struct Judge<'a> {
    seed: u64,
    dataset: [DatasetConfig; 1],
    system: Vec<toml::Table>,
    #[serde(skip_serializing_if = "Degraded::is_default")]
    degraded: &'a Degraded,
    protocol: &'a ProtocolConfig,
    localisation: &'a LocaliseConfig,
}

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let config = comparison(&arguments)?;
    let starts: &[Start] = match arguments.start.as_str() {
        "unknown" => &[Start::Unknown],
        _ => &[Start::Unknown, Start::Known],
    };
    let folder = &arguments.output;
    for (part, what) in [
        ("answers", "answers to earlier trials"),
        ("trials", "earlier trials"),
    ] {
        let part = folder.join(part);
        if part
            .read_dir()
            .is_ok_and(|mut files| files.next().is_some())
        {
            let fault = format!("holds {what}; expected another folder, or one without them");
            return Err(Error::file(part, fault));
        }
    }
    let set = TrialSet::new(&config, Path::new(""), starts)?;
    let channels = set.mapping.channels();
    let formats = formats(&arguments.format, channels)?;
    make_writable(folder)?;
    let [mapping, trials, answers] = ["mapping", "trials", "answers"].map(|name| folder.join(name));
    for part in [&mapping, &trials, &answers] {
        storage::make_folder(part)?;
    }
    let poses = Some(set.mapping.poses());
    for &format in &formats {
        let file = mapping.join(format!("mapping.{}", format.ending()));
        write(format, &file, &set.mapping, poses)?;
    }
    let all: Vec<usize> = (0..set.mapping.len()).collect();
    let has_map = RangeSensors::default().beams(channels).is_ok();
    if has_map {
        let map = OccupancyMap::from_scans(&set.mapping, &all, &OccupancyMapConfig::default())?;
        map.cropped().write_ros(&mapping.join("map.yaml"))?;
    }
    let mut progress = Progress::new("writing trials", set.trials.len());
    let mut table = Table::new(
        [
            "name",
            "start",
            "snapshots",
            "seconds",
            "x_m",
            "y_m",
            "heading_rad",
        ]
        .map(String::from),
    );
    for (done, trial) in set.trials.iter().enumerate() {
        progress.at(done, &trial.name);
        for &format in &formats {
            let folder = trials.join(format.name());
            storage::make_folder(&folder)?;
            let file = folder.join(format!("{}.{}", trial.name, format.ending()));
            write(format, &file, &trial.observed, None)?;
        }
        let stamps = &trial.observed.columns().stamp_s;
        let pose = trial
            .pose
            .map(|pose| [pose.x_m, pose.y_m, pose.heading_rad]);
        let start = |at: usize| pose.map_or(String::new(), |pose| pose[at].to_string());
        let row = [
            trial.name.clone(),
            trial.start.word().to_string(),
            stamps.len().to_string(),
            (stamps[stamps.len() - 1] - stamps[0]).to_string(),
            start(0),
            start(1),
            start(2),
        ];
        table.row(row.map(Cell::Text));
    }
    progress.done();
    write_text(&trials.join("trials.csv"), &table.csv())?;
    let judge = judge(&config, &arguments.dataset, has_map, starts)?;
    write_text(&folder.join("compare.toml"), &judge)?;
    for note in &set.notes {
        warn(&format!("note: {note}"));
    }
    print(&told(folder, &set, &formats, has_map))?;
    Ok(Outcome::Done)
}

/// The comparison that plays these trials; somebody else's localiser is its one system so far.
fn comparison(arguments: &Arguments) -> Result<CompareConfig> {
    let file = match &arguments.config {
        Some(path) => {
            let text = TomlFile::read(path)?;
            let file: TrialsFile = text.parse()?;
            let checked = file.protocol.as_ref().map_or(Ok(()), ProtocolConfig::check);
            checked
                .and_then(|()| file.degraded.check())
                .map_err(|fault| text.locate(fault))?;
            let localisation = file.localisation.check().map_err(|fault| {
                Error::usage(fault.to_string().replace("localise.", "localisation."))
            });
            localisation.map_err(|fault| text.locate(fault))?;
            let mut localisation = file
                .localisation
                .beside(path.parent().unwrap_or(Path::new("")));
            // The comparison that is written stands in another folder.
            if !localisation.map.as_os_str().is_empty() {
                localisation.map = full(&localisation.map)?;
            }
            TrialsFile {
                localisation,
                ..file
            }
        }
        None => TrialsFile::default(),
    };
    let in_turn = || ProtocolConfig {
        mapping: Mapping::Split,
        ..ProtocolConfig::default()
    };
    let external = ExternalConfig {
        answers: "answers".into(),
        ..ExternalConfig::default()
    };
    let config = CompareConfig {
        seed: arguments
            .seed
            .or(file.seed)
            .unwrap_or(CompareConfig::default().seed),
        dataset: vec![DatasetConfig::file(&arguments.dataset)],
        system: vec![SystemConfig::external("mine", external)],
        degraded: file.degraded,
        protocol: file.protocol.unwrap_or_else(in_turn),
        localisation: Some(file.localisation),
        ..CompareConfig::default()
    };
    config.check()?;
    Ok(config)
}

/// Those asked for; else all that hold these sensors, but for datasets.
fn formats(asked: &[String], channels: &[Channel]) -> Result<Vec<Format>> {
    let is_asked = |format: &Format| asked.iter().any(|name| name == format.name());
    let mut formats: Vec<Format> = Format::ALL.into_iter().filter(is_asked).collect();
    if asked.is_empty() {
        let holds = |format: &Format| *format != Format::Npz && format.refuses(channels).is_none();
        formats = Format::ALL.into_iter().filter(holds).collect();
    }
    match formats.iter().find_map(|format| format.refuses(channels)) {
        Some(why) => Err(Error::work(format!("--format {why}; expected csv or npz"))),
        None => Ok(formats),
    }
}

/// Where nobody says otherwise, whether so many times the particles change a result is looked at.
const MORE_PARTICLES: usize = 4;

/// A file's name from the root on, so that it is found from any folder.
fn full(file: &Path) -> Result<PathBuf> {
    file.canonicalize()
        .map_err(|e| Error::io("cannot find", file, e))
}

/// The comparison as a file: the localiser under test first, then rivals that learn nothing.
fn judge(
    config: &CompareConfig,
    dataset: &Path,
    has_map: bool,
    starts: &[Start],
) -> Result<String> {
    let full = full(dataset)?;
    let mut mine = toml::toml! {
        name = "mine"
        kind = "external"
        answers = "answers"
    };
    if !starts.contains(&Start::Known) {
        mine.insert("start".into(), "unknown".into());
    }
    let rivals = match has_map {
        true => vec![
            toml::toml! { name = "likelihood field" kind = "bayes" landmarks = "likelihood_field" },
            toml::toml! { name = "Monte Carlo" kind = "monte_carlo" },
        ],
        false => vec![toml::toml! { name = "kernel" kind = "bayes" landmarks = "kernel" }],
    };
    let odometry = toml::toml! { name = "odometry" kind = "bayes" landmarks = [] };
    let localisation = config.localisation.as_ref();
    let localisation = localisation.ok_or_else(|| Error::work("no trials"))?;
    let judge = Judge {
        seed: config.seed,
        dataset: [DatasetConfig::file(full)],
        system: [vec![mine], rivals, vec![odometry]].concat(),
        degraded: &config.degraded,
        protocol: &config.protocol,
        localisation: &LocaliseConfig {
            more_particles: match (has_map, localisation.more_particles) {
                (true, 0) => MORE_PARTICLES,
                (_, stated) => stated,
            },
            ..localisation.clone()
        },
    };
    let text = toml::to_string(&judge);
    let text = text.map_err(|e| Error::work(format!("configuration as TOML: {e}")))?;
    Ok(format!(
        "# Judges the answers in answers/ beside localisers of ours: ballmark compare compare.toml\n\
         # The dataset has the truth: keep it from the localiser under test.\n\n{text}"
    ))
}

/// What lies where, and what to do next.
fn told(folder: &Path, set: &TrialSet, formats: &[Format], has_map: bool) -> String {
    let of = |start: Start| {
        set.trials
            .iter()
            .filter(|trial| trial.start == start)
            .count()
    };
    let formats: Vec<&str> = formats.iter().map(|format| format.name()).collect();
    let map = if has_map {
        ", and map.yaml for map_server"
    } else {
        ""
    };
    let folder = folder.display();
    format!(
        "{} trials from anywhere, {} from a known start ({})\n\
         {folder}/mapping       {} snapshots to map and learn from, with their poses{map}\n\
         {folder}/trials        what is sensed in each; trials.csv lists them, with the starts that are known\n\
         {folder}/answers       goes here: NAME.tum or NAME.csv for every trial\n\
         {folder}/compare.toml  judges them: ballmark compare {folder}/compare.toml\n",
        of(Start::Unknown),
        of(Start::Known),
        formats.join(", "),
        set.mapping.len()
    )
}
