//! Rows of the tables in an SQLite file, read page by page: no more of the format than a recorder's file needs.
//!
//! Rowid tables only, in the main file only (no write-ahead log, no journal). A page that doesn't fit is reported and left
//! out; no page is read twice, so no damage leads in a circle. Format: sqlite.org, "Database File Format".

use crate::recording::content::Content;
use std::{borrow::Cow, collections::BTreeSet};

/// What every file starts with.
pub(super) const MAGIC: &[u8] = b"SQLite format 3\0";

/// Trees deeper than this can't be.
const DEEPEST: usize = 20;
/// Columns of a row that are kept.
const COLUMNS: usize = 64;

/// A cell's value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value<'a> {
    Null,
    Integer(i64),
    Real(f64),
    Bytes(Cow<'a, [u8]>),
}

impl Value<'_> {
    pub(super) fn integer(&self) -> Option<i64> {
        match self {
            Value::Integer(value) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match self {
            Value::Bytes(bytes) => std::str::from_utf8(bytes).ok(),
            _ => None,
        }
    }
}

/// A row: its number and its cells in the order of the table's columns.
pub(super) struct Row<'a> {
    pub id: i64,
    pub cells: Vec<Value<'a>>,
}

/// A file and its layout.
pub(super) struct Database<'f, 'a> {
    file: &'f Content<'a>,
    page_size: usize,
    /// Bytes of a page that hold content.
    usable: usize,
    /// Pages that the file should have, where its header says so.
    pub stated_pages: usize,
    /// Is there a write-ahead log beside it, which may hold the last rows?
    pub write_ahead: bool,
}

impl<'f, 'a> Database<'f, 'a> {
    /// # Errors
    /// What is wrong with the file's header, in words.
    pub(super) fn open(file: &'f Content<'a>) -> Result<Self, String> {
        let header: [u8; 100] = file
            .number(0)
            .ok_or("the file ends within its header of 100 bytes")?;
        let page_size = match u16::from_be_bytes([header[16], header[17]]) {
            1 => 65536,
            size => usize::from(size),
        };
        let usable = page_size.wrapping_sub(usize::from(header[20]));
        if !page_size.is_power_of_two() || page_size < 512 || usable < 480 || usable > page_size {
            return Err(format!(
                "pages of {page_size} bytes, {} of them reserved; expected a power of two from 512 on",
                header[20]
            ));
        }
        let current = header[24..28] == header[92..96];
        let stated = u32::from_be_bytes([header[28], header[29], header[30], header[31]]);
        Ok(Self {
            file,
            page_size,
            usable,
            stated_pages: if current { stated as usize } else { 0 },
            write_ahead: header[18] == 2 || header[19] == 2,
        })
    }

    /// Whole pages that are there.
    pub(super) fn pages(&self) -> usize {
        self.file.len() / self.page_size
    }

