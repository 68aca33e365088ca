//! What must hold for recordings of moved snapshots.

use super::*;
use crate::recording::Columns;
use crate::seed::Seed;
use std::f64::consts::{FRAC_PI_2, TAU};

fn step(forward_m: f64, left_m: f64, turn_deg: f64) -> Displacement {
    Displacement {
        forward_m,
        left_m,
        turn_rad: turn_deg.to_radians(),
    }
}

/// A drive along the y axis past a light and a scanner, with a route that starts at 10 m.
fn drive() -> Recording {
    let n = 6;
    let beams = (-90..=90).map(|d| f64::from(d).to_radians()).collect();
    let mut values = ndarray::Array2::from_elem((n, 182), 3.0);
    values.column_mut(0).fill(7.0);
    let pose: Vec<Pose> = (0..n)
        .map(|k| Pose::new(0.0, k as f64, FRAC_PI_2))
        .collect();
    let channel = |name: &str, unit: &str, bearing_rad: Option<Vec<f64>>| Channel {
        name: name.into(),
        width: bearing_rad.as_ref().map_or(1, Vec::len),
        unit: unit.into(),
        bearing_rad,
        maximum: None,
        offset_m: None,
    };
    Recording::new(Columns {
        channels: vec![
            channel("light", "lux", Some(vec![0.0])),
            channel("laser", "m", Some(beams)),
        ],
        values,
        stamp_s: (0..n).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        pose,
        run: vec![0; n],
        compass_rad: Some(vec![3.1; n]),
        route_m: Some((0..n).map(|k| 10.0 + k as f64).collect()),
        dataset_sha256: Some("of a file".into()),
        ..Columns::default()
    })
    .unwrap()
}

#[test]
fn a_moved_snapshot_is_moved_in_every_column() {
    let recording = drive();
    let views = Views::of(&recording).unwrap().unwrap();
    let steps = [step(0.5, 0.25, 10.0), step(-0.5, 0.0, 0.0)];
    let moved = views.moved(&[2, 0], &steps).unwrap();
    let c = moved.columns();
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(close(c.pose[0].x_m, -0.25) && close(c.pose[0].y_m, 2.5));
    assert!(close(
        c.pose[0].heading_rad,
        FRAC_PI_2 + 10_f64.to_radians()
    ));
    assert_eq!(c.odometry, c.pose);
    let route_m = c.route_m.as_ref().unwrap();
    assert!(close(route_m[0], 12.5) && close(route_m[1], 9.5));
    let compass_rad = c.compass_rad.as_ref().unwrap();
    assert!(close(compass_rad[0], 3.1 + 10_f64.to_radians() - TAU));
    assert_eq!((c.values[[0, 0]], c.values[[1, 0]]), (7.0, 7.0));
    assert!((c.values[[1, 91]] - 3.5).abs() < 1e-5);
    assert_eq!(c.dataset_sha256, None);
    assert!(views.moved(&[1, 2], &steps[..1]).is_err());
    assert!(views.moved(&[], &[]).is_err());
}

#[test]
fn a_way_back_and_a_standing_robot_have_their_directions() {
    let mut columns = drive().into_columns();
    columns.route_m = Some(vec![5.0, 4.0, 3.0, 2.0, 1.0, 0.0]);
    let back = Recording::new(columns).unwrap();
    let way = ways(&back, back.route_m().unwrap())[0];
    assert!(way[0].abs() < 1e-12 && (way[1] + 1.0).abs() < 1e-12);
    let still = back.select(&[3, 3, 3]).unwrap();
    let way = ways(&still, still.route_m().unwrap())[1];
    assert!(way[0].abs() < 1e-12 && (way[1] - 1.0).abs() < 1e-12);
}

#[test]
fn draws_repeat_themselves_and_have_the_deviations_asked_for() {
    let recording = drive();
    let views = Views::of(&recording).unwrap().unwrap();
    let snapshots: Vec<usize> = (0..5000).map(|k| k % 6).collect();
    let drawn = || {
        let mut random = Seed(4).stream("moved views");
        views.drawn(&snapshots, &Moves::default(), &mut random)
    };
    let (a, b) = (drawn().unwrap(), drawn().unwrap());
    assert_eq!(a.poses(), b.poses());
    assert_eq!(a.values(), b.values());
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let c = one_thread.unwrap().install(drawn).unwrap();
    assert_eq!(a.values(), c.values());
    let steps = Moves::default().draw(5000, &mut Seed(4).stream("moved views"));
    let deviation = |component: fn(&Displacement) -> f64| {
        (steps.iter().map(|s| component(s).powi(2)).sum::<f64>() / 5000.0).sqrt()
    };
    assert!((deviation(|s| s.forward_m) - 0.2).abs() < 0.01);
    assert!((deviation(|s| s.left_m) - 0.2).abs() < 0.01);
    assert!((deviation(|s| s.turn_rad).to_degrees() - 8.0).abs() < 0.4);
    let wrong = Moves {
        shift_m: -1.0,
        ..Moves::default()
    };
    assert!(wrong.check().unwrap_err().is_usage());
}

#[test]
fn a_recording_without_bearings_has_no_views() {
    let mut columns = drive().into_columns();
    columns.channels[1].bearing_rad = None;
    let blind = Recording::new(columns).unwrap();
    assert!(Views::of(&blind).unwrap().is_none());
}
