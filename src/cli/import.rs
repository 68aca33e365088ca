//! `ballmark import`: a log becomes a dataset.

use super::{Outcome, print, warn};
use crate::{
    error::{Error, Result},
    experiment::labelled_log::{TOLERANCE_S, labelled},
    recording::{
        Recording,
        bearings::Bearings,
        format::{FORMATS, Format},
        import::{self, ReadOptions},
        imported_log::ImportedLog,
        log_options::{GAP_M, LogOptions},
        npz,
        selection::Selection,
    },
    score::trajectory,
    storage,
};
use clap::builder::PossibleValuesParser;
use ndarray::Axis;
use serde_json::{Value, json};
use std::{
    collections::BTreeMap,
    fmt::{Display, Write},
    path::{Path, PathBuf},
    str::FromStr,
};

/// Turn a robot's log into a dataset.
///
/// Reads CARMEN text logs, bags of ROS 1 and ROS 2 and MCAP (without ROS), CSV tables (also of camera frames) and datasets, each also packed as a
/// whole (gzip, xz, bzip2, zstd); which of them is guessed from the content. Several logs become several runs.
#[derive(Debug, clap::Args)]
#[command(after_long_help = HELP)]
pub struct Arguments {
    /// Logs to read; each becomes a run of its own.
    #[arg(required = true)]
    log: Vec<PathBuf>,

    /// Dataset to write.
    #[arg(short, long, value_name = "D.npz")]
    output: PathBuf,

    /// Format of the logs, instead of guessing it from their content.
    #[arg(long, value_parser = PossibleValuesParser::new(FORMATS.map(|format| format.name)))]
    format: Option<String>,

    /// Reading in metres from which on there was no return, instead of the log's own; for all channels in metres.
    #[arg(long, value_name = "METRES")]
    max_range: Option<f64>,

    /// Poses to label the snapshots with, in place of the logs' own: TUM, KITTI, CSV or a g2o or TORO graph, as SLAM writes them.
    /// Without times: one a snapshot, in their order.
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,

    /// Times of poses that have none (KITTI): one a line, in seconds.
    #[arg(long, value_name = "FILE")]
    pose_times: Option<PathBuf>,

    /// Farthest in time that a pose may be from a snapshot (0.5); between two poses it is taken in proportion.
    #[arg(long, value_name = "SECONDS")]
    pose_tolerance: Option<f64>,

    /// Sensors to take, of several: columns of a table by name, channels (NAME) or values (NAME.NUMBER) of other logs; `*` stands for any letters.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    columns: Vec<String>,

    /// Sensors to leave out, named likewise.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    drop: Vec<String>,

    /// Unit of a channel, instead of the log's own; mm, cm, dm, km, in, ft and yd are made metres.
    #[arg(long, value_name = "CHANNEL=UNIT", value_parser = named::<String>)]
    unit: Vec<(String, String)>,

    /// Where a channel's values point, in degrees to the left of ahead: one each, or FIRST..LAST evenly.
    #[arg(long, value_name = "CHANNEL=DEG,...", value_parser = named::<Bearings>, allow_hyphen_values = true)]
    bearings: Vec<(String, Bearings)>,

    /// How far from the robot's middle a channel's sensors sit, along their bearings.
    #[arg(long, value_name = "CHANNEL=METRES", value_parser = named::<f64>)]
    offset: Vec<(String, f64)>,

    /// A step longer than this, of which odometry knows less than half, begins a new run (5).
    #[arg(long, value_name = "METRES")]
    gap: Option<f64>,

    /// Topic whose poses are the labels, in a bag: PoseStamped, PoseWithCovarianceStamped or Odometry, such as /amcl_pose.
    #[arg(long, value_name = "TOPIC")]
    pose_topic: Option<String>,

    /// Sensor topics to take from a bag, with commas between them, such as /scan,/odom; all without.
    #[arg(long, value_name = "TOPIC,...", value_delimiter = ',')]
    topics: Option<Vec<String>>,

    /// Print the summary as one JSON object.
    #[arg(long)]
    json: bool,
}

const HELP: &str = "\
CARMEN: one snapshot a FLASER, ROBOTLASER1 or RAWLASER1 line (channel `laser`; RLASER is `rear_laser`, SONAR is `sonar`); \
without those, one an RLASER or SONAR line. Readings without a return become NaN from the log's own maximum on, which is \
printed: a value that readings pile up at, far out and wherever the robot is.

