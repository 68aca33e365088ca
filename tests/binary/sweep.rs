//! `ballmark sweep`: what can't run is refused before anything does, every cell is run once, and a table has no unnamed holes.
#![cfg(unix)]

use crate::support::{Answer, Workplace, answer, binary};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    time::{Duration, Instant},
};

/// Trainings of some tenths of a second each.
const QUICK: &str = "\
command = \"train\"
data = \"d.npz\"
[base]
recipe = \"thrun1998\"
[base.train]
uncertainty = \"2m\"
[base.train.descent]
steps = 2
";

/// A place with the shipped corridor as `d.npz`, and a sweep file.
fn place(text: &str) -> Workplace {
    let place = Workplace::new();
    let dataset = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz");
    place.write("d.npz", std::fs::read(dataset).unwrap());
    place.write("s.toml", text);
    place
}

fn with(more: &str) -> String {
    // Keys of the whole file stand before its tables.
    let (whole, tables) = more.split_once("\n\n").unwrap_or((more, ""));
    format!("{whole}\n{QUICK}\n{tables}\n")
}

fn planned(text: &str) -> Workplace {
    let place = place(text);
    place
        .ballmark(&["sweep", "plan", "s.toml", "-o", "s"])
        .done();
    place
}

/// Names of all cells, in the order of the sweep file.
fn cells(place: &Workplace) -> Vec<String> {
    let lines = std::fs::read_to_string(place.path("s/cells.jsonl")).unwrap();
    let cell = |line: &str| serde_json::from_str::<serde_json::Value>(line).unwrap();
    let mut cells: Vec<serde_json::Value> = lines.lines().map(cell).collect();
    cells.sort_by_key(|cell| cell["number"].as_u64());
    let name = |cell: &serde_json::Value| cell["cell"].as_str().unwrap().to_string();
    cells.iter().map(name).collect()
}

/// All results by name.
fn results(place: &Workplace) -> BTreeMap<String, Vec<u8>> {
    let shards = std::fs::read_dir(place.path("s/results"));
    let shards = shards.into_iter().flatten();
    let files = shards.flat_map(|shard| std::fs::read_dir(shard.unwrap().path()).unwrap());
    // What is being written, or was when its process was killed, has another name.
    let whole = |file: &std::io::Result<std::fs::DirEntry>| {
        let name = file.as_ref().unwrap().file_name();
        name.to_string_lossy().ends_with(".json")
    };
    files
        .filter(whole)
        .map(|file| {
            let path = file.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read(path).unwrap())
        })
        .collect()
}

fn status(place: &Workplace) -> serde_json::Value {
    let told = place.ballmark(&["sweep", "status", "s", "--json"]);
    serde_json::from_str(&told.done().stdout).unwrap()
}

/// Attempts that ended, a line each.
fn attempts(place: &Workplace) -> Vec<String> {
    let times = std::fs::read_to_string(place.path("s/times.jsonl")).unwrap_or_default();
    let cell = |line: &str| {
        let line: serde_json::Value = serde_json::from_str(line).unwrap();
        line["cell"].as_str().unwrap().to_string()
    };
    times.lines().map(cell).collect()
}

