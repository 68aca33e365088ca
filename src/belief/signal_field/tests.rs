use super::*;
use crate::{
    belief::{Grid, GridConfig},
    geometry::Pose,
    recording::import::{ReadOptions, read},
    seed::Seed,
};
use ndarray::{Array2, ArrayView1};
use rand::RngExt;
use std::{f64::consts::TAU, path::PathBuf};

mod brute_force;

use brute_force::BruteForce;

/// Snapshots scattered over a hall of 8 by 6 m, in three runs: four readings that vary with place and heading, the second
/// and third now and then missing, the third in the west only, and a fourth that no snapshot has.
fn scattered(name: &str, snapshots: usize) -> LabelledReadings {
    let mut random = Seed(4).stream(name);
    let poses: Vec<Pose> = (0..snapshots)
        .map(|_| {
            Pose::new(
                8.0 * random.random::<f64>(),
                6.0 * random.random::<f64>(),
                14.0 * (random.random::<f64>() - 0.5),
            )
        })
        .collect();
    let values = Array2::from_shape_fn((snapshots, 4), |(k, value)| {
        let Pose {
            x_m,
            y_m,
            heading_rad,
        } = poses[k];
        let noise = random.random::<f64>() - 0.5;
        let lost = random.random::<f64>() < 0.2;
        let reading = match value {
            0 => -60.0 + 3.0 * x_m + 2.0 * heading_rad.sin() + noise,
            1 if !lost => 40.0 * (y_m / 2.0).cos() + 6.0 * noise,
            2 if !lost && x_m < 4.0 => x_m * y_m + noise,
            _ => f64::NAN,
        };
        reading as f32
    });
    let wifi = Channel {
        name: "wifi".into(),
        width: 4,
        unit: "dBm".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    LabelledReadings {
        channels: vec![wifi],
        values,
        places: Places::Plane(poses),
        run: (0..snapshots).map(|k| (3 * k / snapshots) as i64).collect(),
        snapshot: (0..snapshots).map(|k| 2 * k).collect(),
    }
}

fn compared_with_brute_force(
    readings: &LabelledReadings,
    config: &SignalFieldConfig,
    places: &Places,
) {
    let field = SignalField::fit(readings, config).unwrap();
    let slow = BruteForce::new(readings, config);
    for (value, spread) in field.spread().into_iter().enumerate().take(3) {
        let expected = slow.variance[value].sqrt() * slow.deviation[value];
        assert!(
            (spread / expected - 1.0).abs() < 1e-4,
            "{value}: {spread} {expected}"
        );
    }
    let at = field.at(places).unwrap();
    let mut unknown = 0;
    for place in 0..places.len() {
        for value in 0..3 {
            let (mean, presence) = slow.mean_and_presence(places, place, value, |_| true);
            unknown += usize::from(mean.is_none());
            let mean = slow.mean[value] + slow.deviation[value] * mean.unwrap_or(0.0);
            let off = (at.mean(place, value) - mean) / slow.deviation[value];
            assert!(off.abs() < 1e-4, "{place} {value}: {off}");
            if value > 0 {
                assert!((at.presence(place, value) - presence).abs() < 1e-5);
            }
        }
    }
    assert!(
        unknown > 0,
        "every place is near snapshots: nothing tries the rest"
    );
    let asked = scattered("asked", 20);
    let nothing = [f32::NAN; 4];
    let odd = [f32::INFINITY, f32::MAX, -1e30, 5.0];
    let rows = asked
        .values
        .rows()
        .into_iter()
        .chain([ndarray::aview1(&nothing), ndarray::aview1(&odd)]);
    for values in rows {
        let found = at.log_likelihood(values).unwrap();
        assert_eq!(found.len(), places.len());
        for (place, found) in found.into_iter().enumerate() {
            let expected = slow.log_likelihood(places, place, values);
            assert!(
                (found - expected).abs() < 2e-3,
                "{place}: {found} {expected}"
            );
        }
    }
}

#[test]
fn fields_agree_with_brute_force() {
    let readings = scattered("training", 300);
    for bandwidth_rad in [None, Some(0.5)] {
        let config = SignalFieldConfig {
            bandwidth_m: 0.35,
            bandwidth_rad,
            ..SignalFieldConfig::default()
        };
        let grid = GridConfig {
            cell_m: 0.9,
            headings: 5,
            ..GridConfig::default()
        };
        let grid = Grid::over(&readings.places, &grid).unwrap();
        assert!(grid.len() > 300);
        for places in [&**grid.places(), &scattered("places", 150).places] {
            compared_with_brute_force(&readings, &config, places);
        }
    }
    let mut route = scattered("training", 120);
    let along = |readings: &LabelledReadings| {
        let poses = (0..readings.len()).map(|k| readings.places.pose(k));
        Places::Route(poses.map(|pose| 10.0 * pose.x_m).collect())
    };
    route.places = along(&route);
    let config = SignalFieldConfig {
        bandwidth_m: 0.3,
        bandwidth_rad: Some(0.5), // plays no part along a route
        ..SignalFieldConfig::default()
    };
    compared_with_brute_force(&route, &config, &along(&scattered("places", 150)));
}

#[test]
fn headings_share_what_does_not_depend_on_them() {
    let readings = scattered("training", 300);
    let grid = Grid::over(&readings.places, &GridConfig::default()).unwrap();
    let field = SignalField::fit(&readings, &SignalFieldConfig::default()).unwrap();
    let at = field.at(grid.places()).unwrap();
    let sites = grid.len() / 24;
    // Four means and three presences of 4 bytes, the last block of sites not full.
    assert!(
        at.memory_bytes() < (sites + 128) * 7 * 4,
        "{}",
        at.memory_bytes()
    );
    let answer = at.log_likelihood(readings.values.row(3)).unwrap();
    assert_eq!(answer[..sites], answer[7 * sites..8 * sites]);
    // Readings and two numbers of the place, and three numbers of each value.
    assert_eq!(field.bytes(), (300 * (4 + 2) + 3 * 4) * 4);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let readings = scattered("training", 300);
    let grid = Grid::over(&readings.places, &GridConfig::default()).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let config = SignalFieldConfig {
                bandwidth_rad: Some(0.5),
                ..SignalFieldConfig::default()
            };
            let field = SignalField::fit(&readings, &config).unwrap();
            let at = field.at(grid.places()).unwrap();
            (
                field.spread(),
                at.log_likelihood(readings.values.row(9)).unwrap(),
            )
        })
    };
    assert_eq!(format!("{:?}", run(1)), format!("{:?}", run(3)));
}

