//! One process a cell: a lock that the operating system takes back when its holder ends, however it ends.

use crate::error::{Error, Result};
use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::Write,
    path::{Path, PathBuf},
};

/// How often a lock whose file was taken away between opening and locking is tried again.
const TRIES: usize = 100;

/// The right to run a cell; given back when dropped.
///
/// The file is locked by the operating system, not by being there: what a killed process leaves behind is free.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    /// Locked as long as it is open.
    _file: File,
}

impl Lock {
    /// Takes a lock; none where another process holds it.
    ///
    /// # Errors
    /// Where the file can't be made, or the file system has no locks.
    pub(super) fn take(path: &Path) -> Result<Option<Self>> {
        let refused = |e| Error::io("cannot lock", path, e);
        if let Some(folder) = path.parent() {
            crate::storage::make_folder(folder)?;
        }
        for _ in 0..TRIES {
            let opened = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(path);
            let mut file = opened.map_err(refused)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(e)) => {
                    return Err(refused(e).followed_by("expected a file system with locks"));
                }
            }
            // Whoever held it may have taken the file away meanwhile: then this is another one than the next process opens.
            if !is_same(&file, path) {
                continue;
            }
            // For who looks; that it can't be written is no fault.
            let _ = file.set_len(0);
            let _ = write!(file, "{} {}", std::process::id(), host());
            return Ok(Some(Self {
                path: path.to_path_buf(),
                _file: file,
            }));
        }
        Ok(None)
    }

    /// Does a process hold it now? Its number and machine, as far as they are known.
    pub(super) fn holder(path: &Path) -> Option<String> {
        let file = File::open(path).ok()?;
        match file.try_lock_shared() {
            Err(TryLockError::WouldBlock) => Some(fs::read_to_string(path).unwrap_or_default()),
            _ => None,
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Still locked: nobody else holds what is taken away.
        let _ = fs::remove_file(&self.path);
    }
}

#[cfg(unix)]
fn is_same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let of = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let (open, named) = (file.metadata().map(of), fs::metadata(path).map(of));
    matches!((open, named), (Ok(open), Ok(named)) if open == named)
}

#[cfg(not(unix))]
fn is_same(_: &File, path: &Path) -> bool {
    path.exists() // an open file can't be taken away there
}

/// What this machine is called.
pub(super) fn host() -> String {
    let kernel = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let host = kernel.or_else(|| std::env::var("HOSTNAME").ok());
    let host = host.or_else(|| std::env::var("COMPUTERNAME").ok());
    host.map_or("this machine".into(), |host| host.trim().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_holds_it_and_what_is_left_behind_is_free() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("locks/cell");
        let held = Lock::take(&path).unwrap().unwrap();
        assert!(Lock::take(&path).unwrap().is_none());
        let holder = Lock::holder(&path).unwrap();
        assert!(
            holder.starts_with(&std::process::id().to_string()),
            "{holder}"
        );
        drop(held);
        assert!(!path.exists() && Lock::holder(&path).is_none());

        // As a killed process leaves it.
        fs::write(&path, "1 elsewhere").unwrap();
        assert!(Lock::holder(&path).is_none());
        assert!(Lock::take(&path).unwrap().is_some());
    }

    #[test]
    fn of_many_at_once_one_holds_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cell");
        let inside = std::sync::atomic::AtomicUsize::new(0);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    for _ in 0..200 {
                        if let Some(lock) = Lock::take(&path).unwrap() {
                            let order = std::sync::atomic::Ordering::SeqCst;
                            assert_eq!(inside.fetch_add(1, order), 0);
                            std::thread::yield_now();
                            inside.fetch_sub(1, order);
                            drop(lock);
                        }
                    }
                });
            }
        });
    }
}
