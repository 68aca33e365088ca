//! A file that is read: no folder, no device, and the same from its first byte to its last.

use crate::error::{Error, Result};
use std::{
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
    time::SystemTime,
};

/// A file or a pipe that is open.
pub(crate) struct InputFile {
    path: PathBuf,
    file: File,
    /// What a plain file was when it was opened.
    opened: Option<Version>,
}

/// What changes when a file is written.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Version {
    length: u64,
    modified: Option<SystemTime>,
}

impl Version {
    /// Of a plain file; a pipe has none.
    fn of(metadata: &fs::Metadata) -> Option<Self> {
        metadata.is_file().then(|| Self {
            length: metadata.len(),
            modified: metadata.modified().ok(),
        })
    }
}

impl InputFile {
    /// Opens a file or a pipe.
    ///
    /// # Errors
    /// Where it can't be opened, or is a folder or a device.
    pub fn open(path: &Path) -> Result<Self> {
        if path.is_dir() {
            return Err(Error::file(path, "is a folder; expected a file"));
        }
        #[cfg(unix)]
        {
            use std::os::unix::fs::FileTypeExt;
            let is_device = |metadata: fs::Metadata| {
                metadata.file_type().is_char_device() || metadata.file_type().is_block_device()
            };
            if fs::metadata(path).is_ok_and(is_device) {
                return Err(Error::file(path, "is a device; expected a file"));
            }
        }
        let refused = |e| Error::io("cannot read", path, e);
        let file = File::open(path).map_err(refused)?;
        let metadata = file.metadata().map_err(refused)?;
        Ok(Self {
            path: path.to_path_buf(),
            file,
            opened: Version::of(&metadata),
        })
    }

    /// Bytes of a plain file; none of a pipe, which has as many as come.
    pub fn length(&self) -> Option<u64> {
        self.opened.map(|opened| opened.length)
    }

    /// Reads on, as far as bytes are there; 0 at the end. A signal does not interrupt it.
    ///
    /// # Errors
    /// Where the file can't be read.
    pub fn read_some(&self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            match (&self.file).read(buffer) {
                Err(fault) if fault.kind() == io::ErrorKind::Interrupted => continue,
                read => return read,
            }
        }
    }

    /// The same from a byte of a plain file, whatever was read before; the next [`InputFile::read_some`] goes on where the last one ended.
    ///
    /// # Errors
    /// Where the file can't be read.
    pub fn read_some_at(&self, buffer: &mut [u8], at: u64) -> io::Result<usize> {
        loop {
            match read_at(&self.file, buffer, at) {
                Err(fault) if fault.kind() == io::ErrorKind::Interrupted => continue,
                read => return read,
            }
        }
    }

    /// All that is left of it.
    ///
    /// # Errors
    /// Where it can't be read, or changed since it was opened.
    pub fn read_to_end(self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let read = (&self.file).read_to_end(&mut bytes);
        read.map_err(|e| Error::io("cannot read", &self.path, e))?;
        self.check_unchanged()?;
        Ok(bytes)
    }

    /// Is a plain file still what it was when it was opened?
    ///
    /// # Errors
    /// Where it was written since: what was read is then neither the old nor the new.
    pub fn check_unchanged(&self) -> Result<()> {
        let now = self.file.metadata();
        let now = now.map_err(|e| Error::io("cannot read", &self.path, e))?;
        match self.opened == Version::of(&now) {
            true => Ok(()),
            false => Err(Error::file(
                &self.path,
                "changed while it was read; expected a file that nothing writes to meanwhile",
            )),
        }
    }
}

#[cfg(unix)]
fn read_at(file: &File, buffer: &mut [u8], at: u64) -> io::Result<usize> {
    std::os::unix::fs::FileExt::read_at(file, buffer, at)
}

#[cfg(not(unix))]
fn read_at(mut file: &File, buffer: &mut [u8], at: u64) -> io::Result<usize> {
    use std::io::{Seek, SeekFrom};
    let before = file.stream_position()?;
    file.seek(SeekFrom::Start(at))?;
    let read = file.read(buffer);
    file.seek(SeekFrom::Start(before))?;
    read
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_file_that_is_written_while_it_is_read_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("walk.log");
        fs::write(&path, "0123456789").unwrap();
        let file = InputFile::open(&path).unwrap();
        assert_eq!(file.length(), Some(10));
        let mut start = [0; 4];
        assert_eq!(file.read_some(&mut start).unwrap(), 4);
        assert_eq!(file.read_some_at(&mut start, 8).unwrap(), 2);
        assert_eq!(&start, b"8923");
        assert_eq!(file.read_some(&mut start[..1]).unwrap(), 1);
        assert_eq!(&start, b"4923"); // where the first ended
        file.check_unchanged().unwrap();
        let mut again = File::options().append(true).open(&path).unwrap();
        again.write_all(b"more").unwrap();
        let fault = file.read_to_end().unwrap_err().to_string();
        assert!(
            fault.contains("walk.log: changed while it was read"),
            "{fault}"
        );
        assert_eq!(super::super::read_file(&path).unwrap(), b"0123456789more");
    }
}
