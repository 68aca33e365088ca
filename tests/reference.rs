//! `docs/reference/` tells every key of every configuration, and is made from the code: names, types and meanings from
//! the source, defaults from the types themselves.
//!
//! `BALLMARK_WRITE_REFERENCE=1 cargo test --release --test reference` makes the pages anew.

#[path = "reference/defaults.rs"]
mod defaults;
#[path = "reference/page.rs"]
mod page;
#[path = "reference/source.rs"]
mod source;
#[path = "reference/words.rs"]
mod words;

use ballmark::{
    detector::{ceiling_light::CeilingLight, door::DoorConfig},
    experiment::{
        adaptation::AdaptConfig,
        compare::DatasetConfig,
        error_reduction::ErrorReductionConfig,
        external::ExternalConfig,
        landmarks::LandmarksConfig,
        lifelong::LifelongConfig,
        localisation::LocaliseConfig,
        protocol::ProtocolConfig,
        recognition::RecognitionConfig,
        sensor_models::{
            CompassLandmarks, KernelViewsLandmarks, LearnedLandmarks, RandomBitsLandmarks,
        },
        standard::StandardConfig,
    },
    learning::{Recipe, pretraining::PretrainingConfig},
    localiser::{self, monte_carlo::MonteCarloConfig},
    recogniser,
    recording::degraded::Degraded,
    score::prediction_correction::FrameworkReport,
    world,
};
use defaults::Defaults;
use page::{Page, Section, Source};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};
use toml::Value;

const GENERATED: &str = "<!-- Made from the code by tests/reference.rs; edit the doc comments there, then run\n     BALLMARK_WRITE_REFERENCE=1 cargo test --release --test reference -->\n";

fn in_repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn source() -> Source {
    let folder = in_repository("src");
    let items = source::items(&folder);
    let mut defaults = Defaults::default();
    let files: std::collections::BTreeSet<&String> = items.iter().map(|item| &item.file).collect();
    for file in files {
        let text = fs::read_to_string(in_repository(file)).expect("source is text");
        defaults.note(file, &text);
    }
    Source { items, defaults }
}

fn value(config: impl Serialize) -> Value {
    Value::try_from(config).expect("a configuration is a table")
}

/// A page under construction.
struct Draft<'a> {
    source: &'a Source,
    page: Page,
}

impl<'a> Draft<'a> {
    fn new(source: &'a Source, title: &str, about: &str) -> Self {
        let text = format!("{GENERATED}\n# {title}\n\n{about}\n");
        let page = Page::new(text);
        Self { source, page }
    }

    /// Adds a section, and those within it.
    fn add(&mut self, path: &str, name: &str, file: &str, default: Option<Value>) {
        self.add_beside(path, name, file, default, None);
    }

