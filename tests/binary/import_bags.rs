//! `ballmark import` of bags: whole, damaged, as folders, with chosen topics.

use crate::support::Workplace;
use ballmark::recording::npz;
use std::{fs, path::PathBuf};

fn bag(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/bags")
        .join(name)
}

fn import(place: &Workplace, log: &str, options: &[&str]) -> crate::support::Answer {
    place.ballmark(&[&["import", log, "-o", "d.npz"], options].concat())
}

#[test]
fn bags_of_both_generations_become_the_same_dataset() {
    let place = Workplace::new();
    let mut first = None;
    for name in ["lz4.bag", "plain", "packed_file", "zstd.mcap"] {
        let answer = import(&place, &bag(name).display().to_string(), &["--json"]);
        answer.done();
        let summary: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
        assert_eq!(
            (&summary["snapshots"], &summary["runs"]),
            (&6.into(), &1.into())
        );
        assert_eq!(summary["passed_over"]["std_msgs/String"], 2, "{name}");
        let dataset = npz::read(&place.path("d.npz")).unwrap();
        assert_eq!(dataset.columns().source.as_deref(), Some(name));
        let columns = (
            dataset.poses().to_vec(),
            dataset.values().mapv(f32::to_bits),
        );
        assert_eq!(
            *first.get_or_insert_with(|| columns.clone()),
            columns,
            "{name}"
        );
    }
    // What is said of any log is heeded for files and folders alike; a bag's poses may come from elsewhere, too.
    place.write("est.tum", "0 0 0 0 0 0 0 1\n4000000000 0 5 0 0 0 0 1\n");
    for name in ["lz4.bag", "plain"] {
        let path = bag(name).display().to_string();
        let options = [
            "--columns",
            "laser",
            "--drop",
            "laser.0,laser.1",
            "--poses",
            "est.tum",
            "--pose-tolerance",
            "4e9",
        ];
        import(&place, &path, &options).done();
        let dataset = npz::read(&place.path("d.npz")).unwrap();
        assert_eq!(
            (dataset.channels().len(), dataset.channels()[0].width),
            (1, 14),
            "{name}"
        );
        assert!(dataset.poses()[0].x_m == 0.0 && dataset.poses()[0].y_m > 0.0);
        import(&place, &path, &["--columns", "lidar"])
            .refused(2, &[name, "no sensor is called `lidar`"]);
    }
    // Two bags are two runs.
    let (a, b) = (bag("ros1.mcap"), bag("packed_mcap"));
    let answer = place.ballmark(&[
        "import",
        &a.display().to_string(),
        &b.display().to_string(),
        "-o",
        "two.npz",
    ]);
    answer.done();
    assert_eq!(npz::read(&place.path("two.npz")).unwrap().runs().len(), 2);
}

#[test]
fn a_damaged_bag_is_read_as_far_as_it_goes() {
    let place = Workplace::new();
    let whole = fs::read(bag("none.bag")).unwrap();
    place.write("cut.bag", &whole[..whole.len() / 2]);
    let answer = import(&place, "cut.bag", &[]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    assert!(answer.stderr.contains("dropped: "), "{}", answer.stderr);
    assert!(
        answer.stderr.contains("expected its index at byte"),
        "{}",
        answer.stderr
    );
    // A chunk whose checksum doesn't fit is left out, and named.
    let mut flipped = fs::read(bag("none.mcap")).unwrap();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 1;
    place.write("flipped.mcap", flipped);
    let answer = import(&place, "flipped.mcap", &[]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    assert!(
        answer.stderr.contains("the chunk's checksum doesn't fit"),
        "{}",
        answer.stderr
    );
    // Without its last file a folder is no whole bag; without metadata it is one that crashed.
    fs::create_dir(place.path("walk")).unwrap();
    let file = bag("plain/plain.db3");
    place.write(
        "walk/metadata.yaml",
        fs::read(bag("plain/metadata.yaml")).unwrap(),
    );
    import(&place, "walk", &[])
        .refused(1, &["metadata.yaml", "`plain.db3`", "isn't in the folder"]);
    fs::copy(file, place.path("walk/plain.db3")).unwrap();
    import(&place, "walk", &[]).done();
    let metadata = fs::read_to_string(bag("plain/metadata.yaml")).unwrap();
    place.write(
        "walk/metadata.yaml",
        metadata.replacen("\n  message_count: ", "\n  message_count: 9", 1),
    );
    let answer = import(&place, "walk", &[]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    assert!(
        answer.stderr.contains("messages in all files; expected 9"),
        "{}",
        answer.stderr
    );
    place.write("walk/metadata.yaml", "anything: [");
    import(&place, "walk", &[])
        .refused(1, &["metadata.yaml", "expected the metadata of a rosbag2"]);
    fs::remove_file(place.path("walk/metadata.yaml")).unwrap();
    let answer = import(&place, "walk", &[]);
    answer.done();
    assert!(
        answer.stderr.contains("without metadata.yaml"),
        "{}",
        answer.stderr
    );
}

#[test]
fn topics_can_be_chosen() {
    let place = Workplace::new();
    let path = bag("bz2.bag").display().to_string();
    let options = [
        "--pose-topic",
        "/amcl_pose",
        "--topics",
        "/sonar_left,/odom",
    ];
    import(&place, &path, &options).done();
    let dataset = npz::read(&place.path("d.npz")).unwrap();
    assert_eq!(
        (
            dataset.channels().len(),
            dataset.channels()[0].name.as_str()
        ),
        (1, "sonar")
    );
    assert!(
        dataset.poses()[0].x_m > 10.9,
        "the script puts this topic 10 m aside"
    );
    import(&place, &path, &["--pose-topic", "/scan"]).refused(1, &["`/scan`", "`/amcl_pose`"]);
    import(&place, &path, &["--topics", "/scan,/scam"]).refused(
        1,
        &[
            "bz2.bag",
            "the topic `/scam` isn't in the log",
            "`/scan` (sensor_msgs/LaserScan)",
        ],
    );
    import(&place, &path, &["--topics", "/chatter"])
        .refused(1, &["std_msgs/String, which isn't read"]);
    import(&place, &path, &["--topics", "/odom"]).refused(1, &["no sensor message"]);
}
