//! The files that a cell's end leaves: its result, or why it failed.

use super::{cell::Cell, folder::Sweep, plan::described};
use crate::{error::Result, storage};
use std::{
    fs::{self, File},
    io::{Read, Seek, SeekFrom},
    path::Path,
};

/// Bytes at the end of standard error that are kept of a cell that failed.
const LAST_BYTES: u64 = 4096;
/// And lines.
const LAST_LINES: usize = 20;

/// Writes why a cell failed.
pub(super) fn write_failure(sweep: &Sweep, cell: &Cell, why: &str) -> Result<()> {
    let path = sweep.failure(&cell.name);
    storage::make_folder(&path.with_file_name(""))?;
    let described = described(&cell.keys, cell.seed);
    write_named(&path, &format!("cell {}: {described}\n{why}\n", cell.name))
}

/// Writes a file whole; what a killed process leaves of it is known by its name.
pub(super) fn write_named(path: &Path, text: &str) -> Result<()> {
    storage::write_file_as(path, &left_behind(path), |out| {
        out.write_all(text.as_bytes())
    })
}

/// What temporary files of a file begin with.
fn left_behind(path: &Path) -> String {
    format!(
        ".{}-",
        path.file_name().unwrap_or_default().to_string_lossy()
    )
}

/// Takes away what killed processes left of a file, under its cell's lock: nobody else writes it.
pub(super) fn clear_away(path: &Path) {
    let prefix = left_behind(path);
    let entries = path.parent().and_then(|folder| folder.read_dir().ok());
    for entry in entries.into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with(&prefix) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The last lines of a file, however long it is.
pub(super) fn last_lines(file: &Path) -> String {
    let read = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(file)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(LAST_BYTES)))?;
        let mut end = Vec::new();
        file.take(LAST_BYTES).read_to_end(&mut end)?;
        Ok(end)
    };
    let end = read().unwrap_or_default(); // without them a message does, too
    let end = String::from_utf8_lossy(&end);
    let lines: Vec<&str> = end.lines().filter(|line| !line.trim().is_empty()).collect();
    lines[lines.len().saturating_sub(LAST_LINES)..].join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_of_what_was_printed_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stderr");
        let lines: Vec<String> = (0..5000).map(|n| format!("line {n}")).collect();
        fs::write(&path, lines.join("\n\n")).unwrap();
        let last = last_lines(&path);
        assert_eq!(last.lines().count(), LAST_LINES);
        assert!(last.starts_with("line 4980\n") && last.ends_with("line 4999"));
        assert_eq!(last_lines(&folder.path().join("none")), "");
    }
}
