//! What the messages of a log hold, topic by topic, whichever container they come in.

use super::{
    cursor::Serialisation,
    frames::TransformLog,
    message::{self, Content, Kind, Message, Range, Scan, ros1_spelling},
    part::Budget,
};
use crate::recording::{
    compressed::{Packing, ZSTD_MAGIC},
    image,
    import_report::ImportReport,
};
use nalgebra::Isometry3;
use rayon::prelude::*;
use std::{collections::BTreeMap, fmt::Display};

/// Topics kept apart; messages of further ones are passed over.
const TOPICS: usize = 4096;
/// Pictures decoded at once, and bytes of them after which no further one is waited for.
const BATCH: usize = 64;
const BATCH_BYTES: usize = 16 << 20;

/// Where a container's messages come from, as it states it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Connection {
    pub topic: String,
    pub type_name: String,
    pub encoding: Encoding,
}

/// How a container says that messages are serialised.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Encoding {
    Known(Serialisation),
    Other(String),
}

/// Something with its time and the frame it was seen in.
#[derive(Debug, Clone)]
pub(super) struct Stamped<T> {
    /// By the header: when it was.
    pub stamp_s: f64,
    /// By the container: when it was written down.
    pub logged_s: f64,
    /// Number of its frame in [`Collector::frames`].
    pub frame: usize,
    pub value: T,
}

/// What came on a topic.
#[derive(Debug)]
pub(super) enum Readings {
    /// Nothing that is kept.
    None,
    Scans(Vec<Stamped<Scan>>),
    Ranges(Vec<Stamped<Range>>),
    /// Each picture as the values of the channel `camera`.
    Pictures(Vec<Stamped<Vec<f32>>>),
    Poses(Vec<Stamped<Isometry3<f64>>>),
}

/// A topic of the log.
#[derive(Debug)]
pub(super) struct Topic {
    /// In ROS 1's spelling.
    pub type_name: String,
    pub kind: Option<Kind>,
    pub readings: Readings,
    /// The frame that its poses are the poses of, where they say so.
    pub child: Option<String>,
}

/// Takes messages in and keeps what a recording needs of them.
pub(super) struct Collector<'o> {
    /// Sensor topics to take; all of them without.
    chosen: Option<&'o [String]>,
    pub account: ImportReport,
    pub topics: BTreeMap<String, Topic>,
    pub transforms: TransformLog,
    pub frames: Vec<String>,
    /// Named before what is lost: the file, of a log in several.
    pub file: Option<String>,
    /// Messages taken in, of any type.
    pub messages: u64,
    pictures: Vec<Waiting>,
    waiting_bytes: usize,
}

/// A picture to be decoded.
struct Waiting {
    topic: String,
    place: String,
    reading: Stamped<Vec<u8>>,
}

impl<'o> Collector<'o> {
    pub(super) fn new(chosen: Option<&'o [String]>) -> Self {
        Self {
            chosen,
            account: ImportReport::default(),
            topics: BTreeMap::new(),
            transforms: TransformLog::default(),
            frames: Vec::new(),
            file: None,
            messages: 0,
            pictures: Vec::new(),
            waiting_bytes: 0,
        }
    }

    /// Something of the container that had to be dropped.
    pub(super) fn lost(&mut self, place: &dyn Display, fault: &str) {
        let record = match &self.file {
            Some(file) => format!("{file}: {place}: {fault}"),
            None => format!("{place}: {fault}"),
        };
        self.account.lost(record);
    }

    /// Takes a message in; `place` is where it stands in its file.
    pub(super) fn take(
        &mut self,
        connection: &Connection,
        logged_s: f64,
        bytes: &[u8],
        place: &dyn Display,
    ) {
        self.messages += 1;
        let type_name = ros1_spelling(&connection.type_name);
        let serialisation = match &connection.encoding {
            Encoding::Known(serialisation) => *serialisation,
            Encoding::Other(encoding) => {
                let encoding = shown(encoding);
                let kind = format!("{} ({encoding})", shown(&type_name));
                return self.account.passed_over(&kind);
            }
        };
        let Some((kind, type_name)) = self.wanted(&connection.topic, type_name) else {
            return;
        };
        match message::decode(kind, bytes, serialisation) {
            Ok(message) => self.keep(&connection.topic, message, logged_s, place),
            Err(fault) => {
                let topic = shown(&connection.topic);
                self.lost(place, &format!("`{topic}` ({type_name}): {fault}"));
            }
        }
    }

    /// As [`Collector::take`], for containers whose messages may be packed one by one, as rosbag2 does it with zstd.
    pub(super) fn take_packed(
        &mut self,
        connection: &Connection,
        logged_s: f64,
        bytes: &[u8],
        place: &dyn Display,
        budget: &mut Budget,
    ) {
        // No message of any serialisation read here starts like that: CDR's first byte is 0.
        let packed = connection.encoding == Encoding::Known(Serialisation::Cdr)
            && bytes.starts_with(&ZSTD_MAGIC);
        if !packed {
            return self.take(connection, logged_s, bytes, place);
        }
        match budget.unpack_unstated(Packing::Zstd, bytes) {
            Ok(unpacked) => self.take(connection, logged_s, &unpacked, place),
            Err(fault) => {
                let fault = format!("`{}`: {fault}", shown(&connection.topic));
                self.lost(place, &fault);
            }
        }
    }

