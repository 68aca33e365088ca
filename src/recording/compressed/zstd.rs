//! A zstd file as a stream of bytes: frame after frame, checksums compared, and of a file that was cut all whole blocks.

use ruzstd::decoding::{
    BlockDecodingStrategy, FrameDecoder,
    errors::{FrameDecoderError, ReadFrameHeaderError},
};
use std::io::{Chain, Error, Read};

/// An empty last block and room for a checksum: what completes a frame that was cut off.
const END: [u8; 7] = [1, 0, 0, 0, 0, 0, 0];

/// Reads all frames of a file.
pub(super) struct ZstdReader<'a> {
    rest: &'a [u8],
    largest_window: u64,
    frame: Option<Frame<'a>>,
}

struct Frame<'a> {
    decoder: FrameDecoder,
    /// The file from its blocks on, up to the last whole one if it was cut; then what completes the frame.
    source: Chain<&'a [u8], &'static [u8]>,
}

impl<'a> ZstdReader<'a> {
    /// A window larger than `limit`, which no content of that length needs, is refused.
    pub(super) fn new(file: &'a [u8], limit: u64) -> Self {
        Self {
            rest: file,
            largest_window: limit.min(128 << 20),
            frame: None,
        }
    }

    /// Opens the next frame; false at the end of the file.
    fn open(&mut self) -> std::io::Result<bool> {
        while !self.rest.is_empty() {
            let mut decoder = FrameDecoder::new();
            decoder.set_max_window_size(self.largest_window);
            match decoder.init(&mut self.rest) {
                Ok(()) => {
                    let (blocks, whole) = whole_blocks(self.rest);
                    let there = if whole {
                        self.rest
                    } else {
                        &self.rest[..blocks]
                    };
                    self.frame = Some(Frame {
                        decoder,
                        source: there.chain(&END[..]),
                    });
                    return Ok(true);
                }
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => {
                    let length = length as usize;
                    let behind = self.rest.get(length..);
                    self.rest = behind.ok_or_else(|| Error::other("a frame to skip is cut off"))?;
                }
                Err(fault) => return Err(Error::other(fault)),
            }
        }
        Ok(false)
    }
}

impl Read for ZstdReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        loop {
            if self.frame.is_none() && !self.open()? {
                return Ok(0);
            }
            let Some(frame) = &mut self.frame else {
                return Ok(0); // opened above
            };
            let decoder = &mut frame.decoder;
            while decoder.can_collect() == 0 && !decoder.is_finished() {
                let strategy = BlockDecodingStrategy::UptoBlocks(1);
                decoder
                    .decode_blocks(&mut frame.source, strategy)
                    .map_err(Error::other)?;
            }
            if decoder.can_collect() > 0 {
                return decoder.read(buffer);
            }
            let (rest, end) = frame.source.get_ref();
            if end.len() < END.len() {
                return Err(Error::other("the data are cut off"));
            }
            let stated = decoder.get_checksum_from_data();
            if stated.is_some() && stated != decoder.get_calculated_checksum() {
                return Err(Error::other("the checksum doesn't fit"));
            }
            self.rest = rest;
            self.frame = None;
        }
    }
}

/// Length of the whole blocks that bytes start with, and whether the last of the frame is among them.
fn whole_blocks(bytes: &[u8]) -> (usize, bool) {
    let mut at = 0;
    while let Some(header) = bytes.get(at..at + 3) {
        let header = u32::from_le_bytes([header[0], header[1], header[2], 0]);
        let size = match (header >> 1) & 3 {
            1 => 1, // one byte, repeated
            _ => (header >> 3) as usize,
        };
        let end = at + 3 + size;
        if end > bytes.len() {
            break;
        }
        at = end;
        if header & 1 == 1 {
            return (at, true);
        }
    }
    (at, false)
}