#[test]
fn what_does_not_fit_is_refused_in_words() {
    let good = scattered("training", 60);
    let refused = |change: &dyn Fn(&mut LabelledReadings, &mut SignalFieldConfig)| {
        let (mut readings, mut config) = (good.clone(), SignalFieldConfig::default());
        change(&mut readings, &mut config);
        SignalField::fit(&readings, &config)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        refused(&|_, c| c.bandwidth_m = 0.0),
        "signal_field.bandwidth_m = 0: expected metres above 0"
    );
    assert!(refused(&|_, c| c.bandwidth_rad = Some(f64::NAN)).contains("bandwidth_rad = NaN"));
    assert!(refused(&|_, c| c.outliers = 1.0).contains("outliers = 1:"));
    assert!(refused(&|_, c| c.pass_snapshots = 0).contains("pass_snapshots = 0"));
    assert!(refused(&|_, c| c.most_snapshots = 0).contains("most_snapshots = 0"));
    assert_eq!(
        refused(&|r, _| r.run.truncate(7)),
        "signal field: 7 runs; expected 60, one a snapshot"
    );
    assert!(refused(&|r, _| r.channels[0].width = 3).contains("4 values a snapshot; expected 3"));
    assert!(refused(&|r, _| r.values = Array2::zeros((0, 4))).contains("no training snapshot"));
    assert!(refused(&|r, _| r.values.fill(f32::NAN)).contains("none of 60 snapshots"));
    let nowhere = refused(&|r, _| r.places = Places::Route(vec![f64::NAN; 60]));
    assert!(nowhere.contains("place 0"), "{nowhere}");

    let field = SignalField::fit(&good, &SignalFieldConfig::default()).unwrap();
    let error = field.at(&Places::Route(vec![0.0])).unwrap_err();
    assert!(error.to_string().contains("along a route"), "{error}");
    let at = field.at(&good.places).unwrap();
    let error = at.log_likelihood(ndarray::aview1(&[1.0])).unwrap_err();
    assert_eq!(
        error.to_string(),
        "signal field: expected 4 values a snapshot, found 1"
    );
    assert!(field.at(&Places::Plane(vec![])).unwrap().is_empty());
}

