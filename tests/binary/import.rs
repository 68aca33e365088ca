//! `ballmark import` on good, odd and broken logs.

use crate::support::{Workplace, real_logs};
use std::io::Write;

const HEADER: &str = "time_s,x_m,y_m,heading_rad,light";

/// A robot that goes a metre a scan past walls, every fifth reading without return.
fn carmen(scans: usize) -> String {
    let scan = |k: usize| {
        let far = if k.is_multiple_of(5) { "30" } else { "4.5" };
        format!(
            "FLASER 3 {:.2} {far} 2.25 {k} 0 0 {k} 0 0 {k}.5 host {k}.5\n",
            1.0 + k as f64 / 50.0
        )
    };
    (0..scans).map(scan).collect()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("one JSON object and nothing else")
}

#[test]
fn a_log_becomes_a_dataset_with_its_own_maximum() {
    let place = Workplace::new();
    place.write("walk.log", carmen(60));
    let answer = place.ballmark(&["import", "walk.log", "-o", "walk.npz"]);
    answer.done();
    assert!(
        answer.stdout.contains("no return from 30 m on: 6.67 % NaN"),
        "{}",
        answer.stdout
    );
    let answer = place.ballmark(&[
        "import",
        "walk.log",
        "-o",
        "near.npz",
        "--max-range",
        "4",
        "--json",
    ]);
    answer.done();
    assert_eq!(json(&answer.stdout)["channels"][0]["maximum"], 4.0);
    let dataset = ballmark::recording::npz::read(&place.path("walk.npz")).unwrap();
    assert_eq!(
        (dataset.len(), dataset.channels()[0].maximum),
        (60, Some(30.0))
    );
    assert!(dataset.values()[[5, 1]].is_nan() && dataset.values()[[6, 1]] == 4.5);
    // A dataset can be imported again, and comes out the same but for where it came from.
    place
        .ballmark(&["import", "walk.npz", "-o", "again.npz"])
        .done();
    let again = ballmark::recording::npz::read(&place.path("again.npz")).unwrap();
    assert_eq!(again.poses(), dataset.poses());
    assert_eq!(again.channels(), dataset.channels());
}

#[test]
fn the_same_log_gives_the_same_bytes_however_it_is_packed() {
    let place = Workplace::new();
    let text = carmen(30);
    let (first, second) = text.as_bytes().split_at(text.len() / 2);
    place.write("a.log", &text);
    place.write("b.log", [gzip(first), gzip(second)].concat());
    for (log, dataset) in [("a.log", "a1.npz"), ("a.log", "a2.npz"), ("b.log", "b.npz")] {
        place.ballmark(&["import", log, "-o", dataset]).done();
    }
    assert_eq!(
        std::fs::read(place.path("a1.npz")).unwrap(),
        std::fs::read(place.path("a2.npz")).unwrap()
    );
    let read = |name: &str| ballmark::recording::npz::read(&place.path(name)).unwrap();
    assert_eq!(read("b.npz").poses(), read("a1.npz").poses());
}

#[test]
fn several_logs_become_several_runs() {
    let place = Workplace::new();
    place.write("a.log", carmen(10));
    place.write("b.log", carmen(7));
    let answer = place.ballmark(&["import", "a.log", "b.log", "-o", "d.npz", "--json"]);
    answer.done();
    let told = json(&answer.stdout);
    assert_eq!(
        (&told["runs"], &told["snapshots"], &told["path_m"]),
        (&2.into(), &17.into(), &15.0.into())
    );
    place.write("c.csv", format!("{HEADER}\n0,0,0,0,1\n"));
    let answer = place.ballmark(&["import", "a.log", "c.csv", "-o", "e.npz"]);
    answer.refused(
        1,
        &[
            "c.csv",
            "`light` (1 values",
            "expected those of a.log: `laser` (3 values",
        ],
    );
    assert!(!place.path("e.npz").exists());
}

