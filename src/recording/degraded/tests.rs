use super::*;
use crate::{
    geometry::Pose,
    recording::{Channel, Columns},
};
use ndarray::Array2;

/// A light sensor, a laser of 12 beams from −60° to 60°, a ring of 4 sonars, ranges to two beacons.
fn recording() -> Recording {
    let channel = |name: &str, unit: &str, bearing_deg: Option<Vec<f64>>, width, maximum| Channel {
        name: name.into(),
        width,
        unit: unit.into(),
        bearing_rad: bearing_deg.map(|all| all.into_iter().map(f64::to_radians).collect()),
        maximum,
        offset_m: None,
    };
    let fan = (0..12).map(|b| -60.0 + 120.0 * f64::from(b) / 11.0);
    let pose: Vec<Pose> = (0..3).map(|k| Pose::new(f64::from(k), 0.5, 0.1)).collect();
    // Every value differs: one of column c in row k is k + c / 2.
    let mut values = Array2::from_shape_fn((3, 19), |(k, c)| k as f32 + 0.5 * c as f32);
    values[(1, 4)] = f32::NAN;
    Recording::new(Columns {
        channels: vec![
            channel("light", "lux", None, 1, None),
            channel("laser", "m", Some(fan.collect()), 12, Some(30.0)),
            channel("sonar", "m", Some(vec![0.0, 90.0, 180.0, 270.0]), 4, None),
            channel("beacons", "m", None, 2, Some(50.0)),
        ],
        values,
        stamp_s: vec![0.0, 1.0, 2.0],
        odometry: pose.clone(),
        pose,
        run: vec![0, 0, 1],
        route_m: Some(vec![0.0, 1.0, 2.0]),
        compass_rad: Some(vec![0.1; 3]),
        source: Some("walk".into()),
        dataset_sha256: Some("of the file".into()),
        ..Columns::default()
    })
    .unwrap()
}

fn seen_by(degraded: Degraded) -> Recording {
    degraded.sensor(recording()).unwrap()
}

fn refused(degraded: Degraded) -> Error {
    degraded.sensor(recording()).unwrap_err()
}

fn widths(recording: &Recording) -> Vec<usize> {
    recording.channels().iter().map(|c| c.width).collect()
}

/// NaN is not NaN's equal.
fn bits(recording: &Recording) -> Array2<u32> {
    recording.values().mapv(f32::to_bits)
}

fn beams(count: usize) -> Degraded {
    Degraded {
        beams: Some(count),
        ..Degraded::default()
    }
}

fn blocked(sectors_deg: &[[f64; 2]]) -> Degraded {
    let in_rad = |sector: &[f64; 2]| sector.map(f64::to_radians);
    Degraded {
        blocked_rad: sectors_deg.iter().map(in_rad).collect(),
        ..Degraded::default()
    }
}

#[test]
fn nothing_said_changes_nothing() {
    let (before, after) = (recording(), seen_by(Degraded::default()));
    assert_eq!(bits(&after), bits(&before));
    assert_eq!(after.channels(), before.channels());
    assert_eq!(after.columns().degraded, None);
    let people = Degraded {
        people: Some(0.4), // before the tested part alone
        ..Degraded::default()
    };
    assert_eq!(bits(&seen_by(people)), bits(&before));
}

#[test]
fn beams_are_chosen_evenly_and_keep_readings_and_bearings() {
    let three = seen_by(beams(3));
    assert_eq!(widths(&three), [1, 3, 3, 2]);
    // The middle of each third: beams 2, 6, 10 of the laser; of four sonars 0, 2, 3.
    let columns = [0, 3, 7, 11, 13, 15, 16, 17, 18];
    let expected = recording().values().select(Axis(1), &columns);
    assert_eq!(three.values(), expected);
    let bearing_deg: Vec<f64> = three.channels()[1].bearing_rad.as_ref().unwrap()[..]
        .iter()
        .map(|bearing| (bearing.to_degrees() * 10.0).round() / 10.0)
        .collect();
    assert_eq!(bearing_deg, [-38.2, 5.5, 49.1]);
    assert_eq!(three.channels()[1].maximum, Some(30.0));
    let told = three.columns().degraded.as_ref().unwrap();
    assert_eq!(
        told.to_string(),
        "laser: 3 of 12 beams, sonar: 3 of 4 beams"
    );
    // More than there are.
    assert_eq!(widths(&seen_by(beams(6))), [1, 6, 4, 2]);
    assert_eq!(bits(&seen_by(beams(500))), bits(&recording()));
    // One is in the middle.
    let one = seen_by(beams(1));
    assert_eq!(one.values()[(0, 1)], 3.5); // beam 6 of the laser
    assert_eq!(bits(&one), bits(&seen_by(beams(1)))); // and each time the same
}

