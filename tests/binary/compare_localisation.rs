//! `[localisation]` of `ballmark compare`: the trials of `ballmark localise` for any systems.

use crate::support::{Workplace, answer, binary};
use serde_json::Value;
use std::process::Command;

/// A hall that a Nomad goes round several times, recorded as `hall.npz`.
fn workplace() -> Workplace {
    let place = Workplace::new();
    place.write(
        "hall.toml",
        "name = \"hall\"\n\
         [[wall]]\npoints = [[0, 0], [8, 0], [8, 5], [4, 5], [4, 4], [0, 4]]\nclosed = true\n\
         door = [{ at_m = 2.0, width_m = 0.9 }]\n\
         [robot]\nkind = \"nomad200\"\nturret_north = true\n\
         [path]\nclosed = true\nlaps = 7\ncorners = [[1, 1], [7, 1], [7, 3], [1, 3]]\n\
         [record]\nevery_s = 2.0\n",
    );
    place
        .ballmark(&["simulate", "hall.toml", "-o", "hall.npz"])
        .done();
    place
}

const TRAIN: &str = "features = 3\nuncertainty = 'global'\ndescent = { steps = 20 }\n";

fn record(stdout: &str) -> Value {
    serde_json::from_str(stdout).unwrap()
}

/// A system's figures, but for what it is called.
fn figures(systems: &Value, name: &str) -> Value {
    let systems = systems.as_array().unwrap();
    let mut found = systems.iter().filter(|system| system["name"] == name);
    let mut system = found.next().unwrap_or_else(|| panic!("no {name}")).clone();
    system.as_object_mut().unwrap().remove("title");
    system
}

#[test]
fn localise_is_the_section_localisation_with_a_line_up_of_its_own() {
    let place = workplace();
    place.write(
        "train.toml",
        format!("[train]\n{TRAIN}split = {{ test_fold = 0 }}\n[localise]\ntrials = 6\nresamples = 20\nseed = 4\n"),
    );
    let train = [
        "train",
        "hall.npz",
        "-o",
        "m.safetensors",
        "--config",
        "train.toml",
    ];
    place.ballmark(&train).done();
    let localise = [
        "localise",
        "m.safetensors",
        "hall.npz",
        "--config",
        "train.toml",
        "--json",
    ];
    let localise = place.ballmark(&localise);
    localise.done();

    let system =
        |name: &str, rest: &str| format!("[[system]]\nkind = 'bayes'\nname = '{name}'\n{rest}\n");
    let model = "model = 'm.safetensors'";
    place.write(
        "c.toml",
        ["seed = 4\n[[dataset]]\nfile = 'hall.npz'\n".to_string()]
            .into_iter()
            .chain([
                system("learned", model),
                system(
                    "learned_bits",
                    &format!("landmarks = 'learned_bits'\n{model}"),
                ),
                system("likelihood_field", "landmarks = 'likelihood_field'"),
                system(
                    "learned+likelihood_field",
                    &format!("landmarks = ['learned', 'likelihood_field']\n{model}"),
                ),
                system("signal_field", "landmarks = 'signal_field'"),
                system("kernel", "landmarks = 'kernel'"),
                system(
                    "random_bits_64",
                    "landmarks = { kind = 'random_bits', bits = 64 }",
                ),
                system("odometry", "landmarks = []"),
                // Trained here, on the same parts: the same model again.
                system(
                    "trained",
                    &format!("train = {{ {} }}", TRAIN.trim().replace('\n', ", ")),
                ),
                "[protocol]\nmapping = 'split'\nsplit = { test_fold = 0 }\n\
                 [localisation]\ntrials = 6\nresamples = 20\n"
                    .to_string(),
            ])
            .collect::<String>(),
    );
    let compare = place.ballmark(&["compare", "c.toml", "--json"]);
    compare.done();

    let (localised, compared) = (record(&localise.stdout), record(&compare.stdout));
    let compared = &compared["localisation"]["records"][0]["done"];
    assert_eq!(localised["trials"], compared["trials"]);
    for name in [
        "learned",
        "learned_bits",
        "likelihood_field",
        "learned+likelihood_field",
        "signal_field",
        "kernel",
        "random_bits_64",
        "odometry",
    ] {
        assert_eq!(
            figures(&localised["systems"], name),
            figures(&compared["results"], name),
            "{name}"
        );
    }
    let mut trained = figures(&compared["results"], "trained");
    trained["name"] = "learned".into();
    assert_eq!(trained, figures(&compared["results"], "learned"));
}

