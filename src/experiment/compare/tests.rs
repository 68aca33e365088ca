//! What a configuration may say, and which errors come of what it may not.

use super::*;
use crate::{experiment::protocol::Protocol, localiser, recogniser};

const DATASET: &str = "[[dataset]]\nfile = 'a.npz'\n";
const SYSTEM: &str = "[[system]]\nkind = 'nearest'\n";

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    let error = CompareConfig::parse(text).unwrap_err();
    assert!(error.is_usage(), "{error}");
    let words = error.to_string();
    assert!(!words.contains('\n'), "{words}");
    for part in parts {
        assert!(words.contains(part), "`{part}` is missing in: {words}");
    }
}

#[test]
fn every_kind_of_both_registries_may_take_part() {
    let recognisers = recogniser::Kind::ALL.iter().map(|kind| kind.name());
    let localisers = localiser::Kind::ALL.iter().map(|kind| kind.name());
    for kind in recognisers
        .chain(localisers)
        .chain(["door", "ceiling_light"])
    {
        let text =
            format!("{DATASET}{SYSTEM}name = 'x'\n[[system]]\nkind = '{kind}'\n[standard]\n");
        match CompareConfig::parse(&text) {
            Ok(config) => {
                assert_eq!(config.system[1].name, kind);
                assert_eq!(config.system[1].system.kind(), kind);
                assert!(!config.system[1].system.description().is_empty());
            }
            // What can't do without a file says which.
            Err(error) => assert!(error.to_string().contains("none; expected"), "{error}"),
        }
        let listed = format!("{DATASET}[[system]]\nkind = 'gps'\n[standard]\n");
        refused(&listed, &["line 4", "no kind `gps`", kind]);
    }
}

#[test]
fn constants_and_names_are_taken() {
    let config = CompareConfig::parse(
        "seed = 7\n[[dataset]]\nworld = 'w/hall.toml'\nseed = 3\n[[dataset]]\nname = 'hall, again'\nfile = 'hall.npz'\n\
         [[system]]\nkind = 'nearest'\nname = 'a, \"b\"'\nspacing_m = 2\n\
         [[system]]\nkind = 'ball'\n[system.train]\nfeatures = 2\ndescent = { steps = 5 }\n[recognition]\nbin_m = 3.0\n",
    )
    .unwrap();
    assert_eq!(config.seed, 7);
    assert_eq!(
        [&config.dataset[0].name, &config.dataset[1].name],
        ["hall", "hall, again"]
    );
    assert_eq!(
        (config.dataset[0].seed, config.dataset[1].seed),
        (Some(3), None)
    );
    assert_eq!(config.system[0].name, "a, \"b\"");
    assert_eq!(config.system[0].system.to_json().unwrap()["spacing_m"], 2.0);
    let recipe = config.system[1].recipe().unwrap();
    assert_eq!((recipe.features, recipe.descent.steps), (2, 5));
    assert_eq!(config.recognition.as_ref().unwrap().bin_m, 3.0);
    assert!(config.standard.is_none());
    let json = serde_json::to_value(&config).unwrap();
    assert_eq!(json["system"][0]["kind"], "nearest");
    assert_eq!(json["system"][0]["spacing_m"], 2.0);
    assert_eq!(json["system"][1]["train"]["features"], 2);
}

#[test]
fn faults_have_their_lines() {
    refused("seed = 1\n\nspeed = 2\n", &["line 3", "speed"]);
    refused(
        &format!("{DATASET}{SYSTEM}[standard]\ntrial = 3\n"),
        &["line 6", "trial"],
    );
    refused(
        &format!("{DATASET}colour = 1\n{SYSTEM}[standard]\n"),
        &["line 3", "colour"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}name = 'x'\nspacing = 3\n[standard]\n"),
        &["line 6", "nearest", "unknown field `spacing`", "spacing_m"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}spacing_m = 'far'\n[standard]\n"),
        &["line 5", "`spacing_m`", "far"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}signature = {{ weight = 3 }}\n[standard]\n"),
        &["line 5", "unknown field `weight`"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}name = 3\n[standard]\n"),
        &["line 5", "`name` is 3"],
    );
    refused(
        &format!("{DATASET}[[system]]\nname = 'x'\n[standard]\n"),
        &["line 4", "no `kind`"],
    );
    refused(
        &format!("{DATASET}[[system]]\nkind = 'ball'\n[system.train]\nfeature = 3\n[standard]\n"),
        &["line 5", "`train`", "feature"],
    );
    refused("[standard\n", &["line 1"]);
}

