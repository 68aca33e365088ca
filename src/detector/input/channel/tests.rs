use super::*;

fn channel(width: usize, maximum: Option<f64>) -> Channel {
    Channel {
        name: "laser".into(),
        width,
        unit: "m".into(),
        bearing_rad: Some((0..width).map(|b| b as f64 * 0.1).collect()),
        maximum,
        offset_m: None,
    }
}

fn config(sectors: usize, sector_values: &[SectorValue]) -> InputConfig {
    InputConfig {
        sectors,
        sector_values: sector_values.to_vec(),
        ..InputConfig::default()
    }
}

const ALL: [SectorValue; 5] = [
    SectorValue::Nearest,
    SectorValue::Middle,
    SectorValue::Farthest,
    SectorValue::MiddleLog,
    SectorValue::FarthestLog,
];

fn pooled(channel: &ChannelInput, raw: &[f32]) -> Vec<f32> {
    let mut out = Vec::new();
    channel.pool(raw, &mut out);
    out
}

#[test]
fn logarithms_see_farther_than_the_other_statistics() {
    let of = ChannelInput::new(&config(2, &ALL), &channel(6, None));
    // A room, and a hall with a beam that never came back.
    let raw = [1.0, 3.0, 2.0, 20.0, f32::NAN, 12.0];
    let expected = [
        1.0,
        8.0,
        2.0,
        8.0,
        3.0,
        8.0,
        3_f32.ln(),
        21_f32.ln(),
        4_f32.ln(),
        41_f32.ln(),
    ];
    assert_eq!(pooled(&of, &raw), expected);
}

#[test]
fn what_tells_nothing_new_is_left_out() {
    let kept = |sectors, channel: &Channel| {
        let scan = ChannelInput::new(&config(sectors, &ALL), channel).scan();
        scan.map(|scan| scan.statistics)
    };
    assert_eq!(kept(2, &channel(6, None)), Some(5));
    assert_eq!(kept(6, &channel(6, None)), Some(2)); // a beam, and its logarithm
    assert_eq!(kept(2, &channel(6, Some(7.0))), Some(3)); // sees no farther than 8 m
    assert_eq!(kept(6, &channel(6, Some(7.0))), Some(1));
}

#[test]
fn a_ring_is_one_whose_last_beam_lies_beside_its_first() {
    let around = |beams: usize, turn: f64| -> Vec<f64> {
        (0..beams).map(|b| turn * b as f64 / beams as f64).collect()
    };
    let in_half_turns: Vec<f64> = around(24, TAU).into_iter().map(wrapped).collect();
    assert!(is_ring(&in_half_turns)); // 180°, then −165°
    assert!(is_ring(&around(24, TAU)) && is_ring(&around(16, -TAU)));
    assert!(
        !is_ring(&around(180, TAU / 2.0)) && !is_ring(&around(270, 0.75 * TAU)) && !is_ring(&[])
    );
}

#[test]
fn ranges_to_single_things_are_taken_as_they_are_and_a_scan_without_bearings_is_not() {
    let beacons = Channel {
        bearing_rad: None,
        ..channel(4, None)
    };
    let of = ChannelInput::new(&config(36, &ALL), &beacons);
    assert_eq!(
        pooled(&of, &[20.0, 70.5, 3.0, 41.0]),
        [20.0, 70.5, 3.0, 41.0]
    );
    let many = Channel {
        bearing_rad: None,
        ..channel(180, None)
    };
    assert!(ChannelInput::new(&config(36, &ALL), &many).scan().is_some());
}

#[test]
fn a_value_that_was_missing_in_training_tells_whether_it_is_there() {
    let wifi = Channel {
        unit: "dBm".into(),
        bearing_rad: None,
        ..channel(4, None)
    };
    let mut of = ChannelInput::new(&config(36, &ALL), &wifi);
    let none = f32::NAN;
    // The second and the third are missing together, the fourth on its own.
    let training = ndarray::array![
        [-50.0, none, none, -70.0],
        [-51.0, -60.0, -61.0, none],
        [-52.0, -62.0, -63.0, -71.0],
    ];
    of.tell_missing(training.view());
    assert_eq!((of.inputs(), of.told_missing()), (6, 2));
    let told = |raw: &[f32]| pooled(&of, raw)[4..].to_vec();
    assert_eq!(told(&[none, -60.0, -61.0, none]), [1.0, 0.0]);
    assert_eq!(told(&[-50.0, none, -61.0, -70.0]), [0.0, 1.0]);
    let mut damaged = of.clone();
    if let Kind::Values { may_miss } = &mut damaged.kind {
        may_miss.push(4);
    }
    assert!(of.is_sound() && !damaged.is_sound());
}
