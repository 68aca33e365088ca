//! What a restart has of its own: a seed, and a file for its checkpoint.

use crate::{
    error::{Error, Result},
    seed::Seed,
};
use rand::RngExt;
use std::path::{Path, PathBuf};

/// The seed of a restart; that of the first is the recipe's own.
pub fn restart_seed(seed: u64, restart: usize) -> u64 {
    match restart {
        0 => seed,
        _ => Seed(seed)
            .numbered_stream("restart", restart as u64)
            .random(),
    }
}

/// Where the checkpoint of a restart is kept: at `path` itself for the first, numbered for the others.
pub fn checkpoint_of(path: &Path, restart: usize) -> PathBuf {
    let mut name = path.as_os_str().to_os_string();
    if restart > 0 {
        name.push(format!("-{restart}"));
    }
    name.into()
}

/// Removes the checkpoints of a training of so many restarts.
///
/// # Errors
/// Where one is there and can't be removed.
pub fn remove_checkpoints(checkpoint: &Path, restarts: usize) -> Result<()> {
    for path in (0..restarts).map(|restart| checkpoint_of(checkpoint, restart)) {
        crate::storage::clear_away(&path);
        if path.exists() {
            std::fs::remove_file(&path).map_err(|e| Error::io("cannot remove", &path, e))?;
        }
    }
    Ok(())
}
