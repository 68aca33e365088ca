//! `[degraded]`: recordings as a worse sensor would have made them, by all commands that read a dataset.

use crate::support::{Answer, Workplace};
use serde_json::Value;

/// A hall that a robot with 24 sonars and a laser of 60 beams goes round several times, recorded as `hall.npz`; in `worse.toml`, worse ones.
fn workplace() -> Workplace {
    let place = Workplace::new();
    place.write(
        "hall.toml",
        "name = \"hall\"\n\
         [[wall]]\npoints = [[0, 0], [8, 0], [8, 5], [4, 5], [4, 4], [0, 4]]\nclosed = true\n\
         [robot]\nkind = \"b21\"\n\
         [laser]\nbeams = 60\n\
         [path]\nclosed = true\nlaps = 6\ncorners = [[1, 1], [7, 1], [7, 3], [1, 3]]\n\
         [record]\nevery_s = 2.0\n",
    );
    place
        .ballmark(&["simulate", "hall.toml", "-o", "hall.npz"])
        .done();
    place.write("worse.toml", WORSE);
    place
}

const WORSE: &str = "[train.descent]\nsteps = 5\n[localise]\ntrials = 3\nresamples = 20\n\
                     [degraded]\nbeams = 12\nreach_m = 4.0\nblocked_rad = [[-0.3, 0.5]]\npeople = 0.3\n";

fn train(place: &Workplace, model: &str, more: &[&str]) -> Answer {
    let usual = [
        "train",
        "hall.npz",
        "-o",
        model,
        "--test-fold",
        "0",
        "--features",
        "2",
    ];
    place.ballmark(&[&usual, more].concat())
}

fn localise(place: &Workplace, model: &str, more: &[&str]) -> Answer {
    place.ballmark(&[&["localise", model, "hall.npz"], more].concat())
}

fn json(answer: &Answer) -> Value {
    serde_json::from_str(&answer.done().stdout).unwrap()
}

#[test]
fn a_worse_sensor_is_trained_for_and_localises() {
    let place = workplace();
    let worse = ["--config", "worse.toml"];
    let trained = train(&place, "worse.safetensors", &worse);
    let told = "sensor degraded: sonar: 10 of 24 beams, laser: 9 of 60 beams, reach 4 m, blocked from -0.3 to 0.5 rad";
    assert!(trained.done().stdout.contains(told), "{}", trained.stdout);

    // The same section again: the model's own recording, and so its test part, with people in it.
    let played = localise(&place, "worse.safetensors", &worse);
    let said = &played.done().stdout;
    assert!(said.contains(told), "{said}");
    assert!(said.contains("people before 30 % of the beams"), "{said}");
    assert!(said.contains("occupancy map"), "{said}");
    assert!(!played.stderr.contains("a reach of"), "{}", played.stderr);
    let record = json(&localise(
        &place,
        "worse.safetensors",
        &[&worse[..], &["--json"]].concat(),
    ));
    let degraded = &record["degraded"];
    assert_eq!(degraded["beams"], 12);
    assert_eq!(degraded["reach_m"], 4.0);
    assert_eq!(degraded["blocked_rad"][0][1], 0.5);
    assert_eq!(degraded["channels"][1]["channel"], "laser");
    assert_eq!(degraded["channels"][1]["kept"], 9);
    assert_eq!(degraded["channels"][1]["recorded"], 60);
    assert_eq!(record["people"], 0.3);

    // What filters answer needs it, too.
    let features = ["features", "worse.safetensors", "hall.npz", "-o", "f.csv"];
    place
        .ballmark(&features)
        .refused(1, &["hall.npz", "24 values", "trained on 10"]);
    place.ballmark(&[&features[..], &worse].concat()).done();

    // Other sensors are refused: all beams, or the same beams reaching farther.
    let refused = |model: &str, config: &str, parts: &[&str]| {
        place.write("other.toml", config);
        localise(&place, model, &["--config", "other.toml"]).refused(1, parts);
    };
    let expected = "section [degraded] as it was in training";
    let width = "24 values; the model learned with 10";
    refused("worse.safetensors", "", &["hall.npz", width, expected]);
    let farther = WORSE.replace("4.0", "6.0");
    let reach = "a reach of 6 m; the model learned with 4 m";
    refused("worse.safetensors", &farther, &[reach, expected]);
    // As many, the ring of sonars turned by two of them.
    let turned = WORSE.replace("-0.3, 0.5", "0.2236, 1.0236");
    refused("worse.safetensors", &turned, &["directions", expected]);
}

#[test]
fn people_are_the_same_whoever_says_it() {
    let place = workplace();
    train(&place, "m.safetensors", &["--steps", "5"]).done();
    let systems = |config: &str, more: &[&str]| {
        let text = format!("{config}\n[localise]\ntrials = 3\nresamples = 20\n");
        place.write("c.toml", text);
        let usual = ["--config", "c.toml", "--json"];
        let record = json(&localise(&place, "m.safetensors", &[&usual, more].concat()));
        (record["people"].clone(), record["systems"].clone())
    };
    let degraded = "[degraded]\npeople = 0.4";
    let (share, crowded) = systems(degraded, &[]);
    assert_eq!(share, 0.4);
    assert_eq!((share, crowded.clone()), systems("", &["--people", "0.4"]));
    let (nobody, empty) = systems(degraded, &["--people", "0"]); // an option goes before the file
    assert_eq!((nobody, empty.clone()), systems("", &[]));
    assert_ne!(crowded, empty);
    place.write(
        "c.toml",
        "[localise]\npeople = 0.2\n[degraded]\npeople = 0.4\n",
    );
    localise(&place, "m.safetensors", &["--config", "c.toml"]).refused(
        2,
        &[
            "c.toml: line 4",
            "degraded.people = 0.4",
            "localise.people = 0.2",
        ],
    );
}