#[test]
fn any_system_plays_and_who_cannot_is_named_in_its_cell() {
    let place = workplace();
    place.write(
        "c.toml",
        "[[dataset]]\nfile = 'hall.npz'\n\
         [[system]]\nkind = 'monte_carlo'\nparticles = 300\nleast_particles = 50\n\
         [[system]]\nkind = 'nearest'\n\
         [[system]]\nkind = 'dead_reckoning'\n\
         [[system]]\nkind = 'bayes'\nname = 'responses'\n\
         landmarks = [{ kind = 'recogniser', recogniser = { kind = 'rce' } }, 'compass']\n\
         [[system]]\nkind = 'bayes'\nname = 'views of the query'\nlandmarks = { kind = 'kernel_views', views = 2, moved = 'query' }\n\
         [[system]]\nkind = 'bayes'\nname = 'lights'\nlandmarks = 'ceiling_light'\n\
         [protocol]\nmapping = 'split'\n\
         [localisation]\ntrials = 4\nresamples = 20\n",
    );
    let play = |threads: &str, out: &str| {
        let mut command = Command::new(binary());
        command
            .args(["compare", "c.toml", "--out", out])
            .env("RAYON_NUM_THREADS", threads)
            .current_dir(place.path(""));
        answer(&mut command)
    };
    let one = play("1", "one");
    assert_eq!(one.status, 3, "{}", one.stderr);
    assert!(
        one.stderr.contains("[localisation] lights on hall") && one.stderr.contains("camera"),
        "{}",
        one.stderr
    );
    for words in [
        "Localisation on unseen runs: hall",
        "views of the query",
        "lights: left out",
    ] {
        assert!(one.stdout.contains(words), "{words}: {}", one.stdout);
    }
    assert_eq!(play("2", "two").stdout, one.stdout);
    let read = |out: &str, file: &str| {
        std::fs::read_to_string(place.path(&format!("{out}/{file}"))).unwrap()
    };
    for file in [
        "localisation.csv",
        "localisation-figures.csv",
        "error-by-distance.csv",
        "error-by-distance.svg",
        "tracking-error.svg",
        "risk-coverage.csv",
        "risk-coverage.svg",
        "paired-trials.csv",
        "player.json",
        "index.html",
    ] {
        assert_eq!(read("one", file), read("two", file), "{file}");
    }
    // Particles: their evidence is tuned, their answers have a heading; and all have the time of a step.
    let written: Value = serde_json::from_str(&read("one", "comparison.json")).unwrap();
    let results = &written["localisation"]["records"][0]["done"]["results"];
    let particles = figures(results, "monte_carlo");
    for key in ["evidence_scale", "heading_within_5deg"] {
        assert!(particles[key].is_number(), "{key}: {particles}");
    }
    let step_ms = &written["timing"]["localisation"][0]["step_ms"];
    for name in ["monte_carlo", "nearest", "dead_reckoning", "responses"] {
        let ms = step_ms[name].as_f64();
        assert!(ms.is_some_and(|ms| ms > 0.0), "{name}: {step_ms}");
    }
    // The same tables from the record alone.
    place.ballmark(&[
        "compare",
        "--redraw",
        "one/comparison.json",
        "--out",
        "again",
    ]);
    for file in ["localisation.csv", "error-by-distance.svg", "index.html"] {
        assert_eq!(read("one", file), read("again", file), "{file}");
    }
    super::page::stands_alone(
        &place.path("again/index.html"),
        &["views of the query", "monte_carlo", "class=\"player\""],
    );
    // Beliefs that are another comparison's are refused by the file that they are in.
    place.write("one/player.json", "[null, null]");
    place
        .ballmark(&["compare", "--redraw", "one/comparison.json"])
        .refused(1, &["player.json", "beliefs of 2 datasets"]);
}

