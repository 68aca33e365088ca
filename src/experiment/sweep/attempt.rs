//! A cell that runs: the command itself in a process of its own, in a scratch folder, and what it leaves behind.

use super::{
    cell::{Cell, VERSION, canonical, name},
    command::CONFIGURATION,
    folder::Sweep,
    inputs::{Placed, Stamp},
    lock::{Lock, host},
    plan::described,
    scratch::Scratch,
};
use crate::{
    error::{Error, Result},
    experiment::child,
    storage,
};
use serde_json::{Value, json};
use std::{
    ffi::OsString,
    fs::{self, File, OpenOptions},
    io::Write,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    time::{Duration, Instant},
};

/// A flag of the command of a cell, before the number of the process that started it: it is to end when that does.
pub const ENDS_WITH_PARENT: &str = "--ends-with-parent";
/// How often cells that run are looked at.
pub(super) const LOOKED_AT: Duration = Duration::from_millis(2);
/// And how often their memory.
const MEASURED_EVERY: Duration = Duration::from_millis(20);
/// Lines of standard error that are kept of a cell that failed.
const LAST_LINES: usize = 20;
/// Exit status of a command that is done, but lost something.
const LOSSY: i32 = 3;

/// How cells are run.
#[derive(Debug, Clone, Default)]
pub struct Runner {
    /// The program and what stands before a command's name.
    pub program: Vec<OsString>,
    /// A folder where data is looked for by its SHA-256 before where it was planned from.
    pub cache: Option<PathBuf>,
    /// Threads of a cell; not said: as the environment says.
    pub threads: Option<usize>,
    /// A folder that a cell's files are kept in: it is run even where it has a result, which stays the same.
    pub keep: Option<PathBuf>,
}

/// What came of an attempt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ended {
    /// There is a result.
    Done,
    /// There is none, and why.
    Failed(String),
}

/// Whether a cell can be run now.
#[derive(Debug)]
pub enum Started {
    /// It runs.
    Running(Box<Attempt>),
    /// It has a result.
    DoneBefore,
    /// Another process runs it.
    Elsewhere,
}

/// A cell that runs. Ended, with all that it started, when dropped.
#[derive(Debug)]
pub struct Attempt {
    cell: Cell,
    child: Child,
    scratch: Scratch,
    placed: Vec<Placed>,
    keep: Option<PathBuf>,
    begun: Instant,
    peak_bytes: u64,
    measured: Option<Instant>,
    is_over: bool,
    // Last: given back when all else is cleared away.
    _lock: Lock,
}

impl Attempt {
    /// Starts a cell, unless it is done (and its files are not to be kept) or runs elsewhere.
    ///
    /// # Errors
    /// Where the plan is of another version or was changed, its data is no longer what was planned, or the command can't be started.
    pub fn start(sweep: &Sweep, cell: &Cell, runner: &Runner) -> Result<Started> {
        let is_done = || runner.keep.is_none() && sweep.result(&cell.name).is_file();
        if is_done() {
            return Ok(Started::DoneBefore);
        }
        let Some(lock) = Lock::take(&sweep.lock(&cell.name))? else {
            return Ok(Started::Elsewhere);
        };
        // It may have ended just before.
        if is_done() {
            return Ok(Started::DoneBefore);
        }
        // Whichever of the two this attempt won't write.
        storage::clear_away(&sweep.result(&cell.name));
        storage::clear_away(&sweep.failure(&cell.name));
        let started = Self::with_lock(sweep, cell, runner, lock);
        if let Err(fault) = &started {
            // So that it is found among those that failed, wherever it was started.
            let _ = write_failure(sweep, cell, &fault.to_string());
        }
        started.map(|attempt| Started::Running(Box::new(attempt)))
    }

