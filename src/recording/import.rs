//! Reading logs: which format each is, guessed from its content, and several logs as the runs of one recording.

use super::{
    Recording,
    format::{self, Format, ros},
    import_report::ImportReport,
    imported_log::ImportedLog,
    joined,
    log_options::LogOptions,
    source::Source,
};
use crate::{
    error::{Error, Result},
    storage,
};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// How logs are read.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// The format, instead of guessing it.
    pub format: Option<Format>,
    /// What the logs don't say themselves.
    pub log: LogOptions,
}

/// Reads one log or several; each becomes a run of its own (a log that holds several runs keeps them apart). A folder is a
/// bag of ROS 2, with all its files one log.
///
/// # Errors
/// Where a file can't be read, is no log of a known format, holds no snapshot, or has other channels than the first: other
/// names, widths, units or bearings.
///
/// ```
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = folder.path().join("walk.log");
/// # std::fs::write(&path, "FLASER 2 1.5 2.5 0 0 0 0 0 0 0.1 host 0.1\n").unwrap();
/// use ballmark::recording::import::{ReadOptions, read};
/// let log = read(&[path], &ReadOptions::default())?;
/// assert_eq!((log.recording.len(), log.recording.channels()[0].width), (1, 2));
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<ImportedLog> {
    let mut hash = Sha256::new();
    let mut logs: Vec<ImportedLog> = Vec::new();
    for path in paths {
        let log = if path.is_dir() {
            let (log, read) = ros::read_folder(path, &options.log, hash)?;
            hash = read;
            format::as_declared(path, log, &options.log, false)?
        } else {
            let (log, read) = read_one(path, options, hash)?;
            hash = read;
            log
        };
        if let Some(first) = logs.first() {
            let first_name = paths[0].display().to_string();
            let (first, next) = (first.recording.columns(), log.recording.columns());
            joined::check(first, next, &first_name).map_err(|fault| Error::file(path, fault))?;
        }
        logs.push(log);
    }
    let names: Vec<String> = paths.iter().map(|path| name(path)).collect();
    let log = match logs.len() {
        0 => return Err(Error::usage("no log named; expected at least one")),
        1 => logs.swap_remove(0),
        _ => join(logs, &names)?,
    };
    let mut columns = log.recording.into_columns();
    columns.source = Some(names.join(" + "));
    // Of several logs: what `cat A B | sha256sum` prints.
    columns.source_sha256 = Some(storage::hexadecimal(hash));
    columns.dataset_sha256 = None;
    Ok(ImportedLog {
        recording: Recording::new(columns)?,
        ..log
    })
}

fn name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// Reads the content of one file; the digest goes on with its bytes.
fn read_one(path: &Path, options: &ReadOptions, hash: Sha256) -> Result<(ImportedLog, Sha256)> {
    let mut source = Source::open(path, hash)?;
    if source.is_empty {
        return Err(format::unreadable(path, "the file is empty"));
    }
    let format = match options.format {
        Some(format) => format,
        None => Format::of_content(path, source.head())?,
    };
    let read = format.read_source(path, &mut source, &options.log);
    // A file that can't be read on, or that changed meanwhile, is why a reader stumbled.
    let (hash, damage) = source.end()?;
    let mut log = read?;
    if let Some(damage) = damage {
        log.account.lost(format!("{damage}; the rest is lost"));
    }
    Ok((log, hash))
}

/// One log from several, run after run; lost records bear the name of their log.
fn join(logs: Vec<ImportedLog>, names: &[String]) -> Result<ImportedLog> {
    let mut account = ImportReport::default();
    let odometry = logs[0].odometry;
    let mut recordings = Vec::new();
    for (log, name) in logs.into_iter().zip(names) {
        account.add(name, &log.account);
        if log.odometry != odometry {
            account.warning("logs whose odometry comes from different sources");
        }
        let mut columns = log.recording.into_columns();
        columns.run = counted_from_zero(&columns.run);
        recordings.push(Recording::new(columns)?);
    }
    Ok(ImportedLog {
        recording: Recording::joined(recordings)?,
        account,
        odometry,
    })
}

/// Numbers of runs counted from 0: a new one wherever the number changes.
fn counted_from_zero(run: &[i64]) -> Vec<i64> {
    let mut number = 0;
    let mut before = run.first();
    let counted = run.iter().map(|run| {
        number += i64::from(before != Some(run));
        before = Some(run);
        number
    });
    counted.collect()
}
