//! What every built-in recogniser must keep.

use super::check;
use crate::recogniser::{
    ball::{Ball, BallConfig},
    growing_cells::GrowingCellsConfig,
    test_world::{seeing, test_world},
    *,
};
use crate::{
    detector::{
        filters::Filters,
        input::{Input, InputConfig},
        net::{Activation, NetConfig, Weights},
    },
    geometry::Pose,
    registry::damaged,
};
use ndarray::Array2;

mod public_check;

fn first_lap() -> Vec<usize> {
    (0..104).collect()
}

fn all(recording: &Recording) -> Vec<usize> {
    (0..recording.len()).collect()
}

/// Learned with the default constants; BaLL, which needs a model, from small random networks.
fn learned(kind: Kind, recording: &Recording, seed: Seed) -> Learned {
    if kind != Kind::Ball {
        return learn(&kind.default_config(), recording, &first_lap(), seed).unwrap();
    }
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
    let ball = Ball::new(
        &BallConfig::default(),
        Filters::new(input, weights),
        recording,
        &first_lap(),
    );
    Learned::Ball(ball.unwrap())
}

type Bits = Vec<Option<(usize, u64)>>;

fn bits(answers: &[Option<Response>]) -> Bits {
    let to_bits = |r: Response| (r.class, r.fit.to_bits());
    answers.iter().map(|answer| answer.map(to_bits)).collect()
}

fn text(learned: &Learned) -> String {
    serde_json::to_string(learned).unwrap()
}

fn is_deterministic(kind: Kind) {
    let room = test_world();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let learned = learned(kind, &room, Seed(3));
            let answers = learned.as_recogniser().respond_all(&room, &all(&room));
            (text(&learned), bits(&answers))
        })
    };
    let once = on(1);
    assert_eq!(once, on(1));
    assert_eq!(once, on(3));
}

fn recognises_something(kind: Kind) {
    let room = test_world();
    let learned = learned(kind, &room, Seed(3));
    let recogniser = learned.as_recogniser();
    assert_eq!(recogniser.name(), kind.name());
    assert!(recogniser.matches() > 0);
    // The least is BaLL's four bits, the most a grid of 4096 cells; all patterns together are no more than its file.
    let bytes = recogniser.bytes_per_place();
    assert!((4..5000).contains(&bytes), "{kind}: {bytes} bytes");
    recogniser.check_channels(room.channels()).unwrap();
    let answers = recogniser.respond_all(&room, &all(&room));
    assert_eq!(answers.len(), room.len());
    let classes: Vec<usize> = answers.iter().flatten().map(|r| r.class).collect();
    assert!(classes.iter().all(|&c| c < recogniser.responses()));
    let mut different = classes.clone();
    different.sort_unstable();
    different.dedup();
    assert!(different.len() > 3, "{kind}: {different:?}");
    // The second lap looks like the first but for noise: most answers are the same.
    let same = (0..104).filter(|&k| {
        let class = |k: usize| answers[k].map(|r| r.class);
        class(k).is_some() && class(k) == class(k + 104)
    });
    let same = same.count();
    assert!(same > 70, "{kind}: {same} of 104");
}

