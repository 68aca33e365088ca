//! Text, its lines and the numbers in them.

use crate::error::{Error, Result};
use rayon::prelude::*;
use std::path::Path;

/// Lines worked on at a time by one thread.
const SHARE: usize = 2048;

/// Characters of a line or a cell that a message quotes.
const SHOWN: usize = 24;

/// The text that bytes are, without a byte-order mark.
pub(super) fn text<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a str> {
    let what = match bytes {
        [0x1f, 0x8b, ..] => Some("is compressed with gzip"),
        [0xfd, b'7', b'z', b'X', b'Z', ..] => Some("is compressed with xz"),
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("is UTF-16 text"),
        _ => None,
    };
    if let Some(what) = what {
        let fault = format!("{what}; expected plain text in UTF-8");
        return Err(Error::file(path, fault));
    }
    let at = |end: usize| {
        let line = 1 + bytes[..end].iter().filter(|&&b| b == b'\n').count();
        format!("line {line}")
    };
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let fault = "is not UTF-8; expected poses as text: TUM, KITTI, CSV or g2o";
        Error::input(path, at(e.valid_up_to()), fault)
    })?;
    if let Some(end) = bytes.iter().position(|&b| b == 0) {
        let fault = "holds a zero byte; expected poses as text: TUM, KITTI, CSV or g2o";
        return Err(Error::input(path, at(end), fault));
    }
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// Lines that hold something, with their numbers from 1; those that begin with `#` are comments.
pub(super) fn content(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let numbered = (1..).zip(text.split('\n'));
    let trimmed = numbered.map(|(number, line)| (number, line.trim()));
    trimmed.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// What `parse` makes of every line that holds something, and the lines' numbers; the first fault is the error.
pub(super) fn rows<T: Send>(
    path: &Path,
    text: &str,
    parse: impl Fn(&str) -> std::result::Result<T, String> + Sync,
) -> Result<(Vec<u64>, Vec<T>)> {
    let lines: Vec<(u64, &str)> = content(text).collect();
    let share = |lines: &[(u64, &str)]| -> Result<Vec<T>> {
        let row = |&(number, line): &(u64, &str)| {
            parse(line).map_err(|fault| Error::input(path, format!("line {number}"), fault))
        };
        lines.iter().map(row).collect()
    };
    let shares: Vec<Result<Vec<T>>> = lines.par_chunks(SHARE).map(share).collect();
    let mut rows = Vec::with_capacity(lines.len());
    for share in shares {
        rows.extend(share?);
    }
    Ok((lines.into_iter().map(|(number, _)| number).collect(), rows))
}

/// The numbers of a line, one a name, separated by blanks; `format` is what such a line is called.
pub(super) fn numbers<const N: usize>(
    line: &str,
    names: [&str; N],
    format: &str,
) -> std::result::Result<[f64; N], String> {
    let mut found = [0.0; N];
    let mut words = line.split_ascii_whitespace();
    for (k, (value, name)) in found.iter_mut().zip(names).enumerate() {
        match words.next() {
            Some(word) => *value = number(word, name)?,
            None => return Err(miscounted(k, N, format)),
        }
    }
    match words.count() {
        0 => Ok(found),
        more => Err(miscounted(N + more, N, format)),
    }
}

fn miscounted(found: usize, expected: usize, format: &str) -> String {
    let plural = if found == 1 { "number" } else { "numbers" };
    format!("{found} {plural}; expected {expected} a line ({format})")
}

/// A finite number.
pub(super) fn number(cell: &str, name: &str) -> std::result::Result<f64, String> {
    match cell.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(format!(
            "`{}` holds `{}`; expected a finite number",
            shown(name),
            shown(cell)
        )),
    }
}

/// The beginning of what a file says, fit for one line of a message.
pub(super) fn shown(text: &str) -> String {
    let mut characters = text.chars();
    let start: String = characters.by_ref().take(SHOWN).collect();
    let rest = if characters.next().is_some() {
        "…"
    } else {
        ""
    };
    format!("{}{rest}", start.escape_debug())
}
