use super::*;
use crate::{
    seed::Seed,
    world::{
        Building,
        simulation::{Choice, simulate},
    },
};
use std::path::Path;

fn world(name: &str) -> Recording {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/worlds");
    let building = Building::read(&folder.join(name).with_extension("toml")).unwrap();
    simulate(&building, Seed(1), &Choice::default()).unwrap()
}

/// Mean distance of two traces after the shift and the turn that bring them closest (least squares, closed form).
fn after_rigid_fit(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let n = a.len() as f64;
    let middle =
        |points: &[[f64; 2]]| [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / n);
    let (of_a, of_b) = (middle(a), middle(b));
    let centred = |p: &[f64; 2], middle: [f64; 2]| [p[0] - middle[0], p[1] - middle[1]];
    let pairs: Vec<_> = (a.iter().zip(b))
        .map(|(p, q)| (centred(p, of_a), centred(q, of_b)))
        .collect();
    let cross: f64 = pairs.iter().map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum();
    let dot: f64 = pairs.iter().map(|(p, q)| p[0] * q[0] + p[1] * q[1]).sum();
    let (sin, cos) = cross.atan2(dot).sin_cos();
    let apart = |(p, q): &([f64; 2], [f64; 2])| {
        (cos * p[0] - sin * p[1] - q[0]).hypot(sin * p[0] + cos * p[1] - q[1])
    };
    pairs.iter().map(apart).sum::<f64>() / n
}

/// The worlds, and the laps and parts of laps that their robots drive.
const WORLDS: [(&str, usize); 10] = [
    ("duckett1998-a", 5),
    ("duckett1998-b", 5),
    ("duckett1998-c", 4),
    ("duckett1998-d", 8),
    ("duckett1998-e", 5),
    ("duckett1998-f", 5),
    ("duckett2000-a", 7),
    ("duckett2000-b", 8),
    ("duckett2000-c", 4),
    ("duckett2000-d", 4),
];

/// The papers divided by hand and had no other truth; here the simulation knows it.
#[test]
fn laps_and_corrected_odometry_agree_with_the_truth_in_all_worlds() {
    for (name, laps) in WORLDS {
        let recording = world(name);
        let truth = Protocol::new(&recording, &ProtocolConfig::default()).unwrap();
        let config = ProtocolConfig {
            truth: Truth::Odometry,
            ..ProtocolConfig::default()
        };
        let ours = Protocol::new(&recording, &config).unwrap();
        let poses = recording.poses();
        let mut furthest = [0.0; 2];
        for (furthest, protocol) in furthest.iter_mut().zip([&truth, &ours]) {
            let unit = &protocol.unit;
            let starts: Vec<usize> = (0..unit.len())
                .filter(|&k| k == 0 || unit[k] != unit[k - 1])
                .collect();
            assert_eq!(starts.len(), laps, "{name}");
            let from_start = starts.iter().map(|&k| poses[0].distance_m(&poses[k]));
            *furthest = from_start.fold(0.0, f64::max);
        }
        let apart = after_rigid_fit(&ours.place, &truth.place);
        let between = between_laps(&ours, &truth);
        println!(
            "{name}: lap {:.1} m by poses, {:.1} m by odometry; starts off by at most {:.2} m and {:.2} m; corrected \
             odometry off by {apart:.2} m, laps by {between:.2} m from the first",
            truth.laps.as_ref().unwrap().lap_m,
            ours.laps.as_ref().unwrap().lap_m,
            furthest[0],
            furthest[1]
        );
        assert!(
            furthest[0] < 1.0 && furthest[1] < 1.0,
            "{name}: {furthest:?}"
        );
        // A distorted compass bends the trace, alike in every lap: "global distortions … will not adversely affect the
        // results, provided that the assignment of bins to locations is consistent between successive laps" (D98 6.4).
        assert!(apart < 0.8, "{name}: {apart}");
        assert!(between < 0.25, "{name}: {between}");
    }
}

/// How far snapshots of later laps lie, on average, from where the first lap has the place that they were taken at.
fn between_laps(ours: &Protocol, truth: &Protocol) -> f64 {
    let off = ours.testing.iter().map(|&k| {
        let from = |&m: &usize| {
            let [dx, dy] = [0, 1].map(|axis| truth.place[k][axis] - truth.place[m][axis]);
            ([dx, dy], dx.hypot(dy))
        };
        let same = ours
            .mapping
            .iter()
            .min_by(|a, b| from(a).1.total_cmp(&from(b).1));
        let (apart, _) = from(same.unwrap());
        let offset = [0, 1].map(|axis| ours.place[k][axis] - ours.place[*same.unwrap()][axis]);
        (offset[0] - apart[0]).hypot(offset[1] - apart[1])
    });
    off.sum::<f64>() / ours.testing.len() as f64
}

