//! `ballmark compare`: every system on every dataset.

use crate::support::{Answer, Workplace, answer, binary};
use serde_json::Value;
use std::{collections::BTreeMap, fs, path::Path, process::Command};

/// A hall that a Nomad goes round three times, in a few hundred snapshots.
fn hall(width_m: f64, laps: f64) -> String {
    format!(
        "name = \"hall\"\n\
         [[wall]]\npoints = [[0, 0], [{width_m}, 0], [{width_m}, 5], [4, 5], [4, 4], [0, 4]]\nclosed = true\n\
         door = [{{ at_m = 2.0, width_m = 0.9 }}]\n\
         [robot]\nkind = \"nomad200\"\nturret_north = true\n\
         [path]\nclosed = true\nlaps = {laps}\ncorners = [[1, 1], [{0}, 1], [{0}, 3], [1, 3]]\n\
         [record]\nevery_s = 2.0\n",
        width_m - 1.0
    )
}

/// Two halls, three systems, every question but that about landmarks, all of it short.
const COMPARISON: &str = r#"
seed = 3

[[dataset]]
name = 'A, the "long" | one_1'
world = "long.toml"

[[dataset]]
name = "B"
world = "short.toml"
seed = 5

[[system]]
kind = "dead_reckoning"

[[system]]
kind = "nearest"
name = 'near, "er" & 50 % | x_1'
spacing_m = 1.0

[[system]]
kind = "rce"

[standard]
trial_m = 6.0
every_s = 20.0
permutations = 9
resamples = 20

[recognition]
bin_m = 2.0
permutations = 9
resamples = 20

[error_reduction]
priors = ["2m", "global"]
"#;

fn workplace() -> Workplace {
    let place = Workplace::new();
    place.write("long.toml", hall(10.0, 3.6));
    place.write("short.toml", hall(8.0, 3.6));
    place.write("c.toml", COMPARISON);
    place
}

/// All files under a folder, by their names from there.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        match path.is_dir() {
            true => found.extend(
                files(&path)
                    .into_iter()
                    .map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)),
            ),
            false => {
                found.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    found
}

/// What must be the same from call to call: all but what was timed, which the page has as well where there are costs.
fn untimed(mut all: BTreeMap<String, Vec<u8>>) -> BTreeMap<String, Vec<u8>> {
    let has_costs = all.contains_key("cost.csv");
    all.retain(|name, _| !name.starts_with("cost.") && !name.starts_with("quality-against-cost."));
    all.retain(|name, _| !(has_costs && name == "index.html"));
    if let Some(bytes) = all.get_mut("comparison.json") {
        *bytes = without_timing(std::str::from_utf8(bytes).unwrap())
            .to_string()
            .into_bytes();
    }
    all
}

fn without_timing(json: &str) -> Value {
    let mut value: Value = serde_json::from_str(json).unwrap();
    let timing = value.as_object_mut().unwrap().remove("timing").unwrap();
    assert!(timing["seconds"].as_f64().unwrap() > 0.0);
    value
}

fn with_threads(place: &Workplace, threads: &str, out: &str) -> Answer {
    let mut command = Command::new(binary());
    command
        .args(["compare", "c.toml", "--out", out])
        .env("RAYON_NUM_THREADS", threads)
        .current_dir(place.path(""));
    answer(&mut command)
}

