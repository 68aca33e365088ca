use super::*;
use crate::{
    recogniser::{Config, Kind, Learned, histogram_match::HistogramMatch, learn},
    recording::{Columns, npz},
};

const BOTH: [Kind; 2] = [Kind::GridMatch, Kind::HistogramMatch];

/// The recording that comes with the crate, with a compass that tells the heading or without.
fn corridor(compass: bool) -> Recording {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/corridor-small.npz");
    let columns = npz::read(path.as_ref()).unwrap().into_columns();
    let headings = columns.pose.iter().map(|pose| pose.heading_rad).collect();
    Recording::new(Columns {
        compass_rad: compass.then_some(headings),
        ..columns
    })
    .unwrap()
}

fn places(learned: &Learned) -> &[Pose] {
    match learned {
        Learned::GridMatch(learned) => learned.places(),
        Learned::HistogramMatch(learned) => HistogramMatch::places(learned),
        _ => panic!("neither grids nor histograms"),
    }
}

/// How many snapshots of later runs are answered with a place less than 1.5 m away, of how many.
fn right(kind: Kind, recording: &Recording) -> (usize, usize) {
    let first: Vec<usize> = recording.runs()[0].clone().collect();
    let later: Vec<usize> = (first.len()..recording.len()).collect();
    let learned = learn(&kind.default_config(), recording, &first, Seed(1)).unwrap();
    let recogniser = learned.as_recogniser();
    let turns = if recording.columns().compass_rad.is_some() {
        1
    } else {
        4
    };
    assert_eq!(recogniser.matches(), turns * recogniser.responses());
    let answers = recogniser.respond_all(recording, &later);
    let near = |(answer, k): &(&Option<Response>, &usize)| {
        let here = recording.poses()[**k];
        answer.is_some_and(|a| places(&learned)[a.class].distance_m(&here) < 1.5)
    };
    (answers.iter().zip(&later).filter(near).count(), later.len())
}

/// 24 sonars tell little, but several times more than chance, which is right 3 m in 89; and a compass helps.
#[test]
fn places_of_the_first_run_are_known_again_in_the_others() {
    for kind in BOTH {
        let (without, of) = right(kind, &corridor(false));
        let (with, _) = right(kind, &corridor(true));
        let chance = of as f64 * 3.0 / 89.0;
        assert!(without as f64 > 2.0 * chance, "{kind}: {without} of {of}");
        assert!(with as f64 > 4.0 * chance, "{kind}: {with} of {of}");
        assert!(with > without, "{kind}: {with} and {without}");
    }
}

#[test]
fn a_turned_robot_is_at_the_same_place() {
    for (kind, compass) in BOTH.into_iter().zip([true, false]) {
        let recording = corridor(compass);
        let first: Vec<usize> = recording.runs()[0].clone().collect();
        let learned = learn(&kind.default_config(), &recording, &first, Seed(1)).unwrap();
        // Turned left by six of 24 sonars, a quarter: reading i is now that of the sonar six further on.
        let mut turned = recording.clone().into_columns();
        for (mut row, before) in turned
            .values
            .rows_mut()
            .into_iter()
            .zip(recording.values().rows())
        {
            (0..24).for_each(|i| row[i] = before[(i + 6) % 24]);
        }
        let quarter = std::f64::consts::FRAC_PI_2;
        turned
            .compass_rad
            .iter_mut()
            .flatten()
            .for_each(|c| *c += quarter);
        let turned = Recording::new(turned).unwrap();
        let recogniser = learned.as_recogniser();
        let before = recogniser.respond_all(&recording, &first);
        let after = recogniser.respond_all(&turned, &first);
        let class = |answer: &Option<Response>| answer.map(|a| a.class);
        let same = before
            .iter()
            .zip(&after)
            .filter(|(b, a)| class(b) == class(a));
        // All but where rounding moves a reading from one cell to another.
        assert!(same.count() * 10 > first.len() * 9, "{kind}");
    }
}

#[test]
fn constants_that_make_no_sense_are_named_and_damage_is_refused() {
    for (config, key) in [
        (
            "kind = 'grid_match'\nreach_cells = 64",
            "grid_match.reach_cells = 64",
        ),
        (
            "kind = 'grid_match'\nspacing_m = 0.0",
            "grid_match.spacing_m = 0",
        ),
        (
            "kind = 'histogram_match'\nspacing_m = nan",
            "histogram_match.spacing_m",
        ),
        (
            "kind = 'histogram_match'\nscan.sonar_opening_rad = 7.0",
            "scan.sonar_opening_rad = 7",
        ),
        (
            "kind = 'grid_match'\nscan.reading.range_error_m = 0.0",
            "scan.reading.range_error_m",
        ),
        (
            "kind = 'grid_match'\nscan.reading.minimum_m = -1.0",
            "scan.reading.minimum_m",
        ),
    ] {
        let config: Config = toml::from_str(config).unwrap();
        let error = config.check().unwrap_err();
        assert!(
            error.is_usage() && error.to_string().starts_with(key),
            "{error}"
        );
    }
    let recording = corridor(false);
    let mut grids =
        GridMatch::learn(&GridMatchConfig::default(), &recording, &[0, 40], Seed(1)).unwrap();
    grids.poses.pop();
    assert!(
        Learn::check(&grids)
            .unwrap_err()
            .to_string()
            .contains("2 grids for 1")
    );
    assert!(serde_json::from_str::<States>("[[1, 1]]").is_err());
    let both = format!("[{}]", ["[3, 4]"; 64].join(","));
    assert!(serde_json::from_str::<States>(&both).is_ok());
    let both = both.replacen("[3, 4]", "[3, 1]", 1); // one cell occupied and empty
    let error = serde_json::from_str::<States>(&both)
        .unwrap_err()
        .to_string();
    assert!(error.contains("both occupied and empty"), "{error}");
}
