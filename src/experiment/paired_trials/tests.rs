//! Every other against the first, trial by trial.

use super::*;

/// Two trials of 12 m in each of so many stretches.
fn trials(units: usize) -> Vec<Trial> {
    let of = |k: usize| Trial {
        stretch: k / 2,
        unit: k / 2,
        snapshots: (0..25).collect(),
        travelled_m: (0..25).map(|i| f64::from(i) * 0.5).collect(),
    };
    (0..2 * units).map(of).collect()
}

fn tested(methods: &[TrialFigures], trials: &[Trial]) -> Vec<PairedTest> {
    let named: Vec<(&str, &TrialFigures)> = ["a", "b", "c"].into_iter().zip(methods).collect();
    let unit_of: Vec<usize> = trials.iter().map(|trial| trial.unit).collect();
    paired_tests(&named, &unit_of, 200, Seed(1))
}

/// Always so far off; sure or never.
fn method(trials: &[Trial], point_m: f64, expected_m: f64) -> TrialFigures {
    let answers = Answers {
        expected_error_m: vec![expected_m; 25],
        point_error_m: vec![point_m; 25],
        ..Answers::default()
    };
    TrialFigures::new(trials, &vec![answers; trials.len()], 0.5)
}

#[test]
fn every_other_is_tested_against_the_first_and_corrected() {
    let trials = trials(6);
    let all = [
        method(&trials, 0.5, 0.1),
        method(&trials, 0.75, 0.1),
        method(&trials, 0.5, 9.0),
    ];
    let tests = tested(&all, &trials);
    assert_eq!(tests.len(), 2);
    let [b, c] = [&tests[0], &tests[1]];
    assert_eq!((&*b.name, &*b.against), ("b", "a"));
    // Worse in all six stretches: two of 64 ways are as far; twice that, of two tests.
    assert_eq!(b.error_difference_m, Some(0.25));
    assert_eq!((b.p, b.p_holm), (Some(2.0 / 64.0), Some(4.0 / 64.0)));
    assert_eq!((b.found_difference, b.p_found), (Some(0.0), Some(1.0)));
    assert_eq!(b.error_difference_m_ci95, Some([0.25, 0.25]));
    assert_eq!((b.trials, b.units), (12, 6));
    assert_eq!((c.error_difference_m, c.p), (Some(0.0), Some(1.0)));
    // Who is never found counts with the trial's length.
    assert_eq!(
        (c.distance_difference_m, c.p_distance),
        (Some(12.0), Some(2.0 / 64.0))
    );
    assert_eq!(
        (b.distance_difference_m, b.p_distance_holm),
        (Some(0.0), Some(1.0))
    );
    assert_eq!(
        (c.found_difference, c.p_found),
        (Some(-1.0), Some(2.0 / 64.0))
    );
    assert_eq!(
        (c.p_found_holm, b.p_found_holm),
        (Some(4.0 / 64.0), Some(1.0))
    );
}

#[test]
fn few_trials_or_one_unit_have_no_p_and_short_trials_no_error() {
    let mut one_unit = trials(6);
    one_unit.iter_mut().for_each(|trial| trial.unit = 0);
    for trials in [trials(4), one_unit] {
        let all = [method(&trials, 0.5, 0.1), method(&trials, 1.0, 0.1)];
        let tests = tested(&all, &trials);
        assert_eq!(tests[0].error_difference_m, Some(0.5));
        assert_eq!(
            (tests[0].p, tests[0].p_holm, tests[0].p_found),
            (None, None, None)
        );
    }
    let mut short = trials(6);
    short
        .iter_mut()
        .for_each(|trial| trial.travelled_m.truncate(15)); // 7 m
    let all = [method(&short, 0.5, 0.1), method(&short, 1.0, 0.1)];
    let tests = tested(&all, &short);
    assert_eq!((tests[0].error_difference_m, tests[0].p), (None, None));
    assert_eq!(tests[0].found_difference, Some(0.0));
    assert!(tested(&[], &short).is_empty());
}

/// Of two tests over six stretches no corrected p is below 2 · 2/64 = .0625; over seven it can be 2 · 2/128 = .03125.
#[test]
fn too_few_stretches_for_a_small_p_are_noted() {
    let of_stretches = |units: usize, long: usize| {
        let mut trials = trials(units);
        let short = trials.iter_mut().skip(2 * long);
        short.for_each(|trial| trial.travelled_m.truncate(15)); // 7 m
        let all = [0.5; 3].map(|point_m| method(&trials, point_m, 0.1));
        tested(&all, &trials).remove(0)
    };
    let six = of_stretches(6, 6);
    assert_eq!(six.least_p_found_holm, Some(0.0625));
    assert!(six.is_too_few());
    let note = "too few runs or stretches for any corrected p below 0.05";
    assert_eq!(six.note.as_deref(), Some(note));
    let seven = of_stretches(7, 7);
    let least = (seven.least_p_holm, seven.least_p_found_holm);
    assert_eq!(least, (Some(0.03125), Some(0.03125)));
    assert!(seven.note.is_none() && !seven.is_too_few());
    // Trials of 10 m in six of seven stretches alone.
    let mixed = of_stretches(7, 6);
    let least = (mixed.least_p_holm, mixed.least_p_found_holm);
    assert_eq!(least, (Some(0.0625), Some(0.03125)));
    let note = "too few runs or stretches for a corrected p of error_difference_m below 0.05";
    assert_eq!(mixed.note.as_deref(), Some(note));
    // Too few for any p.
    let four = of_stretches(2, 2);
    assert_eq!((four.p_found, four.least_p_found_holm), (None, None));
    assert!(four.note.is_some());
    assert_eq!(least_p(15), 1.0 / 10_001.0);
    assert_eq!(least_p(3), sign_flip_p(&[1.0, 2.0, 3.0], Seed(1)));
}

/// ±4 ±1 ±2 is at least as far from 0 as 4 + 1 − 2 in six of eight ways: 7, 3 and 5, and their negatives.
#[test]
fn ways_to_flip_signs_by_hand() {
    assert_eq!(sign_flip_p(&[4.0, 1.0, -2.0], Seed(1)), 0.75);
    // Of fifteen units eleven on one side: 2 · P(Binomial(15, ½) ≥ 11) = 2 · 1941/32768, from drawn ways nearly.
    let sums: Vec<f64> = (0..15).map(|u| if u < 11 { 1.0 } else { -1.0 }).collect();
    let p = sign_flip_p(&sums, Seed(3));
    assert!((p - 2.0 * 1941.0 / 32768.0).abs() < 0.01, "{p}");
}
