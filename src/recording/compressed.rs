//! Files as they come: plain, gzip (several members too) or xz (several streams too), recognised by their first bytes.

use crate::{
    error::{Error, Result},
    storage,
};
use std::{borrow::Cow, io::Read, path::Path};

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
    match file {
        [0x1f, 0x8b, ..] => drain(
            path,
            "gzip",
            flate2::bufread::MultiGzDecoder::new(file),
            file.len(),
        ),
        [0xfd, b'7', b'z', b'X', b'Z', 0, ..] => {
            let reader = lzma_rust2::XzReader::new_mem_limit(file, true, XZ_MEMORY_KIB);
            drain(path, "xz", reader, file.len())
        }
        _ => Ok(Content {
            bytes: Cow::Borrowed(file),
            damage: None,
        }),
    }
}

fn drain(
    path: &Path,
    packing: &str,
    mut reader: impl Read,
    len: usize,
) -> Result<Content<'static>> {
    let limit = storage::largest_content(len);
    let mut bytes = Vec::new();
    // What came out before a fault stays in `bytes`.
    let fault = reader
        .by_ref()
        .take(limit + 1)
        .read_to_end(&mut bytes)
        .err();
    if bytes.len() as u64 > limit {
        return Err(Error::file(
            path,
            format!(
                "{packing} data unpacks to more than {limit} bytes; expected a log of a plausible size"
            ),
        ));
    }
    match fault {
        Some(fault) if bytes.is_empty() => Err(Error::file(
            path,
            format!("damaged {packing} data, nothing can be unpacked: {fault}"),
        )),
        fault => Ok(Content {
            damage: fault.map(|fault| {
                format!(
                    "{packing} data damaged after {} unpacked bytes: {fault}",
                    bytes.len()
                )
            }),
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

    #[test]
    fn a_bomb_is_refused() {
        let bomb = gzip(&vec![0; 80 << 20]);
        let error = unpack(Path::new("bomb.gz"), &bomb).unwrap_err().to_string();
        assert!(error.contains("unpacks to more than"), "{error}");
    }
}
