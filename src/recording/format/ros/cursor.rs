//! Reading the fields of one message: ROS 1's serialisation, and CDR as ROS 2 has it, in both byte orders.
//!
//! ROS 1 packs little-endian fields without gaps; a string or an array is its length in four bytes and its content. CDR
//! (OMG Common Data Representation) starts with four bytes that name byte order and version, aligns every number to its own
//! size counted from behind these four (XCDR2: to four bytes at most), and ends strings with a NUL that their length includes.
//! A length is held against what is left of the message before anything is allocated.

/// How messages of a topic are serialised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Serialisation {
    Ros1,
    Cdr,
}

/// The unread rest of a message.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
    /// Numbers are aligned to their size, up to this; 1 where fields have no gaps.
    widest: usize,
    serialisation: Serialisation,
}

type Outcome<T> = Result<T, String>;

impl<'a> Cursor<'a> {
    pub(super) fn new(message: &'a [u8], serialisation: Serialisation) -> Outcome<Self> {
        let (bytes, big_endian, widest) = match serialisation {
            Serialisation::Ros1 => (message, false, 1),
            Serialisation::Cdr => match message {
                [0, kind @ 0..=1, _, _, rest @ ..] => (rest, *kind == 0, 8),
                [0, kind @ 6..=7, _, _, rest @ ..] => (rest, *kind == 6, 4),
                _ => {
                    let start: Vec<String> =
                        message.iter().take(4).map(|b| format!("{b:02x}")).collect();
                    return Err(format!(
                        "starts with `{}`; expected CDR: 00 01 (little-endian) or 00 00 and two bytes",
                        start.join(" ")
                    ));
                }
            },
        };
        Ok(Self {
            bytes,
            at: 0,
            big_endian,
            widest,
            serialisation,
        })
    }

    fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    fn take(&mut self, n: usize) -> Outcome<&'a [u8]> {
        if n > self.left() {
            return Err(format!(
                "ends after {} bytes, {} short; expected all fields of its type",
                self.bytes.len(),
                n - self.left()
            ));
        }
        let taken = &self.bytes[self.at..self.at + n];
        self.at += n;
        Ok(taken)
    }

    /// A number of `N` bytes, little-endian.
    fn number<const N: usize>(&mut self) -> Outcome<[u8; N]> {
        let unit = N.min(self.widest);
        self.take(self.at.next_multiple_of(unit) - self.at)?;
        let mut number = [0; N];
        number.copy_from_slice(self.take(N)?);
        if self.big_endian {
            number.reverse();
        }
        Ok(number)
    }

    pub(super) fn u8(&mut self) -> Outcome<u8> {
        self.number().map(u8::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Outcome<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub(super) fn f32(&mut self) -> Outcome<f32> {
        self.number().map(f32::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Outcome<f64> {
        self.number().map(f64::from_le_bytes)
    }

    /// The announced number of items of at least so many bytes each, as far as they can be there.
    pub(super) fn count(&mut self, least_bytes: usize) -> Outcome<usize> {
        let n = self.u32()? as usize;
        if n > self.left() / least_bytes.max(1) {
            return Err(format!(
                "announces {n} items with {} bytes left; expected a length that fits",
                self.left()
            ));
        }
        Ok(n)
    }

    pub(super) fn bytes(&mut self) -> Outcome<&'a [u8]> {
        let n = self.count(1)?;
        self.take(n)
    }

    pub(super) fn string(&mut self) -> Outcome<String> {
        let bytes = self.bytes()?;
        let text = match (self.serialisation, bytes) {
            (Serialisation::Cdr, [text @ .., 0]) => text,
            (_, text) => text,
        };
        std::str::from_utf8(text)
            .map(str::to_string)
            .map_err(|_| "holds a name that is no text; expected UTF-8".to_string())
    }

    pub(super) fn f32s(&mut self) -> Outcome<Vec<f32>> {
        let n = self.count(4)?;
        let raw = self.take(4 * n)?; // behind a length of four bytes: aligned
        let number = |b: &[u8]| {
            let b = [b[0], b[1], b[2], b[3]];
            if self.big_endian {
                f32::from_be_bytes(b)
            } else {
                f32::from_le_bytes(b)
            }
        };
        Ok(raw.chunks_exact(4).map(number).collect())
    }

    /// Passes over so many f64.
    pub(super) fn skip_f64s(&mut self, n: usize) -> Outcome<()> {
        (0..n).try_for_each(|_| self.f64().map(drop))
    }

    /// Seconds and frame of a std_msgs/Header.
    pub(super) fn header(&mut self) -> Outcome<(f64, String)> {
        if self.serialisation == Serialisation::Ros1 {
            self.u32()?; // the sequence number, which only ROS 1 has
        }
        let seconds = match self.serialisation {
            Serialisation::Ros1 => f64::from(self.u32()?),
            Serialisation::Cdr => f64::from(self.number().map(i32::from_le_bytes)?),
        };
        let nanoseconds = self.u32()?;
        if nanoseconds >= 1_000_000_000 {
            return Err(format!(
                "a stamp of {nanoseconds} ns beside the seconds; expected less than a second"
            ));
        }
        let frame = self.string()?;
        // ROS 1 wrote frames with a slash ahead, too.
        let frame = frame.strip_prefix('/').unwrap_or(&frame).to_string();
        Ok((seconds + f64::from(nanoseconds) * 1e-9, frame))
    }

    /// Nothing may be left but `spare` bytes of fields that newer versions of the type have, and CDR's padding.
    pub(super) fn end(&self, spare: usize) -> Outcome<()> {
        let padding = match self.serialisation {
            Serialisation::Ros1 => 0,
            Serialisation::Cdr => 7,
        };
        match self.left() {
            left if left <= spare + padding => Ok(()),
            left => Err(format!(
                "{left} bytes are left behind its last field; expected only the fields of its type"
            )),
        }
    }
}
