use super::*;
use crate::{
    localiser::{Learn, evidence_based::EvidenceBasedConfig},
    recording::{Columns, Recording},
    seed::Seed,
};
use ndarray::Array2;
use std::f64::consts::FRAC_PI_2;

/// A corridor to the north-east, a snapshot every tenth of a metre; two rings of four that face north and see what is given.
fn corridor(length_m: f64, sees: impl Fn(f64) -> [f32; 8]) -> Recording {
    let k = (10.0 * length_m) as usize + 1;
    let ring = |name: &str| Channel {
        name: name.into(),
        width: 4,
        unit: "m".into(),
        bearing_rad: Some((0..4).map(|i| f64::from(i) * FRAC_PI_2).collect()),
        maximum: Some(5.0),
        offset_m: None,
    };
    let way = |k: usize| 0.1 * k as f64;
    let pose = |k: usize| Pose::new(0.6 * way(k), 0.8 * way(k), FRAC_PI_2);
    // Odometry that started elsewhere and lost a right angle on the way: only the compass knows north.
    let astray = Pose::new(50.0, -3.0, 2.0);
    let odometry = |k: usize| {
        let moved = pose(0).displacement_to(&pose(k));
        astray.after(moved)
    };
    Recording::new(Columns {
        channels: vec![ring("sonar"), ring("infrared")],
        values: Array2::from_shape_fn((k, 8), |(k, i)| sees(way(k))[i]),
        stamp_s: (0..k).map(|k| k as f64).collect(),
        pose: (0..k).map(pose).collect(),
        odometry: (0..k).map(odometry).collect(),
        run: vec![0; k],
        compass_rad: Some(vec![FRAC_PI_2; k]),
        ..Columns::default()
    })
    .unwrap()
}

fn learned(recording: &Recording, config: &EvidenceBasedConfig) -> EvidenceBased {
    let all: Vec<usize> = (0..recording.len()).collect();
    EvidenceBased::learn(config, recording, &all, Seed(1)).unwrap()
}

/// What both rings see where reading `of` alone is not 0.
fn corner(of: usize) -> [f32; 8] {
    std::array::from_fn(|i| f32::from(i % 4 == of))
}

fn ties() -> Stream {
    Seed(1).stream("ties")
}

#[test]
fn gains_are_those_of_the_kalman_filter_whatever_the_first_variance() {
    let at = |x_m: f64, variance: f64| Hypothesis {
        place: 0,
        pose: Pose::new(x_m, 0.0, 0.0),
        variance,
        log_probability: 0.0,
    };
    for first in [1.0, 0.01, 7.5] {
        let (mut old, mut gains) = (at(0.0, first), Vec::new());
        for _ in 0..600 {
            old.variance *= 1.05;
            // The place on the map is 1 m ahead of what was reckoned, so the correction is the gain.
            old = Hypothesis {
                pose: Pose::default(),
                ..old
            };
            old = corrected(&at(1.0, first), &old);
            gains.push(old.pose.x_m);
        }
        for (gain, expected) in gains.iter().zip([0.512195, 0.349722, 0.268583, 0.219976]) {
            assert!((gain - expected).abs() < 5e-7, "{gain}");
        }
        assert!((gains[599] - 1.0 / 21.0).abs() < 1e-9);
    }
}

