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
use crate::recording::compressed::Packing;
use flate2::Crc;
use std::collections::BTreeMap;

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
/// Bytes of a chunk besides its packing's name and its content.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;

struct Record<'a> {
    kind: u8,
    data: &'a [u8],
    /// Bytes of it that are missing behind the file's end.
    missing: u64,
}

impl<'a> Record<'a> {
    fn parse(bytes: &'a [u8]) -> Option<Self> {
        let mut rest = Bytes(bytes);
        let (kind, len) = (rest.u8()?, rest.u64()?);
        let there = usize::try_from(len).unwrap_or(usize::MAX).min(rest.0.len());
        Some(Self {
            kind,
            data: rest.take(there)?,
            missing: len - there as u64,
        })
    }

    fn len(&self) -> usize {
        HEAD + self.data.len()
    }
}

/// A chunk's content, still packed.
struct Chunk<'a> {
    size: u64,
    crc: u32,
    packing: &'a str,
    packed: &'a [u8],
    /// Bytes of it that are missing behind the file's end.
    missing: u64,
}

impl<'a> Chunk<'a> {
    fn parse(data: &'a [u8]) -> Option<Self> {
        let mut rest = Bytes(data);
        let (start, end) = (rest.u64()?, rest.u64()?);
        let (size, crc, packing) = (rest.u64()?, rest.u32()?, rest.text()?);
        let len = rest.u64()?;
        let there = usize::try_from(len).unwrap_or(usize::MAX).min(rest.0.len());
        (start <= end).then_some(Self {
            size,
            crc,
            packing,
            packed: rest.take(there)?,
            missing: len - there as u64,
        })
    }
}

/// Reads all that a file holds.
pub(super) fn read(file: &[u8], collector: &mut Collector) {
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
        let left = &file[at..];
        let record = Record::parse(left);
        let fits = record
            .as_ref()
            .is_some_and(|r| r.missing == 0 && r.kind != 0);
        let Some(record) = record.filter(|_| fits || next_chunk(file, at + 1).is_none()) else {
            // Too short for a record, or one that reaches beyond the file though a chunk follows.
            reader.damaged = true;
            let next = next_chunk(file, at + 1).unwrap_or(file.len());
            let fault = format!(
                "{} bytes that are no record; reading goes on behind them",
                next - at
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
            CHUNK => reader.chunk(at, &record),
            _ if !fits => {}
            FOOTER => {
                ended = true;
                if !summary_fits(file, at, record.data) {
                    let what =
                        "MCAP summary whose checksum doesn't fit, which nothing here depends on";
                    reader.collector.account.warning(what);
                    stated_messages = None;
                }
                break;
            }
            DATA_END => reader.data_end(&file[..at], record.data, &place),
            STATISTICS => stated_messages = Bytes(record.data).u64(),
            ATTACHMENT => reader.collector.account.passed_over("attachment"),
            METADATA => reader.collector.account.passed_over("metadata"),
            _ => reader.record(&record, &place),
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
    fn declarations_of_summary(&mut self, file: &[u8]) {
        let footer = file.len().checked_sub(FOOTER_LEN + MAGIC.len());
        let footer = footer.and_then(|at| Record::parse(&file[at..]));
        let footer = footer.filter(|record| record.kind == FOOTER);
        let start = footer.and_then(|record| Bytes(record.data).u64());
        let Some(mut at) = start.and_then(|start| usize::try_from(start).ok()) else {
            return;
        };
        while let Some(record) = file.get(at..).and_then(Record::parse) {
            match record.kind {
                SCHEMA => self.schemas.extend(schema(record.data)),
                CHANNEL => {
                    let channel = self.channel(record.data);
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

    fn chunk(&mut self, byte: usize, record: &Record) {
        let place = Place { chunk: None, byte };
        let cut = record.missing > 0;
        let Some(chunk) = Chunk::parse(record.data) else {
            if !cut {
                self.lost(&place, "a chunk whose head can't be read");
            }
            return;
        };
        let packing = match chunk.packing {
            "" => None,
            "lz4" => Some(Packing::Lz4),
            "zstd" => Some(Packing::Zstd),
            other => {
                let fault = format!("a chunk packed as `{}`; expected lz4 or zstd", shown(other));
                return self.lost(&place, &fault);
            }
        };
        if chunk.missing > 0 && !cut {
            return self.lost(&place, "a chunk whose length doesn't fit its record");
        }
        let unpacked = match self.budget.unpack(packing, chunk.packed, chunk.size, cut) {
            Ok(unpacked) => unpacked,
            Err(fault) => return self.lost(&place, &format!("the chunk holds {fault}")),
        };
        if !cut && chunk.crc != 0 && checksum(&unpacked) != chunk.crc {
            return self.lost(&place, "the chunk's checksum doesn't fit its content");
        }
        let mut at = 0;
        while at < unpacked.len() {
            let place = Place {
                chunk: Some(byte),
                byte: at,
            };
            match Record::parse(&unpacked[at..]) {
                Some(record) if record.missing == 0 => {
                    self.record(&record, &place);
                    at += record.len();
                }
                _ if cut => break,
                _ => return self.lost(&place, "no record; the rest of the chunk is lost"),
            }
        }
    }

    fn record(&mut self, record: &Record, place: &Place) {
        match record.kind {
            SCHEMA => match schema(record.data) {
                Some((number, name)) => {
                    self.schemas.insert(number, name);
                }
                None => self.lost(place, "a schema that can't be read"),
            },
            CHANNEL => match self.channel(record.data) {
                Some((number, connection)) => {
                    self.channels.insert(number, connection);
                }
                None => self.lost(place, "a channel that can't be read"),
            },
            MESSAGE => {
                self.messages += 1;
                let mut rest = Bytes(record.data);
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
            _ => {}
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
    fn data_end(&mut self, data: &[u8], record: &[u8], place: &Place) {
        let stated = Bytes(record).u32().unwrap_or(0);
        if stated != 0 && !self.damaged && checksum(data) != stated {
            let fault =
                "the checksum of the data before it doesn't fit; something in them is damaged";
            self.lost(place, fault);
        }
    }
}

/// Does the checksum of the summary fit, which reaches into the footer that begins at a byte?
fn summary_fits(file: &[u8], footer: usize, data: &[u8]) -> bool {
    let mut rest = Bytes(data);
    let (start, _, stated) = (rest.u64(), rest.u64(), rest.u32());
    match (start, stated) {
        (_, Some(0)) | (Some(0), _) => true,
        (Some(start), Some(stated)) => usize::try_from(start)
            .ok()
            .and_then(|start| file.get(start..footer + HEAD + 16))
            .is_some_and(|summary| checksum(summary) == stated),
        _ => false,
    }
}

fn schema(data: &[u8]) -> Option<(u16, String)> {
    let mut rest = Bytes(data);
    Some((rest.u16()?, rest.text()?.to_string()))
}

fn checksum(bytes: &[u8]) -> u32 {
    let mut crc = Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// Where the next whole chunk begins, from some byte on.
fn next_chunk(file: &[u8], from: usize) -> Option<usize> {
    let starts_chunk = |bytes: &[u8]| {
        let record = match bytes.first() {
            Some(&CHUNK) => Record::parse(bytes).filter(|record| record.missing == 0),
            _ => None,
        };
        record.is_some_and(|record| {
            Chunk::parse(record.data).is_some_and(|chunk| {
                CHUNK_HEAD + chunk.packing.len() + chunk.packed.len() == record.data.len()
            })
        })
    };
    (from..file.len()).find(|at| starts_chunk(&file[*at..]))
}
