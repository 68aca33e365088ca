//! Runs somebody else's localiser on one trial, within its time.

use super::{config::ExternalConfig, trial_files::Start};
use crate::{
    error::{Error, Result},
    experiment::child,
    geometry::Pose,
    recording::{
        Recording,
        write::{Format, write},
    },
};
use std::{
    fs::{self, File},
    path::Path,
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

/// How often a program that runs is looked at.
const LOOKED_AT: Duration = Duration::from_millis(5);
/// Letters of that line that a message has.
const SHOWN: usize = 300;

/// A trial to be answered.
pub(super) struct Asked<'a> {
    pub name: &'a str,
    pub start: Start,
    /// Its first pose, where it starts at a known place.
    pub pose: Pose,
    pub observed: &'a Recording,
    pub seed: u64,
}

/// Runs the command for a trial; its answers then lie in that folder.
///
/// # Errors
/// Where it can't be started, takes too long or fails; the message has the last line that it printed.
pub(super) fn answer(config: &ExternalConfig, asked: &Asked, folder: &Path) -> Result<()> {
    let path = |ending: &str| folder.join(format!("{}.{ending}", asked.name));
    // What it answered before, with another seed, must not pass for an answer now.
    for ending in ["tum", "csv"] {
        let before = path(ending);
        if before.exists() {
            fs::remove_file(&before).map_err(|e| Error::io("cannot remove", &before, e))?;
        }
    }
    let given = tempfile::tempdir_in(folder)
        .map_err(|e| Error::io("cannot make a folder in", folder, e))?;
    let mut words = config.command.clone();
    for word in &mut words {
        for format in Format::ALL {
            let placeholder = format!("{{trial_{}}}", format.name());
            if word.contains(&placeholder) {
                let file = given
                    .path()
                    .join(format!("{}.{}", asked.name, format.ending()));
                if !file.exists() {
                    write(format, &file, asked.observed, None)?;
                }
                *word = word.replace(&placeholder, &file.to_string_lossy());
            }
        }
        for (placeholder, value) in [
            ("{answer_tum}", path("tum").to_string_lossy().into_owned()),
            ("{answer_csv}", path("csv").to_string_lossy().into_owned()),
            ("{trial}", asked.name.to_string()),
            ("{seed}", asked.seed.to_string()),
            ("{particles}", config.particles.to_string()),
            (
                "{start}",
                match asked.start {
                    Start::Unknown => Start::Unknown.word().to_string(),
                    Start::Known => {
                        let pose = &asked.pose;
                        format!("{},{},{}", pose.x_m, pose.y_m, pose.heading_rad)
                    }
                },
            ),
        ] {
            *word = word.replace(placeholder, &value);
        }
    }
    let printed = given.path().join("printed");
    let file = File::create(&printed).map_err(|e| Error::io("cannot write", &printed, e))?;
    let both = file
        .try_clone()
        .map_err(|e| Error::io("cannot write", &printed, e))?;
    let mut command = Command::new(&words[0]);
    command
        .args(&words[1..])
        .current_dir(&config.folder)
        .stdin(Stdio::null())
        .stdout(file)
        .stderr(both);
    child::in_own_group(&mut command);
    let mut child = command.spawn().map_err(|e| {
        Error::work(format!(
            "{}: command `{}`: {e}; expected a program in the PATH, or its path from the configuration's folder",
            asked.name, words[0]
        ))
    })?;
    let ended = ended_within(&mut child, Duration::from_secs_f64(config.timeout_s));
    match ended.map_err(|e| Error::io("cannot wait for", &words[0], e))? {
        None => Err(Error::work(format!(
            "{}: command `{}` had not ended after timeout_s = {} s{}",
            asked.name,
            words[0],
            config.timeout_s,
            last_words(&printed)
        ))),
        Some(status) if !status.success() => Err(Error::work(format!(
            "{}: command `{}` failed ({status}){}",
            asked.name,
            words[0],
            last_words(&printed)
        ))),
        Some(_) => Ok(()),
    }
}

/// How the program ended; none where it was ended, having taken too long.
fn ended_within(child: &mut Child, limit: Duration) -> std::io::Result<Option<ExitStatus>> {
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if begun.elapsed() >= limit {
            child::end(child);
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(LOOKED_AT.min(limit));
    }
}

/// The last line that a program printed, to follow a message.
fn last_words(printed: &Path) -> String {
    let last = child::last_lines(printed, 1).pop();
    last.map_or(String::new(), |line| {
        let line: String = line.trim().chars().take(SHOWN).collect();
        format!("; it last printed `{}`", line.escape_debug())
    })
}
