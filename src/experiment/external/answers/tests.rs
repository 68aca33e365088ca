use super::*;
use std::fs;

const TIMES_S: [f64; 3] = [1.0, 1.5, 2.5];

fn read_as(file: &str, text: &str, config: &ExternalConfig) -> Result<Vec<Step>> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(file), text).unwrap();
    read(folder.path(), "unknown-001", &TIMES_S, config)
}

fn fault(file: &str, text: &str) -> String {
    read_as(file, text, &ExternalConfig::default())
        .unwrap_err()
        .to_string()
}

fn at(step: &Step) -> [f64; 2] {
    match step.estimate {
        Some(Estimate::Place(place)) => place,
        other => panic!("{other:?}"),
    }
}

#[test]
fn poses_are_answers_without_a_belief() {
    let text = "1.0 5 6 0 0 0 0 1\n1.51 7 8 0 0 0 0.7071067811865476 0.7071067811865476\n2.5 9 9 0 0 0 0 1\n";
    let steps = read_as("unknown-001.tum", text, &ExternalConfig::default()).unwrap();
    assert_eq!((steps.len(), at(&steps[1])), (3, [7.0, 8.0]));
    let heading = steps[1].heading_rad.unwrap();
    assert!((heading - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert!(steps.iter().all(|step| step.posterior.is_empty()));
    let text = "stamp;x;y;yaw_deg\n1,0;1;2;90\n1,5;1;2;90\n2,5;1;2;90\n";
    let steps = read_as("unknown-001.csv", text, &ExternalConfig::default()).unwrap();
    assert_eq!(
        (at(&steps[2]), steps[2].heading_rad),
        ([1.0, 2.0], Some(std::f64::consts::FRAC_PI_2))
    );
}

#[test]
fn particles_are_weighed_and_the_densest_square_answers() {
    let mut text = "time_s,x_m,y_m,heading_rad,weight\n".to_string();
    for time in TIMES_S {
        for (x, heading, weight) in [(10.2, 3.1, 1.0), (10.4, -3.1, 3.0), (50.5, 0.0, 3.5)] {
            text += &format!("{time},{x},2.5,{heading},{weight}\n");
        }
    }
    let steps = read_as("unknown-001.csv", &text, &ExternalConfig::default()).unwrap();
    let [x, y] = at(&steps[0]);
    assert!((x - 10.35).abs() < 1e-12 && y == 2.5, "{x}");
    assert!(steps[0].heading_rad.unwrap().abs() > 3.0); // across ±π
    assert_eq!(steps[0].posterior.len(), 3);
    assert!((steps[0].posterior[2].1 - 3.5 / 7.5).abs() < 1e-12);
    let none = text
        .replace(",1\n", ",0\n")
        .replace(",3\n", ",0\n")
        .replace(",3.5\n", ",0\n");
    assert!(fault("unknown-001.csv", &none).contains("line 2: weights at 1 s sum to 0"));
}

#[test]
fn a_belief_of_a_grid_sums_to_one() {
    let text = |p: f64| {
        let rows = TIMES_S.map(|t| format!("{t},0,0,0.25\n{t},1,0,{p}\n"));
        format!("time_s,x_m,y_m,probability\n{}", rows.concat())
    };
    let steps = read_as("unknown-001.csv", &text(0.75), &ExternalConfig::default()).unwrap();
    assert_eq!(
        (at(&steps[0]), steps[0].posterior[1]),
        ([1.0, 0.0], ([1.0, 0.0], 0.75))
    );
    let wrong = fault("unknown-001.csv", &text(0.5));
    assert!(
        wrong.contains("line 2: probabilities at 1 s sum to 0.75; expected 1 ± 0.001"),
        "{wrong}"
    );
}

/// The mean distance of a Gaussian with deviations s from its own middle is s·√(π/2).
#[test]
fn a_covariance_spreads_the_answer() {
    let rows = TIMES_S.map(|t| format!("{t},1,2,0.25,0,0.25\n")).concat();
    let text = format!("time_s,x_m,y_m,xx_m2,xy_m2,yy_m2\n{rows}");
    let steps = read_as("unknown-001.csv", &text, &ExternalConfig::default()).unwrap();
    let mean_m: f64 = steps[0]
        .posterior
        .iter()
        .map(|([x, y], p)| p * (x - 1.0).hypot(y - 2.0))
        .sum();
    let expected_m = 0.5 * std::f64::consts::FRAC_PI_2.sqrt();
    assert!(
        (mean_m / expected_m - 1.0).abs() < 0.02,
        "{mean_m} {expected_m}"
    );
    let leaning = belief::gaussian([0.0, 0.0], [4.0, 2.0, 1.0]); // on a line: y = x / 2
    assert!(leaning.iter().all(|([x, y], _)| (x - 2.0 * y).abs() < 1e-9));
    let bad = text.replace(",0.25,0,0.25", ",0.25,1,0.25");
    assert!(fault("unknown-001.csv", &bad).contains("positive semidefinite"));
}

#[test]
fn answers_and_beliefs_may_stand_in_two_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = |ending: &str| folder.path().join(format!("unknown-001.{ending}"));
    let tum = TIMES_S.map(|t| format!("{t} 5 5 0 0 0 0 1\n")).concat();
    fs::write(path("tum"), tum).unwrap();
    let rows = TIMES_S.map(|t| format!("{t},0,0,1\n")).concat();
    fs::write(path("csv"), format!("time_s,x_m,y_m,probability\n{rows}")).unwrap();
    let read = || {
        read(
            folder.path(),
            "unknown-001",
            &TIMES_S,
            &ExternalConfig::default(),
        )
    };
    let steps = read().unwrap();
    assert_eq!(
        (at(&steps[0]), steps[0].posterior.as_slice()),
        ([5.0, 5.0], &[([0.0, 0.0], 1.0)][..])
    );
    fs::write(path("csv"), "time_s,x_m,y_m\n1,0,0\n1.5,0,0\n2.5,0,0\n").unwrap();
    assert!(read().unwrap_err().to_string().contains("no belief at 1 s"));
}

#[test]
fn what_is_missing_late_or_of_another_run_is_named() {
    let line = |t: f64| format!("{t} 1 1 0 0 0 0 1\n");
    let missing = read_as("known-001.tum", &line(1.0), &ExternalConfig::default()).unwrap_err();
    assert!(
        missing.to_string().contains("no answer to unknown-001"),
        "{missing}"
    );
    let late = fault("unknown-001.tum", &[1.0, 1.7, 2.5].map(line).concat());
    assert!(
        late.contains("no answer to snapshot 2 of 3, at 1.5 s; the nearest is at 1.7 s"),
        "{late}"
    );
    let short = fault("unknown-001.tum", &[1.0, 1.5].map(line).concat());
    assert!(short.contains("snapshot 3 of 3"), "{short}");
    let other = fault("unknown-001.tum", &[1.7e9, 1.7e9 + 1.0].map(line).concat());
    assert!(
        other.contains("expected those of unknown-001, from 1 to 2.5 s"),
        "{other}"
    );
    let silent = ExternalConfig {
        may_be_silent: true,
        ..ExternalConfig::default()
    };
    let steps = read_as("unknown-001.tum", &[1.0, 2.5].map(line).concat(), &silent).unwrap();
    assert_eq!(steps[1], Step::default());
    let loose = ExternalConfig {
        tolerance_s: 0.2,
        ..ExternalConfig::default()
    };
    read_as(
        "unknown-001.tum",
        &[1.0, 1.7, 2.5].map(line).concat(),
        &loose,
    )
    .unwrap();
}

#[test]
fn what_makes_no_sense_is_named_with_its_line() {
    for (text, words) in [
        (
            "1 nan 1 0 0 0 0 1\n",
            "line 1: `x` holds `nan`; expected a finite number",
        ),
        (
            "2 1 1 0 0 0 0 1\n1 1 1 0 0 0 0 1\n",
            "line 2: stamp 1 goes back",
        ),
    ] {
        let said = fault("unknown-001.tum", text);
        assert!(said.contains(words), "{said}");
    }
    for (text, words) in [
        (
            "time_s,x_m,y_m,heading_rad\n1,1,1,93\n",
            "line 2: `heading_rad` holds 93; expected radians",
        ),
        ("time_s,x_m,y_m\n1,1,inf\n", "line 2: `y_m` holds `inf`"),
        ("time_s,x_m,y_m\n1,1\n", "line 2: 2 cells; expected 3"),
        ("time_s,x_m,y_m\n1,1,1\n1,2,1\n", "line 2: 2 rows at 1 s"),
        (
            "time_s,x_m,y_m\n2,1,1\n1,2,1\n",
            "line 3: time 1 s after 2 s",
        ),
        (
            "time_s,x_m,y_m,weight\n1,1,1,-1\n",
            "line 2: `weight` holds -1",
        ),
        ("time_s,x_m,xx_m2\n1,1,1\n", "line 1: expected all of xx_m2"),
        (
            "time_s,x_m\n1,1\n",
            "line 1: no column `y_m` among `time_s`, `x_m`",
        ),
        ("time_s,x_m,y_m\n", "holds no answer"),
        ("", "line 1: no column `time_s`"),
    ] {
        let said = fault("unknown-001.csv", text);
        assert!(said.contains(words), "{text:?}: {said}");
    }
}
