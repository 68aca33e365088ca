//! `ballmark trajectory` on good files: the same figures as `evo`, and the prediction–correction metric.

use crate::support::{Answer, Workplace};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A file of tests/trajectories, which benches/peers/trajectories.py made.
fn kept(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/trajectories")
        .join(name)
}

pub fn json(answer: &Answer) -> Value {
    serde_json::from_str(&answer.done().stdout).expect("one JSON object")
}

/// TUM lines of poses in the plane: stamp, x, y, heading in degrees.
pub fn tum(poses: impl IntoIterator<Item = [f64; 4]>) -> String {
    let line = |[stamp, x, y, heading]: [f64; 4]| {
        let half = heading.to_radians() / 2.0;
        format!("{stamp} {x} {y} 0 0 0 {} {}\n", half.sin(), half.cos())
    };
    poses.into_iter().map(line).collect()
}

/// Every statistic of every case that evo judged, to 1e-9.
#[test]
fn errors_equal_those_of_evo() {
    let found = std::fs::read_to_string(kept("evo.json")).expect("a kept file");
    let found: Value = serde_json::from_str(&found).expect("JSON");
    let cases = found["cases"].as_array().expect("cases");
    assert!(cases.len() > 30);
    let place = Workplace::new();
    let mut compared = 0;
    for case in cases {
        let text = |key: &str| case[key].as_str().expect("text").to_string();
        let number = |key: &str| case[key].to_string();
        let [estimate, reference] = ["estimate", "reference"]
            .map(|key| kept(&text(key)).to_str().expect("UTF-8").to_string());
        let mut call = ["trajectory", "--json", "--allow-incomplete"]
            .map(String::from)
            .to_vec();
        call.extend([estimate, reference]);
        for (option, value) in [
            ("--align", text("align")),
            ("--max-difference", number("max_difference_s")),
            ("--offset", number("offset_s")),
            ("--delta", number("delta")),
            ("--delta-unit", text("delta_unit")),
            ("--delta-tolerance", number("delta_tolerance")),
        ] {
            call.extend([option.to_string(), value]);
        }
        for (flag, key) in [
            ("--planar", "planar"),
            ("--all-pairs", "all_pairs"),
            ("--pairs-from-reference", "pairs_from_reference"),
        ] {
            call.extend((case[key] == true).then(|| flag.to_string()));
        }
        let ours = json(&place.ballmark(&call));
        assert_eq!(ours["matched"], case["matched"], "{case}");
        assert_eq!(ours["rpe_delta"]["pairs"], case["pairs"], "{case}");
        for metric in ["ape", "rpe"] {
            for part in ["translation_m", "rotation_deg"] {
                let (ours, theirs) = (&ours[metric][part], &case[metric][part]);
                let theirs = theirs.as_object().expect("statistics");
                assert_eq!(theirs.len(), 7);
                for (name, theirs) in theirs {
                    let (ours, theirs) = (ours[name].as_f64().unwrap(), theirs.as_f64().unwrap());
                    let within = 1e-9 * theirs.abs().max(1.0);
                    assert!(
                        (ours - theirs).abs() <= within,
                        "{metric} {part} {name}: {ours}, evo {theirs}, of {call:?}"
                    );
                    compared += 1;
                }
            }
        }
    }
    assert_eq!(compared, cases.len() * 28);
}

/// A robot that drives 40 m; the estimate is off by `y` and `heading` (degrees) at each step.
fn walk(steps: usize, off: impl Fn(usize) -> (f64, f64)) -> String {
    tum((0..steps).map(|k| {
        let (y, heading) = off(k);
        [k as f64, k as f64 * 0.5, y, heading]
    }))
}

