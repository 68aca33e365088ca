//! What every built-in localiser must keep.

use super::check;
use crate::localiser::{
    bayes::{Bayes, BayesConfig, Known},
    local_grid::{LocalGrid, LocalGridConfig},
    *,
};
use crate::{
    belief::{GridConfig, MapConfig, OdometryMotion},
    detector::{
        Detector,
        filters::Filters,
        input::{Input, InputConfig},
        net::{Activation, NetConfig, Weights},
    },
    recogniser::test_world::{seeing, test_world},
    recording::Columns,
    registry::damaged,
};
use std::{path::PathBuf, sync::OnceLock};
use tempfile::TempDir;

mod public_check;

fn first_lap() -> Vec<usize> {
    (0..104).collect()
}

/// Learned with the default constants; a member that needs a file is made of what would be in it.
fn learned(kind: Kind, recording: &Recording, seed: Seed) -> Learned {
    match kind {
        Kind::Bayes => Learned::Bayes(bayes(recording, seed)),
        Kind::LocalGrid => Learned::LocalGrid(local_grid(recording, seed)),
        _ => learn(&kind.default_config(), recording, &first_lap(), seed).unwrap(),
    }
}

fn needs_a_file(kind: Kind) -> bool {
    matches!(kind, Kind::Bayes | Kind::LocalGrid)
}

/// Small random networks, mapped on the first lap.
fn bayes(recording: &Recording, seed: Seed) -> Bayes {
    let input = Input::fit(&InputConfig::default(), recording, &first_lap()).unwrap();
    let nets = NetConfig {
        dense: Vec::new(),
        convolutions: Vec::new(),
        trunk: vec![8],
        hidden: vec![3],
        activation: Activation::Tanh,
        gain: 1.0,
    };
    let mut weights = seed.stream("networks");
    let mut weights = Weights::random(&nets, input.width(), 4, &mut weights);
    // Untrained networks hardly differ from one half: these do.
    weights.layers.iter_mut().for_each(|l| l.weight *= 5.0);
    let filters = Filters::new(input, weights);
    let shown = recording.select(&first_lap()).unwrap();
    let answers = filters.probabilities(&shown).unwrap();
    let known = Known {
        activation: answers.rows().into_iter().map(|g| g.to_vec()).collect(),
        filters,
        pose: shown.poses().to_vec(),
        route_m: None,
        map: MapConfig::default(),
        motion: OdometryMotion::default(),
    };
    let config = BayesConfig {
        grid: GridConfig {
            cell_m: 0.5,
            headings: 8,
            ..GridConfig::default()
        },
        ..BayesConfig::default()
    };
    Bayes::new(&config, known, recording, &first_lap()).unwrap()
}

/// Given the plan of the room, and made to compare fewer poses than R06 compares.
fn local_grid(recording: &Recording, seed: Seed) -> LocalGrid {
    // One file for all tests: what is learned names it.
    static WORLD: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, world) = WORLD.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let world = folder.path().join("room.toml");
        std::fs::write(&world, PLAN).unwrap();
        (folder, world)
    });
    let config = LocalGridConfig {
        world: world.clone(),
        position_radius_m: 0.1,
        heading_radius_rad: 0.2,
        ..Default::default()
    };
    LocalGrid::learn(&config, recording, &first_lap(), seed).unwrap()
}

const PLAN: &str = "name = 'room'\nwall = [{ points = [[0, 0], [9, 0], [9, 6], [0, 6]], closed = true }]
thing = [{ at = [3, 2], radius_m = 0.5, height_m = 2 }]\npath = { corners = [[0.5, 0.5], [8.5, 0.5]] }
record = { every_m = 0.25 }\nrobot = { kind = 'sancho2' }\nsonar = { beams = 16 }";

/// Trials on the second lap, one of a single snapshot and one of none.
fn trials() -> [Vec<usize>; 4] {
    [104..164, 130..208, 207..208, 120..120].map(Iterator::collect)
}

/// The steps of all trials, each from the true start in the room.
fn played(learned: &Learned, recording: &Recording) -> Vec<Vec<Step>> {
    let all: Vec<usize> = (0..recording.len()).collect();
    let player = learned.as_localiser().prepare(recording, &all).unwrap();
    let play = |(number, trial): (usize, &Vec<usize>)| of_trial(&*player, number, trial);
    trials().iter().enumerate().map(play).collect()
}

