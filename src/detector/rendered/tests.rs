use super::*;
use crate::{
    detector::input::InputConfig,
    mapping::Occupancy,
    recording::{Columns, Recording},
};
use std::f64::consts::TAU;

const CELL_M: f64 = 0.05;

fn laser(beams: usize) -> Channel {
    Channel {
        name: "laser".into(),
        width: beams,
        unit: "m".into(),
        bearing_rad: Some((0..beams).map(|b| TAU * b as f64 / beams as f64).collect()),
        maximum: None,
        offset_m: None,
    }
}

/// A room of 6 × 4 m, its east wall open for what nobody has seen.
fn room() -> SensedMap {
    let (width, height) = (120, 80);
    let cell = |k: usize| {
        let (column, row) = (k % width, k / width);
        match (column, row) {
            (0, _) | (_, 0) | (_, 79) => Occupancy::Occupied,
            (110.., 30..50) => Occupancy::Unknown,
            (119, _) => Occupancy::Occupied,
            _ => Occupancy::Free,
        }
    };
    let cells = (0..width * height).map(cell).collect();
    SensedMap {
        map: OccupancyMap::from_cells(CELL_M, [0.0, 0.0], width, cells).unwrap(),
        sensors: RangeSensors::default(),
    }
}

fn recording(channels: Vec<Channel>, values: Array2<f32>) -> Recording {
    let k = values.nrows();
    Recording::new(Columns {
        channels,
        values,
        stamp_s: (0..k).map(|k| k as f64).collect(),
        pose: vec![Pose::new(3.0, 2.0, 0.0); k],
        odometry: vec![Pose::default(); k],
        run: vec![0; k],
        ..Columns::default()
    })
    .unwrap()
}

/// Inputs that are the four ranges, ahead, left, behind and right, less a mean and over a deviation.
fn input() -> Input {
    let values = ndarray::array![[1.0, 2.0, 3.0, 4.0], [2.0, 3.0, 4.0, 6.0]];
    let recording = recording(vec![laser(4)], values);
    Input::fit(&InputConfig::default(), &recording, &[0, 1]).unwrap()
}

#[test]
fn inputs_are_those_of_what_would_be_seen() {
    let (input, channels) = (input(), [laser(4)]);
    let rendered = RenderedInputs::new(&room(), &channels, &input).unwrap();
    // In the south-west, looking east and looking north, many times over so that more than one lot is rendered.
    let east = Pose::new(2.0, 1.0, 0.0);
    let north = Pose::new(2.0, 1.0, TAU / 4.0);
    let poses: Vec<Pose> = [east, north]
        .into_iter()
        .cycle()
        .take(2 * AT_ONCE + 2)
        .collect();
    let at = rendered.at(&poses).unwrap();
    let seen = ndarray::array![
        [3.975, 2.975, 1.975, 0.975],
        [2.975, 1.975, 0.975, 3.975_f32]
    ];
    let expected = input.transform_values(&channels, seen.view()).unwrap();
    for k in [0, 1, 2 * AT_ONCE, 2 * AT_ONCE + 1] {
        for (found, expected) in at.values.row(k).iter().zip(expected.row(k % 2)) {
            assert!((found - expected).abs() < 0.05, "{k}: {found} {expected}");
        }
        assert!(at.seen[k]);
    }
}

#[test]
fn what_nobody_knows_reads_as_far_as_it_was_followed_and_is_not_seen() {
    let (input, channels) = (input(), [laser(4)]);
    let rendered = RenderedInputs::new(&room(), &channels, &input).unwrap();
    let at = rendered
        .at(&[
            Pose::new(3.0, 2.0, 0.0),   // east of it nobody knows what is beyond 5.5 m
            Pose::new(0.01, 2.0, 0.0),  // in the wall
            Pose::new(90.0, 90.0, 0.0), // off the map
        ])
        .unwrap();
    let expected = input
        .transform_values(
            &channels,
            ndarray::array![[2.5, 1.975, 2.975, 1.975]].view(),
        )
        .unwrap();
    assert!((at.values[[0, 0]] - expected[[0, 0]]).abs() < 0.05);
    assert_eq!(at.seen, [true, false, false]);
}

#[test]
fn what_is_no_range_is_refused() {
    let light = Channel {
        name: "light".into(),
        width: 1,
        unit: "lux".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    let channels = vec![laser(4), light];
    let values = ndarray::array![[1.0, 2.0, 3.0, 4.0, 5.0], [2.0, 3.0, 4.0, 6.0, 9.0]];
    let recording = recording(channels.clone(), values);
    let input = Input::fit(&InputConfig::default(), &recording, &[0, 1]).unwrap();
    let fault = RenderedInputs::new(&room(), &channels, &input).unwrap_err();
    let fault = fault.to_string();
    assert!(fault.contains("4 of 5 readings"), "{fault}");
    // Left aside it does no harm.
    let only = InputConfig {
        channels: vec!["laser".into()],
        ..InputConfig::default()
    };
    let input = Input::fit(&only, &recording, &[0, 1]).unwrap();
    assert!(RenderedInputs::new(&room(), &channels, &input).is_ok());
}
