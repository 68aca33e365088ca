//! `ballmark trajectory`: judges anyone's poses.

mod folder;
mod options;
mod runs;

use super::{Outcome, print, warn};
use crate::{
    error::{Error, Result},
    experiment::protocol_record::ProtocolRecord,
    report::{Table, conditions_text, runs_tables, trajectory_tables},
    score::trajectory::{
        self, Alignment, Delta, DeltaUnit, Evaluation, EvaluationOptions, Format, Matching,
        OutputFormat, RunsEvaluation, Trajectory,
    },
    storage,
};
use clap::builder::PossibleValuesParser;
use folder::Records;
use options::options;
use runs::{RunConfig, TrajectoryExperiment};
use std::path::{Path, PathBuf};

/// Judge a trajectory: how far is an estimate from a reference?
///
/// Reads poses as TUM (`stamp x y z qx qy qz qw`), KITTI (three rows of four, no stamps), CSV or the vertices of a g2o or TORO graph, guessed from the content. Poses
/// are paired by time; absolute and relative pose errors (APE, RPE) equal those of `evo`. Fewer than 90 % of REF matched is a failure.
///
/// With the estimates before correction (`--prior`) also the prediction-correction metric of Ruiz-Mayor et al. (2006): what the
/// localiser's correction is worth apart from its prediction. Several runs of one localiser are judged apart and together (`--config`).
#[derive(Debug, clap::Args)]
#[command(after_long_help = HELP)]
pub struct Arguments {
    /// Estimated poses.
    #[arg(value_name = "EST", required_unless_present = "config")]
    estimate: Option<PathBuf>,
    /// Reference: the true poses.
    #[arg(value_name = "REF", required_unless_present = "config")]
    reference: Option<PathBuf>,
    /// Estimates before correction, with the stamps of EST.
    #[arg(long, value_name = "P")]
    prior: Option<PathBuf>,
    /// Several runs as [[run]], and what a reader must know of the experiment as [framework] and [run.conditions].
    #[arg(long, value_name = "C.toml")]
    config: Option<PathBuf>,
    /// One JSON object instead of tables.
    #[arg(long)]
    json: bool,
    /// Folder for all of it: JSON, tables, (text, CSV, Markdown, LaTeX), and every run's traces as CSV and drawn on the floor (SVG, PNG).
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Write the matched, aligned poses of EST: .tum, .txt or .csv.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Format of all files, instead of guessing it from their content.
    #[arg(long, value_parser = PossibleValuesParser::new(Format::NAMES))]
    format: Option<String>,
    /// Time stamps of files that have none, one a line.
    #[arg(long, value_name = "FILE")]
    times: Option<PathBuf>,
    /// Seconds that the stamps of a pair may differ by.
    #[arg(long, value_name = "S", default_value_t = Matching::default().max_difference_s, allow_negative_numbers = true)]
    max_difference: f64,
    /// Seconds to add to the stamps of EST (and P).
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    offset: f64,
    /// Move EST onto REF first: a rigid motion in the plane (se2) or in space (se3), with a scale (sim2, sim3).
    #[arg(long, default_value = "none", value_parser = PossibleValuesParser::new(Alignment::NAMES))]
    align: String,
    /// Compare x, y and heading alone.
    #[arg(long)]
    planar: bool,
    /// Distance between the two poses of a relative error.
    #[arg(long, value_name = "D", default_value_t = Delta::default().value, allow_negative_numbers = true)]
    delta: f64,
    /// Unit of --delta.
    #[arg(long, default_value = "frames", value_parser = PossibleValuesParser::new(DeltaUnit::NAMES))]
    delta_unit: String,
    /// Share of --delta that it may be missed by, with --all-pairs.
    #[arg(long, value_name = "SHARE", default_value_t = Delta::default().tolerance, allow_negative_numbers = true)]
    delta_tolerance: f64,
    /// Relative errors from every pose on, not one after the other.
    #[arg(long)]
    all_pairs: bool,
    /// Seek the pairs along REF instead of EST.
    #[arg(long)]
    pairs_from_reference: bool,
    /// Go on where fewer than 90 % of REF are matched.
    #[arg(long)]
    allow_incomplete: bool,
    /// How precise REF is, such as 0.1m,1deg.
    #[arg(long, value_name = "P")]
    truth_precision: Option<String>,
    /// Steps of the localiser's search, such as 10cm,10deg: which estimates could not be better?
    #[arg(long, value_name = "S")]
    search_step: Option<String>,
    /// Ends of intervals of prior error, such as 0.1m,0.2m,5deg; otherwise quartiles.
    #[arg(long, value_name = "E")]
    prior_intervals: Option<String>,
}

