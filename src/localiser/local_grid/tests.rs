use super::*;
use crate::recording::Columns;
use ndarray::Array2;
use std::path::Path;

fn config() -> LocalGridConfig {
    LocalGridConfig {
        world: Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/worlds/ruizmayor2006-r2.toml"),
        ..LocalGridConfig::default()
    }
}

/// Sancho-2's twelve sonars.
fn ring() -> Channel {
    let bearing = |i: usize| wrapped(f64::from(i as u32) * 30_f64.to_radians());
    Channel {
        name: "sonar".into(),
        width: 12,
        unit: "m".into(),
        bearing_rad: Some((0..12).map(bearing).collect()),
        maximum: Some(6.0),
        offset_m: None,
    }
}

/// A recording of what the plan leads to expect at some poses, with odometry that may say something else.
fn recording(poses: &[Pose], odometry: &[Pose]) -> Recording {
    let plan = ExpectedRanges::of_world(&config().world, &[ring()], Seed(1)).unwrap();
    let scans = poses.iter().flat_map(|pose| plan.at(pose));
    let values: Vec<f32> = scans.map(|metres| metres as f32).collect();
    Recording::new(Columns {
        channels: vec![ring()],
        values: Array2::from_shape_vec((poses.len(), 12), values).unwrap(),
        stamp_s: (0..poses.len()).map(|k| k as f64).collect(),
        pose: poses.to_vec(),
        odometry: odometry.to_vec(),
        run: vec![0; poses.len()],
        ..Columns::default()
    })
    .unwrap()
}

fn learned(recording: &Recording) -> LocalGrid {
    LocalGrid::learn(&config(), recording, &[0], Seed(1)).unwrap()
}

fn places(grid: &LocalGrid, recording: &Recording, start: Option<Pose>) -> Vec<Option<[f64; 2]>> {
    let trial: Vec<usize> = (0..recording.len()).collect();
    let player = grid.prepare(recording, &trial).unwrap();
    let steps = player.play(&trial, start, &mut Seed(1).stream("a trial"));
    let place = |step: &Step| match step.estimate {
        Some(Estimate::Place(place)) => Some(place),
        _ => None,
    };
    steps.unwrap().iter().map(place).collect()
}

/// Somewhere in the room of R2.
const HERE: Pose = Pose::new(-3.0, 2.0, 0.0);

#[test]
fn the_grid_is_a_disc_of_positions_with_all_headings_of_each() {
    let offsets = config().offsets();
    assert_eq!(offsets.len(), 49 * 9);
    assert_eq!(offsets[0], Pose::new(0.0, 0.0, 0.0));
    let far = |pose: &Pose| pose.x_m.hypot(pose.y_m);
    assert!(offsets.windows(2).all(|w| far(&w[0]) <= far(&w[1]) + 1e-12));
    assert!((far(&offsets[offsets.len() - 1]) - 0.4).abs() < 1e-12);
    let turned = |pose: &Pose| pose.heading_rad.to_degrees().round() as i64;
    let first: Vec<i64> = offsets[..9].iter().map(turned).collect();
    assert_eq!(first, [0, -10, 10, -20, 20, -30, 30, -40, 40]);
    let alone = LocalGridConfig {
        position_radius_m: 0.0,
        heading_radius_rad: 0.1,
        ..config()
    };
    assert_eq!(alone.offsets(), [Pose::default()]);
}

#[test]
fn a_pose_of_the_grid_is_found_again_from_every_other() {
    let recording = recording(&[HERE], &[HERE]);
    let grid = learned(&recording);
    for offset in config().offsets().iter().step_by(7) {
        let reckoned = Pose::new(
            HERE.x_m - offset.x_m,
            HERE.y_m - offset.y_m,
            HERE.heading_rad - offset.heading_rad,
        );
        let corrected = grid.corrected(
            recording.channels(),
            recording.observation(0).values,
            &reckoned,
        );
        assert!(corrected.distance_m(&HERE) < 1e-9 && corrected.turn_rad(&HERE) < 1e-9);
    }
}

#[test]
fn the_nearest_perception_is_that_of_a_plain_search() {
    let truth = Pose::new(-2.97, 1.96, 0.07);
    let recording = recording(&[truth], &[truth]);
    let (grid, reckoned) = (learned(&recording), Pose::new(-3.2, 2.2, -0.3));
    let values = recording.observation(0).values;
    let plan = ExpectedRanges::of_world(&config().world, &[ring()], Seed(1)).unwrap();
    let apart = |offset: &Pose| {
        let pose = Pose::new(
            reckoned.x_m + offset.x_m,
            reckoned.y_m + offset.y_m,
            reckoned.heading_rad + offset.heading_rad,
        );
        let both = plan.at(&pose).into_iter().zip(values);
        let square = both.map(|(a, b)| (a - f64::from(*b)).powi(2)).sum::<f64>();
        (square, pose)
    };
    let all = config().offsets();
    let all = all.iter().map(apart);
    let best = all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1;
    let corrected = grid.corrected(recording.channels(), values, &reckoned);
    assert!(corrected.distance_m(&best) < 1e-12 && corrected.turn_rad(&best) < 1e-12);
    // "The optimal estimation": no pose of the grid is nearer to the truth than 0.71 steps, and this one isn't far from it.
    assert!(corrected.distance_m(&truth) < 0.15 && corrected.turn_rad(&truth) < 0.09);
}

