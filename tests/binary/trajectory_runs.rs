//! `ballmark trajectory --config`: several runs, what is known of their conditions, and the folder of all of it.

use crate::{
    support::Workplace,
    trajectory::{json, tum},
};
use serde_json::Value;

/// A robot that drives 10 m in 20 s; the estimate is off by `y` metres.
fn walk(steps: usize, y: f64) -> String {
    tum((0..steps).map(|k| [k as f64, 0.5 * k as f64, y, 0.0]))
}

fn workplace() -> Workplace {
    let place = Workplace::new();
    for (run, steps, off) in [("r1", 21, 0.1), ("r2", 11, 0.3)] {
        place.write(&format!("{run}-ref.tum"), walk(steps, 0.0));
        place.write(&format!("{run}-prior.tum"), walk(steps, 0.2));
        place.write(&format!("{run}-est.tum"), walk(steps, off));
    }
    place
}

const RUNS: &str = "\
[framework]
objective = 'to find the charger'
real_poses = '''motion capture,
each pose'''
correction = ' '

[[run]]
name = 'R1'
estimate = 'r1-est.tum'
reference = 'r1-ref.tum'
prior = 'r1-prior.tum'
[run.conditions]
place = 'a corridor'
changes = 'nobody passed'

[[run]]
estimate = 'r2-est.tum'
reference = 'r2-ref.tum'
prior = 'r2-prior.tum'
";

#[test]
fn runs_are_judged_apart_and_together() {
    let place = workplace();
    place.write("runs.toml", RUNS);
    let call = ["trajectory", "--config", "runs.toml", "--report", "out"];
    let text = place.ballmark(&call);
    let said = &text.done().stdout;
    for part in [
        "all runs",
        "objective: to find the charger\n",
        "measurement of real poses: motion capture, each pose\n",
        "correction (E): missing\n",
        "run conditions of R1 (3.2)\n  place, walls, obstacles: a corridor\n  materials: missing",
        "run conditions of r2-est (3.2)\n  place, walls, obstacles: missing",
    ] {
        assert!(said.contains(part), "{part} in\n{said}");
    }
    let widest = said.lines().map(|line| line.chars().count()).max();
    assert!(widest.unwrap() <= 100, "{widest:?}\n{said}");
    let all = json(&place.ballmark(&[&call[..3], &["--json"]].concat()));
    let metric = &all["prediction_correction"];
    assert_eq!(
        (&metric["n"], &metric["name"]),
        (&32.into(), &"all runs".into())
    );
    assert_eq!(metric["correction"]["position"]["improved"], 21);
    assert_eq!(metric["runs"][1]["correction"]["position"]["worsened"], 11);
    let facts = &all["runs"][0]["facts"];
    assert_eq!(
        (&facts["way_m"], &facts["per_m"]),
        (&10.0.into(), &2.0.into())
    );
    assert_eq!(
        (&facts["duration_s"], &facts["extent_m"][0]),
        (&20.0.into(), &10.0.into())
    );
    assert_eq!(all["runs"][0]["conditions"]["place"], "a corridor");
    let precise = ["--truth-precision", "0.2m,1deg"];
    let answer = place.ballmark(&[&call[..3], &precise, &["--json"]].concat());
    assert_eq!(
        json(&answer)["prediction_correction"]["truth"]["positions_within"],
        21
    );
    assert_eq!(all["framework"]["objective"], "to find the charger");
    let rmse = all["runs"][1]["ape"]["translation_m"]["rmse"].as_f64();
    assert!((rmse.unwrap() - 0.3).abs() < 1e-12);
    // The folder holds the same.
    let read = |name: &str| std::fs::read_to_string(place.path("out").join(name)).unwrap();
    assert_eq!(&read("trajectory.txt"), said);
    let kept: Value = serde_json::from_str(&read("trajectory.json")).unwrap();
    assert_eq!(kept, all);
    let csv = read("traces-R1.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines.len(), 22);
    assert!(lines[0].starts_with("stamp_s,real_x_m,real_y_m,real_heading_rad,prior_x_m"));
    assert!(lines[2].starts_with("1,0.5,0,0,0.5,0.2,"), "{}", lines[2]);
    let svg = read("traces-r2-est.svg");
    assert!(svg.contains("before correction") && svg.contains("y (m)"));
}

/// What an experiment is like can be stated of a single run, too.
#[test]
fn a_run_of_the_call_has_a_framework() {
    let place = workplace();
    place.write("framework.toml", "[framework]\nrobot = 'a cart'");
    let call = [
        "trajectory",
        "r1-est.tum",
        "r1-ref.tum",
        "--config",
        "framework.toml",
    ];
    let said = place.ballmark(&call).done().stdout.clone();
    assert!(
        said.contains("robot: a cart\n") && said.contains("objective: missing\n"),
        "{said}"
    );
}

#[test]
fn what_does_not_fit_is_refused() {
    let place = workplace();
    place.write("runs.toml", RUNS);
    place.write("none.toml", "[framework]\nrobot = 'a cart'");
    place.write("lost.toml", RUNS.replace("r2-ref", "r3-ref"));
    place.write("twice.toml", RUNS.replace("r2-est", "r2-ref"));
    place.write("far.toml", RUNS.replace("'R1'", "'r2-est'"));
    place.write("one.tum", walk(1, 0.0));
    place.write("one.toml", RUNS.replace("r2-prior", "one"));
    let refused = |call: &[&str], status: i32, parts: &[&str]| {
        place
            .ballmark(&[&["trajectory"], call].concat())
            .refused(status, parts);
    };
    refused(&["--config", "none.toml"], 2, &["no run", "[[run]]"]);
    refused(
        &["r1-est.tum", "r1-ref.tum", "--config", "runs.toml"],
        2,
        &["EST beside the [[run]]s"],
    );
    refused(
        &["--config", "runs.toml", "--prior", "r1-prior.tum"],
        2,
        &["--prior beside the [[run]]s"],
    );
    refused(
        &["--config", "runs.toml", "--out", "a.tum"],
        2,
        &["--out for several runs", "--report"],
    );
    refused(&["--config", "lost.toml"], 1, &["r2-est", "r3-ref.tum"]);
    refused(&["--config", "twice.toml"], 2, &["r2-ref.tum", "two files"]);
    refused(
        &["--config", "far.toml"],
        2,
        &["far.toml: line", "another run's"],
    );
    refused(
        &["--config", "one.toml"],
        1,
        &["run r2-est", "one.tum", "one pose; expected a trajectory"],
    );
    refused(&["r1-est.tum"], 2, &["required arguments"]);
    assert!(!place.path("out").exists());
}
