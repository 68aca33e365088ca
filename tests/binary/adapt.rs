//! A model that learns on from runs that it labels itself.

use crate::support::{Answer, Workplace, answer, binary};
use ballmark::{
    Model, Recording, Seed,
    recording::{Columns, npz},
    world::corridor::{CorridorConfig, thrun1998},
};
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

fn repository(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// Another run through the corridor of the repository's models.
fn corridor(place: &Workplace, name: &str, seed: u64) {
    let config = CorridorConfig {
        runs: 1,
        ..CorridorConfig::default()
    };
    let recording = thrun1998(Seed(seed), &config).unwrap();
    npz::write(&place.path(name), &recording).unwrap();
}

fn adapt(place: &Workplace, more: &[&str]) -> Answer {
    let model = repository("models/corridor-2m.safetensors");
    let model = model.to_str().unwrap().to_string();
    let first = ["adapt".to_string(), model];
    let more = more.iter().map(|word| word.to_string());
    place.ballmark(&first.into_iter().chain(more).collect::<Vec<_>>())
}

fn json(answer: &Answer) -> serde_json::Value {
    serde_json::from_str(&answer.stdout).unwrap()
}

/// What the model of the repository was trained on.
fn trained_on(place: &Workplace) -> &'static str {
    let recording = thrun1998(Seed(1), &CorridorConfig::default()).unwrap();
    npz::write(&place.path("old.npz"), &recording).unwrap();
    "old.npz"
}

/// From day to day: adapt, keep the memory, adapt again, localise with what came out.
#[test]
fn a_model_is_adapted_again_and_again_and_remains_one() {
    let place = Workplace::new();
    corridor(&place, "monday.npz", 5);
    corridor(&place, "tuesday.npz", 6);
    corridor(&place, "wednesday.npz", 7);
    let (old, steps) = (trained_on(&place), ["--steps", "3", "--json"]);
    let files = [
        "monday.npz",
        "-o",
        "m1.safetensors",
        "--trained-on",
        old,
        "--memory",
        "mem1.npz",
    ];
    let first = json(adapt(&place, &[&files[..], &steps].concat()).done());
    let labels = &first["datasets"][0]["labels"];
    assert!(labels["kept"].as_u64().unwrap() > 50, "{first}");
    assert_eq!(labels["beyond"], 0, "{first}"); // along a route there is no beyond
    assert!(
        labels["errors"]["median_m"].as_f64().unwrap() < 0.4,
        "{first}"
    );
    assert_eq!(first["updates"][0]["steps"], 3);
    let files = [
        "adapt",
        "m1.safetensors",
        "tuesday.npz",
        "-o",
        "m2.safetensors",
        "--trained-on",
        "mem1.npz",
    ];
    let second = json(place.ballmark(&[&files[..], &steps].concat()).done());
    assert_eq!(second["updates"].as_array().unwrap().len(), 2);
    // Any command takes it; of what it has taken in it is no judge.
    let files = [
        "localise",
        "m2.safetensors",
        "wednesday.npz",
        "--trials",
        "6",
        "--json",
    ];
    assert!(json(place.ballmark(&files).done())["trials"].as_u64() == Some(6));
    let files = ["localise", "m2.safetensors", "tuesday.npz", "--trials", "6"];
    place
        .ballmark(&files)
        .refused(1, &["tuesday.npz", "the model was adapted to this dataset"]);
    let files = [
        "localise",
        "m1.safetensors",
        "tuesday.npz",
        "--trials",
        "6",
        "--trained-on",
        "mem1.npz",
    ];
    place.ballmark(&files).done();
    place
        .ballmark(&["export", "m2.safetensors", "-o", "weights.npz"])
        .done();
    // Both days at once are both days one after the other.
    let files = [
        "monday.npz",
        "tuesday.npz",
        "-o",
        "both.safetensors",
        "--trained-on",
        old,
    ];
    adapt(&place, &[&files[..], &steps].concat()).done();
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(bytes("both.safetensors") == bytes("m2.safetensors"));
}

#[test]
fn the_same_bytes_come_out_whatever_the_poses_say_and_however_many_threads_there_are() {
    let place = Workplace::new();
    corridor(&place, "new.npz", 5);
    let read = npz::read(&place.path("new.npz")).unwrap();
    let mut columns = read.into_columns();
    columns.pose.reverse();
    columns.pose.iter_mut().for_each(|pose| pose.x_m *= 0.5);
    columns.route_m.as_mut().unwrap().reverse();
    columns.dataset_sha256 = None;
    let scrambled = Recording::new(columns).unwrap();
    npz::write(&place.path("scrambled.npz"), &scrambled).unwrap();
    let old = trained_on(&place);
    let adapted = |input: &str, output: &str| {
        let files = [input, "-o", output, "--trained-on", old, "--steps", "2"];
        adapt(&place, &files).done();
        let mut model = Model::read(&place.path(output)).unwrap();
        model.header.updates[0].dataset_sha256 = None; // which file it was
        model
    };
    assert!(adapted("new.npz", "a.safetensors") == adapted("scrambled.npz", "b.safetensors"));
    let table = adapt(&place, &["scrambled.npz", "-o", "c.npz", "--steps", "0"]);
    assert!(table.done().stdout.contains("all >1 m %"));
    let model = repository("models/corridor-2m.safetensors");
    let model = model.to_str().unwrap();
    for threads in ["1", "3"] {
        let output = format!("on{threads}.safetensors");
        let arguments = [
            "adapt",
            model,
            "new.npz",
            "-o",
            &output,
            "--trained-on",
            old,
            "--steps",
            "2",
        ];
        let mut command = Command::new(binary());
        command.args(arguments).env("RAYON_NUM_THREADS", threads);
        answer(command.current_dir(place.path("."))).done();
    }
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(bytes("on1.safetensors") == bytes("on3.safetensors"));
}

