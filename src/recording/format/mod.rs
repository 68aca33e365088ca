//! Log formats: one file (or folder) each, and one line each in [`FORMATS`].
//!
//! A new format is a function that reads a log's bytes, a function that recognises them, and a line in the list: `ballmark
//! import` then guesses it, offers it as `--format` and names it in its messages.

pub mod carmen;
mod clocks;
pub mod csv;
mod dataset;
pub mod ros;

use super::{
    Recording, content::Content, declared, imported_log::ImportedLog, log_options::LogOptions,
    oddities, source::Source,
};
use crate::error::{Error, Result};
use std::{fmt, io, path::Path};

/// A format that logs come in.
#[derive(Clone, Copy)]
pub struct Format {
    /// What `--format` calls it.
    pub name: &'static str,
    /// What such a file is, in a few words.
    pub what: &'static str,
    /// Does an unpacked log read like one of this format? The first format of the list that says so is taken.
    recognises: Recognise,
    read: Read,
    /// Its reader goes through a log once, line by line.
    read_lines: Option<ReadLines>,
    /// Its reader goes back and forth, and holds no more of it than it looks at.
    read_content: Option<ReadContent>,
    /// Its reader leaves out sensors itself, before it reads them.
    selects_itself: bool,
    /// Has it topics?
    is_ros: bool,
    /// Does its reader begin a new run at a gap? Else runs stand as they are.
    parts_runs: bool,
}

type Recognise = fn(&[u8]) -> bool;

/// Reads an unpacked log: its file's name for messages, its bytes, and how it is to be taken.
type Read = fn(&Path, &[u8], &LogOptions) -> Result<ImportedLog>;

/// The same of a log that is too long for memory: its beginning, and what follows.
type ReadLines = fn(&Path, &[u8], &mut dyn io::Read, &LogOptions) -> Result<ImportedLog>;

/// The same of a log that need not be in memory.
type ReadContent = fn(&Path, &Content, &LogOptions) -> Result<ImportedLog>;

/// All formats, in the order in which they are tried.
pub const FORMATS: [Format; 6] = [
    Format::new("npz", "a .npz dataset", dataset::detect, dataset::read).with_runs(),
    Format::new(
        "rosbag1",
        "a bag of ROS 1",
        ros::detect_rosbag1,
        ros::read_rosbag1,
    )
    .of_ros(ros::rosbag1_content),
    Format::new(
        "rosbag2",
        "a bag of ROS 2",
        ros::detect_rosbag2,
        ros::read_rosbag2,
    )
    .of_ros(ros::rosbag2_content),
    Format::new("mcap", "an MCAP log", ros::detect_mcap, ros::read_mcap).of_ros(ros::mcap_content),
    Format::new("carmen", "a CARMEN log", carmen::detect, carmen::read)
        .by_lines(carmen::read_lines),
    Format::new("csv", "a CSV table with a header", csv::detect, csv::read)
        .by_lines(csv::read_lines)
        .selecting_itself(),
];

/// What can't be read, by its first bytes.
const NOT_READ: [(&[u8], &str); 2] = [
    (
        b"#ROSBAG V1",
        "a rosbag of the old format 1, which can't be read (`rosbag migrate` makes it 2.0)",
    ),
    (b"\x89HDF\r\n", "an HDF5 file, which can't be read"),
];

impl Format {
    const fn new(
        name: &'static str,
        what: &'static str,
        recognises: Recognise,
        read: Read,
    ) -> Self {
        Self {
            name,
            what,
            recognises,
            read,
            read_lines: None,
            read_content: None,
            selects_itself: false,
            is_ros: false,
            parts_runs: true,
        }
    }

    const fn by_lines(self, read_lines: ReadLines) -> Self {
        Self {
            read_lines: Some(read_lines),
            ..self
        }
    }

    const fn of_ros(self, read_content: ReadContent) -> Self {
        Self {
            read_content: Some(read_content),
            is_ros: true,
            ..self
        }
    }

    const fn with_runs(self) -> Self {
        Self {
            parts_runs: false,
            ..self
        }
    }

    const fn selecting_itself(self) -> Self {
        Self {
            selects_itself: true,
            ..self
        }
    }

    /// The format of that name.
    ///
    /// # Errors
    /// A usage error that lists the names.
    pub fn named(name: &str) -> Result<Self> {
        let found = FORMATS.into_iter().find(|format| format.name == name);
        found.ok_or_else(|| {
            let names = FORMATS.map(|format| format.name).join(", ");
            let name = name.escape_debug();
            Error::usage(format!("log format `{name}`: expected one of {names}"))
        })
    }

