use super::*;
use crate::{
    seed::Seed,
    world::{
        WorldConfig,
        corridor::{self, CorridorConfig},
        simulation::{Choice, simulate},
    },
};

/// One run of a set of Thrun's corridor with so many snapshots, judged on all of them.
fn judged(set: &str, snapshots: usize, seed: u64) -> LandmarkRecord {
    let mut world = WorldConfig::parse(corridor::WORLD).unwrap();
    for set in &mut world.set {
        (set.runs, set.snapshots) = (Some(1), Some(snapshots));
    }
    let building = Building::new(&world, None).unwrap();
    let choice = Choice {
        set: Some(set.into()),
        runs: None,
    };
    let recording = simulate(&building, Seed(seed), &choice).unwrap();
    let all: Vec<usize> = (0..recording.len()).collect();
    let config = LandmarksConfig::default();
    let records = judge(&building, Some(set), &recording, &all, &all, &config).unwrap();
    assert_eq!((records.len(), records[0].snapshots), (1, snapshots));
    records[0].clone()
}

fn assert_near(record: &LandmarkRecord, detector: &str, [precision, recall]: [f64; 2]) {
    assert_eq!(record.detector, detector);
    let near = |share: Option<f64>, expected: f64| (share.unwrap() - expected).abs() < 0.1;
    assert!(near(record.precision, precision), "{record:?}");
    assert!(near(record.recall, recall), "{record:?}");
}

/// What the detectors' own pages say of them, on a run of each set.
#[test]
fn thruns_doors_and_lamps_are_found_as_well_as_is_said() {
    assert_near(&judged("d1", 360, 1), "door", [0.77, 0.83]);
    assert_near(&judged("d2", 360, 1), "door", [0.42, 0.84]);
    assert_near(&judged("d3", 180, 1), "ceiling_light", [0.99, 0.95]);
}

#[test]
fn doors_by_sonar_alone_are_of_the_side_that_is_asked_for() {
    let config = CorridorConfig {
        runs: 4,
        spacing_m: 0.25,
    };
    let building = corridor::building(&config).unwrap();
    let recording = corridor::thrun1998(Seed(1), &config).unwrap();
    let all: Vec<usize> = (0..recording.len()).collect();
    let on = |side| {
        let mut config = LandmarksConfig::default();
        config.door.side = side;
        judge(&building, None, &recording, &all, &all, &config).unwrap()[0].clone()
    };
    assert_near(&on(Side::Right), "door", [0.55, 0.68]);
    assert_near(&on(Side::Left), "door", [0.27, 0.77]);
}

#[test]
fn answers_are_counted_by_what_they_are() {
    let answers = [
        (3, true, true),
        (2, false, true),
        (1, true, false),
        (4, false, false),
    ];
    let repeated = answers
        .into_iter()
        .flat_map(|(times, is_there, is_said)| std::iter::repeat_n((is_there, is_said), times));
    let record = LandmarkRecord::of("door", repeated);
    let counts = (record.true_positives, record.false_positives, record.missed);
    assert_eq!((record.snapshots, counts), (10, (3, 2, 1)));
    assert_eq!((record.precision, record.recall), (Some(0.6), Some(0.75)));
    let none = LandmarkRecord::of("door", [(false, false)].into_iter());
    assert_eq!((none.precision, none.recall), (None, None));
}

#[test]
fn what_cannot_be_judged_is_told() {
    let small = CorridorConfig {
        runs: 1,
        spacing_m: 2.0,
    };
    let building = corridor::building(&small).unwrap();
    let recording = corridor::thrun1998(Seed(1), &small).unwrap();
    let all: Vec<usize> = (0..recording.len()).collect();
    let config = LandmarksConfig::default();
    let refusal = |building: &Building, set, testing: &[usize], config: &_| {
        judge(building, set, &recording, &all, testing, config)
            .unwrap_err()
            .to_string()
    };
    let mut world = WorldConfig::parse(corridor::WORLD).unwrap();
    let whole = Building::new(&world, None).unwrap();
    assert!(refusal(&whole, None, &all, &config).contains("expected one of d1, d2, d3"));
    assert!(refusal(&whole, Some("d4"), &all, &config).contains("no set `d4`"));
    // The corridor's set has a camera, the recording has none.
    assert!(refusal(&whole, Some("d3"), &all, &config).contains("`camera`"));
    assert!(refusal(&building, None, &[9_999], &config).contains("snapshot 9999"));
    world.name = "thrun".into();
    let other = Building::new(&world, None).unwrap();
    assert!(
        refusal(&other, Some("d1"), &all, &config).contains("expected `simulated world thrun`")
    );
    let odd = LandmarksConfig {
        lamp_within_m: f64::NAN,
        ..config
    };
    assert!(refusal(&building, None, &all, &odd).contains("lamp_within_m"));
}