#[test]
fn keys_are_those_that_programs_rely_on() {
    let place = Workplace::new();
    place.write("ref.tum", walk(20, |_| (0.0, 0.0)));
    place.write("est.tum", walk(20, |_| (0.3, 2.0)));
    place.write("prior.tum", walk(20, |_| (0.5, 2.0)));
    let plain = json(&place.ballmark(&["trajectory", "est.tum", "ref.tum", "--json"]));
    let keys = |value: &Value| -> Vec<String> {
        value
            .as_object()
            .expect("an object")
            .keys()
            .cloned()
            .collect()
    };
    for metric in ["ape", "rpe"] {
        assert_eq!(keys(&plain[metric]), ["rotation_deg", "translation_m"]);
        for part in ["translation_m", "rotation_deg"] {
            let mut expected = ["rmse", "mean", "median", "std", "min", "max", "sse"];
            expected.sort_unstable();
            let mut found = keys(&plain[metric][part]);
            found.sort();
            assert_eq!(found, expected);
        }
    }
    assert_eq!(
        (&plain["matched"], &plain["total"]),
        (&20.into(), &20.into())
    );
    assert_eq!(plain["completeness"], 1.0);
    assert_eq!(plain["prediction_correction"], Value::Null);
    let with_prior = [
        "trajectory",
        "est.tum",
        "ref.tum",
        "--prior",
        "prior.tum",
        "--json",
    ];
    let metric = &json(&place.ballmark(&with_prior))["prediction_correction"];
    assert_eq!(metric["correction"]["position"]["improved"], 20);
    assert_eq!(metric["correction"]["heading"]["unchanged"], 20);
    assert_eq!(metric["correction"]["both"]["better"], 0.0);
    assert_eq!(metric["correction"]["both"]["not_worse"], 1.0);
    assert_eq!(metric["prediction_s"], Value::Null);
}

/// A fifth of the estimates copies its prior, a fifth is worse; errors known in advance.
#[test]
fn the_prediction_correction_metric() {
    let place = Workplace::new();
    place.write("ref.tum", walk(20, |_| (0.0, 0.0)));
    place.write("prior.tum", walk(20, |k| (0.1 * (k + 1) as f64, 10.0)));
    let corrected = |k: usize| match k % 5 {
        0 => (0.1 * (k + 1) as f64, 10.0),
        1 => (5.0, 12.0),
        _ => (0.05, 5.0),
    };
    place.write("est.tum", walk(20, corrected));
    let mut call = vec!["trajectory", "est.tum", "ref.tum", "--prior", "prior.tum"];
    call.extend([
        "--truth-precision",
        "0.05m,3deg",
        "--search-step",
        "10cm,10deg",
    ]);
    call.extend(["--prior-intervals", "0.5m,1m"]);
    let text = place.ballmark(&call);
    call.push("--json");
    let answer = place.ballmark(&call);
    let metric = &json(&answer)["prediction_correction"];
    let position = &metric["correction"]["position"];
    let counts = ["improved", "unchanged", "worsened"].map(|key| position[key].as_u64().unwrap());
    assert_eq!(counts, [12, 4, 4]);
    assert_eq!(
        (&position["not_worse"], &position["better"]),
        (&0.8.into(), &0.6.into())
    );
    let near = |value: &Value, expected: f64| {
        let value = value.as_f64().expect("a number");
        assert!((value - expected).abs() < 1e-9, "{value} is not {expected}");
    };
    let prior = &metric["prior"]["position_m"];
    near(&prior["mean"], 1.05);
    near(&prior["percentiles"]["50"], 1.0);
    near(&prior["percentiles"]["90"], 1.8);
    near(&prior["percentiles"]["95"], 1.9);
    near(&prior["percentiles"]["100"], 2.0);
    let posterior = &metric["posterior"]["heading_deg"];
    near(&posterior["mean"], 7.4);
    near(
        &posterior["std"],
        (0.6 * 2.4f64.powi(2) + 0.2 * 2.6f64.powi(2) + 0.2 * 4.6f64.powi(2)).sqrt(),
    );
    near(
        &posterior["merit"],
        7.4 + posterior["std"].as_f64().unwrap(),
    );
    // 12 estimates are within 0.05 m; 7.07 cm and 5° make the same ones optimal.
    assert_eq!(metric["truth"]["positions_within"], 12);
    assert_eq!(metric["truth"]["position_precise_enough"], true);
    assert_eq!(metric["truth"]["headings_within"], 0);
    near(&metric["optimal"]["limit_position_m"], 0.1 / 2f64.sqrt());
    assert_eq!(metric["optimal"]["count"], 12);
    let intervals = metric["by_prior_position_m"].as_array().unwrap();
    let n = |k: usize| intervals[k]["correction"]["n"].as_u64().unwrap();
    assert_eq!((intervals.len(), n(0), n(1), n(2)), (3, 5, 5, 10));
    assert_eq!(metric["by_prior_heading_deg"].as_array().unwrap().len(), 1); // all alike
    for part in [
        "C_XYT",
        "improved",
        "C with <=",
        "optimal for the search",
        "60.0 %",
        "12 of 20 errors within 0.05 m",
        "time of a prediction: not known from poses",
        "0.5000 to 1.0000",
    ] {
        assert!(
            text.done().stdout.contains(part),
            "{part} in\n{}",
            text.stdout
        );
    }
    let widest = text.stdout.lines().map(|line| line.chars().count()).max();
    assert!(widest.unwrap() <= 100, "{widest:?}\n{}", text.stdout);
    // A truth that is not twice as precise is said to be.
    call.extend(["--truth-precision", "0.05m,4deg"]);
    let first = call
        .iter()
        .position(|word| *word == "--truth-precision")
        .unwrap();
    call.drain(first..first + 2);
    let answer = place.ballmark(&call);
    assert!(
        answer.done().stderr.contains("not twice as precise"),
        "{}",
        answer.stderr
    );
}

