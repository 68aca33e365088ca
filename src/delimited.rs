//! Tables as people's programs write them: which encoding, what separates cells, and which decimal mark numbers have.
//!
//! Spreadsheets write semicolons and decimal commas where people do so, `Unicode text` is UTF-16 with tabs, R and MATLAB write tabs, and
//! some programs name the separator in a first line `sep=;`. All of that is seen in the header alone.

use csv::{ReaderBuilder, Trim};
use std::{borrow::Cow, io::Read, str::FromStr};

/// What may separate cells, in the order of preference.
const SEPARATORS: [u8; 3] = [b'\t', b',', b';'];
/// Bytes looked at where an encoding is guessed without a byte-order mark.
const GUESSED_BY: usize = 64;

/// A table in UTF-8, and how its cells are told apart.
///
/// ```
/// use ballmark::delimited::Delimited;
/// let table = Delimited::new(b"\xef\xbb\xbftime_s;x_m\r\n0,5;2\r\n");
/// let mut reader = table.reader();
/// assert_eq!(reader.headers()?, vec!["time_s", "x_m"]);
/// let row = reader.records().next().unwrap()?;
/// assert_eq!(table.number::<f64>(&row[0]), Some(0.5));
/// # Ok::<(), csv::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Delimited<'a> {
    text: Cow<'a, [u8]>,
    separator: u8,
    passed_over: u64,
}

impl<'a> Delimited<'a> {
    /// The table that a file's bytes are. Any bytes are one; whether they make sense is for its reader to say.
    pub fn new(bytes: &'a [u8]) -> Self {
        let mut text = in_utf8(bytes);
        let header = first_line(&text);
        let stated = header.strip_prefix(b"sep=").and_then(|rest| match rest {
            [separator] => Some(*separator),
            [] => Some(b','),
            _ => None,
        });
        let passed_over = u64::from(stated.is_some());
        if stated.is_some() {
            let end = text.iter().position(|b| *b == b'\n');
            let start = end.map_or(text.len(), |end| end + 1);
            text = match text {
                Cow::Borrowed(text) => Cow::Borrowed(&text[start..]),
                Cow::Owned(mut text) => Cow::Owned(text.split_off(start)),
            };
        }
        let separator = stated.unwrap_or_else(|| separator(first_line(&text)));
        Self {
            text,
            separator,
            passed_over,
        }
    }

    /// What reads it; rows may have more or fewer cells than the header, and spaces around cells don't count.
    pub fn reader(&self) -> csv::Reader<&[u8]> {
        self.settings().from_reader(&self.text)
    }

    /// What reads it and the rest of its file, of which it is the beginning.
    pub(crate) fn reader_with<'b>(&'b self, rest: impl Read + 'b) -> csv::Reader<impl Read + 'b> {
        self.settings().from_reader(self.text.chain(rest))
    }

    fn settings(&self) -> ReaderBuilder {
        let mut settings = ReaderBuilder::new();
        let settings_of = settings.flexible(true).trim(Trim::All);
        settings_of.delimiter(self.separator);
        settings
    }

    /// Was it in another encoding than UTF-8?
    pub(crate) fn is_converted(&self) -> bool {
        matches!(self.text, Cow::Owned(_))
    }

    /// The table in UTF-8, from its header on.
    pub fn text(&self) -> &[u8] {
        &self.text
    }

    /// Names of its columns; none where the first line is no header that can be read.
    pub fn names(&self) -> Vec<String> {
        // A table of one line is made of that line, so that a file of gigabytes isn't searched for its closing quote.
        let line = Delimited {
            text: Cow::Borrowed(first_line(&self.text)),
            separator: self.separator,
            passed_over: 0,
        };
        let names = |record: &csv::StringRecord| record.iter().map(String::from).collect();
        line.reader().headers().map(names).unwrap_or_default()
    }

    /// The line in the file, from 1, of a line that the reader counted.
    pub fn line(&self, counted: u64) -> u64 {
        counted + self.passed_over
    }

    /// The number in a cell; where cells aren't separated by commas, one comma is a decimal mark.
    pub fn number<T: FromStr>(&self, cell: &str) -> Option<T> {
        let cell = cell.trim();
        let comma = || {
            let (whole, part) = cell.split_once(',').filter(|_| self.separator != b',')?;
            let digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
            let exponent = part.find(['e', 'E']).unwrap_or(part.len());
            let plain = digits(whole.trim_start_matches(['-', '+'])) && digits(&part[..exponent]);
            plain.then(|| format!("{whole}.{part}").parse().ok())?
        };
        cell.parse().ok().or_else(comma)
    }
}

