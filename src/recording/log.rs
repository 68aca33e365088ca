//! Any log that can be imported: which format it is, told by its content, and several logs as the runs of one recording.

use super::{
    Channel, Columns, Recording, account::Account, carmen, carmen::OdometrySource, compressed, csv,
    npz,
};
use crate::{
    error::{Error, Result},
    storage,
};
use ndarray::Axis;
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// Formats that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// CARMEN text, plain, gzip or xz: [`carmen`].
    Carmen,
    /// A table with a header, plain, gzip or xz: [`csv`].
    Csv,
    /// A dataset: [`npz`].
    Npz,
}

/// What an import may be told.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// The format, instead of guessing it.
    pub format: Option<Format>,
    /// Reading in metres from which on there was no return, instead of the logs' own, for all channels in metres.
    pub max_range_m: Option<f64>,
}

/// A recording read from a log, and what became of everything the log held.
#[derive(Debug, Clone)]
pub struct Log {
    /// What the robot saw.
    pub recording: Recording,
    /// Messages used and passed over, oddities, losses.
    pub account: Account,
    /// Where the recording's odometry comes from.
    pub odometry: OdometrySource,
}

const KNOWN: &str =
    "expected a CARMEN log (plain, gzip or xz), a CSV table with a header or a .npz dataset";

/// Reads one log or several; each becomes a run of its own (a log that holds several runs keeps them apart).
///
/// # Errors
/// Where a file can't be read, is no log of a known format, holds no snapshot, or has other channels than the first.
///
/// ```
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = folder.path().join("walk.log");
/// # std::fs::write(&path, "FLASER 2 1.5 2.5 0 0 0 0 0 0 0.1 host 0.1\n").unwrap();
/// use ballmark::recording::log::{ReadOptions, read};
/// let log = read(&[path], &ReadOptions::default())?;
/// assert_eq!((log.recording.len(), log.recording.channels()[0].width), (1, 2));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<Log> {
    let mut hash = Sha256::new();
    let mut names = Vec::new();
    let mut joined: Option<(Log, &PathBuf)> = None;
    for path in paths {
        let file = storage::read_file(path)?;
        hash.update(&file);
        let name = path
            .file_name()
            .unwrap_or(path.as_os_str())
            .to_string_lossy()
            .into_owned();
        let log = read_bytes(path, &file, options)?;
        joined = Some(match joined {
            None if paths.len() == 1 => (log, path),
            None => (with_log_name(log, &name), path),
            Some((so_far, first)) => (join(so_far, first, log, path, &name)?, first),
        });
        names.push(name);
    }
    let (log, _) = joined.ok_or_else(|| Error::usage("no log named; expected at least one"))?;
    let mut columns = log.recording.into_columns();
    columns.source = Some(names.join(" + "));
    // Of several logs: what `cat A B | sha256sum` prints.
    columns.source_sha256 = Some(hash.finalize().iter().map(|b| format!("{b:02x}")).collect());
    columns.dataset_sha256 = None;
    Ok(Log {
        recording: Recording::new(columns)?,
        ..log
    })
}

fn with_log_name(log: Log, name: &str) -> Log {
    let mut account = Account::default();
    account.add(name, &log.account);
    Log { account, ..log }
}

/// Reads the content of one file.
fn read_bytes(path: &Path, file: &[u8], options: &ReadOptions) -> Result<Log> {
    if file.is_empty() {
        return Err(Error::file(path, format!("the file is empty; {KNOWN}")));
    }
    if options.format == Some(Format::Npz) || (options.format.is_none() && file.starts_with(b"PK"))
    {
        return read_dataset(path, file, options.max_range_m);
    }
    let content = compressed::unpack(path, file)?;
    let bytes = &content.bytes;
    let format = match options.format {
        Some(format) => format,
        None => guess(bytes).map_err(|what| Error::file(path, format!("{what}; {KNOWN}")))?,
    };
    let mut log = match format {
        Format::Csv => csv::read(path, bytes, options.max_range_m)?,
        _ => carmen::read(path, bytes, options.max_range_m)?,
    };
    if let Some(damage) = content.damage {
        log.account.lost(format!("{damage}; the rest is lost"));
    }
    Ok(log)
}

fn read_dataset(path: &Path, file: &[u8], max_range_m: Option<f64>) -> Result<Log> {
    let mut columns = npz::from_bytes(path, file)?.into_columns();
    if let Some(maximum) = max_range_m {
        let mut first = 0;
        for channel in &mut columns.channels {
            let end = first + channel.width;
            if channel.unit == "m" {
                let values = columns.values.slice_axis_mut(Axis(1), (first..end).into());
                super::ranges::blank_no_returns(values, Some(maximum));
                channel.maximum = Some(maximum);
            }
            first = end;
        }
    }
    let mut account = Account::default();
    (0..columns.pose.len()).for_each(|_| account.used("snapshot"));
    Ok(Log {
        recording: Recording::new(columns).map_err(|e| e.in_file(path))?,
        account,
        odometry: OdometrySource::Stated,
    })
}

