//! The order of rooms, kept: a room uses only rooms above it in `src/lib.rs`, and a few rooms less than that; and no files
//! use one another in a ring.

#[path = "layering/rings.rs"]
mod rings;
#[path = "layering/scopes.rs"]
mod scopes;
#[path = "layering/source.rs"]
mod source;

use source::{Token, module_of, named, tokens};
use std::{collections::BTreeMap, fs, path::Path};

/// Source texts by their name, `src/…` with slashes.
type Tree = BTreeMap<String, String>;

/// Rooms that must not use some of the rooms above them, and why.
const KEPT_APART: [(&str, &[&str], &str); 4] = [
    (
        "recogniser",
        &["world", "learning"],
        "a recogniser is given snapshots and needs no trainer",
    ),
    (
        "localiser",
        &["world", "learning"],
        "localising needs no trainer and can't tell a simulated recording from a logged one",
    ),
    ("score", ROBOT, "score knows no robot"),
    (
        "report",
        ROBOT,
        "report reads only Records, so that a table can be redrawn without the data",
    ),
];

/// What a file may use all the same: the file, the path, and why.
const GRANTED: [(&str, &str, &str); 1] = [(
    "src/localiser/local_grid.rs",
    "crate::world::ExpectedRanges",
    "a robot may be given the plan of a building, and know its own sensors; nothing else of a simulated world",
)];

const ROBOT: &[&str] = &[
    "recording",
    "world",
    "belief",
    "detector",
    "learning",
    "model",
    "recogniser",
    "localiser",
];

/// Files that may use Burn: beginnings of their names.
const BURN_STAYS_IN: [&str; 6] = [
    "src/detector/device.rs",
    "src/detector/net.rs",
    "src/detector/net/",
    "src/learning/trainer",
    "src/learning/optimiser",
    "src/model/",
];

/// Everything in the tree that breaks a rule, one line each: file, line, what is used, and the rule.
///
/// Not checked, as files of one room do name each other (`super::places::Places`): that siblings meet in their `mod.rs`
/// alone. What is checked of it: a folder within a room is entered from outside through its `mod.rs` only.
fn violations(tree: &Tree) -> Vec<String> {
    let empty = String::new();
    let lib = tokens(tree.get("src/lib.rs").unwrap_or(&empty));
    let rooms = declared_modules(&lib);
    let order = |room: &str| rooms.iter().position(|r| r == room);
    let exports = exports(tree.get("src/lib.rs").unwrap_or(&empty));
    let mut found = Vec::new();
    for (file, text) in tree.iter().filter(|(file, _)| *file != "src/lib.rs") {
        if file == "src/main.rs" {
            found.extend(main_violations(file, text));
            continue;
        }
        let module = module_of(file);
        let room = module.get(1).map_or("", String::as_str);
        let Some(here) = order(room) else {
            found.push(format!(
                "{file}: belongs to no room that src/lib.rs declares"
            ));
            continue;
        };
        for name in named(file, text) {
            let place = format!("{file}:{}: uses `{}`", name.line, name.path.join("::"));
            if is_burn(&name.path[0]) && !BURN_STAYS_IN.iter().any(|f| file.starts_with(f)) {
                found.push(format!(
                    "{place}: Burn stays in {}",
                    BURN_STAYS_IN.join(", ")
                ));
            }
            if name.path[0] != "crate" {
                continue;
            }
            let first = name.path.get(1).map_or("", String::as_str);
            let used = exports.get(first).map_or(first, String::as_str);
            let Some(there) = order(used) else {
                found.push(format!("{place}: expected a room that src/lib.rs declares"));
                continue;
            };
            if there > here {
                found.push(format!(
                    "{place}: `{room}` stands above `{used}` in src/lib.rs; a room uses only rooms above it"
                ));
            }
            let granted = GRANTED
                .iter()
                .any(|(by, path, _)| file == by && name.path.join("::") == *path);
            for (apart, from, why) in KEPT_APART {
                if room == apart && from.contains(&used) && !granted {
                    found.push(format!("{place}: `{room}` must not use `{used}`: {why}"));
                }
            }
            if let Some(folder) = entered_beside_its_mod(tree, &module, &name.path) {
                found.push(format!(
                    "{place}: {folder} is entered from outside through its mod.rs only"
                ));
            }
        }
    }
    found
}