fn first_line(text: &[u8]) -> &[u8] {
    let line = text.split(|b| *b == b'\n').next().unwrap_or_default();
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// Whatever separator a header has most of outside of quotes.
pub fn separator(header: &[u8]) -> u8 {
    let mut counts = [0usize; SEPARATORS.len()];
    let mut quoted = false;
    for byte in header {
        quoted ^= *byte == b'"';
        if let Some(at) = SEPARATORS
            .iter()
            .position(|s| s == byte)
            .filter(|_| !quoted)
        {
            counts[at] += 1;
        }
    }
    // The first of several with as many.
    let most = (0..SEPARATORS.len()).rev().max_by_key(|at| counts[*at]);
    most.map_or(b',', |at| SEPARATORS[at])
}

/// Two bytes of UTF-16 in one of their orders.
type ReadUnit = fn([u8; 2]) -> u16;

/// UTF-8 without a byte-order mark; half pairs of UTF-16 become the replacement character.
fn in_utf8(bytes: &[u8]) -> Cow<'_, [u8]> {
    let (wide, read): (&[u8], ReadUnit) = match bytes {
        [0xef, 0xbb, 0xbf, text @ ..] => return Cow::Borrowed(text),
        [0xff, 0xfe, text @ ..] => (text, u16::from_le_bytes),
        [0xfe, 0xff, text @ ..] => (text, u16::from_be_bytes),
        _ => match every_second_is_zero(bytes) {
            Some(1) => (bytes, u16::from_le_bytes),
            Some(_) => (bytes, u16::from_be_bytes),
            None => return Cow::Borrowed(bytes),
        },
    };
    let units = wide.as_chunks::<2>().0.iter().map(|pair| read(*pair));
    let characters = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
    Cow::Owned(characters.collect::<String>().into_bytes())
}

/// Where zeros stand in each pair of the first bytes, if they stand in all of them and nowhere else.
fn every_second_is_zero(bytes: &[u8]) -> Option<usize> {
    let pairs = bytes[..bytes.len().min(GUESSED_BY)].as_chunks::<2>().0;
    let zero_at = |at: usize| pairs.iter().all(|pair| pair[at] == 0 && pair[1 - at] != 0);
    (0..2).find(|at| pairs.len() > 1 && zero_at(*at))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(bytes: &[u8]) -> Vec<Vec<String>> {
        let table = Delimited::new(bytes);
        let mut reader = table.reader();
        let header = reader.headers().unwrap().clone();
        let rows = reader.records().map(|row| row.unwrap());
        let all = std::iter::once(header).chain(rows);
        all.map(|row| row.iter().map(String::from).collect())
            .collect()
    }

    #[test]
    fn separators_are_seen_in_the_header() {
        for (text, first) in [
            ("a,b;c\n1,2\n", ["a", "b;c"]),
            ("a;b\n1,5;2\n", ["a", "b"]),
            ("a\tb, c\n1\t2\n", ["a", "b, c"]),
            ("\"a;;\",b\n1,2\n", ["a;;", "b"]),
            ("sep=|\r\na|b,,\r\n1|2\r\n", ["a", "b,,"]),
        ] {
            assert_eq!(cells(text.as_bytes())[0], first, "{text:?}");
        }
    }

    #[test]
    fn utf_16_is_read_with_and_without_its_mark() {
        let text = "naïve\tb\n𝄞\t2\n";
        for (mark, write) in [
            (&[0xff, 0xfe][..], u16::to_le_bytes as fn(u16) -> [u8; 2]),
            (&[0xfe, 0xff][..], u16::to_be_bytes),
        ] {
            let wide: Vec<u8> = text.encode_utf16().flat_map(write).collect();
            let marked = [mark, &wide].concat();
            assert_eq!(cells(&marked), [["naïve", "b"], ["𝄞", "2"]]);
        }
        let plain: Vec<u8> = "time_s,x_m\n1,2\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect();
        assert_eq!(cells(&plain)[1], ["1", "2"]);
        assert_eq!(Delimited::new(b"ab").text(), b"ab");
        assert!(Delimited::new(&[]).names() == Vec::<String>::new());
    }

    #[test]
    fn a_comma_is_a_decimal_mark_only_where_it_separates_nothing() {
        let semicolons = Delimited::new(b"a;b\n");
        for (cell, number) in [
            ("-0,5", Some(-0.5)),
            ("1,5e-3", Some(0.0015)),
            ("1.5", Some(1.5)),
            ("1,000,000", None),
            ("1.000,5", None),
            ("a,b", None),
        ] {
            assert_eq!(semicolons.number::<f64>(cell), number, "{cell}");
        }
        assert_eq!(Delimited::new(b"a,b\n").number::<f64>("0,5"), None);
    }

    #[test]
    fn lines_are_those_of_the_file() {
        let table = Delimited::new(b"sep=;\na;b\n1;2\n");
        let mut reader = table.reader();
        let row = reader.records().next().unwrap().unwrap();
        assert_eq!(table.line(row.position().unwrap().line()), 3);
    }
}
