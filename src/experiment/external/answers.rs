//! Answers of somebody else's localiser from files: poses, poses with covariances, particles, or the belief of a grid.
//!
//! `NAME.tum` holds a pose a snapshot (`time x y z qx qy qz qw`). `NAME.csv` has a header: `time_s`, `x_m`, `y_m` and perhaps
//! `heading_rad` (or `heading_deg`), and where there is a belief either `xx_m2`, `xy_m2`, `yy_m2` (the covariance of the place, a row a snapshot),
//! `weight` (particles, several rows a snapshot, any positive sum) or `probability` (cells, several rows a snapshot, which sum to 1).

mod belief;
mod table;

use super::config::ExternalConfig;
use crate::{
    error::{Error, Result},
    localiser::{Estimate, Step},
    score::trajectory::{self, Format},
};
use belief::Said;
use std::path::{Path, PathBuf};

/// Answers to a trial whose snapshots were taken at these times, one each.
///
/// # Errors
/// Where there is no file of that name in the folder, a line of it makes no sense, or a snapshot has no answer.
pub(super) fn read(
    folder: &Path,
    name: &str,
    times_s: &[f64],
    config: &ExternalConfig,
) -> Result<Vec<Step>> {
    let [poses, table] = ["tum", "csv"].map(|ending| folder.join(format!("{name}.{ending}")));
    let said = match (poses.is_file(), table.is_file()) {
        (false, false) => {
            return Err(Error::work(format!(
                "no answer to {name}; expected {} or .csv",
                poses.display()
            )));
        }
        (true, false) => poses_of(&poses)?,
        (false, true) => table::read(&table)?,
        (true, true) => {
            let (answers, beliefs) = (poses_of(&poses)?, table::read(&table)?);
            if let Some(bare) = beliefs.iter().find(|said| said.step.posterior.is_empty()) {
                return Err(Error::file(
                    &table,
                    format!(
                        "no belief at {} s; expected covariances, weights or probabilities beside {}",
                        bare.time_s,
                        poses.display()
                    ),
                ));
            }
            let answers = at_times(&poses, name, answers, times_s, config)?;
            let beliefs = at_times(&table, name, beliefs, times_s, config)?;
            let both = answers.into_iter().zip(beliefs);
            return Ok(both
                .map(|(answer, belief)| Step {
                    posterior: belief.posterior,
                    ..answer
                })
                .collect());
        }
    };
    let file = if table.is_file() { table } else { poses };
    at_times(&file, name, said, times_s, config)
}

/// What was said nearest to each of these times.
fn at_times(
    file: &Path,
    name: &str,
    said: Vec<Said>,
    times_s: &[f64],
    config: &ExternalConfig,
) -> Result<Vec<Step>> {
    let (first_s, last_s) = match times_s {
        [first, .., last] => (*first, *last),
        [one] => (*one, *one),
        [] => return Ok(Vec::new()),
    };
    let (from, to) = match (said.first(), said.last()) {
        (Some(first), Some(last)) => (first.time_s, last.time_s),
        _ => {
            return Err(Error::file(
                file,
                "holds no answer; expected one a snapshot",
            ));
        }
    };
    if from > last_s + config.tolerance_s || to < first_s - config.tolerance_s {
        return Err(Error::file(
            file,
            format!(
                "its time stamps go from {from} to {to} s; expected those of {name}, from {first_s} to {last_s} s"
            ),
        ));
    }
    let mut steps = Vec::with_capacity(times_s.len());
    for (snapshot, &time_s) in times_s.iter().enumerate() {
        let after = said.partition_point(|said| said.time_s < time_s);
        let candidates = [after.checked_sub(1), Some(after)];
        let near = candidates.into_iter().flatten().filter_map(|k| said.get(k));
        let off = |said: &&Said| (said.time_s - time_s).abs();
        let nearest = near.min_by(|a, b| off(a).total_cmp(&off(b)));
        match nearest {
            // Rounded stamps must not decide.
            Some(said) if off(&said) <= config.tolerance_s + 1e-9 => steps.push(said.step.clone()),
            _ if config.may_be_silent => steps.push(Step::default()),
            nearest => {
                let nearest = nearest.map_or(String::new(), |said| {
                    format!("; the nearest is at {} s", said.time_s)
                });
                return Err(Error::file(
                    file,
                    format!(
                        "no answer to snapshot {} of {}, at {time_s} s{nearest}; expected one within tolerance_s = {} s, or \
                         may_be_silent = true",
                        snapshot + 1,
                        times_s.len(),
                        config.tolerance_s
                    ),
                ));
            }
        }
    }
    Ok(steps)
}

fn poses_of(file: &Path) -> Result<Vec<Said>> {
    let trajectory = trajectory::read(file, Some(Format::Tum))?;
    let stamps = trajectory.stamps().unwrap_or_default(); // TUM has them
    let said = stamps.iter().zip(trajectory.poses());
    Ok(said
        .map(|(&time_s, pose)| {
            let pose = pose.to_plane();
            Said {
                time_s,
                step: Step {
                    estimate: Some(Estimate::Place([pose.x_m, pose.y_m])),
                    heading_rad: Some(pose.heading_rad),
                    posterior: Vec::new(),
                },
            }
        })
        .collect())
}

/// Files of a folder that are answers to no trial of these names: what a person should be told of.
///
/// # Errors
/// Where the folder can't be read.
pub(super) fn strangers(folder: &Path, names: &[String]) -> Result<Vec<PathBuf>> {
    let unreadable = |e| Error::io("cannot read the folder", folder, e);
    let mut strangers = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let is_answer = path
            .extension()
            .is_some_and(|ending| ending == "tum" || ending == "csv");
        let stem = path
            .file_stem()
            .map(|stem| stem.to_string_lossy().into_owned());
        if is_answer && !stem.is_some_and(|stem| names.contains(&stem)) {
            strangers.push(path);
        }
    }
    strangers.sort();
    Ok(strangers)
}

#[cfg(test)]
mod tests;
