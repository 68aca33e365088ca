//! Files as they come: plain, gzip (several members too), xz (several streams too), bzip2 or zstd, recognised by their first
//! bytes; and the packed parts inside of logs.

use crate::{
    error::{Error, Result},
    storage,
};
use std::{
    borrow::Cow,
    io::{BufRead, Read},
    path::Path,
};
use zstd::ZstdReader;

mod zstd;

/// The first bytes of a zstd frame.
pub(super) const ZSTD_MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// Memory that the xz dictionary may take, in KiB: enough for `xz -9` (64 MiB).
const XZ_MEMORY_KIB: u32 = 128 * 1024;

/// A file's content, and what is wrong with its packing if only a part came out.
#[derive(Debug)]
pub struct Content<'a> {
    /// The unpacked bytes.
    pub bytes: Cow<'a, [u8]>,
    /// Why the rest could not be unpacked.
    pub damage: Option<String>,
}

/// Unpacks what is packed and passes the rest through.
///
/// # Errors
/// Where nothing at all comes out of a packed file, or far more than a log of its size can hold.
///
/// ```
/// use ballmark::recording::compressed::unpack;
/// let content = unpack("walk.log".as_ref(), b"ODOM 0 0 0")?;
/// assert_eq!(&*content.bytes, b"ODOM 0 0 0");
/// # Ok::<(), ballmark::Error>(())
/// ```
pub fn unpack<'a>(path: &Path, file: &'a [u8]) -> Result<Content<'a>> {
    let limit = storage::largest_content(file.len());
    match packed(file) {
        Some(packed) => drain(path, packed.name(), packed.reader(file, limit), limit),
        None => Ok(Content {
            bytes: Cow::Borrowed(file),
            damage: None,
        }),
    }
}

/// How a whole file is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packed {
    Gzip,
    Xz,
    Bzip2,
    Zstd,
}

/// Bytes by which that is known.
pub(super) const MAGIC_LENGTH: u64 = 6;

/// How a file that begins so is packed, if it is.
pub(super) fn packed(file: &[u8]) -> Option<Packed> {
    match file {
        [0x1f, 0x8b, ..] => Some(Packed::Gzip),
        [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => Some(Packed::Xz),
        [b'B', b'Z', b'h', b'1'..=b'9', ..] => Some(Packed::Bzip2),
        _ if file.starts_with(&ZSTD_MAGIC) => Some(Packed::Zstd),
        _ => None,
    }
}

impl Packed {
    /// What it is called in messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Packed::Gzip => "gzip",
            Packed::Xz => "xz",
            Packed::Bzip2 => "bzip2",
            Packed::Zstd => "zstd",
        }
    }

    /// What unpacks a file bit by bit, to no more than `limit` bytes if it is any log's.
    pub(super) fn reader<'a>(self, file: impl BufRead + 'a, limit: u64) -> Box<dyn Read + 'a> {
        match self {
            Packed::Gzip => Box::new(flate2::bufread::MultiGzDecoder::new(file)),
            Packed::Xz => Box::new(lzma_rust2::XzReader::new_mem_limit(
                file,
                true,
                XZ_MEMORY_KIB,
            )),
            Packed::Bzip2 => Box::new(bzip2::bufread::MultiBzDecoder::new(file)),
            Packed::Zstd => Box::new(ZstdReader::new(file, limit)),
        }
    }
}

/// That a file unpacks to more than any log of its size does.
pub(super) fn too_long(packing: &str, limit: u64) -> String {
    format!("{packing} data unpacks to more than {limit} bytes; expected a log of a plausible size")
}

/// That nothing of a packed file can be unpacked.
pub(super) fn nothing(packing: &str, fault: &std::io::Error) -> String {
    format!("damaged {packing} data, nothing can be unpacked: {fault}")
}

/// That no more of a packed file can be unpacked.
pub(super) fn damaged(packing: &str, unpacked: u64, fault: &std::io::Error) -> String {
    format!("{packing} data damaged after {unpacked} unpacked bytes: {fault}")
}

/// How a part of a log is packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packing {
    Bzip2,
    Lz4,
    Zstd,
}

impl Packing {
    /// What it is called in messages.
    pub(super) fn name(self) -> &'static str {
        match self {
            Packing::Bzip2 => "bzip2",
            Packing::Lz4 => "lz4",
            Packing::Zstd => "zstd",
        }
    }
}

/// A part of a log, unpacked as far as it goes.
pub(super) struct Unpacked {
    pub bytes: Vec<u8>,
    /// Why it doesn't go on.
    pub fault: Option<String>,
}

