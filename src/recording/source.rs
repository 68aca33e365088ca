//! A log as it comes: read, unpacked and hashed bit by bit, so that a text log need not fit in memory.

use super::{
    compressed::{self, Packed},
    content::Content,
};
use crate::{
    error::{Error, Result},
    storage::{self, InputFile},
};
use sha2::{Digest, Sha256};
use std::{
    cell::RefCell,
    io::{self, BufReader, Cursor, Read},
    path::Path,
    rc::Rc,
};

/// Unpacked bytes by which a format is known, and of which a log that fits is made in one piece.
const HEAD: u64 = 16 << 20;

/// Bytes read from a file at a time.
const AT_ONCE: usize = 1 << 20;

/// The unpacked content of a log's file.
pub(super) struct Source<'a> {
    path: &'a Path,
    /// Has the file no byte?
    pub is_empty: bool,
    head: Vec<u8>,
    rest: Box<dyn Read>,
    /// A plain file whose bytes are the content, and their number.
    in_place: Option<(Rc<InputFile>, usize)>,
    /// What is read of the file last, so that all of it is hashed.
    tail: Option<Hashed>,
    seen: Rc<RefCell<Seen>>,
}

/// What became known on the way.
struct Seen {
    hash: Sha256,
    /// Why the file itself can't be read.
    fault: Option<io::Error>,
    /// Why the rest could not be unpacked.
    damage: Option<String>,
}

impl<'a> Source<'a> {
    /// Opens a file and reads its beginning; `hash` goes on with its bytes. What is no plain file is read whole.
    ///
    /// # Errors
    /// Where it can't be read, or nothing of it can be unpacked.
    pub fn open(path: &'a Path, hash: Sha256) -> Result<Self> {
        Self::with_head(path, hash, HEAD)
    }

    /// The same with so many bytes for a beginning.
    fn with_head(path: &'a Path, hash: Sha256, head_bytes: u64) -> Result<Self> {
        let seen = Seen {
            hash,
            fault: None,
            damage: None,
        };
        let mut source = Self {
            path,
            is_empty: false,
            head: Vec::new(),
            rest: Box::new(io::empty()),
            in_place: None,
            tail: None,
            seen: Rc::new(RefCell::new(seen)),
        };
        let file = InputFile::open(path)?;
        let Some(length) = file.length() else {
            source.take_whole(&file.read_to_end()?)?;
            return Ok(source);
        };
        let mut start = Vec::new();
        let mut from = Hashed {
            file: Rc::new(file),
            seen: Rc::clone(&source.seen),
        };
        let tail = from.clone();
        let first = from.by_ref().take(compressed::MAGIC_LENGTH);
        source.read(first, &mut start)?;
        if start.is_empty() {
            source.is_empty = true;
            return Ok(source);
        }
        let packed = compressed::packed(&start);
        if packed.is_none() {
            let length = usize::try_from(length).ok();
            source.in_place = length.map(|length| (Rc::clone(&tail.file), length));
        }
        let limit = storage::largest_content(usize::try_from(length).unwrap_or(usize::MAX));
        let from = BufReader::with_capacity(AT_ONCE, Cursor::new(start).chain(from));
        source.rest = Box::new(Unpacking {
            from: match packed {
                Some(packed) => packed.reader(from, limit),
                None => Box::new(from),
            },
            packing: packed.map(Packed::name),
            unpacked: 0,
            limit,
            seen: Rc::clone(&source.seen),
        });
        source.tail = Some(tail);
        let mut head = Vec::new();
        let mut rest = std::mem::replace(&mut source.rest, Box::new(io::empty()));
        source.read(rest.by_ref().take(head_bytes), &mut head)?;
        (source.head, source.rest) = (head, rest);
        Ok(source)
    }

    /// The content of a file that was read whole.
    fn take_whole(&mut self, file: &[u8]) -> Result<()> {
        self.seen.borrow_mut().hash.update(file);
        self.is_empty = file.is_empty();
        let content = compressed::unpack(self.path, file)?;
        self.seen.borrow_mut().damage = content.damage;
        self.head = content.bytes.into_owned();
        Ok(())
    }

    fn read(&self, mut from: impl Read, to: &mut Vec<u8>) -> Result<()> {
        let read = from.read_to_end(to);
        read.map(drop).map_err(|e| self.fault(e))
    }

    /// What went wrong where the content could not be read on.
    fn fault(&self, fault: io::Error) -> Error {
        match self.seen.borrow_mut().fault.take() {
            Some(fault) => Error::io("cannot read", self.path, fault),
            None => Error::file(self.path, fault),
        }
    }

    /// The first bytes of the content: all of a short log.
    pub fn head(&self) -> &[u8] {
        &self.head
    }

