//! The same drive in every container, whole and damaged (`tests/bags`, written by other people's writers).

mod windows;

use super::*;
use crate::{
    recording::{Recording, compressed, imported_log::OdometrySource},
    seed::Seed,
};
use rand::RngExt;
use sha2::{Digest, Sha256};
use std::{path::PathBuf, time::Instant};

/// Files whose bytes are damaged: each container, with each packing.
const FILES: [&str; 10] = [
    "none.bag",
    "lz4.bag",
    "bz2.bag",
    "plain/plain.db3",
    "packed_messages/packed_messages.db3",
    "none.mcap",
    "lz4.mcap",
    "zstd.mcap",
    "unchunked.mcap",
    "ros1.mcap",
];

/// And files that are packed as a whole, of which a damage may leave nothing, or hold a part of the drive.
const OTHERS: [&str; 4] = [
    "packed_file/packed_file.db3.zstd",
    "packed_mcap/packed_mcap.mcap.zstd",
    "split/split_0.mcap",
    "split/split_1.mcap",
];

fn bag(name: &str) -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    root.join("tests/bags").join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(bag(name)).unwrap()
}

/// Reads a file's content as `import` would.
fn read_bytes(name: &str, file: &[u8], options: &LogOptions) -> Result<ImportedLog> {
    let path = Path::new(name);
    let content = compressed::unpack(path, file)?;
    crate::recording::format::Format::of_content(path, &content.bytes)?.read(
        path,
        &content.bytes,
        options,
    )
}

fn read(name: &str) -> ImportedLog {
    let options = LogOptions::default();
    let log = match bag(name).is_dir() {
        true => read_folder(&bag(name), &options, Sha256::new()).map(|(log, _)| log),
        false => read_bytes(name, &bytes(name), &options),
    };
    log.unwrap_or_else(|error| panic!("{error}"))
}

/// All that a recording holds, bit by bit.
fn content(recording: &Recording) -> impl PartialEq + std::fmt::Debug {
    let c = recording.columns();
    let values: Vec<u32> = c.values.iter().map(|v| v.to_bits()).collect();
    let columns = (c.stamp_s.clone(), c.pose.clone(), c.odometry.clone());
    (c.channels.clone(), values, columns, c.run.clone())
}