/// Told by `config`, on one run of world A cut to so many snapshots.
fn refused(config: &str, snapshots: usize) -> Error {
    let recording = world("duckett1998-a");
    let indices: Vec<usize> = (0..snapshots.min(recording.len())).collect();
    let recording = recording.select(&indices).unwrap();
    Protocol::new(&recording, &toml::from_str(config).unwrap()).unwrap_err()
}

#[test]
fn what_cannot_be_staged_says_what_to_ask_for() {
    // 650 s are 80 m: a lap and a third.
    let error = refused("", 650).to_string();
    assert!(
        error.contains("no lap") && error.contains("\"split\""),
        "{error}"
    );
    assert!(error.contains("starts_s"), "{error}");
    let error = refused("mapping = 'first_run'", 650).to_string();
    assert!(
        error.contains("one run") && error.contains("\"split\""),
        "{error}"
    );
    let error = refused("laps = { starts_s = [0.0, 9000.0] }", 650);
    assert!(error.to_string().contains("from 0 s to"), "{error}");
    let config = "mapping = 'split'\ntruth = 'odometry'\nsplit = { test_fold = 0 }";
    let error = refused(config, 650);
    assert!(
        error.is_usage() && error.to_string().starts_with("protocol.truth"),
        "{error}"
    );
    let mut columns = world("duckett1998-d").into_columns();
    columns.compass_rad = None;
    let recording = Recording::new(columns).unwrap();
    let config = toml::from_str("truth = 'odometry'").unwrap();
    let error = Protocol::new(&recording, &config).unwrap_err().to_string();
    assert!(error.contains("no compass"), "{error}");
    let protocol = Protocol::new(&recording, &ProtocolConfig::default()).unwrap();
    assert!(protocol.notes[0].contains("no compass"));
}

#[test]
fn laps_told_by_hand_are_those_that_were_found() {
    let recording = world("duckett1998-d");
    let found = Protocol::new(&recording, &ProtocolConfig::default()).unwrap();
    let stamps = &recording.columns().stamp_s;
    let starts = (0..recording.len()).filter(|&k| k == 0 || found.unit[k] != found.unit[k - 1]);
    let starts_s: Vec<f64> = starts.map(|k| stamps[k]).collect();
    let config = ProtocolConfig {
        laps: LapsConfig {
            starts_s,
            ..LapsConfig::default()
        },
        ..ProtocolConfig::default()
    };
    let found_again = Protocol::new(&recording, &config).unwrap();
    assert_eq!(found_again.unit, found.unit);
    assert_eq!(
        (found_again.mapping, found_again.testing),
        (found.mapping, found.testing)
    );
}

#[test]
fn runs_and_stretches_are_numbered_and_never_on_both_sides() {
    let mut columns = world("duckett1998-d").into_columns();
    let third = columns.run.len() / 3;
    columns.run = (0..columns.run.len()).map(|k| (k / third) as i64).collect();
    let recording = Recording::new(columns).unwrap();
    let set = |config: &str| Protocol::new(&recording, &toml::from_str(config).unwrap()).unwrap();
    let runs = set("mapping = 'first_run'");
    assert_eq!(runs.mapping, (0..third).collect::<Vec<_>>());
    assert_eq!(
        (runs.unit[0], runs.unit[third], runs.unit[2 * third]),
        (0, 1, 2)
    );
    let split = set("mapping = 'split'\nsplit = { unit = '10m', test_fold = 1 }");
    assert_eq!(split.mapping.len() + split.testing.len(), recording.len());
    let units_of = |part: &[usize]| -> Vec<usize> {
        let mut units: Vec<usize> = part.iter().map(|&k| split.unit[k]).collect();
        units.dedup();
        units
    };
    let (mapped, tested) = (units_of(&split.mapping), units_of(&split.testing));
    assert!(tested.len() > 2 && tested.iter().all(|unit| !mapped.contains(unit)));
    assert!(split.unit.is_sorted());
}
