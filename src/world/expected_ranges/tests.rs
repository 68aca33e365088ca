use super::*;
use crate::world::simulate;
use ndarray::Array1;

/// A hall of 9 m by 4 m with a low bench, a glass wall across, and a robot with both kinds of sensors.
fn hall(sensors: &str) -> Building {
    let text = format!(
        r#"
        name = "hall"
        [[wall]]
        points = [[0, 0], [9, 0], [9, 4], [0, 4]]
        closed = true
        [[wall]]
        points = [[0, 3.5], [9, 3.5]]
        high_m = 0.3
        [[wall]]
        points = [[7, 0], [7, 4]]
        material = "glass"
        [path]
        corners = [[1, 1], [5, 1]]
        [record]
        every_m = 0.5
        {sensors}
        "#
    );
    Building::from_text(&text).unwrap()
}

const BOTH: &str = r#"
    [robot]
    odometry = { translation_noise_m = 0.0 }
    [sonar]
    beams = 12
    plain = true
    ring_radius_m = 0.2
    height_m = 0.2
    opening_rad = 0.5
    maximum_m = 6.0
    axis_sd_rad = 0.0
    noise_m = 0.0
    noise_per_m = 0.0
    resolution_m = 0.0
    short_probability = 0.0
    lost_probability = 0.0
    [laser]
    beams = 4
    field_of_view_rad = 6.283185307179586
    ahead_m = 0.0
    height_m = 0.5
    noise_m = 0.0
    noise_per_m = 0.0
    resolution_m = 0.0
    short_probability = 0.0
    lost_probability = 0.0
    [compass]
"#;

fn expected(building: &Building) -> (ExpectedRanges, crate::recording::Recording) {
    let recording = simulate(building, Seed(1), &Default::default()).unwrap();
    let expected = ExpectedRanges::new(building, recording.channels(), Seed(1)).unwrap();
    (expected, recording)
}

#[test]
fn what_is_expected_is_what_an_undisturbed_robot_senses() {
    let (expected, recording) = expected(&hall(BOTH));
    for (k, pose) in recording.poses().iter().enumerate() {
        let values = recording.observation(k).values;
        let sensed = expected.sensed(recording.channels(), values).unwrap();
        let at = expected.at(pose);
        assert_eq!(at.len(), 16);
        for (value, (a, b)) in at.iter().zip(&sensed).enumerate() {
            assert!((a - b).abs() < 1e-5, "{k}, {value}: {a} {b}");
        }
    }
    // 2 m before the glass, which the sonar hears and the laser looks through; the bench lies below the laser.
    let at = expected.at(&Pose::new(5.0, 1.0, 0.0));
    assert!((at[0] - 1.8).abs() < 1e-9, "{at:?}");
    assert!((at[3] - 2.3).abs() < 1e-9, "{at:?}");
    // Beams at −135°, −45°, 45° and 135°: the floor plan's south wall, twice, then the north wall.
    let aside = 2_f64.sqrt();
    for (beam, metres) in [aside, aside, 3.0 * aside, 3.0 * aside].iter().enumerate() {
        assert!((at[12 + beam] - metres).abs() < 1e-9, "{at:?}");
    }
}

#[test]
fn walls_out_of_reach_make_no_difference() {
    let (expected, _) = expected(&hall(BOTH));
    for (x_m, y_m) in [(1.0, 1.0), (5.0, 2.0), (8.5, 3.0), (-200.0, 0.0)] {
        let centre = Pose::new(x_m, y_m, 0.3);
        let near = expected.near(&centre, 0.5);
        for (dx, dy) in [(0.0, 0.0), (0.3, 0.4), (-0.5, 0.0)] {
            let pose = Pose::new(x_m + dx, y_m + dy, 2.0);
            assert_eq!(near.at(&pose), expected.at(&pose));
        }
    }
}

