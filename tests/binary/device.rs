//! `ballmark train --device` on the real binary: the same in every build, whatever GPUs it was made for and finds.

use crate::{
    support::{Answer, Workplace},
    train::toy,
};
use ballmark::detector::device::DeviceChoice;

fn train_on(place: &Workplace, device: &str) -> Answer {
    let call = ["train", "toy.npz", "-o", "m.safetensors", "--steps", "200"];
    let more = ["--features", "2", "--json", "--device", device];
    place.ballmark(&[&call[..], &more].concat())
}

fn error_reduction(answer: &Answer) -> f64 {
    let told: serde_json::Value = serde_json::from_str(&answer.stdout).expect("one JSON object");
    told["train"]["error_reduction"].as_f64().expect("a number")
}

#[test]
fn an_unknown_device_is_a_wrong_call_and_the_known_ones_are_listed() {
    let place = Workplace::new();
    toy(&place, true);
    for unknown in ["gpu", "CPU", "cuda:1", ""] {
        let list = "expected one of cpu, cuda, wgpu, metal, rocm";
        train_on(&place, unknown).refused(2, &["--device", &format!("`{unknown}`"), list]);
    }
    assert_eq!(place.files(), ["toy.csv", "toy.npz"]);
}

#[test]
fn a_device_that_is_not_built_in_is_a_wrong_call_and_its_feature_is_named() {
    let place = Workplace::new();
    toy(&place, true);
    for absent in DeviceChoice::ALL.iter().filter(|d| !d.is_built_in()) {
        let feature = format!("without the feature `{absent}`");
        let expected = format!("`cargo install --path . --features {absent}`");
        let device = format!("device {absent}:");
        train_on(&place, absent.name()).refused(2, &[&device, &feature, &expected, "cpu"]);
    }
    assert_eq!(place.files(), ["toy.csv", "toy.npz"]);
}

/// A GPU rounds otherwise, so descends to nearly the same place; where the machine has none, a line says so.
#[test]
fn a_device_that_is_built_in_learns_as_the_cpu_does_or_is_told_to_be_missing() {
    let place = Workplace::new();
    toy(&place, true);
    let cpu = error_reduction(train_on(&place, "cpu").done());
    assert!(cpu > 0.2, "{cpu}");
    for device in DeviceChoice::ALL.iter().filter(|d| d.is_built_in()) {
        let answer = train_on(&place, device.name());
        if answer.status == 1 {
            let line = format!("device {device}: no such GPU can be used here");
            answer.refused(1, &[&line, "expected one, or the device cpu"]);
            eprintln!("skipped: training on {device}: {}", answer.stderr.trim());
        } else {
            let found = error_reduction(answer.done());
            assert!((found - cpu).abs() < 0.01, "{device}: {found} for {cpu}");
        }
    }
}