#[test]
fn a_comparison_fills_every_table_and_is_the_same_with_any_number_of_threads() {
    let place = workplace();
    let one = with_threads(&place, "1", "one");
    one.done();
    for words in [
        "dead_reckoning",
        "near, \"er\" & 50 % | x_1",
        "A, the \"long\" | one_1",
        "Standard experiment",
        "Recognition",
        "Error reduction against prior uncertainty",
        "seed 3, ballmark ",
        "truth: the recordings' poses",
    ] {
        assert!(
            one.stdout.contains(words),
            "`{words}` is missing in:\n{}",
            one.stdout
        );
    }
    assert!(one.stderr.contains("comparing: "), "{}", one.stderr);
    let made = files(&place.path("one"));
    for name in [
        "comparison.json",
        "config.json",
        "standard.csv",
        "standard-matrix.md",
        "standard-answers.tex",
        "standard-curves.csv",
        "standard-B.svg",
        "standard-A__the__long____one_1.svg",
        "recognition.tex",
        "recognition-matrix.csv",
        "recognition-tests.md",
        "recognition-pairs.csv",
        "cost.csv",
        "quality-against-cost.svg",
        "error-reduction.csv",
        "error-reduction-B.svg",
    ] {
        assert!(made.contains_key(name), "no {name} among {:?}", made.keys());
    }
    let text = |name: &str| String::from_utf8(made[name].clone()).unwrap();
    let words = [
        "near, &#34;er&#34; &#38; 50 % | x_1",
        "dead_reckoning",
        "Quality against cost",
        "Error reduction against prior uncertainty",
    ];
    super::page::stands_alone(&place.path("one/index.html"), &words);

    // Every cell is there, whatever its system and dataset are called.
    let record: Value = serde_json::from_str(&text("comparison.json")).unwrap();
    for (section, systems) in [("standard", 3), ("recognition", 2), ("error_reduction", 2)] {
        let cells = record[section]["cells"].as_array().unwrap();
        assert_eq!(cells.len(), systems, "{section}");
        for row in cells {
            let row = row.as_array().unwrap();
            assert!(
                row.len() == 2 && row.iter().all(|cell| cell["done"].is_object()),
                "{row:?}"
            );
        }
    }
    let mut csv = csv::Reader::from_reader(&made["standard.csv"][..]);
    let rows: Vec<csv::StringRecord> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 6);
    assert_eq!(
        [&rows[1][0], &rows[1][1]],
        ["A, the \"long\" | one_1", "near, \"er\" & 50 % | x_1"]
    );
    let markdown = text("standard.md");
    assert!(
        markdown.contains("| A, the \"long\" \\| one_1 | near, \"er\" & 50 % \\| x_1 |"),
        "{markdown}"
    );
    let latex = text("standard.tex");
    assert!(
        latex.contains("near, \\char34{}er\\char34{} \\& 50 \\% $|$ x\\_1 &"),
        "{latex}"
    );
    assert!(
        text("standard-curves.csv").lines().count() == 1 + 6 * 61,
        "{}",
        text("standard-curves.csv")
    );

    let resolved: Value = serde_json::from_str(&text("config.json")).unwrap();
    assert_eq!(resolved["seed"], 3);
    assert_eq!(resolved["compare"]["standard"]["bin_m"], 2.0);
    assert_eq!(resolved["compare"]["system"][1]["spacing_m"], 1.0);
    let sums = resolved["dataset_sha256"].as_object().unwrap();
    assert!(
        sums.len() == 2 && sums.values().all(|sum| sum.as_str().unwrap().len() == 64),
        "{sums:?}"
    );

    with_threads(&place, "4", "four").done();
    let (one, four) = (untimed(made), untimed(files(&place.path("four"))));
    assert_eq!(
        one.keys().collect::<Vec<_>>(),
        four.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &one {
        assert!(*bytes == four[name], "{name} differs");
    }
}

#[test]
fn tables_and_pictures_are_drawn_again_without_the_data() {
    let place = workplace();
    let first = place.ballmark(&["compare", "c.toml", "--toy", "--out", "out"]);
    first.done();
    for world in ["long.toml", "short.toml", "c.toml"] {
        fs::remove_file(place.path(world)).unwrap();
    }
    let again = place.ballmark(&[
        "compare",
        "--redraw",
        "out/comparison.json",
        "--out",
        "again",
    ]);
    assert_eq!(again.done().stdout, first.stdout);
    let (mut made, redrawn) = (files(&place.path("out")), files(&place.path("again")));
    made.retain(|name, _| name != "comparison.json" && name != "config.json");
    assert_eq!(
        made.keys().collect::<Vec<_>>(),
        redrawn.keys().collect::<Vec<_>>()
    );
    assert!(made == redrawn);

    place.write("bent.json", "{\"seed\": 1}");
    let bent = place.ballmark(&["compare", "--redraw", "bent.json"]);
    bent.refused(1, &["bent.json", "expected `comparison.json`"]);
    // A record whose parts don't fit together is refused by the section before anything is written.
    let record = fs::read_to_string(place.path("out/comparison.json")).unwrap();
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    for (section, bend) in [
        (
            "[standard]: system 99",
            (|r| r["standard"]["systems"][0] = 99.into()) as fn(&mut serde_json::Value),
        ),
        ("[recognition]: 0 rows", |r| {
            r["recognition"]["cells"] = serde_json::json!([])
        }),
        ("[error_reduction]: a row of 0", |r| {
            r["error_reduction"]["cells"][0] = serde_json::json!([])
        }),
        ("[error_reduction]: a point for", |r| {
            r["error_reduction"]["config"]["priors"] = serde_json::json!([])
        }),
    ] {
        let mut bent = record.clone();
        bend(&mut bent);
        place.write("bent.json", bent.to_string());
        let answer = place.ballmark(&["compare", "--redraw", "bent.json", "--out", "bent"]);
        answer.refused(1, &["bent.json", section]);
        assert_eq!(files(&place.path("bent")).len(), 0, "{section}");
    }
    place
        .ballmark(&["compare", "c.toml", "--redraw", "out/comparison.json"])
        .stderr
        .contains("cannot be used with")
        .then_some(())
        .expect("one or the other");
}