#[test]
fn what_makes_no_sense_together_is_refused() {
    refused(
        &format!("{DATASET}{DATASET}{SYSTEM}[standard]\n"),
        &["two [[dataset]] named `a`"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}{SYSTEM}[standard]\n"),
        &["two [[system]] named `nearest`", "`name`"],
    );
    refused(&format!("{DATASET}[standard]\n"), &["0 [[system]]"]);
    refused(&format!("{SYSTEM}[standard]\n"), &["0 [[dataset]]"]);
    refused(
        &format!("{DATASET}{SYSTEM}"),
        &["nothing is asked", "[error_reduction]"],
    );
    refused(
        &format!("{DATASET}world = 'w.toml'\n{SYSTEM}[standard]\n"),
        &["both `file` and `world`"],
    );
    refused(
        &format!("[[dataset]]\nname = 'x'\n{SYSTEM}[standard]\n"),
        &["neither `file` nor `world`"],
    );
    refused(
        &format!("{DATASET}runs = 3\n{SYSTEM}[standard]\n"),
        &["`a`", "for a `world`"],
    );
    refused(
        &format!("{DATASET}[[system]]\nkind = 'dead_reckoning'\n[recognition]\n"),
        &["[recognition]", "a recogniser"],
    );
    refused(
        &format!("{DATASET}[[system]]\nkind = 'door'\n[standard]\n"),
        &["[standard]", "localiser"],
    );
    refused(
        &format!("{DATASET}[[system]]\nkind = 'door'\n[landmarks]\n"),
        &["[landmarks]", "`world`"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}spacing_m = -1\n[standard]\n"),
        &["`nearest`", "spacing_m = -1"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}[system.train]\nseed = 3\n[standard]\n"),
        &["`nearest`", "`train` only where"],
    );
    refused(
        &format!(
            "{DATASET}[[system]]\nkind = 'ball'\n[system.train]\nsplit = {{ test_fold = 0 }}\n[standard]\n"
        ),
        &["test_fold", "only the mapping part"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}name = ' '\n[standard]\n"),
        &["`name` is empty"],
    );
    refused(
        &format!("{DATASET}{SYSTEM}[standard]\nbin_m = 0\n"),
        &["bin_m"],
    );
}

/// A comparison in code is the same as one in a file.
#[test]
fn systems_are_values() {
    let nearest = recogniser::nearest::NearestConfig {
        spacing_m: 2.0,
        ..Default::default()
    };
    let in_code = CompareConfig {
        dataset: vec![DatasetConfig::file("a.npz")],
        system: vec![SystemConfig::recogniser(
            "x",
            recogniser::Config::Nearest(nearest),
        )],
        standard: Some(Default::default()),
        ..CompareConfig::default()
    };
    let text = format!("{DATASET}{SYSTEM}name = 'x'\nspacing_m = 2\n[standard]\n");
    assert_eq!(CompareConfig::parse(&text).unwrap(), in_code);
    let other = format!("{DATASET}{SYSTEM}name = 'x'\nspacing_m = 3\n[standard]\n");
    assert_ne!(CompareConfig::parse(&other).unwrap(), in_code);
}

#[test]
fn a_kind_is_registered_once() {
    let mut registry = Registry::built_in();
    let taken = registry.add_recogniser::<recogniser::Config>("nearest");
    assert!(taken.unwrap_err().to_string().contains("`nearest`"));
    // A name that a kind had in the version before is taken, too.
    let taken = registry.add_localiser::<localiser::Config>("evidence");
    assert!(taken.unwrap_err().is_usage());
}

