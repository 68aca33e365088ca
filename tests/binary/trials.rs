//! `ballmark trials`, and systems of other people in `ballmark compare`.

use crate::support::Workplace;
use serde_json::Value;
use std::{fs, path::Path};

/// Six short trials on every other run.
const CONFIG: &str = "seed = 3\n[protocol]\nmapping = 'split'\n[localisation]\ntrials = 6\nlongest_m = 8.0\nresamples = 20\n";

fn corridor() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("datasets/corridor-small.npz")
        .to_string_lossy()
        .into_owned()
}

/// A folder `t` with trials.
fn with_trials(more: &[&str]) -> (Workplace, String) {
    let place = Workplace::new();
    place.write("c.toml", CONFIG);
    let corridor = corridor();
    let call = [
        &["trials", &corridor, "-o", "t", "--config", "c.toml"],
        more,
    ]
    .concat();
    let told = place.ballmark(&call).done().stdout.clone();
    // Odometry is rival enough here.
    let judge = fs::read_to_string(place.path("t/compare.toml")).unwrap();
    let mut judge: toml::Table = toml::from_str(&judge).unwrap();
    let systems = judge["system"].as_array_mut().unwrap();
    assert!(systems.len() >= 3, "{systems:?}");
    let name = |system: &toml::Value| system["name"].as_str().unwrap().to_string();
    systems.retain(|system| ["mine", "odometry"].contains(&name(system).as_str()));
    fs::write(place.path("t/compare.toml"), judge.to_string()).unwrap();
    (place, told)
}

/// Times and odometry of a trial.
fn trial(place: &Workplace, name: &str) -> Vec<[f64; 4]> {
    let text = fs::read_to_string(place.path(&format!("t/trials/csv/{name}.csv"))).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        [0, 1, 2, 3].map(|at| cells[at].parse().unwrap())
    };
    text.lines().skip(1).map(row).collect()
}

fn listed(place: &Workplace) -> Vec<Vec<String>> {
    let text = fs::read_to_string(place.path("t/trials/trials.csv")).unwrap();
    text.lines()
        .skip(1)
        .map(|line| line.split(',').map(String::from).collect())
        .collect()
}

/// Answers that add odometry to the start, or to the middle of nowhere.
fn answer_all(place: &Workplace) {
    for row in listed(place) {
        let known = row[1] == "known";
        let at = |k: usize| {
            if known {
                row[k].parse::<f64>().unwrap()
            } else {
                1.0
            }
        };
        let (x, y, heading) = (at(4), at(5), at(6));
        let mut text = String::new();
        for [time_s, dx, dy, turn] in trial(place, &row[0]) {
            let (px, py) = (
                x + dx * heading.cos() - dy * heading.sin(),
                y + dx * heading.sin() + dy * heading.cos(),
            );
            let half = (heading + turn) / 2.0;
            text += &format!("{time_s} {px} {py} 0 0 0 {} {}\n", half.sin(), half.cos());
        }
        fs::write(place.path(&format!("t/answers/{}.tum", row[0])), text).unwrap();
    }
}

#[test]
fn trials_are_given_away_without_the_truth_and_judged() {
    let (place, told) = with_trials(&[]);
    assert!(
        told.contains("6 trials from anywhere, 6 from a known start"),
        "{told}"
    );
    assert_eq!(place.files(), ["c.toml", "t"]);
    let rows = listed(&place);
    assert_eq!(rows.len(), 12);
    for row in &rows {
        let is_known = row[1] == "known";
        assert!(
            row[0].starts_with(&row[1]) && row[4].is_empty() != is_known,
            "{row:?}"
        );
        let first = trial(&place, &row[0])[0];
        assert_eq!(first, [1.0, 0.0, 0.0, 0.0]);
        let header =
            fs::read_to_string(place.path(&format!("t/trials/csv/{}.csv", row[0]))).unwrap();
        assert!(
            header.starts_with("time_s,odometry_x_m,odometry_y_m,odometry_heading_rad,"),
            "{header}"
        );
    }
    let mapping = fs::read_to_string(place.path("t/mapping/mapping.csv")).unwrap();
    assert!(mapping.starts_with("time_s,x_m,y_m,heading_rad,"));
    answer_all(&place);
    let record = place
        .ballmark(&["compare", "t/compare.toml", "--json"])
        .done()
        .stdout
        .clone();
    let record: Value = serde_json::from_str(&record).unwrap();
    let trials = &record["localisation"]["records"][0]["done"];
    let mine = &trials["results"][0];
    assert_eq!(
        (mine["name"].as_str(), trials["trials"].as_u64()),
        (Some("mine"), Some(6))
    );
    // Odometry from a known start is what our own dead reckoning says.
    let own = trials["results"]
        .as_array()
        .unwrap()
        .iter()
        .find(|r| r["name"] == "odometry")
        .unwrap();
    let row = |of: &Value| {
        of["tracking"]["error_by_distance"][2]["point_error_m"]
            .as_f64()
            .unwrap()
    };
    assert!(
        row(mine) < 0.5 && (row(mine) - row(own)).abs() < 0.5,
        "{} {}",
        row(mine),
        row(own)
    );
    assert_eq!(trials["protocol"]["hash"].as_str().unwrap().len(), 16);
}

