//! What is written is read again by this crate's own readers.

use super::*;
use crate::recording::{
    Channel, Columns,
    import::{ReadOptions, read},
};
use ndarray::Array2;
use std::f64::consts::FRAC_PI_2;

const BEAMS: usize = 5;

fn walk() -> Recording {
    let laser = Channel {
        name: "laser".into(),
        width: BEAMS,
        unit: "m".into(),
        bearing_rad: Some(
            (0..BEAMS)
                .map(|k| -FRAC_PI_2 + 0.25 * std::f64::consts::PI * k as f64)
                .collect(),
        ),
        maximum: Some(8.0),
        offset_m: None,
    };
    let sonar = Channel {
        name: "sonar".into(),
        width: 3,
        unit: "m".into(),
        bearing_rad: Some(vec![0.0, 0.3, 1.0]),
        maximum: None,
        offset_m: Some(vec![0.2, 0.25, 0.2]),
    };
    let light = Channel {
        name: "light".into(),
        width: 1,
        unit: "lux".into(),
        ..Channel::default()
    };
    let n = 7;
    let mut values = Array2::from_shape_fn((n, BEAMS + 3 + 1), |(k, i)| {
        0.1 + 0.7 * k as f32 + 0.013 * i as f32
    });
    values[[2, 1]] = f32::NAN;
    let at =
        |k: usize, drift: f64| Pose::new(0.5 * k as f64 + drift, -0.1 * k as f64, 0.03 * k as f64);
    Recording::new(Columns {
        channels: vec![laser, sonar, light],
        values,
        stamp_s: (0..n).map(|k| 1.0 + 0.3 * k as f64).collect(),
        pose: (0..n).map(|k| at(k, 0.25)).collect(),
        odometry: (0..n).map(|k| at(k, 0.0)).collect(),
        run: vec![0; n],
        compass_rad: Some((0..n).map(|k| 0.01 * k as f64).collect()),
        ..Columns::default()
    })
    .unwrap()
}

/// Written and read again; poses as given.
fn again(format: Format, poses: bool) -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(format!("walk.{}", format.ending()));
    let walk = walk();
    write(format, &file, &walk, poses.then(|| walk.poses())).unwrap();
    let log = read(&[file], &ReadOptions::default()).unwrap();
    assert_eq!(log.account.lost_count(), 0);
    log.recording
}

fn same_poses(a: &[Pose], b: &[Pose], within: f64) {
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        let off = (a.x_m - b.x_m)
            .abs()
            .max((a.y_m - b.y_m).abs())
            .max((a.heading_rad - b.heading_rad).abs());
        assert!(off <= within, "{a:?} {b:?}");
    }
}

#[test]
fn a_table_holds_all() {
    let (walk, read) = (walk(), again(Format::Csv, true));
    same_poses(read.poses(), walk.poses(), 0.0);
    same_poses(&read.columns().odometry, &walk.columns().odometry, 0.0);
    assert_eq!(read.columns().compass_rad, walk.columns().compass_rad);
    for (a, b) in read.channels().iter().zip(walk.channels()) {
        assert_eq!(
            (&a.name, a.width, &a.unit, &a.offset_m),
            (&b.name, b.width, &b.unit, &b.offset_m)
        );
        let bearings = a
            .bearing_rad
            .iter()
            .flatten()
            .zip(b.bearing_rad.iter().flatten());
        assert!(bearings.into_iter().all(|(a, b)| (a - b).abs() < 1e-12));
    }
    let same = |(a, b): (&f32, &f32)| a == b || a.is_nan() && b.is_nan();
    assert!(read.values().iter().zip(walk.values()).all(same));
}

#[test]
fn scans_travel_in_logs_of_robots() {
    let walk = walk();
    for (format, poses) in [
        (Format::Carmen, true),
        (Format::Carmen, false),
        (Format::Mcap, true),
    ] {
        let read = again(format, poses);
        let own = if poses {
            walk.poses()
        } else {
            &walk.columns().odometry
        };
        same_poses(read.poses(), own, 1e-9);
        same_poses(&read.columns().odometry, &walk.columns().odometry, 1e-9);
        assert_eq!(read.len(), walk.len());
        let bearings = read.channels()[0].bearing_rad.clone().unwrap();
        let expected = walk.channels()[0].bearing_rad.clone().unwrap();
        assert!(
            bearings
                .iter()
                .zip(&expected)
                .all(|(a, b)| (a - b).abs() < 1e-6),
            "{bearings:?}"
        );
        for k in 0..walk.len() {
            for i in 0..BEAMS {
                let (a, b) = (read.values()[[k, i]], walk.values()[[k, i]]);
                let nothing = |m: f32| m.is_nan() || m > 8.0; // beyond the farthest
                assert!(
                    a == b || nothing(a) && nothing(b),
                    "{format:?} {k} {i}: {a} {b}"
                );
            }
        }
        let stamps = read.columns().stamp_s.iter().zip(&walk.columns().stamp_s);
        assert!(stamps.into_iter().all(|(a, b)| (a - b).abs() < 1e-6));
    }
}

#[test]
fn what_a_format_cannot_hold_is_said() {
    let sonar = walk().channels()[1].clone();
    for format in [Format::Carmen, Format::Mcap] {
        let why = format.refuses(std::slice::from_ref(&sonar)).unwrap();
        assert!(why.contains("evenly spaced"), "{why}");
    }
    assert!(Format::Npz.refuses(&[sonar]).is_none());
}
