//! Poses as a file: TUM or CSV.

use crate::{
    error::{Error, Result},
    score::trajectory::Trajectory,
    storage,
};
use std::{fmt::Write as _, path::Path};

/// A format that poses are written in; numbers have all their digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputFormat {
    /// `stamp x y z qx qy qz qw`, separated by single blanks as `evo` wants them.
    Tum,
    /// Columns `time_s,x_m,y_m,z_m,qx,qy,qz,qw,heading_rad`; without `time_s` where there are no stamps.
    Csv,
}

impl OutputFormat {
    /// The format that a file's ending stands for: `.tum` or `.txt`, `.csv`.
    ///
    /// # Errors
    /// A usage error where it stands for none.
    pub fn of_ending(path: &Path) -> Result<Self> {
        let ending = path.extension().map(|ending| ending.to_ascii_lowercase());
        match ending.as_deref().and_then(std::ffi::OsStr::to_str) {
            Some("tum" | "txt") => Ok(Self::Tum),
            Some("csv") => Ok(Self::Csv),
            _ => Err(Error::usage(format!(
                "{}: expected a name that ends in .tum, .txt or .csv",
                path.display()
            ))),
        }
    }

    /// The trajectory as text.
    ///
    /// # Errors
    /// A usage error where TUM is asked of poses without time stamps.
    pub fn text(self, trajectory: &Trajectory) -> Result<String> {
        let stamps = trajectory.stamps();
        let (separator, mut text) = match self {
            Self::Tum if stamps.is_none() => {
                return Err(Error::usage(format!(
                    "{} has no time stamps, which TUM files need: expected --times, or a name that ends in .csv",
                    trajectory.name()
                )));
            }
            Self::Tum => (' ', String::new()),
            Self::Csv => {
                let time = stamps.map_or("", |_| "time_s,");
                (',', format!("{time}x_m,y_m,z_m,qx,qy,qz,qw,heading_rad\n"))
            }
        };
        for (k, pose) in trajectory.poses().iter().enumerate() {
            let [qx, qy, qz, qw] = pose.quaternion();
            let [x, y, z] = pose.position_m.into();
            let heading = matches!(self, Self::Csv).then(|| pose.to_plane().heading_rad);
            let numbers = stamps
                .map(|stamps| stamps[k])
                .into_iter()
                .chain([x, y, z, qx, qy, qz, qw])
                .chain(heading);
            for (at, number) in numbers.enumerate() {
                if at > 0 {
                    text.push(separator);
                }
                let _ = write!(text, "{}", number + 0.0); // −0 is 0
            }
            text.push('\n');
        }
        Ok(text)
    }
}

/// Writes a trajectory, whole or not at all, in the format that the file's ending stands for.
///
/// # Errors
/// As [`OutputFormat::of_ending`] and [`OutputFormat::text`], and where the file can't be written.
pub fn write(path: &Path, trajectory: &Trajectory) -> Result<()> {
    let text = OutputFormat::of_ending(path)?.text(trajectory)?;
    storage::write_file(path, |out| out.write_all(text.as_bytes()))
}
