use super::*;
use crate::{
    geometry::Pose,
    seed::Seed,
    world::corridor::{CorridorConfig, thrun1998},
};
use std::path::Path;

fn model() -> Model {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    Model::read(&folder.join("corridor-2m.safetensors")).unwrap()
}

fn corridor(seed: u64, runs: usize) -> Recording {
    let config = CorridorConfig {
        runs,
        ..CorridorConfig::default()
    };
    thrun1998(Seed(seed), &config).unwrap()
}

fn memory(model: &Model) -> Memory {
    Memory::of(
        model,
        &thrun1998(Seed(1), &CorridorConfig::default()).unwrap(),
    )
    .unwrap()
}

fn map_only() -> AdaptConfig {
    let mut config = AdaptConfig::default();
    config.update.steps = 0;
    config
}

/// Poses of a run are for its judge alone.
#[test]
fn a_model_is_the_same_whatever_the_truth_is() {
    let (model, run) = (model(), corridor(2, 2));
    let memory = memory(&model);
    let mut config = AdaptConfig::default();
    config.update.steps = 4;
    let adapted = |run: &Recording| adapt(&model, Some(&memory), run, &config, None, &mut |_| {});
    let mut columns = run.clone().into_columns();
    columns.pose.iter_mut().enumerate().for_each(|(k, pose)| {
        *pose = Pose::new((k * k % 17) as f64, -3.0, 1.0);
    });
    columns.route_m = Some((0..run.len()).map(|k| (k * 7 % 80) as f64).collect());
    let scrambled = adapted(&Recording::new(columns).unwrap()).unwrap();
    let adapted = adapted(&run).unwrap();
    assert_eq!(adapted.model, scrambled.model);
    assert_eq!(adapted.labels.kept, scrambled.labels.kept);
    assert_ne!(adapted.labels.errors, scrambled.labels.errors);
    assert_ne!(adapted.model.weights, model.weights);
    assert_eq!(adapted.model.header.updates[0].steps, 4);
}

#[test]
fn what_is_kept_is_right_and_comes_into_the_map() {
    let (model, run) = (model(), corridor(2, 2));
    let adapted = adapt(&model, None, &run, &map_only(), None, &mut |_| {}).unwrap();
    let LabelRecord {
        snapshots,
        kept,
        beyond,
        errors,
        errors_of_all,
    } = adapted.labels;
    assert_eq!((snapshots, beyond), (run.len(), 0)); // a route has no beyond
    assert!(2 * kept > snapshots, "{kept} of {snapshots}");
    let (errors, all) = (errors.unwrap(), errors_of_all.unwrap());
    assert!(
        errors.median_m < 0.3 && errors.beyond_1m < 0.02,
        "{errors:?}"
    );
    assert!(
        errors.p95_m < 0.6 && all.beyond_1m >= errors.beyond_1m,
        "{errors:?} {all:?}"
    );
    let record = &adapted.model.header.updates[0];
    assert_eq!((record.added, record.validation), (kept, None));
    assert!(record.forgotten > 0);
    assert_eq!(adapted.model.weights, model.weights);
    let places = adapted.model.pose.len();
    assert_eq!(places, model.pose.len() - record.forgotten + kept);
}

#[test]
fn a_closed_gate_changes_nothing() {
    let (model, run) = (model(), corridor(2, 1));
    let mut config = map_only();
    config.labels.gate = 0.0;
    let adapted = adapt(&model, None, &run, &config, None, &mut |_| {}).unwrap();
    assert_eq!((adapted.labels.kept, adapted.labels.errors), (0, None));
    assert_eq!(adapted.model, model);
}

#[test]
fn a_model_goes_on_from_the_memory_of_its_last_update() {
    let model = model();
    let memory = memory(&model);
    let [monday, tuesday] = [2, 3].map(|seed| corridor(seed, 1));
    let config = map_only();
    let first = adapt(&model, Some(&memory), &monday, &config, None, &mut |_| {}).unwrap();
    let first_memory = first.memory.unwrap();
    assert_eq!(first_memory.recording().len(), first.model.pose.len());
    assert_eq!(first_memory.recording().poses(), first.model.pose);
    assert!(crate::model::seen::is_source(&first.model, first_memory.recording()).unwrap());
    // Looked up again, as a command does that reads it from a file.
    let again = Memory::of(&first.model, first_memory.recording()).unwrap();
    let second = adapt(
        &first.model,
        Some(&again),
        &tuesday,
        &config,
        None,
        &mut |_| {},
    )
    .unwrap();
    assert_eq!(second.model.header.updates.len(), 2);
    let old = Memory::of(&first.model, &corridor(1, 12)).unwrap_err();
    assert!(
        old.to_string().contains("memory of its last update"),
        "{old}"
    );
}

#[test]
fn what_cannot_be_adapted_to_is_refused() {
    let (model, run) = (model(), corridor(2, 1));
    let refused = |run: &Recording, config: &AdaptConfig, words: &str| {
        let fault = adapt(&model, None, run, config, None, &mut |_| {}).unwrap_err();
        assert!(fault.to_string().contains(words), "{fault}");
    };
    let mut columns = run.clone().into_columns();
    columns.odometry.fill(Pose::new(1.0, 2.0, 3.0));
    let stands = Recording::new(columns).unwrap();
    refused(&stands, &map_only(), "`odometry` never moves");
    let mut columns = run.clone().into_columns();
    columns.channels[0].name = "radar".into();
    refused(&Recording::new(columns).unwrap(), &map_only(), "sonar");
    refused(&run, &AdaptConfig::default(), "expected these, or 0 steps");
    let mut config = map_only();
    config.labels.gate = 1.5;
    refused(&run, &config, "adapt: labels.gate = 1.5");
    config = map_only();
    config.update.half_life = 0.0;
    refused(&run, &config, "adapt: update.half_life = 0");
}

#[test]
fn errors_by_hand() {
    let errors_m = (0..=100).map(|k| f64::from(k) * 0.02).collect();
    let errors = LabelErrors::of(errors_m).unwrap();
    assert!((errors.median_m - 1.0).abs() < 1e-12 && (errors.p95_m - 1.9).abs() < 1e-12);
    assert!((errors.beyond_1m - 50.0 / 101.0).abs() < 1e-12);
    assert_eq!(LabelErrors::of(Vec::new()), None);
}
