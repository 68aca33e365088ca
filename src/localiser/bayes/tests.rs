use super::*;
use crate::{
    detector::{
        input::{Input, InputConfig},
        net::{NetConfig, Weights},
    },
    localiser::{Estimate, Step},
    recording::{Columns, npz},
};
use std::path::Path;

/// Three runs along the corridor of Thrun (1998), none of which the shipped models have seen.
fn corridor() -> Recording {
    npz::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz")).unwrap()
}

fn shipped() -> BayesConfig {
    BayesConfig {
        model: Path::new(env!("CARGO_MANIFEST_DIR")).join("models/corridor-global.safetensors"),
        ..BayesConfig::default()
    }
}

fn first_run(recording: &Recording) -> Vec<usize> {
    recording.runs()[0].clone().collect()
}

/// Trials of 50 snapshots, 25 m, from all over the second and third run.
fn trials(recording: &Recording) -> Vec<Vec<usize>> {
    let runs = recording.runs();
    let starts = runs[1..]
        .iter()
        .flat_map(|run| (run.start..run.end - 50).step_by(16));
    starts.map(|start| (start..start + 50).collect()).collect()
}

fn play(bayes: &Bayes, recording: &Recording, trial: &[usize]) -> Vec<Step> {
    let player = bayes.prepare(recording, trial).unwrap();
    player
        .play(trial, None, &mut Seed(1).stream("a trial"))
        .unwrap()
}

fn error_m(recording: &Recording, k: usize, step: &Step) -> f64 {
    let Some(Estimate::Place([x_m, y_m])) = step.estimate else {
        panic!("no place")
    };
    recording.poses()[k].distance_m(&Pose::new(x_m, y_m, 0.0))
}

/// Median error at the end of all trials.
fn median_error_m(bayes: &Bayes, recording: &Recording) -> f64 {
    let end = |trial: &Vec<usize>| {
        let steps = play(bayes, recording, trial);
        error_m(recording, trial[49], &steps[49])
    };
    let mut errors: Vec<f64> = trials(recording).iter().map(end).collect();
    errors.sort_by(f64::total_cmp);
    errors[errors.len() / 2]
}

#[test]
fn a_lost_robot_finds_its_place_along_the_route() {
    let recording = corridor();
    let bayes = Bayes::learn(&shipped(), &recording, &first_run(&recording), Seed(0)).unwrap();
    assert_eq!(bayes.places(), 2853);
    assert_eq!(bayes.bytes_per_place(), 3 * 8 + 8 + 4 * 4);
    assert!(median_error_m(&bayes, &recording) < 0.5);
    let trial = &trials(&recording)[0];
    let steps = play(&bayes, &recording, trial);
    for step in &steps {
        let total: f64 = step.posterior.iter().map(|(_, p)| p).sum();
        assert!((total - 1.0).abs() < 1e-9 && step.posterior.iter().all(|(_, p)| *p > 0.0));
    }
    // It begins nowhere in particular, and ends with most of its belief in a few places.
    let within = |step: &Step| {
        let Some(Estimate::Place(at)) = step.estimate else {
            panic!()
        };
        let near = step
            .posterior
            .iter()
            .filter(|(place, _)| (place[0] - at[0]).hypot(place[1] - at[1]) < 2.0);
        near.map(|(_, p)| p).sum::<f64>()
    };
    assert!(within(&steps[0]) < 0.5 && within(&steps[49]) > 0.8);
}

#[test]
fn a_place_along_the_route_is_where_the_mapped_places_around_it_are() {
    let recording = corridor();
    let bayes = Bayes::learn(&shipped(), &recording, &first_run(&recording), Seed(0)).unwrap();
    let along = recording.route_m().unwrap();
    for (&x_m, pose) in along.iter().zip(recording.poses()) {
        let truth = Places::Route(vec![x_m]);
        let [x, y] = bayes.sites.place(bayes.grid.cell_at(&truth, 0).unwrap());
        let apart_m = pose.distance_m(&Pose::new(x, y, 0.0));
        // Half a cell along it, and as much aside as robots swerve.
        assert!(apart_m < 0.5, "{apart_m} at {x_m}");
    }
}