#[test]
fn the_drive_is_what_the_script_made_of_it() {
    let log = read("none.bag");
    assert_eq!(log.account.lost_count(), 0);
    assert!(log.account.warning_counts().is_empty(), "{:?}", log.account);
    assert_eq!(log.account.passed_over_counts()["std_msgs/String"], 2);
    assert_eq!(
        log.account.passed_over_counts()["geometry_msgs/PoseWithCovarianceStamped"],
        5
    );
    assert_eq!(log.account.used_counts()["sensor_msgs/LaserScan"], 6);
    assert_eq!(log.odometry, OdometrySource::Interpolated);
    let c = log.recording.columns();
    let channels: Vec<_> = c
        .channels
        .iter()
        .map(|c| (c.name.as_str(), c.width, c.maximum))
        .collect();
    assert_eq!(
        channels,
        [
            ("laser", 16, Some(8.0)),
            ("sonar", 1, Some(4.0)),
            ("camera", 140, None)
        ]
    );
    for k in 0..6 {
        let t = 0.15 + 0.3 * k as f64;
        assert!((c.stamp_s[k] - 1.7e9 - t).abs() < 1e-6);
        let turn = 0.1 * t;
        let arc = |radius: f64| (radius * turn.sin(), radius * (1.0 - turn.cos()));
        let ((x, y), (odometry_x, odometry_y)) = (arc(4.0), arc(4.08));
        let (pose, odometry) = (c.pose[k], c.odometry[k]);
        assert!(
            (pose.x_m - x - 1.0).abs() < 1e-3 && (pose.y_m - y + 2.0).abs() < 1e-3,
            "{pose:?}"
        );
        assert!(
            (odometry.x_m - odometry_x).abs() < 1e-3 && (odometry.y_m - odometry_y).abs() < 1e-3
        );
        assert!(
            (pose.heading_rad - turn).abs() < 1e-7 && (odometry.heading_rad - turn).abs() < 1e-7
        );
        let row = c.values.row(k);
        assert!((f64::from(row[7]) - (3.25 + 0.125 * (t + 7.0).sin())).abs() < 1e-6);
        assert!(
            row.iter().skip(3).take(3).all(|v| v.is_nan()),
            "no return, too near, too far"
        );
        assert_eq!(row.iter().filter(|v| v.is_nan()).count(), 3);
        assert!(
            (f64::from(row[16]) - 1.0 - 0.1 * t).abs() < 0.02,
            "the sonar nearest in time"
        );
    }
    let laser = &c.channels[0];
    let bearing_rad = laser.bearing_rad.as_ref().unwrap();
    assert!((bearing_rad[4] + std::f64::consts::FRAC_PI_4).abs() < 1e-6);
    assert!((laser.offset_of(8) - 0.2).abs() < 1e-6 && laser.offset_of(0) < 1e-6);
    let sonar = &c.channels[1];
    assert!((sonar.bearing_rad.as_ref().unwrap()[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    assert!((sonar.offset_of(0) - 0.15).abs() < 1e-9);
}

#[test]
fn every_container_gives_the_same_recording() {
    let expected = read("none.bag");
    for name in FILES.into_iter().chain([
        "zstd.mcap",
        "plain",
        "packed_messages",
        "packed_file",
        "packed_file/packed_file.db3.zstd",
        "packed_mcap",
        "split",
    ]) {
        let log = read(name);
        assert_eq!(
            content(&log.recording),
            content(&expected.recording),
            "{name}"
        );
        assert_eq!(
            log.account.used_counts(),
            expected.account.used_counts(),
            "{name}"
        );
        assert_eq!(
            (log.account.lost_count(), log.account.warning_counts().len()),
            (0, 0),
            "{name}"
        );
    }
}

/// Reads damaged bytes: whatever comes of it comes soon. Gives snapshots and losses; none where nothing can be read.
fn survive(name: &str, file: &[u8], whole: &ImportedLog) -> Option<ImportedLog> {
    let start = Instant::now();
    let log = read_bytes(name, file, &LogOptions::default());
    assert!(
        start.elapsed().as_secs() < 5,
        "{name}: {:?}",
        start.elapsed()
    );
    let log = log.ok()?;
    // The scans, or without their topic the sonar's readings.
    let most = whole.account.used_counts()["sensor_msgs/Range"];
    assert!(log.recording.len() <= most, "{name}");
    Some(log)
}

/// Where records begin, those in chunks that aren't packed as well, and pages of tables.
fn records(name: &str, file: &[u8]) -> Vec<usize> {
    let u32_at = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    let mut begins = Vec::new();
    if name.ends_with(".bag") {
        let mut at = rosbag1::MAGIC.len();
        while at + 8 <= file.len() {
            begins.push(at);
            let header = u32_at(at);
            let is = |field: &[u8]| {
                file[at..at + 4 + header]
                    .windows(field.len())
                    .any(|w| w == field)
            };
            // Into a chunk that isn't packed, over all else.
            let into = is(b"op=\x05") && is(b"compression=none");
            at += 4 + header + 4 + if into { 0 } else { u32_at(at + 4 + header) };
        }
    } else if name.ends_with(".mcap") {
        let mut at = mcap::MAGIC.len();
        while at + 9 <= file.len() && !file[at..].starts_with(mcap::MAGIC) {
            begins.push(at);
            // Start, end, size, checksum; a name without letters for what isn't packed; and the size of what follows.
            let head = 9 + 8 + 8 + 8 + 4;
            let into = file[at] == 6 && u32_at(at + head) == 0;
            at += if into {
                head + 4 + 8
            } else {
                record_len(&file[at..])
            };
        }
    } else if name.ends_with(".db3") {
        begins.extend((0..file.len()).step_by(512));
    }
    begins
}

#[test]
fn bags_cut_anywhere_give_what_is_left_and_say_so() {
    for name in FILES.into_iter().chain(OTHERS) {
        let (file, whole) = (bytes(name), read(name));
        let mut kept = Vec::new();
        // Before every record, in the midst of its head, and evenly all over.
        let records = records(name, &file);
        let is_packed = name.ends_with(".zstd");
        assert!(is_packed || records.len() > 12, "{name}: {}", records.len());
        let mut ends: Vec<usize> = (0..file.len()).step_by(file.len() / 97).collect();
        ends.extend(records.iter().flat_map(|begin| [*begin, begin + 3]));
        ends.retain(|end| *end < file.len());
        ends.sort_unstable();
        for end in ends {
            let Some(log) = survive(name, &file[..end], &whole) else {
                kept.push(0);
                continue;
            };
            kept.push(log.recording.len());
            let said = log.account.lost_count() > 0 || !log.account.warning_counts().is_empty();
            assert!(
                said,
                "{name}: nothing said of a cut at byte {end} of {}",
                file.len()
            );
        }
        assert!(kept.is_sorted(), "{name}: {kept:?}");
        let some = kept
            .iter()
            .filter(|n| (1..whole.recording.len()).contains(*n))
            .count();
        assert!(OTHERS.contains(&name) || some > 10, "{name}: {kept:?}");
    }
}

#[test]
fn flipped_bits_and_absurd_lengths_are_survived() {
    for name in FILES.into_iter().chain(OTHERS) {
        let (file, whole) = (bytes(name), read(name));
        let mut stream = Seed(1).stream(name);
        let mut read = 0;
        for trial in 0..200 {
            let mut damaged = file.clone();
            let at = stream.random_range(0..file.len() - 8);
            match trial % 4 {
                0 | 1 => damaged[at] ^= 1 << stream.random_range(0..8),
                2 => damaged[at..at + 4].fill(0xff),
                _ => damaged[at..at + 8].copy_from_slice(&(1_u64 << 40).to_be_bytes()),
            }
            read += usize::from(survive(name, &damaged, &whole).is_some());
        }
        assert!(
            OTHERS.contains(&name) || read > 150,
            "{name}: {read} of 200 read"
        );
    }
}

#[test]
fn what_a_crashed_recorder_leaves_is_whole_but_for_its_index() {
    let whole = read("none.bag");
    // The bag's header: op, then chunk_count, conn_count and index_pos, which are 0 until the bag is closed.
    let mut crashed = bytes("none.bag");
    let name = b"index_pos=";
    let at = crashed.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    let index = u64::from_le_bytes(crashed[at..at + 8].try_into().unwrap()) as usize;
    crashed.truncate(index);
    let closed = read_bytes("cut.bag", &crashed, &LogOptions::default()).unwrap();
    assert!(
        closed
            .account
            .warning_counts()
            .keys()
            .next()
            .unwrap()
            .contains("index is damaged")
    );
    assert_eq!(content(&closed.recording), content(&whole.recording));
    let cut = read_bytes("cut.bag", &crashed[..index - 1], &LogOptions::default()).unwrap();
    assert!(cut.account.lost_count() > 0, "{:?}", cut.account);
    crashed[at..at + 8].fill(0);
    let log = read_bytes("crashed.bag", &crashed, &LogOptions::default()).unwrap();
    assert_eq!(log.account.lost_count(), 0, "{:?}", log.account);
    assert!(
        log.account
            .warning_counts()
            .keys()
            .next()
            .unwrap()
            .contains("without an index")
    );
    assert_eq!(content(&log.recording), content(&whole.recording));

    let file = bytes("lz4.mcap");
    let mut at = 8;
    while file[at] != 0x0f {
        at += record_len(&file[at..]);
    }
    let log = read_bytes("crashed.mcap", &file[..at], &LogOptions::default()).unwrap();
    assert_eq!(
        (log.account.lost_count(), log.account.warning_counts().len()),
        (0, 1)
    );
    assert_eq!(content(&log.recording), content(&whole.recording));
}

/// Length of the MCAP record that bytes start with.
fn record_len(bytes: &[u8]) -> usize {
    9 + u64::from_le_bytes(bytes[1..9].try_into().unwrap()) as usize
}

#[test]
fn checksums_are_compared() {
    for name in ["none.mcap", "lz4.mcap", "unchunked.mcap"] {
        let mut file = bytes(name);
        // In the midst of the content of the first chunk, or of a message of a file without chunks.
        let mut start = 8;
        while ![5, 6].contains(&file[start]) {
            start += record_len(&file[start..]);
        }
        let at = start + record_len(&file[start..]) / 2;
        file[at] ^= 4;
        let log = read_bytes(name, &file, &LogOptions::default()).unwrap();
        assert!(log.account.lost_count() > 0, "{name}: {:?}", log.account);
    }
}

#[test]
fn a_lost_page_of_a_table_costs_its_own_rows_only() {
    let (file, whole) = (bytes("plain/plain.db3"), read("plain"));
    let inner: Vec<usize> = (512..file.len())
        .step_by(512)
        .filter(|at| file[*at] == 5)
        .collect();
    let mut trees = 0;
    for at in inner {
        let mut damaged = file.clone();
        damaged[at] = 0;
        let Ok(log) = read_bytes("plain.db3", &damaged, &LogOptions::default()) else {
            continue; // the table of tables
        };
        trees += usize::from(log.account.lost_count() > 0); // or a page of another table
        assert_eq!(
            content(&log.recording),
            content(&whole.recording),
            "page at {at}"
        );
    }
    assert!(trees > 0, "the messages are in a tree of pages");
}

#[test]
fn parts_unpack_within_what_a_file_may_hold() {
    use crate::recording::compressed::Packing;
    use std::io::Write;
    let mut packer = lz4_flex::frame::FrameEncoder::new(Vec::new());
    packer.write_all(&vec![0; 80 << 20]).unwrap();
    let bomb = packer.finish().unwrap();
    let mut budget = part::Budget::for_file(1000);
    let fault = budget
        .unpack(Some(Packing::Lz4), &bomb, 80 << 20, false)
        .unwrap_err();
    assert!(fault.contains("unpacks to more than"), "{fault}");
    // Nothing is left for the next part of the file.
    let small = budget
        .unpack(Some(Packing::Lz4), &bomb, 1 << 20, true)
        .unwrap();
    assert!(small.is_empty());
    let mut budget = part::Budget::for_file(1000);
    assert!(
        budget
            .unpack(Some(Packing::Lz4), &bomb, 1 << 20, false)
            .is_err()
    );
    assert_eq!(
        budget.unpack(None, b"abc", 3, false).unwrap()[..],
        b"abc"[..]
    );
    assert!(budget.unpack(None, b"abc", 4, false).is_err());
}
