use super::*;
use crate::{
    model::{Model, Training},
    recording::{Recording, npz},
};
use std::path::Path;

fn corridor() -> Recording {
    npz::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets/corridor-small.npz")).unwrap()
}

fn model() -> Model {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/corridor-global.safetensors");
    Model::read(&path).unwrap()
}

/// Observations of snapshots in any order, as a robot makes them that is carried where they don't follow one another.
struct Drive<'a> {
    recording: &'a Recording,
    odometry: Pose,
    last: Option<usize>,
}

impl<'a> Drive<'a> {
    fn new(recording: &'a Recording) -> Self {
        Self {
            recording,
            odometry: Pose::default(),
            last: None,
        }
    }

    fn to(&mut self, snapshot: usize) -> Observation<'a> {
        let reckoned = |k| self.recording.observation(k).odometry;
        if self.last == Some(snapshot - 1) {
            let step = reckoned(snapshot - 1).displacement_to(&reckoned(snapshot));
            self.odometry = self.odometry.after(step);
        }
        self.last = Some(snapshot);
        Observation {
            odometry: self.odometry,
            ..self.recording.observation(snapshot)
        }
    }
}

#[test]
fn a_robot_finds_itself_and_knows_when_it_was_carried_away() {
    let (recording, model) = (corridor(), model());
    let route_m = recording.route_m().unwrap();
    for run in &recording.runs()[1..] {
        let mut robot = LiveLocaliser::new(&model).unwrap();
        let mut drive = Drive::new(&recording);
        assert!(robot.lost(), "with no idea where it is");
        let middle = run.start + run.len() / 2;
        let far = run.start + 5;
        let mut found = false;
        for k in run.start + 2..middle {
            let log_predictive = robot.observe(&drive.to(k)).unwrap();
            assert!(log_predictive <= 0.0, "a probability: {log_predictive}");
            found |= !robot.lost();
            if route_m[k] - route_m[run.start] > 30.0 {
                let error_m = (robot.mode().x_m - route_m[k]).abs();
                assert!(!robot.lost(), "at {} m", route_m[k]);
                assert!(error_m < 2.0, "{error_m} m at {} m", route_m[k]);
                assert!((robot.mean().x_m - route_m[k]).abs() < 2.0);
                assert!(robot.covariance()[(0, 0)].sqrt() < 2.0);
                assert!(robot.mass_within(3.0) > 0.8);
            }
        }
        assert!(found);
        // Carried back to the start of the corridor; odometry says nothing of it.
        let noticed = (far..middle).find(|&k| {
            robot.observe(&drive.to(k)).unwrap();
            robot.lost()
        });
        let noticed = noticed.map(|k| route_m[k] - route_m[far]);
        assert!(noticed.is_some_and(|m| m < 8.0), "{noticed:?}");
    }
}

#[test]
fn a_robot_off_its_map_is_noticed() {
    let (recording, model) = (corridor(), model());
    let route_m = recording.route_m().unwrap();
    let run = recording.runs()[1].clone();
    let start = run.start + run.len() / 2;
    let mut robot = LiveLocaliser::new(&model).unwrap();
    let pose = Pose::new(route_m[start], 0.0, 0.0);
    robot.start_at(pose, 0.3, 0.1).unwrap();
    assert!(!robot.lost());
    assert!(robot.entropy() < robot.no_idea.entropy() - 3.0);
    let mut drive = Drive::new(&recording);
    for k in start..start + 10 {
        robot.observe(&drive.to(k)).unwrap();
        assert!(!robot.lost(), "{k}");
    }
    // Another building, of which the sonars say something else. Four features that say little each take a while to tell.
    let lost = (start + 10..start + 50).find(|&k| {
        let seen = recording.observation(k).values;
        let elsewhere: Vec<f32> = (0..24).map(|beam| seen[(beam + 6) % 24]).collect();
        let odometry = drive.to(k).odometry;
        let observation =
            Observation::new(recording.channels(), &elsewhere, 0.0, odometry).unwrap();
        robot.observe(&observation).unwrap();
        robot.lost()
    });
    let after_m = lost.map(|k| route_m[k] - route_m[start + 9]);
    assert!(after_m.is_some_and(|m| m < 20.0), "{after_m:?}");
}

#[test]
fn predictions_and_corrections_apart_are_the_same_as_together() {
    let (recording, model) = (corridor(), model());
    let mut together = LiveLocaliser::new(&model).unwrap();
    let mut apart = LiveLocaliser::new(&model).unwrap();
    let mut last: Option<Pose> = None;
    for k in 4..9 {
        let observation = recording.observation(k);
        let one = together.observe(&observation).unwrap();
        if let Some(last) = last.replace(observation.odometry) {
            let step = last.displacement_to(&observation.odometry);
            apart.predict(&step).unwrap();
        }
        assert_eq!(apart.correct(&observation).unwrap(), one);
    }
    assert_eq!(together.belief(), apart.belief());
}

