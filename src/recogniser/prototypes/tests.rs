use super::*;
use crate::{geometry::Pose, recording::Columns, seed::Seed};
use ndarray::Array2;
use rand::RngExt;

/// Scans of two sensors, every tenth a copy of an earlier one, so that there are ties.
fn scans(k: usize, widths: [usize; 2]) -> Recording {
    let mut random = Seed(9).stream("scans");
    let width = widths[0] + widths[1];
    let mut values = Array2::from_shape_simple_fn((k, width), || random.random_range(0.1..4.0));
    for i in (10..k).step_by(10) {
        let earlier = values.row(i / 2).to_owned();
        values.row_mut(i).assign(&earlier);
    }
    let channel = |(i, &width): (usize, &usize)| Channel {
        name: ["sonar", "infrared"][i].into(),
        width,
        unit: "m".into(),
        bearing_rad: None,
        maximum: Some(4.0),
        offset_m: None,
    };
    Recording::new(Columns {
        channels: widths.iter().enumerate().map(channel).collect(),
        values,
        stamp_s: vec![0.0; k],
        pose: vec![Pose::default(); k],
        odometry: vec![Pose::default(); k],
        run: vec![0; k],
        ..Columns::default()
    })
    .unwrap()
}

fn storing(recording: &Recording, patterns: usize) -> Prototypes {
    let all: Vec<usize> = (0..patterns).collect();
    let mut prototypes = Prototypes::new(&SignatureConfig::default(), recording, &all).unwrap();
    for k in all {
        let signature = prototypes
            .layout()
            .of(recording.channels(), &recording.observation(k));
        prototypes.push(&signature.unwrap());
    }
    prototypes
}

/// Block edges within, at and past the end, widths that no vector unit divides, and ties: the same answers to the bit.
#[test]
fn the_blocked_product_answers_as_the_plain_loop() {
    for widths in [[16, 16], [3, 2], [180, 7]] {
        let recording = scans(2 * PATTERNS + 100, widths);
        for patterns in [1, 7, PATTERNS, 2 * PATTERNS + 30] {
            let prototypes = storing(&recording, patterns);
            for asked in [1, SNAPSHOTS, recording.len()] {
                let asked: Vec<usize> = (recording.len() - asked..recording.len()).collect();
                let together = prototypes.respond_all(&recording, &asked);
                let one = |&k: &usize| {
                    prototypes.respond(recording.channels(), &recording.observation(k))
                };
                assert_eq!(together, asked.iter().map(one).collect::<Vec<_>>());
            }
        }
    }
}

#[test]
fn a_stored_snapshot_is_the_first_pattern_like_it_and_fits_fully() {
    let recording = scans(200, [16, 16]);
    let prototypes = storing(&recording, 200);
    let all: Vec<usize> = (0..200).collect();
    for (k, answer) in prototypes.respond_all(&recording, &all).iter().enumerate() {
        let answer = answer.unwrap();
        let alike = |j: &usize| recording.values().row(*j) == recording.values().row(k);
        assert_eq!(Some(answer.class), (0..=k).find(alike));
        assert!(
            (answer.fit - 1.0).abs() < 1e-6,
            "two channels, one fit: {answer:?}"
        );
    }
}

#[test]
fn damage_is_told() {
    let sound = storing(&scans(20, [4, 2]), 20);
    sound.check().unwrap();
    for damage in [f32::NAN, 3.0, f32::INFINITY] {
        let mut prototypes = sound.clone();
        prototypes.values[5] = damage;
        assert!(prototypes.check().is_err());
    }
    let mut prototypes = sound.clone();
    prototypes.values.pop();
    assert!(prototypes.check().unwrap_err().to_string().contains("119"));
}