    /// The content for readers that go back and forth. A plain file that is longer than its beginning is not held in memory.
    ///
    /// # Errors
    /// Where a file that is held can't be read on.
    pub fn content(&mut self) -> Result<Content<'_>> {
        if let Some((file, length)) = &self.in_place
            && *length > self.head.len()
        {
            return Ok(Content::of_file(Rc::clone(file), *length));
        }
        self.whole().map(Content::of_bytes)
    }

    /// All of the content, for readers that want it in one piece.
    ///
    /// # Errors
    /// Where the file can't be read on.
    pub fn whole(&mut self) -> Result<&[u8]> {
        let mut rest = std::mem::replace(&mut self.rest, Box::new(io::empty()));
        let mut head = std::mem::take(&mut self.head);
        self.read(&mut rest, &mut head)?;
        self.head = head;
        Ok(&self.head)
    }

    /// The content for readers that go through it once: its beginning, and what follows.
    pub fn parts(&mut self) -> (&[u8], &mut dyn Read) {
        (&self.head, &mut self.rest)
    }

    /// Ends the reading: the digest goes on with all of the file, and what was lost in its packing is told.
    ///
    /// # Errors
    /// Where the file can't be read, or changed meanwhile: then what was read is neither the old nor the new.
    pub fn end(self) -> Result<(Sha256, Option<String>)> {
        if let Some(mut tail) = self.tail {
            let drained = io::copy(&mut tail, &mut io::sink());
            drained.map_err(|e| Error::io("cannot read", self.path, e))?;
            tail.file.check_unchanged()?;
        }
        let mut seen = self.seen.borrow_mut();
        if let Some(fault) = seen.fault.take() {
            return Err(Error::io("cannot read", self.path, fault));
        }
        Ok((seen.hash.clone(), seen.damage.take()))
    }
}

/// A file whose bytes are hashed as they are read.
#[derive(Clone)]
struct Hashed {
    file: Rc<InputFile>,
    seen: Rc<RefCell<Seen>>,
}

impl Read for Hashed {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read_some(buffer);
        let mut seen = self.seen.borrow_mut();
        match read {
            Ok(read) => {
                seen.hash.update(&buffer[..read]);
                Ok(read)
            }
            Err(fault) => {
                let told = io::Error::new(fault.kind(), fault.to_string());
                seen.fault = Some(fault);
                Err(told)
            }
        }
    }
}

/// Content as it is unpacked; where its packing is damaged it ends, and says so.
struct Unpacking {
    from: Box<dyn Read>,
    packing: Option<&'static str>,
    unpacked: u64,
    limit: u64,
    seen: Rc<RefCell<Seen>>,
}

impl Read for Unpacking {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let fault = match self.from.read(buffer) {
            Ok(read) => {
                self.unpacked += read as u64;
                let (limit, packing) = (self.limit, self.packing);
                return match packing.filter(|_| self.unpacked > limit) {
                    Some(packing) => Err(io::Error::other(compressed::too_long(packing, limit))),
                    None => Ok(read),
                };
            }
            Err(fault) => fault, // of the packing or the file: the file's readers see to interrupts
        };
        let mut seen = self.seen.borrow_mut();
        match (self.packing, seen.fault.is_some()) {
            (Some(packing), false) if self.unpacked == 0 => {
                Err(io::Error::other(compressed::nothing(packing, &fault)))
            }
            (Some(packing), false) => {
                seen.damage = Some(compressed::damaged(packing, self.unpacked, &fault));
                self.from = Box::new(io::empty());
                Ok(0)
            }
            _ => Err(fault),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{format::Format, imported_log::ImportedLog, log_options::LogOptions};
    use std::{fs, io::Write, path::PathBuf};

    const SNAPSHOTS: usize = 400;

    fn carmen() -> Vec<u8> {
        let line = |k: usize| {
            let x = k as f64 * 0.1;
            format!("ODOM {x} 0 0 0 0 0 {k} h {k}\nFLASER 3 1.5 {x} 2 {x} 0 0 {x} 0 0 {k} h {k}\n")
        };
        (0..SNAPSHOTS).map(line).collect::<String>().into_bytes()
    }

    fn csv() -> Vec<u8> {
        let row = |k: usize| format!("{k};{},5;0;0;{k};\r\n", k / 10);
        let rows: String = (0..SNAPSHOTS).map(row).collect();
        format!("\u{feff}time_s;x_m;y_m;heading_rad;a.0;a.1\r\n{rows}").into_bytes()
    }

    fn utf_16(text: &[u8]) -> Vec<u8> {
        let text = std::str::from_utf8(text).unwrap();
        text.encode_utf16().flat_map(u16::to_le_bytes).collect()
    }

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    }

