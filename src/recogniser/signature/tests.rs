use super::*;
use crate::geometry::Pose;
use crate::recording::Columns;
use ndarray::Array2;

/// One snapshot of a ring of sonars, and of a bumper that is no range.
fn ring(readings: &[f32], compass_rad: Option<f64>) -> Recording {
    let n = readings.len();
    let bearing = |i: usize| TAU * i as f64 / n as f64;
    let sonar = Channel {
        name: "sonar".into(),
        width: n,
        unit: "m".into(),
        bearing_rad: Some((0..n).map(bearing).collect()),
        maximum: None,
        offset_m: None,
    };
    let bumper = Channel {
        name: "bumper".into(),
        width: 1,
        unit: "1".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    let values = readings.iter().copied().chain([-7.0]).collect();
    Recording::new(Columns {
        channels: vec![sonar, bumper],
        values: Array2::from_shape_vec((1, n + 1), values).unwrap(),
        stamp_s: vec![0.0],
        pose: vec![Pose::default()],
        odometry: vec![Pose::default()],
        run: vec![0],
        compass_rad: compass_rad.map(|c| vec![c]),
        ..Columns::default()
    })
    .unwrap()
}

fn of(recording: &Recording, config: &SignatureConfig) -> Vec<f32> {
    let layout = Layout::fit(config, recording, &[0]).unwrap();
    layout.check().unwrap();
    layout
        .of(recording.channels(), &recording.observation(0))
        .unwrap()
}

#[test]
fn a_turned_robot_with_a_compass_has_the_same_signature() {
    // The long reading looks north (90°) in both: ahead of a robot that faces it, to the left of one that faces east.
    let north = ring(&[3.0, 1.0, 1.5, 2.0], Some(TAU / 4.0));
    let east = ring(&[2.0, 3.0, 1.0, 1.5], Some(0.0));
    let config = SignatureConfig::default();
    assert_eq!(of(&north, &config), of(&east, &config));
    assert!(of(&north, &config)[1] > of(&north, &config)[0]);
    let as_read = SignatureConfig {
        compass: false,
        ..SignatureConfig::default()
    };
    assert_ne!(of(&north, &as_read), of(&east, &as_read));
    let odd = ring(&[3.0, 1.0, 1.5, 2.0], Some(f64::from(f32::MAX)));
    assert_eq!(of(&odd, &config).len(), 4);
}

#[test]
fn channels_are_ranges_unless_named_and_missing_returns_are_the_largest_reading() {
    let one = ring(&[3.0, f32::NAN, 4.0, f32::INFINITY], None);
    let length = (9.0f32 + 16.0 * 3.0).sqrt();
    let expected = [3.0 / length, 4.0 / length, 4.0 / length, 4.0 / length];
    let found = of(&one, &SignatureConfig::default());
    assert!(
        found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a - b).abs() < 1e-6)
    );
    let bumper = SignatureConfig {
        channels: vec!["bumper".into()],
        ..SignatureConfig::default()
    };
    assert_eq!(of(&one, &bumper), [-1.0]);
    let wrong = SignatureConfig {
        channels: vec!["radar".into()],
        ..SignatureConfig::default()
    };
    let error = Layout::fit(&wrong, &one, &[0]).unwrap_err().to_string();
    assert!(
        error.contains("`radar`") && error.contains("`sonar` (4 values)"),
        "{error}"
    );
}

#[test]
fn other_sensors_are_told_and_silent() {
    let (four, five) = (ring(&[1.0; 4], None), ring(&[1.0; 5], None));
    let layout = Layout::fit(&SignatureConfig::default(), &four, &[0]).unwrap();
    let error = layout.check_channels(five.channels()).unwrap_err();
    assert!(error.to_string().contains("5 values"), "{error}");
    assert_eq!(layout.of(five.channels(), &five.observation(0)), None);
}
