//! Whether robots know that they are lost, and kidnapped ones, on the real binary.

use super::support::Workplace;
use serde_json::Value;
use std::path::Path;

fn data() -> String {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz");
    file.to_str().unwrap().to_string()
}

/// A model of the shipped dataset, of which a quarter is kept for testing.
fn trained(place: &Workplace) {
    let data = data();
    let arguments = ["train", &data, "-o", "m.safetensors", "--steps", "20"];
    let more = ["--test-fold", "3", "--features", "2"];
    place.ballmark(&[&arguments[..], &more].concat()).done();
}

/// What a model's file says of itself.
fn header(place: &Workplace) -> Value {
    let bytes = std::fs::read(place.path("m.safetensors")).unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let all: Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
    let metadata = all["__metadata__"].as_object().unwrap();
    let mut texts = metadata.values().filter_map(Value::as_str);
    let header = texts.find_map(|text| {
        let parsed: Value = serde_json::from_str(text).ok()?;
        parsed.get("recipe").is_some().then_some(parsed)
    });
    header.expect("a header")
}

fn localised(place: &Workplace, more: &[&str]) -> String {
    let data = data();
    let arguments = ["localise", "m.safetensors", &data, "--trials", "4"];
    let answer = place.ballmark(&[&arguments[..], more].concat());
    answer.done().stdout.clone()
}

#[test]
fn confidence_and_kidnapping_are_in_table_json_and_files() {
    let place = Workplace::new();
    trained(&place);
    let table = localised(&place, &["--kidnap", "5", "--out", "report"]);
    assert!(
        table.lines().all(|line| line.chars().count() <= 100),
        "{table}"
    );
    for words in [
        "AUROC",
        "risk %",
        "nats",
        "no idea: ",
        "kidnapped ",
        "restart %",
        "after 5 m",
        "harm %",
    ] {
        assert!(table.contains(words), "{words}: {table}");
    }
    for (file, column) in [
        ("confidence.csv", "lost_auroc"),
        ("kidnapping.csv", "harm_found"),
    ] {
        let text = std::fs::read_to_string(place.path("report").join(file)).unwrap();
        assert!(text.lines().next().unwrap().contains(column), "{text}");
        assert!(text.contains("\nlikelihood_field,"), "{text}");
    }

    let json = localised(&place, &["--kidnap", "5", "--json"]);
    let result: Value = serde_json::from_str(&json).unwrap();
    let systems = result["systems"].as_array().unwrap();
    let named = |name: &str| systems.iter().find(|s| s["name"] == name).unwrap();
    for name in ["learned", "likelihood_field", "kernel", "beam_model"] {
        let judged = &named(name)["confidence"];
        let number = |key: &str| {
            judged[key]
                .as_f64()
                .unwrap_or_else(|| panic!("{key}: {judged}"))
        };
        assert!(number("steps") > 20.0);
        assert!((0.0..=1.0).contains(&number("lost")) && (0.0..=1.0).contains(&number("flagged")));
        assert!(number("nats_of_true_place") > 0.0 && number("nats_of_no_idea") > 4.0);
        assert!(judged["score"]["slope"].as_f64() > Some(0.0), "{judged}");
        assert_eq!(judged["threshold"], judged["score"]["threshold"]);
        if name == "learned" {
            // What the robot's model has.
            let header = header(&place);
            assert_eq!(header["lost"], judged["score"], "{header}");
        }
        let auroc = judged["lost_auroc"]["value"].as_f64();
        assert!(auroc.is_none_or(|area| (0.0..=1.0).contains(&area)));
        let kidnapped = &named(name)["kidnapped"];
        let ways = kidnapped["ways"].as_array().unwrap();
        let names: Vec<&str> = ways
            .iter()
            .map(|way| way["way"].as_str().unwrap())
            .collect();
        assert_eq!(names, ["nothing", "floor", "restart"]);
        assert_eq!(kidnapped["after_m"], 5.0);
        assert_eq!(kidnapped["harm"]["against"], "floor");
    }
    // Who has no sensors says so by its belief alone, and is not carried away.
    let odometry = named("odometry");
    assert!(odometry["confidence"]["score"].is_null() && odometry["kidnapped"].is_null());
    assert!(odometry["confidence"]["nats_of_true_place"].is_number());
    // Particles are a whole localiser with a belief; nobody can carry it away.
    let without: Value = serde_json::from_str(&localised(&place, &["--json"])).unwrap();
    assert!(without["kidnapped"].is_null() && without["confidence"].is_object());
    for key in ["error_by_distance", "evidence_scale", "confidence"] {
        assert_eq!(without[key], result[key], "{key}");
    }
    assert!(!localised(&place, &[]).contains("kidnapped"));
}

#[test]
fn a_restart_may_be_switched_on_for_all_trials() {
    let place = Workplace::new();
    trained(&place);
    place.write("c.toml", "[localise.restart]\nmost = 0.5\nfast = 0.9\n");
    let curve = |more: &[&str], name: &str| {
        let json = localised(&place, &[more, &["--json"]].concat());
        let result: Value = serde_json::from_str(&json).unwrap();
        let systems = result["systems"].as_array().unwrap();
        let system = systems.iter().find(|s| s["name"] == name).unwrap();
        system["error_by_distance"].to_string()
    };
    let on = ["--config", "c.toml"];
    assert_ne!(curve(&on, "kernel"), curve(&[], "kernel"));
    assert_eq!(curve(&on, "odometry"), curve(&[], "odometry"));
}

#[test]
fn jumps_that_make_no_sense_are_refused_in_words() {
    let place = Workplace::new();
    trained(&place);
    let data = data();
    let call = |more: &[&str]| {
        let arguments = ["localise", "m.safetensors", &data, "--trials", "4"];
        place.ballmark(&[&arguments[..], more].concat())
    };
    for metres in ["-1", "0", "NaN", "inf"] {
        let kidnap = format!("--kidnap={metres}");
        call(&[&kidnap]).refused(2, &["localise.kidnap_m", "metres above 0"]);
    }
    call(&["--kidnap", "far"]).refused(2, &["--kidnap", "far"]);
    let too_far = call(&["--kidnap", "500"]);
    too_far.refused(
        1,
        &[
            "kidnap_m = 500",
            "the longest trial ends after",
            "before that",
        ],
    );
    let with = |text: &str, words: &[&str]| {
        place.write("c.toml", text);
        call(&["--config", "c.toml"]).refused(2, words);
    };
    with("[localise]\nkidnap_m = -3.0\n", &["localise.kidnap_m"]);
    with(
        "[localise.restart]\nslow = 0.9\nfast = 0.5\n",
        &["restart", "`slow` is 0.9", "slow < fast"],
    );
    with(
        "[localise.restart]\nmost = 2.0\n",
        &["restart", "`most` is 2"],
    );
    with("[localise.restart]\nalpha = 0.1\n", &["alpha"]);
}
