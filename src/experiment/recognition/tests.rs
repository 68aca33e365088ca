use super::*;
use crate::{
    experiment::protocol::{Mapping, ProtocolConfig},
    recogniser::BoxedRecogniserConfig,
    recording::Recording,
    world::corridor::{CorridorConfig, thrun1998},
};

fn recording() -> Recording {
    let config = CorridorConfig {
        runs: 3,
        spacing_m: 0.5,
    };
    thrun1998(Seed(2), &config).unwrap()
}

fn protocol(recording: &Recording) -> Protocol<'_> {
    let config = ProtocolConfig {
        mapping: Mapping::FirstRun,
        ..ProtocolConfig::default()
    };
    Protocol::new(recording, &config).unwrap()
}

fn quick() -> RecognitionConfig {
    RecognitionConfig {
        permutations: 49,
        resamples: 49,
        ..RecognitionConfig::default()
    }
}

#[test]
fn all_give_the_number_of_responses_wanted() {
    let recording = recording();
    let protocol = protocol(&recording);
    let binning = protocol.binning(6.0).unwrap();
    for &kind in Kind::ALL.iter().filter(|kind| **kind != Kind::Ball) {
        for wanted in [9, 30] {
            let config = kind.default_config();
            let record = recognise(
                &protocol,
                &binning,
                &config,
                Some(wanted),
                &quick(),
                Seed(1),
                &mut |_| (),
            )
            .unwrap();
            let (constants, record) = (record.config, record.record);
            assert!(
                record.responses.abs_diff(wanted) <= 1,
                "{kind}: {}",
                record.responses
            );
            assert!(record.patterns >= record.responses - usize::from(record.unanswered > 0.0));
            assert_eq!(record.config["kind"], kind.name());
            let judgement = &record.judgement;
            assert_eq!(
                (judgement.n, judgement.responses),
                (protocol.testing.len(), record.responses)
            );
            assert!(
                judgement.uncertainty_coefficient > Some(0.03),
                "{kind}: {judgement:?}"
            );
            assert!(judgement.ci95.is_some() && record.bytes_per_place > 0);
            // What was found is found again from its constants alone, and in its file.
            let again = recognise(
                &protocol,
                &binning,
                &*constants,
                None,
                &quick(),
                Seed(1),
                &mut |_| (),
            )
            .unwrap();
            assert_eq!(again.record.judgement, record.judgement);
            let json = serde_json::to_string(&record).unwrap();
            assert_eq!(
                serde_json::from_str::<RecognitionRecord>(&json).unwrap(),
                record
            );
        }
    }
}

#[test]
fn without_a_number_the_nearest_neighbour_sets_it() {
    let recording = recording();
    let protocol = protocol(&recording);
    let binning = protocol.binning(6.0).unwrap();
    let wanted = quick().wanted("a hall", &protocol, Seed(1)).unwrap();
    let nearest = Kind::Nearest.default_config();
    let as_it_is = recognise(
        &protocol,
        &binning,
        &nearest,
        None,
        &quick(),
        Seed(1),
        &mut |_| (),
    )
    .unwrap();
    assert_eq!(as_it_is.record.config, nearest.to_json().unwrap());
    assert_eq!(as_it_is.record.responses, wanted);
    assert!(wanted > 30, "{wanted}"); // 89 m, a pattern each 1.5 m
}

#[test]
fn a_number_that_cannot_be_met_is_named_with_its_dial() {
    let recording = recording();
    let protocol = protocol(&recording);
    let binning = protocol.binning(6.0).unwrap();
    let rce = Kind::Rce.default_config();
    let error = recognise(
        &protocol,
        &binning,
        &rce,
        Some(5000),
        &quick(),
        Seed(1),
        &mut |_| (),
    )
    .err()
    .unwrap();
    let error = error.to_string();
    assert!(
        error.starts_with("rce: no radius") && error.contains("5000 responses"),
        "{error}"
    );
    for (config, key) in [
        ("bin_m = -6.0", "recognition.bin_m"),
        ("responses = 1", "recognition.responses"),
        ("resamples = 1000001", "recognition.resamples"),
    ] {
        let config: RecognitionConfig = toml::from_str(config).unwrap();
        let error = recognise(
            &protocol,
            &binning,
            &rce,
            None,
            &config,
            Seed(1),
            &mut |_| (),
        )
        .err()
        .unwrap();
        assert!(
            error.is_usage() && error.to_string().starts_with(key),
            "{error}"
        );
    }
}

#[test]
fn the_search_says_how_far_it_is() {
    let recording = recording();
    let protocol = protocol(&recording);
    let binning = protocol.binning(6.0).unwrap();
    let mut said = Vec::new();
    let mut note = |search| said.push(search);
    let rce = Kind::Rce.default_config();
    let found = recognise(
        &protocol,
        &binning,
        &rce,
        Some(12),
        &quick(),
        Seed(1),
        &mut note,
    );
    assert!(found.unwrap().record.responses.abs_diff(12) <= 1);
    let of = |tried, nearest| Search {
        tried,
        nearest,
        wanted: 12,
    };
    assert_eq!(said[0], of(0, None));
    assert!(said.len() > 1 && said[1].tried == 1 && said[1].nearest.is_some());
    let off = |search: &Search| search.nearest.map(|n| n.abs_diff(12));
    assert!(said[1..].is_sorted_by(|a, b| off(a) >= off(b)), "{said:?}");
}

#[test]
fn threads_change_nothing() {
    let recording = recording();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let protocol = protocol(&recording);
            let binning = protocol.binning(6.0).unwrap();
            let config = Kind::GrowingCells.default_config();
            recognise(
                &protocol,
                &binning,
                &config,
                Some(12),
                &quick(),
                Seed(1),
                &mut |_| (),
            )
            .unwrap()
            .record
        })
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn matches_take_time() {
    let recording = recording();
    let protocol = protocol(&recording);
    let answers = Answers::of(&protocol, &Kind::Nearest.default_config(), Seed(1)).unwrap();
    let seconds = seconds_per_match(&protocol, answers.recogniser.as_ref());
    assert!(seconds > 0.0 && seconds.is_finite(), "{seconds}");
}