/// Unpacks a part of a log, up to `limit` bytes; more is a fault.
pub(super) fn unpack_part(packing: Packing, packed: &[u8], limit: u64) -> Unpacked {
    match packing {
        Packing::Bzip2 => read_up_to(bzip2::bufread::MultiBzDecoder::new(packed), limit),
        Packing::Lz4 => read_up_to(lz4_flex::frame::FrameDecoder::new(packed), limit),
        Packing::Zstd => read_up_to(ZstdReader::new(packed, limit), limit),
    }
}

fn read_up_to(reader: impl Read, limit: u64) -> Unpacked {
    let mut bytes = Vec::new();
    // What came out before a fault stays in `bytes`.
    let fault = reader
        .take(limit.saturating_add(1))
        .read_to_end(&mut bytes)
        .err()
        .map(|fault| fault.to_string());
    let too_long = bytes.len() as u64 > limit;
    if too_long {
        bytes.truncate(limit as usize);
    }
    Unpacked {
        fault: match too_long {
            true => Some(format!("it unpacks to more than {limit} bytes")),
            false => fault,
        },
        bytes,
    }
}

fn drain(
    path: &Path,
    packing: &str,
    mut reader: impl Read,
    limit: u64,
) -> Result<Content<'static>> {
    let mut bytes = Vec::new();
    // What came out before a fault stays in `bytes`.
    let fault = reader
        .by_ref()
        .take(limit + 1)
        .read_to_end(&mut bytes)
        .err();
    if bytes.len() as u64 > limit {
        return Err(Error::file(path, too_long(packing, limit)));
    }
    match fault {
        Some(fault) if bytes.is_empty() => Err(Error::file(path, nothing(packing, &fault))),
        fault => Ok(Content {
            damage: fault.map(|fault| damaged(packing, bytes.len() as u64, &fault)),
            bytes: Cow::Owned(bytes),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    }

    fn unpacked(file: &[u8]) -> (Vec<u8>, Option<String>) {
        let content = unpack(Path::new("log"), file).unwrap();
        (content.bytes.into_owned(), content.damage)
    }

    #[test]
    fn all_members_of_a_gzip_file_are_read() {
        let two = [gzip(b"ODOM 1\n"), gzip(b"ODOM 2\n")].concat();
        assert_eq!(unpacked(&two), (b"ODOM 1\nODOM 2\n".to_vec(), None));
    }

    #[test]
    fn a_cut_file_gives_what_it_still_holds_and_says_so() {
        let text: Vec<u8> = (0..20_000)
            .flat_map(|i| format!("ODOM {i}\n").into_bytes())
            .collect();
        let whole = gzip(&text);
        let (bytes, damage) = unpacked(&whole[..whole.len() / 2]);
        assert!(!bytes.is_empty() && text.starts_with(&bytes));
        assert!(damage.unwrap().contains("gzip data damaged"));
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
    }

    fn bzip2(bytes: &[u8]) -> Vec<u8> {
        let mut packer = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    }

    #[test]
    fn all_parts_of_zstd_and_bzip2_files_are_read() {
        for pack in [zstd, bzip2] {
            let two = [pack(b"ODOM 1\n"), pack(b"ODOM 2\n")].concat();
            assert_eq!(unpacked(&two), (b"ODOM 1\nODOM 2\n".to_vec(), None));
        }
        // A frame to be skipped lies between two others.
        let skipped = [&[0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0][..], b"any"].concat();
        let three = [zstd(b"ODOM 1\n"), skipped, zstd(b"ODOM 2\n")].concat();
        assert_eq!(unpacked(&three), (b"ODOM 1\nODOM 2\n".to_vec(), None));
    }

    #[test]
    fn a_cut_zstd_file_gives_its_whole_blocks() {
        let text: Vec<u8> = (0..100_000)
            .flat_map(|i| format!("ODOM {i}\n").into_bytes())
            .collect();
        let whole = zstd(&text);
        let (bytes, damage) = unpacked(&whole[..whole.len() / 2]);
        assert!(
            bytes.len() > text.len() / 4 && text.starts_with(&bytes),
            "{}",
            bytes.len()
        );
        assert!(damage.unwrap().contains("cut off"));
        // Without its checksum, and with a wrong one.
        let (bytes, damage) = unpacked(&whole[..whole.len() - 2]);
        assert!(bytes == text && damage.unwrap().contains("cut off"));
        let mut wrong = whole.clone();
        *wrong.last_mut().unwrap() ^= 1;
        let (bytes, damage) = unpacked(&wrong);
        assert!(bytes == text && damage.unwrap().contains("checksum"));
    }

    #[test]
    fn a_bomb_is_refused() {
        let bomb = gzip(&vec![0; 80 << 20]);
        let error = unpack(Path::new("bomb.gz"), &bomb).unwrap_err().to_string();
        assert!(error.contains("unpacks to more than"), "{error}");
    }
}
