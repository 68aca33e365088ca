//! MCAP, of any profile: records of a kind and a length, most of them in chunks with checksums.
//!
//! A file is read from front to back, so it needs no summary. Where a record doesn't fit, reading goes on at the next chunk.
//! A chunk whose checksum doesn't fit its content is dropped whole. Format: the MCAP specification, version 0.

use super::{
    bytes::Bytes,
    collector::{Collector, Connection, Encoding, shown},
    cursor::Serialisation,
    part::{Budget, Place},
};
use crate::recording::{compressed::Packing, content::Content};
use flate2::Crc;
use std::{borrow::Cow, collections::BTreeMap, ops::Range};

/// What a file starts and ends with.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

const FOOTER: u8 = 2;
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const CHUNK: u8 = 6;
const ATTACHMENT: u8 = 9;
const STATISTICS: u8 = 0x0b;
const METADATA: u8 = 0x0c;
const DATA_END: u8 = 0x0f;

/// Bytes of a record's kind and length.
const HEAD: usize = 9;
/// Bytes of the record that the file ends with, but for the magic.
const FOOTER_LEN: usize = HEAD + 8 + 8 + 4;
/// Bytes ahead of a chunk's content at most, where a chunk is looked for after damage: 40 and the name of its packing.
const LONGEST_CHUNK_HEAD: usize = 1024;
/// Bytes of which a checksum is made at a time.
const SUMMED_AT_ONCE: usize = 1 << 20;

/// A record: its kind, and where its data are as far as they are there.
struct Record {
    kind: u8,
    data_at: usize,
    data_len: usize,
    /// Bytes of it that are missing behind the end.
    missing: u64,
}

impl Record {
    /// The record that begins at a byte; none where its kind and length don't fit in.
    fn at(content: &Content, at: usize) -> Option<Self> {
        let [kind] = content.number(at)?;
        let len = u64::from_le_bytes(content.number(at + 1)?);
        let data_at = at + HEAD;
        let left = content.len().checked_sub(data_at)?;
        let there = usize::try_from(len).unwrap_or(usize::MAX).min(left);
        Some(Self {
            kind,
            data_at,
            data_len: there,
            missing: len - there as u64,
        })
    }

    fn data<'a>(&self, content: &Content<'a>) -> Cow<'a, [u8]> {
        content.bytes(self.data_at, self.data_len)
    }

    fn len(&self) -> usize {
        HEAD + self.data_len
    }
}

/// What stands ahead of a chunk's content.
struct ChunkHead<'a> {
    size: u64,
    crc: u32,
    packing: &'a str,
    /// Bytes of the content, still packed.
    packed_len: u64,
    /// Bytes of this.
    len: usize,
}

impl<'a> ChunkHead<'a> {
    /// That of a chunk whose data begin so.
    fn parse(data: &'a [u8]) -> Option<Self> {
        let mut rest = Bytes(data);
        let (start, end) = (rest.u64()?, rest.u64()?);
        let (size, crc, packing) = (rest.u64()?, rest.u32()?, rest.text()?);
        let packed_len = rest.u64()?;
        (start <= end).then_some(Self {
            size,
            crc,
            packing,
            packed_len,
            len: data.len() - rest.0.len(),
        })
    }
}

