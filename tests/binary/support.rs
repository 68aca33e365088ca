//! Calling `ballmark` in a fresh folder and looking at what it said and left behind.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// A fresh folder that a test's call works in; removed when dropped.
pub struct Workplace {
    folder: tempfile::TempDir,
}

/// What a call answered.
pub struct Answer {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Workplace {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a temporary folder"),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).expect("a file in a temporary folder");
        path
    }

    /// Names of everything in the folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder");
        let mut names: Vec<String> = entries
            .map(|e| {
                e.expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// Calls `ballmark` with these arguments in the folder.
    pub fn ballmark<S: AsRef<std::ffi::OsStr>>(&self, arguments: &[S]) -> Answer {
        answer(
            Command::new(binary())
                .args(arguments)
                .current_dir(self.folder.path()),
        )
    }
}

impl Answer {
    /// The call failed as it should: this status, one line on standard error that holds all of `parts`, no result.
    #[track_caller]
    pub fn refused(&self, status: i32, parts: &[&str]) {
        assert_eq!(
            self.status, status,
            "stdout: {}\nstderr: {}",
            self.stdout, self.stderr
        );
        let line = self
            .stderr
            .lines()
            .find(|l| l.starts_with("error: "))
            .unwrap_or("");
        assert!(
            !line.is_empty(),
            "no line starts with `error: ` in: {}",
            self.stderr
        );
        for part in parts {
            assert!(line.contains(part), "`{part}` is missing in: {line}");
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert_eq!(self.stdout, "", "a refused call prints no result");
    }

    #[track_caller]
    pub fn done(&self) -> &Self {
        assert_eq!(
            self.status, 0,
            "stdout: {}\nstderr: {}",
            self.stdout, self.stderr
        );
        self
    }
}

pub fn binary() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_ballmark"))
}

pub fn answer(command: &mut Command) -> Answer {
    let output = command.output().expect("the binary runs");
    Answer {
        status: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// The folder of real logs, where the environment names one; a test without it says that it is skipped.
pub fn real_logs(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("BALLMARK_DATA")
        .map(PathBuf::from)
        .filter(|f| f.is_dir());
    if folder.is_none() {
        eprintln!("skipped: {test} needs the real logs in $BALLMARK_DATA");
    }
    folder
}