#[test]
fn people_stand_before_what_is_asked_and_not_before_what_is_learned() {
    let place = workplace();
    let play = |people: &str| {
        place.write(
            "c.toml",
            format!(
                "[[dataset]]\nfile = 'hall.npz'\n\
                 [[system]]\nkind = 'bayes'\nname = 'map'\nlandmarks = 'likelihood_field'\n\
                 [protocol]\nmapping = 'split'\nsplit = {{ test_fold = 0 }}\n\
                 [localisation]\ntrials = 4\nresamples = 20\n{people}\n"
            ),
        );
        place.ballmark(&["compare", "c.toml", "--json"])
    };
    let result = |people: &str| {
        let played = play(people);
        let record = record(&played.done().stdout);
        let played = &record["localisation"]["records"][0]["done"];
        let share = played["people"].as_f64().unwrap();
        (figures(&played["results"], "map"), share)
    };
    let ((empty, nobody), (crowded, share)) = (result(""), result("people = 0.6"));
    assert_eq!((nobody, share), (0.0, 0.6));
    assert_eq!((empty.clone(), nobody), result("people = 0.0"));
    assert_eq!(empty["evidence_scale"], crowded["evidence_scale"]);
    let recall = |figures: &Value| figures["recall_1m"].as_f64().unwrap();
    assert!(recall(&crowded) < recall(&empty), "{empty} {crowded}");
    play("people = 1.5").refused(2, &["localisation.people", "0 to 1"]);
}

#[test]
fn what_landmarks_may_not_be_is_refused_with_its_line() {
    let place = Workplace::new();
    let refused = |system: &str, parts: &[&str]| {
        let text = format!(
            "[[dataset]]\nfile = 'hall.npz'\n[[system]]\nkind = 'bayes'\n{system}\n[localisation]\ntrials = 4\n"
        );
        place.write("c.toml", text);
        place.ballmark(&["compare", "c.toml"]).refused(2, parts);
    };
    refused(
        "landmarks = 'gps'",
        &["c.toml", "line 5", "no sensor model `gps`", "signal_field"],
    );
    refused(
        "landmarks = 3",
        &["line 5", "3: expected the name of a sensor model"],
    );
    refused("landmarks = [{ bits = 3 }]", &["line 5", "no `kind`"]);
    refused(
        "landmarks = { kind = 'random_bits', bits = 0 }",
        &["random_bits.bits = 0", "expected 1 to"],
    );
    refused(
        "landmarks = { kind = 'random_bits', bit = 3 }",
        &["line 5", "unknown field `bit`", "bits"],
    );
    refused("grid = 3", &["line 5", "unknown field `grid`", "landmarks"]);
    place.write(
        "c.toml",
        "[[dataset]]\nfile = 'hall.npz'\n[[system]]\nkind = 'bayes'\ntrain = { split = { unit = '5m' } }\n\
         [protocol]\nmapping = 'split'\n[localisation]\n",
    );
    place
        .ballmark(&["compare", "c.toml"])
        .refused(2, &["`bayes`: train.split", "[protocol.split]"]);
    let no_trials = "[[dataset]]\nfile = 'hall.npz'\n[[system]]\nkind = 'nearest'\n[localisation]\ntrials = 0\n";
    place.write("c.toml", no_trials);
    place
        .ballmark(&["compare", "c.toml"])
        .refused(2, &["localisation.trials"]);
}