/// Reads all that a file holds.
pub(super) fn read(file: &Content, collector: &mut Collector) {
    let mut reader = Reader {
        schemas: BTreeMap::new(),
        channels: BTreeMap::new(),
        budget: Budget::for_file(file.len()),
        messages: 0,
        damaged: false,
        collector,
    };
    reader.declarations_of_summary(file);
    let mut at = if file.starts_with(MAGIC) {
        MAGIC.len()
    } else {
        0
    };
    let (mut ended, mut stated_messages) = (false, None);
    while at < file.len() {
        let place = Place {
            chunk: None,
            byte: at,
        };
        let record = Record::at(file, at);
        let fits = record
            .as_ref()
            .is_some_and(|r| r.missing == 0 && r.kind != 0);
        let Some(record) = record.filter(|_| fits || next_chunk(file, at + 1).is_none()) else {
            // Too short for a record, or one that reaches beyond the file though a chunk follows.
            reader.damaged = true;
            let next = next_chunk(file, at + 1).unwrap_or(file.len());
            let fault = format!(
                "{} bytes that are no record; reading goes on behind them",
                next.saturating_sub(at)
            );
            reader.collector.lost(&place, &fault);
            at = next;
            continue;
        };
        if !fits {
            reader.damaged = true;
            let fault = format!(
                "the file ends within a record, {} bytes short",
                record.missing
            );
            reader.collector.lost(&place, &fault);
        }
        match record.kind {
            CHUNK => reader.chunk(file, at, &record),
            _ if !fits => {}
            FOOTER => {
                ended = true;
                if !summary_fits(file, at, &record.data(file)) {
                    let what =
                        "MCAP summary whose checksum doesn't fit, which nothing here depends on";
                    reader.collector.account.warning(what);
                    stated_messages = None;
                }
                break;
            }
            DATA_END => reader.data_end(file, at, &record, &place),
            STATISTICS => stated_messages = file.number(record.data_at).map(u64::from_le_bytes),
            ATTACHMENT => reader.collector.account.passed_over("attachment"),
            METADATA => reader.collector.account.passed_over("metadata"),
            _ => reader.record(file, &record, &place),
        }
        at += record.len();
    }
    let (messages, damaged) = (reader.messages, reader.damaged);
    if !ended && !damaged {
        let account = &mut collector.account;
        account.warning("MCAP file without its end, as a recorder that crashed leaves it");
    }
    match stated_messages {
        Some(stated) if stated != messages && !damaged => collector.lost(
            &"the whole",
            &format!("{messages} messages; expected {stated} as its statistics say"),
        ),
        _ => {}
    }
}

struct Reader<'c, 'o> {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Connection>,
    budget: Budget,
    messages: u64,
    damaged: bool,
    collector: &'c mut Collector<'o>,
}

impl Reader<'_, '_> {
    /// Takes the schemas and channels that the summary repeats, for a chunk whose own declarations are damaged.
    fn declarations_of_summary(&mut self, file: &Content) {
        let footer = file.len().checked_sub(FOOTER_LEN + MAGIC.len());
        let footer = footer.and_then(|at| Record::at(file, at));
        let footer = footer.filter(|record| record.kind == FOOTER);
        let start = footer.and_then(|record| file.number(record.data_at));
        let start = start.map(u64::from_le_bytes);
        let Some(mut at) = start.and_then(|start| usize::try_from(start).ok()) else {
            return;
        };
        while let Some(record) = Record::at(file, at) {
            match record.kind {
                SCHEMA => self.schemas.extend(schema(&record.data(file))),
                CHANNEL => {
                    let channel = self.channel(&record.data(file));
                    self.channels.extend(channel);
                }
                _ => {}
            }
            at += record.len();
        }
    }

    fn lost(&mut self, place: &Place, fault: &str) {
        self.damaged = true;
        self.collector.lost(place, fault);
    }

    fn chunk(&mut self, file: &Content, byte: usize, record: &Record) {
        let place = Place { chunk: None, byte };
        let cut = record.missing > 0;
        let data = record.data(file);
        let Some(chunk) = ChunkHead::parse(&data) else {
            if !cut {
                self.lost(&place, "a chunk whose head can't be read");
            }
            return;
        };
        let packed = &data[chunk.len..];
        let packed_len = usize::try_from(chunk.packed_len).unwrap_or(usize::MAX);
        let packed = &packed[..packed_len.min(packed.len())];
        let packing = match chunk.packing {
            "" => None,
            "lz4" => Some(Packing::Lz4),
            "zstd" => Some(Packing::Zstd),
            other => {
                let fault = format!("a chunk packed as `{}`; expected lz4 or zstd", shown(other));
                return self.lost(&place, &fault);
            }
        };
        if packed.len() < packed_len && !cut {
            return self.lost(&place, "a chunk whose length doesn't fit its record");
        }
        let unpacked = match self.budget.unpack(packing, packed, chunk.size, cut) {
            Ok(unpacked) => unpacked,
            Err(fault) => return self.lost(&place, &format!("the chunk holds {fault}")),
        };
        let unpacked = Content::of_bytes(&unpacked);
        if !cut && chunk.crc != 0 && checksum(&unpacked, 0..unpacked.len()) != chunk.crc {
            return self.lost(&place, "the chunk's checksum doesn't fit its content");
        }
        let mut at = 0;
        while at < unpacked.len() {
            let place = Place {
                chunk: Some(byte),
                byte: at,
            };
            match Record::at(&unpacked, at) {
                Some(record) if record.missing == 0 => {
                    self.record(&unpacked, &record, &place);
                    at += record.len();
                }
                _ if cut => break,
                _ => return self.lost(&place, "no record; the rest of the chunk is lost"),
            }
        }
    }

