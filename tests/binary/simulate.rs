//! `ballmark simulate`: what it writes, and what it says of worlds that make no sense.

use crate::support::{Workplace, answer, binary};
use std::process::Command;

const HALL: &str = r#"
name = "hall"
[materials.orange]
colour = [0.9, 0.5, 0.1]
[building]
ceiling_m = 2.6
[[wall]]
points = [[0, 0], [10, 0], [10, 6], [0, 6]]
closed = true
[[wall.paint]]
from_m = 1
to_m = 2
material = "orange"
[[wall.door]]
at_m = 3
width_m = 0.9
open = 0.5
[[wall.window]]
at_m = 11
width_m = 2
[[thing]]
at = [5, 5]
radius_m = 0.2
[[light]]
at = [5, 3]
[robot]
radius_m = 0.25
[robot.odometry]
translation_drift = 0.02
[sonar]
beams = 8
[path]
corners = [[1, 2], [9, 2]]
[record]
every_m = 0.5
runs = 2
"#;

/// Simulates a text; the answer, and the place it was given in.
fn simulate(world: &str, more: &[&str]) -> (Workplace, crate::support::Answer) {
    let place = Workplace::new();
    place.write("world.toml", world);
    let call = [&["simulate", "world.toml", "-o", "out.npz"], more].concat();
    let answer = place.ballmark(&call);
    (place, answer)
}