fn of_trial(player: &dyn TrialRunner, number: usize, trial: &[usize]) -> Vec<Step> {
    let start = trial.first().map(|&k| test_world().poses()[k]);
    let mut stream = Seed(1).numbered_stream("trial", number as u64);
    player.play(trial, start, &mut stream).unwrap()
}

/// Steps as text, which has all digits: NaN would equal itself.
fn text<T: std::fmt::Debug>(value: &T) -> String {
    format!("{value:?}")
}

fn json(learned: &Learned) -> String {
    serde_json::to_string(learned).unwrap()
}

/// The room with some of its columns changed.
fn changed(change: impl FnOnce(&mut Columns)) -> Recording {
    let mut columns = test_world().into_columns();
    change(&mut columns);
    Recording::new(columns).unwrap()
}

fn is_deterministic(kind: Kind) {
    let room = test_world();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let learned = learned(kind, &room, Seed(3));
            (json(&learned), text(&played(&learned, &room)))
        })
    };
    let once = on(1);
    // Without their texts, which are long.
    assert!(once == on(1), "another time");
    assert!(once == on(3), "on three threads");
}

/// Answers are places that there are, finite, and probabilities sum to 1.
fn check_steps(localiser: &dyn Localiser, steps: &[Step]) {
    for step in steps {
        match step.estimate {
            Some(Estimate::Class(class)) => assert!(class < localiser.places(), "{class}"),
            Some(Estimate::Place(at)) => assert!(at.iter().all(|c| c.is_finite()), "{at:?}"),
            None => (),
        }
        let posterior = &step.posterior;
        let sound =
            |(at, p): &Probable| at.iter().all(|c| c.is_finite()) && (0.0..=1.0).contains(p);
        assert!(posterior.iter().all(sound), "{posterior:?}");
        let sum: f64 = posterior.iter().map(|(_, p)| p).sum();
        assert!(posterior.is_empty() || (sum - 1.0).abs() < 1e-9, "{sum}");
    }
}

fn answers(kind: Kind) {
    let room = test_world();
    let learned = learned(kind, &room, Seed(3));
    let localiser = learned.as_localiser();
    assert_eq!(localiser.name(), kind.name());
    assert!(localiser.places() > 0 || localiser.bytes_per_place() == 0);
    localiser.check_channels(room.channels()).unwrap();
    for (trial, steps) in trials().iter().zip(played(&learned, &room)) {
        assert_eq!(steps.len(), trial.len());
        check_steps(localiser, &steps);
        let mut different: Vec<String> = steps.iter().map(|s| text(&s.estimate)).collect();
        different.dedup();
        // Along half of the walls it is in more than three places.
        assert!(trial.len() < 50 || different.len() > 3, "{different:?}");
    }
}

fn is_causal(kind: Kind) {
    let room = test_world();
    let learned = learned(kind, &room, Seed(3));
    let all = played(&learned, &room);
    for (number, trial) in trials().iter().enumerate() {
        for end in [0, 1, 7, 31].into_iter().filter(|&end| end <= trial.len()) {
            // What comes later is not even known.
            let part = &trial[..end];
            let player = learned.as_localiser().prepare(&room, part).unwrap();
            let steps = of_trial(&*player, number, part);
            assert!(text(&steps) == text(&&all[number][..end]), "{kind} {end}");
        }
    }
}

fn is_total(kind: Kind) {
    let room = test_world();
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX];
    let scans: Vec<Recording> = [0.0, 1.0, -1.0, 1e-30, 1e30]
        .into_iter()
        .chain(odd)
        .map(|v| seeing(&room, |_, _| v))
        .chain([seeing(&room, |k, i| odd[(k + i) % 4])])
        .chain([changed(|columns| columns.compass_rad = None), room.clone()])
        .collect();
    for learned in scans.iter().map(|scan| learned(kind, scan, Seed(1))) {
        learned.check().unwrap();
        for scan in &scans {
            for steps in played(&learned, scan) {
                check_steps(learned.as_localiser(), &steps);
            }
        }
    }
    let error = learn(&kind.default_config(), &room, &[], Seed(1)).unwrap_err();
    assert!(error.to_string().starts_with(kind.name()), "{error}");
}

fn is_blind_to_the_truth(kind: Kind) {
    let room = test_world();
    let learned = learned(kind, &room, Seed(3));
    let elsewhere = changed(|columns| {
        for (k, pose) in columns.pose.iter_mut().enumerate() {
            *pose = Pose::new(-3.0 * k as f64, 7.0, 1.0);
        }
        columns.route_m = Some((0..columns.pose.len()).map(|k| 9.0 * k as f64).collect());
    });
    assert!(text(&played(&learned, &elsewhere)) == text(&played(&learned, &room)));
}

