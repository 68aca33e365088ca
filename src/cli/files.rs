//! Files that commands write to the folder of a report.

use crate::{
    error::{Error, Result},
    report::Table,
    storage,
};
use std::path::Path;

/// Makes a folder that results go to. One that takes no file is an error now, not after the work.
pub(super) fn make_writable(folder: &Path) -> Result<()> {
    storage::make_folder(folder)?;
    tempfile::tempfile_in(folder).map_err(|e| Error::io("cannot write to", folder, e))?;
    Ok(())
}

pub(super) fn write_text(path: &Path, text: &str) -> Result<()> {
    storage::write_file(path, |out| out.write_all(text.as_bytes()))
}

/// A table as people read it: text, Markdown, LaTeX.
pub(super) fn write_for_readers(folder: &Path, name: &str, table: &Table) -> Result<()> {
    write_text(&folder.join(format!("{name}.txt")), &table.text())?;
    write_text(&folder.join(format!("{name}.md")), &table.markdown())?;
    write_text(&folder.join(format!("{name}.tex")), &table.latex())
}

pub(super) fn in_json(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string(value).map_err(|e| Error::work(format!("result: {e}")))
}

pub(super) fn write_json(file: &Path, value: &impl serde::Serialize) -> Result<()> {
    write_text(file, &(in_json(value)? + "\n"))
}
