use super::*;
use crate::recogniser::test_world::test_world;

const TRIALS: usize = 6;

/// Trials of 20 snapshots of the second lap, and answers that are the truth moved so.
fn fault(word: &str, moved: impl Fn(usize, &Pose) -> [f64; 2]) -> Option<String> {
    let run = test_world();
    let trial = |t: usize| Trial {
        stretch: 0,
        unit: 0,
        snapshots: (104 + 12 * t..124 + 12 * t).collect(),
        travelled_m: (0..20).map(|i| 0.25 * f64::from(i)).collect(),
    };
    let trials: Vec<Trial> = (0..TRIALS).map(trial).collect();
    let names: Vec<String> = (1..=TRIALS).map(|n| format!("{word}-00{n}")).collect();
    let step = |t: usize, k: usize| Step {
        estimate: Some(Estimate::Place(moved(t, &run.poses()[k]))),
        ..Step::default()
    };
    let of = |(t, trial): (usize, &Trial)| trial.snapshots.iter().map(|&k| step(t, k)).collect();
    let steps: Vec<Vec<Step>> = trials.iter().enumerate().map(of).collect();
    let answered = Answered {
        start: match word {
            "known" => Start::Known,
            _ => Start::Unknown,
        },
        names: &names,
        trials: &trials,
        steps: &steps,
    };
    check(&run, &[answered]).err().map(|e| e.to_string())
}

#[test]
fn the_truth_and_what_is_merely_wrong_are_in_its_frame() {
    for start in ["known", "unknown"] {
        assert_eq!(fault(start, |_, p| [p.x_m, p.y_m]), None);
        assert_eq!(fault(start, |_, p| [p.x_m + 1.5, p.y_m]), None);
        assert_eq!(fault(start, |_, _| [4.5, 3.0]), None);
        // Lost, each trial elsewhere.
        let lost = |t: usize, p: &Pose| [[9.0, 0.0], [0.0, 6.0]][t % 2].map(|m| m + 0.1 * p.x_m);
        assert_eq!(fault(start, lost), None);
    }
}

#[test]
fn another_frame_is_named_with_its_turn_and_shift() {
    for start in ["known", "unknown"] {
        let turned = fault(start, |_, p| [20.0 - p.y_m, 10.0 + p.x_m]).unwrap();
        assert!(
            turned.contains("in another frame: turned by -90.0°"),
            "{turned}"
        );
        let shifted = fault(start, |_, p| [p.x_m + 30.0, p.y_m]).unwrap();
        assert!(shifted.contains("shifted by (-30.00, 0.00) m"), "{shifted}");
    }
    let far = fault("known", |_, p| [p.x_m * 1000.0, p.y_m]).unwrap();
    assert!(
        far.starts_with("known-001: its answer to snapshot") && far.contains("metres in the frame"),
        "{far}"
    );
    let first = |t: usize, p: &Pose| {
        let begun = test_world().poses()[104 + 12 * t];
        [p.x_m - begun.x_m, p.y_m - begun.y_m]
    };
    let own = fault("unknown", first).unwrap();
    assert!(
        own.contains("the answers to all 6 trials begin at (0, 0)"),
        "{own}"
    );
    let told = fault("known", first).unwrap();
    assert!(told.contains("begin at (0, 0)"), "{told}");
}

/// Programs that have no idea yet often say (0, 0) at first.
#[test]
fn a_first_guess_at_the_origin_is_no_frame() {
    let guess = |t: usize, p: &Pose| match *p == test_world().poses()[104 + 12 * t] {
        true => [0.0, 0.0],
        false => [p.x_m, p.y_m],
    };
    assert_eq!(fault("unknown", guess), None);
}
