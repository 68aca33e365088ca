//! One array: numpy's `.npy` layout, read with every count checked against the bytes that are there.

use std::fmt;

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
    /// Reads an array of another type than its own, where this type takes it in.
    fn of_other(descr: &str, bytes: &[u8]) -> Option<Result<Array<Self>, String>>;
}

macro_rules! widened {
    ($($type:ty: $($other:ty),*;)*) => {$(
        impl Widened for $type {
            fn of_other(descr: &str, bytes: &[u8]) -> Option<Result<Array<Self>, String>> {
                $(if descr == <$other>::DESCR {
                    return Some(read::<$other>(bytes).map(|array| Array {
                        shape: array.shape,
                        data: array.data.into_iter().map(|number| number as $type).collect(),
                    }));
                })*
                None
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

/// Reads an array of one number type, or of another that it takes in.
///
/// # Errors
/// As [`read`].
///
/// ```
/// use ballmark::archive::npy::read_widened;
/// let header = b"{'descr': '<i4', 'fortran_order': False, 'shape': (1,), }\n";
/// let mut array = b"\x93NUMPY\x01\x00".to_vec();
/// array.extend((header.len() as u16).to_le_bytes());
/// array.extend(header);
/// array.extend(7i32.to_le_bytes());
/// assert_eq!(read_widened::<i64>(&array)?.data, [7]);
/// # Ok::<(), String>(())
/// ```
pub fn read_widened<T: Widened>(bytes: &[u8]) -> Result<Array<T>, String> {
    match T::of_other(number_type(bytes)?, bytes) {
        Some(array) => array,
        None => read(bytes),
    }
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
pub fn number_type(bytes: &[u8]) -> Result<&str, String> {
    let (header, _) = split_header(bytes)?;
    Header::parse(header)
        .map(|header| header.descr)
        .ok_or_else(|| UNREADABLE.to_string())
}

const UNREADABLE: &str = "a header that can't be read; expected one as numpy writes it";

/// Reads an array of one number type.
///
/// # Errors
/// Where the bytes are no array, or hold another type or size than the header says; the error is the fault and what was
/// expected.
pub fn read<T: Element>(bytes: &[u8]) -> Result<Array<T>, String> {
    let (header, body) = split_header(bytes)?;
    let header = Header::parse(header).ok_or(UNREADABLE)?;
    if header.descr != T::DESCR {
        return Err(format!(
            "holds numbers of type `{}`; expected `{}`",
            header.descr.escape_debug(),
            T::DESCR
        ));
    }
    let declared = header
        .shape
        .iter()
        .try_fold(T::BYTES, |bytes, n| bytes.checked_mul(*n));
    if declared != Some(body.len()) {
        return Err(format!(
            "shape {} doesn't fit the {} bytes that follow; expected {} bytes a number",
            Shape(&header.shape),
            body.len(),
            T::BYTES
        ));
    }
    let data: Vec<T> = body.chunks_exact(T::BYTES).map(T::from_le).collect();
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

/// A shape as numpy prints it.
pub struct Shape<'a>(pub &'a [usize]);

impl fmt::Display for Shape<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers: Vec<String> = self.0.iter().map(usize::to_string).collect();
        write!(f, "({})", numbers.join(", "))
    }
}

fn split_header(bytes: &[u8]) -> Result<(&str, &[u8]), String> {
    let cut = || "cut short; expected a whole array".to_string();
    let rest = bytes
        .strip_prefix(b"\x93NUMPY")
        .ok_or("not an array; expected numpy's .npy layout")?;
    let (len, rest) = match rest {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        [1..=3, ..] => return Err(cut()),
        _ => return Err("a version that is not known; expected 1, 2 or 3".into()),
    };
    let (header, body) = rest.split_at_checked(len).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| "a header that isn't text")?;
    Ok((header, body))
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