/// A way of 3 m, a snapshot every 25 cm, and wheels that count a fifth too much.
fn drive() -> (Vec<Pose>, Vec<Pose>) {
    let along = |scale: f64| -> Vec<Pose> {
        (0..13)
            .map(|k| Pose::new(scale * 0.25 * f64::from(k), 0.0, 0.0))
            .collect()
    };
    let ahead = along(1.0).into_iter();
    let way = ahead.map(|p| Pose::new(p.x_m - 4.6, 2.0, 0.0)).collect();
    (way, along(1.2))
}

#[test]
fn it_is_corrected_every_half_metre_and_reckons_between() {
    let (way, wheels) = drive();
    let recording = recording(&way, &wheels);
    let answers = places(&learned(&recording), &recording, Some(way[0]));
    let error = |k: usize| {
        let [x_m, y_m] = answers[k].unwrap();
        way[k].distance_m(&Pose::new(x_m, y_m, 0.0))
    };
    assert_eq!(error(0), 0.0, "at the start that is given");
    assert!((error(1) - 0.05).abs() < 1e-9, "reckoned");
    for k in 1..13 {
        // At every second snapshot the wheels have counted 0.6 m; at the next, 0.3 m since a correction to the nearest 10 cm.
        assert!(
            error(k) < if k % 2 == 0 { 0.072 } else { 0.13 },
            "{k}: {}",
            error(k)
        );
    }
    let every_3_m = LocalGrid {
        config: LocalGridConfig {
            estimation_every_m: 100.0,
            ..config()
        },
        ..learned(&recording)
    };
    let [x_m, _] = places(&every_3_m, &recording, Some(way[0]))[12].unwrap();
    assert!((x_m - way[0].x_m - 3.6).abs() < 1e-9, "never corrected");
    assert_eq!(places(&every_3_m, &recording, None), [None; 13]);
}

#[test]
fn wheels_that_count_a_little_too_little_are_corrected_as_often() {
    let way: Vec<Pose> = (0..7)
        .map(|k| Pose::new(-4.6 + 0.5 * f64::from(k), 2.0, 0.0))
        .collect();
    let wheels = (0..7).map(|k| Pose::new(0.48 * f64::from(k), 0.1 * f64::from(k), 0.0));
    let recording = recording(&way, &wheels.collect::<Vec<_>>());
    let answers = places(&learned(&recording), &recording, Some(way[0]));
    for (k, answer) in answers.iter().enumerate() {
        // 0.49 m by the wheels; were every second snapshot passed over, it would lie 10 cm aside.
        let [_, y_m] = answer.unwrap();
        assert!((y_m - 2.0).abs() < 0.05, "{k}: {y_m}");
    }
}

#[test]
fn a_scan_without_a_return_corrects_nothing() {
    let (way, wheels) = drive();
    let mut columns = recording(&way, &wheels).into_columns();
    columns.values.fill(f32::NAN);
    let recording = Recording::new(columns).unwrap();
    let answers = places(&learned(&recording), &recording, Some(way[0]));
    let [x_m, y_m] = answers[12].unwrap();
    assert!((x_m - way[0].x_m - 3.6).abs() < 1e-9 && (y_m - 2.0).abs() < 1e-9);
}

#[test]
fn a_file_holds_the_plan_and_answers_the_same() {
    let (way, wheels) = drive();
    let recording = recording(&way, &wheels);
    let grid = learned(&recording);
    let text = serde_json::to_string(&grid).unwrap();
    let read: LocalGrid = serde_json::from_str(&text).unwrap();
    read.check().unwrap();
    let answers = |grid: &LocalGrid| places(grid, &recording, Some(way[0]));
    assert_eq!(answers(&read), answers(&grid));
    let damaged = text.replace("\"position_step_m\":0.1", "\"position_step_m\":0.0");
    let read: LocalGrid = serde_json::from_str(&damaged).unwrap();
    assert!(
        read.check()
            .unwrap_err()
            .to_string()
            .contains("position_step_m")
    );
}

#[test]
fn constants_that_make_no_sense_are_told_by_name() {
    let refused = |config: LocalGridConfig, key: &str| {
        let error = config.check().unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(key),
            "{error}"
        );
    };
    refused(LocalGridConfig::default(), "local_grid.world");
    refused(
        LocalGridConfig {
            position_step_m: 0.0,
            ..config()
        },
        "position_step_m",
    );
    refused(
        LocalGridConfig {
            heading_step_rad: f64::NAN,
            ..config()
        },
        "heading_step_rad",
    );
    refused(
        LocalGridConfig {
            estimation_every_m: -1.0,
            ..config()
        },
        "estimation_every_m",
    );
    refused(
        LocalGridConfig {
            position_radius_m: -0.1,
            ..config()
        },
        "position_radius_m",
    );
    refused(
        LocalGridConfig {
            heading_radius_rad: 4.0,
            ..config()
        },
        "heading_radius_rad",
    );
    refused(
        LocalGridConfig {
            position_step_m: 1e-4,
            ..config()
        },
        "poses",
    );
    let missing = LocalGridConfig {
        world: "no-such-world.toml".into(),
        ..config()
    };
    let recording = recording(&[HERE], &[HERE]);
    let error = LocalGrid::learn(&missing, &recording, &[0], Seed(1)).unwrap_err();
    assert!(error.to_string().contains("no-such-world.toml"), "{error}");
}