    /// The kind of a message of that topic, if it is to be decoded; otherwise it is passed over.
    fn wanted(&mut self, name: &str, type_name: String) -> Option<(Kind, String)> {
        if self.topics.len() >= TOPICS && !self.topics.contains_key(name) {
            self.account.passed_over(&shown(&type_name));
            return None;
        }
        let new = || Topic {
            kind: Kind::named(&type_name),
            type_name: type_name.clone(),
            readings: Readings::None,
            child: None,
        };
        let topic = match self.topics.get(name) {
            Some(topic) => topic,
            None => self.topics.entry(name.to_string()).or_insert_with(new),
        };
        if topic.type_name != type_name {
            self.account
                .warning("message of another type than its topic has");
            self.account.passed_over(&shown(&type_name));
            return None;
        }
        let unchosen = |kind: Kind| {
            kind.is_sensor()
                && self
                    .chosen
                    .is_some_and(|all| !all.iter().any(|t| t == name))
        };
        match topic.kind {
            Some(kind) if !unchosen(kind) => Some((kind, type_name)),
            _ => {
                self.account.passed_over(&shown(&type_name));
                None
            }
        }
    }

    fn keep(&mut self, topic: &str, message: Message, logged_s: f64, place: &dyn Display) {
        if let Content::Transforms(transforms) = message.content {
            let fixed = topic.ends_with("tf_static");
            let kept = transforms
                .into_iter()
                .all(|t| self.transforms.add(t, fixed));
            if !kept {
                self.account.warning("transform of a frame too many");
            }
            return self.account.used("tf2_msgs/TFMessage");
        }
        let frame = self.frame(message.frame);
        let stamp_s = message.stamp_s;
        let stamped = Head {
            stamp_s,
            logged_s,
            frame,
        };
        if let Content::Picture { format, file } = message.content {
            if format.contains("compressedDepth") {
                return self
                    .account
                    .passed_over("sensor_msgs/CompressedImage (compressedDepth)");
            }
            self.waiting_bytes += file.len();
            self.pictures.push(Waiting {
                topic: topic.to_string(),
                place: place.to_string(),
                reading: stamped.with(file.to_vec()),
            });
            if self.pictures.len() >= BATCH || self.waiting_bytes >= BATCH_BYTES {
                self.decode_pictures();
            }
            return;
        }
        let Some(topic) = self.topics.get_mut(topic) else {
            return; // entered by `wanted`
        };
        match message.content {
            Content::Scan(scan) => match &mut topic.readings {
                Readings::Scans(scans) => scans.push(stamped.with(scan)),
                empty => *empty = Readings::Scans(vec![stamped.with(scan)]),
            },
            Content::Range(range) => match &mut topic.readings {
                Readings::Ranges(ranges) => ranges.push(stamped.with(range)),
                empty => *empty = Readings::Ranges(vec![stamped.with(range)]),
            },
            Content::Pose { pose, child } => {
                topic.child = topic.child.take().or(child);
                match &mut topic.readings {
                    Readings::Poses(poses) => poses.push(stamped.with(pose)),
                    empty => *empty = Readings::Poses(vec![stamped.with(pose)]),
                }
            }
            Content::Picture { .. } | Content::Transforms(_) => {} // above
        }
    }

    /// Number of a frame, which is entered if it is new.
    fn frame(&mut self, name: String) -> usize {
        // Few frames, and mostly the same few last ones.
        match self.frames.iter().take(TOPICS).position(|f| *f == name) {
            Some(number) => number,
            None if self.frames.len() < TOPICS => {
                self.frames.push(name);
                self.frames.len() - 1
            }
            None => 0,
        }
    }

    /// Decodes the pictures that wait, all at once.
    pub(super) fn decode_pictures(&mut self) {
        let waiting = std::mem::take(&mut self.pictures);
        self.waiting_bytes = 0;
        let decoded: Vec<_> = waiting
            .into_par_iter()
            .map(|w| {
                let values =
                    image::decoded(&w.reading.value).map(|picture| image::features(&picture));
                (w.topic, w.place, w.reading, values)
            })
            .collect();
        for (topic, place, reading, values) in decoded {
            let values = match values {
                Ok(values) => values,
                Err(fault) => {
                    let fault = format!("`{}`: the picture {fault}", shown(&topic));
                    self.lost(&place, &fault);
                    continue;
                }
            };
            let head = Head {
                stamp_s: reading.stamp_s,
                logged_s: reading.logged_s,
                frame: reading.frame,
            };
            if let Some(topic) = self.topics.get_mut(&topic) {
                match &mut topic.readings {
                    Readings::Pictures(pictures) => pictures.push(head.with(values)),
                    empty => *empty = Readings::Pictures(vec![head.with(values)]),
                }
            }
        }
    }
}

struct Head {
    stamp_s: f64,
    logged_s: f64,
    frame: usize,
}

impl Head {
    fn with<T>(self, value: T) -> Stamped<T> {
        Stamped {
            stamp_s: self.stamp_s,
            logged_s: self.logged_s,
            frame: self.frame,
            value,
        }
    }
}

/// A name out of a log, fit to be printed.
pub(super) fn shown(name: &str) -> String {
    let name: String = name.chars().take(80).collect();
    name.escape_debug().to_string()
}
