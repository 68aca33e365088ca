//! The unpacked content of a log for readers that go back and forth in it: bytes at hand, or a file of which a window is held.

use crate::{
    error::{Error, Result},
    storage::InputFile,
};
use std::{
    borrow::Cow,
    cell::{Cell, RefCell},
    io,
    path::Path,
    rc::Rc,
};

/// Bytes of a file that are read at a time where fewer are asked for.
const WINDOW: usize = 64 << 10;

/// Bytes that can be asked for by their place.
///
/// A file that can't be read on ends where that was found, so that its reader comes to an end as well; [`Content::check`] says why.
pub(super) struct Content<'a> {
    length: Cell<usize>,
    from: From<'a>,
}

enum From<'a> {
    Bytes(&'a [u8]),
    File {
        file: Rc<InputFile>,
        window_bytes: usize,
        window: RefCell<Window>,
        fault: RefCell<Option<io::Error>>,
    },
}

/// What was read last.
#[derive(Default)]
struct Window {
    at: usize,
    bytes: Vec<u8>,
}

impl<'a> Content<'a> {
    /// Bytes at hand.
    pub fn of_bytes(bytes: &'a [u8]) -> Self {
        Self {
            length: Cell::new(bytes.len()),
            from: From::Bytes(bytes),
        }
    }

    /// A plain file of so many bytes, which others may read on meanwhile.
    pub fn of_file(file: Rc<InputFile>, length: usize) -> Self {
        Self::in_windows(file, length, WINDOW)
    }

    /// The same with a window of so many bytes.
    pub fn in_windows(file: Rc<InputFile>, length: usize, window_bytes: usize) -> Self {
        Self {
            length: Cell::new(length),
            from: From::File {
                file,
                window_bytes,
                window: RefCell::default(),
                fault: RefCell::default(),
            },
        }
    }

    /// Bytes in all.
    pub fn len(&self) -> usize {
        self.length.get()
    }

    /// The bytes from a place on, as far as they are there.
    pub fn bytes(&self, at: usize, length: usize) -> Cow<'a, [u8]> {
        let end = at.saturating_add(length).min(self.len());
        let at = at.min(end);
        match &self.from {
            From::Bytes(bytes) => Cow::Borrowed(&bytes[at..end]),
            From::File {
                file, window_bytes, ..
            } if end - at > *window_bytes => Cow::Owned(self.read(file, at, end - at)),
            From::File { .. } => Cow::Owned(self.looked_at(at, end, <[u8]>::to_vec)),
        }
    }

    /// So many bytes from a place on, where all of them are there.
    pub fn number<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        let end = at.checked_add(N).filter(|end| *end <= self.len())?;
        self.looked_at(at, end, |bytes| bytes.try_into().ok())
    }

    /// Does it start so?
    pub fn starts_with(&self, start: &[u8]) -> bool {
        *self.bytes(0, start.len()) == *start
    }

    /// Gives some bytes that are there to `look`, no more than a window has room for.
    fn looked_at<T>(&self, at: usize, end: usize, look: impl Fn(&[u8]) -> T) -> T {
        let (file, window_bytes, window) = match &self.from {
            From::Bytes(bytes) => return look(&bytes[at..end]),
            From::File {
                file,
                window_bytes,
                window,
                ..
            } => (file, *window_bytes, window),
        };
        let mut window = window.borrow_mut();
        if at < window.at || end > window.at + window.bytes.len() {
            let length = window_bytes.max(end - at).min(self.len() - at);
            *window = Window {
                at,
                bytes: self.read(file, at, length),
            };
        }
        let from = at - window.at;
        look(
            window
                .bytes
                .get(from..from + (end - at))
                .unwrap_or_default(),
        )
    }

    /// Reads bytes that the file should have; fewer where it can't be read on, which is its end from then on.
    fn read(&self, file: &InputFile, at: usize, length: usize) -> Vec<u8> {
        let mut bytes = vec![0; length];
        let mut done = 0;
        while done < length {
            let fault = match file.read_some_at(&mut bytes[done..], (at + done) as u64) {
                Ok(0) => io::Error::new(
                    io::ErrorKind::UnexpectedEof,
                    format!("it ends at byte {}; expected {}", at + done, self.len()),
                ),
                Ok(read) => {
                    done += read;
                    continue;
                }
                Err(fault) => fault,
            };
            self.length.set(0);
            bytes.clear();
            if let From::File { fault: first, .. } = &self.from {
                first.borrow_mut().get_or_insert(fault);
            }
            break;
        }
        bytes
    }

    /// Could all that was asked for be read?
    ///
    /// # Errors
    /// Where the file could not be read on.
    pub fn check(&self, path: &Path) -> Result<()> {
        let From::File { fault, .. } = &self.from else {
            return Ok(());
        };
        match fault.borrow_mut().take() {
            Some(fault) => Err(Error::io("cannot read", path, fault)),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_file_has_the_bytes_that_it_has_in_one_piece() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("content");
        let whole: Vec<u8> = (0..100).collect();
        fs::write(&path, &whole).unwrap();
        let memory = Content::of_bytes(&whole);
        for window in [1, 7, 64, 1000] {
            let file = Rc::new(InputFile::open(&path).unwrap());
            let file = Content::in_windows(file, whole.len(), window);
            for at in [0, 1, 6, 7, 8, 50, 3, 93, 99, 100, 101, usize::MAX] {
                for length in [0, 1, 4, 7, 8, 60, 200, usize::MAX] {
                    let expected = memory.bytes(at, length);
                    assert_eq!(file.bytes(at, length), expected, "{window} {at} {length}");
                }
                assert_eq!(file.number::<4>(at), memory.number::<4>(at));
            }
            assert!(file.starts_with(&[0, 1, 2]) && !file.starts_with(&[1]));
            file.check(&path).unwrap();
        }
    }

    #[test]
    fn a_file_that_ends_too_early_ends_its_reader_and_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("content");
        fs::write(&path, [1; 100]).unwrap();
        let file = Rc::new(InputFile::open(&path).unwrap());
        let content = Content::in_windows(file, 150, 10);
        assert_eq!(content.bytes(90, 10).len(), 10);
        content.check(&path).unwrap();
        assert!(content.bytes(95, 10).is_empty());
        assert_eq!((content.len(), content.number::<1>(0)), (0, None));
        let fault = content.check(&path).unwrap_err().to_string();
        assert!(
            fault.contains("content: cannot read: it ends at byte 100"),
            "{fault}"
        );
    }
}