    /// The same with a second set of defaults. `[[path]]` is one of many.
    fn add_beside(
        &mut self,
        path: &str,
        name: &str,
        file: &str,
        default: Option<Value>,
        other: Option<(&'a str, Value)>,
    ) {
        let item = self.source.find(name, file);
        let item =
            item.unwrap_or_else(|| panic!("no type {name} that a configuration is read into"));
        let is_list = path.starts_with("[[");
        let path = path.trim_matches(['[', ']']).to_string();
        self.source.write(
            &mut self.page,
            Section {
                path,
                is_list,
                item,
                default,
                other,
            },
        );
    }

    fn heading(&mut self, title: &str, about: &str) {
        let _ = write!(self.page.text, "\n## {title}\n\n{about}\n");
    }

    /// Adds a kind of system and its constants: the one struct of its file that has defaults.
    fn add_kind(&mut self, room: &str, name: &str, what: &str, default: Value) {
        let file = format!("src/{room}/{name}.rs");
        let of_file = |item: &&source::Item| item.file == file && item.serde("default").is_some();
        let configs: Vec<&source::Item> = self.source.items.iter().filter(of_file).collect();
        let [item] = configs[..] else {
            panic!("{file}: expected one struct of constants that has defaults");
        };
        self.add_constants(name, what, item, default);
    }

    /// The same for a struct that is found by its name.
    fn add_kind_of(&mut self, kind: &str, name: &str, default: Value) {
        let item = self.source.find(name, "");
        let item =
            item.unwrap_or_else(|| panic!("no type {name} that a configuration is read into"));
        self.add_constants(kind, "", item, default);
    }

    fn add_constants(&mut self, name: &str, what: &str, item: &'a source::Item, default: Value) {
        let _ = write!(self.page.text, "\n### `kind = \"{name}\"`\n");
        if !what.is_empty() {
            let _ = write!(self.page.text, "\n{what}\n");
        }
        let before = self.page.text.len();
        let (path, default) = (String::new(), Some(default));
        self.source.write(
            &mut self.page,
            Section {
                path,
                is_list: false,
                item,
                default,
                other: None,
            },
        );
        let lower = self.page.text.split_off(before).replace("\n## ", "\n#### ");
        self.page.text.push_str(&lower);
    }
}

fn train(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "`[train]`: keys of a training",
        "For `ballmark train --config C.toml`; in a comparison the same keys stand in `[system.train]`. Every key may be \
         left out. Above the sections may stand `recipe = \"default\"` or `recipe = \"thrun1998\"`: the recipe that holds \
         where the file is silent (`--recipe` goes before it). The column `thrun1998` shows where that recipe differs.",
    );
    let other = Some(("thrun1998", value(Recipe::thrun1998())));
    draft.add_beside("train", "Recipe", "", Some(value(Recipe::default())), other);
    draft.page
}

fn pretrain(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "`[pretrain]`: keys of a pre-training",
        "For `ballmark pretrain --config C.toml`, whose section `[train]` ([train.md](train.md)) says what the networks are and how they \
         descend. Every key may be left out.",
    );
    draft.add(
        "pretrain",
        "PretrainingConfig",
        "",
        Some(value(PretrainingConfig::default())),
    );
    draft.page
}

fn degraded(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "`[degraded]`: keys of a worse sensor",
        "For `--config C.toml` of `ballmark train`, `localise` and `features`, and for `ballmark compare C.toml`, where it is of all \
         datasets: they are degraded as soon as they are read. A model is of the sensor that it was trained with, so \
         whoever asks it needs the same section; about its own recording it answers no other. Every key may be left out.",
    );
    draft.add(
        "degraded",
        "Degraded",
        "src/recording/degraded.rs",
        Some(value(Degraded::default())),
    );
    draft.page
}

fn trajectory(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "`ballmark trajectory --config C.toml`: keys of several runs",
        "Texts are printed as they are stated; whatever is not stated is printed as missing. Each run is a `[[run]]`; `estimate` and \
         `reference` must be there. File names are relative to the configuration.",
    );
    let framework = value(FrameworkReport::default());
    draft.add("framework", "FrameworkReport", "", Some(framework));
    draft.add("[[run]]", "RunConfig", "src/cli/trajectory/runs.rs", None);
    draft.page
}

fn localise(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "`[localise]`: keys of trials",
        "For `ballmark localise --config C.toml`. Every key may be left out.",
    );
    draft.add(
        "localise",
        "LocaliseConfig",
        "",
        Some(value(LocaliseConfig::default())),
    );
    draft.page
}

fn adapt(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "`[adapt]` and `[lifelong]`: keys of learning that goes on",
        "`[adapt]` is for `ballmark adapt --config C.toml` and `ballmark lifelong C.toml`, `[lifelong]` for the latter alone, which trains as \
         `[train]` ([train.md](train.md)) says. Every key may be left out.",
    );
    draft.add(
        "adapt",
        "AdaptConfig",
        "",
        Some(value(AdaptConfig::default())),
    );
    draft.add(
        "lifelong",
        "LifelongConfig",
        "",
        Some(value(LifelongConfig::default())),
    );
    draft.page
}

