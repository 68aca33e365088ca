//! Parts of a container: where they stand, and how packed ones are unpacked within bounds.

use crate::{
    recording::compressed::{Packing, unpack_part},
    storage,
};
use std::{borrow::Cow, fmt};

/// A place in a file, or in a chunk of it once that is unpacked.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub chunk: Option<usize>,
    pub byte: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.chunk {
            None => write!(f, "byte {}", self.byte),
            Some(chunk) => write!(f, "chunk at byte {chunk}, byte {} in it", self.byte),
        }
    }
}

/// How much more all packed parts of a file together may unpack to.
pub(super) struct Budget {
    left: u64,
}

impl Budget {
    /// For a file of so many bytes, as much as for a packed file of that length.
    pub(super) fn for_file(len: usize) -> Self {
        Self {
            left: storage::largest_content(len),
        }
    }

    /// Unpacks a part that should have `size` bytes then. A part that the file's end cuts is unpacked as far as it goes; one
    /// that is there and doesn't fit its packing or its size is refused, since nothing of it can be trusted.
    pub(super) fn unpack<'a>(
        &mut self,
        packing: Option<Packing>,
        packed: &'a [u8],
        size: u64,
        cut: bool,
    ) -> Result<Cow<'a, [u8]>, String> {
        let Some(packing) = packing else {
            if !cut && packed.len() as u64 != size {
                return Err(format!("{} bytes; expected {size}", packed.len()));
            }
            return Ok(Cow::Borrowed(packed));
        };
        let unpacked = unpack_part(packing, packed, size.min(self.left));
        self.left -= (unpacked.bytes.len() as u64).min(self.left);
        match unpacked.fault {
            Some(_) if cut => {}
            Some(fault) => return Err(format!("damaged {} data: {fault}", packing.name())),
            None if unpacked.bytes.len() as u64 == size || cut => {}
            None => {
                let n = unpacked.bytes.len();
                return Err(format!(
                    "{} data that unpack to {n} bytes; expected {size}",
                    packing.name()
                ));
            }
        }
        Ok(Cow::Owned(unpacked.bytes))
    }

    /// Unpacks a part that doesn't say how long it is then.
    pub(super) fn unpack_unstated(
        &mut self,
        packing: Packing,
        packed: &[u8],
    ) -> Result<Vec<u8>, String> {
        let unpacked = unpack_part(packing, packed, self.left);
        self.left -= (unpacked.bytes.len() as u64).min(self.left);
        match unpacked.fault {
            None => Ok(unpacked.bytes),
            Some(fault) => Err(format!("damaged {} data: {fault}", packing.name())),
        }
    }
}