/// `sweep run` with its own folder for temporary files, on its way.
fn run_begun(place: &Workplace) -> Child {
    std::fs::create_dir_all(place.path("tmp")).unwrap();
    let mut command = Command::new(binary());
    command
        .args(["sweep", "run", "s", "--jobs", "2"])
        .env("TMPDIR", place.path("tmp"))
        .current_dir(place.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command.spawn().unwrap()
}

fn ended(child: Child) -> Answer {
    let output = child.wait_with_output().unwrap();
    Answer {
        status: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

#[track_caller]
fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < Duration::from_secs(60), "never: {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn signal(child: &Child, name: &str) {
    let kill = Command::new("kill")
        .args([name, &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
}

#[test]
fn what_cannot_run_is_refused_with_file_line_and_key() {
    for (text, parts) in [
        (
            "command = \"tarin\"",
            &["s.toml", "line 1", "unknown variant `tarin`"][..],
        ),
        (
            "comand = \"train\"",
            &["s.toml", "line 1", "unknown field `comand`"],
        ),
        (
            "command = \"train\"",
            &["s.toml", "no `data`", "`train` needs one"],
        ),
        (
            "command = \"train\"\ndata = \"none.npz\"",
            &["s.toml", "line 2", "none.npz"],
        ),
        (
            &with("seeds = [1, 2, 1]"),
            &["s.toml", "line 1", "seeds: 1 stands twice"],
        ),
        (&with("seeds = []"), &["s.toml", "line 1", "seeds: none"]),
        (
            &with("seeds = [1]\n\n[keys]\ntrain.features = [2]\ntrain.featurs = [2]"),
            &[
                "s.toml",
                "line 13",
                "train.featurs",
                "unknown field `featurs`",
            ],
        ),
        (
            &with("seeds = [1]\n\n[keys]\ntrain.features = [2,\n  \"many\"]"),
            &["s.toml", "line 13", "train.features = many", "invalid type"],
        ),
        (
            &with("seeds = [1]\n\n[keys]\ntrain.features = [2, 300]"),
            &["s.toml", "line 12", "train.features = 300", "expected 1 to"],
        ),
        (
            &with("seeds = [1]\n\n[keys]\ntrain.features = [2, 2]"),
            &["s.toml", "line 12", "train.features: 2 stands twice"],
        ),
        (
            &with("seeds = [1]\n\n[keys]\nlocalise.trials = [20, 30]"),
            &[
                "s.toml",
                "line 12",
                "two cells are the same",
                "localise.trials = 20",
                "`train` reads",
            ],
        ),
        (
            &with("seeds = [1]\n\n[keys]\nbank = [\"yes\"]"),
            &["s.toml", "line 12", "bank", "expected true or false"],
        ),
        (
            &with(
                "seeds = [1]\n\n[[combination]]\ntrain.split.folds = 3\ntrain.split.test_fold = 7",
            ),
            &["s.toml", "test_fold"],
        ),
        (
            "command = \"train\"\ndata = \"d.npz\"\n[base]\ntrain.featurs = 3",
            &["s.toml", "line 3", "[base]", "unknown field `featurs`"],
        ),
        (
            "command = \"train\"\ndata = \"d.npz\"\nconfig = \"c.toml\"",
            &["c.toml", "line 2", "unknown field `featurs`"],
        ),
        (
            "command = \"reproduce\"\n[keys]\npaper = [\"thrun1998\", \"thrun1999\"]",
            &["s.toml", "line 3", "no paper `thrun1999`"],
        ),
        (
            "command = \"reproduce\"\n[keys]\npaper = [\"thrun1998\"]\ntrain.features = [2]",
            &["s.toml", "line 4", "no option of `reproduce`"],
        ),
        (
            &with("baseline = { train = { features = 3 } }\n\n[keys]\ntrain.features = [2]"),
            &["s.toml", "line 1", "no combination has it"],
        ),
    ] {
        let place = place(text);
        place.write("c.toml", "[train]\nfeaturs = 3\n");
        let told = place.ballmark(&["sweep", "plan", "s.toml", "-o", "s"]);
        told.refused(2, parts);
        assert!(!place.path("s").exists(), "{text}");
    }
}

#[test]
fn a_cell_has_the_same_bytes_wherever_it_ran_and_is_run_once() {
    let place = planned(&with("seeds = [1, 2]\n\n[keys]\ntrain.features = [2, 3]"));
    let told = place.ballmark(&["sweep", "run", "s", "--jobs", "1"]);
    assert_eq!(told.done().stdout, "4 of 4 cells done: 0 before, 4 now\n");
    let whole = results(&place);
    assert_eq!(whole.len(), 4);
    assert_eq!(attempts(&place), cells(&place));
    let again = place.ballmark(&["sweep", "run", "s"]);
    assert_eq!(again.done().stdout, "4 of 4 cells done: 4 before, 0 now\n");
    let cell = &cells(&place)[0];
    let again = place.ballmark(&["sweep", "run-cell", "s", cell]);
    assert!(
        again.done().stderr.contains("nothing is run"),
        "{}",
        again.stderr
    );
    assert_eq!(attempts(&place).len(), 4);

    // Elsewhere: data that lie there under their digests, three threads, another order.
    let there = planned(&with("seeds = [2, 1]\n\n[keys]\ntrain.features = [3, 2]"));
    std::fs::create_dir(there.path("cache")).unwrap();
    let digest = ballmark::storage::sha256(&std::fs::read(there.path("d.npz")).unwrap());
    std::fs::rename(there.path("d.npz"), there.path("cache").join(digest)).unwrap();
    for cell in cells(&there) {
        let mut command = Command::new(binary());
        command
            .args(["sweep", "run-cell", "s", &cell, "--data", "cache"])
            .env("RAYON_NUM_THREADS", "3")
            .current_dir(there.path(""));
        answer(&mut command).done();
    }
    assert_eq!(results(&there), whole);
    let record: serde_json::Value = serde_json::from_slice(whole.values().next().unwrap()).unwrap();
    assert!(record["record"]["train"]["error_reduction"].is_number());
    assert!(!record.to_string().contains("\"timing\""));

    // By hand the command says the same.
    let first = &cells(&place)[0];
    let by_hand = place.ballmark(&[
        "train",
        "d.npz",
        "-o",
        "m.safetensors",
        "--recipe",
        "thrun1998",
        "--uncertainty",
        "2m",
        "--features",
        "2",
        "--steps",
        "2",
        "--seed",
        "1",
        "--json",
    ]);
    let mut by_hand: serde_json::Value = serde_json::from_str(&by_hand.done().stdout).unwrap();
    by_hand.as_object_mut().unwrap().remove("timing");
    let ours: serde_json::Value = serde_json::from_slice(&whole[&format!("{first}.json")]).unwrap();
    assert_eq!(ours["record"], by_hand);
}

#[test]
fn an_extended_sweep_runs_what_is_new_and_another_configuration_has_other_names() {
    let place = planned(&with("seeds = [1]\n\n[keys]\ntrain.features = [2]"));
    place.ballmark(&["sweep", "run", "s"]).done();
    place.write(
        "s.toml",
        with("seeds = [1, 2]\n\n[keys]\ntrain.features = [2]"),
    );
    let told = place.ballmark(&["sweep", "plan", "s.toml", "-o", "s", "--json"]);
    let told: serde_json::Value = serde_json::from_str(&told.done().stdout).unwrap();
    assert_eq!((&told["cells"], &told["done"]), (&2.into(), &1.into()));
    let steps =
        with("seeds = [1, 2]\n\n[keys]\ntrain.features = [2]").replace("steps = 2", "steps = 3");
    place.write("s.toml", steps);
    place
        .ballmark(&["sweep", "plan", "s.toml", "-o", "s"])
        .done();
    let status = status(&place);
    assert_eq!(
        (&status["done"], &status["of_other_plans"]),
        (&0.into(), &1.into())
    );
}

#[test]
fn a_failing_cell_fails_alone_and_is_named_with_its_last_lines() {
    let text =
        with("seeds = [1, 2]").replace("data = \"d.npz\"", "data = [\"d.npz\", \"bad.npz\"]");
    let place = place(&text);
    place.write("bad.npz", "no dataset");
    place
        .ballmark(&["sweep", "plan", "s.toml", "-o", "s"])
        .done();
    let told = place.ballmark(&["sweep", "run", "s", "--jobs", "2"]);
    told.refused(1, &["2 of 4 cells failed, 2 done", "failed/"]);
    let named = told
        .stderr
        .lines()
        .filter(|line| line.starts_with("failed: cell "));
    let named: Vec<&str> = named.collect();
    assert_eq!(named.len(), 2, "{}", told.stderr);
    let is_named = |seed: &str| {
        named
            .iter()
            .any(|line| line.contains(seed) && line.contains("error: "))
    };
    for seed in ["data = bad.npz, seed 1", "data = bad.npz, seed 2"] {
        assert!(is_named(seed), "{}", told.stderr);
    }
    assert_eq!(results(&place).len(), 2);
    let status = status(&place);
    assert_eq!(
        (&status["done"], &status["missing"]),
        (&2.into(), &serde_json::json!([]))
    );
    let why = status["failed"][0]["why"].as_str().unwrap();
    assert!(
        why.starts_with("ended with exit status 1\nlast lines of standard error:\n"),
        "{why}"
    );
    assert!(why.contains("error: ") && why.contains("bad.npz"), "{why}");
    let table = place.ballmark(&["sweep", "status", "s"]);
    assert!(table.done().stdout.contains("failed: "), "{}", table.stdout);
    let cell = status["failed"][0]["cell"].as_str().unwrap();
    let alone = place.ballmark(&["sweep", "run-cell", "s", cell]);
    alone.refused(1, &["ended with exit status 1", "data = bad.npz, seed 1"]);

    // Holes are refused and named; where they are wanted, they are named, too.
    let table = place.ballmark(&["sweep", "collect", "s"]);
    table.refused(
        1,
        &[
            "2 of 4 cells have no result",
            "data = bad.npz, seed 1",
            "--holes",
        ],
    );
    let table = place.ballmark(&["sweep", "collect", "s", "--holes", "-o", "t"]);
    assert_eq!(table.status, 3, "{}", table.stderr);
    assert!(
        table.stdout.contains(
            "2 of 4 cells have no result: data = bad.npz, seed 1; data = bad.npz, seed 2"
        )
    );
    let holes = std::fs::read_to_string(place.path("t/sweep-holes.csv")).unwrap();
    assert_eq!(holes.lines().count(), 3);
}

#[test]
fn a_table_has_means_intervals_and_paired_differences() {
    let place = planned(&with(
        "seeds = [1, 2, 3]\n\n[keys]\ntrain.features = [2, 3]\ntrain.split.test_fold = [0, 1]",
    ));
    place.ballmark(&["sweep", "run", "s"]).done();
    let collect = |more: &[&str]| {
        let mut arguments = vec!["sweep", "collect", "s", "--json"];
        arguments.extend(more);
        let told = place.ballmark(&arguments);
        serde_json::from_str::<serde_json::Value>(&told.done().stdout).unwrap()
    };
    let record = collect(&[
        "--over",
        "test_fold",
        "--metric",
        "train.error_reduction",
        "-o",
        "t",
    ]);
    let rows = record["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!(
        (&rows[0]["is_baseline"], &rows[0]["cells"]),
        (&true.into(), &6.into())
    );

    // Worked out again from the cells.
    let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for cell in record["by_cell"].as_array().unwrap() {
        let features = cell["values"][0].as_str().unwrap().to_string();
        values
            .entry(features)
            .or_default()
            .push(cell["figures"][0].as_f64().unwrap());
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let differences: Vec<f64> = values["3"]
        .iter()
        .zip(&values["2"])
        .map(|(a, b)| a - b)
        .collect();
    let near =
        |a: &serde_json::Value, b: f64| assert!((a.as_f64().unwrap() - b).abs() < 1e-12, "{a} {b}");
    near(&rows[0]["mean"]["mean"], mean(&values["2"]));
    near(&rows[1]["difference"]["mean"], mean(&differences));
    let test = ballmark::score::PairedT::of(&values["3"], &values["2"]).unwrap();
    near(&rows[1]["p"], test.p);
    for (file, part) in [
        ("sweep.txt", "to baseline"),
        ("sweep.md", "| --: |"),
        ("sweep.tex", "\\begin{tabular}"),
        ("sweep.csv", "features,figure,n,mean"),
        ("sweep-figures.csv", "difference_low"),
        (
            "sweep-cells.csv",
            "cell,train.features,train.split.test_fold,seed",
        ),
        ("sweep.json", "\"p_holm\""),
    ] {
        let text = std::fs::read_to_string(place.path("t").join(file)).unwrap();
        assert!(text.contains(part), "{file}: {text}");
    }
    let other = collect(&["--baseline", "features=3"]);
    let is_baseline = |row: &&serde_json::Value| row["is_baseline"] == true;
    let baselines: Vec<_> = other["rows"]
        .as_array()
        .unwrap()
        .iter()
        .filter(is_baseline)
        .collect();
    assert!(!baselines.is_empty() && baselines.iter().all(|row| row["values"][0] == "3"));
    for (arguments, part) in [
        (["--metric", "train.error"], "no number there"),
        (["--baseline", "features=9"], "no cell has that value"),
        (["--baseline", "steps=9"], "cells don't differ in it"),
        (["--over", "fold"], "cells don't differ in it"),
    ] {
        let told = place.ballmark(&[&["sweep", "collect", "s"][..], &arguments].concat());
        told.refused(2, &[part, arguments[1].split('=').next().unwrap()]);
    }
}

#[test]
fn what_was_killed_goes_on_where_it_was() {
    let text = with("seeds = [1, 2, 3, 4, 5, 6]\n\n[keys]\ntrain.features = [2, 3]")
        .replace("steps = 2", "steps = 20");
    let place = planned(&text);
    let mut child = run_begun(&place);
    wait_for("two results", || results(&place).len() >= 2);
    signal(&child, "-KILL");
    child.wait().unwrap();
    let before = results(&place);
    assert!(before.len() < 12, "all done before the end");
    // Nobody works on, and nobody holds a lock.
    wait_for("cells that end with it", || {
        status(&place)["running"] == serde_json::json!([])
    });
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(results(&place).len(), before.len());
    // As a process killed just after its cell's result was written leaves it, and one that ran another plan.
    let done = before.keys().next().unwrap().trim_end_matches(".json");
    for name in [done, &"0".repeat(done.len())] {
        place.write(&format!("s/locks/{name}"), "1 elsewhere");
    }
    let attempted = attempts(&place).len();
    let told = ended(run_begun(&place));
    assert!(
        told.done().stdout.starts_with("12 of 12 cells done"),
        "{}",
        told.stdout
    );
    assert_eq!(attempts(&place).len() - attempted, 12 - before.len());
    let after = results(&place);
    assert!(before.iter().all(|(name, bytes)| after[name] == *bytes));
    let unbroken = planned(&text);
    unbroken.ballmark(&["sweep", "run", "s"]).done();
    assert_eq!(after, results(&unbroken));
    assert_eq!(
        std::fs::read_dir(place.path("tmp")).unwrap().count(),
        0,
        "scratch folders stay"
    );
    let mut left = std::fs::read_dir(place.path("s/results")).unwrap();
    let is_hidden = |file: std::io::Result<std::fs::DirEntry>| {
        file.unwrap().file_name().to_string_lossy().starts_with('.')
    };
    let inside = |shard: std::fs::DirEntry| std::fs::read_dir(shard.path()).unwrap().any(is_hidden);
    assert!(
        !left.any(|shard| inside(shard.unwrap())),
        "half-written files stay"
    );
    assert_eq!(
        std::fs::read_dir(place.path("s/locks")).unwrap().count(),
        0,
        "locks stay"
    );
}

#[test]
fn ctrl_c_ends_what_runs() {
    let text = with("seeds = [1, 2, 3, 4]").replace("steps = 2", "steps = 20000");
    let place = planned(&text);
    let child = run_begun(&place);
    wait_for("cells that run", || {
        status(&place)["running"].as_array().unwrap().len() == 2
    });
    signal(&child, "-INT");
    let told = ended(child);
    told.refused(1, &["cancelled: 0 of 4 cells done", "goes on"]);
    assert_eq!(std::fs::read_dir(place.path("tmp")).unwrap().count(), 0);
    assert_eq!(status(&place)["missing"].as_array().unwrap().len(), 4);
}

/// Processes that work in the place's folder for temporary files.
#[cfg(target_os = "linux")]
fn workers(place: &Workplace) -> usize {
    let folder = place.path("tmp").canonicalize().unwrap();
    let processes = std::fs::read_dir("/proc").unwrap().flatten();
    let works = |process: std::fs::DirEntry| {
        let at = std::fs::read_link(process.path().join("cwd"));
        at.is_ok_and(|at| at.starts_with(&folder))
    };
    processes.map(works).filter(|works| *works).count()
}

#[cfg(target_os = "linux")]
#[test]
fn nobody_works_on_for_a_run_that_is_gone() {
    let text = with("seeds = [1, 2]").replace("steps = 2", "steps = 200000");
    for name in ["-KILL", "-TERM"] {
        let place = planned(&text);
        let mut child = run_begun(&place);
        wait_for("two workers", || workers(&place) == 2);
        let begun = Instant::now();
        signal(&child, name);
        child.wait().unwrap();
        wait_for("no workers", || workers(&place) == 0);
        // At once, and not when they have come to their ends.
        assert!(begun.elapsed() < Duration::from_secs(3), "{name}");
    }
}

#[test]
fn two_runs_at_once_share_the_work() {
    let place = planned(&with(
        "seeds = [1, 2, 3, 4, 5, 6]\n\n[keys]\ntrain.features = [2, 3]",
    ));
    let both = [run_begun(&place), run_begun(&place)];
    let told = both.map(ended);
    for told in &told {
        assert!(
            told.done().stdout.starts_with("12 of 12 cells done"),
            "{}",
            told.stdout
        );
    }
    let (mut ran, mut all) = (attempts(&place), cells(&place));
    ran.sort();
    all.sort();
    assert_eq!(ran, all, "a cell was run twice or never");
}

#[test]
fn data_that_changed_is_refused() {
    let place = planned(&with("seeds = [1]"));
    let mut bytes = std::fs::read(place.path("d.npz")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    place.write("d.npz", bytes);
    let cell = &cells(&place)[0];
    let told = place.ballmark(&["sweep", "run-cell", "s", cell]);
    told.refused(
        1,
        &[
            "d.npz",
            "has changed since the sweep was planned",
            "expected",
        ],
    );
    let told = place.ballmark(&["sweep", "run", "s"]);
    told.refused(1, &["1 of 1 cells failed"]);
    assert!(told.stderr.contains("has changed since"), "{}", told.stderr);
    assert!(results(&place).is_empty());
    // Planned anew it is another cell.
    place
        .ballmark(&["sweep", "plan", "s.toml", "-o", "s"])
        .done();
    assert_ne!(cells(&place)[0], *cell);
}

#[test]
fn a_plan_that_was_changed_or_is_of_another_version_is_refused() {
    let place = planned(&with("seeds = [1]"));
    let cell = &cells(&place)[0];
    let plan = std::fs::read_to_string(place.path("s/plan.json")).unwrap();
    let changed = plan.replace("\"steps\": 2", "\"steps\": 3");
    assert_ne!(plan, changed);
    place.write("s/plan.json", &changed);
    let told = place.ballmark(&["sweep", "run-cell", "s", cell]);
    told.refused(1, &["is not what its name says"]);
    let version = format!("\"version\": \"{}\"", env!("CARGO_PKG_VERSION"));
    place.write(
        "s/plan.json",
        plan.replace(&version, "\"version\": \"0.0.9\""),
    );
    let told = place.ballmark(&["sweep", "run-cell", "s", cell]);
    told.refused(1, &["planned by ballmark 0.0.9", env!("CARGO_PKG_VERSION")]);
    place.write("s/plan.json", "{");
    place
        .ballmark(&["sweep", "run", "s"])
        .refused(1, &["plan.json", "expected what"]);
    for step in ["run", "status", "collect"] {
        place
            .ballmark(&["sweep", step, "."])
            .refused(1, &["no plan.json"]);
    }
    place.write("s/plan.json", &plan);
    let told = place.ballmark(&["sweep", "run-cell", "s", "0123"]);
    told.refused(2, &["no cell `0123`"]);
}

#[test]
fn a_full_disk_costs_the_cell_and_nothing_else() {
    let place = planned(&with("seeds = [1, 2]"));
    let cell = &cells(&place)[0];
    let script = "ulimit -f 1; exec \"$0\" sweep run-cell s \"$1\"";
    let mut command = Command::new("sh");
    command
        .args(["-c", script, binary().to_str().unwrap(), cell])
        .current_dir(place.path(""));
    let told = answer(&mut command);
    told.refused(1, &[cell.as_str()]);
    assert!(results(&place).is_empty());
    place.ballmark(&["sweep", "run", "s"]).done();
    assert_eq!(results(&place).len(), 2);
    assert_eq!(status(&place)["failed"], serde_json::json!([]));
    let left = |folder: PathBuf| std::fs::read_dir(folder).map_or(0, |files| files.count());
    let shard = &cell[..2];
    assert_eq!(
        left(place.path("s/failed").join(shard)),
        0,
        "a failure that is none any more"
    );
}

/// What Slurm would call, task by task: every cell once.
#[test]
fn the_tasks_of_an_array_do_every_cell() {
    let place = planned(&with("seeds = [1, 2, 3]"));
    let script = std::fs::read_to_string(place.path("s/run.slurm")).unwrap();
    assert!(script.contains("#SBATCH --array=1-3\n"), "{script}");
    for task in ["1", "2", "3"] {
        let mut command = Command::new("bash");
        command
            .arg("s/run.slurm")
            .env("SLURM_ARRAY_TASK_ID", task)
            .env("BALLMARK", binary())
            .current_dir(place.path(""));
        answer(&mut command).done();
        assert_eq!(results(&place).len().to_string(), task);
    }
}

#[test]
fn the_other_commands_are_swept_as_well() {
    // A comparison, a key in one of its systems; and the localisation of a model, its configuration beside the sweep file.
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let place = place(
        "command = \"compare\"\nseeds = [1, 2]\n[base]\ndataset = [{ file = \"d.npz\", name = \"corridor\" }]\n\
         system = [{ kind = \"nearest\" }, { kind = \"dead_reckoning\" }]\nprotocol = { mapping = \"split\" }\nstandard = { every_s = 60, permutations = 19, resamples = 20 }\n\
         [keys]\nsystem.nearest.spacing_m = [2, 4]\n",
    );
    place
        .ballmark(&["sweep", "plan", "s.toml", "-o", "s"])
        .done();
    place.ballmark(&["sweep", "run", "s"]).done();
    let table = place.ballmark(&["sweep", "collect", "s"]);
    let table = &table.done().stdout;
    assert!(
        table.contains("standard.nearest.mean_uncertainty_coefficient_corrected"),
        "{table}"
    );

    std::fs::remove_dir_all(place.path("s")).unwrap();
    let model = std::fs::read(root.join("models/corridor-2m.safetensors")).unwrap();
    place.write("m.safetensors", model);
    place.write("c.toml", "[localise]\nresamples = 20\n");
    place.write(
        "s.toml",
        "command = \"localise\"\ndata = \"d.npz\"\nconfig = \"c.toml\"\nseeds = [5]\noptions = { model = \"m.safetensors\" }\n\
         [keys]\nlocalise.trials = [2]\n",
    );
    place
        .ballmark(&["sweep", "plan", "s.toml", "-o", "s"])
        .done();
    place.ballmark(&["sweep", "run", "s"]).done();
    let table = place.ballmark(&[
        "sweep",
        "collect",
        "s",
        "--metric",
        "systems.learned.recall_1m",
        "--metric",
        "error_at_10m_m",
    ]);
    let table = &table.done().stdout;
    assert!(
        table.contains("systems.learned.recall_1m") && table.contains("error_at_10m_m"),
        "{table}"
    );
}
