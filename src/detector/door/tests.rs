use super::*;
use crate::{
    geometry::Pose,
    recording::{Channel, Columns},
};

const WIDTH: usize = 4;

/// Sonars ahead, left, behind, right; and a camera whose middle columns have a brightness and a texture.
fn seen(snapshots: &[([f32; WIDTH], Option<[f32; 2]>)]) -> Recording {
    let sonar = Channel {
        name: "sonar".into(),
        width: WIDTH,
        unit: "m".into(),
        bearing_rad: Some((0..WIDTH).map(|i| i as f64 * FRAC_PI_2).collect()),
        maximum: Some(10.0),
        offset_m: None,
    };
    let camera = Channel {
        name: "camera".into(),
        width: 140,
        unit: "1".into(),
        bearing_rad: None,
        maximum: None,
        offset_m: None,
    };
    let (k, with_camera) = (snapshots.len(), snapshots[0].1.is_some());
    let value = |(k, i): (usize, usize)| {
        let (sonar, camera) = snapshots[k];
        match (i.checked_sub(WIDTH), camera) {
            (None, _) => sonar[i],
            (Some(98 | 105), Some([brightness, _])) => brightness, // 70 + 7 × 4 and 70 + 7 × 5
            (Some(102 | 109), Some([_, texture])) => texture,
            _ => 0.0,
        }
    };
    let width = WIDTH + if with_camera { 140 } else { 0 };
    Recording::new(Columns {
        channels: [sonar]
            .into_iter()
            .chain(with_camera.then_some(camera))
            .collect(),
        values: Array2::from_shape_fn((k, width), value),
        stamp_s: vec![0.0; k],
        pose: vec![Pose::default(); k],
        odometry: vec![Pose::default(); k],
        run: vec![0; k],
        ..Columns::default()
    })
    .unwrap()
}

fn fitted(recording: &Recording, side: Side) -> Door {
    let config = DoorConfig {
        side,
        ..DoorConfig::default()
    };
    let all: Vec<usize> = (0..recording.len()).collect();
    Door::fit(&config, recording, &all).unwrap()
}

const NONE: f32 = f32::NAN;

#[test]
fn by_sonar_alone_a_wall_farther_away_than_usual_is_a_door() {
    let walls = [
        [5.0, 0.9, 5.0, 1.0],
        [5.0, 1.2, 5.0, 0.7], // nearer to one side: the same distance of the walls
        [5.0, 0.9, 5.0, 1.0],
        [5.0, 0.9, 5.0, 4.0],  // open
        [5.0, 0.9, 5.0, NONE], // open, and nothing within reach
        [5.0, NONE, 5.0, 0.95],
    ];
    let recording = seen(&walls.map(|sonar| (sonar, None)));
    let door = fitted(&recording, Side::Right);
    assert!((door.between_walls_m - 1.9).abs() < 1e-6);
    let p = door.probabilities(&recording).unwrap();
    let (walls, doors) = ([0, 1, 2, 5], [3, 4]);
    assert!(walls.iter().all(|&k| p[[k, 0]] < 0.5), "{p}");
    assert!(doors.iter().all(|&k| p[[k, 0]] > 0.5), "{p}");
    // Worked by hand: a recess of 0, and of the most that counts.
    let logistic = |evidence: f64| 1.0 / (1.0 + (-evidence).exp());
    assert!((f64::from(p[[0, 0]]) - logistic(-0.6)).abs() < 1e-6);
    assert!((f64::from(p[[3, 0]]) - logistic(2.4)).abs() < 1e-6);
}

#[test]
fn to_a_camera_it_is_dark_and_grained_in_the_middle() {
    let wall = [5.0, 0.95, 5.0, 0.95];
    let looks = [
        [0.0, 0.1],
        [-0.4, 0.1],
        [0.0, 0.17],
        [-0.4, 0.16],
        [0.4, 0.1],
    ];
    let recording = seen(&looks.map(|look| (wall, Some(look))));
    let p = fitted(&recording, Side::Left)
        .probabilities(&recording)
        .unwrap();
    let is_door: Vec<bool> = p.iter().map(|&p| p > 0.5).collect();
    assert_eq!(is_door, [false, false, false, true, false], "{p}");
    assert!(p[[1, 0]] > p[[0, 0]] && p[[2, 0]] > p[[0, 0]] && p[[4, 0]] < p[[0, 0]]);
    // (.4 − .1)/.15 + (.16 − .13)/.03 + 0 − 1.5 = 1.5
    assert!((f64::from(p[[3, 0]]) - 1.0 / (1.0 + (-1.5f64).exp())).abs() < 1e-5);
}

#[test]
fn each_side_is_looked_at_for_itself() {
    let recording = seen(&[([5.0, 2.0, 5.0, NONE], None), ([5.0, 1.0, 5.0, 1.0], None)]);
    let on = |side| {
        let door = Door {
            between_walls_m: 2.0,
            ..fitted(&recording, side)
        };
        let p = door.probabilities(&recording).unwrap();
        [p[[0, 0]] > 0.5, p[[1, 0]] > 0.5]
    };
    assert_eq!(
        (on(Side::Left), on(Side::Right)),
        ([true, false], [true, false])
    );
    let near_left = seen(&[([5.0, 0.5, 5.0, NONE], None)]);
    let door = Door {
        between_walls_m: 2.0,
        ..fitted(&recording, Side::Left)
    };
    assert!(door.probabilities(&near_left).unwrap()[[0, 0]] < 0.5);
    let door = Door {
        between_walls_m: 2.0,
        ..fitted(&recording, Side::Right)
    };
    assert!(door.probabilities(&near_left).unwrap()[[0, 0]] > 0.5);
}

#[test]
fn missing_sensors_are_reported() {
    let silent = seen(&[([5.0, 1.0, 5.0, NONE], None)]);
    let error = Door::fit(&DoorConfig::default(), &silent, &[0]).unwrap_err();
    assert!(error.to_string().contains("both sides"), "{error}");
    let mut ahead = silent.into_columns();
    ahead.channels[0].bearing_rad = Some(vec![0.0, 0.1, 0.2, 0.3]);
    let ahead = Recording::new(ahead).unwrap();
    let error = Door::fit(&DoorConfig::default(), &ahead, &[0]).unwrap_err();
    assert!(error.to_string().contains("±90°"), "{error}");
    let odd = DoorConfig {
        texture_step: -1.0,
        ..DoorConfig::default()
    };
    let error = odd.check().unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("texture_step"));
}
