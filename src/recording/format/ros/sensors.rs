//! Sensor topics as channels: which topic fills which, and what its readings mean.

use super::{
    collector::{Collector, Readings, Stamped, Topic, shown},
    frames::FrameTree,
    message::{Range, Scan},
    mounting::{Directions, directions},
    track::{TOLERANCE_S, nearest_index},
};
use crate::recording::{Channel, image, import_report::ImportReport};
use std::collections::{BTreeMap, BTreeSet};

/// Names that arrays of a dataset have besides its channels.
const RESERVED: [&str; 7] = [
    "stamp", "pose", "odometry", "run", "route", "compass", "meta",
];

/// A channel and where its values come from.
pub(super) struct Sensor {
    pub channel: Channel,
    /// Values of one topic each, side by side; several only where each has one value.
    parts: Vec<Part>,
}

struct Part {
    topic: String,
    width: usize,
    /// In the order of time.
    readings: Vec<Reading>,
}

struct Reading {
    stamp_s: f64,
    values: Vec<f32>,
}

/// All sensors of a log, the leading one first.
pub(super) struct Sensors {
    pub sensors: Vec<Sensor>,
    /// The topic whose messages are the snapshots.
    pub leader: String,
    /// Type of its messages.
    pub leader_type: String,
}

impl Sensor {
    /// Fills a snapshot's values from the readings nearest in time; false where a topic has none that is near enough.
    pub(super) fn fill(&self, stamp_s: f64, values: &mut [f32]) -> bool {
        let mut first = 0;
        let mut whole = true;
        for part in &self.parts {
            let nearest = nearest_index(&part.readings, |r| r.stamp_s, stamp_s);
            let reading = nearest
                .map(|i| &part.readings[i])
                .filter(|r| (r.stamp_s - stamp_s).abs() <= TOLERANCE_S);
            match reading {
                Some(reading) => values[first..first + part.width].copy_from_slice(&reading.values),
                None => whole = false,
            }
            first += part.width;
        }
        whole
    }
}

impl Sensors {
    /// Stamps of the leading topic's messages, in the order of time.
    pub(super) fn leading_stamps(&self) -> Vec<f64> {
        let parts = self.sensors.iter().flat_map(|sensor| &sensor.parts);
        let mut leading = parts.filter(|part| part.topic == self.leader);
        let readings = leading.next().map(|part| &part.readings[..]);
        readings
            .unwrap_or_default()
            .iter()
            .map(|r| r.stamp_s)
            .collect()
    }

    /// The other topics with the number of their messages.
    pub(super) fn further_counts(&self) -> impl Iterator<Item = (&str, usize)> {
        let parts = self.sensors.iter().flat_map(|sensor| &sensor.parts);
        let further = parts.filter(|part| part.topic != self.leader);
        further.map(|part| (part.topic.as_str(), part.readings.len()))
    }
}

/// A topic of single ranges.
type RangeTopic<'a> = (&'a str, Vec<Stamped<Range>>);

/// What is being turned into sensors.
struct Builder<'a> {
    tree: &'a FrameTree,
    frames: &'a [String],
    base: &'a str,
    max_range_m: Option<f64>,
    account: &'a mut ImportReport,
    names: BTreeSet<String>,
}

/// Turns the sensor topics into channels: laser scans first, then single ranges, then pictures, each in the order of the
/// topics' names. `None` where there is no sensor topic.
pub(super) fn sensors(
    collector: &mut Collector,
    tree: &FrameTree,
    base: &str,
    max_range_m: Option<f64>,
) -> Option<Sensors> {
    let mut builder = Builder {
        tree,
        frames: &collector.frames,
        base,
        max_range_m,
        account: &mut collector.account,
        names: RESERVED.iter().map(|name| name.to_string()).collect(),
    };
    let mut sensors = Vec::new();
    let mut leading: Vec<(String, String)> = Vec::new();
    let mut ranges: BTreeMap<bool, Vec<RangeTopic>> = BTreeMap::new();
    let mut pictures = Vec::new();
    for (name, topic) in &mut collector.topics {
        let Topic {
            type_name,
            readings,
            ..
        } = topic;
        let head = (name.clone(), type_name.clone());
        match std::mem::replace(readings, Readings::None) {
            Readings::Scans(scans) => {
                sensors.push(builder.scans(name, scans));
                leading.insert(sensors.len() - 1, head);
            }
            Readings::Ranges(all) => {
                let infrared = all.first().is_some_and(|r| r.value.infrared);
                ranges.entry(infrared).or_default().push((name, all));
                leading.push(head);
            }
            Readings::Pictures(all) => pictures.push((head, name, all)),
            other => *readings = other,
        }
    }
    for (infrared, topics) in ranges {
        sensors.push(builder.ranges(infrared, topics));
    }
    for (head, name, all) in pictures {
        sensors.push(builder.pictures(name, all));
        leading.push(head);
    }
    let (leader, leader_type) = leading.into_iter().next()?;
    // The leading topic's channel goes first: with scans it does; a single range may be of the second kind.
    let leads = |sensor: &Sensor| sensor.parts.iter().any(|part| part.topic == leader);
    sensors.sort_by_key(|sensor| !leads(sensor));
    Some(Sensors {
        sensors,
        leader,
        leader_type,
    })
}