#[test]
fn what_is_wrong_with_answers_is_named_in_the_row() {
    let (place, _) = with_trials(&["--start", "unknown"]);
    answer_all(&place);
    let file = place.path("t/answers/unknown-002.tum");
    let whole = fs::read_to_string(&file).unwrap();
    let mut lines: Vec<&str> = whole.lines().collect();
    lines.pop();
    let none = String::new();
    for (text, words) in [
        (&lines.join("\n"), "unknown-002.tum: no answer to snapshot"),
        (
            &whole.replacen("1 ", "nan ", 1),
            "unknown-002.tum: line 1: `stamp` holds `nan`",
        ),
        (&none, "unknown-002.tum"),
    ] {
        fs::write(&file, text).unwrap();
        let answer = place.ballmark(&["compare", "t/compare.toml"]);
        assert_eq!(answer.status, 3, "{}", answer.stderr);
        let line = answer
            .stderr
            .lines()
            .find(|line| line.starts_with("failed: [localisation] mine"));
        assert!(
            line.is_some_and(|line| line.contains(words)),
            "{words}: {}",
            answer.stderr
        );
    }
    fs::remove_file(&file).unwrap();
    let answer = place.ballmark(&["compare", "t/compare.toml"]);
    assert!(
        answer.stderr.contains("no answer to unknown-002; expected"),
        "{}",
        answer.stderr
    );
    fs::write(place.path("t/answers/unknown-099.csv"), whole).unwrap();
    let answer = place.ballmark(&["compare", "t/compare.toml"]);
    assert!(
        answer.stderr.contains("unknown-099.csv: answers no trial"),
        "{}",
        answer.stderr
    );
    // Nor are earlier answers mixed with new trials.
    place
        .ballmark(&["trials", &corridor(), "-o", "t"])
        .refused(1, &["t/answers", "holds answers to earlier trials"]);
}

/// The comparison stands in another folder than the configuration, and earlier trials aren't mixed with new ones.
#[test]
fn files_are_found_from_the_comparison_and_trials_are_of_one_call() {
    let place = Workplace::new();
    place.write("office.yaml", "image: office.pgm\n");
    place.write("c.toml", format!("{CONFIG}map = 'office.yaml'\n"));
    let corridor = corridor();
    let call = [
        "trials", &corridor, "-o", "t", "--config", "c.toml", "--start", "unknown",
    ];
    place.ballmark(&call).done();
    let judge: toml::Table =
        toml::from_str(&fs::read_to_string(place.path("t/compare.toml")).unwrap()).unwrap();
    let map = Path::new(judge["localisation"]["map"].as_str().unwrap());
    assert!(map.is_absolute() && map.is_file(), "{map:?}");
    place
        .ballmark(&call)
        .refused(1, &["t/trials", "holds earlier trials"]);
}

#[test]
fn what_no_trials_can_be_made_of_is_refused() {
    let place = Workplace::new();
    place.write("bad.toml", "[localisation]\ntrials = 0\n");
    let corridor = corridor();
    place
        .ballmark(&["trials", &corridor, "-o", "t", "--config", "bad.toml"])
        .refused(2, &["bad.toml", "localisation.trials"]);
    place.write("bad.toml", "[localisation]\nmap = 'none.yaml'\n");
    place
        .ballmark(&["trials", &corridor, "-o", "t", "--config", "bad.toml"])
        .refused(1, &["none.yaml", "cannot find"]);
    place.write("bad.toml", "[protocol]\nmaps = 'split'\n");
    place
        .ballmark(&["trials", &corridor, "-o", "t", "--config", "bad.toml"])
        .refused(2, &["bad.toml: line 2", "maps"]);
    place
        .ballmark(&["trials", "none.npz", "-o", "t"])
        .refused(1, &["none.npz"]);
    place
        .ballmark(&["trials", &corridor, "-o", "t", "--format", "mcap"])
        .refused(1, &["--format mcap", "evenly spaced"]);
    assert_eq!(place.files(), ["bad.toml"]);
}