    fn with_lock(sweep: &Sweep, cell: &Cell, runner: &Runner, lock: Lock) -> Result<Self> {
        let plan = &sweep.plan;
        if plan.version != VERSION {
            return Err(Error::file(
                sweep.folder(),
                format!(
                    "planned by ballmark {}, and this is {VERSION}; plan it anew",
                    plan.version
                ),
            ));
        }
        let command = plan.base.command;
        let keys = cell.keys.iter().map(|(key, value)| (key.as_str(), value));
        let call = plan.base.call(keys)?;
        let mut resolved = command.resolved(&call.text)?;
        if let Some(seed) = cell.seed {
            command.put_seed(&mut resolved, seed);
        }
        if name(command, &resolved, &call) != cell.name {
            return Err(Error::file(
                sweep.folder(),
                format!(
                    "cell {} is not what its name says: plan.json or cells.jsonl was changed; plan it anew",
                    cell.name
                ),
            ));
        }
        let scratch = Scratch::make(sweep, &cell.name)?;
        let path = scratch.path.as_path();
        let mut placed = Vec::new();
        for number in &cell.data {
            let input = plan.data.get(*number);
            let input = input.ok_or_else(|| {
                Error::file(
                    sweep.folder(),
                    format!("cell {}: no data {number}; plan it anew", cell.name),
                )
            })?;
            placed.extend(input.place(path, runner.cache.as_deref())?);
        }
        if command.is_configured() {
            storage::write_file(&path.join(CONFIGURATION), |out| {
                out.write_all(call.text.as_bytes())
            })?;
        }
        let printed = |name: &str| {
            let file = path.join(name);
            File::create(&file).map_err(|e| Error::io("cannot write", &file, e))
        };
        let (first, before) = runner
            .program
            .split_first()
            .ok_or_else(|| Error::work("no program to run cells with"))?;
        let mut process = Command::new(first);
        process
            .args(before)
            .args([ENDS_WITH_PARENT, &std::process::id().to_string()])
            .args(command.arguments(&call.options, cell.seed))
            .current_dir(path)
            .stdin(Stdio::null())
            .stdout(printed("stdout")?)
            .stderr(printed("stderr")?);
        if let Some(threads) = runner.threads {
            process.env("RAYON_NUM_THREADS", threads.to_string());
        }
        child::in_own_group(&mut process);
        let child = process
            .spawn()
            .map_err(|e| Error::io("cannot run", Path::new(first), e))?;
        Ok(Self {
            cell: cell.clone(),
            child,
            scratch,
            placed,
            keep: runner.keep.clone(),
            begun: Instant::now(),
            peak_bytes: 0,
            measured: None,
            is_over: false,
            _lock: lock,
        })
    }

    /// The cell.
    pub fn cell(&self) -> &Cell {
        &self.cell
    }

    /// Most memory that it was seen to take, in bytes; 0 where the system doesn't say.
    pub fn peak_bytes(&self) -> u64 {
        self.peak_bytes
    }

    /// Memory that it takes now, in bytes; likewise.
    pub(super) fn resident_bytes(&self) -> u64 {
        status_bytes(self.child.id(), "VmRSS:")
    }

    /// Looks at it. Where it has ended, its result is written, or why it failed.
    ///
    /// # Errors
    /// Where it can't be waited for, or neither can be written.
    pub fn poll(&mut self, sweep: &Sweep) -> Result<Option<Ended>> {
        if self
            .measured
            .is_none_or(|at| at.elapsed() >= MEASURED_EVERY)
        {
            self.measured = Some(Instant::now());
            let most = status_bytes(self.child.id(), "VmHWM:");
            self.peak_bytes = self.peak_bytes.max(most);
        }
        let ended = self.child.try_wait();
        match ended.map_err(|e| Error::io("cannot wait for", &self.cell.name, e))? {
            None => Ok(None),
            Some(status) => self.finish(sweep, status).map(Some),
        }
    }

    /// Waits until it has ended, or until `is_cancelled`; none then.
    ///
    /// # Errors
    /// As [`Attempt::poll`].
    pub fn wait(mut self, sweep: &Sweep, is_cancelled: &dyn Fn() -> bool) -> Result<Option<Ended>> {
        loop {
            if let Some(ended) = self.poll(sweep)? {
                return Ok(Some(ended));
            }
            if is_cancelled() {
                return Ok(None);
            }
            std::thread::sleep(LOOKED_AT);
        }
    }

