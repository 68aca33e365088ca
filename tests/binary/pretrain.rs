//! Pre-trained networks, from the command that makes them to a training that goes on from them.

use crate::support::{Answer, Workplace};
use std::fs;

const SMALL: &str = "
[train]
features = 6
uncertainty = 'global'
[train.descent]
steps = 2
truths_per_step = 16
rendered_per_step = 40
[pretrain]
at_hand = 2
held_out = 1
[pretrain.buildings]
path_m = [25.0, 30.0]
visits = 1
";

fn pretrained(place: &Workplace, output: &str, more: &[&str]) -> Answer {
    let arguments = ["pretrain", "-o", output, "--config", "small.toml"];
    place.ballmark(&[&arguments[..], more].concat())
}

fn json(answer: &Answer) -> serde_json::Value {
    serde_json::from_str(&answer.stdout).unwrap()
}

/// A laser of 180 beams that is driven through a hall, as a dataset of two runs.
fn dataset(place: &Workplace) {
    let world = r#"
name = "hall"
[[wall]]
points = [[0, 0], [12, 0], [12, 7], [5, 7], [5, 4], [0, 4]]
closed = true
[laser]
beams = 180
[path]
closed = true
laps = 6
corners = [[1, 1], [11, 1], [11, 6], [6, 6], [6, 3], [1, 3]]
[record]
every_s = 2.0
"#;
    place.write("hall.toml", world);
    place
        .ballmark(&["simulate", "hall.toml", "-o", "hall.npz"])
        .done();
}

#[test]
fn a_training_goes_on_from_pretrained_networks_or_uses_them_as_they_are() {
    let place = Workplace::new();
    place.write("small.toml", SMALL);
    let out = pretrained(&place, "t.safetensors", &["--json"]);
    let told = json(out.done());
    assert!(
        told["held_out_error_reduction"]
            .as_f64()
            .unwrap()
            .is_finite()
    );
    pretrained(&place, "again.safetensors", &[]).done();
    let bytes = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(bytes("t.safetensors") == bytes("again.safetensors"));
    dataset(&place);
    let train = |output: &str, more: &[&str]| {
        let arguments = [
            "train",
            "hall.npz",
            "-o",
            output,
            "--features",
            "6",
            "--uncertainty",
            "global",
            "--json",
        ];
        place.ballmark(&[&arguments[..], more].concat())
    };
    let as_they_are = train(
        "m0.safetensors",
        &["--from", "t.safetensors", "--steps", "0"],
    );
    assert_eq!(json(as_they_are.done())["steps"], 0);
    train(
        "m1.safetensors",
        &["--from", "t.safetensors", "--steps", "3"],
    )
    .done();
    train("m2.safetensors", &["--steps", "3", "--from", "none"]).done();
    assert!(bytes("m1.safetensors") != bytes("m0.safetensors"));
    assert!(bytes("m1.safetensors") != bytes("m2.safetensors"));
    // The map answers at every pose: it is in the model, and the trials play with it.
    let model = ballmark::Model::read(&place.path("m0.safetensors")).unwrap();
    assert!(model.occupancy.is_some());
    let weights = ballmark::Model::read(&place.path("t.safetensors"))
        .unwrap()
        .weights;
    let same = model.weights.layers.iter().zip(&weights.layers);
    for (own, theirs) in same {
        let off = (&own.weight - &theirs.weight).mapv(f32::abs);
        assert!(off.iter().all(|off| *off < 1e-5)); // the gain went out and in again
    }
    let features = ["features", "m0.safetensors", "hall.npz", "-o", "f.csv"];
    place.ballmark(&features).done();
}

#[test]
fn what_does_not_fit_is_refused() {
    let place = Workplace::new();
    place.write("small.toml", SMALL);
    dataset(&place);
    let train = |more: &[&str]| {
        let arguments = ["train", "hall.npz", "-o", "m.safetensors"];
        place.ballmark(&[&arguments[..], more].concat())
    };
    train(&["--steps", "0", "--from", "none"]).refused(2, &["descent.steps = 0", "random weights"]);
    train(&["--from", "gone.safetensors"]).refused(1, &["gone.safetensors"]);
    // Another sensor: the shipped corridor's sonars.
    let shipped = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/models/corridor-2m.safetensors"
    );
    train(&["--from", shipped]).refused(
        1,
        &["pre-trained networks work from sonar (24)", "laser (180)"],
    );
    train(&["--map", "gone.yaml"]).refused(1, &["gone.yaml"]);
    place.write("small.toml", "[pretrain]\nat_hand = 0\n");
    pretrained(&place, "t.safetensors", &[]).refused(2, &["small.toml: line 2", "at_hand"]);
    place.write("small.toml", "[pretrain.buildings]\nvisits = 0\n");
    pretrained(&place, "t.safetensors", &[]).refused(2, &["small.toml: line 2", "visits"]);
    assert!(!place.path("t.safetensors").exists() && !place.path("m.safetensors").exists());
}
