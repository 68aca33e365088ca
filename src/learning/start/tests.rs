use super::*;
use crate::{
    detector::input::InputConfig,
    geometry::Pose,
    recording::{Columns, Recording},
    seed::Seed,
};
use ndarray::Array2;

fn recording(beams: usize, view_deg: f64) -> Recording {
    let bearing_rad = |b: usize| (view_deg * (b as f64 / (beams - 1) as f64 - 0.5)).to_radians();
    let k = 4;
    Recording::new(Columns {
        channels: vec![Channel {
            name: "laser".into(),
            width: beams,
            unit: "m".into(),
            bearing_rad: Some((0..beams).map(bearing_rad).collect()),
            maximum: None,
            offset_m: None,
        }],
        values: Array2::from_shape_fn((k, beams), |(k, b)| 1.0 + 0.1 * (k * 7 + b * 3 % 11) as f32),
        stamp_s: (0..k).map(|k| k as f64).collect(),
        pose: vec![Pose::default(); k],
        odometry: vec![Pose::default(); k],
        run: vec![0; k],
        ..Columns::default()
    })
    .unwrap()
}

fn fitted(recording: &Recording) -> Input {
    Input::fit(&InputConfig::far(), recording, &[0, 1, 2, 3]).unwrap()
}

fn random(features: usize, seed: u64, input: &Input) -> Weights {
    let network = Recipe::default().network;
    let mut random = Seed(seed).stream("weights");
    Weights::random(&network, input.shape(), features, &mut random)
}

fn start() -> Start {
    let recording = recording(180, 179.0);
    let input = fitted(&recording);
    Start {
        weights: random(8, 1, &input),
        channels: recording.channels().to_vec(),
        input,
        same_sensors: false,
    }
}

#[test]
fn constants_are_those_that_the_networks_learned_with() {
    let (start, other) = (start(), recording(360, 179.5));
    let own = fitted(&other);
    assert_ne!(own.mean, start.input.mean);
    let input = start.input_for(own, other.channels()).unwrap();
    assert_eq!(
        (&input.mean, &input.deviation),
        (&start.input.mean, &start.input.deviation)
    );
    assert!(input.transform(&other).is_ok()); // 360 beams into the same sectors
}

#[test]
fn other_sensors_are_refused() {
    let refused = |other: &Recording| {
        let fault = start()
            .input_for(fitted(other), other.channels())
            .unwrap_err();
        fault.to_string()
    };
    assert!(
        refused(&recording(180, 270.0))
            .contains("over 179°, these sensors give laser (180) over 270°")
    );
    assert!(refused(&recording(3, 170.0)).contains("laser (3)"));
    assert!(refused(&recording(40, 60.0)).contains("laser (40) over 60°")); // a third of the sectors
    let mut unknown = recording(180, 179.0).into_columns();
    unknown.channels[0].bearing_rad = None;
    let unknown = Recording::new(unknown).unwrap();
    assert!(refused(&unknown).contains("in unknown directions"));
}

#[test]
fn fewer_beams_stand_in_for_their_sectors() {
    let (start, other) = (start(), recording(12, 165.0));
    let own = fitted(&other);
    assert_ne!(own.shape(), start.input.shape());
    let input = start.input_for(own, other.channels()).unwrap();
    assert_eq!(input.shape(), start.input.shape());
    assert!(input.check().is_ok());
    let values = input.transform(&other).unwrap();
    // Beam by beam three sectors, and of one beam all statistics are that beam.
    let raw = |k: usize| values[(0, k)] * input.deviation[k] + input.mean[k];
    for sector in 0..36 {
        let reading = other.values()[(0, sector / 3)];
        for statistic in 0..3 {
            assert!((raw(36 * statistic + sector) - reading).abs() < 1e-4);
        }
    }
    // The same from a file.
    let text = serde_json::to_string(&input).unwrap();
    let mut read: Input = serde_json::from_str(&text).unwrap();
    (read.mean, read.deviation) = (input.mean.clone(), input.deviation.clone());
    assert_eq!(read, input);
}

#[test]
fn another_number_of_features_keeps_what_is_shared() {
    let start = start();
    let recipe = Recipe::default();
    let same = start
        .weights_for(&recipe, random(8, 2, &start.input))
        .unwrap();
    let last = same.layers.last().unwrap().weight.clone() * recipe.network.gain;
    let off = (last - &start.weights.layers.last().unwrap().weight).mapv(f32::abs);
    assert!(off.into_iter().all(|off| off < 1e-6));
    let fewer = random(3, 2, &start.input);
    let found = start.weights_for(&recipe, fewer.clone()).unwrap();
    let shared = found.trunk;
    assert_eq!(found.layers[..shared], start.weights.layers[..shared]);
    assert_eq!(found.layers[shared..], fewer.layers[shared..]);
    let mut other = random(8, 2, &start.input);
    other.layers.remove(0);
    assert!(start.weights_for(&recipe, other).is_err());
}

/// Whatever its sensors are: those of a model's own recording make its own inputs.
#[test]
fn the_same_sensors_make_the_same_inputs() {
    let start = Start {
        same_sensors: true,
        ..start()
    };
    let narrow = recording(90, 45.0);
    let other = fitted(&narrow);
    assert_ne!(other, start.input);
    assert_eq!(
        start.input_for(other, narrow.channels()).unwrap(),
        start.input
    );
}