/// The format of some unpacked bytes, or what they look like instead.
fn guess(bytes: &[u8]) -> std::result::Result<Format, String> {
    let known_elsewhere: [(&[u8], &str); 4] = [
        (b"\x89MCAP0\r\n", "an MCAP log, which can't be read yet"),
        (b"#ROSBAG V", "a rosbag, which can't be read yet"),
        (
            b"SQLite format 3\0",
            "an SQLite database (rosbag2?), which can't be read",
        ),
        (b"\x89HDF\r\n", "an HDF5 file, which can't be read"),
    ];
    if let Some((_, what)) = known_elsewhere
        .iter()
        .find(|(magic, _)| bytes.starts_with(magic))
    {
        return Err((*what).to_string());
    }
    if carmen::looks_like_one(bytes) {
        return Ok(Format::Carmen);
    }
    if csv::looks_like_one(bytes) {
        return Ok(Format::Csv);
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err("nothing but blank space".to_string());
    }
    let first_line = bytes
        .split(|b| *b == b'\n')
        .find(|line| !line.starts_with(b"#") && !line.is_empty());
    let words: Vec<&[u8]> = first_line
        .unwrap_or_default()
        .split(|b| b.is_ascii_whitespace())
        .filter(|w| !w.is_empty())
        .take(9)
        .collect();
    let numeric = |w: &&[u8]| std::str::from_utf8(w).is_ok_and(|w| w.parse::<f64>().is_ok());
    if words.len() == 8 && words.iter().all(numeric) {
        return Err("poses in TUM format, which can't be read yet".to_string());
    }
    Err("not a log that is known here".to_string())
}

/// One recording from two, the second one's runs after the first one's.
fn join(first: Log, first_path: &Path, second: Log, path: &Path, name: &str) -> Result<Log> {
    check_channels(
        first.recording.channels(),
        first_path,
        second.recording.channels(),
        path,
    )?;
    let mut account = first.account;
    account.add(name, &second.account);
    let odometry = if first.odometry == second.odometry {
        first.odometry
    } else {
        account.warning("logs whose odometry comes from different sources");
        first.odometry
    };
    let mut runs = numbered_runs(&first.recording, 0);
    let next = runs.last().map_or(0, |run| run + 1);
    runs.extend(numbered_runs(&second.recording, next));
    let (a, b) = (
        first.recording.into_columns(),
        second.recording.into_columns(),
    );
    let both = |a: Option<Vec<f64>>, b: Option<Vec<f64>>, what: &str| match (a, b) {
        (Some(a), Some(b)) => Ok(Some([a, b].concat())),
        (None, None) => Ok(None),
        _ => Err(Error::file(
            path,
            format!(
                "`{what}` is in one of the logs only, {} or this one; expected in all or none",
                first_path.display()
            ),
        )),
    };
    let channels = a
        .channels
        .into_iter()
        .zip(&b.channels)
        .map(|(a, b)| Channel {
            // Each log is blanked by its own maximum already: no reading of either reaches the larger one.
            maximum: match (a.maximum, b.maximum) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            },
            ..a
        });
    let values = ndarray::concatenate(Axis(0), &[a.values.view(), b.values.view()])
        .map_err(|e| Error::work(format!("cannot join the logs: {e}")))?;
    Ok(Log {
        recording: Recording::new(Columns {
            channels: channels.collect(),
            values,
            stamp_s: [a.stamp_s, b.stamp_s].concat(),
            pose: [a.pose, b.pose].concat(),
            odometry: [a.odometry, b.odometry].concat(),
            run: runs,
            compass_rad: both(a.compass_rad, b.compass_rad, "compass")?,
            route_m: both(a.route_m, b.route_m, "route")?,
            ..Columns::default()
        })?,
        account,
        odometry,
    })
}

fn numbered_runs(recording: &Recording, first: i64) -> Vec<i64> {
    let runs = recording.runs();
    (first..)
        .zip(runs)
        .flat_map(|(number, run)| std::iter::repeat_n(number, run.len()))
        .collect()
}

fn check_channels(
    expected: &[Channel],
    expected_in: &Path,
    found: &[Channel],
    path: &Path,
) -> Result<()> {
    let tell = |channels: &[Channel]| {
        let each = channels
            .iter()
            .map(|c| format!("{} ({} values, {})", c.name, c.width, c.unit));
        each.collect::<Vec<_>>().join(", ")
    };
    let key = |c: &Channel| (c.name.clone(), c.width, c.unit.clone());
    if expected.iter().map(key).eq(found.iter().map(key)) {
        return Ok(());
    }
    Err(Error::file(
        path,
        format!(
            "channels {}; expected those of {}: {}",
            tell(found),
            expected_in.display(),
            tell(expected)
        ),
    ))
}