#[test]
fn what_makes_no_sense_is_an_error_and_changes_nothing() {
    let (recording, model) = (corridor(), model());
    let mut robot = LiveLocaliser::new(&model).unwrap();
    robot.observe(&recording.observation(0)).unwrap();
    let before = robot.belief().clone();
    let message = |result: Result<f64>| result.unwrap_err().to_string();
    let odometry = Pose::new(f64::NAN, 0.0, 0.0);
    let nowhere = Observation {
        odometry,
        ..recording.observation(1)
    };
    assert!(message(robot.observe(&nowhere)).contains("odometry"));
    let few = Observation {
        values: ndarray::ArrayView1::from(&[1.0f32; 3]),
        ..recording.observation(1)
    };
    assert!(message(robot.correct(&few)).contains("3 values; expected 24"));
    for (pose, spread_m) in [
        (Pose::new(1e6, 0.0, 0.0), 1.0),
        (Pose::new(f64::NAN, 0.0, 0.0), 1.0),
        (Pose::new(5.0, 0.0, 0.0), 0.0),
    ] {
        assert!(robot.start_at(pose, spread_m, 0.1).is_err());
    }
    assert_eq!(robot.belief(), &before);
    // Readings that are missing are nothing to complain about.
    let nothing = [f32::NAN; 24];
    let silent = Observation::new(recording.channels(), &nothing, 0.0, Pose::default());
    assert!(robot.correct(&silent.unwrap()).unwrap().is_finite());
}

#[test]
fn evidence_counts_as_the_model_was_tuned_unless_somebody_says_otherwise() {
    let (recording, mut model) = (corridor(), model());
    let entropy = |model: &Model, evidence_scale: Option<f64>| {
        let config = LiveConfig {
            evidence_scale,
            ..LiveConfig::default()
        };
        let mut robot = LiveLocaliser::with_config(model, &config).unwrap();
        robot.observe(&recording.observation(3)).unwrap();
        robot.entropy()
    };
    let at_its_word = entropy(&model, None);
    model.header.evidence_scale = Some(0.25);
    let tuned = entropy(&model, None);
    assert!(tuned > at_its_word + 0.1, "{tuned} {at_its_word}");
    assert_eq!(entropy(&model, Some(0.25)), tuned);
    // The share that no model explains aside, 1 is the model's own word.
    let own = entropy(&model, Some(1.0));
    assert!(tuned > own + 0.1, "{tuned} {own}");
    let config = LiveConfig {
        evidence_scale: Some(0.0),
        ..LiveConfig::default()
    };
    let fault = LiveLocaliser::with_config(&model, &config).err().unwrap();
    assert!(fault.is_usage() && fault.to_string().contains("evidence_scale = 0"));
}

#[test]
fn a_robot_is_lost_as_its_model_was_tuned_unless_somebody_says_otherwise() {
    let (recording, mut model) = (corridor(), model());
    let score = |model: &Model, lost: Option<LostConfig>| {
        let config = LiveConfig {
            lost,
            ..LiveConfig::default()
        };
        let mut robot = LiveLocaliser::with_config(model, &config).unwrap();
        robot.observe(&recording.observation(3)).unwrap();
        robot.lost_score()
    };
    let usual = score(&model, None);
    let wary = LostConfig {
        base: -3.0,
        ..LostConfig::default()
    };
    assert_eq!(score(&model, Some(LostConfig::default())), usual);
    model.header.lost = Some(wary.clone());
    let tuned = score(&model, None);
    assert!(tuned > usual, "{tuned} {usual}");
    assert_eq!(score(&model, Some(LostConfig::default())), usual);
    let senseless = LostConfig {
        slope: -1.0,
        ..wary
    };
    let config = LiveConfig {
        lost: Some(senseless),
        ..LiveConfig::default()
    };
    let fault = LiveLocaliser::with_config(&model, &config).err().unwrap();
    assert!(fault.is_usage() && fault.to_string().contains("`slope` is -1"));
}

#[test]
fn a_robot_looks_at_a_snapshot_again_as_often_as_it_is_told_to() {
    let (recording, model) = (corridor(), model());
    let robot = |query_views: usize| {
        let config = LiveConfig {
            query_views,
            ..LiveConfig::default()
        };
        LiveLocaliser::with_config(&model, &config)
    };
    let belief = |query_views: usize| {
        let mut robot = robot(query_views).unwrap();
        robot.observe(&recording.observation(3)).unwrap();
        robot.belief().clone()
    };
    assert_ne!(belief(2), belief(0));
    assert_eq!(belief(2), belief(2));
    let fault = robot(65).err().unwrap();
    assert!(
        fault.is_usage()
            && fault
                .to_string()
                .contains("query_views = 65: expected at most 64")
    );
}

/// Of a model that works from the readings of the last metres, the robot remembers them itself.
#[test]
fn a_robot_that_remembers_believes_what_one_does_that_is_told() {
    let recording = corridor();
    let mut recipe = model().header.recipe;
    recipe.descent.steps = 2;
    recipe.input.history_m = Some(vec![1.0, 2.0]);
    let model = Training::new(&recipe, &recording).run().unwrap().model;
    let remembered = model.seen_in(&recording).unwrap();
    let mut robot = LiveLocaliser::new(&model).unwrap();
    let mut told = model.clone();
    told.header.channels = remembered.channels().to_vec();
    told.header.recipe.input.history_m = None;
    let mut told = LiveLocaliser::new(&told).unwrap();
    for k in 0..12 {
        robot.observe(&recording.observation(k)).unwrap();
        told.observe(&remembered.observation(k)).unwrap();
    }
    assert_eq!(robot.belief().mass(), told.belief().mass());
    // Carried elsewhere it remembers nothing: as at the start of a run.
    let belief = told.belief().clone();
    robot.restart(belief.clone()).unwrap();
    told.restart(belief).unwrap();
    let there = recording.select(&[20]).unwrap();
    let alone = model.seen_in(&there).unwrap();
    assert_eq!(
        robot.correct(&there.observation(0)).unwrap(),
        told.correct(&alone.observation(0)).unwrap()
    );
}