#[test]
fn records_of_one_protocol_stand_side_by_side() {
    let place = Workplace::new();
    let compare = |name: &str, system: &str, trials: usize| {
        let text = format!(
            "seed = 3\n[[dataset]]\nname = 'corridor'\nfile = '{}'\n[[system]]\nname = 'x'\n{system}\n[protocol]\nmapping = 'split'\n\
             [localisation]\ntrials = {trials}\nlongest_m = 8.0\nresamples = 20\n",
            corridor()
        );
        place.write("c.toml", text);
        place.ballmark(&["compare", "c.toml", "--out", name]).done();
    };
    compare("a", "kind = 'bayes'\nlandmarks = []", 6);
    compare("b", "kind = 'dead_reckoning'", 6);
    compare("c", "kind = 'dead_reckoning'", 5);
    // As many trials, and others.
    let text = fs::read_to_string(place.path("c.toml")).unwrap();
    let other = text.replace("trials = 5", "trials = 6\nshortest_m = 6.0");
    place.write("d.toml", other);
    place.ballmark(&["compare", "d.toml", "--out", "d"]).done();
    let [a, b, c, d] = ["a", "b", "c", "d"].map(|name| format!("{name}/comparison.json"));
    let both = place
        .ballmark(&["compare", "--redraw", &a, &b])
        .done()
        .stdout
        .clone();
    assert!(both.contains("x (2)"), "{both}");
    let told = |more: &[&str]| {
        let call = [&["compare", "--json", "--redraw"][..], more].concat();
        let record = place.ballmark(&call).done().stdout.clone();
        let record: Value = serde_json::from_str(&record).unwrap();
        record["localisation"]["records"][0]["done"]["paired_tests"].clone()
    };
    // Of the same trials, trial by trial; of others nothing can be said.
    let tests = told(&[&a, &b]);
    assert_eq!(tests.as_array().unwrap().len(), 1);
    assert_eq!(
        (&tests[0]["name"], &tests[0]["trials"]),
        (&"x (2)".into(), &6.into())
    );
    assert!(tests[0]["distance_difference_m"].is_number());
    for other in [&c, &d] {
        let tests = told(&[&a, other, "--mixed"]);
        assert!(tests.as_array().unwrap().is_empty(), "{other}: {tests}");
    }
    let call = ["compare", "--redraw", &a, &b, "--out", "both"];
    place.ballmark(&call).done();
    let page = fs::read_to_string(place.path("both/index.html")).unwrap();
    assert!(page.contains("x (2)") && !page.contains("application/json"));
    // A record that doesn't say what it was measured on.
    let mut old: Value = serde_json::from_slice(&fs::read(place.path(&b)).unwrap()).unwrap();
    old["datasets"][0]
        .as_object_mut()
        .unwrap()
        .remove("protocol");
    let trials = &mut old["localisation"]["records"][0]["done"];
    trials.as_object_mut().unwrap().remove("protocol");
    place.write("old.json", old.to_string());
    for pair in [[&a, "old.json"], ["old.json", "old.json"]] {
        let call = [&["compare", "--redraw"][..], &pair].concat();
        place
            .ballmark(&call)
            .refused(1, &["old.json: corridor:", "--mixed"]);
    }
    place.ballmark(&["compare", "--redraw", &a, &c]).refused(
        1,
        &[
            "c/comparison.json: corridor: measured on another protocol: `trials` differs",
            "--mixed",
        ],
    );
    place
        .ballmark(&["compare", "--redraw", &a, &c, "--mixed"])
        .done();
}

/// A program that finds the robot by as many particles as it takes, and answers the standard experiment's trials by odometry.
const PROGRAM: &str = r#"
case "$1" in
trial) awk -F, 'NR > 1 { print $1, $2, $3, 0, 0, 0, 0, 1 }' "$4" > "$2" ;;
*) if [ "$3" -ge 100 ]; then cp "answers/$1.tum" "$2"
   else awk '{ $2 += 3 * (NR % 5); print }' "answers/$1.tum" > "$2"; fi ;;
esac
"#;