fn many_together_are_answered_as_one_by_one(kind: Kind) {
    let room = test_world();
    let learned = learned(kind, &room, Seed(3));
    let recogniser = learned.as_recogniser();
    let some = [150, 3, 3, 207, 0];
    let together = recogniser.respond_all(&room, &some);
    assert_eq!(together.len(), some.len());
    for (k, together) in some.into_iter().zip(together) {
        let alone = recogniser.respond(room.channels(), &room.observation(k));
        if kind == Kind::Ball {
            let (alone, together) = (alone.unwrap(), together.unwrap());
            assert_eq!(alone.class, together.class);
            assert!((alone.fit - together.fit).abs() < 1e-5);
        } else {
            assert_eq!(bits(&[alone]), bits(&[together]));
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
        .collect();
    let learned_from = |scans| learned(kind, scans, Seed(1));
    for learned in scans.iter().chain([&room]).map(learned_from) {
        let recogniser = learned.as_recogniser();
        for scan in &scans {
            let mut answers = recogniser.respond_all(scan, &[0, 1, 2, 3]);
            answers.push(recogniser.respond(scan.channels(), &scan.observation(0)));
            for answer in answers.into_iter().flatten() {
                assert!(answer.fit.is_finite(), "{kind}: {answer:?}");
                assert!(answer.class < recogniser.responses());
            }
        }
        // No sensor, no value, another sensor.
        assert_eq!(recogniser.respond_all(&room, &[]).len(), 0);
        assert_eq!(recogniser.respond(&[], &room.observation(0)), None);
        let none = Array2::<f32>::zeros((1, 0));
        let nothing = Observation {
            values: none.row(0),
            ..room.observation(0)
        };
        assert_eq!(recogniser.respond(room.channels(), &nothing), None);
        assert_eq!(recogniser.respond(&[], &nothing), None);
        let mut other = room.clone().into_columns();
        other.channels[0].name = "lidar".into();
        let other = Recording::new(other).unwrap();
        assert_eq!(recogniser.respond_all(&other, &[0, 1]), [None, None]);
        let error = recogniser.check_channels(other.channels()).unwrap_err();
        assert!(error.to_string().contains("`sonar`"), "{error}");
    }
    if kind != Kind::Ball {
        let error = learn(&kind.default_config(), &room, &[], Seed(1)).unwrap_err();
        assert!(error.to_string().starts_with(kind.name()), "{error}");
    }
}

fn knows_neither_truth_nor_odometry(kind: Kind) {
    let room = test_world();
    let learned = learned(kind, &room, Seed(3));
    let mut elsewhere = room.clone().into_columns();
    for k in 0..room.len() {
        elsewhere.pose[k] = Pose::new(-3.0 * k as f64, 7.0, 1.0);
        elsewhere.odometry[k] = Pose::new(5.0 * k as f64, 2.0, -1.0);
        elsewhere.stamp_s[k] = 1e6 - k as f64;
    }
    let elsewhere = Recording::new(elsewhere).unwrap();
    let on = |r: &Recording| bits(&learned.as_recogniser().respond_all(r, &all(r)));
    assert_eq!(on(&elsewhere), on(&room));
}

fn survives_its_file(kind: Kind) {
    let room = test_world();
    let kept = learned(kind, &room, Seed(3));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recogniser.json");
    kept.write(&path).unwrap();
    let read = Learned::read(&path).unwrap();
    assert_eq!(text(&read), text(&kept));
    let on = |l: &Learned| bits(&l.as_recogniser().respond_all(&room, &all(&room)));
    assert_eq!(on(&read), on(&kept));

    // A damaged file is refused.
    let damaged = damaged(&std::fs::read_to_string(&path).unwrap());
    assert!(damaged.len() > 2, "{}", damaged.len());
    for text in damaged {
        std::fs::write(&path, &text).unwrap();
        let error = Learned::read(&path).expect_err(&text);
        assert!(error.to_string().contains("recogniser.json"), "{error}");
    }
}

fn has_a_name_and_constants(kind: Kind) {
    assert_eq!(kind.name().parse::<Kind>().unwrap(), kind);
    let config = kind.default_config();
    assert_eq!(config.kind(), kind);
    let json = serde_json::to_string(&config).unwrap();
    assert!(
        json.starts_with(&format!("{{\"kind\":\"{kind}\"")),
        "{json}"
    );
    assert_eq!(serde_json::from_str::<Config>(&json).unwrap(), config);
    assert_eq!(
        toml::from_str::<Config>(&format!("kind = \"{kind}\"")).unwrap(),
        config
    );
    let unknown = format!("kind = \"{kind}\"\nraduis = 1");
    let error = toml::from_str::<Config>(&unknown).unwrap_err().to_string();
    assert!(error.contains("raduis"), "{error}");
    if kind != Kind::Ball {
        config.check().unwrap();
    }
}

/// All laws for all members: a new line in the registry is under them at once.
macro_rules! laws {
    ($($kind:ident, $module:ident, $config:ident, $what:literal $(, formerly $former:literal)?;)*) => { $(
        mod $module {
            laws!(@each $kind:
                is_deterministic, recognises_something, many_together_are_answered_as_one_by_one, is_total,
                knows_neither_truth_nor_odometry, survives_its_file, has_a_name_and_constants);
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
fn an_unknown_name_is_answered_with_all_that_there_are() {
    let error = "rbf".parse::<Kind>().unwrap_err();
    assert!(error.is_usage());
    let error = error.to_string();
    assert!(
        Kind::ALL.iter().all(|kind| error.contains(kind.name())),
        "{error}"
    );
}

#[test]
fn constants_that_make_no_sense_are_named() {
    for (config, key) in [
        ("kind = 'rce'\nradius = 2.5", "rce.radius = 2.5"),
        ("kind = 'rce'\nradius = nan", "rce.radius"),
        ("kind = 'nearest'\nspacing_m = 0.0", "nearest.spacing_m"),
        ("kind = 'nearest'\nspacing_m = inf", "nearest.spacing_m"),
        ("kind = 'art2'\nd = 0.95", "art2.c"),
        ("kind = 'growing_cells'\nbest = 1.5", "growing_cells.best"),
        (
            "kind = 'growing_cells'\nneighbour = -0.1",
            "growing_cells.neighbour",
        ),
        ("kind = 'growing_cells'\ndecay = nan", "growing_cells.decay"),
        (
            "kind = 'growing_cells'\nremoval = -1.0",
            "growing_cells.removal",
        ),
        (
            "kind = 'growing_cells'\ninterval = 0",
            "growing_cells.interval = 0",
        ),
        (
            "kind = 'growing_cells'\ncells = 2",
            "growing_cells.cells = 2",
        ),
        ("kind = 'ball'\nmodel = ''", "ball.model"),
        (
            "kind = 'ball'\nmodel = 'm'\nmost_patterns = 0",
            "ball.most_patterns",
        ),
    ] {
        let config: Config = toml::from_str(config).unwrap();
        let error = learn(&config, &test_world(), &first_lap(), Seed(0)).unwrap_err();
        assert!(
            error.is_usage() && error.to_string().starts_with(key),
            "{error}"
        );
    }
}

#[test]
fn a_net_has_the_cells_asked_for_and_needs_three_snapshots() {
    let room = test_world();
    for cells in [3, 17, 40] {
        let config = GrowingCellsConfig {
            cells,
            ..Default::default()
        };
        let net = learn(&Config::GrowingCells(config), &room, &first_lap(), Seed(0)).unwrap();
        assert_eq!(net.as_recogniser().responses(), cells);
    }
    let config = Kind::GrowingCells.default_config();
    let error = learn(&config, &room, &[0, 1], Seed(0)).unwrap_err();
    assert!(error.to_string().contains("2 snapshots"), "{error}");
}
