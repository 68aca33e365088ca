//! A zstd file as a stream of bytes: block after block, frame after frame, checksums compared, and of a file that was cut all whole
//! blocks.

use ruzstd::decoding::{
    BlockDecodingStrategy, FrameDecoder,
    errors::{FrameDecoderError, ReadFrameHeaderError},
};
use std::io::{self, BufRead, Error, Read};

/// An empty last block: what completes a frame that was cut off.
const LAST_BLOCK: [u8; 3] = [1, 0, 0];
/// Room for the checksum of such a frame.
const CHECKSUM: [u8; 4] = [0; 4];

/// Reads all frames of a file.
pub(super) struct ZstdReader<R> {
    file: R,
    largest_window: u64,
    frame: Option<Frame>,
    /// A block as it stands in the file.
    block: Vec<u8>,
}

struct Frame {
    decoder: FrameDecoder,
    /// Does the file end within it?
    is_cut: bool,
}

impl<R: BufRead> ZstdReader<R> {
    /// A window larger than `limit`, which no content of that length needs, is refused.
    pub(super) fn new(file: R, limit: u64) -> Self {
        Self {
            file,
            largest_window: limit.min(128 << 20),
            frame: None,
            block: Vec::new(),
        }
    }

    /// Opens the next frame; false at the end of the file.
    fn open(&mut self) -> io::Result<bool> {
        while !self.is_at_end()? {
            let mut decoder = FrameDecoder::new();
            decoder.set_max_window_size(self.largest_window);
            match decoder.init(&mut self.file) {
                Ok(()) => {
                    self.frame = Some(Frame {
                        decoder,
                        is_cut: false,
                    });
                    return Ok(true);
                }
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                    length,
                    ..
                })) => {
                    let length = u64::from(length);
                    if io::copy(&mut (&mut self.file).take(length), &mut io::sink())? < length {
                        return Err(Error::other("a frame to skip is cut off"));
                    }
                }
                Err(fault) => return Err(Error::other(fault)),
            }
        }
        Ok(false)
    }

    fn is_at_end(&mut self) -> io::Result<bool> {
        loop {
            match self.file.fill_buf() {
                Err(fault) if fault.kind() == io::ErrorKind::Interrupted => {}
                there => return there.map(<[u8]>::is_empty),
            }
        }
    }

    /// Takes the next block from the file; false where it isn't there as a whole.
    fn next_block(&mut self) -> io::Result<bool> {
        self.block.clear();
        let file = &mut self.file;
        if file.by_ref().take(3).read_to_end(&mut self.block)? < 3 {
            return Ok(false);
        }
        let header = u32::from_le_bytes([self.block[0], self.block[1], self.block[2], 0]);
        let size = match (header >> 1) & 3 {
            1 => 1, // one byte, repeated
            _ => u64::from(header >> 3),
        };
        Ok(file.by_ref().take(size).read_to_end(&mut self.block)? as u64 == size)
    }
}

impl<R: BufRead> Read for ZstdReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            if self.frame.is_none() && !self.open()? {
                return Ok(0);
            }
            let finished = |frame: &Frame| frame.decoder.is_finished();
            let waits = |frame: &Frame| frame.decoder.can_collect() == 0 && !finished(frame);
            while self.frame.as_ref().is_some_and(waits) {
                let is_whole = self.next_block()?;
                let Some(frame) = &mut self.frame else {
                    return Ok(0); // it was there before
                };
                let block = match is_whole {
                    true => &self.block[..],
                    false => &LAST_BLOCK[..],
                };
                // Behind the last block stands a checksum, where the frame has one.
                let mut source = block.chain(&mut self.file).chain(&CHECKSUM[..]);
                let strategy = BlockDecodingStrategy::UptoBlocks(1);
                let decoded = frame.decoder.decode_blocks(&mut source, strategy);
                decoded.map_err(Error::other)?;
                frame.is_cut = !is_whole || source.get_ref().1.len() < CHECKSUM.len();
            }
            let Some(frame) = &mut self.frame else {
                return Ok(0); // opened above
            };
            let decoder = &mut frame.decoder;
            if decoder.can_collect() > 0 {
                return decoder.read(buffer);
            }
            if frame.is_cut {
                return Err(Error::other("the data are cut off"));
            }
            let stated = decoder.get_checksum_from_data();
            if stated.is_some() && stated != decoder.get_calculated_checksum() {
                return Err(Error::other("the checksum doesn't fit"));
            }
            self.frame = None;
        }
    }
}
