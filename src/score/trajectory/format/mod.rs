//! Files of poses: TUM, KITTI, CSV and pose graphs, guessed from their content; and TUM and CSV to write.

mod csv;
mod graph;
mod kitti;
mod lines;
mod tum;
mod write;

use super::{Pose3, Trajectory};
use crate::{
    error::{Error, Result},
    storage,
};
use std::{fmt, path::Path, str::FromStr};

pub use write::{OutputFormat, write};

/// A format that poses are read from.
///
/// - TUM: `stamp x y z qx qy qz qw` a line, separated by blanks; seconds, metres, a quaternion. Lines that begin with `#` are
///   comments.
/// - KITTI: twelve numbers a line, the upper three rows of the 4 × 4 matrix; no time stamps, which [`read_times`] reads from a
///   file of their own.
/// - CSV: a header with `x_m`, `y_m` (or `x`, `y`), optional `z_m`; for the time `time_s` (or `stamp`), which may be missing; for the
///   orientation `heading_rad` or `heading_deg` (or `yaw_…`), or `qx`, `qy`, `qz`, `qw`, which then count. Separated by
///   commas, semicolons or tabs. Other columns are passed over.
/// - g2o: `VERTEX_SE2 id x y theta`, `VERTEX2` (TORO) or `VERTEX_SE3:QUAT id x y z qx qy qz qw` lines, in the order of their numbers; no
///   time stamps. Edges are passed over.
///
/// ```
/// use ballmark::score::trajectory::Format;
/// let tum = b"# stamp x y z qx qy qz qw\n0.5 1 2 0 0 0 0 1\n";
/// let format = Format::of_content("est.tum".as_ref(), tum)?;
/// assert_eq!(format, Format::Tum);
/// let trajectory = format.read_bytes("est.tum".as_ref(), tum)?;
/// assert_eq!((trajectory.len(), trajectory.stamps()), (1, Some(&[0.5][..])));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// TUM RGB-D benchmark.
    Tum,
    /// KITTI odometry benchmark.
    Kitti,
    /// A table with a header.
    Csv,
    /// A pose graph of g2o or TORO.
    Graph,
}

/// What a format's reader gives: a place to name for each pose, stamps where there are, poses.
struct Rows {
    line: Vec<u64>,
    stamp_s: Option<Vec<f64>>,
    pose: Vec<Pose3>,
}

impl Format {
    /// What `--format` calls them.
    pub const NAMES: [&'static str; 4] = ["tum", "kitti", "csv", "g2o"];

    /// The format that some content is of, by its first line that is no comment: two words or more separated by commas,
    /// semicolons or tabs, the first of them no number, are the header of a table; eight numbers TUM, twelve KITTI.
    ///
    /// # Errors
    /// Where it is neither, or no text; the message says what was found.
    pub fn of_content(path: &Path, bytes: &[u8]) -> Result<Self> {
        let text = lines::text(path, bytes)?;
        let Some((number, line)) = lines::content(text).next() else {
            return Err(Error::file(
                path,
                "is empty; expected poses as TUM, KITTI, CSV or g2o",
            ));
        };
        let is_header = line.contains([',', ';', '\t'])
            && line
                .split([',', ';', '\t'])
                .all(|name| name.trim().parse::<f64>().is_err());
        if is_header {
            return Ok(Self::Csv);
        }
        if graph::is_of_graph(line) {
            return Ok(Self::Graph);
        }
        let count = line.split_ascii_whitespace().take(1000).count();
        match count {
            8 => Ok(Self::Tum),
            12 => Ok(Self::Kitti),
            _ => {
                let shown = lines::shown(line);
                let plural = if count == 1 { "word" } else { "words" };
                Err(Error::input(
                    path,
                    format!("line {number}"),
                    format!(
                        "{count} {plural}, `{shown}`; expected 8 numbers (TUM), 12 (KITTI), the header of a CSV table or the vertices of a graph"
                    ),
                ))
            }
        }
    }

    /// Reads content of this format; `path` is the trajectory's name and stands in messages.
    ///
    /// # Errors
    /// Where a line has more or fewer numbers than it should, a number is none or not finite, a coordinate lies beyond 10⁹ m, a
    /// quaternion has no length or one far from 1, a matrix is no rotation, or a stamp is not after the one before it. The message
    /// names the line.
    pub fn read_bytes(self, path: &Path, bytes: &[u8]) -> Result<Trajectory> {
        let text = lines::text(path, bytes)?;
        let rows = match self {
            Self::Tum => tum::read(path, text),
            Self::Kitti => kitti::read(path, text),
            Self::Csv => csv::read(path, text),
            Self::Graph => graph::read(path, text),
        }?;
        if rows.pose.is_empty() {
            return Err(Error::file(path, "holds no pose; expected at least one"));
        }
        if let Some(stamp_s) = &rows.stamp_s {
            let place = |k: usize| format!("line {}", rows.line[k]);
            if let Some((k, fault)) = super::poses::not_rising(stamp_s, place) {
                return Err(Error::input(path, format!("line {}", rows.line[k]), fault));
            }
        }
        Trajectory::new(path.display().to_string(), rows.stamp_s, rows.pose)
    }
}

impl FromStr for Format {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "tum" => Ok(Self::Tum),
            "kitti" => Ok(Self::Kitti),
            "csv" => Ok(Self::Csv),
            "g2o" => Ok(Self::Graph),
            _ => Err(Error::usage(format!(
                "format `{}`: expected one of {}",
                name.escape_debug(),
                Self::NAMES.join(", ")
            ))),
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tum => "tum",
            Self::Kitti => "kitti",
            Self::Csv => "csv",
            Self::Graph => "g2o",
        })
    }
}

/// Reads a file of poses, of this format or of the one that its content is of.
///
/// # Errors
/// Where it can't be read, or as [`Format::of_content`] and [`Format::read_bytes`].
pub fn read(path: impl AsRef<Path>, format: Option<Format>) -> Result<Trajectory> {
    let path = path.as_ref();
    let bytes = storage::read_file(path)?;
    let format = format.map_or_else(|| Format::of_content(path, &bytes), Ok)?;
    format.read_bytes(path, &bytes)
}

/// Reads a file of time stamps, one number a line, as KITTI has them beside its poses.
///
/// # Errors
/// Where it can't be read, a line holds anything else, or a stamp is not after the one before it.
pub fn read_times(path: impl AsRef<Path>) -> Result<Vec<f64>> {
    let path = path.as_ref();
    let bytes = storage::read_file(path)?;
    let text = lines::text(path, &bytes)?;
    let (line, stamp_s) = lines::rows(path, text, |line| {
        let [stamp_s] = lines::numbers(line, ["stamp"], "times")?;
        Ok(stamp_s)
    })?;
    if stamp_s.is_empty() {
        return Err(Error::file(path, "holds no time; expected one a line"));
    }
    let place = |k: usize| format!("line {}", line[k]);
    match super::poses::not_rising(&stamp_s, place) {
        Some((k, fault)) => Err(Error::input(path, place(k), fault)),
        None => Ok(stamp_s),
    }
}

#[cfg(test)]
mod tests;
