//! MCAP without chunks, as ROS 2 plays it: odometry, a scan of every channel whose beams are evenly spaced, and the true poses where they
//! are given. Little-endian CDR; format: the MCAP specification, version 0.

use super::{reach_m, scans};
use crate::{geometry::Pose, recording::Recording, storage::WriteSeek};
use std::io::{self, Write};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const HEADER: u8 = 1;
const FOOTER: u8 = 2;
const SCHEMA: u8 = 3;
const CHANNEL: u8 = 4;
const MESSAGE: u8 = 5;
const STATISTICS: u8 = 0x0b;
const DATA_END: u8 = 0x0f;

/// A type of message: its name, and its definition with those of what it is made of.
struct Schema {
    name: &'static str,
    definition: &'static str,
}

const ODOMETRY: Schema = Schema {
    name: "nav_msgs/msg/Odometry",
    definition: "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n\
        geometry_msgs/TwistWithCovariance twist\n\
        ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
        ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
        ===\nMSG: geometry_msgs/PoseWithCovariance\nPose pose\nfloat64[36] covariance\n\
        ===\nMSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n\
        ===\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n\
        ===\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n\
        ===\nMSG: geometry_msgs/TwistWithCovariance\nTwist twist\nfloat64[36] covariance\n\
        ===\nMSG: geometry_msgs/Twist\nVector3 linear\nVector3 angular\n\
        ===\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
};
const SCAN: Schema = Schema {
    name: "sensor_msgs/msg/LaserScan",
    definition: "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\nfloat32 time_increment\n\
        float32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\nfloat32[] intensities\n\
        ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
        ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n",
};
const POSE: Schema = Schema {
    name: "geometry_msgs/msg/PoseStamped",
    definition: "std_msgs/Header header\ngeometry_msgs/Pose pose\n\
        ===\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
        ===\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n\
        ===\nMSG: geometry_msgs/Pose\nPoint position\nQuaternion orientation\n\
        ===\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n\
        ===\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n",
};
/// Lines between the definitions of a schema, which are `=` eighty times.
const BETWEEN: &str =
    "================================================================================";

pub(super) fn write(
    out: &mut dyn WriteSeek,
    recording: &Recording,
    poses: Option<&[Pose]>,
) -> io::Result<()> {
    let columns = recording.columns();
    let scans = scans(recording.channels());
    let mut schemas = vec![(1, &ODOMETRY), (2, &SCAN)];
    let mut topics: Vec<(u16, String)> = vec![(1, "/odom".into())];
    topics.extend(
        scans
            .iter()
            .map(|(channel, ..)| (2, format!("/{}", topic(&channel.name)))),
    );
    if poses.is_some() {
        schemas.push((3, &POSE));
        topics.push((3, "/pose".into()));
    }
    let declared: Vec<(u8, Vec<u8>)> = schemas
        .iter()
        .map(|(id, schema)| (SCHEMA, self::schema(*id, schema)))
        .chain(
            (0..)
                .zip(&topics)
                .map(|(id, (schema, name))| (CHANNEL, channel(id, *schema, name))),
        )
        .collect();
    out.write_all(MAGIC)?;
    let mut head = Vec::new();
    text(&mut head, "ros2");
    text(&mut head, concat!("ballmark ", env!("CARGO_PKG_VERSION")));
    record(out, HEADER, &head)?;
    for (kind, data) in &declared {
        record(out, *kind, data)?;
    }
    let mut counts = vec![0_u64; topics.len()];
    for k in 0..recording.len() {
        let stamp_s = columns.stamp_s[k];
        let mut put = |id: usize, cdr: Cdr| {
            counts[id] += 1;
            record(
                out,
                MESSAGE,
                &message(id as u16, counts[id] as u32, stamp_s, &cdr.0),
            )
        };
        let mut odometry = Cdr::new();
        odometry.header(stamp_s, "odom");
        odometry.string("base_link");
        odometry.pose(&columns.odometry[k]);
        odometry.f64s(&[0.0; 36 + 6 + 36]);
        put(0, odometry)?;
        for (number, (channel, begins, (first_rad, step_rad))) in scans.iter().enumerate() {
            let values = columns.values.row(k);
            let ranges = || values.iter().copied().skip(*begins).take(channel.width);
            let mut scan = Cdr::new();
            scan.header(stamp_s, "base_link");
            let last_rad = first_rad + step_rad * (channel.width - 1) as f64;
            for value in [
                *first_rad,
                last_rad,
                *step_rad,
                0.0,
                0.0,
                0.0,
                reach_m(channel, ranges()),
            ] {
                scan.f32(value as f32);
            }
            scan.u32(channel.width as u32);
            // Nothing within reach is infinity (ROS REP 117).
            ranges().for_each(|m| scan.f32(if m.is_nan() { f32::INFINITY } else { m }));
            scan.u32(0);
            put(1 + number, scan)?;
        }
        if let Some(poses) = poses {
            let mut pose = Cdr::new();
            pose.header(stamp_s, "map");
            pose.pose(&poses[k]);
            put(topics.len() - 1, pose)?;
        }
    }
    record(out, DATA_END, &0_u32.to_le_bytes())?;
    let summary = out.stream_position()?;
    for (kind, data) in &declared {
        record(out, *kind, data)?;
    }
    let stamps = (columns.stamp_s[0], columns.stamp_s[recording.len() - 1]);
    record(out, STATISTICS, &statistics(&counts, schemas.len(), stamps))?;
    let mut footer = summary.to_le_bytes().to_vec();
    footer.extend([0; 8 + 4]);
    record(out, FOOTER, &footer)?;
    out.write_all(MAGIC)
}

