//! rosbag 2.0, the bags of ROS 1: records of a header of named fields and data, most of them in chunks.
//!
//! A bag is read from front to back, so it needs no index. Where a record doesn't fit, reading goes on at the next place that
//! looks like one. Format: ROS wiki, "Bags/Format/2.0".

use super::{
    bytes::Bytes,
    collector::{Collector, Connection, Encoding, shown},
    cursor::Serialisation,
    part::{Budget, Place},
};
use crate::recording::{compressed::Packing, content::Content};
use std::{borrow::Cow, collections::BTreeMap};

/// What every bag of this format starts with.
pub(super) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

const MESSAGE: u8 = 2;
const BAG_HEADER: u8 = 3;
const INDEX: u8 = 4;
const CHUNK: u8 = 5;
const CHUNK_INFO: u8 = 6;
const CONNECTION: u8 = 7;

/// Longest record header that a record is looked for by after damage; it names a topic at most.
const LONGEST_HEADER: usize = 1024;

/// Longest record header that is read at all: no more is held for a length that is damaged.
const MOST_HEADER: usize = 1 << 20;

/// A record: its kind, the fields of its header, where its data are as far as the file has them.
struct Record<'a> {
    kind: u8,
    header: Cow<'a, [u8]>,
    data_at: usize,
    data_len: usize,
    /// Bytes of it that are missing behind the file's end.
    missing: usize,
    /// Bytes from its start to the next one.
    len: usize,
}

impl<'a> Record<'a> {
    /// The record that begins at a byte; `None` where the bytes don't look like one.
    fn at(content: &Content<'a>, at: usize) -> Option<Self> {
        let header_len = u32::from_le_bytes(content.number(at)?) as usize;
        if header_len > MOST_HEADER {
            return None;
        }
        let header = content.bytes(at + 4, header_len);
        let data_len = u32::from_le_bytes(content.number(at + 4 + header_len)?) as usize;
        let kind = match field(&header, b"op")? {
            [kind @ MESSAGE..=CONNECTION] => *kind,
            _ => return None,
        };
        let data_at = at + 4 + header_len + 4;
        let there = data_len.min(content.len().checked_sub(data_at)?);
        Some(Self {
            kind,
            header,
            data_at,
            data_len: there,
            missing: data_len - there,
            len: data_at - at + there,
        })
    }

    fn field(&self, name: &str) -> Option<&[u8]> {
        field(&self.header, name.as_bytes())
    }

    fn data(&self, content: &Content<'a>) -> Cow<'a, [u8]> {
        content.bytes(self.data_at, self.data_len)
    }

    fn u32(&self, name: &str) -> Option<u32> {
        Some(u32::from_le_bytes(self.field(name)?.try_into().ok()?))
    }

    fn u64(&self, name: &str) -> Option<u64> {
        Some(u64::from_le_bytes(self.field(name)?.try_into().ok()?))
    }

    /// Number and connection that a connection record declares.
    fn connection(&self, content: &Content) -> Option<(u32, Connection)> {
        let topic = std::str::from_utf8(self.field("topic")?).ok()?;
        let mut type_name = None;
        let data = content.bytes(self.data_at, self.data_len);
        let mut rest = Bytes(&data);
        while let Some(field) = rest.block() {
            if let Some(name) = field.strip_prefix(b"type=") {
                type_name = Some(std::str::from_utf8(name).ok()?);
            }
        }
        let connection = Connection {
            topic: topic.to_string(),
            type_name: type_name?.to_string(),
            encoding: Encoding::Known(Serialisation::Ros1),
        };
        Some((self.u32("conn")?, connection))
    }
}

/// The last field of that name in a record's header; none either where the header is no list of fields.
fn field<'h>(header: &'h [u8], name: &[u8]) -> Option<&'h [u8]> {
    let mut found = None;
    let mut unread = Bytes(header);
    while !unread.0.is_empty() {
        let field = unread.block()?;
        let equals = field.iter().position(|b| *b == b'=')?;
        if field[..equals] == *name {
            found = Some(&field[equals + 1..]);
        }
    }
    found
}

/// Reads all that a bag holds.
pub(super) fn read(file: &Content, collector: &mut Collector) {
    let mut reader = Reader {
        connections: BTreeMap::new(),
        budget: Budget::for_file(file.len()),
        chunks: 0,
        collector,
    };
    // The index at the end declares all connections once more, for a chunk whose own declaration is damaged.
    let declared = records(file, MAGIC.len(), |_, _| {});
    for (_, record) in declared {
        if record.kind == CONNECTION
            && let Some((number, connection)) = record.connection(file)
        {
            reader.connections.insert(number, connection);
        }
    }
    let (mut bag_header, mut infos) = (None, 0);
    let mut gaps = Vec::new();
    let mut damaged = false;
    for (byte, record) in records(file, MAGIC.len(), |byte, bytes| gaps.push((byte, bytes))) {
        damaged |= record.missing > 0;
        match record.kind {
            BAG_HEADER => {
                bag_header = record.u64("index_pos").zip(record.u32("chunk_count"));
            }
            CHUNK => reader.chunk(file, byte, &record),
            CHUNK_INFO => infos += u32::from(record.missing == 0),
            INDEX => {}
            _ => reader.record(file, Place { chunk: None, byte }, &record),
        }
    }
    damaged |= !gaps.is_empty();
    let chunks = reader.chunks;
    for (byte, bytes) in gaps {
        let fault = format!("{bytes} bytes that are no record; reading goes on behind them");
        collector.lost(&Place { chunk: None, byte }, &fault);
    }
    match bag_header {
        Some((index, _)) if index > file.len() as u64 => collector.lost(
            &"the end",
            &format!(
                "the bag ends at byte {}; expected its index at byte {index}",
                file.len()
            ),
        ),
        Some((0, _)) => collector
            .account
            .warning("bag without an index, as a recorder that crashed leaves it"),
        Some((_, stated)) if stated != chunks && !damaged => collector.lost(
            &"the whole",
            &format!("{chunks} chunks; expected {stated} as its header says"),
        ),
        Some((_, stated)) if stated != infos => collector
            .account
            .warning("bag whose index is damaged, which nothing here depends on"),
        Some(_) => {}
        None => collector.lost(&"the start", "the bag's header is damaged or missing"),
    }
}