/// The corridor in the plane, with a compass whose zero is 0.7 rad off and which errs to and fro; and what the shipped
/// filters answer on the first run as its map.
fn in_the_plane() -> (Recording, Known) {
    let recording = corridor().in_the_plane();
    let known: Known = Model::read(&shipped().model).unwrap().into();
    let first = first_run(&recording);
    let answers = known.filters.probabilities(&recording).unwrap();
    let row = |k: &usize| answers.row(*k).to_vec();
    let known = Known {
        pose: first.iter().map(|&k| recording.poses()[k]).collect(),
        route_m: None,
        activation: first.iter().map(row).collect(),
        ..known
    };
    let compass = recording.poses().iter().enumerate();
    let compass = compass.map(|(k, pose)| pose.heading_rad + 0.7 + 0.1 * (k as f64).sin());
    let recording = Recording::new(Columns {
        compass_rad: Some(compass.collect()),
        ..recording.clone().into_columns()
    });
    (recording.unwrap(), known)
}

/// Cells of half a metre and 45°: a test need not wait for more.
fn coarse() -> BayesConfig {
    let grid = GridConfig {
        cell_m: 0.5,
        headings: 8,
        ..GridConfig::default()
    };
    BayesConfig { grid, ..shipped() }
}

#[test]
fn in_the_plane_the_compass_tells_north() {
    let (recording, known) = in_the_plane();
    let first = first_run(&recording);
    let with =
        |config: &BayesConfig| Bayes::new(config, known.clone(), &recording, &first).unwrap();
    let bayes = with(&coarse());
    assert!((bayes.compass_zero_rad.unwrap() + 0.7).abs() < 0.02);
    assert!(median_error_m(&bayes, &recording) < 1.0);
    // Where its zero is set behind, all headings are wrong, and so is the way that the robot goes.
    let with_zero = |compass_zero_rad| {
        let saved = Saved {
            compass_zero_rad,
            ..bayes.clone().into()
        };
        Bayes::try_from(saved).unwrap()
    };
    let turned = with_zero(bayes.compass_zero_rad.map(|zero| zero + 3.0));
    assert!(median_error_m(&turned, &recording) > 3.0);
    // An sd past all turns says nothing: as if there were none.
    let deaf = with(&BayesConfig {
        compass_sd_rad: 1e9,
        ..coarse()
    });
    let without = with_zero(None);
    let trial = &trials(&recording)[3];
    let places = |bayes: &Bayes| -> Vec<Option<Estimate>> {
        let steps = play(bayes, &recording, trial);
        steps.iter().map(|step| step.estimate).collect()
    };
    assert_eq!(places(&deaf), places(&without));
}

#[test]
fn a_map_of_elsewhere_or_of_what_is_asked_later_is_refused() {
    let (recording, known) = in_the_plane();
    let first = first_run(&recording);
    let refusal = |known: Known, snapshots: &[usize]| {
        let refused = Bayes::new(&coarse(), known, &recording, snapshots);
        refused.unwrap_err().to_string()
    };
    let mut moved = known.clone();
    moved.pose.iter_mut().for_each(|pose| pose.y_m += 300.0);
    let error = refusal(moved, &first);
    assert!(error.starts_with("0 of 180 snapshots"), "{error}");
    // Learning from the second run alone, which is at the same places, the first should not be known.
    let second: Vec<usize> = recording.runs()[1].clone().collect();
    let error = refusal(known.clone(), &second);
    assert!(error.contains("180 snapshots of this recording"), "{error}");
}

#[test]
fn a_route_that_the_recording_does_not_have_is_left_out() {
    let (recording, known) = in_the_plane();
    let on_route = Known {
        route_m: Some(vec![0.0; 180]),
        ..known
    };
    let bayes = Bayes::new(&coarse(), on_route, &recording, &first_run(&recording)).unwrap();
    assert!(bayes.known.route_m.is_none() && bayes.grid.headings() == 8);
}