const HELP: &str = "\
CSV: a header with `x_m`, `y_m` (or `x`, `y`), optional `z_m`, `time_s` (or `stamp`), and `heading_rad` or `heading_deg`, or \
`qx`, `qy`, `qz`, `qw`; separated by commas, semicolons or tabs.

Pairs: each pose of the trajectory with fewer poses gets the one of the other that is nearest in time. Files without stamps \
are paired in order. Rotations are angles about whatever axis, in degrees. --align se3 may turn a planar trajectory upside down; se2 can't.

--prior: position and heading errors of prior and posterior, their percentiles and merit (mean + standard deviation); C_XY, C_T \
and C_XYT, the share of poses that the correction brings nearer to the truth, with ties counted and not counted; posterior errors by \
intervals of prior error. An estimate is optimal within 0.71 of the position step and half the heading step of --search-step.

--config: each [[run]] has `estimate`, `reference` and, where known, `prior` (files beside the TOML) and `name`. Then all runs are \
judged, and their union. [framework] and [run.conditions] state what poses don't tell, one text a key (`objective`, `robot`, `correction`, \
`real_poses`, ...; `place`, `materials`, `changes`, ...); what is not stated is printed as missing.

Exit status: 0 done, 1 failed (unreadable input, no common time, fewer than 90 % matched), 2 wrong call.

Example:
  printf '0 0 0 0 0 0 0 1\\n1 1 0 0 0 0 0 1\\n2 2 0 0 0 0 0 1\\n' > ref.tum
  printf '0 0 .1 0 0 0 0 1\\n1 1 .1 0 0 0 0 1\\n2 2 .2 0 0 0 0 1\\n' > est.tum
  ballmark trajectory est.tum ref.tum";

pub fn run(arguments: Arguments) -> Result<Outcome> {
    let config = arguments.config.as_deref().map(TrajectoryExperiment::read);
    let config = config.transpose()?;
    let named = config.as_ref().map_or(&[][..], |config| &config.run);
    let has_prior = arguments.prior.is_some() || named.iter().any(|run| run.prior.is_some());
    let options = options(&arguments, has_prior)?;
    let in_call = run_in_call(&arguments, named)?;
    let runs: Vec<&RunConfig> = in_call.iter().chain(named).collect();
    runs.iter()
        .try_for_each(|run| check_files(run, &arguments))?;
    if let Some(folder) = &arguments.report {
        storage::make_folder(folder)?; // a wrong name fails now
    }
    let format = arguments.format.as_deref().map(str::parse).transpose()?;
    let (mut judged, mut protocols) = (Vec::new(), Vec::new());
    for run in &runs {
        let evaluation = judge(run, &arguments, format, &options);
        let evaluation = evaluation.map_err(|e| match named.is_empty() {
            true => e,
            false => e.context(format!("run {}", run.name)),
        })?;
        let (evaluation, protocol) = evaluation;
        judged.push((run.name.clone(), evaluation));
        protocols.push(protocol);
    }
    if let (Some(path), Some((_, evaluation))) = (&arguments.out, judged.first()) {
        trajectory::write(path, &evaluation.aligned)?;
    }
    let all = RunsEvaluation::of(judged, &options.metric)?;
    let framework = config.as_ref().map(|config| &config.framework);
    let (json, tables) = match (&all.runs[..], framework) {
        ([run], None) => {
            let mut json = to_json(&run.evaluation)?;
            json["protocol"] = to_json(&protocols[0])?;
            (json, trajectory_tables(&run.evaluation))
        }
        _ => {
            let mut json = to_json(&all)?;
            for (number, protocol) in protocols.iter().enumerate() {
                json["runs"][number]["protocol"] = to_json(protocol)?;
            }
            (json, runs_tables(&all))
        }
    };
    let mut text = texts(&tables);
    let mut json = json;
    if let Some(framework) = framework {
        json["framework"] = to_json(framework)?;
        for (number, run) in runs.iter().enumerate() {
            json["runs"][number]["conditions"] = to_json(&run.conditions)?;
        }
        let conditions: Vec<_> = (runs.iter())
            .map(|run| (run.name.as_str(), &run.conditions))
            .collect();
        text = format!("{text}\n{}", conditions_text(framework, &conditions));
    }
    if let Some(folder) = &arguments.report {
        let config = serde_json::json!({
            "crate_version": env!("CARGO_PKG_VERSION"),
            "run": runs,
            "options": options,
            "framework": framework,
        });
        let records = Records {
            result: &json,
            config: &config,
        };
        folder::write(folder, &all, records, (&text, tables))?;
    }
    match arguments.json {
        true => print(&format!("{json:#}\n"))?,
        false => print(&text)?,
    }
    Ok(Outcome::Done)
}

