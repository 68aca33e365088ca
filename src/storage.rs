//! Files read once and written whole or not at all.

mod input_file;
mod temporary;

pub(crate) use input_file::InputFile;

use crate::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::{
    fs,
    io::{self, Cursor, Seek, Write},
    path::{Path, PathBuf},
};

/// A place to write bytes that also can go back, as a zip archive needs.
pub trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

/// All bytes of a file or a pipe; not those of a device, which need never end.
///
/// # Errors
/// Where it can't be read, or changes while it is read.
pub fn read_file(path: &Path) -> Result<Vec<u8>> {
    InputFile::open(path)?.read_to_end()
}

/// What a file of `len` bytes may unpack to: text logs shrink to a tenth, constant arrays to a thousandth, but no log
/// of any size does as a whole. So a small file can't ask for all the memory there is.
pub fn largest_content(len: usize) -> u64 {
    (64 << 20) + 200 * len as u64
}

/// Writes `path` whole or not at all: a temporary file beside it, fsync, rename. Whatever stood there before stays
/// until the new content is safe, and nothing half-written is left behind when the disk or a limit refuses. What a
/// process that was killed meanwhile left beside it goes when the file is written again.
///
/// ```
/// # let folder = tempfile::tempdir().unwrap();
/// let path = folder.path().join("note.txt");
/// ballmark::storage::write_file(&path, |out| out.write_all(b"whole")).unwrap();
/// assert_eq!(std::fs::read(&path).unwrap(), b"whole");
/// ```
pub fn write_file(
    path: &Path,
    content: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
) -> Result<()> {
    let refused = |e: io::Error| Error::io("cannot write", path, e);
    folder_of_target(path)?;
    let target = followed(path);
    let folder = folder_of(&target);
    let before = fs::metadata(&target)
        .ok()
        .map(|metadata| metadata.permissions());
    let name = target.file_name().unwrap_or_default();
    let mut temporary = temporary::beside(&folder, name).map_err(refused)?;
    // Made in memory first: an archive writer tries to close its archive when it is dropped, and complains on standard
    // error, beside our own line, when the disk that has refused it once refuses again.
    let mut whole = Cursor::new(Vec::new());
    content(&mut whole).map_err(refused)?;
    temporary.write_all(whole.get_ref()).map_err(refused)?;
    if let Some(permissions) = before {
        temporary
            .as_file()
            .set_permissions(permissions)
            .map_err(refused)?;
    }
    temporary.as_file().sync_all().map_err(refused)?;
    temporary.persist(&target).map_err(|e| refused(e.error))?;
    Ok(())
}

/// Takes away what processes that were killed while they wrote a file left beside it; what others write now stays.
pub(crate) fn clear_away(path: &Path) {
    temporary::clear_away(&folder_of(path), path.file_name().unwrap_or_default());
}

/// Can a file of that name be made, as far as can be known beforehand? Returns the folder it goes to. Asked before long
/// work, so that the answer does not come after it.
///
/// # Errors
/// Where a folder, a device or a pipe of that name exists, or the folder that it would lie in is a file, does not exist or can't be written to.
pub fn check_target(path: &Path) -> Result<PathBuf> {
    let folder = folder_of_target(path)?;
    let target = followed(path);
    let made = temporary::beside(&folder_of(&target), target.file_name().unwrap_or_default());
    made.map_err(|e| Error::io("cannot write", path, e))?; // and is gone again
    Ok(folder)
}

/// What a link leads to is written, and the link stays.
fn followed(path: &Path) -> PathBuf {
    let linked = fs::symlink_metadata(path).is_ok_and(|metadata| metadata.is_symlink());
    match linked {
        true => fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()),
        false => path.to_path_buf(),
    }
}

/// The folder that a file would lie in, as its name alone says.
fn folder_of_target(path: &Path) -> Result<PathBuf> {
    let folder = folder_of(path);
    let fault = if path.is_dir() {
        "a folder of that name exists; expected a file name".to_string()
    } else if folder == Path::new("/dev") || fs::metadata(path).is_ok_and(|m| !m.is_file()) {
        // What /dev/stdout leads to is somebody's open file, which must not be replaced.
        "a device or a pipe of that name exists; expected a file name".to_string()
    } else if folder.is_dir() {
        return Ok(folder);
    } else if folder.exists() {
        format!("{} is a file, not a folder", folder.display())
    } else {
        format!("the folder {} does not exist", folder.display())
    };
    Err(Error::file(path, format!("cannot write: {fault}")))
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Makes a folder for results, with its parents.
pub fn make_folder(path: &Path) -> Result<()> {
    fs::create_dir_all(path).map_err(|e| Error::io("cannot make the folder", path, e))
}

/// SHA-256 of some bytes in hexadecimal, as `sha256sum` prints it.
pub fn sha256(bytes: &[u8]) -> String {
    hexadecimal(Sha256::new().chain_update(bytes))
}

/// The same of a digest that was made bit by bit.
pub(crate) fn hexadecimal(digest: Sha256) -> String {
    let digest = digest.finalize();
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn what_never_ends_is_refused() {
        let error = read_file("/dev/zero".as_ref()).unwrap_err();
        assert!(
            error.to_string().contains("/dev/zero: is a device"),
            "{error}"
        );
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_stay_what_they_are() {
        for path in ["/dev/null", "/dev/stdout"] {
            let error = write_file(path.as_ref(), |out| out.write_all(b"x")).unwrap_err();
            assert!(error.to_string().contains("a device or a pipe"), "{error}");
        }
        // Memory that is mounted there is a folder like any other.
        if Path::new("/dev/shm").is_dir() {
            check_target("/dev/shm/dataset.npz".as_ref()).unwrap();
            // Where nobody may make a file, whoever asks.
            let fault = check_target("/proc/dataset.npz".as_ref()).unwrap_err();
            assert!(fault.to_string().contains("cannot write"), "{fault}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_permissions_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [disk, real, link] =
            ["disk", "disk/real.npz", "link.npz"].map(|name| folder.path().join(name));
        fs::create_dir(&disk).unwrap();
        fs::write(&real, b"old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o600)).unwrap();
        symlink("disk/real.npz", &link).unwrap();
        write_file(&link, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(
            fs::metadata(&real).unwrap().permissions().mode() & 0o777,
            0o600
        );
        assert_eq!(fs::read_dir(&disk).unwrap().count(), 1);
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.csv");
        write_file(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write_file(&path, |out| {
            out.write_all(b"new, half")?;
            Err(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().is_io());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_as_parent_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"").unwrap();
        let error = write_file(&file.join("out"), |_| Ok(()))
            .unwrap_err()
            .to_string();
        assert!(error.contains("is a file, not a folder"), "{error}");
    }

    #[test]
    fn sha256_of_the_standard_example() {
        // FIPS 180-2, appendix B.1
        assert_eq!(
            sha256(b"abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