#[test]
fn distances_are_broken_off_only_where_they_are_too_long() {
    let (expected, recording) = expected(&hall(BOTH));
    let sensed = expected
        .sensed(recording.channels(), recording.observation(2).values)
        .unwrap();
    let pose = Pose::new(2.5, 1.2, 0.1);
    let apart = expected.at(&pose).into_iter().zip(&sensed);
    let square: f64 = apart.map(|(a, b)| (a - b) * (a - b)).sum();
    let squared = |most: f64| expected.square_distance(&pose, &sensed, most);
    assert!((squared(f64::INFINITY).unwrap() - square).abs() < 1e-12);
    assert!(squared(square * 1.001).is_some() && squared(square * 0.999).is_none());
    assert_eq!(
        squared(squared(f64::INFINITY).unwrap()),
        None,
        "as far is no nearer"
    );
}

#[test]
fn no_return_is_the_longest_reading_and_nothing_at_all_is_none() {
    let (expected, recording) = expected(&hall(BOTH));
    let sensed =
        |values: Vec<f32>| expected.sensed(recording.channels(), Array1::from(values).view());
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX];
    for value in odd {
        assert_eq!(sensed(vec![value; 16]), None, "{value}");
    }
    let mut values = vec![f32::NAN; 16];
    values[3] = 1.5;
    let seen = sensed(values).unwrap();
    assert_eq!((seen[0], seen[3], seen[12]), (6.0, 1.5, 20.0));
    assert_eq!(sensed(vec![1.0; 3]), None, "too few values");
}

#[test]
fn channels_of_other_sensors_are_passed_over_or_told() {
    let building = hall(BOTH);
    let (_, recording) = expected(&building);
    let mut channels = recording.channels().to_vec();
    let new = |channels: &[Channel]| ExpectedRanges::new(&building, channels, Seed(1));
    channels[1].name = "camera".into();
    let sonar_alone = new(&channels).unwrap();
    assert_eq!(sonar_alone.at(&Pose::new(5.0, 1.0, 0.0)).len(), 12);
    sonar_alone.check_channels(recording.channels()).unwrap();
    channels[0].bearing_rad.as_mut().unwrap()[4] += 0.1;
    let error = new(&channels).unwrap_err().to_string();
    assert!(error.contains("no channel among sonar, camera"), "{error}");
    let error = sonar_alone
        .check_channels(&channels)
        .unwrap_err()
        .to_string();
    assert!(error.contains("channel `sonar`"), "{error}");
    let error = sonar_alone
        .check_channels(&channels[1..])
        .unwrap_err()
        .to_string();
    assert!(error.contains("no channel `sonar`"), "{error}");
}

#[test]
fn a_file_holds_the_walls_and_is_checked() {
    let (expected, _) = expected(&hall(BOTH));
    let text = serde_json::to_string(&expected).unwrap();
    let read: ExpectedRanges = serde_json::from_str(&text).unwrap();
    for pose in [Pose::new(5.0, 1.0, 0.0), Pose::new(1.0, 3.0, 2.0)] {
        assert_eq!(read.at(&pose), expected.at(&pose));
    }
    let damaged = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        let read = serde_json::from_str::<ExpectedRanges>(&text.replacen(from, to, 1));
        read.unwrap_err().to_string()
    };
    assert!(damaged("\"beams\":12", "\"beams\":13").contains("not that of its sensor"));
    assert!(damaged("\"beams\":12", "\"beams\":0").contains("beams"));
    assert!(damaged("[0.0,0.0,9.0,0.0]", "[0.0,0.0,0.0,0.0]").contains("wall 0"));
    let none = serde_json::from_str::<ExpectedRanges>("{\"sensors\":[]}");
    assert!(none.unwrap_err().to_string().contains("no sensor"));
}

#[test]
fn rebounds_and_cross_talk_are_never_expected() {
    let real = BOTH.replace(
        "plain = true",
        "plain = false\nfiring = [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]]",
    );
    let (expected, _) = expected(&hall(&real));
    // The south wall slants away at 40°: as a mirror it throws nothing back, and yet its nearest point in the cone counts.
    let aside = 40_f64.to_radians();
    let at = expected.at(&Pose::new(4.0, 1.0, -aside));
    let nearest_m = (1.0 - 0.2 * aside.sin()) / (aside + 0.25).sin();
    assert!((at[0] - nearest_m).abs() < 1e-9, "{at:?}");
}