fn compare(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "Keys of a comparison",
        "For `ballmark compare C.toml`; [compare.md](../compare.md) says what the sections ask and which tables they make. \
         Above the sections may stand `seed` (1): of learning, trials, permutations and resamples, and of the worlds that \
         name none. Each of `[standard]`, `[localisation]`, `[recognition]`, `[error_reduction]` and `[landmarks]` that \
         is there makes its tables; `[degraded]` ([degraded.md](degraded.md)) is of all datasets. File names are relative to the \
         configuration.",
    );
    let unnamed = Value::Table(toml::Table::from_iter([("name".into(), "".into())]));
    for (path, name, default) in [
        (
            "[[dataset]]",
            "DatasetConfig",
            value(DatasetConfig::default()),
        ),
        ("[[system]]", "SystemConfig", unnamed),
        (
            "protocol",
            "ProtocolConfig",
            value(ProtocolConfig::default()),
        ),
        (
            "standard",
            "StandardConfig",
            value(StandardConfig::default()),
        ),
        (
            "localisation",
            "LocaliseConfig",
            value(LocaliseConfig::default()),
        ),
        (
            "recognition",
            "RecognitionConfig",
            value(RecognitionConfig::default()),
        ),
        (
            "error_reduction",
            "ErrorReductionConfig",
            value(ErrorReductionConfig::default()),
        ),
        (
            "landmarks",
            "LandmarksConfig",
            value(LandmarksConfig::default()),
        ),
    ] {
        draft.add(
            path,
            name,
            "src/experiment/compare/config.rs",
            Some(default),
        );
    }
    draft.page
}

fn sweep(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "Keys of a sweep",
        "For `ballmark sweep plan S.toml`; [sweeps.md](../sweeps.md) says what to do with one. All but `command` may be left out, as far as the \
         command has no need of them.",
    );
    draft.add("", "SweepConfig", "", None);
    draft.page
}

fn systems(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "Kinds of systems and their constants",
        "For `[[system]]` of a comparison: its `kind` names one of these, and its constants stand beside it. Every \
         constant may be left out. Tables that several kinds have are told at the first of them.",
    );
    draft.heading(
        "Recognisers",
        "A snapshot gives a response, without memory.",
    );
    for kind in recogniser::Kind::ALL {
        draft.add_kind(
            "recogniser",
            kind.name(),
            kind.what(),
            value(kind.default_config()),
        );
    }
    draft.heading("Localisers", "A run gives responses, with memory.");
    let whole = localiser::Kind::ALL.iter();
    for kind in whole.filter(|&&kind| kind != localiser::Kind::Bayes) {
        draft.add_kind(
            "localiser",
            kind.name(),
            kind.what(),
            value(kind.default_config()),
        );
    }
    let default = value(MonteCarloConfig::default());
    draft.add_kind_of("monte_carlo", "MonteCarloConfig", default);
    let default = value(ExternalConfig::default());
    draft.add_kind_of("external", "ExternalConfig", default);
    draft.heading(
        "Sensor models",
        "What the grid Bayes filter, `kind = \"bayes\"`, is driven by in a comparison: `landmarks` names one of these, or \
         is its table with `kind`, or a list of them, which multiply; none (`[]`): odometry alone. `model` names the file of \
         the learned ones, which else are trained on the mapping part by `train`. `kernel`, `likelihood_field`, `beam_model` and \
         `signal_field` have no constants, as what they have is tuned on the validation part; `door` and `ceiling_light` \
         have those below.",
    );
    for (kind, name, default) in [
        (
            "learned",
            "LearnedLandmarks",
            value(LearnedLandmarks::default()),
        ),
        (
            "learned_bits",
            "LearnedLandmarks",
            value(LearnedLandmarks::default()),
        ),
        (
            "random_bits",
            "RandomBitsLandmarks",
            value(RandomBitsLandmarks::default()),
        ),
        (
            "kernel_views",
            "KernelViewsLandmarks",
            value(KernelViewsLandmarks::default()),
        ),
        (
            "compass",
            "CompassLandmarks",
            value(CompassLandmarks::default()),
        ),
    ] {
        draft.add_kind_of(kind, name, default);
    }
    draft.heading("Hand-made landmarks", "Detectors of what people chose.");
    draft.add_kind("detector", "door", "", value(DoorConfig::default()));
    draft.add_kind(
        "detector",
        "ceiling_light",
        "",
        value(CeilingLight::default()),
    );
    draft.page
}