#[test]
fn two_steps_by_hand() {
    // Four places of 0.7 m; the first and third look alike, the second a little like them, the fourth like nothing else.
    let recording = corridor(2.7, |at| match (10.0 * at).round() as usize / 7 {
        0 | 2 => corner(0),
        1 => [5.0, 4.0, 0.0, 0.0, 5.0, 4.0, 0.0, 0.0],
        _ => corner(2),
    });
    let evidence = learned(&recording, &EvidenceBasedConfig::default());
    let places = evidence.map().places().to_vec();
    assert_eq!(places.len(), 4, "{places:?}");
    let mut robot = Hypotheses::none(&evidence);
    let mut see =
        |k: usize| robot.observe(recording.channels(), &recording.observation(k), &mut ties());

    // At the start places 0 and 2 fit, and place 1 a little; 3 is 2√2 away.
    let first = see(0);
    assert_eq!(first.estimate, Some(Estimate::Class(0)));
    assert_eq!(first.posterior.len(), 3);
    let d: Vec<f64> = places
        .iter()
        .map(|p| {
            evidence
                .map()
                .difference(&p.signature, &places[0].signature)
        })
        .collect();
    let likelihood = |d: f64| (-(d / 1.5).powi(2)).exp();
    let sum: f64 = d[..3].iter().map(|&d| likelihood(d)).sum();
    for (m, (at, p)) in first.posterior.iter().enumerate() {
        assert!((p - likelihood(d[m]) / sum).abs() < 1e-6, "{m}: {p}"); // eq. 3
        assert!((at[0] - places[m].pose.x_m).abs() < 1e-9);
    }

    // Seven decimetres on, still the same iteration: hypotheses move, the answer stays.
    for k in 1..8 {
        let step = see(k);
        assert_eq!(step.estimate, Some(Estimate::Class(0)));
        for (now, before) in step.posterior.iter().zip(&first.posterior) {
            let moved = [now.0[0] - before.0[0], now.0[1] - before.0[1]];
            let way = 0.1 * k as f64;
            assert!((moved[0] - 0.6 * way).abs() < 1e-9 && (moved[1] - 0.8 * way).abs() < 1e-9);
            assert_eq!(now.1, before.1);
        }
    }

    // Eight: the second place is entered, and it was the first that the robot came from.
    let second = see(8);
    assert_eq!(second.estimate, Some(Estimate::Class(1)));
    let signature = evidence
        .map()
        .signature(recording.channels(), &recording.observation(8))
        .unwrap();
    let d = evidence.map().differences(&signature);
    let reckoned: Vec<[f64; 2]> = first
        .posterior
        .iter()
        .map(|(at, _)| [at[0] + 0.48, at[1] + 0.64])
        .collect();
    let eval = |j: usize, i: usize| {
        let (dx, dy) = (
            places[j].pose.x_m - reckoned[i][0],
            places[j].pose.y_m - reckoned[i][1],
        );
        (-(dx * dx + dy * dy) / 1.5f64.powi(2)).exp() * first.posterior[i].1 // eq. 7, w_pr = 4D = 1.5 m
    };
    let candidates: Vec<usize> = (0..4).filter(|&j| d[j] < 1.5).collect();
    let best = |j: usize| {
        (0..3)
            .max_by(|&a, &b| eval(j, a).total_cmp(&eval(j, b)))
            .unwrap()
    };
    let posterior: Vec<f64> = candidates
        .iter()
        .map(|&j| likelihood(f64::from(d[j])) * eval(j, best(j))) // eq. 9, 10
        .collect();
    let sum: f64 = posterior.iter().sum();
    assert_eq!(second.posterior.len(), candidates.len());
    for ((&j, p), (at, found)) in candidates.iter().zip(&posterior).zip(&second.posterior) {
        assert!((found - p / sum).abs() < 1e-6);
        let from = reckoned[best(j)];
        let expected = from[0] + (1.05 / 2.05) * (places[j].pose.x_m - from[0]); // eq. 11
        assert!((at[0] - expected).abs() < 1e-9, "{j}: {at:?} {expected}");
    }
}