#[test]
fn beyond_the_reach_nothing_returns() {
    let near = |reach_m| Degraded {
        reach_m: Some(reach_m),
        ..Degraded::default()
    };
    let (before, after) = (recording(), seen_by(near(4.0)));
    let maxima: Vec<Option<f64>> = after.channels().iter().map(|c| c.maximum).collect();
    assert_eq!(maxima, [None, Some(4.0), Some(4.0), Some(50.0)]);
    assert_eq!(widths(&after), widths(&before));
    for ((k, c), &value) in before.values().indexed_iter() {
        let seen = after.values()[(k, c)];
        let is_range = (1..17).contains(&c);
        if (is_range && value >= 4.0) || value.is_nan() {
            assert!(seen.is_nan(), "snapshot {k}, value {c}: {seen}");
        } else {
            assert_eq!(seen, value, "snapshot {k}, value {c}");
        }
    }
    // Farther than the sensor reaches anyway.
    let far = seen_by(near(40.0));
    assert_eq!(bits(&far), bits(&before));
    assert_eq!(far.channels()[1].maximum, Some(30.0));
    let told = after.columns().degraded.as_ref().unwrap().to_string();
    assert!(told.ends_with("4 of 4 beams, reach 4 m"), "{told}");
}

#[test]
fn blocked_sectors_go_counter_clockwise_and_round_the_back() {
    let left = |sectors_deg: &[[f64; 2]]| -> Vec<f64> {
        let mut ring_alone = recording().into_columns();
        ring_alone.channels[1].bearing_rad = None;
        let ring_alone = Recording::new(ring_alone).unwrap();
        let seen = blocked(sectors_deg).sensor(ring_alone).unwrap();
        let bearing_rad = seen.channels()[2].bearing_rad.clone().unwrap();
        bearing_rad.iter().map(|b| b.to_degrees().round()).collect()
    };
    assert_eq!(left(&[[-20.0, 100.0]]), [180.0, 270.0]);
    assert_eq!(left(&[[170.0, -170.0]]), [0.0, 90.0, 270.0]); // wraps at 180°
    assert_eq!(left(&[[-190.0, -170.0]]), [0.0, 90.0, 270.0]); // the same
    assert_eq!(left(&[[260.0, 280.0]]), [0.0, 90.0, 180.0]);
    assert_eq!(left(&[[-100.0, -80.0]]), [0.0, 90.0, 180.0]); // 270° is −90°
    assert_eq!(left(&[[90.0, 90.0]]), [0.0, 180.0, 270.0]); // both ends count
    assert_eq!(left(&[[100.0, 80.0]]), [90.0]); // all but ahead of it
    assert_eq!(left(&[[80.0, 100.0], [-10.0, 10.0]]), [180.0, 270.0]);
    // The laser's beams go with the sonar's; what has no bearings stays.
    let seen = seen_by(blocked(&[[-20.0, 20.0]]));
    assert_eq!(widths(&seen), [1, 8, 3, 2]);
    assert_eq!(seen.values()[(0, 13)], recording().values()[(0, 18)]);
}

