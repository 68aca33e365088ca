//! One array: numpy's `.npy` layout, read with every count checked against the bytes that are there.

use std::{
    fmt,
    io::{self, Read},
};

/// Number types that our files use.
pub trait Element: Copy {
    /// As numpy writes it, little-endian.
    const DESCR: &'static str;
    /// Size of one number.
    const BYTES: usize;
    /// From as many bytes, little-endian.
    fn from_le(bytes: &[u8]) -> Self;
}

macro_rules! element {
    ($($type:ty, $descr:literal);*) => {$(
        impl Element for $type {
            const DESCR: &'static str = $descr;
            const BYTES: usize = size_of::<$type>();
            fn from_le(bytes: &[u8]) -> Self {
                let mut own = [0; size_of::<$type>()];
                own.copy_from_slice(bytes);
                <$type>::from_le_bytes(own)
            }
        }
    )*};
}

element!(f32, "<f4"; f64, "<f8"; i64, "<i8"; i32, "<i4"; i16, "<i2"; u32, "<u4"; u16, "<u2"; u8, "|u1");

/// A number type that takes in the numbers of other types: people's programs write whichever they have at hand.
pub trait Widened: Element {
    /// How a number of a type, its own or one that it takes in, is read.
    fn decoder(descr: &str) -> Option<Decoder<Self>>;
}

/// Size of a number in a file, and what makes one of as many bytes.
pub type Decoder<T> = (usize, fn(&[u8]) -> T);

macro_rules! widened {
    ($($type:ty: $($other:ty),*;)*) => {$(
        impl Widened for $type {
            fn decoder(descr: &str) -> Option<Decoder<Self>> {
                $(if descr == <$other>::DESCR {
                    let decode = |bytes: &[u8]| <$other as Element>::from_le(bytes) as $type;
                    return Some((<$other>::BYTES, decode));
                })*
                own_decoder(descr)
            }
        }
    )*};
}

// Numbers of the wider float types round to the nearest, which no sensor's reading has digits enough to notice.
widened! {
    f32: f64, i64, i32, i16, u32, u16, u8;
    f64: f32, i64, i32, i16, u32, u16, u8;
    i64: i32, i16, u32, u16, u8;
}

fn own_decoder<T: Element>(descr: &str) -> Option<Decoder<T>> {
    (descr == T::DESCR).then_some((T::BYTES, T::from_le))
}

/// An array in row order.
#[derive(Debug, PartialEq)]
pub struct Array<T> {
    /// Length of every axis.
    pub shape: Vec<usize>,
    /// The numbers, last axis fastest.
    pub data: Vec<T>,
}

/// The number type of an array, as numpy writes it (`<f4`, `|u1`, …).
///
/// # Errors
/// Where the bytes are no array; the error is the fault and what was expected.
pub fn number_type(mut bytes: &[u8]) -> Result<String, String> {
    let header = read_header(&mut bytes)?;
    Header::parse(&header)
        .map(|header| header.descr.to_string())
        .ok_or_else(|| UNREADABLE.to_string())
}

const UNREADABLE: &str = "a header that can't be read; expected one as numpy writes it";

/// Reads an array of one number type.
///
/// # Errors
/// Where the bytes are no array, or hold another type or size than the header says; the error is the fault and what was
/// expected.
pub fn read<T: Element>(bytes: &[u8]) -> Result<Array<T>, String> {
    decoded(bytes, own_decoder)
}

/// Reads an array of one number type, or of another that it takes in, as its bytes come: no more than its numbers is held.
///
/// # Errors
/// As [`read`], and where `bytes` can't be read.
///
/// ```
/// use ballmark::archive::npy::read_widened;
/// let header = b"{'descr': '<i4', 'fortran_order': False, 'shape': (1,), }\n";
/// let mut array = b"\x93NUMPY\x01\x00".to_vec();
/// array.extend((header.len() as u16).to_le_bytes());
/// array.extend(header);
/// array.extend(7i32.to_le_bytes());
/// assert_eq!(read_widened::<i64>(&array[..])?.data, [7]);
/// # Ok::<(), String>(())
/// ```
pub fn read_widened<T: Widened>(bytes: impl Read) -> Result<Array<T>, String> {
    decoded(bytes, T::decoder)
}

/// The shape that the array's header states.
///
/// # Errors
/// Where the bytes are no array, or can't be read.
pub fn shape(mut bytes: impl Read) -> Result<Vec<usize>, String> {
    let header = read_header(&mut bytes)?;
    Ok(Header::parse(&header).ok_or(UNREADABLE)?.shape)
}

/// Bytes that are decoded at a time, a multiple of every number's size.
const AT_ONCE: usize = 1 << 16;