#[test]
fn a_world_becomes_a_dataset_and_a_picture() {
    let (place, answer) = simulate(HALL, &["--plan", "plan.svg", "--json"]);
    answer.done();
    assert_eq!(place.files(), ["out.npz", "plan.svg", "world.toml"]);
    let told: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    assert_eq!((&told["world"], &told["runs"]), (&"hall".into(), &2.into()));
    assert_eq!(told["channels"][0]["values"], 8);
    // The sonars sit on the rim of a B21, and the file says so.
    let recording = ballmark::recording::npz::read(&place.path("out.npz")).unwrap();
    assert_eq!(recording.channels()[0].offset_m, Some(vec![0.26; 8]));
    let again = place.ballmark(&["import", "out.npz", "-o", "again.npz"]);
    assert!(again.done().stdout.contains("sonar: 8 values in m"));
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_number_of_threads() {
    let world = HALL.replace(
        "[sonar]",
        "[camera]\n[compass]\n[laser]\nbeams = 31\n[infrared]\n[sonar]",
    );
    let bytes = |threads: &str, seed: &str| {
        let place = Workplace::new();
        place.write("world.toml", &world);
        let call = ["simulate", "world.toml", "-o", "out.npz", "--seed", seed];
        answer(
            Command::new(binary())
                .args(call)
                .env("RAYON_NUM_THREADS", threads)
                .current_dir(place.path(".")),
        )
        .done();
        std::fs::read(place.path("out.npz")).unwrap()
    };
    let one = bytes("1", "7");
    assert!(one == bytes("4", "7"), "one thread and four differ");
    assert!(one != bytes("4", "8"), "two seeds are alike");
}

#[test]
fn as_many_snapshots_as_asked_for_in_each_set() {
    let sets = "[[set]]\nname = \"d1\"\nruns = 3\nsnapshots = 101\n[[set]]\nname = \"d2\"\nruns = 2\nsnapshots = 57\n";
    let world = format!("{}{sets}", HALL.replace("every_m = 0.5\nruns = 2\n", ""));
    for (more, snapshots, runs) in [
        (&[][..], 158, 5),
        (&["--set", "d1"], 101, 3),
        (&["--set", "d2"], 57, 2),
        (&["--set", "d1", "--runs", "1"], 34, 1),
    ] {
        let (_, answer) = simulate(&world, &[&["--json"], more].concat());
        let told: serde_json::Value = serde_json::from_str(&answer.done().stdout).unwrap();
        assert_eq!(
            (&told["snapshots"], &told["runs"]),
            (&snapshots.into(), &runs.into())
        );
    }
    simulate(&world, &["--set", "d3"])
        .1
        .refused(2, &["--set d3", "d1, d2"]);
    let other = format!("{world}sonar = {{ beams = 9 }}\n");
    simulate(&other, &[])
        .1
        .refused(2, &["`d1` and `d2` differ", "--set"]);
    simulate(&other, &["--set", "d2"]).1.done();
}

#[test]
fn each_fault_of_the_file_is_one_line_and_nothing_is_written() {
    let swap = |from: &str, to: &str| {
        assert!(HALL.contains(from), "{from}");
        HALL.replace(from, to)
    };
    let with = |more: &str| format!("{HALL}{more}");
    for (world, parts) in [
        // Not TOML, not text, unknown and missing keys.
        ("[".to_string(), &["world.toml: line 1"][..]),
        (String::new(), &["name"]),
        (swap("name = \"hall\"", "name = \"\""), &["`name` is empty"]),
        (with("[ghosts]\n"), &["ghosts", "line "]),
        (
            swap("width_m = 0.9", "widht_m = 0.9"),
            &["widht_m", "line "],
        ),
        (swap("beams = 8", "beems = 8"), &["[sonar]", "beems"]),
        (
            swap("radius_m = 0.25", "radios_m = 0.25"),
            &["[robot]", "radios_m"],
        ),
        (
            swap("translation_drift", "translation_drifd"),
            &["[robot]", "translation_drifd"],
        ),
        (swap("open = 0.5", "open = \"often\""), &["often", "line "]),
        (
            swap("every_m = 0.5", "every_m = 0.5\nevery_s = 1"),
            &["[record]", "`every_m` and `every_s`"],
        ),
        (swap("every_m = 0.5", ""), &["[record]", "no spacing"]),
        // Numbers that make no sense.
        (swap("beams = 8", "beams = 0"), &["sonar: `beams` is 0"]),
        (
            swap("beams = 8", "maximum_m = nan"),
            &["sonar: `maximum_m` is NaN"],
        ),
        (
            swap("radius_m = 0.25", "speed_m_per_s = 0"),
            &["robot: `speed_m_per_s` is 0"],
        ),
        (
            swap("radius_m = 0.25", "radius_m = -1"),
            &["robot: `radius_m` is -1"],
        ),
        (
            swap("every_m = 0.5", "every_m = 0"),
            &["[record]", "`every_m` is 0"],
        ),
        (swap("every_m = 0.5", "every_m = 0.001"), &["0.001"]),
        (swap("every_m = 0.5", "every_s = -1"), &["`every_s` is -1"]),
        (swap("runs = 2", "runs = 0"), &["[record]", "`runs` is 0"]),
        (
            swap("every_m = 0.5", "snapshots = 1"),
            &["`snapshots` is 1"],
        ),
        (
            swap("every_m = 0.5", "snapshots = 900000"),
            &["900000 snapshots"],
        ),
        (
            swap("open = 0.5", "open = 1.5"),
            &["[[wall]] 1: door at 3 m", "`open` is 1.5"],
        ),
        (
            swap("ceiling_m = 2.6", "ceiling_m = inf"),
            &["[building]", "`ceiling_m` is inf"],
        ),
        (
            swap("ceiling_m = 2.6", "daylight = [0.9, 0.1]"),
            &["[building]", "`daylight`"],
        ),
        (
            swap("colour = [0.9,", "colour = [1.9,"),
            &["[materials.orange]", "1.9"],
        ),
        (
            swap("at = [5, 3]", "at = [nan, 3]"),
            &["[[light]] 1", "`at` is NaN"],
        ),
        (
            swap("radius_m = 0.2\n", "radius_m = 0\n"),
            &["[[thing]] 1", "`radius_m` is 0"],
        ),
        // Names that nothing has.
        (
            swap("material = \"orange\"", "material = \"pink\""),
            &["[[wall]] 1: paint", "no material `pink`", "orange"],
        ),
        (
            swap("radius_m = 0.25", "kind = \"r2d2\""),
            &["[robot]", "r2d2", "nomad200"],
        ),
        (
            swap("radius_m = 0.25", "turret_north = true"),
            &["[robot]", "turret_north", "[compass]"],
        ),
        // Walls that can't be built.
        (
            swap("width_m = 0.9", "width_m = 8"),
            &["[[wall]] 1: door at 3 m", "over the corner at 10.000 m"],
        ),
        (
            swap("width_m = 0.9", "width_m = 0"),
            &["door at 3 m", "`width_m` is 0"],
        ),
        (swap("at_m = 11", "at_m = 3.5"), &["[[wall]] 1", "overlaps"]),
        (
            swap("at_m = 11", "at_m = 40"),
            &["window at 40 m", "within 0 to 32.000 m"],
        ),
        (
            swap("to_m = 2", "to_m = 99"),
            &["[[wall]] 1: paint from 1 to 99 m"],
        ),
        (
            swap(", [10, 0], [10, 6], [0, 6]]", "]"),
            &["[[wall]] 1", "`points` has 1"],
        ),
        (swap("[10, 0], ", "[0, 0], "), &["[[wall]] 1", "0 m long"]),
        (
            with("[[wall]]\npoints = [[0, 0], [inf, 0]]\n"),
            &["[[wall]] 2"],
        ),
        // Ways that can't be driven.
        (
            swap("corners = [[1, 2], [9, 2]]", "corners = [[1, 2]]"),
            &["[path]", "1 corners"],
        ),
        (
            swap(
                "corners = [[1, 2], [9, 2]]",
                "corners = [[1, 2], [9, 2]]\nlaps = 3",
            ),
            &["[path]", "`laps` is 3"],
        ),
        (
            swap("corners = [[1, 2], [9, 2]]", "follow = \"poses\""),
            &["[path]", "`poses` is empty"],
        ),
        (
            swap("corners = [[1, 2], [9, 2]]", "follow = \"wall\""),
            &["[path]", "`corners` has 0"],
        ),
        (
            swap("corners = [[1, 2], [9, 2]]", "follow = \"stars\""),
            &["stars", "line "],
        ),
        // Sensors and people.
        (HALL.replace("[sonar]\nbeams = 8", ""), &["no sensor"]),
        (
            with("[camera]\nheight_m = 3.0\n"),
            &["[camera]", "`height_m` is 3"],
        ),
        (
            with("[people]\npassing = 3\nbetween = 1\n"),
            &["`between` is 1"],
        ),
        (
            with("[people]\npassing = 1\nbetween = 2\n"),
            &["`between` is 2"],
        ),
        (
            swap("[building]", "[building]\nmap = \"lost.yaml\""),
            &["lost.yaml"],
        ),
        (
            with("[[set]]\nname = \"a\"\n[[set]]\nname = \"a\"\n"),
            &["[[set]] 2", "`a`"],
        ),
        (
            with("[[set]]\nname = \"a\"\nhorn = 3\n"),
            &["horn", "line "],
        ),
    ] {
        let (place, answer) = simulate(&world, &["--plan", "plan.svg"]);
        let io = parts == ["lost.yaml"];
        answer.refused(if io { 1 } else { 2 }, parts);
        assert_eq!(answer.stderr.lines().count(), 1, "{}", answer.stderr);
        assert_eq!(place.files(), ["world.toml"], "{}", answer.stderr);
    }
}

#[test]
fn a_drive_that_fails_is_told_with_its_run_and_nothing_is_written() {
    let swap = |from: &str, to: &str| HALL.replace(from, to);
    for (world, parts) in [
        (
            swap("closed = true", "closed = false"),
            &["run 0", "gets out near"][..],
        ),
        (
            swap("[[1, 2],", "[[0.1, 2],"),
            &["run 0", "starts in a wall"],
        ),
        (
            swap("[9, 2]]", "[9.9, 2]]"),
            &["run 0", "hits a wall", "m along the route"],
        ),
        (
            swap("at = [5, 5]", "at = [5, 2]"),
            &["run 0", "hits a wall"],
        ),
        (
            swap(
                "corners = [[1, 2], [9, 2]]",
                "follow = \"poses\"\nposes = [[1, 2, 0], [12, 2, 0]]",
            )
            .replace("every_m = 0.5\n", ""),
            &["run 0", "hits a wall"],
        ),
        (
            swap("[[1, 2], [9, 2]]", "[[1, 12], [9, 12]]"),
            &["run 0", "starts outside of the walls"],
        ),
    ] {
        let (place, answer) = simulate(&world, &["--plan", "plan.svg"]);
        answer.refused(1, parts);
        assert_eq!(answer.stderr.lines().count(), 1, "{}", answer.stderr);
        assert_eq!(place.files(), ["world.toml"], "{}", answer.stderr);
    }
}

#[test]
fn a_wrong_call_is_told() {
    let place = Workplace::new();
    place
        .ballmark(&["simulate", "none.toml", "-o", "out.npz"])
        .refused(1, &["none.toml", "cannot read"]);
    place.write("world.toml", HALL);
    let call = |more: &[&str]| place.ballmark(&[&["simulate", "world.toml"], more].concat());
    call(&["-o", "no/folder/out.npz"]).refused(1, &["no/folder"]);
    call(&["-o", "out.npz", "--plan", "no/plan.svg"]).refused(1, &["no/plan.svg"]);
    call(&["-o", "out.npz", "--runs", "0"]).refused(2, &["--runs 0"]);
    place.write("bytes.toml", [0xff, 0xfe]);
    place
        .ballmark(&["simulate", "bytes.toml", "-o", "out.npz"])
        .refused(2, &["not UTF-8"]);
    assert_eq!(place.files(), ["bytes.toml", "world.toml"]);
}

/// Numbers that are finite but beyond any use end in a line, not in hours.
#[test]
fn what_would_never_end_is_refused_at_once() {
    let swap = |from: &str, to: &str| HALL.replace(from, to);
    let poses = "follow = \"poses\"\nlaps = 1000\nposes = [[1, 2, 0], [2, 2, 0]]";
    for (world, part) in [
        (swap("[9, 2]]", "[1e9, 2]]"), "corner 1 is (1e9, 2e0)"),
        (swap("radius_m = 0.25", "start_scatter_m = 1e300"), "`start_scatter_m`"),
        (swap("radius_m = 0.25", "start_scatter_m = 50"), "less than the route's 8.00 m"),
        (swap("radius_m = 0.25", "speed_m_per_s = 1e-9"), "`speed_m_per_s` is 1e-9"),
        (
            swap("corners = [[1, 2], [9, 2]]", poses).replace("every_m = 0.5\nruns = 2", "runs = 10000"),
            "20000000 snapshots",
        ),
        (
            swap(
                "corners = [[1, 2], [9, 2]]",
                "corners = [[1, 2], [9, 2], [9, 4]]\nclosed = true\nlaps = 1000\nbend_radius_m = 0.1",
            )
            .replace("every_m = 0.5\nruns = 2", "every_m = 1e5\nruns = 10000"),
            "1000000 m in all",
        ),
        (
            swap("beams = 8", "beams = 10000\nrays = 1").replace("every_m = 0.5\nruns = 2", "snapshots = 70000\nruns = 200"),
            "700000000 values",
        ),
    ] {
        let (place, answer) = simulate(&world, &[]);
        answer.refused(2, &[part]);
        assert_eq!(place.files(), ["world.toml"], "{}", answer.stderr);
    }
}

#[test]
fn a_door_that_is_shut_while_mapping_is_in_the_way_until_then() {
    let wall = "[[wall]]\npoints = [[5, 0], [5, 6]]\n[[wall.door]]\nat_m = 1.2\nwidth_m = 1.6\n\
                open = 1.0\nopened_deg = [90, 90]\nshut_while_mapping = true\n";
    let world = |map_laps: &str| {
        let hall = HALL.replace("at = [5, 5]", "at = [2, 5]");
        format!("{wall}room_depth_m = 3\n{hall}[people]\nmap_laps = {map_laps}\n")
    };
    // A name must come first in the file.
    let first = |world: String| {
        format!(
            "name = \"hall\"\n{}",
            world.replace("name = \"hall\"\n", "")
        )
    };
    let (_, answer) = simulate(&first(world("1")), &[]);
    answer.refused(1, &["run 0", "hits a wall"]);
}