#[test]
fn a_gate_that_nothing_passes_leaves_the_model_as_it_was() {
    let place = Workplace::new();
    corridor(&place, "new.npz", 5);
    let closed = [
        "new.npz",
        "-o",
        "same.safetensors",
        "--steps",
        "0",
        "--gate",
        "0",
    ];
    let answer = adapt(&place, &closed);
    assert!(
        answer
            .done()
            .stderr
            .contains("new.npz: no label passes the gate of 0"),
        "{}",
        answer.stderr
    );
    let own = fs::read(repository("models/corridor-2m.safetensors")).unwrap();
    let before = Model::read(&place.write("before.safetensors", own)).unwrap();
    let after = Model::read(&place.path("same.safetensors")).unwrap();
    assert!(before == after);
    // With a known start as with an unknown one.
    let known = [
        "new.npz",
        "-o",
        "known.safetensors",
        "--steps",
        "0",
        "--start",
        "0.5",
    ];
    adapt(&place, &known).done();
}

#[test]
fn bad_calls_and_bad_input_get_a_line_and_leave_nothing() {
    let place = Workplace::new();
    corridor(&place, "new.npz", 5);
    let old = trained_on(&place);
    let fails = |more: &[&str], status: i32, words: &[&str]| {
        adapt(&place, more).refused(status, words);
        assert!(!place.path("out.safetensors").exists(), "{more:?}");
    };
    let out = ["-o", "out.safetensors"];
    let with = |more: &[&'static str]| [&["new.npz"][..], &out, more].concat();
    fails(&with(&[]), 2, &["--trained-on", "--steps 0"]);
    fails(
        &with(&["--steps", "0", "--memory", "mem.npz"]),
        2,
        &["--memory", "--trained-on"],
    );
    fails(&with(&["--gate", "2"]), 2, &["labels.gate = 2"]);
    fails(&with(&["--half-life", "0"]), 2, &["half_life = 0"]);
    fails(
        &with(&["--steps", "0", "--start", "1,2"]),
        2,
        &["expected x,y,heading"],
    );
    fails(
        &with(&["--steps", "0", "--start=-900"]),
        1,
        &["new.npz", "off the grid"],
    );
    fails(
        &["new.npz", "-o", "out.txt", "--steps", "0"],
        2,
        &["out.txt"],
    );
    fails(
        &["none.npz", "-o", "out.safetensors", "--steps", "0"],
        1,
        &["none.npz"],
    );
    let wrong = [
        "new.npz",
        "-o",
        "out.safetensors",
        "--trained-on",
        "new.npz",
    ];
    fails(
        &wrong,
        1,
        &["new.npz", "snapshots that the model's map is made of"],
    );
    place.write("c.toml", "[adapt.update]\nrate = 0\n");
    fails(
        &with(&["--config", "c.toml"]),
        2,
        &["c.toml: line 2", "rate = 0"],
    );
    place.write("c.toml", "[adapt]\nhalflife = 0\n");
    fails(&with(&["--config", "c.toml"]), 2, &["c.toml", "halflife"]);

    // Other channels, and odometry that stands.
    let read = npz::read(&place.path("new.npz")).unwrap();
    let changed = |name: &str, change: fn(&mut Columns)| {
        let mut columns = read.clone().into_columns();
        change(&mut columns);
        let changed = Recording::new(columns).unwrap();
        npz::write(&place.path(name), &changed).unwrap();
    };
    changed("radar.npz", |columns| {
        columns.channels[0].name = "radar".into()
    });
    fails(
        &["radar.npz", "-o", "out.safetensors", "--steps", "0"],
        1,
        &["radar.npz", "sonar"],
    );
    changed("stands.npz", |columns| {
        columns.odometry.fill(Default::default())
    });
    fails(
        &["stands.npz", "-o", "out.safetensors", "--steps", "0"],
        1,
        &["stands.npz", "never moves"],
    );

    // A bank.
    let small = ["--features", "1", "--steps", "1"];
    let bank = [
        "train",
        old,
        "-o",
        "bank.safetensors",
        "--uncertainty",
        "bank",
    ];
    place.ballmark(&[&bank[..], &small].concat()).done();
    let files = [
        "adapt",
        "bank.safetensors",
        "new.npz",
        "-o",
        "out.safetensors",
        "--steps",
        "0",
    ];
    place
        .ballmark(&files)
        .refused(1, &["bank.safetensors", "expected a single model"]);
}