#[test]
fn the_prior_is_moved_as_the_estimate_is() {
    let place = Workplace::new();
    let walk = |by: f64, turn: f64| {
        let pose = |k: usize| {
            let (x, y) = (k as f64 * 0.5, (k as f64 * 0.4).sin() + by);
            let (s, c) = turn.to_radians().sin_cos();
            [k as f64, c * x - s * y + 3.0, s * x + c * y - 1.0, turn]
        };
        tum((0..30).map(pose))
    };
    place.write("ref.tum", walk(0.0, 0.0));
    place.write("est.tum", walk(0.0, 30.0));
    place.write("prior.tum", walk(0.25, 30.0));
    let call = [
        "trajectory",
        "est.tum",
        "ref.tum",
        "--prior",
        "prior.tum",
        "--align",
        "se2",
        "--json",
    ];
    let answer = json(&place.ballmark(&call));
    let prior = &answer["prediction_correction"]["prior"]["position_m"];
    for value in [&prior["mean"], &prior["percentiles"]["100"]] {
        assert!((value.as_f64().unwrap() - 0.25).abs() < 1e-9, "{prior}");
    }
    let rmse = answer["ape"]["translation_m"]["rmse"].as_f64().unwrap();
    assert!(rmse < 1e-12, "{rmse}");
}

#[test]
fn formats_and_stamps_may_differ() {
    let place = Workplace::new();
    place.write("ref.tum", walk(20, |_| (0.0, 0.0)));
    let mut csv = String::from("\u{feff}note;y;x;stamp;heading_deg\r\n");
    let mut kitti = String::new();
    for k in 0..20 {
        csv.push_str(&format!(
            "a;0.3;{};{};2\r\n",
            0.5 * k as f64,
            k as f64 + 0.004
        ));
        kitti.push_str(&format!("1 0 0 {} 0 1 0 0.3 0 0 1 0\n", 0.5 * k as f64));
    }
    place.write("est.csv", csv);
    place.write("est.kitti", kitti);
    place.write(
        "times.txt",
        (0..20).map(|k| format!("{k}\n")).collect::<String>(),
    );
    let rmse = |arguments: &[&str]| {
        let call = [&["trajectory", "--json"], arguments].concat();
        json(&place.ballmark(&call))["ape"]["translation_m"]["rmse"]
            .as_f64()
            .unwrap()
    };
    assert!((rmse(&["est.csv", "ref.tum"]) - 0.3).abs() < 1e-12);
    assert!((rmse(&["est.kitti", "ref.tum", "--times", "times.txt"]) - 0.3).abs() < 1e-12);
    assert!(
        (rmse(&[
            "est.kitti",
            "ref.tum",
            "--times",
            "times.txt",
            "--offset",
            "2"
        ]) - 1.0440306508910549)
            .abs()
            < 1e-12
    );
}