/// Stretches of a split have room for the trials of the standard experiment, unless their length is named.
#[test]
fn a_split_leaves_room_for_trials() {
    let config = crate::world::corridor::CorridorConfig {
        runs: 3,
        spacing_m: 1.0,
    };
    let recording = crate::world::corridor::thrun1998(crate::seed::Seed(1), &config).unwrap();
    let with = |protocol: &str| {
        let text =
            format!("{DATASET}{SYSTEM}[standard]\n[protocol]\nmapping = 'split'\n{protocol}");
        let config = CompareConfig::parse(&text).unwrap();
        let protocol = config.protocol_for(&recording);
        let protocol = Protocol::new(&recording, &protocol).unwrap();
        crate::experiment::standard::trials(&protocol, config.standard.as_ref().unwrap())
            .map(|_| ())
    };
    with("").unwrap();
    with("split = { folds = 3 }").unwrap();
    assert!(
        with("split = { unit = '15m' }")
            .unwrap_err()
            .to_string()
            .contains("no trial of 20 m")
    );
}

#[test]
fn the_documented_configuration_is_one() {
    let page = include_str!("../../../docs/compare.md");
    let toml = page
        .split("```toml\n")
        .nth(1)
        .unwrap()
        .split("```")
        .next()
        .unwrap();
    let config = CompareConfig::parse(toml).unwrap();
    assert_eq!(config.system.len(), 4);
    let standard = config.standard.unwrap();
    for (key, value) in [
        ("bin_m", standard.bin_m),
        ("trial_m", standard.trial_m),
        ("every_s", standard.every_s),
        ("step_m", standard.step_m),
        ("coefficient_to_reach", standard.coefficient_to_reach),
    ] {
        assert!(page.contains(&format!("`{key}` {value}")), "{key} {value}");
    }
}

/// A sensor model of somebody else's, by name.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Beacons {
    reach_m: f64,
}

impl crate::registry::Constants for Beacons {
    fn kind(&self) -> &str {
        "beacons"
    }
}

impl crate::experiment::sensor_models::SensorModelConfig for Beacons {
    fn method<'a>(
        &self,
        context: &crate::experiment::methods::MethodContext<'a>,
    ) -> crate::error::Result<crate::experiment::method::Method<'a>> {
        Ok(context.odometry("beacons", "out of reach of all of them"))
    }
}

#[test]
fn landmarks_of_ones_own_are_named_beside_built_in_ones() {
    let mut registry = Registry::built_in();
    registry.add_sensor_model::<Beacons>("beacons").unwrap();
    for taken in ["beacons", "kernel"] {
        let fault = registry.add_sensor_model::<Beacons>(taken).unwrap_err();
        assert!(
            fault.is_usage() && fault.to_string().contains(taken),
            "{fault}"
        );
    }
    let text = |landmarks: &str| {
        format!(
            "{DATASET}[[system]]\nkind = 'bayes'\nlandmarks = {landmarks}\n[localisation]\nseed = 9\n"
        )
    };
    let both = text("['kernel', { kind = 'beacons', reach_m = 4.5 }]");
    let config = CompareConfig::parse_with(&registry, &both).unwrap();
    let json = config.system[0].system.to_json().unwrap();
    assert_eq!(json["kind"], "bayes");
    assert_eq!(json["landmarks"][0]["kind"], "kernel");
    assert_eq!(json["landmarks"][1]["reach_m"], 4.5);
    // A seed of the section's own holds; else it is the comparison's.
    assert_eq!(config.trials().seed, Some(9));
    let other = CompareConfig {
        localisation: Some(Default::default()),
        seed: 4,
        ..config
    };
    assert_eq!(other.trials().seed, Some(4));
    let unknown = CompareConfig::parse(&both).unwrap_err().to_string();
    assert!(unknown.contains("no sensor model `beacons`"), "{unknown}");
}