#[test]
fn damaged_lines_are_named_and_the_rest_is_kept() {
    let place = Workplace::new();
    let mut log = carmen(4).into_bytes();
    log.extend(b"FLASER 3 1 2 x 0 0 0 0 0 0 1 h 1\n"); // line 5
    log.extend(b"FLASER 3 1 2 3 nan 0 0 0 0 0 1 h 1\n");
    log.extend(b"FLASER 4 1 2 3 4 0 0 0 0 0 0 1 h 1\n");
    log.extend(b"ODOM 1 2 \xff\xfe 0 0 0 1 h 1\n");
    log.extend(b"FLASER 3 1 2 3 0 0 0 0 0\n".repeat(4));
    log.extend(b"FLASER 3 1.5");
    place.write("bad.log", log);
    let answer = place.ballmark(&["import", "bad.log", "-o", "d.npz", "--json"]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    for part in [
        "line 5: `FLASER`: holds `x`",
        "line 6",
        "line 8: `ODOM`",
        "dropped: 4 more",
    ] {
        assert!(answer.stderr.contains(part), "{}", answer.stderr);
    }
    let told = json(&answer.stdout);
    assert_eq!(
        (&told["dropped"], &told["snapshots"]),
        (&9.into(), &4.into())
    );
}

#[test]
fn a_cut_archive_gives_what_is_left_and_says_so() {
    let place = Workplace::new();
    let packed = gzip(carmen(5000).as_bytes());
    place.write("cut.log.gz", &packed[..packed.len() / 2]);
    let answer = place.ballmark(&["import", "cut.log.gz", "-o", "d.npz"]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    assert!(
        answer.stderr.contains("gzip data damaged after"),
        "{}",
        answer.stderr
    );
}

#[test]
fn oddities_are_warnings() {
    let place = Workplace::new();
    let odd = "PARAM any_prefix_at_all 1\nSYNC x\nNEFF 3\n# remark\nMYSTERY \u{e9}\n\
        FLASER 1 1 0 0 0 0 0 0 5 h 5\nFLASER 1 1 1 0 0 1 0 0 4 h 4\nFLASER 1 1 2 0 0 2 0 0 4 h 4\nFLASER 1 1 3 0 0 3 0 0 0 h 0\n\
        FLASER 1 1 99 0 0 99 0 0 6 h 6\n";
    place.write("odd.log", odd);
    let answer = place.ballmark(&["import", "odd.log", "-o", "d.npz", "--json"]);
    answer.done();
    let told = json(&answer.stdout);
    let warnings = &told["warnings"];
    assert_eq!(warnings["FLASER stamped 0"], 1);
    assert_eq!(warnings["FLASER stamped before the one ahead of it"], 1);
    assert_eq!(warnings["FLASER stamped like the one ahead of it"], 1);
    assert_eq!(warnings["gap of more than 5 m, where a new run begins"], 1);
    assert_eq!(
        (&told["passed_over"]["MYSTERY"], &told["runs"]),
        (&1.into(), &2.into())
    );
}

#[test]
fn further_sensors_join_the_leading_one() {
    let place = Workplace::new();
    let log = "SONAR 2 1.5 2.5 1 h 1\nRLASER 2 3 4 0 0 0 0 0 0 1.1 h 1.1\nFLASER 1 1 0 0 0 0 0 0 1.2 h 1.2\n\
        FLASER 1 1 1 0 0 1 0 0 1.4 h 1.4\nFLASER 1 1 2 0 0 2 0 0 9 h 9\n";
    place.write("all.log", log);
    place.ballmark(&["import", "all.log", "-o", "d.npz"]).done();
    let dataset = ballmark::recording::npz::read(&place.path("d.npz")).unwrap();
    let names: Vec<&str> = dataset.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["laser", "rear_laser", "sonar"]);
    assert_eq!(dataset.values().row(1).to_vec(), [1.0, 3.0, 4.0, 1.5, 2.5]);
    assert!(dataset.values()[[2, 1]].is_nan(), "too old");
    // A line of another width is lost; together the lines that lead have as many readings as the table, by chance.
    let row = |k: usize| {
        format!(
            "RLASER 2 3 4 {k} 0 0 {k} 0 0 {k} h {k}\nFLASER 2 1 {k} {k} 0 0 {k} 0 0 {k} h {k}\n"
        )
    };
    let odd = "FLASER 6 9 9 9 9 9 9 0 0 0 0 0 0 4 h 4\n";
    place.write("odd.log", [&row(1), &row(2), odd, &row(3)].concat());
    let answer = place.ballmark(&["import", "odd.log", "-o", "odd.npz"]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    let dataset = ballmark::recording::npz::read(&place.path("odd.npz")).unwrap();
    let expected = ndarray::array![
        [1.0, 1.0, 3.0, 4.0],
        [1.0, 2.0, 3.0, 4.0],
        [1.0, 3.0, 3.0, 4.0]
    ];
    assert_eq!(dataset.values(), &expected);
    place.write(
        "sonar.log",
        "ODOM 1 2 0 0 0 0 1 h 1\nSONAR 2 1.5 2.5 1 h 1\n",
    );
    place
        .ballmark(&["import", "sonar.log", "-o", "s.npz"])
        .done();
    let dataset = ballmark::recording::npz::read(&place.path("s.npz")).unwrap();
    assert_eq!(
        (dataset.channels()[0].name.as_str(), dataset.poses()[0].x_m),
        ("sonar", 1.0)
    );
}

#[test]
fn a_graph_without_poses_in_its_laser_lines_uses_the_vertices() {
    let place = Workplace::new();
    let scan = "RAWLASER1 0 -1.57 3.14 0.0175 50 0.1 0 2 1.5 2.5 0 12.5 x 3\n";
    place.write(
        "g.log",
        format!("VERTEX2 0 4 5 0.1\n{scan}EDGE2 0 1 0 0 0\nVERTEX2 1 5 5 0.1\n{scan}"),
    );
    place.ballmark(&["import", "g.log", "-o", "g.npz"]).done();
    let dataset = ballmark::recording::npz::read(&place.path("g.npz")).unwrap();
    assert_eq!((dataset.poses()[0].x_m, dataset.poses()[1].x_m), (4.0, 5.0));
    place.write("n.log", scan);
    place
        .ballmark(&["import", "n.log", "-o", "n.npz"])
        .refused(1, &["n.log", "no pose"]);
}

#[test]
fn what_is_no_log_is_refused_by_what_it_is() {
    let place = Workplace::new();
    for (content, part) in [
        (&b""[..], "the file is empty"),
        (
            b"Dear diary,\ntoday I got lost.\n",
            "not a log that is known here",
        ),
        (b" \n\n", "nothing but blank space"),
        (b"\x89MCAP0\r\n....", "no sensor message"),
        (b"#ROSBAG V2.0\n", "no sensor message"),
        (b"#ROSBAG V1.2\n", "rosbag of the old format 1"),
        (b"SQLite format 3\0 and no more", "header of 100 bytes"),
        (b"1.5 0 0 0 0 0 0 1\n", "TUM"),
        (b"PARAM a b\nODOM 0 0 0 0 0 0 1 h 1\n", "no scan"),
        (b"PK\x03\x04 and no more", "not a whole .npz"),
        (b"\x1f\x8b\x08 broken", "damaged gzip data"),
        (b"\xfd7zXZ\0 broken", "damaged xz data"),
        (
            b"time_s,x_m,y_m,heading_rad,a\n",
            "nothing below the header",
        ),
        (
            b"time_s,x_m,y_m,heading_rad,a\n1,nan,0,0,1\n",
            "finite number",
        ),
        (b"time_s,x_m,a\n", "no column `y_m`"),
    ] {
        place.write("thing", content);
        place
            .ballmark(&["import", "thing", "-o", "d.npz"])
            .refused(1, &["thing", part]);
    }
    place
        .ballmark(&["import", "absent.log", "-o", "d.npz"])
        .refused(1, &["absent.log", "cannot read"]);
    place
        .ballmark(&["import", ".", "-o", "d.npz"])
        .refused(1, &["is a folder"]);
    assert_eq!(
        place.files(),
        ["thing"],
        "a refused call leaves nothing behind"
    );
}

#[test]
fn outputs_that_cannot_be_written_are_told() {
    let place = Workplace::new();
    place.write("walk.log", carmen(3));
    place
        .ballmark(&["import", "walk.log", "-o", "walk.log/d.npz"])
        .refused(1, &["is a file, not a folder"]);
    place
        .ballmark(&["import", "walk.log", "-o", "."])
        .refused(1, &["folder"]);
    place
        .ballmark(&["import", "walk.log", "-o", "d.npz", "--max-range", "0"])
        .refused(2, &["--max-range 0", "above 0"]);
    assert_eq!(place.ballmark(&["import", "walk.log"]).status, 2);
    assert_eq!(place.files(), ["walk.log"]);
}

#[test]
fn damaged_datasets_name_the_array() {
    let place = Workplace::new();
    place.write("walk.log", carmen(300));
    place
        .ballmark(&["import", "walk.log", "-o", "d.npz"])
        .done();
    let whole = std::fs::read(place.path("d.npz")).unwrap();
    for len in [1, 100, whole.len() / 2, whole.len() - 1] {
        place.write("cut.npz", &whole[..len]);
        place
            .ballmark(&["import", "cut.npz", "--format", "npz", "-o", "e.npz"])
            .refused(1, &["cut.npz", "not a whole .npz"]);
    }
    let f8 = |shape: &str, values: &[f64]| {
        npy(
            "<f8",
            shape,
            &values
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect::<Vec<_>>(),
        )
    };
    let meta = |json: &str| npy("|u1", &format!("({},)", json.len()), json.as_bytes());
    let good = || {
        vec![
            ("stamp", f8("(1,)", &[0.0])),
            ("pose", f8("(1, 3)", &[0.0; 3])),
            ("odometry", f8("(1, 3)", &[0.0; 3])),
            ("run", npy("<i8", "(1,)", &[0; 8])),
            ("light", npy("<f4", "(1, 2)", &[0; 8])),
            ("meta", meta(r#"{"channels": {"light": {"unit": "lux"}}}"#)),
        ]
    };
    place.write("good.npz", zip(&good()));
    place
        .ballmark(&["import", "good.npz", "-o", "e.npz"])
        .done();
    // People write -1 for "none", and a file without rows may claim any width.
    let mut none = good();
    none.pop();
    none.push((
        "meta",
        meta(r#"{"channels": {"light": {"unit": "m", "maximum": -1}}}"#),
    ));
    place.write("none.npz", zip(&none));
    place
        .ballmark(&["import", "none.npz", "-o", "f.npz"])
        .refused(1, &["none.npz", "`maximum` of channel `light` is -1"]);
    let empty = vec![
        ("stamp", f8("(0,)", &[])),
        ("pose", f8("(0, 3)", &[])),
        ("run", npy("<i8", "(0,)", &[])),
        ("light", npy("<f4", "(0, 9223372036854775808)", &[])),
        ("meta", meta(r#"{"channels": {"light": {"unit": "lux"}}}"#)),
    ];
    place.write("empty.npz", zip(&empty));
    place
        .ballmark(&["import", "empty.npz", "-o", "f.npz"])
        .refused(1, &["empty.npz", "no snapshot"]);
    // Other programs' number types are taken in, and odometry may be missing.
    let mut other = good();
    other.retain(|(name, _)| !["odometry", "light", "run"].contains(name));
    other.push(("light", f8("(1, 2)", &[0.5, 1.5])));
    other.push(("run", npy("<i4", "(1,)", &[7, 0, 0, 0])));
    place.write("other.npz", zip(&other));
    let answer = place.ballmark(&["import", "other.npz", "-o", "e.npz"]);
    answer.done();
    assert!(
        answer.stdout.contains("it repeats them"),
        "{}",
        answer.stdout
    );
    let taken = ballmark::recording::npz::read(&place.path("e.npz")).unwrap();
    assert_eq!((taken.values()[[0, 1]], taken.columns().run[0]), (1.5, 7));
    for (array, replacement, parts) in [
        ("stamp", None, &["array `stamp`", "missing"][..]),
        ("light", None, &["array `light`", "missing"]),
        (
            "light",
            Some(npy("<c8", "(1, 2)", &[0; 16])),
            &["array `light`", "`<c8`; expected `<f4`"],
        ),
        (
            "light",
            Some(npy("<f4", "(2,)", &[0; 8])),
            &["array `light`", "one row a snapshot"],
        ),
        (
            "light",
            Some(npy("<f4", "(99999999, 99999999)", &[0; 8])),
            &["array `light`", "doesn't fit"],
        ),
        (
            "pose",
            Some(f8("(3, 1)", &[0.0; 3])),
            &["array `pose`", "expected (1, 3)"],
        ),
        (
            "pose",
            Some(f8("(1, 3)", &[f64::NAN; 3])),
            &["`pose`", "not a finite number"],
        ),
        (
            "run",
            Some(npy("<i8", "(2,)", &[0; 16])),
            &["array `run`", "expected (1)"],
        ),
        (
            "meta",
            Some(meta("{\"channels\": [")),
            &["array `meta`", "expected JSON"],
        ),
        (
            "meta",
            Some(meta(r#"{"channels": {"pose": {}}}"#)),
            &["array `meta`", "a channel named `pose`"],
        ),
        (
            "meta",
            Some(meta(
                r#"{"channels": {"light": {"unit": "m", "bearing_rad": [0, 1], "offset_m": [0.2]}}}"#,
            )),
            &["`light`", "1 numbers in `offset_m` for 2 values"],
        ),
        (
            "meta",
            Some(meta(
                r#"{"channels": {"light": {"unit": "m", "bearing_rad": [0, 1], "offset_m": [0.2, -0.2]}}}"#,
            )),
            &["`light`", "`offset_m` of -0.2", "0 to 100"],
        ),
        (
            "meta",
            Some(meta(
                r#"{"channels": {"light": {"unit": "m", "bearing_rad": [0, 1], "offset_m": [0.2, NaN]}}}"#,
            )),
            &["array `meta`", "expected JSON"],
        ),
        (
            "meta",
            Some(meta(
                r#"{"channels": {"light": {"unit": "m", "offset_m": [0.2, 0.2]}}}"#,
            )),
            &["`light`", "`offset_m` without `bearing_rad`"],
        ),
        (
            "light",
            Some(npy("<f4", "(1, 25000000)", &vec![0; 100_000_000])),
            &["array `light`", "claims to unpack"],
        ),
    ] {
        let mut arrays = good();
        match replacement {
            None => arrays.retain(|(name, _)| *name != array),
            Some(bytes) => arrays
                .iter_mut()
                .filter(|(name, _)| *name == array)
                .for_each(|a| a.1 = bytes.clone()),
        }
        place.write("bad.npz", zip(&arrays));
        let parts: Vec<&str> = ["bad.npz"].iter().chain(parts).copied().collect();
        place
            .ballmark(&["import", "bad.npz", "-o", "f.npz"])
            .refused(1, &parts);
    }
}

fn npy(descr: &str, shape: &str, body: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    [
        b"\x93NUMPY\x01\x00",
        &(header.len() as u16).to_le_bytes()[..],
        header.as_bytes(),
        body,
    ]
    .concat()
}

fn zip(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated);
    for (name, bytes) in arrays {
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn real_logs_come_in_whole_with_raw_odometry() {
    let Some(logs) = real_logs("real_logs_come_in_whole_with_raw_odometry") else {
        return;
    };
    let place = Workplace::new();
    for (log, snapshots, path_m, maximum, correction_m) in [
        (
            "freiburg-079/freiburg-079-corrected.log.xz",
            4791,
            422.0,
            81.91,
            Some(0.0265),
        ),
        (
            "intel-lab/intel-corrected.log.xz",
            910,
            500.0,
            81.83,
            Some(0.0528),
        ),
        (
            "infinite-corridor/infinite-corridor-corrected.log.xz",
            1941,
            1920.0,
            51.01,
            Some(0.0328),
        ),
        ("intel-lab/intel-lab-graph.log.xz", 2672, 361.0, 81.83, None),
    ] {
        let path = logs.join(log).display().to_string();
        let answer = place.ballmark(&["import", &path, "-o", "d.npz", "--json"]);
        answer.done();
        let told = json(&answer.stdout);
        assert_eq!(
            (&told["snapshots"], &told["runs"]),
            (&snapshots.into(), &1.into()),
            "{log}"
        );
        assert!(
            (told["path_m"].as_f64().unwrap() - path_m).abs() < 1.0,
            "{log}: {}",
            told["path_m"]
        );
        assert_eq!(told["channels"][0]["maximum"], maximum, "{log}");
        let dataset = ballmark::recording::npz::read(&place.path("d.npz")).unwrap();
        let c = dataset.columns();
        let mut corrections: Vec<f64> = (1..dataset.len())
            .map(|k| {
                let corrected = c.pose[k - 1].displacement_to(&c.pose[k]);
                let raw = c.odometry[k - 1].displacement_to(&c.odometry[k]);
                (corrected.forward_m - raw.forward_m).hypot(corrected.left_m - raw.left_m)
            })
            .collect();
        corrections.sort_unstable_by(f64::total_cmp);
        let median = corrections[corrections.len() / 2];
        assert!(
            (median - correction_m.unwrap_or(0.0)).abs() < 5e-4,
            "{log}: {median}"
        );
        if log.contains("freiburg") {
            assert_eq!(told["warnings"]["ODOM stamped 0"], 4772);
            assert_eq!(
                told["warnings"]["ODOM stamped before the one ahead of it"],
                19
            );
        }
    }
}

/// A log that a recorder still writes is neither what it was nor what it will be.
#[test]
fn a_log_that_is_written_while_it_is_read_is_refused_and_nothing_is_left() {
    use std::{
        fs::File,
        sync::atomic::{AtomicBool, Ordering},
        time::Duration,
    };
    let place = Workplace::new();
    place.write("walk.log", carmen(300_000));
    place.write("walk.npz", "as it was");
    let (path, is_read) = (place.path("walk.log"), AtomicBool::new(false));
    let answer = std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut log = File::options().append(true).open(&path).unwrap();
            while !is_read.load(Ordering::Relaxed) {
                log.write_all(b"NEFF 2.0\n").unwrap();
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let answer = place.ballmark(&["import", "walk.log", "-o", "walk.npz"]);
        is_read.store(true, Ordering::Relaxed);
        answer
    });
    answer.refused(1, &["walk.log: changed while it was read"]);
    assert_eq!(place.files(), ["walk.log", "walk.npz"]);
    assert_eq!(std::fs::read(place.path("walk.npz")).unwrap(), b"as it was");
    // Once nobody writes to it any more it is a log as any other.
    place
        .ballmark(&["import", "walk.log", "-o", "walk.npz"])
        .done();
}