/// The run that the call names, where the configuration names none.
fn run_in_call(arguments: &Arguments, named: &[RunConfig]) -> Result<Option<RunConfig>> {
    let refused = |name: &str| {
        Err(Error::usage(format!(
            "{name} beside the [[run]]s of --config; expected the files of all runs there"
        )))
    };
    match (&arguments.estimate, &arguments.reference) {
        (Some(_), _) if !named.is_empty() => refused("EST"),
        _ if !named.is_empty() && arguments.prior.is_some() => refused("--prior"),
        _ if !named.is_empty() && arguments.out.is_some() => Err(Error::usage(
            "--out for several runs; expected --report, a folder for the traces of each",
        )),
        (Some(estimate), Some(reference)) => Ok(Some(RunConfig {
            name: estimate
                .file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            estimate: estimate.clone(),
            reference: reference.clone(),
            prior: arguments.prior.clone(),
            ..RunConfig::default()
        })),
        _ if named.is_empty() => Err(Error::usage(
            "no run: neither EST and REF nor a [[run]] in --config; expected one of them",
        )),
        _ => Ok(None),
    }
}

/// Reads a run's files and judges them; what a reader may take wrongly goes to stderr.
fn judge(
    run: &RunConfig,
    arguments: &Arguments,
    format: Option<Format>,
    options: &EvaluationOptions,
) -> Result<(Evaluation, ProtocolRecord)> {
    let read = |path: &Path| trajectory::read(path, format);
    let (estimate, (reference, prior)) = rayon::join(
        || read(&run.estimate),
        || {
            rayon::join(
                || read(&run.reference),
                || run.prior.as_deref().map(read).transpose(),
            )
        },
    );
    let mut all = (estimate?, reference?, prior?);
    if let Some(path) = &arguments.times {
        all = with_times(path, all)?;
    }
    let (estimate, reference, prior) = all;
    let evaluation = trajectory::evaluate(&estimate, &reference, prior.as_ref(), options)?;
    let mut notes = evaluation.notes.clone();
    let same = |other: &Trajectory| {
        prior
            .as_ref()
            .is_some_and(|prior| prior.poses() == other.poses())
    };
    if same(&reference) {
        notes.push(
            "the prior holds the poses of the reference: are --prior and REF swapped?".into(),
        );
    }
    notes.iter().for_each(|note| warn(&format!("note: {note}")));
    let protocol = ProtocolRecord::of_reference(&reference, options);
    Ok((evaluation, protocol))
}

fn to_json(of: &impl serde::Serialize) -> Result<serde_json::Value> {
    serde_json::to_value(of)
        .map_err(|e| Error::work(format!("cannot write the result as JSON: {e}")))
}

fn texts(tables: &[Table]) -> String {
    let tables: Vec<String> = tables.iter().map(Table::text).collect();
    tables.join("\n")
}

/// Is each file given once, and can the output be made? Asked before the reading.
fn check_files(run: &RunConfig, arguments: &Arguments) -> Result<()> {
    let mut given = vec![("EST", &run.estimate), ("REF", &run.reference)];
    given.extend(run.prior.as_ref().map(|prior| ("--prior", prior)));
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    for (k, (name, path)) in given.iter().enumerate() {
        if let Some((other, _)) = given[..k]
            .iter()
            .find(|(_, other)| real(other) == real(path))
        {
            return Err(Error::usage(format!(
                "{}: given as {other} and as {name}; expected two files",
                path.display()
            )));
        }
    }
    if let Some(path) = &arguments.out {
        OutputFormat::of_ending(path).map_err(|e| e.context("--out"))?;
        storage::check_target(path)?;
        if let Some((name, _)) = given.iter().find(|(_, read)| real(read) == real(path)) {
            return Err(Error::usage(format!(
                "--out {}: would replace {name}; expected another file",
                path.display()
            )));
        }
    }
    Ok(())
}

type Files = (Trajectory, Trajectory, Option<Trajectory>);

/// The same poses; those without time stamps get the ones of a file.
fn with_times(path: &Path, (estimate, reference, prior): Files) -> Result<Files> {
    let stamp_s = trajectory::read_times(path)?;
    let mut used = false;
    let mut stamped = |of: Trajectory| match of.stamps() {
        Some(_) => Ok(of),
        None => {
            used = true;
            of.with_stamps(stamp_s.clone())
                .map_err(|e| e.context(path.display()))
        }
    };
    let stamped = (
        stamped(estimate)?,
        stamped(reference)?,
        prior.map(&mut stamped).transpose()?,
    );
    if used {
        Ok(stamped)
    } else {
        Err(Error::usage(format!(
            "--times {}: all files have time stamps of their own; expected one without",
            path.display()
        )))
    }
}