#[test]
fn the_aligned_estimate_is_written_whole() {
    let place = Workplace::new();
    let (est, reference) = (kept("flight-estimate.tum"), kept("flight-reference.tum"));
    let (est, reference) = (est.to_str().unwrap(), reference.to_str().unwrap());
    let judged = json(&place.ballmark(&[
        "trajectory",
        est,
        reference,
        "--align",
        "sim3",
        "--json",
        "--out",
        "a.tum",
    ]));
    for out in ["a.tum", "a.csv"] {
        place
            .ballmark(&[
                "trajectory",
                est,
                reference,
                "--align",
                "sim3",
                "--out",
                out,
            ])
            .done();
        let again = json(&place.ballmark(&["trajectory", out, reference, "--json"]));
        for metric in ["ape", "rpe"] {
            for part in ["translation_m", "rotation_deg"] {
                let of = |value: &Value| value[metric][part]["rmse"].as_f64().unwrap();
                assert!(
                    (of(&judged) - of(&again)).abs() < 1e-12,
                    "{out} {metric} {part}"
                );
            }
        }
        assert_eq!(again["matched"], 194);
    }
    assert_eq!(place.files(), ["a.csv", "a.tum"]);
    let line = std::fs::read_to_string(place.path("a.tum")).unwrap();
    assert_eq!(line.lines().next().unwrap().split(' ').count(), 8);
}

#[test]
fn too_few_matched_poses_are_a_failure_unless_allowed() {
    let place = Workplace::new();
    place.write("ref.tum", walk(100, |_| (0.0, 0.0)));
    place.write("lost.tum", walk(42, |_| (0.1, 0.0)));
    let every_second = tum((0..50).map(|k| [2.0 * k as f64, k as f64, 0.1, 0.0]));
    place.write("slow.tum", every_second);
    place
        .ballmark(&["trajectory", "lost.tum", "ref.tum"])
        .refused(
            1,
            &[
                "lost.tum has a pose for 42 of 100 poses of ref.tum (42.0 %, under 90 %)",
                "span 42.0 %",
                "--allow-incomplete",
            ],
        );
    place
        .ballmark(&["trajectory", "slow.tum", "ref.tum"])
        .refused(1, &["50 of 100", "span 99.0 %"]);
    let allowed = place.ballmark(&["trajectory", "lost.tum", "ref.tum", "--allow-incomplete"]);
    assert!(
        allowed.done().stderr.contains("42 of 100 poses"),
        "{}",
        allowed.stderr
    );
    let row = allowed
        .stdout
        .lines()
        .find(|line| line.starts_with("APE, translation"))
        .unwrap();
    assert!(row.ends_with("42    100"), "{row}");
    assert!(allowed.stdout.contains("completeness 42.0 %"));
    // 90 % is enough.
    place.write("most.tum", walk(90, |_| (0.1, 0.0)));
    place
        .ballmark(&["trajectory", "most.tum", "ref.tum"])
        .done();
    place.write("less.tum", walk(89, |_| (0.1, 0.0)));
    assert_eq!(
        place
            .ballmark(&["trajectory", "less.tum", "ref.tum"])
            .status,
        1
    );
    // Swapped: the estimate knows more than what it is held against.
    let swapped = place.ballmark(&["trajectory", "ref.tum", "lost.tum"]);
    assert!(
        swapped
            .done()
            .stderr
            .contains("58 of 100 poses of ref.tum lie outside the time of lost.tum"),
        "{}",
        swapped.stderr
    );
}

#[test]
fn threads_do_not_change_a_byte() {
    let with = |threads: &str| {
        let mut command = std::process::Command::new(crate::support::binary());
        command.args([
            "trajectory",
            "--json",
            "--align",
            "sim3",
            "--delta",
            "40",
            "--delta-unit",
            "deg",
            "--all-pairs",
        ]);
        command.args([kept("flight-estimate.tum"), kept("flight-reference.tum")]);
        crate::support::answer(command.env("RAYON_NUM_THREADS", threads))
            .done()
            .stdout
            .clone()
    };
    assert_eq!(with("1"), with("4"));
}