#[test]
fn what_looks_like_no_place_has_no_answer_until_something_does() {
    let recording = corridor(4.0, |at| if at < 2.0 { corner(0) } else { corner(1) });
    let half: Vec<usize> = (0..18).collect();
    let evidence =
        EvidenceBased::learn(&EvidenceBasedConfig::default(), &recording, &half, Seed(1)).unwrap();
    let mut robot = Hypotheses::none(&evidence);
    let mut see =
        |k: usize| robot.observe(recording.channels(), &recording.observation(k), &mut ties());
    assert_eq!(see(25), Step::default()); // nothing known, nothing seen that is
    for k in 0..20 {
        assert!(see(k).estimate.is_some());
    }
    let before = see(19).posterior;
    // The readings change by more than T at 2 m, so an iteration is due at once, and finds nothing.
    let lost = see(20);
    assert_eq!(lost.estimate, None);
    let moved = |after: &Step| after.posterior[0].0[0] - before[0].0[0];
    assert!((moved(&lost) - 0.06).abs() < 1e-9 && lost.posterior[0].1 == before[0].1);
    assert!((moved(&see(25)) - 0.36).abs() < 1e-9);
    assert!(see(17).estimate.is_some());
}

#[test]
fn a_set_that_was_led_astray_finds_back() {
    let recording = corridor(6.0, |_| corner(0));
    let evidence = learned(&recording, &EvidenceBasedConfig::default());
    let mut robot = Hypotheses::none(&evidence);
    robot.observe(recording.channels(), &recording.observation(0), &mut ties());
    // A slip of a kilometre: every term of eq. 9 is far below the smallest number.
    let mut slipped = recording.observation(30);
    slipped.odometry.x_m += 1000.0;
    let step = robot.observe(recording.channels(), &slipped, &mut ties());
    let sum: f64 = step.posterior.iter().map(|(_, p)| p).sum();
    assert!(step.estimate.is_some() && (sum - 1.0).abs() < 1e-9);
    // One that can't even be compared: what is seen decides alone.
    slipped.odometry.x_m = f64::MAX;
    let step = robot.observe(recording.channels(), &slipped, &mut ties());
    assert!(
        step.posterior
            .iter()
            .all(|(at, p)| at[0].abs() < 10.0 && p.is_finite())
    );
}

#[test]
fn without_a_compass_headings_tell_the_way_there_from_the_way_back() {
    // There and back along one line, and nothing to be seen but which end is which.
    let there = corridor(6.0, |at| match at {
        at if at < 1.0 => corner(1),
        at if at < 5.0 => corner(0),
        _ => corner(2),
    });
    let mut columns = there.into_columns();
    columns.compass_rad = None;
    let k = columns.pose.len();
    let back = |pose: &Pose| {
        Pose::new(
            pose.x_m,
            pose.y_m,
            wrapped(pose.heading_rad + std::f64::consts::PI),
        )
    };
    for i in (0..k).rev() {
        let pose = back(&columns.pose[i]);
        columns.pose.push(pose);
        let odometry = back(&columns.odometry[i]);
        columns.odometry.push(odometry);
        columns.stamp_s.push(columns.stamp_s.len() as f64);
        columns.run.push(0);
    }
    let rows: Vec<usize> = (0..k).chain((0..k).rev()).collect();
    columns.values = columns.values.select(ndarray::Axis(0), &rows);
    let recording = Recording::new(columns).unwrap();
    let evidence = learned(&recording, &EvidenceBasedConfig::default());
    assert!(evidence.map().is_oriented());
    for trial in [5..55, k + 5..k + 55] {
        let mut robot = Hypotheses::none(&evidence);
        let end = trial.end - 1;
        let steps: Vec<Step> = trial
            .map(|k| robot.observe(recording.channels(), &recording.observation(k), &mut ties()))
            .collect();
        let Some(Estimate::Class(place)) = steps[steps.len() - 1].estimate else {
            panic!("no answer");
        };
        let (place, truth) = (
            &evidence.map().places()[place].pose,
            &recording.poses()[end],
        );
        assert!(
            place.turn_rad(truth) < 0.1 && place.distance_m(truth) < 0.8,
            "{place:?} {truth:?}"
        );
        let sure = robot
            .set()
            .iter()
            .map(Hypothesis::probability)
            .fold(0.0, f64::max);
        assert!(sure > 0.3, "{sure}");
    }
}