#[test]
fn json_is_one_object_and_nothing_else() {
    let place = workplace();
    let answer = place.ballmark(&["compare", "c.toml", "--toy", "--json", "--out", "out"]);
    let written = fs::read_to_string(place.path("out/comparison.json")).unwrap();
    assert_eq!(
        without_timing(&answer.done().stdout),
        without_timing(&written)
    );
    assert_eq!(answer.stdout.lines().count(), 1);
}

#[test]
fn a_system_that_fails_is_named_in_its_cell_and_the_others_go_on() {
    let place = workplace();
    let mut text = COMPARISON.to_string();
    text.push_str("[[system]]\nkind = 'ball'\nmodel = 'lost.safetensors'\n");
    place.write("c.toml", text);
    let answer = place.ballmark(&["compare", "c.toml", "--toy", "--out", "out"]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    assert!(answer.stdout.contains("failed [1]"), "{}", answer.stdout);
    assert!(answer.stdout.contains("[1] ball: "), "{}", answer.stdout);
    // One reason, one line, however many sections it spoils.
    let line = "failed: [standard] [recognition] [error_reduction] ball on B: ball: ";
    assert_eq!(answer.stderr.matches(line).count(), 1, "{}", answer.stderr);
    assert!(
        answer.stdout.contains("lost.safetensors"),
        "{}",
        answer.stdout
    );
    let record: Value =
        serde_json::from_slice(&fs::read(place.path("out/comparison.json")).unwrap()).unwrap();
    let cells = record["standard"]["cells"].as_array().unwrap();
    assert!(cells[0][0]["done"].is_object() && cells[3][0]["failed"]["why"].is_string());
    let csv = fs::read_to_string(place.path("out/standard-matrix.csv")).unwrap();
    assert!(csv.contains("ball,failed,failed,\n"), "{csv}");
}

#[test]
fn a_dataset_without_laps_fails_in_its_column() {
    let place = workplace();
    place.write("short.toml", hall(8.0, 0.9));
    let answer = place.ballmark(&["compare", "c.toml", "--toy"]);
    assert_eq!(answer.status, 3, "{}", answer.stderr);
    assert!(answer.stdout.contains("[1] B: "), "{}", answer.stdout);
    let lines = answer.stderr.lines();
    let failed: Vec<&str> = lines.filter(|line| line.contains("failed: ")).collect();
    assert_eq!(
        failed.len(),
        1,
        "one fault of a dataset, one line: {failed:?}"
    );
    assert!(failed[0].contains(" on B: B: "), "{failed:?}");
    assert!(
        place.files() == ["c.toml", "long.toml", "short.toml"],
        "{:?}",
        place.files()
    );
}

#[test]
fn where_nothing_can_be_compared_one_line_says_why() {
    for (key, value, parts) in [
        ("laps = 3.6", "laps = 0.9", vec!["lap"]),
        ("trial_m = 6.0", "trial_m = 500.0", vec!["trial"]),
        ("bin_m = 2.0", "bin_m = 90.0", vec!["bin"]),
    ] {
        let place = workplace();
        let world = hall(8.0, 3.6).replace(key, value);
        place.write("short.toml", world);
        let head = "[[dataset]]\nworld = 'short.toml'\n[[system]]\nkind = 'nearest'\n";
        let bin = if key == "bin_m = 2.0" {
            value
        } else {
            "bin_m = 2.0"
        };
        let trial = if key == "trial_m = 6.0" {
            value
        } else {
            "trial_m = 6.0"
        };
        place.write("c.toml", format!("{head}[standard]\n{bin}\n{trial}\n"));
        let mut expected = vec!["nothing could be compared"];
        expected.extend(parts);
        place
            .ballmark(&["compare", "c.toml", "--toy", "--out", "out"])
            .refused(1, &expected);
        assert!(files(&place.path("out")).is_empty());
    }
}

#[test]
fn wrong_calls_are_refused_before_the_work() {
    let place = workplace();
    let refused = |from: &str, to: &str, status: i32, parts: &[&str]| {
        assert!(COMPARISON.contains(from), "{from}");
        place.write("wrong.toml", COMPARISON.replacen(from, to, 1));
        place
            .ballmark(&["compare", "wrong.toml"])
            .refused(status, parts);
    };
    refused(
        "spacing_m",
        "spacing",
        2,
        &["wrong.toml: line 19: [[system]]: nearest", "spacing"],
    );
    refused(
        "\"rce\"",
        "\"gps\"",
        2,
        &["line 22", "no kind `gps`", "dead_reckoning", "door"],
    );
    refused("[recognition]", "[recognising]", 2, &["recognising"]);
    refused(
        "kind = \"rce\"",
        "kind = \"dead_reckoning\"",
        2,
        &["two [[system]] named `dead_reckoning`"],
    );
    refused("[[system]]", "[system]", 2, &["wrong.toml"]);
    refused(
        "world = \"short.toml\"",
        "world = \"none.toml\"",
        1,
        &["none.toml", "cannot read"],
    );
    refused(
        "world = \"short.toml\"\nseed = 5",
        "file = \"none.npz\"",
        1,
        &["none.npz", "cannot read"],
    );
    refused(
        "world = \"short.toml\"\nseed = 5",
        "file = \"c.toml\"",
        1,
        &["c.toml"],
    );
    refused(
        "world = \"short.toml\"",
        "world = \"c.toml\"",
        2,
        &["c.toml"],
    );
    refused("bin_m = 2.0", "bin_m = -2.0", 2, &["wrong.toml", "bin_m"]);
    refused(
        "priors = [\"2m\", \"global\"]",
        "priors = [\"2 miles\"]",
        2,
        &["2 miles"],
    );

    place.write("empty.toml", "");
    place
        .ballmark(&["compare", "empty.toml"])
        .refused(2, &["empty.toml", "0 [[dataset]]"]);
    place
        .ballmark(&["compare", "absent.toml"])
        .refused(1, &["absent.toml", "cannot read"]);
    place.write("taken", "");
    place
        .ballmark(&["compare", "c.toml", "--out", "taken"])
        .refused(1, &["taken"]);
    assert_eq!(place.ballmark(&["compare"]).status, 2);
}

#[test]
fn filters_are_trained_on_the_mapping_part_once_a_recipe() {
    let place = workplace();
    let train = "[system.train]\nfeatures = 2\ndescent = { steps = 3 }\n";
    place.write(
        "c.toml",
        format!(
            "[[dataset]]\nname = 'B'\nworld = 'short.toml'\n[[system]]\nkind = 'ball'\n{train}\
             [[system]]\nkind = 'bayes'\n{train}[standard]\ntrial_m = 6.0\n\
             [recognition]\nbin_m = 2.0\nresponses = 3\n[error_reduction]\npriors = ['2m']\n"
        ),
    );
    let answer = place.ballmark(&["compare", "c.toml", "--toy", "--out", "out"]);
    answer.done();
    let made = files(&place.path("out"));
    let models: Vec<&String> = made
        .keys()
        .filter(|name| name.starts_with("models/"))
        .collect();
    assert_eq!(models, ["models/B-ball.safetensors"]);
    // Where the model lay is not in the record: another call trains it elsewhere.
    let record: Value = serde_json::from_slice(&made["comparison.json"]).unwrap();
    let recognised = &record["recognition"]["cells"][0][0]["done"];
    assert_eq!(recognised["config"]["model"], "", "{recognised}");
}