#[test]
#[cfg(unix)]
fn too_few_particles_are_named_and_the_standard_experiment_runs_programs_too() {
    let (place, _) = with_trials(&[]);
    place.write("t/mine.sh", PROGRAM);
    answer_all(&place);
    // Where unknown starts are follows from the known ones: the same trials.
    let listed = listed(&place);
    for row in listed.iter().filter(|row| row[1] == "unknown") {
        let same = listed
            .iter()
            .find(|other| other[1] == "known" && trial(&place, &other[0]) == trial(&place, &row[0]))
            .unwrap();
        let answers = |name: &str| place.path(&format!("t/answers/{name}.tum"));
        fs::copy(answers(&same[0]), answers(&row[0])).unwrap();
    }
    let text = fs::read_to_string(place.path("t/compare.toml")).unwrap();
    let judged = |particles: &str, standard: &str| {
        let mut judge: toml::Table = toml::from_str(&text).unwrap();
        assert_eq!(judge["localisation"]["more_particles"], 4.into());
        let mine = judge["system"].as_array_mut().unwrap()[0]
            .as_table_mut()
            .unwrap();
        mine.remove("answers");
        let command = [
            "sh",
            "mine.sh",
            "{trial}",
            "{answer_tum}",
            "{particles}",
            "{trial_csv}",
        ];
        mine.insert("command".into(), command.to_vec().into());
        let more: toml::Table = toml::from_str(&format!("{particles}{standard}")).unwrap();
        if let Some(particles) = more.get("particles") {
            mine.insert("particles".into(), particles.clone());
        }
        if let Some(standard) = more.get("standard") {
            judge.insert("standard".into(), standard.clone());
            judge["system"].as_array_mut().unwrap().truncate(1); // who senses nothing has no answer there
        }
        fs::write(place.path("t/judge.toml"), judge.to_string()).unwrap();
        place.ballmark(&["compare", "t/judge.toml", "--out", "out"])
    };
    judged("", "").refused(
        2,
        &["particles: expected their number where `{particles}` stands"],
    );
    let standard = "[standard]\ntrial_m = 3.0\nevery_s = 60.0\npermutations = 19\nresamples = 19\n";
    let few = judged("particles = 30\n", standard).done().stdout.clone();
    assert!(
        few.contains(
            "warning: mine: 0 % found with 30 particles,\n  100 % found with 120 particles"
        ),
        "{few}"
    );
    let record: Value =
        serde_json::from_slice(&fs::read(place.path("out/comparison.json")).unwrap()).unwrap();
    let check = &record["localisation"]["records"][0]["done"]["more_particles"][0];
    assert_eq!(
        (&check["particles"], &check["more"]),
        (&30.into(), &120.into())
    );
    assert_eq!(check["changes"], true);
    let cell = &record["standard"]["cells"][0][0]["done"];
    assert!(
        cell["mean_uncertainty_coefficient"].as_f64().unwrap() > 0.0,
        "{cell}"
    );
    let answers = cell["answers_at_end"].as_array().unwrap();
    let counted: u64 = answers.iter().map(|of| of["count"].as_u64().unwrap()).sum();
    assert_eq!(Some(counted), cell["trials"].as_u64());
    let page = fs::read_to_string(place.path("out/index.html")).unwrap();
    assert!(page.contains("Where each answer was given"));
    let pictures = place.path("out/contingency-standard-corridor-small-mine");
    assert!(pictures.with_extension("svg").exists() && pictures.with_extension("png").exists());
    let enough = judged("particles = 100\n", "").done().stdout.clone();
    assert!(
        enough.contains("no change beyond chance") && !enough.contains("warning:"),
        "{enough}"
    );
}

#[test]
fn numbers_of_particles_that_make_no_sense_are_refused() {
    let place = Workplace::new();
    let system = "[[system]]\nkind = 'nearest'\n";
    for (text, fault) in [
        (
            format!("{system}[localisation]\nmore_particles = 1"),
            "more_particles = 1: expected 0 for no more, or 2 to 1000",
        ),
        (
            format!("{system}[localisation]\nmore_particles = 1001"),
            "more_particles",
        ),
        (
            "[[system]]\nkind = 'monte_carlo'\nroughening_m = -0.1\n[localisation]".into(),
            "roughening_m = -0.1: expected a number from 0",
        ),
        (
            "[[system]]\nkind = 'monte_carlo'\nroughening_rad = nan\n[localisation]".into(),
            "roughening_rad",
        ),
        (
            "[[system]]\nkind = 'external'\ncommand = ['x']\nparticles = 9\n[localisation]".into(),
            "particles: expected their number where `{particles}` stands",
        ),
    ] {
        let file = corridor();
        place.write(
            "bad.toml",
            format!("[[dataset]]\nfile = '{file}'\n{text}\n"),
        );
        place
            .ballmark(&["compare", "bad.toml"])
            .refused(2, &["bad.toml", fault]);
    }
}