impl Builder<'_> {
    /// The name of a topic's channel: the usual one while it is free, else made of the topic's.
    fn name(&mut self, usual: &str, topic: &str) -> String {
        let sane = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let own: String = topic.trim_matches('/').chars().map(sane).take(60).collect();
        let own = if own.is_empty() {
            usual.to_string()
        } else {
            own
        };
        let numbered = (2..).map(|n| format!("{own}_{n}"));
        let mut names = [usual.to_string(), own.clone()].into_iter().chain(numbered);
        let free = names.find(|name| !self.names.contains(name));
        let name = free.unwrap_or(own); // the numbers don't end
        self.names.insert(name.clone());
        name
    }

    /// Directions of a sensor's readings on the robot.
    fn directions(
        &mut self,
        topic: &str,
        frame: usize,
        stamps_s: [f64; 2],
        angles: &[f64],
    ) -> Option<Directions> {
        let frame = self.frames[frame].as_str();
        let topic = shown(topic);
        if frame == self.base || frame.is_empty() {
            return Some(directions(&nalgebra::Isometry3::identity(), angles));
        }
        let mounting = |stamp_s| self.tree.mounting(self.base, frame, stamp_s);
        let Some(first) = mounting(stamps_s[0]) else {
            let (base, frame) = (shown(self.base), shown(frame));
            self.account.warning(&format!(
                "sensor `{topic}` whose place on the robot isn't in the log (no transform from {base} to {frame}): taken as in its middle, facing ahead"
            ));
            return None;
        };
        if let Some(last) = mounting(stamps_s[1]) {
            let moved_m = (first.translation.vector - last.translation.vector).norm();
            if moved_m > 0.01 || first.rotation.angle_to(&last.rotation) > 0.01 {
                let what =
                    "sensor `{topic}` that moves on the robot: taken as where it is at first";
                self.account.warning(&what.replace("{topic}", &topic));
            }
        }
        let directions = directions(&first, angles);
        if let Some(left_out) = directions.left_out {
            self.account
                .warning(&format!("sensor `{topic}` {left_out}"));
        }
        Some(directions)
    }

    fn scans(&mut self, topic: &str, scans: Vec<Stamped<Scan>>) -> Sensor {
        let width = usual_width(&scans);
        let mut kept: Vec<Stamped<Scan>> = Vec::with_capacity(scans.len());
        for scan in scans {
            let found = scan.value.ranges.len();
            if found == width {
                kept.push(scan);
            } else {
                self.account.lost(format!(
                    "`{}` stamped {:.3}: {found} readings; expected {width} as in its other messages",
                    shown(topic),
                    scan.stamp_s
                ));
            }
        }
        let (first, last) = (&kept[0], &kept[kept.len() - 1]); // of the usual width there is one at least
        let (start, step) = (
            f64::from(first.value.first_rad),
            f64::from(first.value.step_rad),
        );
        let angles: Vec<f64> = (0..width).map(|i| start + i as f64 * step).collect();
        let (frame, stamps_s) = (first.frame, [first.stamp_s, last.stamp_s]);
        let directions = self.directions(topic, frame, stamps_s, &angles);
        for scan in &kept {
            let apart = (f64::from(scan.value.first_rad) - start).abs();
            let steps_apart = (f64::from(scan.value.step_rad) - step).abs() * width as f64;
            if apart.max(steps_apart) > 0.01 {
                self.account.warning(&format!(
                    "`{}`: scan of other directions than the first",
                    shown(topic)
                ));
            }
        }
        let farthest = kept.iter().map(|scan| scan.value.farthest_m);
        let maximum = self.maximum(farthest);
        let limit = self.max_range_m;
        let readings = kept.into_iter().map(|scan| {
            let Scan {
                nearest_m,
                farthest_m,
                mut ranges,
                ..
            } = scan.value;
            ranges
                .iter_mut()
                .for_each(|r| *r = distance(*r, nearest_m, farthest_m, limit));
            Reading {
                stamp_s: scan.stamp_s,
                values: ranges,
            }
        });
        let (bearing_rad, offset_m) = match directions {
            Some(directions) => (directions.bearing_rad, directions.offset_m),
            None => (angles, None),
        };
        Sensor {
            channel: Channel {
                name: self.name("laser", topic),
                width,
                unit: "m".to_string(),
                bearing_rad: Some(bearing_rad),
                maximum,
                offset_m,
            },
            parts: vec![part(topic, width, readings.collect())],
        }
    }

    /// Topics of one value each as one channel.
    fn ranges(&mut self, infrared: bool, topics: Vec<RangeTopic>) -> Sensor {
        let usual = if infrared { "infrared" } else { "sonar" };
        let (mut bearing_rad, mut offset_m) = (Vec::new(), Vec::new());
        let mut parts = Vec::new();
        let mut farthest = Vec::new();
        let limit = self.max_range_m;
        for (topic, readings) in topics {
            let (first, last) = (&readings[0], &readings[readings.len() - 1]); // a topic without any has no list
            let stamps_s = [first.stamp_s, last.stamp_s];
            if let Some(directions) = self.directions(topic, first.frame, stamps_s, &[0.0]) {
                bearing_rad.extend(directions.bearing_rad);
                offset_m.extend(directions.offset_m.unwrap_or_else(|| vec![0.0]));
            }
            farthest.extend(readings.iter().map(|r| r.value.farthest_m));
            let readings = readings.into_iter().map(|r| {
                let Range {
                    nearest_m,
                    farthest_m,
                    range,
                    ..
                } = r.value;
                Reading {
                    stamp_s: r.stamp_s,
                    values: vec![distance(range, nearest_m, farthest_m, limit)],
                }
            });
            parts.push(part(topic, 1, readings.collect()));
        }
        // A direction for each value or for none.
        let known = bearing_rad.len() == parts.len();
        let apart = known && offset_m.iter().any(|m| *m > 0.0);
        Sensor {
            channel: Channel {
                name: self.name(usual, usual),
                width: parts.len(),
                unit: "m".to_string(),
                bearing_rad: known.then_some(bearing_rad),
                maximum: self.maximum(farthest.into_iter()),
                offset_m: apart.then_some(offset_m),
            },
            parts,
        }
    }

    fn pictures(&mut self, topic: &str, pictures: Vec<Stamped<Vec<f32>>>) -> Sensor {
        let channel = image::channel();
        let readings = pictures.into_iter().map(|picture| Reading {
            stamp_s: picture.stamp_s,
            values: picture.value,
        });
        Sensor {
            parts: vec![part(topic, channel.width, readings.collect())],
            channel: Channel {
                name: self.name(&channel.name, topic),
                ..channel
            },
        }
    }

    /// The channel's maximum: the one that the user states, else the greatest of the messages'.
    fn maximum(&self, farthest_m: impl Iterator<Item = f32>) -> Option<f64> {
        let stated = farthest_m.filter(|m| m.is_finite() && *m > 0.0);
        let greatest = stated.max_by(f32::total_cmp);
        // By way of its shortest decimal form, so that 5.6 stays 5.6.
        let greatest = greatest.and_then(|m| m.to_string().parse().ok());
        self.max_range_m.or(greatest)
    }
}

fn part(topic: &str, width: usize, mut readings: Vec<Reading>) -> Part {
    readings.sort_by(|a, b| a.stamp_s.total_cmp(&b.stamp_s));
    Part {
        topic: topic.to_string(),
        width,
        readings,
    }
}

/// A reading that is a distance within its sensor's limits, or NaN. `limit_m` stands in the place of the sensor's farthest.
fn distance(reading: f32, nearest_m: f32, farthest_m: f32, limit_m: Option<f64>) -> f32 {
    let beyond = match limit_m {
        Some(limit) => f64::from(reading) >= limit,
        None => farthest_m > 0.0 && reading >= farthest_m,
    };
    if !reading.is_finite() || reading <= 0.0 || reading < nearest_m || beyond {
        f32::NAN
    } else {
        reading
    }
}

/// The number of readings that most scans have (the smaller one in a draw).
fn usual_width(scans: &[Stamped<Scan>]) -> usize {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for scan in scans {
        *counts.entry(scan.value.ranges.len()).or_default() += 1;
    }
    let usual = counts.iter().rev().max_by_key(|(_, n)| **n);
    usual.map_or(0, |(width, _)| *width)
}