    /// Bytes of the page of some number, from 1 on.
    fn page(&self, number: u32) -> Option<Cow<'a, [u8]>> {
        let start = (number as usize)
            .checked_sub(1)?
            .checked_mul(self.page_size)?;
        let page = self.file.bytes(start, self.page_size);
        (page.len() == self.page_size).then_some(page)
    }

    /// Root page and column names of a table.
    pub(super) fn table(&self, name: &str) -> Option<(u32, Vec<String>)> {
        let mut found = None;
        self.rows(
            1,
            &mut Visited::default(),
            &mut |row| {
                let [kind, _, table, root, sql, ..] = &row.cells[..] else {
                    return;
                };
                if kind.text() == Some("table") && table.text() == Some(name) {
                    let root = root.integer().and_then(|root| u32::try_from(root).ok());
                    let columns = sql.text().map(column_names);
                    found = found.take().or(root.zip(columns));
                }
            },
            &mut |_| {},
        );
        found
    }

    /// Gives all rows of the tree under a root to `row`, in order, and what is wrong with its pages to `fault`.
    pub(super) fn rows(
        &self,
        root: u32,
        visited: &mut Visited,
        row: &mut dyn FnMut(Row),
        fault: &mut dyn FnMut(String),
    ) {
        // Pages to be read, the next one last, each with its depth.
        let mut next = vec![(root, 0)];
        while let Some((number, depth)) = next.pop() {
            let page = match self.page(number) {
                Some(page) if depth <= DEEPEST && visited.0.insert(number) => page,
                Some(_) => {
                    fault(format!("page {number}: the tree of pages comes back to it"));
                    continue;
                }
                None => {
                    fault(format!("page {number}: not in the file"));
                    continue;
                }
            };
            if self.leaf(number, &page, visited, row, fault) {
                continue;
            }
            match self.children(number, &page) {
                Some(children) => {
                    next.extend(children.into_iter().rev().map(|child| (child, depth + 1)));
                }
                None => fault(format!("page {number}: no page of a table")),
            }
        }
    }

    /// Rows of the leaves that no tree led to, of a file whose trees are damaged.
    pub(super) fn stray_rows(&self, visited: &mut Visited, row: &mut dyn FnMut(Row)) {
        for number in 1..=self.pages() as u32 {
            if let Some(page) = self.page(number)
                && !visited.0.contains(&number)
            {
                self.leaf(number, &page, visited, row, &mut |_| {});
            }
        }
    }

    /// Reads a leaf; false where the page is none.
    fn leaf(
        &self,
        number: u32,
        page: &[u8],
        visited: &mut Visited,
        row: &mut dyn FnMut(Row),
        fault: &mut dyn FnMut(String),
    ) -> bool {
        let start = header_start(number);
        if page[start] != 0x0d {
            return false;
        }
        let cells = usize::from(u16::from_be_bytes([page[start + 3], page[start + 4]]));
        for cell in 0..cells {
            let found = cell_start(page, start + 8, cell)
                .and_then(|at| page[..self.usable].get(at..))
                .and_then(|cell| self.row(cell, visited));
            match found {
                Some(found) => row(found),
                None => fault(format!("page {number}: row {cell} can't be read")),
            }
            if start + 8 + 2 * cell >= self.usable {
                break; // more cells announced than a page holds
            }
        }
        true
    }

    /// The pages below an inner page.
    fn children(&self, number: u32, page: &[u8]) -> Option<Vec<u32>> {
        let start = header_start(number);
        if page[start] != 0x05 {
            return None;
        }
        let cells = usize::from(u16::from_be_bytes([page[start + 3], page[start + 4]]));
        let child = |at: usize| {
            let bytes = page.get(at..at + 4)?;
            Some(u32::from_be_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
        };
        let left = (0..cells).map(|cell| child(cell_start(page, start + 12, cell)?));
        left.chain([child(start + 8)]).collect()
    }

    fn row<'p>(&self, mut cell: &'p [u8], visited: &mut Visited) -> Option<Row<'p>> {
        let len = usize::try_from(varint(&mut cell)?).ok()?;
        let id = varint(&mut cell)?;
        let largest = self.usable - 35;
        let content = if len <= largest {
            Cow::Borrowed(cell.get(..len)?)
        } else {
            // What doesn't fit on the page goes on in a chain of others.
            let least = (self.usable - 12) * 32 / 255 - 23;
            let local = least + (len - least) % (self.usable - 4);
            let local = if local <= largest { local } else { least };
            Cow::Owned(self.overflowing(cell.get(..local + 4)?, len, visited)?)
        };
        Some(Row {
            id,
            cells: cells(content)?,
        })
    }

    /// Content of `len` bytes that begins in a cell, whose last four bytes name the next page.
    fn overflowing(&self, cell: &[u8], len: usize, visited: &mut Visited) -> Option<Vec<u8>> {
        if len > self.file.len() {
            return None;
        }
        let (here, &next) = cell.split_last_chunk::<4>()?;
        let mut next = next;
        let mut content = here.to_vec();
        while content.len() < len {
            let number = u32::from_be_bytes(next);
            let page = self.page(number)?;
            if !visited.0.insert(number) {
                return None;
            }
            let (&pointer, rest) = page[..self.usable].split_first_chunk::<4>()?;
            next = pointer;
            content.extend_from_slice(&rest[..rest.len().min(len - content.len())]);
        }
        Some(content)
    }
}

