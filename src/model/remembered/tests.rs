use super::*;
use crate::{
    belief::Uncertainty,
    detector::Detector,
    geometry::Pose,
    model::{Note, Training},
    recording::{Channel, Columns},
    seed::Seed,
};
use ndarray::Array2;
use rand::RngExt;

/// A hall in four passes, up and down by turns, where one receiver hears as much ahead of the middle as behind it: what it hears now
/// leaves two places, how that changed along the way one.
fn recording(noise: f32) -> Recording {
    let mut random = Seed(5).stream("receivers");
    let (passes, each) = (8, 40);
    let at_m = |k: usize| 0.25 * (k % each) as f64;
    let pose: Vec<Pose> = (0..passes * each)
        .map(|k| Pose::new(at_m(k), 0.05 * (k / each) as f64, 0.0))
        .collect();
    let heard = |k: usize| -> f32 { -40.0 - 3.0 * (at_m(k) - 5.0).abs() as f32 };
    let values = (0..passes * each).map(|k| heard(k) + noise * random.random_range(-1.0..1.0));
    Recording::new(Columns {
        channels: vec![Channel {
            name: "rssi".into(),
            width: 1,
            unit: "dBm".into(),
            bearing_rad: None,
            maximum: None,
            offset_m: None,
        }],
        values: Array2::from_shape_vec((passes * each, 1), values.collect()).unwrap(),
        stamp_s: (0..passes * each).map(|k| k as f64).collect(),
        odometry: pose.clone(),
        run: (0..passes * each).map(|k| (k / each) as i64).collect(),
        pose,
        ..Columns::default()
    })
    .unwrap()
}

fn recipe() -> Recipe {
    let mut recipe = Recipe {
        features: 8,
        uncertainty: Uncertainty::Global,
        ..Recipe::default()
    };
    recipe.descent.steps = 60;
    recipe.descent.validate_every = 20;
    recipe
}

#[test]
fn what_was_sensed_before_becomes_an_input_where_it_helps_on_the_validation_part() {
    let recording = recording(1.0);
    let mut steps = Vec::new();
    let recipe = recipe();
    let training = Training::new(&recipe, &recording).on_progress(|p| steps.push(p.step));
    let learned = training.run().unwrap();
    assert_eq!(learned.model.history_m(), [0.5, 1.0, 2.0]);
    // A robot has the one receiver.
    assert_eq!(learned.model.header.channels, recording.channels());
    assert_eq!(
        (steps.first(), steps.last(), steps.len()),
        (Some(&0), Some(&120), 122)
    );
    let paper = Recipe::thrun1998();
    assert_eq!(histories(&paper, &recording).unwrap(), [Vec::<f64>::new()]);
    let mut plain = recipe.clone();
    plain.input.history_m = Some(Vec::new());
    let without = Training::new(&plain, &recording).run().unwrap();
    assert!(without.model.history_m().is_empty());
    let [with, without] = [learned, without.clone()]
        .map(|learned| learned.report.scores.validation.unwrap().error_reduction);
    assert!(with > without + 0.1, "{with} {without}");
}

#[test]
fn a_robot_is_fed_as_a_recording_is() {
    let recording = recording(1.0);
    let mut recipe = recipe();
    recipe.input.history_m = Some(vec![0.5, 1.0]);
    recipe.input.channels = vec!["rssi".into()];
    let model = Training::new(&recipe, &recording).run().unwrap().model;
    let remembered = model.seen_in(&recording).unwrap();
    assert_eq!(remembered.channels().len(), 5);
    assert!(matches!(
        model.seen_in(&remembered).unwrap(),
        Cow::Borrowed(_)
    ));
    let answers = model.detector().probabilities(&remembered).unwrap();
    assert_eq!(answers.dim(), (recording.len(), 8));
}

#[test]
fn where_learning_gives_less_than_random_features_these_are_kept_and_it_is_said() {
    let recording = recording(0.1);
    let mut recipe = recipe();
    recipe.input.history_m = Some(Vec::new());
    recipe.features = 32;
    recipe.descent.steps = 1;
    recipe.descent.learning_rate = 1e-9; // nothing is learned
    let learned = Training::new(&recipe, &recording).run().unwrap();
    let notes = &learned.report.notes;
    let better = |note: &Note| matches!(note, Note::RandomBetter(_));
    assert!(notes.iter().any(better), "{notes:?}");
    assert!(
        notes
            .iter()
            .any(|note| note.to_string().contains("less than as many random"))
    );
    let weights = &learned.model.weights;
    assert_eq!((weights.layers.len(), weights.trunk), (1, 0));
    assert_eq!(weights.features(), 32);
    let file = tempfile::tempdir().unwrap();
    let file = file.path().join("random.safetensors");
    learned.model.write(&file).unwrap();
    assert_eq!(Model::read(&file).unwrap().weights, learned.model.weights);
}