fn names_a_missing_channel(kind: Kind) {
    let room = test_world();
    let learned = learned(kind, &room, Seed(3));
    let localiser = learned.as_localiser();
    let other = changed(|columns| columns.channels[0].name = "lidar".into());
    let wider = changed(|columns| columns.channels[0].unit = "ft".into());
    for other in [other, wider] {
        let checked = localiser.check_channels(other.channels());
        let prepared = localiser.prepare(&other, &[0]).map(|_| ());
        if localiser.is_blind() {
            checked.unwrap();
            prepared.unwrap();
        } else {
            for error in [checked.unwrap_err(), prepared.unwrap_err()] {
                assert!(error.to_string().contains("`sonar`"), "{error}");
            }
        }
    }
}

fn survives_its_file(kind: Kind) {
    let room = test_world();
    let kept = learned(kind, &room, Seed(3));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("localiser.json");
    kept.write(&path).unwrap();
    let read = Learned::read(&path).unwrap();
    assert!(json(&read) == json(&kept));
    assert!(text(&played(&read, &room)) == text(&played(&kept, &room)));

    // A damaged file is refused.
    for text in damaged(&std::fs::read_to_string(&path).unwrap()) {
        std::fs::write(&path, &text).unwrap();
        let error = Learned::read(&path).expect_err(&text);
        assert!(error.to_string().contains("localiser.json"), "{error}");
    }
}

fn has_a_name_and_constants(kind: Kind) {
    assert_eq!(kind.name().parse::<Kind>().unwrap(), kind);
    let config = kind.default_config();
    assert_eq!(config.kind(), kind);
    let json = serde_json::to_string(&config).unwrap();
    assert_eq!(serde_json::from_str::<Config>(&json).unwrap(), config);
    let named = format!("kind = \"{kind}\"");
    assert_eq!(toml::from_str::<Config>(&named).unwrap(), config);
    let unknown = format!("{named}\nraduis = 1");
    let error = toml::from_str::<Config>(&unknown).unwrap_err().to_string();
    assert!(error.contains("raduis"), "{error}");
    assert_eq!(config.check().is_ok(), !needs_a_file(kind));
}

/// All laws for all members: a new line in the registry is under them at once.
macro_rules! laws {
    ($($kind:ident, $module:ident, $config:ident, $what:literal $(, formerly $former:literal)?;)*) => { $(
        mod $module {
            laws!(@each $kind:
                is_deterministic, answers, is_causal, is_total, is_blind_to_the_truth, names_a_missing_channel,
                survives_its_file, has_a_name_and_constants);
        }
    )* };
    (@each $kind:ident: $($law:ident),*) => { $(
        #[test]
        fn $law() {
            super::$law(super::Kind::$kind);
        }
    )* };
}

members!(laws);

#[test]
fn constants_that_make_no_sense_are_named() {
    for (config, key) in [
        (
            "kind = 'evidence'\nexteroceptive_width = 0.0",
            "exteroceptive_width = 0",
        ),
        (
            "kind = 'evidence'\nproprioceptive_width = nan",
            "proprioceptive_width",
        ),
        (
            "kind = 'evidence'\nvariance_growth = -0.1",
            "variance_growth = -0.1",
        ),
        ("kind = 'evidence'\nmap.distance_m = inf", "map.distance_m"),
        ("kind = 'evidence'\nmap.threshold = 0.0", "map.threshold"),
        (
            "kind = 'evidence'\nmap.heading_rad = 4.0",
            "map.heading_rad",
        ),
        (
            "kind = 'evidence'\nmap.weights.sonar = -1.0",
            "map.weights.sonar = -1",
        ),
        (
            "kind = 'evidence'\nmap.weights.radar = 1.0",
            "map.weights.radar",
        ),
        (
            "kind = 'landmark_classifier'\nmap.distance_m = 0.0",
            "map.distance_m",
        ),
    ] {
        let config: Config = toml::from_str(config).unwrap();
        let error = learn(&config, &test_world(), &first_lap(), Seed(0)).unwrap_err();
        let message = error.to_string();
        let kind = config.kind().name();
        assert!(
            error.is_usage() && message.starts_with(kind) && message.contains(key),
            "{message}"
        );
    }
}
