use super::*;
use crate::recording::{Columns, Observation};
use ndarray::Array2;

/// Snapshots at poses, each with a sonar and an infrared ring of four that see what is given; turned to north unless `compass` is
/// missing.
fn recording(poses: &[Pose], sees: impl Fn(usize) -> [f32; 8], compass: bool) -> Recording {
    let ring = |name: &str| Channel {
        name: name.into(),
        width: 4,
        unit: "m".into(),
        bearing_rad: Some((0..4).map(|i| f64::from(i) * PI / 2.0).collect()),
        maximum: Some(5.0),
        offset_m: None,
    };
    let k = poses.len();
    Recording::new(Columns {
        channels: vec![ring("sonar"), ring("infrared")],
        values: Array2::from_shape_fn((k, 8), |(k, i)| sees(k)[i]),
        stamp_s: (0..k).map(|k| k as f64).collect(),
        odometry: poses.to_vec(),
        pose: poses.to_vec(),
        run: vec![0; k],
        compass_rad: compass.then(|| vec![0.0; k]),
        ..Columns::default()
    })
    .unwrap()
}

fn build(recording: &Recording) -> PlaceMap {
    let all: Vec<usize> = (0..recording.len()).collect();
    PlaceMap::build(&PlaceMapConfig::default(), recording, &all).unwrap()
}

fn along(x_m: impl Iterator<Item = f64>) -> Vec<Pose> {
    x_m.map(|x_m| Pose::new(x_m, 0.0, 0.0)).collect()
}

const ALIKE: [f32; 8] = [1.0; 8];

#[test]
fn straight_ahead_a_place_is_entered_every_2_d_and_the_way_back_adds_next_to_none() {
    let there = (0..=5900).map(|i| f64::from(i) * 0.001);
    let map = build(&recording(&along(there.clone()), |_| ALIKE, true));
    assert_eq!(map.places().len(), 8); // of 0.75 m each
    for (m, pair) in map.places().windows(2).enumerate() {
        let apart = pair[0].pose.distance_m(&pair[1].pose);
        assert!(apart <= 0.75 + 1e-9 && apart > 0.7, "{m}: {apart}");
    }
    let first = &map.places()[0];
    assert!((first.pose.x_m - 0.375).abs() < 0.01, "{first:?}");
    assert!(first.signature.iter().all(|v| (v - 0.5).abs() < 1e-6));
    let poses = along(there.clone().chain(there.rev()));
    let both = build(&recording(&poses, |_| ALIKE, true));
    assert!(both.places().len() <= 9, "{}", both.places().len());
}

#[test]
fn a_change_by_more_than_t_starts_a_place_and_only_the_current_one_is_asked() {
    // Sonars and infrared see one thing each, at 1 m and at 2 m another: 2√2 from what they saw.
    let corner = |of: usize| -> [f32; 8] { std::array::from_fn(|i| f32::from(i % 4 == of)) };
    let poses = along((0..4).map(|i| 0.05 * f64::from(i)));
    let seen = [corner(0), corner(0), corner(1), corner(1)];
    let map = build(&recording(&poses, |k| seen[k], true));
    assert_eq!(map.places().len(), 2);
    assert!((map.places()[1].pose.x_m - 0.125).abs() < 1e-12);
    // One channel alone differs by √2 at most: no new place.
    let half =
        |k: usize| -> [f32; 8] { std::array::from_fn(|i| if i < 4 { seen[k][i] } else { 1.0 }) };
    let one = build(&recording(&poses, half, true));
    assert_eq!(one.places().len(), 1);
    let signature = &one.places()[0].signature;
    // The mean of two unit vectors at a right angle, at length 1 again.
    let expected = [0.5f32.sqrt(), 0.5f32.sqrt(), 0.0, 0.0, 0.5, 0.5, 0.5, 0.5];
    assert!(
        signature
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-6),
        "{signature:?}"
    );
    // Back beside the first place, 0.05 m from it and 0.075 m from the second, it is the first that is asked.
    let poses = [poses.clone(), along([0.03].into_iter())].concat();
    let seen = [seen.to_vec(), vec![corner(0)]].concat();
    assert_eq!(
        build(&recording(&poses, |k| seen[k], true)).places().len(),
        2
    );
}

#[test]
fn without_a_compass_the_other_side_is_another_place_and_headings_are_averaged() {
    let poses: Vec<Pose> = [3.1, -3.1, 0.0, 0.2]
        .map(|h| Pose::new(1.0, 2.0, h))
        .to_vec();
    let map = build(&recording(&poses, |_| ALIKE, false));
    assert!(map.is_oriented());
    assert_eq!(map.places().len(), 2);
    assert!((map.places()[0].pose.heading_rad.abs() - PI).abs() < 1e-9);
    assert!((map.places()[1].pose.heading_rad - 0.1).abs() < 1e-9);
    let with_compass = build(&recording(&poses, |_| ALIKE, true));
    assert!(!with_compass.is_oriented() && with_compass.places().len() == 1);
}

#[test]
fn weights_count_in_eq_1_and_name_channels_that_there_are() {
    let recording = recording(&along([0.0].into_iter()), |_| ALIKE, true);
    let mut config = PlaceMapConfig::default();
    config.weights.insert("infrared".into(), 3.0);
    let map = PlaceMap::build(&config, &recording, &[0]).unwrap();
    let corner = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    // ‖(1, 0, 0, 0) − (½, ½, ½, ½)‖ = 1
    let d = map.difference(&map.places()[0].signature, &corner);
    assert!((d - 4.0).abs() < 1e-6, "{d}");
    assert_eq!(map.differences(&corner), [4.0]);
    config.weights.insert("radar".into(), 1.0);
    let error = PlaceMap::build(&config, &recording, &[0]).unwrap_err();
    assert!(
        error.is_usage() && error.to_string().contains("sonar, infrared"),
        "{error}"
    );
}

#[test]
fn a_snapshot_without_the_sensors_looks_like_nothing() {
    let recording = recording(&along([0.0].into_iter()), |_| ALIKE, true);
    let map = build(&recording);
    let observation: Observation = recording.observation(0);
    assert_eq!(
        map.signature(&recording.channels()[..1], &observation),
        None
    );
    assert_eq!(map.nearest_in_signature(&[]), None);
    assert_eq!(map.nearest_in_signature(&[2.0, 1.0, 1.0]), Some(1));
}