#[test]
fn what_a_file_holds_is_checked_and_answers_the_same() {
    let (recording, known) = in_the_plane();
    let bayes = Bayes::new(&coarse(), known, &recording, &first_run(&recording)).unwrap();
    let text = serde_json::to_string(&bayes).unwrap();
    let read: Bayes = serde_json::from_str(&text).unwrap();
    let trial = &trials(&recording)[1][..20];
    assert_eq!(
        play(&read, &recording, trial),
        play(&bayes, &recording, trial)
    );
    let damaged = |from: &str, to: &str| {
        let text = text.replacen(from, to, 1);
        serde_json::from_str::<Bayes>(&text)
            .unwrap_err()
            .to_string()
    };
    assert!(
        damaged("\"activation\":[[", "\"activation\":[[0.5,").contains("5 activations of a place")
    );
    assert!(
        damaged("\"activation\":[[", "\"activation\":[[0.5,0.5,0.5,0.5],[")
            .contains("181 activations")
    );
    assert!(damaged("\"headings\":8", "\"headings\":0").contains("headings"));
    assert!(damaged("\"compass_sd_rad\":0.2", "\"compass_sd_rad\":0.0").contains("compass_sd_rad"));
    assert!(damaged("\"trunk\":4", "\"trunk\":5").contains("filters"));
}

#[test]
fn scans_past_all_bounds_say_nothing() {
    let recording = corridor();
    let on_ranges = Bayes::learn(&shipped(), &recording, &first_run(&recording), Seed(0)).unwrap();
    let trial = &trials(&recording)[0][..10];
    for odd in [f32::NAN, f32::INFINITY, f32::MAX, f32::MIN] {
        let mut columns = recording.clone().into_columns();
        columns.values.fill(odd);
        let recording = Recording::new(columns).unwrap();
        let steps = play(&on_ranges, &recording, trial);
        assert!(steps.iter().all(|step| step.estimate.is_some()));
    }
    // Ranges are clipped; values of other units are not.
    let (recording, known) = in_the_plane();
    let mut columns = recording.into_columns();
    columns.channels[0].unit = "V".into();
    let recording = Recording::new(columns.clone()).unwrap();
    let first = first_run(&recording);
    let model = Model::read(&shipped().model).unwrap();
    let input = Input::fit(&InputConfig::default(), &recording, &first).unwrap();
    let mut random = Seed(1).stream("weights");
    let weights = Weights::random(
        &NetConfig::default(),
        input.width(),
        model.features(),
        &mut random,
    );
    let known = Known {
        filters: Filters::new(input, weights),
        ..known
    };
    let bayes = Bayes::new(&coarse(), known, &recording, &first).unwrap();
    columns.values.fill(f32::INFINITY);
    let steps = play(&bayes, &Recording::new(columns).unwrap(), trial);
    assert!(steps.iter().all(|step| step.estimate.is_some()));

    let mut gone = corridor().channels().to_vec();
    gone[0].name = "infrared".into();
    let error = on_ranges.check_channels(&gone).unwrap_err().to_string();
    assert!(error.contains("no channel `sonar`"), "{error}");
}

#[test]
fn constants_that_make_no_sense_are_named() {
    let refused = |config: BayesConfig, key: &str| {
        let error = config.check().unwrap_err();
        assert!(
            error.is_usage() && error.to_string().contains(key),
            "{error}"
        );
    };
    refused(BayesConfig::default(), "bayes.model");
    for compass_sd_rad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(
            BayesConfig {
                compass_sd_rad,
                ..shipped()
            },
            "compass_sd_rad",
        );
    }
    let motion = OdometryMotion {
        stall_probability: 2.0,
        ..OdometryMotion::default()
    };
    refused(
        BayesConfig {
            motion: Some(motion),
            ..shipped()
        },
        "stall_probability",
    );
    let grid = GridConfig {
        cell_m: 0.0,
        ..GridConfig::default()
    };
    refused(BayesConfig { grid, ..shipped() }, "cell_m");
    let missing = BayesConfig {
        model: "no-such-model.safetensors".into(),
        ..shipped()
    };
    let error = Bayes::learn(&missing, &corridor(), &[0], Seed(0)).unwrap_err();
    assert!(error.to_string().contains("no-such-model"), "{error}");
}