    /// The format of some unpacked bytes; `path` is for messages only.
    ///
    /// # Errors
    /// Where no format recognises them; the message says what they look like instead, and what was expected.
    ///
    /// ```
    /// use ballmark::recording::format::Format;
    /// let format = Format::of_content("walk.log".as_ref(), b"ODOM 0 0 0 0 0 0 1 host 1\n")?;
    /// assert_eq!(format.name, "carmen");
    /// let error = Format::of_content("walk.bag".as_ref(), b"#ROSBAG V1.2\n").unwrap_err();
    /// assert!(error.to_string().starts_with("walk.bag: a rosbag of the old format 1, which can't be read"));
    /// # Ok::<(), ballmark::Error>(())
    /// ```
    pub fn of_content(path: &Path, bytes: &[u8]) -> Result<Self> {
        let not_read = NOT_READ.iter().find(|(magic, _)| bytes.starts_with(magic));
        let found = FORMATS.iter().find(|format| (format.recognises)(bytes));
        match (not_read, found) {
            (None, Some(format)) => Ok(*format),
            (Some((_, what)), _) => Err(unreadable(path, what)),
            (None, None) => Err(unreadable(path, looks_like(bytes))),
        }
    }

    /// Reads an unpacked log of this format.
    ///
    /// # Errors
    /// Where it holds nothing that can be read, or an option names a sensor that it lacks. Damaged records are no error but
    /// entries in the log's account.
    pub fn read(&self, path: &Path, bytes: &[u8], options: &LogOptions) -> Result<ImportedLog> {
        self.noted(path, (self.read)(path, bytes, options)?, options)
    }

    /// The same of a log that is still being read.
    ///
    /// # Errors
    /// As [`Format::read`], and where it can't be read on.
    pub(super) fn read_source(
        &self,
        path: &Path,
        source: &mut Source,
        options: &LogOptions,
    ) -> Result<ImportedLog> {
        let log = if let Some(read_lines) = self.read_lines {
            let (head, rest) = source.parts();
            read_lines(path, head, rest, options)?
        } else if let Some(read_content) = self.read_content {
            read_content(path, &source.content()?, options)?
        } else {
            (self.read)(path, source.whole()?, options)?
        };
        self.noted(path, log, options)
    }

    /// A log with what is to be known of how its options were taken.
    fn noted(
        &self,
        path: &Path,
        mut log: ImportedLog,
        options: &LogOptions,
    ) -> Result<ImportedLog> {
        if !self.is_ros && (options.topics.is_some() || options.pose_topic.is_some()) {
            let what = self.what;
            let note = format!("topics have no effect: {} is {what}", path.display());
            log.account.note(note);
        }
        if !self.parts_runs && options.gap_m.is_some() && !options.poses_elsewhere {
            let (path, what) = (path.display(), self.what);
            let note =
                format!("the gap has no effect: {path} is {what}, whose runs stand as they are");
            log.account.note(note);
        }
        as_declared(path, log, options, self.selects_itself)
    }
}

/// A log with all that was said about it whatever its format, and with notes on what looks wrong about it.
///
/// # Errors
/// A usage error where an option names a sensor that it lacks.
pub(super) fn as_declared(
    path: &Path,
    log: ImportedLog,
    options: &LogOptions,
    is_selected: bool,
) -> Result<ImportedLog> {
    let ImportedLog {
        recording,
        mut account,
        odometry,
    } = log;
    let mut columns = recording.into_columns();
    if !is_selected {
        let selected = options.sensors.apply(&mut columns);
        selected.map_err(|fault| Error::usage(format!("{}: {fault}", path.display())))?;
    }
    declared::apply(&mut columns, options, &mut account).map_err(|e| e.in_file(path))?;
    let stays = (!options.poses_elsewhere).then_some(odometry);
    oddities::note(&columns, stays, &mut account);
    let recording = Recording::new(columns).map_err(|e| e.in_file(path))?;
    Ok(ImportedLog {
        recording,
        account,
        odometry,
    })
}

impl fmt::Debug for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Format").field(&self.name).finish()
    }
}

/// An error about a file that is no log: what it is instead, and what was expected.
pub(super) fn unreadable(path: &Path, what: &str) -> Error {
    let known = FORMATS.map(|format| format.what).join(", ");
    Error::file(
        path,
        format!("{what}; expected a log, plain, gzip, xz, bzip2 or zstd: {known}"),
    )
}

/// What bytes of no known format look like.
fn looks_like(bytes: &[u8]) -> &'static str {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return "nothing but blank space";
    }
    let first_line = bytes
        .split(|b| *b == b'\n')
        .find(|line| !line.starts_with(b"#") && !line.is_empty());
    let words: Vec<&[u8]> = first_line
        .unwrap_or_default()
        .split(|b| b.is_ascii_whitespace())
        .filter(|w| !w.is_empty())
        .take(13)
        .collect();
    let numeric = |w: &&[u8]| std::str::from_utf8(w).is_ok_and(|w| w.parse::<f64>().is_ok());
    let kind = words.first().copied().unwrap_or_default();
    match words.len() {
        8 if words.iter().all(numeric) => {
            "poses in TUM format without scans, which `--poses` joins to a log"
        }
        12 if words.iter().all(numeric) => {
            "poses in KITTI format without scans, which `--poses` joins to a log"
        }
        _ if [&b"VERTEX"[..], b"EDGE"]
            .iter()
            .any(|start| kind.starts_with(start)) =>
        {
            "a pose graph without scans, whose vertices `--poses` joins to a log"
        }
        _ => "not a log that is known here",
    }
}
