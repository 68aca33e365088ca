use super::*;
use crate::{
    model::Training,
    world::corridor::{CorridorConfig, thrun1998},
};

fn corridor(seed: u64) -> Recording {
    let config = CorridorConfig {
        runs: 3,
        spacing_m: 1.0,
    };
    thrun1998(Seed(seed), &config).unwrap()
}

fn recipe() -> Recipe {
    let mut recipe = Recipe {
        features: 2,
        uncertainty: "5m".parse().unwrap(),
        ..Recipe::default()
    };
    recipe.descent.steps = 20;
    recipe
}

fn with(steps: usize, half_life: f64) -> UpdateConfig {
    UpdateConfig {
        steps,
        half_life,
        ..UpdateConfig::default()
    }
}

fn quiet(
    model: &Model,
    memory: Option<&Memory>,
    new: &Recording,
    config: &UpdateConfig,
) -> Result<Updated> {
    update(model, memory, new, config, &mut |_| {})
}

#[test]
fn the_map_is_extended_and_forgets_and_the_file_is_a_model() {
    let (old, new) = (corridor(1), corridor(2));
    let model = Training::new(&recipe(), &old).run().unwrap().model;
    let memory = Memory::of(&model, &old).unwrap();
    let alone = quiet(&model, None, &new, &with(0, 2.0)).unwrap();
    let both = quiet(&model, Some(&memory), &new, &with(0, 2.0)).unwrap();
    // From the old snapshots answers are worked out anew, to the last digits.
    let off = (&alone.model.activation - &both.model.activation).mapv(f32::abs);
    assert!(off.iter().all(|off| *off < 1e-5));
    assert_eq!(alone.model.pose, both.model.pose);
    assert!(alone.memory.is_none());
    let (kept, places) = (both.model.pose.len() - new.len(), model.pose.len());
    assert!(
        kept > places / 10 && kept < places / 2,
        "{kept} of {places}"
    );
    assert_eq!(both.model.pose[kept..], *new.poses());
    assert_eq!(
        both.model.route_m.as_deref().unwrap()[kept..],
        *new.route_m().unwrap()
    );
    let nothing = quiet(&model, None, &new, &with(0, f64::INFINITY))
        .unwrap()
        .model;
    assert_eq!(nothing.pose[..places], model.pose);
    assert_eq!(nothing.activation.nrows(), places + new.len());

    let folder = tempfile::tempdir().unwrap();
    for name in ["m.safetensors", "m.npz"] {
        let file = folder.path().join(name);
        both.model.write(&file).unwrap();
        assert_eq!(Model::read(&file).unwrap(), both.model);
    }
    // What a command would say of a training that it finds in this file.
    let file = folder.path().join("m.npz");
    let recipe = recipe();
    assert!(
        Training::new(&recipe, &old)
            .finished(&file)
            .unwrap()
            .is_none()
    );
}

#[test]
fn steps_start_where_the_model_is_and_are_judged_on_what_is_kept_back() {
    let (old, new) = (corridor(1), corridor(2));
    let mut recipe = recipe();
    recipe.descent.steps = 3;
    let model = Training::new(&recipe, &old).run().unwrap().model;
    let memory = Memory::of(&model, &old).unwrap();
    let config = UpdateConfig {
        rate: 1.0,
        ..with(60, 2.0)
    };
    let updated = quiet(&model, Some(&memory), &new, &config).unwrap();
    let record = &updated.model.header.updates[0];
    let [before, after] = record.validation.unwrap();
    assert!(after > before && record.steps == 60, "{record:?}");
    // So small that nothing moves: then weights are the model's own, but for rounding.
    let still = UpdateConfig {
        rate: 1e-12,
        ..with(1, 2.0)
    };
    let still = quiet(&model, Some(&memory), &new, &still).unwrap().model;
    let off = |a: &Model, b: &Model| {
        let layers = a.weights.layers.iter().zip(&b.weights.layers);
        let off = layers.map(|(a, b)| (&a.weight - &b.weight).mapv(f32::abs).sum());
        off.sum::<f32>()
    };
    assert!(off(&still, &model) < 1e-3 * off(&updated.model, &model).max(1.0));
    assert!(off(&updated.model, &model) > 1e-3);
    assert_eq!(updated.model.header.input, model.header.input);
}

#[test]
fn an_update_is_the_same_on_any_number_of_threads() {
    let (old, new) = (corridor(1), corridor(2));
    let model = Training::new(&recipe(), &old).run().unwrap().model;
    let memory = Memory::of(&model, &old).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let config = with(6, 1.0);
        pool.install(|| quiet(&model, Some(&memory), &new, &config))
            .unwrap()
            .model
    };
    assert_eq!(on(1), on(3));
}

/// A map at every pose is drawn anew, by what is left and what came.
#[test]
fn a_map_at_every_pose_is_drawn_anew() {
    let (old, new) = (corridor(1).in_the_plane(), corridor(2).in_the_plane());
    let model = Training::new(&recipe(), &old).run().unwrap().model;
    assert!(model.occupancy.is_some());
    let fault = quiet(&model, None, &new, &with(0, 2.0)).unwrap_err();
    assert!(
        fault.is_usage() && fault.to_string().contains("draw it anew"),
        "{fault}"
    );
    let memory = Memory::of(&model, &old).unwrap();
    let updated = quiet(&model, Some(&memory), &new, &with(0, 2.0))
        .unwrap()
        .model;
    assert_ne!(updated.occupancy, model.occupancy);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("m.safetensors");
    updated.write(&file).unwrap();
    assert_eq!(Model::read(&file).unwrap(), updated);
}

#[test]
fn what_is_kept_back_is_new_and_in_the_middle() {
    let both = Recording::joined(vec![corridor(1), corridor(2)]).unwrap();
    let old = both.len() / 2;
    let split = kept_back(&both, old);
    let travelled_m = both.travelled_m();
    assert!(!split.validation.is_empty());
    let inside = |k: &usize| *k >= old && (30.0..45.0).contains(&(travelled_m[*k] % 75.0));
    assert!(split.validation.iter().all(inside));
    assert_eq!(split.train.len() + split.validation.len(), both.len());
}