/// A channel's name as a topic may be called.
fn topic(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(letter).collect();
    match name.starts_with(|c: char| c.is_ascii_alphabetic()) {
        true => name,
        false => format!("scan_{name}"),
    }
}

fn record(out: &mut (impl Write + ?Sized), kind: u8, data: &[u8]) -> io::Result<()> {
    out.write_all(&[kind])?;
    out.write_all(&(data.len() as u64).to_le_bytes())?;
    out.write_all(data)
}

fn text(data: &mut Vec<u8>, text: &str) {
    data.extend((text.len() as u32).to_le_bytes());
    data.extend(text.as_bytes());
}

fn schema(id: u16, schema: &Schema) -> Vec<u8> {
    let mut data = id.to_le_bytes().to_vec();
    text(&mut data, schema.name);
    text(&mut data, "ros2msg");
    text(&mut data, &schema.definition.replace("===", BETWEEN));
    data
}

fn channel(id: u16, schema: u16, topic: &str) -> Vec<u8> {
    let mut data = id.to_le_bytes().to_vec();
    data.extend(schema.to_le_bytes());
    text(&mut data, topic);
    text(&mut data, "cdr");
    data.extend(0_u32.to_le_bytes()); // no metadata
    data
}

fn nanoseconds(stamp_s: f64) -> u64 {
    (stamp_s * 1e9).round().max(0.0) as u64
}

fn message(channel: u16, sequence: u32, stamp_s: f64, cdr: &[u8]) -> Vec<u8> {
    let mut data = channel.to_le_bytes().to_vec();
    data.extend(sequence.to_le_bytes());
    data.extend(nanoseconds(stamp_s).to_le_bytes()); // when it was logged …
    data.extend(nanoseconds(stamp_s).to_le_bytes()); // … and published
    data.extend(cdr);
    data
}

fn statistics(counts: &[u64], schemas: usize, (first_s, last_s): (f64, f64)) -> Vec<u8> {
    let mut data = counts.iter().sum::<u64>().to_le_bytes().to_vec();
    data.extend((schemas as u16).to_le_bytes());
    data.extend((counts.len() as u32).to_le_bytes());
    data.extend([0; 4 + 4 + 4]); // attachments, metadata, chunks
    data.extend(nanoseconds(first_s).to_le_bytes());
    data.extend(nanoseconds(last_s).to_le_bytes());
    data.extend((counts.len() as u32 * (2 + 8)).to_le_bytes());
    for (id, count) in (0_u16..).zip(counts) {
        data.extend(id.to_le_bytes());
        data.extend(count.to_le_bytes());
    }
    data
}

/// A message in CDR: every number at a multiple of its own size, counted from behind the four bytes that say so.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    fn align(&mut self, size: usize) {
        while !(self.0.len() - 4).is_multiple_of(size) {
            self.0.push(0);
        }
    }

    fn u32(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    fn f32(&mut self, value: f32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    fn f64s(&mut self, values: &[f64]) {
        self.align(8);
        self.0
            .extend(values.iter().flat_map(|value| value.to_le_bytes()));
    }

    fn string(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    fn header(&mut self, stamp_s: f64, frame: &str) {
        let ns = nanoseconds(stamp_s);
        self.u32((ns / 1_000_000_000) as u32);
        self.u32((ns % 1_000_000_000) as u32);
        self.string(frame);
    }

    fn pose(&mut self, pose: &Pose) {
        let half = pose.heading_rad / 2.0;
        self.f64s(&[pose.x_m, pose.y_m, 0.0, 0.0, 0.0, half.sin(), half.cos()]);
    }
}