CSV: a header with `time_s` (or `stamp`), `x_m`, `y_m`, `heading_rad` (the true place); optional `odometry_x_m`, \
`odometry_y_m`, `odometry_heading_rad`, `run`, `route_m`, `compass_rad`. Every other column is one sensor value: NAME.0, \
NAME.1, ... (or NAME_0, NAME[0], NAME0, NAME001, from 0 or 1 on) form one channel NAME, a plain name is a channel of one value. An empty \
cell or nan is no return. A unit may stand in brackets: light[lux], and behind it where a value points and how far out its sensor sits: \
sonar.3[cm @ 67.5 + 0.2m]; `laser`, `rear_laser`, `sonar`, `infrared` and names ending in _m are in metres. Cells are separated by commas, \
semicolons or tabs; UTF-16 and decimal commas are read. \
A column `frame` (or `image`) of file names, relative to the table, brings a PNG or JPEG picture a row: channel `camera`, \
the 140 values of Thrun (1998, 5.1.3) of the picture subsampled to 60 x 64 pixels.

ROS: rosbag 2.0 (ROS 1), .db3 and .mcap of rosbag2 or a whole folder of them with metadata.yaml, MCAP with ros1 or cdr messages; compressed \
or not. One snapshot a message of the first LaserScan topic by name (channel `laser`), without one of the first Range topic, then CompressedImage; \
every other sensor topic joins with its message nearest in time, half a second at most: further scans by their topic's name, ranges as `sonar` or \
`infrared`, a value a topic, pictures as `camera`. Bearings hold the sensor's place on the robot by tf. The label is tf map -> base, else \
PoseWithCovarianceStamped or PoseStamped messages, or what --pose-topic says, interpolated at the message's stamp; odometry is nav_msgs/Odometry, else tf \
odom -> base. A log of odometry alone is taken with a warning that it has no labels.

--poses: a snapshot takes the pose between the two around its stamp; those before the first and after the last are passed over, \
those in a gap of the poses are dropped. The logs' own poses become odometry where they have no other.

Exit status: 0 done (odd time stamps and messages passed over are warnings), 1 failed, 2 wrong call, 3 done but damaged lines, messages or chunks \
(or lines whose picture is missing or broken) were dropped, each counted and the first ones named.

Example:
  printf 'time_s,x_m,y_m,heading_rad,light\\n0,0,0,0,7\\n1,0.5,0,0,9\\n' > walk.csv
  ballmark import walk.csv -o walk.npz";

pub fn run(arguments: Arguments) -> Result<Outcome> {
    for (option, metres) in [
        ("--max-range", arguments.max_range),
        ("--gap", arguments.gap),
    ] {
        if let Some(metres) = metres.filter(|m| !(m.is_finite() && *m > 0.0)) {
            let fault = format!("{option} {metres}: expected metres above 0");
            return Err(Error::usage(fault));
        }
    }
    let options = ReadOptions {
        format: arguments.format.as_deref().map(Format::named).transpose()?,
        log: LogOptions {
            max_range_m: arguments.max_range,
            sensors: Selection {
                take: arguments.columns.clone(),
                leave: arguments.drop.clone(),
            },
            units: arguments.unit.clone(),
            bearings: arguments.bearings.clone(),
            offsets_m: arguments.offset.clone(),
            gap_m: arguments.gap,
            poses_elsewhere: arguments.poses.is_some(),
            pose_topic: arguments.pose_topic.clone(),
            topics: arguments.topics.clone(),
        },
    };
    storage::check_target(&arguments.output)?; // a wrong name fails now, not after the reading
    if let Some(s) = arguments
        .pose_tolerance
        .filter(|s| !(s.is_finite() && *s >= 0.0))
    {
        return Err(Error::usage(format!(
            "--pose-tolerance {s}: expected seconds from 0"
        )));
    }
    let of_poses = arguments.pose_times.is_some() || arguments.pose_tolerance.is_some();
    if arguments.poses.is_none() && of_poses {
        return Err(Error::usage(
            "--pose-times, --pose-tolerance: expected `--poses` with them",
        ));
    }
    let mut log = import::read(&arguments.log, &options)?;
    if let Some(poses) = &arguments.poses {
        log = posed(log, poses, &arguments)?;
    }
    let named = |e: Error| {
        if e.is_io() {
            e
        } else {
            e.in_file(&arguments.log[0])
        }
    };
    npz::write(&arguments.output, &log.recording).map_err(named)?;
    let account = &log.account;
    for note in account.notes() {
        warn(&format!("note: {note}"));
    }
    for (what, n) in account.warning_counts() {
        warn(&format!("warning: {n} × {what}"));
    }
    for record in account.lost_records() {
        warn(&format!("dropped: {record}"));
    }
    let unnamed = account.lost_count() - account.lost_records().len();
    if unnamed > 0 {
        warn(&format!("dropped: {unnamed} more"));
    }
    if arguments.json {
        print(&format!("{}\n", summary(&log, &arguments)))?;
    } else {
        print(&table(&log, &arguments))?;
    }
    Ok(if account.lost_count() > 0 {
        Outcome::Lossy
    } else {
        Outcome::Done
    })
}

