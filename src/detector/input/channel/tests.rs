use super::*;

fn channel(width: usize, maximum: Option<f64>) -> Channel {
    Channel {
        name: "laser".into(),
        width,
        unit: "m".into(),
        bearing_rad: Some((0..width).map(|b| b as f64 * 0.1).collect()),
        maximum,
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