struct Reader<'c, 'o> {
    connections: BTreeMap<u32, Connection>,
    budget: Budget,
    chunks: u32,
    collector: &'c mut Collector<'o>,
}

impl Reader<'_, '_> {
    fn chunk(&mut self, file: &Content, byte: usize, record: &Record) {
        self.chunks += 1;
        let place = Place { chunk: None, byte };
        let packing = match record.field("compression") {
            Some(b"none") => None,
            Some(b"lz4") => Some(Packing::Lz4),
            Some(b"bz2") => Some(Packing::Bzip2),
            other => {
                let name = String::from_utf8_lossy(other.unwrap_or(b""));
                let fault = format!(
                    "a chunk packed as `{}`; expected none, lz4 or bz2",
                    shown(&name)
                );
                return self.collector.lost(&place, &fault);
            }
        };
        let cut = record.missing > 0;
        if cut {
            let fault = format!("the chunk is cut off, {} bytes short", record.missing);
            self.collector.lost(&place, &fault);
        }
        let size = u64::from(record.u32("size").unwrap_or(0));
        let data = file.bytes(record.data_at, record.data_len);
        let unpacked = match self.budget.unpack(packing, &data, size, cut) {
            Ok(unpacked) => unpacked,
            Err(fault) => {
                return self
                    .collector
                    .lost(&place, &format!("the chunk holds {fault}"));
            }
        };
        let unpacked = Content::of_bytes(&unpacked);
        let (mut gaps, mut partial) = (Vec::new(), None);
        for (at, record) in records(&unpacked, 0, |at, bytes| gaps.push((at, bytes))) {
            let place = Place {
                chunk: Some(byte),
                byte: at,
            };
            if record.missing == 0 {
                self.record(&unpacked, place, &record);
            } else {
                partial = Some((at, record.len));
            }
        }
        for (at, bytes) in gaps.into_iter().chain(partial) {
            if !cut || at + bytes < unpacked.len() {
                let place = Place {
                    chunk: Some(byte),
                    byte: at,
                };
                let fault = format!("{bytes} bytes that are no record");
                self.collector.lost(&place, &fault);
            }
        }
    }

    fn record<'a>(&mut self, content: &Content<'a>, place: Place, record: &Record<'a>) {
        match record.kind {
            CONNECTION => {
                if let Some((number, connection)) = record.connection(content) {
                    self.connections.entry(number).or_insert(connection);
                } else if record.missing == 0 {
                    let fault =
                        "a connection that can't be read; expected its number, topic and type";
                    self.collector.lost(&place, fault);
                }
            }
            MESSAGE if record.missing > 0 => {
                let fault = format!("the message is cut off, {} bytes short", record.missing);
                self.collector.lost(&place, &fault);
            }
            MESSAGE => {
                let number = record.u32("conn");
                let connection = number.and_then(|number| self.connections.get(&number));
                let (Some(connection), Some(time)) = (connection, record.u64("time")) else {
                    let fault = "a message of no known connection; expected one that is declared";
                    return self.collector.lost(&place, fault);
                };
                // Seconds in the lower four bytes, nanoseconds in the upper.
                let logged_s = f64::from(time as u32) + (time >> 32) as f64 * 1e-9;
                self.collector
                    .take(connection, logged_s, &record.data(content), &place);
            }
            _ => {}
        }
    }
}

/// The records from a place on. Bytes that are no record are given to `gap`, with the place where they begin.
fn records<'c, 'a: 'c>(
    content: &'c Content<'a>,
    start: usize,
    mut gap: impl FnMut(usize, usize) + 'c,
) -> impl Iterator<Item = (usize, Record<'a>)> + 'c {
    let mut at = start.min(content.len());
    std::iter::from_fn(move || {
        if at >= content.len() {
            return None;
        }
        let found = Record::at(content, at)
            .filter(|record| record.missing == 0 || next_record(content, at + 1).is_none());
        if let Some(record) = found {
            let place = at;
            at += record.len;
            return Some((place, record));
        }
        let from = at;
        at = next_record(content, from + 1).unwrap_or(content.len());
        gap(from, at.saturating_sub(from));
        let record = Record::at(content, at)?;
        let place = at;
        at += record.len;
        Some((place, record))
    })
}

/// Where a whole record begins whose header is no longer than usual, from some byte on. One before it that would reach beyond has a
/// damaged length.
fn next_record(content: &Content, from: usize) -> Option<usize> {
    let mut at = from;
    while let Some(header) = content.number(at) {
        let header = u32::from_le_bytes(header) as usize;
        if (9..=LONGEST_HEADER).contains(&header)
            && Record::at(content, at).is_some_and(|record| record.missing == 0)
        {
            return Some(at);
        }
        at += 1;
    }
    None
}
