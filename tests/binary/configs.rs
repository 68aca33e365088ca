//! Every experiment in `configs/` runs, at toy size, on the shipped dataset.

use super::support::Workplace;
use std::path::{Path, PathBuf};

/// The configurations of comparisons, which name datasets, or those of trainings.
fn configs(of_comparisons: bool) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let mut configs: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    configs.retain(|path| {
        path.extension().is_some_and(|e| e == "toml")
            && std::fs::read_to_string(path)
                .unwrap()
                .contains("[[dataset]]")
                == of_comparisons
    });
    configs.sort();
    configs
}

#[test]
fn every_comparison_compares() {
    let configs = configs(true);
    assert!(configs.len() >= 3, "{configs:?}");
    for config in configs {
        ballmark::experiment::compare::CompareConfig::read(&config).unwrap();
        let config = config.to_str().unwrap();
        if !config.contains("compare-") {
            continue; // a paper's: minutes, even at toy size
        }
        let place = Workplace::new();
        let told = place.ballmark(&["compare", config, "--toy", "--json"]);
        // 3: a system can't be brought to the number of responses that is wanted, and is named.
        assert!([0, 3].contains(&told.status), "{config}: {}", told.stderr);
        let told: serde_json::Value = serde_json::from_str(&told.stdout).unwrap();
        assert!(
            told["datasets"][0]["testing"].as_u64().unwrap() > 0,
            "{config}"
        );
        assert!(place.files().is_empty());
    }
}

#[test]
fn every_config_trains_and_localises() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let dataset = root.join("datasets/corridor-small.npz");
    let configs = configs(false);
    assert!(configs.len() >= 4, "{configs:?}");
    let mut localised = 0;
    for config in configs {
        let place = Workplace::new();
        let (data, config) = (dataset.to_str().unwrap(), config.to_str().unwrap());
        let train = [
            "train",
            data,
            "-o",
            "m.safetensors",
            "--config",
            config,
            "--steps",
            "4",
            "--json",
        ];
        let told: serde_json::Value =
            serde_json::from_str(&place.ballmark(&train).done().stdout).unwrap();
        assert_eq!(told["steps"], 4, "{config}");
        // What says nothing of localising is localised with as all others are.
        let text = std::fs::read_to_string(config).unwrap();
        if !text.contains("[localise") && localised > 0 {
            assert_eq!(place.files(), ["m.safetensors"]);
            continue;
        }
        localised += 1;
        let localise = [
            "localise",
            "m.safetensors",
            data,
            "--config",
            config,
            "--trials",
            "3",
            "--json",
        ];
        let told: serde_json::Value =
            serde_json::from_str(&place.ballmark(&localise).done().stdout).unwrap();
        assert_eq!(told["trials"], 3, "{config}");
        assert_eq!(place.files(), ["m.safetensors"]);
    }
}
