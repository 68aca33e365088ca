use super::*;
use crate::{
    detector::input::InputConfig,
    geometry::Pose,
    recording::{Columns, Recording},
    seed::Seed,
};
use ndarray::Array2;

fn recording() -> Recording {
    let bearing_rad = |beam: usize| (beam as f64 - 89.5).to_radians();
    Recording::new(Columns {
        channels: vec![Channel {
            name: "laser".into(),
            width: 180,
            unit: "m".into(),
            bearing_rad: Some((0..180).map(bearing_rad).collect()),
            maximum: Some(50.0),
            offset_m: None,
        }],
        values: Array2::from_shape_fn((3, 180), |(k, b)| match (k + b) % 17 {
            0 => f32::NAN,
            reading => 0.5 + 1.7 * reading as f32,
        }),
        stamp_s: vec![0.0, 1.0, 2.0],
        pose: vec![Pose::default(); 3],
        odometry: vec![Pose::default(); 3],
        run: vec![0; 3],
        ..Columns::default()
    })
    .unwrap()
}

#[test]
fn a_shorter_reach_on_inputs_is_one_on_readings() {
    let recording = recording();
    let input = Input::fit(&InputConfig::far(), &recording, &[0, 1, 2]).unwrap();
    for reach_m in [3.0, 6.0, 12.0, 30.0] {
        let mut columns = recording.columns().clone();
        columns.values.mapv_inplace(|r| match r > reach_m {
            true => f32::NAN,
            false => r,
        });
        let cut = input.transform(&Recording::new(columns).unwrap()).unwrap();
        let inputs = input.within_reach(reach_m, input.transform(&recording).unwrap());
        let off = (&cut - &inputs).mapv(f32::abs);
        assert!(off.iter().all(|&off| off < 1e-4), "{reach_m}");
    }
}

#[test]
fn beams_are_taken_away_as_often_as_said() {
    let recording = recording();
    let input = Input::fit(&InputConfig::far(), &recording, &[0, 1, 2]).unwrap();
    let worsened = |config: &VariedSensorConfig| {
        let mut random = Seed(1).stream("sensors");
        (0..200)
            .filter(|_| config.worsened(&input, recording.channels(), &mut random) != input)
            .count()
    };
    let none = VariedSensorConfig {
        thinned: 0.0,
        blocked: 0.0,
        ..VariedSensorConfig::default()
    };
    assert_eq!(worsened(&none), 0);
    let thinned = VariedSensorConfig {
        thinned: 0.5,
        ..none
    };
    let count = worsened(&thinned);
    assert!((75..125).contains(&count), "{count}");
    let mut random = Seed(1).stream("sensors");
    let thinned = VariedSensorConfig {
        thinned: 1.0,
        ..thinned
    };
    let few = thinned.worsened(&input, recording.channels(), &mut random);
    // The same sectors with the same constants, which other beams fill.
    assert_eq!(few.shape(), input.shape());
    assert_eq!(few.mean, input.mean);
    let [own, other] = [&input, &few].map(|input| input.transform(&recording).unwrap());
    assert_ne!(own, other);
}

#[test]
fn reaches_are_between_the_least_and_the_sensors() {
    let (recording, mut random) = (recording(), Seed(1).stream("reaches"));
    let config = VariedSensorConfig::default();
    let drawn: Vec<f32> = (0..500)
        .filter_map(|_| config.reach_m(recording.channels(), &mut random))
        .collect();
    assert!((150..250).contains(&drawn.len()), "{}", drawn.len());
    assert!(drawn.iter().all(|reach_m| (3.0..=50.0).contains(reach_m)));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let refused = |change: fn(&mut VariedSensorConfig)| {
        let mut config = VariedSensorConfig::default();
        change(&mut config);
        let fault = config.check().unwrap_err();
        assert!(fault.is_usage());
        fault.to_string()
    };
    assert!(refused(|c| c.short = 1.5).contains("pretrain.sensors.short"));
    assert!(refused(|c| c.thinned = f64::NAN).contains("pretrain.sensors.thinned"));
    assert!(refused(|c| c.widest_blocked = 0.5).contains("0 to 0.3"));
    assert!(refused(|c| c.least_reach_m = 0.0).contains("least_reach_m"));
    assert!(refused(|c| c.fewest_beams = 1).contains("fewest_beams"));
}