/// Names in `mod name;` in their order.
fn declared_modules(tokens: &[Token]) -> Vec<String> {
    let declares = |w: &&[Token]| w[0].text == "mod" && w[2].text == ";";
    let names = tokens.windows(3).filter(declares);
    names.map(|w| w[1].text.clone()).collect()
}

/// The room behind each name that `src/lib.rs` exports, as in `pub use error::{Error, Result}`.
fn exports(lib: &str) -> BTreeMap<String, String> {
    let paths = named("src/lib.rs", lib).into_iter().map(|n| n.path);
    let relative = paths.map(|path| path.into_iter().filter(|part| part != "crate"));
    let parts = relative.map(Iterator::collect::<Vec<String>>);
    parts
        .filter(|parts| parts.len() > 1)
        .map(|parts| (parts[parts.len() - 1].clone(), parts[0].clone()))
        .collect()
}

fn is_burn(name: &str) -> bool {
    name == "burn" || name.starts_with("burn_")
}

fn main_violations(file: &str, text: &str) -> Vec<String> {
    let modules = declared_modules(&tokens(text)).into_iter();
    let modules = modules.map(|m| format!("{file}: declares `{m}`: main uses the library alone"));
    let names = named(file, text).into_iter();
    // A program has one allocator, and only its main can choose it.
    let allowed = ["std", "ballmark", "mimalloc"];
    let others = names.filter(|n| !allowed.contains(&n.path[0].as_str()));
    let others = others.map(|n| {
        let (line, path) = (n.line, n.path.join("::"));
        format!("{file}:{line}: uses `{path}`: main uses the library alone")
    });
    modules.chain(others).collect()
}

/// The folder within a room whose file is named past its `mod.rs`, from outside that folder.
fn entered_beside_its_mod(tree: &Tree, module: &[String], path: &[String]) -> Option<String> {
    let folder = path.get(..3)?;
    let file = path.get(3)?;
    let name = format!("src/{}", folder[1..].join("/"));
    let within = tree.contains_key(&format!("{name}/{file}.rs"));
    (within && !module.starts_with(folder)).then_some(name)
}

fn read_tree(folder: &Path, name: &str, tree: &mut Tree) {
    for entry in fs::read_dir(folder).expect("a folder of the source") {
        let path = entry.expect("an entry of it").path();
        let name = format!("{name}/{}", path.file_name().unwrap().to_string_lossy());
        if path.is_dir() {
            read_tree(&path, &name, tree);
        } else if name.ends_with(".rs") {
            tree.insert(name, fs::read_to_string(&path).expect("source is text"));
        }
    }
}