fn decoded<T: Element>(
    mut bytes: impl Read,
    decoder: impl Fn(&str) -> Option<Decoder<T>>,
) -> Result<Array<T>, String> {
    let header = read_header(&mut bytes)?;
    let header = Header::parse(&header).ok_or(UNREADABLE)?;
    let Some((size, decode)) = decoder(header.descr) else {
        return Err(format!(
            "holds numbers of type `{}`; expected `{}`",
            header.descr.escape_debug(),
            T::DESCR
        ));
    };
    let declared = header
        .shape
        .iter()
        .try_fold(size as u64, |bytes, n| bytes.checked_mul(*n as u64));
    let (mut data, mut found) = (Vec::new(), 0);
    let mut buffer = vec![0; AT_ONCE];
    loop {
        let read = fill(&mut bytes, &mut buffer)?;
        found += read as u64;
        // Past what is declared only the bytes are counted.
        if declared.is_some_and(|declared| found <= declared) {
            data.extend(buffer[..read].chunks_exact(size).map(decode));
        }
        if read < AT_ONCE {
            break;
        }
    }
    if declared != Some(found) {
        return Err(format!(
            "shape {} doesn't fit the {found} bytes that follow; expected {size} bytes a number",
            Shape(&header.shape),
        ));
    }
    let data = match (header.fortran_order, header.shape.as_slice()) {
        (true, &[rows, columns]) => (0..rows * columns)
            .map(|i| data[i % columns * rows + i / columns])
            .collect(),
        (true, shape) if shape.len() > 2 => {
            return Err("more than two dimensions; expected one or two".into());
        }
        _ => data,
    };
    Ok(Array {
        shape: header.shape,
        data,
    })
}

/// Fills a buffer as far as the bytes go; returns how far.
fn fill(bytes: &mut impl Read, buffer: &mut [u8]) -> Result<usize, String> {
    let mut filled = 0;
    while filled < buffer.len() {
        match bytes.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
            Err(e) => return Err(format!("damaged: {e}")),
        }
    }
    Ok(filled)
}

/// A shape as numpy prints it.
pub struct Shape<'a>(pub &'a [usize]);

impl fmt::Display for Shape<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<String> = self.0.iter().map(usize::to_string).collect();
        write!(f, "({})", numbers.join(", "))
    }
}

/// The text of an array's header; the numbers follow.
fn read_header(bytes: &mut impl Read) -> Result<String, String> {
    let cut = || "cut short; expected a whole array".to_string();
    let mut start = [0; 8];
    let read = fill(bytes, &mut start)?;
    let version = start[..read]
        .strip_prefix(b"\x93NUMPY")
        .ok_or("not an array; expected numpy's .npy layout")?;
    let length_bytes = match version {
        [1, ..] => 2,
        [2 | 3, ..] => 4,
        [] => return Err(cut()),
        _ => return Err("a version that is not known; expected 1, 2 or 3".into()),
    };
    let mut length = [0; 4];
    if read < start.len() || fill(bytes, &mut length[..length_bytes])? < length_bytes {
        return Err(cut());
    }
    let length = u32::from_le_bytes(length);
    let mut header = Vec::new();
    let whole = bytes.take(u64::from(length)).read_to_end(&mut header);
    whole.map_err(|e| format!("damaged: {e}"))?;
    if (header.len() as u64) < u64::from(length) {
        return Err(cut());
    }
    String::from_utf8(header).map_err(|_| "a header that isn't text".into())
}

struct Header<'a> {
    descr: &'a str,
    fortran_order: bool,
    shape: Vec<usize>,
}

impl<'a> Header<'a> {
    /// `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2), }`
    fn parse(text: &'a str) -> Option<Self> {
        let value = |key: &str| Some(text.split_once(key)?.1.trim_start());
        let descr = value("'descr':")?;
        // A structured type is a list: shown as it stands.
        let descr = match descr.strip_prefix('\'') {
            Some(quoted) => quoted.split_once('\'')?.0,
            None => descr.get(..descr.len().min(20)).unwrap_or(""),
        };
        let shape = value("'shape':")?.strip_prefix('(')?.split_once(')')?.0;
        let numbers = shape.split(',').map(str::trim).filter(|n| !n.is_empty());
        Some(Self {
            descr,
            fortran_order: value("'fortran_order':")?.starts_with("True"),
            shape: numbers.map(|n| n.parse().ok()).collect::<Option<_>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, body: &[u8]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(body);
        bytes
    }

    #[test]
    fn column_order_is_turned_into_row_order() {
        let header = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 3), }\n";
        let array = read::<u8>(&file(header, &[1, 4, 2, 5, 3, 6])).unwrap();
        assert_eq!(
            array,
            Array {
                shape: vec![2, 3],
                data: vec![1, 2, 3, 4, 5, 6]
            }
        );
    }

    #[test]
    fn what_a_header_claims_is_checked() {
        let claims = |descr: &str, shape: &str| {
            let header =
                format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
            read::<f32>(&file(&header, &[0; 8]))
                .map(|a| a.shape)
                .unwrap_err()
        };
        assert!(claims("<f8", "(2,)").contains("type `<f8`; expected `<f4`"));
        assert!(claims("<f4", "(3,)").contains("shape (3) doesn't fit the 8 bytes"));
        assert!(claims("<f4", "(99999999999, 99999999999)").contains("doesn't fit"));
        assert!(claims("<f4", "(-1,)").contains("can't be read"));
        assert!(
            read::<f32>(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{")
                .unwrap_err()
                .contains("cut short")
        );
        assert!(read::<f32>(b"hello").unwrap_err().contains("not an array"));
    }
}