/// The log with the poses of a file as labels.
fn posed(log: ImportedLog, poses: &Path, arguments: &Arguments) -> Result<ImportedLog> {
    let mut trajectory = trajectory::read(poses, None)?;
    if let Some(times) = &arguments.pose_times {
        trajectory = trajectory.with_stamps(trajectory::read_times(times)?)?;
    }
    let tolerance_s = arguments.pose_tolerance.unwrap_or(TOLERANCE_S);
    labelled(
        log,
        &trajectory,
        tolerance_s,
        arguments.gap.unwrap_or(GAP_M),
    )
}

/// `NAME=VALUE`
fn named<T: FromStr<Err: Display>>(text: &str) -> std::result::Result<(String, T), String> {
    let (name, value) = text.split_once('=').ok_or("expected CHANNEL=VALUE")?;
    let value = value.parse().map_err(|e: T::Err| e.to_string())?;
    Ok((name.to_string(), value))
}

/// Share of NaN in each channel.
fn no_return_shares(recording: &Recording) -> Vec<f64> {
    let mut first = 0;
    let shares = recording.channels().iter().map(|channel| {
        let values = recording
            .values()
            .slice_axis(Axis(1), (first..first + channel.width).into());
        first += channel.width;
        values.iter().filter(|v| v.is_nan()).count() as f64 / values.len() as f64
    });
    shares.collect()
}

fn summary(log: &ImportedLog, arguments: &Arguments) -> Value {
    let recording = &log.recording;
    let channels = recording.channels().iter().zip(no_return_shares(recording)).map(|(c, share)| {
        json!({ "name": c.name, "values": c.width, "unit": c.unit, "maximum": c.maximum, "no_return_share": share })
    });
    let account = &log.account;
    json!({
        "output": arguments.output.display().to_string(),
        "snapshots": recording.len(),
        "runs": recording.runs().len(),
        "path_m": recording.path_m(),
        "odometry": log.odometry.describe(),
        "channels": channels.collect::<Vec<_>>(),
        "used": account.used_counts(),
        "passed_over": account.passed_over_counts(),
        "warnings": account.warning_counts(),
        "notes": account.notes(),
        "dropped": account.lost_count(),
        "dropped_records": account.lost_records(),
    })
}

fn table(log: &ImportedLog, arguments: &Arguments) -> String {
    let recording = &log.recording;
    let account = &log.account;
    let mut out = String::new();
    let mut row = |name: &str, value: String| {
        let _ = writeln!(out, "{name:<12} {value}"); // writing to a String can't fail
    };
    row("dataset", arguments.output.display().to_string());
    row("snapshots", recording.len().to_string());
    row("runs", recording.runs().len().to_string());
    row("path", format!("{:.1} m", recording.path_m()));
    row("odometry", log.odometry.describe().to_string());
    for (channel, share) in recording.channels().iter().zip(no_return_shares(recording)) {
        let maximum = match channel.maximum {
            Some(maximum) => format!("no return from {maximum} {} on", channel.unit),
            None => "no maximum found or given".to_string(),
        };
        row(
            "channel",
            format!(
                "{}: {} values in {}; {maximum}: {:.2} % NaN",
                channel.name,
                channel.width,
                channel.unit,
                100.0 * share
            ),
        );
    }
    row("used", counted(account.used_counts()));
    row("passed over", counted(account.passed_over_counts()));
    row(
        "warnings",
        account.warning_counts().values().sum::<usize>().to_string(),
    );
    row("dropped", account.lost_count().to_string());
    out
}

fn counted(counts: &BTreeMap<String, usize>) -> String {
    let each: Vec<String> = counts
        .iter()
        .map(|(kind, n)| format!("{n} {kind}"))
        .collect();
    if each.is_empty() {
        "none".to_string()
    } else {
        each.join(", ")
    }
}