#[test]
fn rooms_use_only_rooms_above_them() {
    let mut tree = Tree::new();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    read_tree(&source, "src", &mut tree);
    assert!(tree.len() > 50 && tree.contains_key("src/cli/mod.rs"));
    let uses: usize = tree.iter().map(|(f, t)| named(f, t).len()).sum();
    assert!(uses > 500, "only {uses} paths found");
    let found = violations(&tree);
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn no_files_use_one_another_in_a_ring() {
    let mut tree = Tree::new();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    read_tree(&source, "src", &mut tree);
    let found: Vec<String> = rings::rings(&tree);
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

/// Rings of these files only.
fn rings_of(files: &[(&str, &str)]) -> Vec<String> {
    let text = |(file, text): &(&str, &str)| (file.to_string(), text.to_string());
    rings::rings(&files.iter().map(text).collect())
}

#[test]
fn rings_of_files_are_reported_with_their_files() {
    let log = (
        "src/log.rs",
        "pub struct Log; pub fn read() { crate::csv::read() }",
    );
    for csv in [
        "use crate::log::Log; pub fn read() {}",
        "use crate::{error::Error, log::{self, Log}}; pub fn read() { log::other() }",
        "use super::log; pub fn read() -> log::Log { todo!() }",
        "pub fn read() -> crate::log::Log { todo!() }",
        "mod inner { use super::super::log::Log; } pub fn read() {}",
        "use super::log::*; pub fn read() {}",
        "use super::log::Log as L; pub fn read() {}",
    ] {
        let found = rings_of(&[
            log,
            ("src/csv.rs", csv),
            ("src/error.rs", "pub struct Error;"),
        ]);
        assert_eq!(found.len(), 1, "{csv}");
        for part in [
            "src/csv.rs:1 uses src/log.rs",
            "src/log.rs:1 uses src/csv.rs",
        ] {
            assert!(found[0].contains(part), "{found:?}");
        }
    }
}

#[test]
fn a_ring_may_lead_over_several_files_and_names_that_are_passed_on() {
    let found = rings_of(&[
        (
            "src/room/mod.rs",
            "mod a; mod b; mod c; pub use a::A; pub use b::B;\npub use c::C;",
        ),
        ("src/room/a.rs", "use super::B; pub struct A(B);"),
        ("src/room/b.rs", "use crate::room::C; pub struct B(C);"),
        (
            "src/room/c.rs",
            "\npub struct C; fn f() { super::A::new() }",
        ),
    ]);
    assert_eq!(
        found,
        [
            "files in a ring: src/room/a.rs:1 uses src/room/b.rs, src/room/b.rs:1 uses src/room/c.rs, \
          src/room/c.rs:2 uses src/room/a.rs"
        ]
    );
    // Who uses a part of a module uses the module.
    let found = rings_of(&[
        (
            "src/trainer.rs",
            "mod progress; use crate::checkpoint::read; pub fn train() { read() }",
        ),
        ("src/trainer/progress.rs", "pub struct Progress;"),
        (
            "src/checkpoint.rs",
            "use crate::trainer::progress::Progress; pub fn read() {}",
        ),
    ]);
    assert_eq!(found.len(), 1, "{found:?}");
}

#[test]
fn what_is_no_ring_is_not_reported() {
    let found = rings_of(&[
        // A module and its parts; a re-export is no use.
        (
            "src/room/mod.rs",
            "mod part; mod other; pub use other::Other; pub struct Whole; fn f() { part::f() }",
        ),
        ("src/room/part.rs", "use super::Whole; pub fn f() {}"),
        (
            "src/room/other.rs",
            "use super::{Whole, part}; pub struct Other; fn f() { part::f() }",
        ),
        // Tests may use anything, comments and strings are no use, nor are names of other crates.
        (
            "src/log.rs",
            "pub struct Log; #[cfg(test)] mod tests { use crate::csv::read; } #[cfg(test)] mod far;",
        ),
        ("src/log/far.rs", "use crate::csv::read;"),
        (
            "src/csv.rs",
            "use crate::log::Log; use ::csv::Reader; use toml::Value; pub fn read() {}",
        ),
        (
            "src/toml.rs",
            "// crate::csv::read\nconst A: &str = \"crate::csv::read\"; use ::csv::read; pub struct Value;",
        ),
    ]);
    assert_eq!(found, [""; 0]);
}

const LIB: &str = "pub mod error;\npub mod geometry;\npub mod recording;\npub mod world;\npub mod learning;\n\
                   pub mod localiser;\npub mod report;\npub mod cli;\npub use error::{Error, Result};";

/// What is found when `file` with `text` is added to a house in order.
fn added(file: &str, text: &str) -> Vec<String> {
    let house = [
        ("src/lib.rs", LIB),
        ("src/main.rs", "fn main() { ballmark::cli::run() }"),
        ("src/error.rs", "use std::fmt;"),
        ("src/geometry.rs", "use crate::Error;"),
        (
            "src/recording/mod.rs",
            "use crate::{error::Result, geometry::Pose};",
        ),
        (
            "src/recording/carmen/mod.rs",
            "use super::super::geometry; use message::A;",
        ),
        (
            "src/recording/carmen/message.rs",
            "use super::Carmen; use crate::Result;",
        ),
        (
            "src/world/mod.rs",
            "use crate::recording::{Recording, carmen::Carmen};",
        ),
        (
            "src/cli/mod.rs",
            "use crate::{world, report::Table}; mod train;",
        ),
    ];
    let mut tree: Tree = house.map(|(f, t)| (f.into(), t.into())).into();
    assert_eq!(violations(&tree), [""; 0], "the house is in order");
    tree.insert(file.into(), text.into());
    violations(&tree)
}

#[track_caller]
fn reported(file: &str, text: &str, parts: &[&str]) {
    let found = added(file, text);
    assert_eq!(found.len(), 1, "{found:?}");
    for part in parts {
        assert!(found[0].contains(part), "`{part}` is missing in {found:?}");
    }
}

#[test]
fn upward_uses_are_reported_however_they_are_written() {
    let rule = "a room uses only rooms above it";
    let file = "src/recording/log.rs";
    let at_2 = "src/recording/log.rs:2: uses `crate::world::Wall`";
    for upward in [
        "// first\nuse crate::world::Wall;",
        "\nuse crate::{error::Error, world::{Wall}};",
        "use crate::{error::Error,\n    world::Wall as W, geometry::Pose};",
        "\nfn f() -> crate::world::Wall { todo!() }",
        "\nuse super::super::world::Wall;",
        "mod inner { mod most {\nuse super::super::super::super::world::Wall; } }",
        "#[cfg(test)] mod tests {\n use crate::world::Wall; }",
        "const A: char = '\"';\nuse crate::world::Wall; const B: char = '\"';",
        "const A: &str = r#\"\"\n\"#; use crate::world::Wall;",
        "fn f<'a>(a: &'a u8) { g::<u8>(a) }\npub(crate) use crate::world::Wall;",
    ] {
        reported(file, upward, &[at_2, "`world`", rule]);
    }
    // Ground files stand in an order of their own.
    reported(
        "src/error.rs",
        "use crate::geometry::Pose;",
        &["src/error.rs:1", "`geometry`", rule],
    );
    reported("src/error.rs", "use super::{cli};", &["`cli`", rule]);
    reported(
        "src/recording/log.rs",
        "use crate::{self as all};",
        &["expected a room"],
    );
    reported(
        "src/recording/log.rs",
        "use crate::*;",
        &["expected a room"],
    );
    reported("src/helpers.rs", "", &["src/helpers.rs", "no room"]);
}

#[test]
fn what_is_no_use_is_not_reported() {
    for harmless in [
        "// crate::world::Wall\n/* crate::world /* crate::cli */ crate::cli */",
        "//! [`crate::world::Wall`]\n/// crate::cli\nfn f() {}",
        "const A: &str = \"crate::world \\\" crate::cli\"; const B: &[u8] = br##\"crate::cli\"# \"##;",
        "mod world { use super::super::geometry; } use self::world::Wall;",
        "use std::fmt; fn f() { other::world::cli() }",
    ] {
        assert_eq!(
            added("src/recording/log.rs", harmless),
            [""; 0],
            "{harmless}"
        );
    }
}

#[test]
fn rooms_kept_apart_burn_main_and_inner_folders_are_guarded() {
    let report = "src/report/table.rs";
    reported(
        report,
        "use crate::recording::Recording;",
        &["src/report/table.rs:1", "only Records"],
    );
    let localiser = "src/localiser/mod.rs";
    reported(
        localiser,
        "use crate::learning::Recipe;",
        &["localiser/mod.rs:1", "needs no trainer"],
    );
    let plan = "use crate::world::ExpectedRanges;";
    assert_eq!(added("src/localiser/local_grid.rs", plan), [""; 0]);
    let building = "use crate::world::{Building, ExpectedRanges};";
    for (file, world) in [
        ("src/localiser/local_grid.rs", building),
        ("src/localiser/bayes.rs", plan),
    ] {
        reported(file, world, &["crate::world::", "simulated recording"]);
    }
    let tensor = "use burn::tensor::Tensor;";
    reported(
        "src/world/robot.rs",
        tensor,
        &["src/world/robot.rs:1", "Burn stays in"],
    );
    reported(
        "src/world/robot.rs",
        "fn f(a: burn_core::A) {}",
        &["Burn stays in"],
    );
    assert_eq!(added("src/learning/trainer.rs", tensor), [""; 0]);
    reported("src/main.rs", "mod extra;", &["`extra`", "library alone"]);
    reported(
        "src/main.rs",
        "fn main() { clap::go() }",
        &["src/main.rs:1: uses `clap::go`"],
    );
    let past = "use crate::recording::carmen::message::A;";
    reported(
        "src/world/robot.rs",
        past,
        &["src/recording/carmen", "mod.rs only"],
    );
    assert_eq!(added("src/recording/carmen/odometry.rs", past), [""; 0]);
}