#[test]
fn a_beam_stays_where_all_keys_leave_it() {
    let all = Degraded {
        beams: Some(4),
        reach_m: Some(5.0),
        ..blocked(&[[-70.0, 0.0]])
    };
    let seen = seen_by(all);
    // Of beams 1, 4, 7, 10 of the laser two look to the left; of four sonars the one ahead goes.
    assert_eq!(widths(&seen), [1, 2, 3, 2]);
    assert_eq!(seen.values()[(0, 1)], 4.0);
    assert!(seen.values()[(0, 2)].is_nan()); // 5.5 m
    let told = seen.columns().degraded.as_ref().unwrap();
    let words = told.to_string();
    assert!(
        words
            .starts_with("laser: 2 of 12 beams, sonar: 3 of 4 beams, reach 5 m, blocked from -1.2"),
        "{words}"
    );
    let text = serde_json::to_string(told).unwrap();
    let again: Degradation = serde_json::from_str(&text).unwrap();
    assert_eq!(&again, told);
}

#[test]
fn it_is_the_same_recording() {
    let (before, after) = (recording().into_columns(), seen_by(beams(2)).into_columns());
    assert_eq!(after.pose, before.pose);
    assert_eq!(after.odometry, before.odometry);
    assert_eq!(after.run, before.run);
    assert_eq!(
        (&after.stamp_s, &after.route_m, &after.compass_rad),
        (&before.stamp_s, &before.route_m, &before.compass_rad)
    );
    assert_eq!(after.dataset_sha256, before.dataset_sha256);
    assert_eq!(after.source, before.source);
    let part = seen_by(beams(2)).select(&[2]).unwrap();
    assert!(part.columns().degraded.is_some());
}

#[test]
fn values_that_make_no_sense_are_named() {
    let reach = |reach_m| Degraded {
        reach_m: Some(reach_m),
        ..Degraded::default()
    };
    let people = |share| Degraded {
        people: Some(share),
        ..Degraded::default()
    };
    let sector = |from, to| Degraded {
        blocked_rad: vec![[0.0, 0.1], [from, to]],
        ..Degraded::default()
    };
    for (degraded, key) in [
        (beams(0), "degraded.beams = 0"),
        (reach(0.0), "degraded.reach_m = 0"),
        (reach(-1.0), "degraded.reach_m = -1"),
        (reach(f64::NAN), "degraded.reach_m = NaN"),
        (reach(f64::INFINITY), "degraded.reach_m = inf"),
        (
            sector(0.0, 7.0),
            "degraded.blocked_rad: the sector [0.0, 7.0]",
        ),
        (sector(f64::NAN, 0.0), "degraded.blocked_rad: the sector"),
        (people(1.5), "degraded.people = 1.5"),
        (people(f64::NAN), "degraded.people = NaN"),
    ] {
        let error = refused(degraded);
        let words = error.to_string();
        assert!(error.is_usage() && words.starts_with(key), "{words}");
        assert!(words.contains("expected"), "{words}");
    }
}

#[test]
fn a_sensor_without_beams_is_none() {
    for all_round in [[-180.0, 180.0], [0.0, 360.0], [-60.0, 60.0]] {
        let words = refused(blocked(&[all_round])).to_string();
        assert!(
            words.contains("degraded.blocked_rad: no beam of channel `laser` is left"),
            "{words}"
        );
    }
    let mut blind = recording().into_columns();
    for channel in &mut blind.channels {
        channel.bearing_rad = None;
    }
    let blind = Recording::new(blind).unwrap();
    let error = beams(2).sensor(blind.clone()).unwrap_err();
    assert!(!error.is_usage());
    assert!(
        error
            .to_string()
            .contains("degraded: no channel in metres has bearings"),
        "{error}"
    );
    assert!(Degraded::default().sensor(blind).is_ok());
}

#[test]
fn people_may_be_said_by_another_key() {
    let people = |own, other| {
        let degraded = Degraded {
            people: own,
            ..Degraded::default()
        };
        degraded.people_or(other, "localise.people")
    };
    assert_eq!(people(None, None).unwrap(), None);
    assert_eq!(people(Some(0.3), None).unwrap(), Some(0.3));
    assert_eq!(people(None, Some(0.3)).unwrap(), Some(0.3));
    assert_eq!(people(Some(0.3), Some(0.3)).unwrap(), Some(0.3));
    let error = people(Some(0.3), Some(0.0)).unwrap_err();
    let words = error.to_string();
    assert!(error.is_usage(), "{words}");
    assert!(
        words.starts_with("degraded.people = 0.3 and localise.people = 0:"),
        "{words}"
    );
}