    fn finish(&mut self, sweep: &Sweep, status: ExitStatus) -> Result<Ended> {
        self.is_over = true;
        let seconds = self.begun.elapsed().as_secs_f64();
        let written = self.record(status).and_then(|(lossy, record)| {
            let path = sweep.result(&self.cell.name);
            storage::make_folder(&path.with_file_name(""))?;
            let text = self.result(sweep, lossy, record);
            storage::write_file(&path, |out| out.write_all(text.as_bytes()))
        });
        let ended = match written {
            Ok(()) => {
                // Of an earlier attempt.
                let _ = fs::remove_file(sweep.failure(&self.cell.name));
                Ended::Done
            }
            Err(fault) => {
                let last = child::last_lines(&self.scratch.path.join("stderr"), LAST_LINES);
                let why = match last.is_empty() {
                    true => fault.to_string(),
                    false => format!(
                        "{fault}\nlast lines of standard error:\n{}",
                        last.join("\n")
                    ),
                };
                write_failure(sweep, &self.cell, &why)?;
                Ended::Failed(why)
            }
        };
        self.note_time(sweep, seconds, ended == Ended::Done);
        if let Some(keep) = &self.keep {
            self.scratch.keep_as(keep)?;
        }
        Ok(ended)
    }

    /// What the command printed, and whether it lost something.
    fn record(&self, status: ExitStatus) -> Result<(bool, Value)> {
        let lossy = match status.code() {
            Some(0) => false,
            Some(LOSSY) => true,
            Some(code) => return Err(Error::work(format!("ended with exit status {code}"))),
            None => return Err(Error::work(format!("was ended: {status}"))),
        };
        for (path, before) in &self.placed {
            if Stamp::of(path)? != *before {
                return Err(Error::file(
                    path,
                    "was written to while the cell ran; expected data that stays",
                ));
            }
        }
        let printed = storage::read_file(&self.scratch.path.join("stdout"))?;
        let record = serde_json::from_slice(&printed);
        let record = record.map_err(|e| Error::work(format!("printed no JSON object: {e}")))?;
        Ok((lossy, record))
    }

    /// A cell's result: the same bytes wherever it ran. Times stand apart.
    fn result(&self, sweep: &Sweep, lossy: bool, mut record: Value) -> String {
        take_times_away(&mut record);
        let data = self.cell.data.iter();
        let data = data.filter_map(|number| sweep.plan.data.get(*number));
        let data: Vec<&str> = data.map(|input| input.name.as_str()).collect();
        let result = json!({
            "cell": self.cell.name,
            "version": VERSION,
            "command": sweep.plan.base.command,
            "keys": self.cell.keys,
            "seed": self.cell.seed,
            "data": data,
            "lossy": lossy,
            "record": record,
        });
        let mut text = String::new();
        canonical(&result, &mut text);
        text + "\n"
    }

    /// A line in the times. That it can't be written is no fault: nothing depends on it.
    fn note_time(&self, sweep: &Sweep, seconds: f64, is_done: bool) {
        let line = json!({
            "cell": self.cell.name,
            "done": is_done,
            "seconds": seconds,
            "peak_bytes": self.peak_bytes,
            "host": host(),
        });
        let file = OpenOptions::new()
            .append(true)
            .create(true)
            .open(sweep.times());
        if let Ok(mut file) = file {
            let _ = file.write_all(format!("{line}\n").as_bytes()); // at once, so that lines of two processes don't mix
        }
    }
}

impl Drop for Attempt {
    fn drop(&mut self) {
        if !self.is_over {
            child::end(&mut self.child);
            let _ = self.child.wait();
        }
    }
}

/// Writes why a cell failed.
fn write_failure(sweep: &Sweep, cell: &Cell, why: &str) -> Result<()> {
    let path = sweep.failure(&cell.name);
    storage::make_folder(&path.with_file_name(""))?;
    let described = described(&cell.keys, cell.seed);
    let text = format!("cell {}: {described}\n{why}\n", cell.name);
    storage::write_file(&path, |out| out.write_all(text.as_bytes()))
}

/// Takes every `timing` out of a record: what differs from one call to the next.
fn take_times_away(record: &mut Value) {
    match record {
        Value::Object(keys) => {
            keys.remove("timing");
            keys.values_mut().for_each(take_times_away);
        }
        Value::Array(values) => values.iter_mut().for_each(take_times_away),
        _ => {}
    }
}

/// A figure of a process's memory in bytes; 0 where the system doesn't say.
fn status_bytes(process: u32, figure: &str) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(figure));
    let kib = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    kib.unwrap_or(0) * 1024
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_stand_apart() {
        let mut record = json!({ "a": 1, "timing": { "seconds": 2 }, "all": [{ "timing": 3, "b": { "timing": {} } }] });
        take_times_away(&mut record);
        assert_eq!(record, json!({ "a": 1, "all": [{ "b": {} }] }));
    }
}