fn world(source: &Source) -> Page {
    let mut draft = Draft::new(
        source,
        "Keys of a world",
        "For `ballmark simulate WORLD.toml`; [format.md](../worlds/format.md) shows a whole world and how its parts belong \
         together. A sensor is there if its table is. `[robot]` also takes `kind` (`\"nomad200\"`, `\"b21\"` or \
         `\"sancho2\"`), which brings sensors and defaults of its own, those below hold without it; and `turret_north = true`: the sensors sit on a turret that is held to \
         north by the compass.",
    );
    draft.add("", "WorldConfig", "", None);
    for (path, name, default) in [
        ("robot", "RobotConfig", value(world::RobotConfig::default())),
        ("sonar", "SonarConfig", value(world::SonarConfig::default())),
        (
            "infrared",
            "InfraredConfig",
            value(world::InfraredConfig::default()),
        ),
        ("laser", "LaserConfig", value(world::LaserConfig::default())),
        (
            "camera",
            "CameraConfig",
            value(world::CameraConfig::default()),
        ),
        (
            "compass",
            "CompassConfig",
            value(world::CompassConfig::default()),
        ),
    ] {
        draft.add(path, name, "", Some(default));
    }
    draft.page
}

/// All pages, by file.
fn pages(source: &Source) -> BTreeMap<&'static str, Page> {
    BTreeMap::from([
        ("train.md", train(source)),
        ("pretrain.md", pretrain(source)),
        ("degraded.md", degraded(source)),
        ("localise.md", localise(source)),
        ("adapt.md", adapt(source)),
        ("compare.md", compare(source)),
        ("sweep.md", sweep(source)),
        ("systems.md", systems(source)),
        ("trajectory.md", trajectory(source)),
        ("world.md", world(source)),
    ])
}

#[test]
fn the_reference_is_what_the_code_says() {
    let source = source();
    let mut stale = Vec::new();
    for (name, page) in pages(&source) {
        let path = in_repository("docs/reference").join(name);
        if std::env::var_os("BALLMARK_WRITE_REFERENCE").is_some() {
            fs::create_dir_all(path.parent().expect("a folder")).expect("a folder for the pages");
            fs::write(&path, &page.text).expect("docs/reference can be written");
        }
        if fs::read_to_string(&path).ok().as_deref() != Some(page.text.as_str()) {
            stale.push(name);
        }
    }
    assert!(
        stale.is_empty(),
        "docs/reference: {stale:?} differ from the code; make them anew with \
         BALLMARK_WRITE_REFERENCE=1 cargo test --release --test reference"
    );
}

/// Types of constants that no file is read into: a library user's alone.
const NOT_OF_A_FILE: [&str; 11] = [
    "BayesConfig",
    "BeamModelConfig",
    "RenderConfig",
    "CorridorConfig",
    "LiveConfig",
    "LostConfig",
    "LikelihoodFieldConfig",
    "OccupancyMapConfig",
    "SignalFieldConfig",
    "Thrun1998Config",
    "Ruizmayor2006Config",
];

#[test]
fn every_configuration_has_its_place_in_the_reference() {
    let source = source();
    let seen: Vec<String> = pages(&source)
        .into_values()
        .flat_map(|page| page.types)
        .collect();
    let missing: Vec<&str> = source
        .items
        .iter()
        .filter(|item| {
            item.is_public
                && item.name.ends_with("Config")
                && item.attributes.contains("Deserialize")
        })
        .map(|item| item.name.as_str())
        .filter(|name| !seen.iter().any(|s| s == name) && !NOT_OF_A_FILE.contains(name))
        .collect();
    assert!(
        missing.is_empty(),
        "{missing:?}: on no page; add them in tests/reference.rs"
    );
}
