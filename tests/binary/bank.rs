//! Banks of filters on the real binary: trained, shown, written in both containers, localised with, and refused where they are none.

use super::support::Workplace;
use ballmark::{
    localiser::{LiveConfig, LiveLocaliser},
    model::{Model, ModelBank},
    recording::npz,
};
use std::{fs, path::Path};

/// The shipped dataset.
fn corridor() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz");
    path.to_str().unwrap().to_string()
}

const PRIORS: [&str; 6] = ["1m", "2m", "5m", "10m", "50m", "global"];

/// A folder with `bank.safetensors`, and what training it said.
fn trained(more: &[&str]) -> (Workplace, String) {
    let place = Workplace::new();
    place.write("small.toml", "[train.input]\nhistory_m = []\n");
    let data = corridor();
    let arguments = [
        "train",
        &data,
        "-o",
        "bank.safetensors",
        "--uncertainty",
        "bank",
    ];
    let small = [
        "--features",
        "2",
        "--steps",
        "60",
        "--test-fold",
        "3",
        "--config",
        "small.toml",
    ];
    let answer = place.ballmark(&[&arguments[..], &small[..], more].concat());
    answer.done();
    (place, answer.stdout)
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("one JSON object")
}

#[test]
fn a_set_for_every_prior_goes_into_one_file_and_round_through_both_containers() {
    let (place, said) = trained(&["--json"]);
    let result = json(&said);
    let sets = result["sets"].as_array().expect("sets");
    let names: Vec<&str> = sets
        .iter()
        .map(|set| set["uncertainty"].as_str().unwrap())
        .collect();
    assert_eq!(names, PRIORS);
    assert!(sets[1]["train"]["error_reduction"].as_f64().is_some());
    assert_eq!(place.files(), ["bank.safetensors", "small.toml"]);

    let bank = ModelBank::read(&place.path("bank.safetensors")).unwrap();
    assert_eq!(bank.sets().len(), 6);
    assert!(bank.run().iter().max() > Some(&0));
    let convert = |from: &str, to: &str| place.ballmark(&["export", from, "-o", to]);
    assert!(
        convert("bank.safetensors", "bank.npz")
            .done()
            .stdout
            .contains("uncertainty 50m")
    );
    convert("bank.npz", "back.safetensors").done();
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(bytes("bank.safetensors") == bytes("back.safetensors"));

    // What a single set expects says what it was given.
    let fault = Model::read(&place.path("bank.safetensors")).unwrap_err();
    assert!(fault.to_string().contains("a bank of 6 sets"), "{fault}");

    let data = corridor();
    place
        .ballmark(&[
            "features", "bank.npz", &data, "-o", "f.csv", "--report", "page",
        ])
        .done();
    let page = fs::read_to_string(place.path("page/index.html")).unwrap();
    assert!(page.contains("A bank of 6 sets of filters"));
    let heading = ">Filters for uncertainty 10m</h2>";
    assert!(page.contains(heading), "{heading}");
    assert!(!place.path("f.svg").exists());
    let table = fs::read_to_string(place.path("f.csv")).unwrap();
    let header = table.lines().next().unwrap();
    assert!(
        header.starts_with("index,x_m,y_m,heading_rad,1m.f1,1m.f2,2m.f1"),
        "{header}"
    );
    assert!(header.ends_with("global.f1,global.f2"), "{header}");
}

#[test]
fn a_bank_localises_beside_all_its_sets_and_each_alone() {
    let (place, said) = trained(&[]);
    assert!(
        said.contains("global, validation") && said.contains("a bank of 6 sets"),
        "{said}"
    );
    let data = corridor();
    place.write(
        "c.toml",
        "[localise]\ntrials = 2\nshortest_m = 3\nlongest_m = 6\n",
    );
    let localise = |more: &[&str]| {
        let arguments = ["localise", "bank.safetensors", &data, "--config", "c.toml"];
        place.ballmark(&[&arguments[..], more].concat())
    };
    let table = localise(&["--out", "o"]);
    table.done();
    let table = table.stdout;
    assert!(table.contains("bank, 2 of 6 sets + map"), "{table}");
    assert!(
        table.lines().all(|line| line.chars().count() <= 100),
        "{table}"
    );
    let figures = fs::read_to_string(place.path("o/localisation.csv")).unwrap();
    for name in [
        "bank",
        "bank_all_sets",
        "learned_2m",
        "learned_global",
        "kernel",
    ] {
        assert!(
            figures
                .lines()
                .any(|row| row.starts_with(&format!("{name},"))),
            "{name}: {figures}"
        );
    }

    let twice = ["localise", "bank.safetensors", "bank.safetensors", &data];
    place
        .ballmark(&twice)
        .refused(2, &["a bank of filters beside other models"]);
    place.write("c.toml", "[localise.bank]\nsets = 0\n");
    localise(&[]).refused(2, &["c.toml", "bank.sets = 0", "at least 1"]);
    place.write("c.toml", "[localise.bank]\nby = \"luck\"\n");
    localise(&[]).refused(2, &["luck", "most_information"]);
}

#[test]
fn a_live_robot_uses_a_bank() {
    let (place, _) = trained(&[]);
    let bank = ModelBank::read(&place.path("bank.safetensors")).unwrap();
    let run = npz::read(Path::new(&corridor())).unwrap();
    let mut robot = LiveLocaliser::with_bank(&bank, &LiveConfig::default()).unwrap();
    let entropy_before = robot.entropy();
    for k in 0..40 {
        robot.observe(&run.observation(k)).unwrap();
    }
    assert!(robot.entropy() < entropy_before - 0.5);
}

#[test]
fn damaged_banks_and_wrong_words_are_refused() {
    let (place, _) = trained(&[]);
    let data = corridor();
    let whole = fs::read(place.path("bank.safetensors")).unwrap();
    let changed = |pairs: &[(&str, &str)]| {
        let mut bytes = whole.clone();
        for (from, to) in pairs {
            assert_eq!(from.len(), to.len());
            let text = whole
                .windows(from.len())
                .position(|w| w == from.as_bytes())
                .expect(from);
            bytes[text..text + to.len()].copy_from_slice(to.as_bytes());
        }
        place.write("bad.safetensors", bytes);
        place.ballmark(&["localise", "bad.safetensors", &data])
    };
    // Damaged, and as another program wrote it, without a digest.
    let (other_set, unsealed) = (
        ("set.5m.filter.", "set.7m.filter."),
        ("\\\"sha256\\\"", "\\\"sha_no\\\""),
    );
    changed(&[other_set]).refused(1, &["bad.safetensors: damaged", "sha256"]);
    changed(&[other_set, unsealed]).refused(1, &["bad.safetensors", "filter."]);
    changed(&[("\"map.run\"", "\"map.ran\""), unsealed])
        .refused(1, &["bad.safetensors", "map.ran", "of no set"]);
    place.write("half.safetensors", &whole[..whole.len() / 2]);
    place
        .ballmark(&["localise", "half.safetensors", &data])
        .refused(1, &["half.safetensors"]);
    let wrong = [
        "train",
        &data,
        "-o",
        "w.safetensors",
        "--uncertainty",
        "banks",
    ];
    place.ballmark(&wrong).refused(2, &["banks", "or `bank`"]);
}
