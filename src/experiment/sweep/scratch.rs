//! Where a cell's command works.

use super::{cell::is_name, folder::Sweep, lock::Lock};
use crate::{
    error::{Error, Result},
    storage,
};
use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

/// A cell's scratch folder, called after sweep and cell so that one left behind by a killed process is found and taken away.
#[derive(Debug)]
pub(super) struct Scratch {
    pub path: PathBuf,
}

impl Scratch {
    /// What those of a sweep's cells begin with.
    fn prefix(sweep: &Sweep) -> Result<String> {
        let folder = sweep.folder();
        let whole = folder.canonicalize();
        let whole = whole.map_err(|e| Error::io("cannot find", folder, e))?;
        let digest = storage::sha256(whole.to_string_lossy().as_bytes());
        Ok(format!("ballmark-{}-", &digest[..8]))
    }

    /// Made under the cell's lock, so that nobody else has it.
    pub fn make(sweep: &Sweep, name: &str) -> Result<Self> {
        let path = std::env::temp_dir().join(Self::prefix(sweep)? + name);
        let refused = |e| Error::io("cannot make the folder", &path, e);
        if path.exists() {
            fs::remove_dir_all(&path).map_err(refused)?;
        }
        #[cfg(unix)]
        let builder = {
            use std::os::unix::fs::DirBuilderExt;
            let mut builder = fs::DirBuilder::new();
            builder.mode(0o700);
            builder
        };
        #[cfg(not(unix))]
        let builder = fs::DirBuilder::new();
        builder.create(&path).map_err(refused)?;
        Ok(Self { path })
    }

    /// Copies what is no link to a folder.
    pub fn keep_as(&self, folder: &Path) -> Result<()> {
        storage::make_folder(folder)?;
        let entries = self.path.read_dir();
        for entry in entries.map_err(|e| Error::io("cannot read", &self.path, e))? {
            let entry = entry.map_err(|e| Error::io("cannot read", &self.path, e))?;
            if entry.file_type().is_ok_and(|kind| kind.is_file()) {
                let to = folder.join(entry.file_name());
                let content = storage::read_file(&entry.path())?;
                storage::write_file(&to, |out| out.write_all(&content))?;
            }
        }
        Ok(())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.path);
    }
}

/// Takes away what killed processes left of a sweep's cells: scratch folders, and locks of cells that nobody will run again, because they are
/// done (who was killed between the two had written the result and held the lock) or of another plan.
///
/// # Errors
/// Where the sweep's folder isn't there any more, or can't be read.
pub(super) fn clear_left_behind(sweep: &Sweep) -> Result<()> {
    let prefix = Scratch::prefix(sweep)?;
    let entries = std::env::temp_dir().read_dir();
    for entry in entries.into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Some(cell) = name.strip_prefix(&prefix).filter(|cell| is_name(cell)) else {
            continue;
        };
        // Held by whoever works in it.
        if let Ok(Some(_lock)) = Lock::take(&sweep.lock(cell)) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
    let locked = sweep.locked()?;
    if locked.is_empty() {
        return Ok(());
    }
    let done = sweep.done()?;
    let cells = sweep.cells()?;
    let to_run = cells.iter().map(|cell| &cell.name);
    let to_run: HashSet<&String> = to_run.filter(|name| !done.contains(*name)).collect();
    for name in locked.iter().filter(|name| !to_run.contains(name)) {
        // Taken away with its file as soon as it is held.
        let _ = Lock::take(&sweep.lock(name));
    }
    Ok(())
}
