//! Every reader of files that may come from a stranger, as something that takes any bytes and must end without a panic. Shared by the test that
//! replays the corpus and by the targets of the fuzzer.

use ballmark::{
    experiment::{
        compare::{CompareConfig, Comparison},
        configuration::Experiment,
    },
    mapping::RosMap,
    model::ModelBank,
    recording::{
        format::Format,
        import::{self, ReadOptions},
        log_options::LogOptions,
        npz,
    },
    report,
    score::{Responses, trajectory},
    storage,
    world::Building,
};
use std::path::Path;

/// The name of a reader's folder in `corpus/` and of its target in `targets/`, and the reader.
type Named = (&'static str, fn(&[u8]));

/// All of them.
pub const READERS: [Named; 15] = [
    ("carmen", |bytes| log("carmen", bytes)),
    ("configuration", configuration),
    ("csv", |bytes| log("csv", bytes)),
    ("map", map),
    ("mcap", |bytes| log("mcap", bytes)),
    ("model", model),
    ("npz", |bytes| drop(npz::from_bytes(Path::new("f"), bytes))),
    ("onnx", onnx),
    ("packed", packed),
    ("record", record),
    ("responses", |bytes| {
        drop(Responses::from_reader("f", bytes))
    }),
    ("rosbag1", |bytes| log("rosbag1", bytes)),
    ("rosbag2", |bytes| log("rosbag2", bytes)),
    ("trajectory", poses),
    ("world", |bytes| {
        as_text(bytes, |text| drop(Building::from_text(text)))
    }),
];

/// What the reader of that name does with some bytes.
#[allow(dead_code, reason = "the test takes them all, a target one")]
pub fn read(name: &str, bytes: &[u8]) {
    let found = READERS.iter().find(|(own, _)| *own == name);
    found.expect("a reader of that name").1(bytes);
}

fn as_text(bytes: &[u8], read: impl Fn(&str)) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        read(text);
    }
}

fn log(format: &str, bytes: &[u8]) {
    let format = Format::named(format).expect("a format");
    drop(format.read(Path::new("f"), bytes, &LogOptions::default()));
}

fn poses(bytes: &[u8]) {
    if let Ok(format) = trajectory::Format::of_content(Path::new("f"), bytes) {
        drop(format.read_bytes(Path::new("f"), bytes));
    }
}

fn configuration(bytes: &[u8]) {
    as_text(bytes, |text| {
        drop(Experiment::parse(text));
        drop(CompareConfig::parse(text));
    });
}

fn record(bytes: &[u8]) {
    if let Ok(comparison) = serde_json::from_slice::<Comparison>(bytes)
        && comparison.check().is_ok()
    {
        drop(report::comparison::sheets(&comparison));
        drop(report::comparison::pictures(&comparison));
    }
}

/// A model in any container.
fn model(bytes: &[u8]) {
    drop(ModelBank::from_bytes(Path::new("f"), bytes));
}

/// A graph under a digest that fits: else nothing that was changed would be looked at.
fn onnx(bytes: &[u8]) {
    // Metadata (field 14) of key (1) and value (2), as the last field of the file.
    let mut sealed = bytes.to_vec();
    sealed.extend([0x72, 74, 0x0a, 6]);
    sealed.extend(b"sha256");
    sealed.extend([0x12, 64]);
    sealed.extend(storage::sha256(bytes).as_bytes());
    model(&sealed);
}

/// A log in a file, plain or packed.
fn packed(bytes: &[u8]) {
    in_folder(&[("f", bytes)], |folder| {
        drop(import::read(&[folder.join("f")], &ReadOptions::default()));
    });
}

/// A map's YAML, and behind its last line the picture.
fn map(bytes: &[u8]) {
    let end = bytes.windows(5).position(|part| part == b"\n---\n");
    let (yaml, picture) = match end {
        Some(end) => (&bytes[..end], &bytes[end + 5..]),
        None => (bytes, &b"P5\n2 2\n255\n\x00\xfe\xfe\xfe"[..]),
    };
    in_folder(&[("f.yaml", yaml), ("f.pgm", picture)], |folder| {
        drop(RosMap::read(&folder.join("f.yaml")));
    });
}

fn in_folder(files: &[(&str, &[u8])], read: impl Fn(&Path)) {
    // In memory where there is such a folder: a fuzzer makes thousands a second.
    let memory = Path::new("/dev/shm");
    let folder = match memory.is_dir() {
        true => tempfile::tempdir_in(memory),
        false => tempfile::tempdir(),
    };
    let folder = folder.expect("a folder");
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    }
    read(folder.path());
}
