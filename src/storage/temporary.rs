//! Temporary files beside the files that they become: one that a killed process left is taken away by the next that
//! writes the same file.

use std::{
    ffi::OsStr,
    fs::{self, File},
    io,
    path::{Path, PathBuf},
};
use tempfile::{Builder, NamedTempFile};

/// Bytes of a target's name that its temporary files keep: a name may have 255 of them.
const NAME_BYTES: usize = 200;
/// Characters that tell the temporary files of one target apart.
const RANDOM: usize = 6;
/// How often a temporary file is made anew that another process took for left behind before it was locked.
const TRIES: usize = 100;

/// A new file in `folder` that is to become the one of that name there, locked as long as it is open; those that ended
/// processes left of it are gone.
///
/// Where the file system has no locks, nothing is taken away: whose a file is can't be known.
pub(super) fn beside(folder: &Path, name: &OsStr) -> io::Result<NamedTempFile> {
    clear_away(folder, name);
    let mut builder = Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As the user's umask has them, not the owner-only ones that temporary files get by default.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let prefix = prefix(name);
    builder.prefix(&prefix).rand_bytes(RANDOM);
    for _ in 1..TRIES {
        let made = builder.tempfile_in(folder)?;
        // Between making and locking, another process may have locked it and taken it away.
        if made.as_file().lock().is_err() || made.path().exists() {
            return Ok(made);
        }
    }
    builder.tempfile_in(folder)
}

/// Takes away what ended processes left of a file of that name.
pub(super) fn clear_away(folder: &Path, name: &OsStr) {
    for path in of_prefix(folder, &prefix(name)) {
        remove_unless_locked(&path);
    }
}

fn prefix(name: &OsStr) -> String {
    let mut name = name.to_string_lossy().into_owned();
    while name.len() > NAME_BYTES {
        name.pop();
    }
    format!(".{name}.tmp")
}

fn of_prefix(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let is_one = |name: &OsStr| {
        let rest = name.to_str().and_then(|name| name.strip_prefix(prefix));
        rest.is_some_and(|rest| {
            rest.len() == RANDOM && rest.bytes().all(|b| b.is_ascii_alphanumeric())
        })
    };
    let entries = folder.read_dir().into_iter().flatten().flatten();
    let names = entries.filter(|entry| is_one(&entry.file_name()));
    names.map(|entry| entry.path()).collect()
}

fn remove_unless_locked(path: &Path) {
    // No link is followed, no pipe waited for.
    if fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_file())
        && let Ok(file) = File::options().write(true).open(path)
        && file.try_lock().is_ok()
    {
        // Still locked: whoever has just made it makes another one. That it stays is no fault.
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_process_left_goes_and_what_another_one_writes_stays() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path();
        let name = OsStr::new("table.csv");
        let written = beside(place, name).unwrap();
        for other in [
            ".table.csv.tmpaB3dE9",
            ".table.csv.tmpaB3dE99",
            ".table.csv.tmpaB-dE9",
            ".table.md.tmpaB3dE9",
            "table.csv",
        ] {
            fs::write(place.join(other), "half").unwrap();
        }
        let next = beside(place, name).unwrap();
        assert!(written.path().exists() && next.path() != written.path());
        let mut left = Vec::from_iter(place.read_dir().unwrap().map(|e| e.unwrap().path()));
        left.retain(|path| path != written.path() && path != next.path());
        left.sort();
        let expected = [
            ".table.csv.tmpaB-dE9",
            ".table.csv.tmpaB3dE99",
            ".table.md.tmpaB3dE9",
            "table.csv",
        ];
        assert_eq!(left, expected.map(|name| place.join(name)));
        // Ended, whoever wrote it: a file that is closed has no lock.
        let (file, path) = written.keep().unwrap();
        drop(file);
        beside(place, name).unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn long_names_and_names_of_any_letters_have_temporary_files() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a".repeat(250), "ü".repeat(120)] {
            let made = beside(folder.path(), OsStr::new(&name)).unwrap();
            assert!(made.path().exists());
        }
    }
}
