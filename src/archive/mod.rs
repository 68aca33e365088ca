//! Named arrays in one file: numpy's `.npz`, a zip archive of `.npy` arrays that numpy opens with `allow_pickle=False`.
//!
//! Datasets and models are such files. Reading takes no more memory than a file of its size may ask for, whatever it
//! claims to hold; writing gives the same bytes for the same arrays.

pub mod npy;

use crate::{
    error::{Error, Result},
    storage,
};
use ndarray::{ArrayView, Dimension};
use ndarray_npy::{WritableElement, WriteNpyExt};
use npy::{Element, Widened};
use std::{
    fmt,
    io::{self, Cursor, Read},
    path::Path,
};
use zip::{
    CompressionMethod, DateTime, ZipArchive, ZipWriter, result::ZipError, write::SimpleFileOptions,
};

/// An archive that is being read, array by array.
pub struct Archive<'a> {
    path: &'a Path,
    /// What the file is to be, for messages: "a dataset such as `ballmark import` writes".
    expected: &'static str,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl<'a> Archive<'a> {
    /// Opens the bytes of a file; `path` and `expected` (what the file is to be) are for messages.
    ///
    /// # Errors
    /// Where the bytes are no whole zip archive.
    pub fn open(path: &'a Path, file: &'a [u8], expected: &'static str) -> Result<Self> {
        let zip = ZipArchive::new(Cursor::new(file)).map_err(|e| {
            Error::file(
                path,
                format!("not a whole .npz file ({e}); expected {expected}"),
            )
        })?;
        Ok(Self {
            path,
            expected,
            zip,
            left: storage::largest_content(file.len()),
        })
    }

    /// Names of all arrays, in alphabetical order.
    pub fn names(&self) -> Vec<String> {
        let arrays = self.zip.file_names().filter_map(|f| f.strip_suffix(".npy"));
        let mut names: Vec<String> = arrays.map(str::to_string).collect();
        names.sort();
        names
    }

    /// Is there an array of that name?
    pub fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(&format!("{name}.npy")).is_some()
    }

    /// An error that names the file and the array.
    pub fn wrong(&self, array: &str, fault: impl fmt::Display) -> Error {
        wrong(self.path, array, fault)
    }

    /// Reads an array of one number type.
    ///
    /// # Errors
    /// Where it is missing, damaged, or of another type or size than its header says.
    pub fn read<T: Element>(&mut self, name: &str) -> Result<npy::Array<T>> {
        let bytes = self.unpack(name)?;
        npy::read(&bytes).map_err(|fault| self.wrong(name, fault))
    }

    /// Reads an array of one number type, or of another that it takes in, as it is unpacked.
    ///
    /// # Errors
    /// As [`Archive::read`].
    pub fn read_widened<T: Widened>(&mut self, name: &str) -> Result<npy::Array<T>> {
        self.unpacking(name, |bytes| npy::read_widened(bytes))?
            .map_err(|fault| self.wrong(name, fault))
    }

    /// The shape that an array claims to have: of no more numbers than its entry claims bytes. Nothing else of it is read.
    ///
    /// # Errors
    /// Where it is missing, or its header is damaged.
    pub fn shape(&mut self, name: &str) -> Result<Vec<usize>> {
        let shape = self.unpacking(name, |bytes| npy::shape(bytes))?;
        let shape = shape.map_err(|fault| self.wrong(name, fault))?;
        let entry = self.zip.by_name(&format!("{name}.npy"));
        let bytes = entry.map_or(0, |entry| entry.size());
        let numbers = shape
            .iter()
            .try_fold(1, |all: u64, n| all.checked_mul(*n as u64));
        match numbers.is_some_and(|numbers| numbers <= bytes) {
            true => Ok(shape),
            false => {
                let shape = npy::Shape(&shape);
                Err(self.wrong(
                    name,
                    format!(
                        "shape {shape} doesn't fit its {bytes} bytes; expected an array of its size"
                    ),
                ))
            }
        }
    }

    /// The bytes of an array, for [`npy`] to look into.
    ///
    /// # Errors
    /// Where it is missing, damaged, or larger than anything that a file of this size may hold.
    pub fn unpack(&mut self, name: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.unpacking(name, |entry| entry.read_to_end(&mut bytes))?
            .map_err(|e| self.wrong(name, format!("damaged: {e}")))?;
        Ok(bytes)
    }

    /// What `read` makes of the bytes of an array.
    fn unpacking<T>(&mut self, name: &str, read: impl FnOnce(&mut dyn Read) -> T) -> Result<T> {
        let path = self.path;
        let wrong = |fault: String| wrong(path, name, fault);
        let entry = match self.zip.by_name(&format!("{name}.npy")) {
            Ok(entry) => entry,
            Err(ZipError::FileNotFound) => {
                return Err(wrong(format!("missing; expected {}", self.expected)));
            }
            Err(e) => return Err(wrong(format!("can't be opened: {e}"))),
        };
        let declared = entry.size();
        if declared > self.left {
            return Err(wrong(format!(
                "claims to unpack to {declared} bytes; expected a size that fits a file this small"
            )));
        }
        let mut entry = entry.take(self.left + 1);
        let made = read(&mut entry);
        let read = self.left + 1 - entry.limit();
        self.left = self.left.checked_sub(read).ok_or_else(|| {
            wrong(
                "unpacks to more bytes than it claims; expected a size that fits a file this small"
                    .into(),
            )
        })?;
        Ok(made)
    }
}

fn wrong(path: &Path, array: &str, fault: impl fmt::Display) -> Error {
    Error::input(path, format!("array `{}`", array.escape_debug()), fault)
}

/// Writes an archive, whole or not at all; `add_arrays` puts the arrays in, and their order is the file's.
///
/// ```
/// use ballmark::archive::{self, Archive};
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = folder.path().join("steps.npz");
/// let steps = ndarray::array![[0.5, 0.25], [1.0, 2.0]];
/// archive::write(&path, |archive| archive.add("steps", steps.view()))?;
/// let file = std::fs::read(&path).unwrap();
/// let mut archive = Archive::open(&path, &file, "an archive with `steps`")?;
/// assert_eq!(archive.read::<f64>("steps")?.shape, [2, 2]);
/// assert!(archive.read::<f32>("steps").unwrap_err().to_string().contains("`<f8`; expected `<f4`"));
/// # Ok::<(), ballmark::Error>(())
/// ```
///
/// # Errors
/// Where the file can't be written, or `add_arrays` fails.
pub fn write(
    path: &Path,
    add_arrays: impl FnOnce(&mut Writer<'_>) -> io::Result<()>,
) -> Result<()> {
    storage::write_file(path, |out| {
        let mut writer = Writer {
            zip: ZipWriter::new(out),
        };
        add_arrays(&mut writer)?;
        writer.zip.finish()?;
        Ok(())
    })
}

/// An archive that is being written.
pub struct Writer<'a> {
    zip: ZipWriter<&'a mut dyn storage::WriteSeek>,
}

impl Writer<'_> {
    /// Adds an array, compressed.
    ///
    /// # Errors
    /// Where the bytes can't be written, or the name is taken.
    pub fn add<T: WritableElement, D: Dimension>(
        &mut self,
        name: &str,
        array: ArrayView<'_, T, D>,
    ) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default()) // 1980: the bytes depend on the content only
            .large_file(array.len() as u64 * 8 > u64::from(u32::MAX) / 2);
        self.zip.start_file(format!("{name}.npy"), options)?;
        array.write_npy(&mut self.zip).map_err(io::Error::other)
    }
}