/// Readings that depend on heading alone within 1 m, and count twice.
#[test]
fn tuning_finds_the_heading_and_that_readings_repeat_each_other() {
    let readings = |name: &str, snapshots: usize| {
        let mut readings = scattered(name, snapshots);
        let Places::Plane(poses) = &readings.places else {
            unreachable!("scattered in the plane")
        };
        let mut random = Seed(6).stream(name);
        for (mut row, pose) in readings.values.rows_mut().into_iter().zip(poses) {
            let noise = 0.3 * (random.random::<f64>() + random.random::<f64>() - 1.0);
            row.fill((pose.x_m + 3.0 * pose.heading_rad.cos() + noise) as f32);
        }
        readings
    };
    let (training, validation) = (readings("training", 1500), readings("validation", 100));
    let config = SignalFieldConfig::default();
    let tuned = fit_tuned(&training, &validation, &training.places, &config).unwrap();
    assert_eq!(tuned.field.config().bandwidth_rad, Some(0.4));
    // The same reading four times.
    assert_eq!(tuned.power, 0.25);
    let chance = (training.len() as f64 + 1.0).ln();
    assert!(tuned.negative_log_likelihood.unwrap() < chance - 0.5);

    let none = LabelledReadings {
        values: Array2::zeros((0, 4)),
        ..validation
    };
    let untuned = fit_tuned(&training, &none, &training.places, &config).unwrap();
    assert_eq!(
        (untuned.power, untuned.negative_log_likelihood),
        (1.0, None)
    );
    assert_eq!(untuned.field.config(), &config);
}

/// One snapshot's error reduction on a real log, as an independent program has it (kernel regression by dense matrices,
/// without the reach of 3 bandwidths): Bluetooth in a flat, the first and the last of five runs tested on.
#[test]
fn a_flat_full_of_bluetooth_is_reduced_as_elsewhere() {
    let Some(folder) = std::env::var_os("BALLMARK_DATA").map(PathBuf::from) else {
        eprintln!("skipped: the Bluetooth log needs the real logs in $BALLMARK_DATA");
        return;
    };
    let log = folder.join("flat-ble/flat-ble.csv.xz");
    if !log.is_file() {
        eprintln!("skipped: no {}", log.display());
        return;
    }
    let recording = read(&[log], &ReadOptions::default()).unwrap().recording;
    let runs = recording.runs();
    let of_runs = |wanted: &[usize]| -> Vec<usize> {
        wanted.iter().flat_map(|&run| runs[run].clone()).collect()
    };
    let (training, test) = (of_runs(&[1, 2, 3]), of_runs(&[0, 4]));
    let test: Vec<usize> = test
        .iter()
        .copied()
        .step_by((test.len() / 800).max(1))
        .collect();
    let readings = LabelledReadings::of(&recording, &training, &[]).unwrap();
    let asked = LabelledReadings::of(&recording, &test, &[]).unwrap();
    let candidates = &readings.places;
    let apart = |truth: usize, c: usize| {
        let turn = asked.places.turn_rad(truth, candidates, c);
        (asked.places.distance_m(truth, candidates, c), turn)
    };
    let counted: Vec<usize> = (0..asked.len())
        .filter(|&truth| {
            (0..candidates.len()).any(|c| apart(truth, c).0 < 0.5 && apart(truth, c).1 < 0.45)
        })
        .collect();
    assert!((280..300).contains(&counted.len()), "{}", counted.len());
    for (bandwidth_m, bandwidth_rad, within_2m, anywhere) in [
        (0.3, Some(1.0), 0.197, 0.531),
        (0.6, None, 0.171, 0.535),
        (1.2, Some(0.4), 0.116, 0.486),
    ] {
        let config = SignalFieldConfig {
            bandwidth_m,
            bandwidth_rad,
            ..SignalFieldConfig::default()
        };
        let field = SignalField::fit(&readings, &config).unwrap();
        let at = field.at(candidates).unwrap();
        let mut errors = [[0.0; 2]; 2];
        for &truth in &counted {
            let l = at.log_likelihood(asked.values.row(truth)).unwrap();
            for (errors, half_width_m) in errors.iter_mut().zip([2.0, f64::INFINITY]) {
                let admitted: Vec<(f64, f64)> = (0..candidates.len())
                    .map(|c| (l[c], apart(truth, c)))
                    .filter(|(_, (far, turn))| {
                        *far <= half_width_m && (*turn <= 0.5 || half_width_m > 2.0)
                    })
                    .map(|(l, (far, _))| (l, far))
                    .collect();
                if admitted.len() < 2 {
                    continue;
                }
                let best = admitted
                    .iter()
                    .map(|a| a.0)
                    .fold(f64::NEG_INFINITY, f64::max);
                let mass: f64 = admitted.iter().map(|a| (a.0 - best).exp()).sum();
                let error: f64 = admitted.iter().map(|a| (a.0 - best).exp() * a.1).sum();
                errors[0] += admitted.iter().map(|a| a.1).sum::<f64>() / admitted.len() as f64;
                errors[1] += error / mass;
            }
        }
        let reduction = errors.map(|[prior, posterior]| 1.0 - posterior / prior);
        eprintln!("{bandwidth_m} m, {bandwidth_rad:?} rad: {reduction:?}");
        assert!((reduction[0] - within_2m).abs() < 0.01, "{reduction:?}");
        assert!((reduction[1] - anywhere).abs() < 0.01, "{reduction:?}");
    }
}
