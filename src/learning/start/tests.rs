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
    assert!(refused(&recording(180, 270.0)).contains("see 179°, this sensor 270°"));
    assert!(refused(&recording(12, 179.0)).contains("laser (12)"));
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