    fn record(&mut self, content: &Content, record: &Record, place: &Place) {
        let data = match record.kind {
            SCHEMA | CHANNEL | MESSAGE => record.data(content),
            _ => return,
        };
        match record.kind {
            SCHEMA => match schema(&data) {
                Some((number, name)) => {
                    self.schemas.insert(number, name);
                }
                None => self.lost(place, "a schema that can't be read"),
            },
            CHANNEL => match self.channel(&data) {
                Some((number, connection)) => {
                    self.channels.insert(number, connection);
                }
                None => self.lost(place, "a channel that can't be read"),
            },
            _ => {
                self.messages += 1;
                let mut rest = Bytes(&data);
                let head = rest.u16().zip(rest.u32()).zip(rest.u64().zip(rest.u64()));
                let Some(((channel, _), (logged_ns, _))) = head else {
                    return self.lost(place, "a message without its head");
                };
                let Some(connection) = self.channels.get(&channel) else {
                    let fault = format!("a message of channel {channel}, which is never declared");
                    return self.lost(place, &fault);
                };
                let logged_s = logged_ns as f64 * 1e-9;
                self.collector
                    .take_packed(connection, logged_s, rest.0, place, &mut self.budget);
            }
        }
    }

    fn channel(&self, data: &[u8]) -> Option<(u16, Connection)> {
        let mut rest = Bytes(data);
        let (number, schema) = (rest.u16()?, rest.u16()?);
        let (topic, encoding) = (rest.text()?, rest.text()?);
        let type_name = self.schemas.get(&schema).cloned();
        let encoding = match encoding {
            "ros1" => Encoding::Known(Serialisation::Ros1),
            "cdr" => Encoding::Known(Serialisation::Cdr),
            other => Encoding::Other(other.to_string()),
        };
        let connection = Connection {
            topic: topic.to_string(),
            type_name: type_name.unwrap_or_else(|| "messages without a type".to_string()),
            encoding,
        };
        Some((number, connection))
    }

    /// The checksum of everything up to the end of the data, where the file states one.
    fn data_end(&mut self, file: &Content, at: usize, record: &Record, place: &Place) {
        let stated = Bytes(&record.data(file)).u32().unwrap_or(0);
        if stated != 0 && !self.damaged && checksum(file, 0..at) != stated {
            let fault =
                "the checksum of the data before it doesn't fit; something in them is damaged";
            self.lost(place, fault);
        }
    }
}

/// Does the checksum of the summary fit, which reaches into the footer that begins at a byte?
fn summary_fits(file: &Content, footer: usize, data: &[u8]) -> bool {
    let mut rest = Bytes(data);
    let (start, _, stated) = (rest.u64(), rest.u64(), rest.u32());
    match (start, stated) {
        (_, Some(0)) | (Some(0), _) => true,
        (Some(start), Some(stated)) => usize::try_from(start)
            .ok()
            .filter(|start| (*start..=file.len()).contains(&(footer + HEAD + 16)))
            .is_some_and(|start| checksum(file, start..footer + HEAD + 16) == stated),
        _ => false,
    }
}

fn schema(data: &[u8]) -> Option<(u16, String)> {
    let mut rest = Bytes(data);
    Some((rest.u16()?, rest.text()?.to_string()))
}

fn checksum(content: &Content, places: Range<usize>) -> u32 {
    let mut crc = Crc::new();
    for at in places.clone().step_by(SUMMED_AT_ONCE) {
        crc.update(&content.bytes(at, SUMMED_AT_ONCE.min(places.end - at)));
    }
    crc.sum()
}

/// Where the next whole chunk begins, from some byte on.
fn next_chunk(file: &Content, from: usize) -> Option<usize> {
    let starts_chunk = |at: usize| {
        let record = Record::at(file, at).filter(|record| record.missing == 0)?;
        let data = file.bytes(record.data_at, record.data_len.min(LONGEST_CHUNK_HEAD));
        let head = ChunkHead::parse(&data)?;
        (head.len as u64 + head.packed_len == record.data_len as u64).then_some(at)
    };
    let mut at = from;
    while let Some([kind]) = file.number(at) {
        if kind == CHUNK && starts_chunk(at).is_some() {
            return Some(at);
        }
        at += 1;
    }
    None
}