/// Pages read so far.
#[derive(Default)]
pub(super) struct Visited(BTreeSet<u32>);

/// The first page begins with the file's header.
fn header_start(number: u32) -> usize {
    if number == 1 { 100 } else { 0 }
}

fn cell_start(page: &[u8], pointers: usize, cell: usize) -> Option<usize> {
    let pointer = page.get(pointers + 2 * cell..pointers + 2 * cell + 2)?;
    Some(usize::from(u16::from_be_bytes([pointer[0], pointer[1]])))
}

/// A number of one to nine bytes, seven bits each, the first ones first.
fn varint(bytes: &mut &[u8]) -> Option<i64> {
    let mut value = 0_u64;
    for i in 0..9 {
        let (byte, rest) = bytes.split_first()?;
        *bytes = rest;
        if i == 8 {
            return Some((value << 8 | u64::from(*byte)) as i64);
        }
        value = value << 7 | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            break;
        }
    }
    Some(value as i64)
}

/// The cells of a row: their types first, then their values.
fn cells(content: Cow<'_, [u8]>) -> Option<Vec<Value<'_>>> {
    let mut unread = &content[..];
    let head = usize::try_from(varint(&mut unread)?).ok()?;
    let mut types = content.get(content.len() - unread.len()..head)?;
    let mut at = head;
    let mut places = Vec::new();
    while !types.is_empty() && places.len() < COLUMNS {
        let kind = varint(&mut types)?;
        let len = match kind {
            0 | 8 | 9 => 0,
            1..=4 => kind as usize,
            5 => 6,
            6 | 7 => 8,
            12.. => usize::try_from((kind - 12) / 2).ok()?,
            _ => return None,
        };
        let end = at.checked_add(len)?;
        content.get(at..end)?;
        places.push((kind, at..end));
        at = end;
    }
    let value = |(kind, place): (i64, std::ops::Range<usize>)| match kind {
        0 => Value::Null,
        1..=6 => {
            let bytes = &content[place];
            let sign = if bytes[0] & 0x80 == 0 { 0 } else { -1_i64 };
            Value::Integer(
                bytes
                    .iter()
                    .fold(sign, |value, b| value << 8 | i64::from(*b)),
            )
        }
        7 => {
            let bits = content[place]
                .iter()
                .fold(0, |bits, b| bits << 8 | u64::from(*b));
            Value::Real(f64::from_bits(bits))
        }
        8 => Value::Integer(0),
        9 => Value::Integer(1),
        _ => Value::Bytes(match &content {
            Cow::Borrowed(content) => Cow::Borrowed(&content[place]),
            Cow::Owned(content) => Cow::Owned(content[place].to_vec()),
        }),
    };
    Some(places.into_iter().map(value).collect())
}

/// Names of the columns in a `CREATE TABLE` statement, constraints left out.
fn column_names(sql: &str) -> Vec<String> {
    let inner = sql.split_once('(').map_or("", |(_, rest)| rest);
    let mut depth = 0;
    let parts = inner.split(|c: char| {
        match c {
            '(' => depth += 1,
            ')' => depth -= 1,
            _ => {}
        }
        c == ',' && depth == 0
    });
    let first_words = parts.filter_map(|part| part.split_whitespace().next());
    let bare = |word: &str| word.trim_matches(|c| "\"'`[])".contains(c)).to_string();
    first_words.map(bare).collect()
}

#[cfg(test)]
mod tests;