#[test]
fn a_comparison_is_of_a_worse_sensor() {
    let place = workplace();
    let comparison = |degraded: &str, localisation: &str| {
        let text = format!(
            "[[dataset]]\nfile = 'hall.npz'\n\
             [[system]]\nkind = 'bayes'\nname = 'map'\nlandmarks = 'likelihood_field'\n\
             [[system]]\nkind = 'nearest'\n\
             [protocol]\nmapping = 'split'\nsplit = {{ test_fold = 0 }}\n\
             [error_reduction]\n[localisation]\ntrials = 3\nresamples = 20\n{localisation}\n\
             [degraded]\n{degraded}\n"
        );
        place.write("c.toml", text);
        place.ballmark(&["compare", "c.toml", "--json"])
    };
    let record = |degraded: &str, localisation: &str| json(&comparison(degraded, localisation));
    let trials = |record: &Value| record["localisation"]["records"][0]["done"]["results"].clone();
    let reduction = |record: &Value| record["error_reduction"]["cells"].clone();

    let (whole, few) = (record("", ""), record("beams = 6\nreach_m = 2", ""));
    assert_ne!(trials(&whole), trials(&few));
    let dataset = &few["datasets"][0];
    assert_eq!(dataset["degraded"]["channels"][1]["recorded"], 60);
    assert_eq!(
        dataset["notes"][0],
        "sensor degraded: sonar: 6 of 24 beams, laser: 6 of 60 beams, reach 2 m"
    );
    assert_eq!(dataset["sha256"], whole["datasets"][0]["sha256"]);
    assert_eq!(few["config"]["degraded"]["beams"], 6);
    assert_eq!(whole["config"].get("degraded"), None);
    let played = &few["localisation"]["records"][0]["done"];
    assert_eq!(played["degraded"]["reach_m"], 2.0);

    // People are in the way of what every section tests on, and of the trials as [localisation] puts them there.
    let (by_section, by_all) = (record("", "people = 0.5"), record("people = 0.5", ""));
    assert_eq!(trials(&by_section), trials(&by_all));
    assert_ne!(trials(&by_all), trials(&whole));
    assert_eq!(by_all["localisation"]["records"][0]["done"]["people"], 0.5);
    assert_eq!(reduction(&by_section), reduction(&whole));
    assert_ne!(reduction(&by_all), reduction(&whole));
    let twice = record("people = 0.5", "people = 0.5");
    assert_eq!(trials(&twice), trials(&by_all)); // not two crowds
    comparison("people = 0.5", "people = 0.4").refused(
        2,
        &[
            "c.toml: line 18",
            "degraded.people = 0.5",
            "localisation.people = 0.4",
        ],
    );
    comparison("beams = 0", "").refused(2, &["c.toml: line 18", "degraded.beams = 0"]);
    comparison("blocked_rad = [[-3.2, 3.2]]", "").refused(1, &["hall", "`sonar`", "no beam"]);
}

#[test]
fn values_that_make_no_sense_are_one_line() {
    let place = workplace();
    let refused = |section: &str, status: i32, parts: &[&str]| {
        place.write("c.toml", format!("[degraded]\n{section}\n"));
        let config = ["--config", "c.toml"];
        let trained = train(&place, "m.safetensors", &config);
        trained.refused(status, parts);
        assert_eq!(trained.stderr.lines().count(), 1, "{}", trained.stderr);
        assert!(!place.path("m.safetensors").exists());
    };
    let in_line = "c.toml: line 2: ";
    refused("beams = 0", 2, &[in_line, "beams = 0", "at least 1"]);
    refused("beams = -3", 2, &[in_line, "-3"]);
    refused("beams = 2.5", 2, &[in_line, "2.5"]);
    refused("reach_m = 0", 2, &[in_line, "reach_m = 0", "more than 0"]);
    refused("reach_m = nan", 2, &[in_line, "reach_m = NaN"]);
    refused("blocked_rad = [[0.1]]", 2, &[in_line, "length"]);
    refused("blocked_rad = [0.1, 0.2]", 2, &[in_line]);
    refused("blocked_rad = [[0.1, 6.4]]", 2, &[in_line, "6.4", "±2π"]);
    refused("people = 1.2", 2, &[in_line, "people = 1.2", "0 to 1"]);
    refused("range_m = 3", 2, &[in_line, "unknown field `range_m`"]);
    let all_round = "blocked_rad = [[0, 6.2832]]";
    refused(all_round, 1, &["hall.npz", "`sonar`", "at least one"]);

    // No range sensor, nothing to degrade.
    place.write(
        "light.csv",
        "time_s,x_m,y_m,heading_rad,light\n0,0,0,0,1\n1,1,0,0,2\n2,2,0,0,3\n",
    );
    let import = ["import", "light.csv", "-o", "hall.npz"];
    place.ballmark(&import).done();
    let nothing = "no channel in metres has bearings";
    refused("reach_m = 3", 1, &["hall.npz", "degraded", nothing]);
}