    fn bzip2(bytes: &[u8]) -> Vec<u8> {
        let mut packer = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
    }

    /// A file in a folder of its own, and what is read of it with so short a beginning.
    fn read(bytes: &[u8], head_bytes: u64) -> Result<(ImportedLog, String, Option<String>)> {
        let folder = tempfile::tempdir().unwrap();
        let path: PathBuf = folder.path().join("walk");
        fs::write(&path, bytes).unwrap();
        let mut source = Source::with_head(&path, Sha256::new(), head_bytes)?;
        let format = Format::of_content(&path, source.head())?;
        let log = format.read_source(&path, &mut source, &LogOptions::default());
        let (hash, damage) = source.end()?;
        Ok((log?, storage::hexadecimal(hash), damage))
    }

    fn same(a: &ImportedLog, b: &ImportedLog) -> bool {
        let (a, c) = (a.recording.columns(), b.recording.columns());
        let bits =
            |of: &ndarray::Array2<f32>| -> Vec<u32> { of.iter().map(|v| v.to_bits()).collect() };
        bits(&a.values) == bits(&c.values) && a.pose == c.pose && a.stamp_s == c.stamp_s
    }

    /// Whatever the packing, wherever the beginning ends, in a line or between two.
    #[test]
    fn a_log_that_is_read_bit_by_bit_is_the_log_that_is_read_at_once() {
        for text in [carmen(), csv(), utf_16(&csv()[3..])] {
            let (whole, hash, damage) = read(&text, HEAD).unwrap();
            assert_eq!((whole.recording.len(), damage), (SNAPSHOTS, None));
            assert_eq!(hash, storage::sha256(&text));
            for head_bytes in [300, 1001, text.len() as u64 - 1, text.len() as u64] {
                for packed in [text.clone(), gzip(&text), bzip2(&text), zstd(&text)] {
                    let (log, hash, damage) = read(&packed, head_bytes).unwrap();
                    assert!(same(&log, &whole), "{head_bytes}");
                    assert_eq!(log.account.used_counts(), whole.account.used_counts());
                    assert_eq!((hash, damage), (storage::sha256(&packed), None));
                }
            }
        }
    }

    /// Bags are not held in memory, but where they are packed.
    #[test]
    fn a_bag_that_is_read_here_and_there_is_the_bag_that_is_read_at_once() {
        let bags = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/bags");
        for name in ["none.bag", "plain/plain.db3", "zstd.mcap", "unchunked.mcap"] {
            let bag = fs::read(bags.join(name)).unwrap();
            let (whole, ..) = read(&bag, HEAD).unwrap();
            for head_bytes in [300, bag.len() as u64 - 1, bag.len() as u64] {
                for packed in [bag.clone(), gzip(&bag)] {
                    let (log, hash, damage) = read(&packed, head_bytes).unwrap();
                    assert!(same(&log, &whole), "{name} {head_bytes}");
                    assert_eq!(log.account, whole.account);
                    assert_eq!((hash, damage), (storage::sha256(&packed), None));
                }
            }
        }
    }

    #[test]
    fn a_packed_log_that_is_cut_gives_its_beginning_and_says_where_it_ends() {
        let (text, head_bytes) = (carmen(), 1000);
        let whole = gzip(&text);
        let (log, hash, damage) = read(&whole[..whole.len() / 2], head_bytes).unwrap();
        assert!((20..SNAPSHOTS).contains(&log.recording.len()));
        assert_eq!(hash, storage::sha256(&whole[..whole.len() / 2]));
        let damage = damage.unwrap();
        assert!(damage.contains("gzip data damaged after"), "{damage}");
        // What follows the damage is part of the file, and of its digest, though nobody unpacks it.
        let mut broken = whole.clone();
        broken.extend([0x1f, 0x8b, 0xff]);
        broken.resize(whole.len() + 3 * AT_ONCE, 0x55);
        let (log, hash, damage) = read(&broken, head_bytes).unwrap();
        assert_eq!(log.recording.len(), SNAPSHOTS);
        assert!(damage.is_some());
        assert_eq!(hash, storage::sha256(&broken));
        let fault = read(&whole[..8], head_bytes).unwrap_err().to_string();
        assert!(fault.contains("nothing can be unpacked"), "{fault}");
    }

    #[test]
    fn a_log_that_unpacks_to_more_than_any_log_is_refused_while_it_is_read() {
        let mut log = b"ODOM 0 0 0 0 0 0 0 h 0\n".to_vec();
        log.resize(200 << 20, b' ');
        let fault = read(&gzip(&log), 1000).unwrap_err().to_string();
        assert!(fault.contains("unpacks to more than"), "{fault}");
    }
}
