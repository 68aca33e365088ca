//! The files that a cell's end leaves: its result, or why it failed.

use super::{cell::Cell, folder::Sweep, plan::described};
use crate::{error::Result, storage};
use std::{fs, path::Path};

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
