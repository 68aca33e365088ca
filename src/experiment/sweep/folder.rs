//! A sweep's folder: the plan, and one file a result.
//!
//! ```text
//! plan.json              what holds for all cells
//! cells.jsonl            a line a cell, in the order of their names
//! sweep.toml             the sweep file as it was read
//! run.slurm              the same work as a Slurm array
//! results/ab/abcd….json  a cell's result, written whole
//! failed/ab/abcd….txt    why a cell failed, with its last lines
//! locks/abcd…            while a cell runs
//! times.jsonl            seconds and memory of every attempt
//! ```
//!
//! Results lie in 256 folders by the first two digits of their cells' names: 100,000 of them are 400 a folder.

use super::{
    cell::{Cell, is_name},
    plan::{Plan, Planned},
};
use crate::{
    error::{Error, Result},
    storage,
};
use std::{
    collections::HashSet,
    fs::File,
    io::{BufRead, BufReader, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
};

const PLAN: &str = "plan.json";
const CELLS: &str = "cells.jsonl";

/// A sweep that was planned, and what has come of it so far.
#[derive(Debug, Clone)]
pub struct Sweep {
    folder: PathBuf,
    /// What holds for all cells.
    pub plan: Plan,
}

impl Sweep {
    /// Writes a plan to a folder, which is made where it isn't there. Results that lie there stay: cells of the same name are done.
    ///
    /// # Errors
    /// Where the folder holds something else, or can't be written to.
    pub fn create(folder: &Path, planned: &Planned, text: &[u8]) -> Result<Self> {
        let holds_something = folder.read_dir().is_ok_and(|mut all| all.next().is_some());
        if holds_something && !folder.join(PLAN).exists() {
            let fault = "holds something that is no sweep; expected another folder";
            return Err(Error::file(folder, fault));
        }
        let json = |e: serde_json::Error| Error::work(format!("plan: {e}"));
        let plan = serde_json::to_string_pretty(&planned.plan).map_err(json)? + "\n";
        let mut lines = String::new();
        for cell in &planned.cells {
            lines.push_str(&serde_json::to_string(cell).map_err(json)?);
            lines.push('\n');
        }
        storage::make_folder(folder)?;
        let write = |name: &str, content: &[u8]| {
            storage::write_file(&folder.join(name), |out| out.write_all(content))
        };
        write("sweep.toml", text)?;
        write(CELLS, lines.as_bytes())?;
        write(PLAN, plan.as_bytes())?;
        Ok(Self {
            folder: folder.to_path_buf(),
            plan: planned.plan.clone(),
        })
    }

    /// Opens a folder that `ballmark sweep plan` made.
    ///
    /// # Errors
    /// Where there is no plan in it, or it can't be read.
    pub fn open(folder: &Path) -> Result<Self> {
        let path = folder.join(PLAN);
        if !path.is_file() {
            let fault = "no plan.json in it; expected a folder that `ballmark sweep plan` made";
            return Err(Error::file(folder, fault));
        }
        let plan = serde_json::from_slice(&storage::read_file(&path)?);
        let plan = plan.map_err(|e| {
            Error::file(
                &path,
                format!("{e}; expected what `ballmark sweep plan` of this version wrote"),
            )
        })?;
        Ok(Self {
            folder: folder.to_path_buf(),
            plan,
        })
    }

    /// Where it lies.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// All cells, by name.
    ///
    /// # Errors
    /// Where they can't be read.
    pub fn cells(&self) -> Result<Vec<Cell>> {
        let path = self.folder.join(CELLS);
        let content = storage::read_file(&path)?;
        let lines = content.split(|byte| *byte == b'\n');
        let lines = lines.enumerate().filter(|(_, line)| !line.is_empty());
        let cells = lines.map(|(number, line)| parsed(&path, number + 1, line));
        cells.collect()
    }

    /// A cell by its name. Looked for by halves in the file, whose lines are in the order of names, so that it takes no longer where there are
    /// many.
    ///
    /// # Errors
    /// Where there is none of that name.
    pub fn cell(&self, name: &str) -> Result<Cell> {
        let path = self.folder.join(CELLS);
        let unreadable = |e| Error::io("cannot read", &path, e);
        let mut file = BufReader::new(File::open(&path).map_err(unreadable)?);
        let (mut low, mut high) = (0, file.seek(SeekFrom::End(0)).map_err(unreadable)?);
        // The line sought begins at `low` or after it, and before `high`.
        while low < high {
            let middle = low + (high - low) / 2;
            let mut line = Vec::new();
            let mut start = middle;
            file.seek(SeekFrom::Start(middle.saturating_sub(1)))
                .map_err(unreadable)?;
            if middle > 0 {
                start = middle - 1 + read_line(&mut file, &mut line).map_err(unreadable)?;
            }
            line.clear();
            let length = read_line(&mut file, &mut line).map_err(unreadable)?;
            if start >= high || length == 0 {
                high = middle;
                continue;
            }
            let found = parsed(&path, 0, &line)?;
            match found.name.as_str().cmp(name) {
                std::cmp::Ordering::Equal => return Ok(found),
                std::cmp::Ordering::Less => low = start + length,
                std::cmp::Ordering::Greater => high = middle,
            }
        }
        Err(Error::usage(format!(
            "{}: no cell `{}`; expected one of {CELLS}",
            self.folder.display(),
            name.escape_debug()
        )))
    }

    /// Where a cell's result goes.
    pub fn result(&self, name: &str) -> PathBuf {
        self.sharded("results", name, "json")
    }

    /// Where it goes why a cell failed.
    pub fn failure(&self, name: &str) -> PathBuf {
        self.sharded("failed", name, "txt")
    }

    pub(super) fn lock(&self, name: &str) -> PathBuf {
        self.folder.join("locks").join(name)
    }

    pub(super) fn times(&self) -> PathBuf {
        self.folder.join("times.jsonl")
    }

    fn sharded(&self, kind: &str, name: &str, ending: &str) -> PathBuf {
        let shard = name.get(..2).unwrap_or(name);
        let folder = self.folder.join(kind).join(shard);
        folder.join(format!("{name}.{ending}"))
    }

    /// Names of all cells that have a result, whether the plan has them or not.
    ///
    /// # Errors
    /// Where a folder can't be read.
    pub fn done(&self) -> Result<HashSet<String>> {
        self.names("results", ".json")
    }

    /// Names of all cells that failed when they were last tried.
    ///
    /// # Errors
    /// Where a folder can't be read.
    pub fn failed(&self) -> Result<HashSet<String>> {
        self.names("failed", ".txt")
    }

    fn names(&self, kind: &str, ending: &str) -> Result<HashSet<String>> {
        let mut all = HashSet::new();
        for shard in entries(&self.folder.join(kind))? {
            for file in entries(&self.folder.join(kind).join(shard))? {
                // What is being written has another name.
                let name = file.strip_suffix(ending).filter(|name| is_name(name));
                all.extend(name.map(String::from));
            }
        }
        Ok(all)
    }

    /// Names of all cells that have a lock, held or left behind.
    pub(super) fn locked(&self) -> Result<Vec<String>> {
        let names = entries(&self.folder.join("locks"))?;
        Ok(names.into_iter().filter(|name| is_name(name)).collect())
    }
}

/// Names of what is in a folder; none where it isn't there.
fn entries(folder: &Path) -> Result<Vec<String>> {
    let unreadable = |e| Error::io("cannot read", folder, e);
    let entries = match folder.read_dir() {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(unreadable(e)),
        Ok(entries) => entries,
    };
    let name = |entry: std::io::Result<std::fs::DirEntry>| {
        Ok(entry
            .map_err(unreadable)?
            .file_name()
            .to_string_lossy()
            .into_owned())
    };
    entries.map(name).collect()
}

fn parsed(path: &Path, number: usize, line: &[u8]) -> Result<Cell> {
    serde_json::from_slice(line).map_err(|e| {
        let place = match number {
            0 => "a line".to_string(),
            number => format!("line {number}"),
        };
        Error::input(path, place, format!("{e}; plan the sweep anew"))
    })
}

/// Longest line of a cell: keys and values of a sweep file.
const LONGEST_LINE: u64 = 1 << 20;

fn read_line(file: &mut BufReader<File>, line: &mut Vec<u8>) -> std::io::Result<u64> {
    let read = file.by_ref().take(LONGEST_LINE).read_until(b'\n', line)?;
    Ok(read as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::sweep::{Base, Command};
    use serde_json::Map;

    fn planned(count: usize) -> Planned {
        let cell = |number: usize| Cell {
            name: storage::sha256(number.to_string().as_bytes())[..16].to_string(),
            number,
            keys: Map::from_iter([("k".to_string(), "x".repeat(number % 40).into())]),
            seed: None,
            data: Vec::new(),
        };
        let mut cells: Vec<Cell> = (0..count).map(cell).collect();
        cells.sort_by(|a, b| a.name.cmp(&b.name));
        let base = Base {
            command: Command::Train,
            config: toml::Table::new(),
            options: Map::new(),
        };
        let plan = Plan {
            version: "0".into(),
            cells: count,
            base,
            keys: vec!["k".into()],
            data: Vec::new(),
            metrics: Vec::new(),
            baseline: Map::new(),
        };
        Planned { plan, cells }
    }

    #[test]
    fn every_cell_is_found_by_its_name() {
        for count in [0, 1, 2, 3, 100] {
            let folder = tempfile::tempdir().unwrap();
            let planned = planned(count);
            let sweep = Sweep::create(folder.path(), &planned, b"").unwrap();
            assert_eq!(sweep.cells().unwrap(), planned.cells);
            assert_eq!(Sweep::open(folder.path()).unwrap().plan, planned.plan);
            for cell in &planned.cells {
                assert_eq!(sweep.cell(&cell.name).unwrap(), *cell);
            }
            for other in [
                "0000000000000000",
                "8888888888888888",
                "ffffffffffffffff",
                "",
            ] {
                assert!(sweep.cell(other).unwrap_err().is_usage());
            }
        }
    }

    #[test]
    fn only_whole_results_count() {
        let folder = tempfile::tempdir().unwrap();
        let sweep = Sweep::create(folder.path(), &planned(2), b"").unwrap();
        assert!(sweep.done().unwrap().is_empty());
        let name = "00ff00ff00ff00ff";
        let path = sweep.result(name);
        assert!(
            path.ends_with("results/00/00ff00ff00ff00ff.json"),
            "{path:?}"
        );
        storage::make_folder(path.parent().unwrap()).unwrap();
        std::fs::write(
            path.with_file_name(format!(".{name}.json.tmpAb3dE9")),
            "half",
        )
        .unwrap();
        assert!(sweep.done().unwrap().is_empty());
        std::fs::write(&path, "{}").unwrap();
        assert_eq!(sweep.done().unwrap(), HashSet::from([name.to_string()]));
    }

    #[test]
    fn a_folder_of_something_else_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("thesis.tex"), "x").unwrap();
        let fault = Sweep::create(folder.path(), &planned(1), b"").unwrap_err();
        assert!(fault.to_string().contains("is no sweep"), "{fault}");
        let fault = Sweep::open(folder.path()).unwrap_err();
        assert!(fault.to_string().contains("no plan.json"), "{fault}");
    }
}
