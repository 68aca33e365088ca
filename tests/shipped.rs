//! The files in `datasets/` and `models/` are what this code makes, and their cards tell the truth about them.
//!
//! `BALLMARK_WRITE_SHIPPED=1 cargo test --release --test shipped` makes the dataset anew; the models come from
//! `ballmark demo`, their cards from the same variable.

use ballmark::{
    belief::{GridMap, Neighbours, Places, Uncertainty},
    detector::Detector,
    experiment::{held_out, parts::Parts},
    learning::recipe::BeginWith,
    model::{Model, Training},
    recording::{Recording, npz},
    seed::Seed,
    world::{
        corridor::{CorridorConfig, thrun1998},
        generated::{GeneratedBuilding, GeneratedConfig},
    },
};
use ndarray::Axis;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Error reductions on a card are held to this: exact on one machine, some last digits differ on another.
const TOLERANCE: f64 = 0.005;

fn shipped(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn rewriting() -> bool {
    std::env::var_os("BALLMARK_WRITE_SHIPPED").is_some()
}

/// Three runs along the demo's corridor that none of the demo's runs is part of.
fn small_corridor() -> Recording {
    let config = CorridorConfig {
        runs: 3,
        spacing_m: 0.5,
    };
    thrun1998(Seed(2), &config).expect("the corridor can be driven")
}

/// The recording of `ballmark demo`, with the checksum that its models name.
fn demo_corridor(model: &Model) -> Recording {
    let mut columns = thrun1998(Seed(1), &CorridorConfig::default())
        .expect("the corridor can be driven")
        .into_columns();
    columns.dataset_sha256 = model.header.dataset_sha256.clone();
    Recording::new(columns).expect("a whole recording")
}

#[test]
fn the_dataset_is_what_the_simulator_makes() {
    let path = shipped("datasets/corridor-small.npz");
    let made = small_corridor();
    if rewriting() {
        npz::write(&path, &made).expect("datasets/ can be written");
    }
    let kept = npz::read(&path).expect("a dataset");
    assert_eq!(kept.channels(), made.channels());
    assert_eq!(kept.values().dim(), made.values().dim());
    // Another machine's sine may differ in the last bit, and turn a rounded reading now and then.
    let same = kept
        .values()
        .iter()
        .zip(made.values())
        .filter(|(a, b)| a == b || (a.is_nan() && b.is_nan()))
        .count();
    assert!(
        same as f64 > 0.99 * made.values().len() as f64,
        "{same} of {} readings",
        made.values().len()
    );
    assert!(
        std::fs::metadata(&path).expect("the file").len() < 200_000,
        "a small dataset is small"
    );
}

/// Error reduction of one snapshot on the runs that the model never saw.
fn held_out(model: &Model, recording: &Recording, prior: Uncertainty) -> f64 {
    let parts = Parts::new(model, recording, None).expect("the model's own dataset");
    assert!(!parts.unseen_is_validation);
    let candidates = model.places();
    let truths = held_out::counted(
        prior,
        &parts.places,
        &parts.covered(&candidates),
        &candidates,
    );
    let answers = model
        .detector()
        .probabilities(recording)
        .expect("answers")
        .select(Axis(0), &truths)
        .mapv(f64::from);
    let nearness = &model.header.recipe.map.nearness;
    let near = Neighbours::find(&candidates, &candidates, nearness).expect("neighbours");
    let map = model
        .map()
        .and_then(|map| map.from_neighbours(&near))
        .expect("a map");
    let truths = parts.places.select(&truths);
    let score = held_out::by_mean_field(prior, (&truths, answers.view()), (&candidates, &map));
    score.error_reduction
}

fn card(name: &str) {
    let model = Model::read(&shipped(&format!("models/{name}.safetensors"))).expect("a model");
    let recording = demo_corridor(&model);
    let reduction = |prior: &str| held_out(&model, &recording, prior.parse().expect("a prior"));
    let path = shipped(&format!("models/{name}.json"));
    let recipe = serde_json::to_value(&model.header.recipe).expect("a recipe");
    if rewriting() {
        let card = json!({
            "made_by": "ballmark demo --seed 1",
            "crate_version": model.header.crate_version,
            "data": "the demo's corridor: 12 runs, 24 sonars; runs 4, 8 and 12 kept for testing",
            "prior": model.header.prior,
            "scores": model.header.scores,
            "held_out_error_reduction": { "2m": reduction("2m"), "global": reduction("global") },
            "recipe": recipe,
        });
        std::fs::write(&path, format!("{card:#}\n")).expect("models/ can be written");
    }
    let card: Value = serde_json::from_slice(&std::fs::read(&path).expect("a card")).expect("JSON");
    assert_eq!(
        card["recipe"], recipe,
        "the card names another recipe than the model"
    );
    assert_eq!(card["prior"], json!(model.header.prior));
    for prior in ["2m", "global"] {
        let told = card["held_out_error_reduction"][prior]
            .as_f64()
            .expect("a number");
        assert!(
            (told - reduction(prior)).abs() < TOLERANCE,
            "{prior}: the card says {told}, it is {}",
            reduction(prior)
        );
    }
    let told = card["scores"]["train"]["error_reduction"]
        .as_f64()
        .expect("a number");
    assert!((told - model.header.scores.train.error_reduction).abs() < 1e-9);
    let (own, other) = (
        name.strip_prefix("corridor-").expect("a prior"),
        if name.ends_with("2m") { "global" } else { "2m" },
    );
    assert!(
        reduction(own) > 0.1,
        "filters for {own} are worth something there"
    );
    assert!(reduction(own).is_finite() && reduction(other) < 1.0);
}

#[test]
fn the_card_of_the_2m_filters_tells_the_truth() {
    card("corridor-2m");
}

#[test]
fn the_card_of_the_global_filters_tells_the_truth() {
    card("corridor-global");
}

/// Share of the prior error that one later snapshot removes with no idea where, in simulated buildings that no training saw: the
/// networks as they are shipped.
fn in_unseen_buildings(model: &Model) -> f64 {
    let mut recipe = model.header.recipe.clone();
    recipe.begin_with = BeginWith::Pretrained;
    recipe.descent.steps = 0;
    recipe.split.validation_every = 0;
    let config = GeneratedConfig {
        path_m: [60.0, 80.0],
        visits: 1,
        ..GeneratedConfig::default()
    };
    let buildings = (0..9).filter_map(|number| {
        GeneratedBuilding::draw(&config, number, Seed(2)).expect("sound constants")
    });
    let reductions: Vec<f64> = buildings
        .take(3)
        .map(|building| {
            let learned = Training::new(&recipe, &building.first)
                .run()
                .expect("the sensors fit");
            assert_eq!(learned.report.began_with.as_deref(), Some("lidar-180"));
            let model = learned.model;
            let at = model
                .at_every_pose(&model.pose)
                .expect("answers")
                .expect("a map");
            let map = GridMap::new(at.values.mapv(f64::from)).expect("probabilities");
            let answers = model
                .detector()
                .probabilities(&building.second)
                .expect("answers");
            let truths = Places::Plane(building.second.poses().to_vec());
            let answers = answers.mapv(f64::from);
            let seen = (&truths, answers.view());
            let candidates = model.places();
            let score = held_out::by_mean_field(Uncertainty::Global, seen, (&candidates, &map));
            score.error_reduction
        })
        .collect();
    reductions.iter().sum::<f64>() / reductions.len() as f64
}

#[test]
fn the_card_of_the_pretrained_networks_tells_the_truth() {
    let model = Model::read(&shipped("models/lidar-180.safetensors")).expect("a model");
    let path = shipped("models/lidar-180.json");
    let found = in_unseen_buildings(&model);
    if rewriting() {
        let card = json!({
            "made_by": "ballmark pretrain -o lidar-180.safetensors --config configs/pretrain-lidar-180.toml",
            "crate_version": model.header.crate_version,
            "licence": "CC0-1.0",
            "sensor": "a laser scanner that sees 180 degrees; any number of beams, 4 or more",
            "data": "1,279 simulated buildings, seed 1; no log of any real one",
            "cost": "20,000 steps, 1,472 s on one core of an EPYC",
            "error_reduction_in_unseen_simulated_buildings": found,
            "recipe": model.header.recipe,
        });
        std::fs::write(&path, format!("{card:#}\n")).expect("models/ can be written");
    }
    let card: Value = serde_json::from_slice(&std::fs::read(&path).expect("a card")).expect("JSON");
    assert_eq!(card["recipe"], json!(model.header.recipe));
    let told = card["error_reduction_in_unseen_simulated_buildings"]
        .as_f64()
        .expect("a number");
    assert!(
        (told - found).abs() < TOLERANCE,
        "the card says {told}, it is {found}"
    );
    assert!(
        found > 0.6,
        "{found}: worth something in a building never seen"
    );
}
