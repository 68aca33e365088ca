//! `ballmark train` on the real binary, at toy size.

use crate::support::{Answer, Workplace, answer, binary};
use std::{
    fmt::Write,
    fs,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

/// Three runs along the same 20 m with eight light sensors, as the dataset `toy.npz`; with a route or in the plane.
pub fn toy(place: &Workplace, with_route: bool) {
    place.write("toy.csv", toy_csv(80, with_route));
    place
        .ballmark(&["import", "toy.csv", "-o", "toy.npz"])
        .done();
}

fn toy_csv(snapshots_a_run: usize, with_route: bool) -> String {
    let mut csv = String::from("time_s,x_m,y_m,heading_rad,run");
    csv += if with_route { ",route_m" } else { "" };
    (0..8).for_each(|c| write!(csv, ",light.{c}").unwrap());
    let mut noise = 1u32;
    for k in 0..3 * snapshots_a_run {
        let x_m = (k % snapshots_a_run) as f64 * 0.25;
        write!(csv, "\n{k},{x_m},0,0,{}", k / snapshots_a_run).unwrap();
        if with_route {
            write!(csv, ",{x_m}").unwrap();
        }
        for c in 0..8 {
            noise = noise.wrapping_mul(1664525).wrapping_add(1013904223);
            let wave = (x_m * (0.3 + 0.17 * f64::from(c)) + f64::from(c)).sin();
            let light = 2.0 + wave + 0.2 * f64::from(noise >> 16) / 65536.0;
            write!(csv, ",{light:.3}").unwrap();
        }
    }
    csv + "\n"
}

fn train(place: &Workplace, output: &str, more: &[&str]) -> Answer {
    place.ballmark(&[&["train", "toy.npz", "-o", output], more].concat())
}

fn bytes(place: &Workplace, name: &str) -> Vec<u8> {
    fs::read(place.path(name)).expect(name)
}

#[test]
fn reports_its_errors_in_json_and_leaves_only_the_model() {
    let place = Workplace::new();
    toy(&place, true);
    let more = ["--features", "2", "--steps", "300", "--json"];
    let answer = train(&place, "m.safetensors", &more);
    answer.done();
    let result: serde_json::Value = serde_json::from_str(&answer.stdout).expect("one JSON object");
    for part in ["train", "validation"] {
        let [prior, posterior, reduction] =
            ["prior_error_m", "posterior_error_m", "error_reduction"]
                .map(|key| result[part][key].as_f64().expect(key));
        assert!(0.9 < prior && prior < 1.1, "{part}: {prior}"); // ±2 m: a metre in the middle of the route
        assert!((reduction - (1.0 - posterior / prior)).abs() < 1e-12);
        assert!(reduction > 0.2, "{part}: {reduction}");
    }
    assert_eq!(result["steps"], 300);
    assert_eq!(result["stopped_by"], "steps");
    assert!(
        result["timing"]["seconds"]
            .as_f64()
            .is_some_and(|s| s > 0.0)
    );
    assert_eq!(place.files(), ["m.safetensors", "toy.csv", "toy.npz"]);
    let scale = result["evidence_scale"].as_f64();
    assert!(scale.is_some_and(|s| s > 0.0), "{scale:?}");
}

#[test]
fn networks_that_overflow_in_the_last_step_are_no_perfect_model() {
    let place = Workplace::new();
    toy(&place, true);
    let config = "[train]\nfeatures = 2\nbegin_with = \"random\"\nnetwork = { trunk = [6], hidden = [3] }\n\
                  descent = { learning_rate = 1e20, weight_decay = 0.0, steps = 1 }\n\
                  split = { unit = \"runs\", validation_every = 3 }\n";
    place.write("c.toml", config);
    let answer = train(&place, "m.safetensors", &["--config", "c.toml"]);
    answer.refused(
        1,
        &[
            "the objective is no longer a number after 1 steps",
            "learning_rate",
        ],
    );
    assert!(!place.path("m.safetensors").exists());
}

#[test]
fn trains_for_a_window_and_for_anywhere_on_a_route_and_in_the_plane() {
    for with_route in [true, false] {
        let place = Workplace::new();
        toy(&place, with_route);
        for uncertainty in ["2m", "2m,any", "2m,0.3rad", "global"] {
            let more = ["--uncertainty", uncertainty, "--features", "2", "--json"];
            let answer = train(&place, "m.npz", &[&more[..], &["--steps", "300"]].concat());
            answer.done();
            let result: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
            let reduction = result["validation"]["error_reduction"].as_f64().unwrap();
            assert!(reduction > 0.2, "{uncertainty}: {reduction}");
            let model = ballmark::model::Model::read(&place.path("m.npz")).unwrap();
            assert_eq!(model.header.prior.to_string(), uncertainty);
            assert_eq!(model.route_m.is_some(), with_route);
        }
    }
}

#[test]
fn gives_the_same_bytes_with_one_thread_with_many_and_again() {
    let place = Workplace::new();
    for (with_route, uncertainty) in [(true, "2m"), (false, "2m"), (false, "global")] {
        toy(&place, with_route);
        let trained = |name: &str, threads: &str| {
            let mut command = Command::new(binary());
            command
                .args(["train", "toy.npz", "-o", name, "--uncertainty", uncertainty])
                .args(["--features", "3", "--steps", "40"])
                .current_dir(place.path(""))
                .env("RAYON_NUM_THREADS", threads);
            answer(&mut command).done();
            bytes(&place, name)
        };
        let one = trained("one.safetensors", "1");
        assert!(one == trained("four.safetensors", "4"), "{uncertainty}");
        assert!(one == trained("again.safetensors", "4"), "{uncertainty}");
    }
    let other_seed = train(
        &place,
        "seed.safetensors",
        &[
            "--uncertainty",
            "global",
            "--features",
            "3",
            "--steps",
            "40",
            "--seed",
            "2",
        ],
    );
    other_seed.done();
    assert!(bytes(&place, "seed.safetensors") != bytes(&place, "one.safetensors"));
}

/// Long enough to be killed in: seconds, with a checkpoint every tenth of one or so.
const LONG: &str =
    "[train]\nfeatures = 6\n[train.descent]\nsteps = 600\npatience = 600\ncheckpoint_every = 25\n";

/// Starts a training into `output` and kills it when `now` says so; it must not have come to its end.
fn kill_when(
    place: &Workplace,
    output: &str,
    more: &[&str],
    mut now: impl FnMut(Duration) -> bool,
) {
    let started = Instant::now();
    let mut child = Command::new(binary())
        .args(["train", "toy.npz", "-o", output])
        .args(more)
        .current_dir(place.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the binary runs");
    while !now(started.elapsed()) {
        assert!(started.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().expect("a running child");
    let status = child.wait().expect("a dead child");
    assert_eq!(status.code(), None, "it ended before it was killed");
    assert!(!place.path(output).exists());
}

#[test]
fn resumes_to_the_same_bytes_after_being_killed() {
    let place = Workplace::new();
    toy(&place, true);
    place.write("long.toml", LONG);
    let config = ["--config", "long.toml"];
    let resume = ["--config", "long.toml", "--resume"];
    train(&place, "whole.safetensors", &config).done();
    let whole = bytes(&place, "whole.safetensors");

    let checkpoint = place.path("killed.safetensors.checkpoint");
    kill_when(&place, "killed.safetensors", &config, |_| {
        checkpoint.exists()
    });
    // Killed again, at no particular moment after some more checkpoints.
    let mut last = fs::read(&checkpoint).unwrap();
    let mut further = 0;
    kill_when(&place, "killed.safetensors", &resume, |_| {
        let now = fs::read(&checkpoint).unwrap();
        further += usize::from(now != last);
        last = now;
        further == 3
    });
    let answer = train(&place, "killed.safetensors", &resume);
    answer.done();
    assert!(
        !answer.stderr.contains("learning: 60 of 600 "),
        "it started afresh: {}",
        answer.stderr
    );
    assert!(bytes(&place, "killed.safetensors") == whole);
    assert!(!checkpoint.exists());

    // Killed before the first checkpoint: it starts afresh, and says so. (On a busy machine the kill may come late; then once more.)
    let checkpoint = place.path("soon.safetensors.checkpoint");
    loop {
        let soon = Duration::from_millis(3);
        kill_when(&place, "soon.safetensors", &config, |since| since > soon);
        if !checkpoint.exists() {
            break;
        }
        fs::remove_file(&checkpoint).unwrap();
    }
    let answer = train(&place, "soon.safetensors", &resume);
    let line = "note: no checkpoint soon.safetensors.checkpoint: the training starts afresh";
    assert!(answer.done().stderr.contains(line), "{}", answer.stderr);
    assert!(bytes(&place, "soon.safetensors") == whole);
}

/// Sends a signal to a training once its first checkpoint is there, and waits for its end.
#[cfg(unix)]
fn interrupted(place: &Workplace, output: &str, config: &str, signal: &str) -> Answer {
    let checkpoint = place.path(&format!("{output}.checkpoint"));
    let mut child = Command::new(binary())
        .args(["train", "toy.npz", "-o", output, "--config", config])
        .current_dir(place.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let started = Instant::now();
    while !checkpoint.exists() {
        assert!(started.elapsed() < Duration::from_secs(60), "no checkpoint");
        assert!(child.try_wait().expect("a child").is_none(), "it ended");
        std::thread::sleep(Duration::from_millis(1));
    }
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(sent.expect("kill runs").success());
    let output = child.wait_with_output().expect("a child that ends");
    Answer {
        status: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_checkpoint_and_says_how_to_go_on() {
    let place = Workplace::new();
    toy(&place, true);
    place.write("long.toml", LONG);
    train(&place, "whole.safetensors", &["--config", "long.toml"]).done();
    for signal in ["-INT", "-TERM"] {
        let answer = interrupted(&place, "m.safetensors", "long.toml", signal);
        let parts = ["cancelled at step", "m.safetensors.checkpoint", "--resume"];
        answer.refused(1, &parts);
        assert!(!place.path("m.safetensors").exists());
        let resume = ["--config", "long.toml", "--resume"];
        train(&place, "m.safetensors", &resume).done();
        assert!(bytes(&place, "m.safetensors") == bytes(&place, "whole.safetensors"));
        fs::remove_file(place.path("m.safetensors")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_checkpoint_goes_on_to_more_steps_and_to_no_other_data() {
    let place = Workplace::new();
    toy(&place, true);
    place.write(
        "long.toml",
        format!("{LONG}[train.input]\nhistory_m = []\n"),
    );
    interrupted(&place, "m.safetensors", "long.toml", "-INT").refused(1, &["--resume"]);
    let checkpoint = bytes(&place, "m.safetensors.checkpoint");

    let resume = ["--config", "long.toml", "--resume"];
    let fewer = [&resume[..], &["--steps", "20"]].concat();
    let parts = ["m.safetensors.checkpoint", "at step", "--steps"];
    train(&place, "m.safetensors", &fewer).refused(1, &parts);
    assert!(bytes(&place, "m.safetensors.checkpoint") == checkpoint);

    let more = [&resume[..], &["--steps", "640", "--json"]].concat();
    let answer = train(&place, "m.safetensors", &more);
    assert!(
        answer.done().stderr.contains("note: went on from step"),
        "{}",
        answer.stderr
    );
    let result: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    assert_eq!(result["steps"], 640);
    assert!(result["resumed_at"].as_u64().is_some_and(|step| step >= 25));

    // The same recipe and the same names, but one reading is another one.
    place.write("m.safetensors.checkpoint", checkpoint);
    fs::remove_file(place.path("m.safetensors")).unwrap();
    let other = toy_csv(80, true).replacen("\n3,0.75,0,0,0,0.75,", "\n3,0.75,0,0,0,0.75,9", 1);
    assert_ne!(other, toy_csv(80, true));
    place.write("toy.csv", other);
    place
        .ballmark(&["import", "toy.csv", "-o", "toy.npz"])
        .done();
    train(&place, "m.safetensors", &resume).refused(1, &["another training", "other data"]);
}

#[test]
fn a_finished_training_is_not_learned_anew() {
    let place = Workplace::new();
    toy(&place, true);
    let call = ["--features", "2", "--steps", "60"];
    let resume = [&call[..], &["--resume"]].concat();
    let first = train(&place, "m.safetensors", &call);
    let model = bytes(&place, "m.safetensors");
    let again = train(&place, "m.safetensors", &resume);
    assert!(
        again.done().stderr.contains("nothing is learned anew"),
        "{}",
        again.stderr
    );
    assert!(!again.stderr.contains("learning:"), "{}", again.stderr);
    let rows = |answer: &Answer| {
        let lines = answer.stdout.lines();
        lines.take(4).map(String::from).collect::<Vec<_>>()
    };
    assert_eq!(rows(&again), rows(first.done()));
    assert!(
        again.stdout.contains("60 steps (all steps taken)"),
        "{}",
        again.stdout
    );
    assert!(bytes(&place, "m.safetensors") == model);
    // The model of a shorter training has no checkpoint left to go on from.
    let more = ["--features", "2", "--steps", "90", "--resume"];
    train(&place, "m.safetensors", &more).refused(
        1,
        &[
            "m.safetensors",
            "same training of 60 steps",
            "without --resume",
            "90 steps",
        ],
    );
    assert!(bytes(&place, "m.safetensors") == model);
    // One of another training does not stand in the way, and what is no model doesn't either.
    let other = [&resume[..], &["--seed", "5"]].concat();
    let answer = train(&place, "m.safetensors", &other);
    assert!(
        answer.done().stderr.contains("starts afresh"),
        "{}",
        answer.stderr
    );
    assert!(bytes(&place, "m.safetensors") != model);
    place.write("m.safetensors", "no model");
    train(&place, "m.safetensors", &resume).done();
    assert!(bytes(&place, "m.safetensors") == model);
}

#[test]
fn a_small_validation_part_and_an_empty_one_are_noted() {
    let place = Workplace::new();
    toy(&place, true);
    place.write(
        "runs.toml",
        "[train.split]\nunit = \"runs\"\nvalidation_every = 3\n",
    );
    let call = ["--features", "2", "--steps", "20"];
    let by_runs = [&call[..], &["--config", "runs.toml"]].concat();
    let notes = |answer: &Answer| answer.stderr.matches("note: ").count();
    let answer = train(&place, "m.safetensors", &by_runs);
    assert_eq!(notes(answer.done()), 0, "{}", answer.stderr);

    place.write("few.csv", toy_csv(30, true));
    place
        .ballmark(&["import", "few.csv", "-o", "few.npz"])
        .done();
    let train_on_few = |more: &[&str]| {
        place.ballmark(&[&["train", "few.npz", "-o", "m.npz"], &call[..], more].concat())
    };
    let answer = train_on_few(&["--config", "runs.toml"]);
    let line = "note: only 30 validation snapshots";
    assert!(answer.done().stderr.contains(line), "{}", answer.stderr);

    place.write("none.toml", "[train.split]\nvalidation_every = 0\n");
    let answer = train_on_few(&["--config", "none.toml", "--json"]);
    let line = "note: no validation snapshot";
    assert!(answer.done().stderr.contains(line), "{}", answer.stderr);
    assert_eq!(notes(&answer), 1, "{}", answer.stderr);
    let result: serde_json::Value = serde_json::from_str(&answer.stdout).unwrap();
    assert!(
        result["notes"][0]
            .as_str()
            .is_some_and(|n| n.starts_with("no validation"))
    );
}

#[test]
fn a_hopeless_training_ends_early_and_says_so() {
    let place = Workplace::new();
    let mut csv = String::from("time_s,x_m,y_m,heading_rad,run,light");
    for k in 0..240 {
        // The reading depends on the run alone, not on the place.
        write!(
            csv,
            "\n{k},{},0,0,{},{}",
            (k % 80) as f64 * 0.25,
            k / 80,
            k / 80
        )
        .unwrap();
    }
    place.write("toy.csv", csv + "\n");
    place
        .ballmark(&["import", "toy.csv", "-o", "toy.npz"])
        .done();
    let call = ["--features", "2", "--steps", "800"];
    let answer = train(&place, "m.safetensors", &call);
    assert!(
        answer
            .done()
            .stdout
            .contains("steps (stopped: nothing learned"),
        "{}",
        answer.stdout
    );
    assert!(
        answer.stderr.contains("note: less than 1 %"),
        "{}",
        answer.stderr
    );
    let answer = train(&place, "m.safetensors", &[&call[..], &["--json"]].concat());
    let result: serde_json::Value = serde_json::from_str(&answer.done().stdout).unwrap();
    assert_eq!(result["stopped_by"], "nothing_learned");
    assert!(
        result["steps"]
            .as_u64()
            .is_some_and(|steps| (200..500).contains(&steps))
    );
}

#[test]
fn progress_and_table_show_the_same_figure() {
    let place = Workplace::new();
    toy(&place, true);
    let answer = train(
        &place,
        "m.safetensors",
        &["--features", "2", "--steps", "200"],
    );
    let row = answer
        .done()
        .stdout
        .lines()
        .find(|line| line.starts_with("validation "));
    let in_table = row
        .and_then(|row| row.split_whitespace().last())
        .expect("a row");
    // Two trainings, with and without the readings of the last metres; the better one is the model's.
    let line = format!("learning: 400 of 400, validation {in_table} %");
    assert!(
        answer.stderr.contains(&line),
        "{}\n{}",
        answer.stdout,
        answer.stderr
    );
}

#[test]
fn a_checkpoint_that_does_not_fit_is_refused() {
    let place = Workplace::new();
    toy(&place, true);
    place.write("long.toml", LONG);
    let checkpoint = place.path("m.safetensors.checkpoint");
    let config = ["--config", "long.toml"];
    kill_when(&place, "m.safetensors", &config, |_| checkpoint.exists());
    let whole = fs::read(&checkpoint).unwrap();

    let resume = ["--config", "long.toml", "--resume", "--seed", "2"];
    let named = "m.safetensors.checkpoint";
    let refused = |more: &[&str], fault: &str| {
        let answer = train(&place, "m.safetensors", more);
        answer.refused(1, &[named, fault, "without --resume"]);
        assert!(!answer.stderr.contains("toy.npz"), "{}", answer.stderr);
        assert!(!place.path("m.safetensors").exists());
    };
    refused(&resume, "another training");
    let mut damaged = vec![
        Vec::new(),
        whole[..10].to_vec(),
        whole[..whole.len() - 1].to_vec(),
    ];
    for at in [0, 9, whole.len() / 2, whole.len() - 1] {
        let mut flipped = whole.clone();
        flipped[at] ^= 4;
        damaged.push(flipped);
    }
    for content in damaged {
        fs::write(&checkpoint, content).unwrap();
        refused(&resume[..3], "is not as a checkpoint has it");
    }
}

#[test]
fn a_configuration_at_fault_is_a_wrong_call_and_names_the_line() {
    let place = Workplace::new();
    toy(&place, true);
    for (config, parts) in [
        (
            "[train]\nseed = 1\nfeature = 2\n",
            &["c.toml: line 3: ", "`feature`"][..],
        ),
        (
            "[train.descent]\nrate = 1\n",
            &["c.toml: line 2: ", "`rate`"],
        ),
        ("\n[training]\n", &["c.toml: line 2: ", "`training`"]),
        ("[train]\nfeatures = \"two\"\n", &["c.toml: line 2: "]),
        (
            "[train]\nuncertainty = \"-1m\"\n",
            &["c.toml: line 2: ", "`-1m`"],
        ),
        ("[train]\n\nfeatures == 2\n", &["c.toml: line 3: "]),
        ("[train]\nfeatures = 257\n", &["features = 257", "1 to 256"]),
        (
            "recipe = \"thrun1998\"\n[train]\nfeatures = 13\n",
            &["features = 13", "1 to 12"],
        ),
        (
            "recipe = \"thrun1999\"\n",
            &["c.toml: line 1: ", "`thrun1999`"],
        ),
        (
            "[train.network]\ntrunk = [0]\n",
            &["network.trunk", "0 units"],
        ),
        (
            "[train.priors]\nstated = 1.5\n",
            &["priors.stated = 1.5", "0 to 1"],
        ),
        (
            "[train.augmentation]\nshift_m = -1.0\n",
            &["augmentation.shift_m = -1"],
        ),
        (
            "[train.descent]\ntruths_per_step = 0\n",
            &["descent.truths_per_step = 0", "augmentation.shift_m"],
        ),
        // Read under its name of the version before.
        (
            "[train.descent]\nqueries = 0\n",
            &["descent.truths_per_step = 0", "augmentation.shift_m"],
        ),
        (
            "[train.descent]\nobjective = \"exact\"\n[train.priors]\nstated = 0.5\n",
            &["priors.stated = 0.5", "exact objective"],
        ),
        ("[train.descent]\nsteps = 0\n", &["descent.steps = 0"]),
        (
            "[train.descent]\nlearning_rate = nan\n",
            &["descent.learning_rate"],
        ),
        (
            "[train.network]\nhidden = [1000000000]\n",
            &["network.hidden", "1000000000 units"],
        ),
        (
            "[train.map]\nunmodelled_probability = 2.0\n",
            &["map.unmodelled_probability = 2"],
        ),
    ] {
        place.write("c.toml", config);
        let answer = train(&place, "m.safetensors", &["--config", "c.toml"]);
        answer.refused(2, parts);
    }
    for (more, parts) in [
        (["--uncertainty", "0m"], ["--uncertainty", "0m"]),
        (
            ["--uncertainty", "near"],
            ["--uncertainty", "expected `global`"],
        ),
        (["--features", "0"], ["features = 0", "expected 1 to"]),
    ] {
        train(&place, "m.safetensors", &more).refused(2, &parts);
    }
    train(&place, "m.onnx", &[]).refused(2, &["m.onnx", ".safetensors or .npz"]);
    train(&place, "m", &[]).refused(2, &["expected a name ending in"]);
    assert_eq!(place.files(), ["c.toml", "toy.csv", "toy.npz"]);
}

#[test]
fn an_output_that_cannot_be_made_is_refused_before_the_training() {
    let place = Workplace::new();
    place.write("file", "");
    fs::create_dir(place.path("folder.npz")).unwrap();
    for (output, fault) in [
        ("file/m.safetensors", "is a file, not a folder"),
        ("nowhere/m.npz", "does not exist"),
        ("folder.npz", "a folder of that name"),
    ] {
        // Even before the dataset is looked for, which isn't there.
        let answer = train(&place, output, &[]);
        answer.refused(1, &[output, "cannot write", fault]);
    }
}

#[test]
fn a_dataset_that_gives_nothing_to_learn_from_is_refused() {
    let place = Workplace::new();
    toy(&place, true);
    let none = ["--uncertainty", "0.1m", "--steps", "5"];
    // Three runs pass the same places, so a window of 10 cm holds others, but all at the very same place.
    train(&place, "m.safetensors", &none).refused(1, &["toy.npz", "at the same place"]);
    let import = |name: &str, csv: String| {
        place.write("d.csv", csv);
        place.ballmark(&["import", "d.csv", "-o", name]).done();
    };
    let refused = |name: &str, more: &[&str], parts: &[&str]| {
        let answer = place.ballmark(&[&["train", name, "-o", "m.safetensors"], more].concat());
        answer.refused(1, &[&[name], parts].concat());
        assert!(!place.path("m.safetensors").exists());
    };
    let one_run: String = toy_csv(80, true).split_inclusive('\n').take(41).collect();
    import("one.npz", one_run);
    refused("one.npz", &none, &["uncertainty 0.1m", "wider window"]);
    let few: String = toy_csv(80, true).split_inclusive('\n').take(5).collect();
    import("few.npz", few);
    refused(
        "few.npz",
        &[],
        &["4 training snapshots; expected at least k = 5"],
    );

    let whole = bytes(&place, "toy.npz");
    for len in [0, 1, 30, whole.len() / 2, whole.len() - 1] {
        place.write("cut.npz", &whole[..len]);
        refused("cut.npz", &[], &["expected a", "dataset"]);
    }
    place.write("text.npz", "time_s,x_m\n0,0\n");
    refused("text.npz", &[], &["not a whole .npz"]);
    refused("missing.npz", &[], &["cannot read"]);

    write_with_a_nan_pose(&place, "nan.npz");
    refused(
        "nan.npz",
        &[],
        &["`pose`", "snapshot 3", "not a finite number"],
    );
}

/// A dataset whose fourth pose is not a number: [`ballmark::recording::Recording`] itself would refuse it.
fn write_with_a_nan_pose(place: &Workplace, name: &str) {
    let k = 20;
    let meta = br#"{"channels": {"light": {"unit": "lux"}}}"#;
    let mut pose = ndarray::Array2::<f64>::zeros((k, 3));
    pose[[3, 0]] = f64::NAN;
    ballmark::archive::write(&place.path(name), |archive| {
        archive.add("meta", ndarray::ArrayView1::from(meta))?;
        archive.add("stamp", ndarray::Array1::<f64>::zeros(k).view())?;
        archive.add("pose", pose.view())?;
        archive.add("odometry", ndarray::Array2::<f64>::zeros((k, 3)).view())?;
        archive.add("run", ndarray::Array1::<i64>::zeros(k).view())?;
        archive.add("light", ndarray::Array2::<f32>::zeros((k, 1)).view())
    })
    .unwrap();
}

#[test]
fn a_recipe_by_name_holds_where_flags_and_configuration_are_silent() {
    let place = Workplace::new();
    toy(&place, true);
    let resolved = |more: &[&str]| {
        let call = ["--features", "2", "--steps", "3", "--json"];
        let answer = train(&place, "m.safetensors", &[&call[..], more].concat());
        let result: serde_json::Value =
            serde_json::from_str(&answer.done().stdout).expect("one JSON object");
        result["recipe"].clone()
    };
    let (default, paper) = (resolved(&[]), resolved(&["--recipe", "thrun1998"]));
    assert_eq!(default, resolved(&["--recipe", "default"]));
    assert_eq!(default["descent"]["objective"], "mean_field");
    assert_eq!(paper["descent"]["objective"], "exact");
    assert_eq!(paper["network"]["hidden"], serde_json::json!([6]));
    assert_eq!(paper["descent"]["steps"], 3);
    place.write(
        "c.toml",
        "recipe = \"thrun1998\"\n[train.network]\nhidden = [4]\n",
    );
    let mixed = resolved(&["--config", "c.toml"]);
    assert_eq!(mixed["network"]["hidden"], serde_json::json!([4]));
    assert_eq!(mixed["descent"], paper["descent"]);
    let flag_first = resolved(&["--config", "c.toml", "--recipe", "default"]);
    assert_eq!(flag_first["network"]["trunk"], default["network"]["trunk"]);
    train(&place, "m.safetensors", &["--recipe", "thrun1999"])
        .refused(2, &["--recipe", "`thrun1999`", "`default` or `thrun1998`"]);
}

#[test]
fn learns_from_several_recordings_of_one_building() {
    let place = Workplace::new();
    toy(&place, false);
    fs::rename(place.path("toy.npz"), place.path("plane.npz")).unwrap();
    toy(&place, true);
    fs::copy(place.path("toy.npz"), place.path("again.npz")).unwrap();
    let call = ["train", "toy.npz", "again.npz", "-o", "m.safetensors"];
    let short = ["--features", "2", "--steps", "3", "--json"];
    let both = place.ballmark(&[&call[..], &short].concat());
    let snapshots = |answer: &Answer| {
        let result: serde_json::Value = serde_json::from_str(&answer.done().stdout).unwrap();
        let count = |part: &str| result[part]["snapshots"].as_u64().unwrap_or(0);
        count("train") + count("validation")
    };
    let alone = train(&place, "alone.safetensors", &short);
    assert_eq!(snapshots(&both), 2 * snapshots(&alone));
    // The baselines learn from the same recordings, named in the same order.
    let localise = [
        "localise",
        "m.safetensors",
        "plane.npz",
        "--trained-on",
        "toy.npz",
        "again.npz",
    ];
    place
        .ballmark(&localise)
        .refused(1, &["plane.npz", "route"]);
    place
        .ballmark(&["train", "toy.npz", "plane.npz", "-o", "n.safetensors"])
        .refused(
            1,
            &[
                "toy.npz",
                "recording 2",
                "a route in the first and not here",
            ],
        );
    place
        .ballmark(&["train", "toy.npz", "none.npz", "-o", "n.safetensors"])
        .refused(1, &["none.npz", "cannot read"]);
    assert!(!place.path("n.safetensors").exists());
}

#[test]
fn the_best_of_several_starts_is_kept() {
    let place = Workplace::new();
    toy(&place, true);
    place.write(
        "c.toml",
        "[train.descent]\nrestarts = 3\nvalidate_every = 5\n",
    );
    let reduction = |more: &[&str]| {
        let call = ["--features", "2", "--steps", "40", "--json"];
        let answer = train(&place, "m.safetensors", &[&call[..], more].concat());
        let result: serde_json::Value = serde_json::from_str(&answer.done().stdout).unwrap();
        result["validation"]["error_reduction"].as_f64().unwrap()
    };
    place.write("one.toml", "[train.descent]\nvalidate_every = 5\n");
    assert!(reduction(&["--config", "c.toml"]) >= reduction(&["--config", "one.toml"]));
    assert_eq!(
        place.files(),
        ["c.toml", "m.safetensors", "one.toml", "toy.csv", "toy.npz"]
    );
}
