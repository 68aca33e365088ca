//! Every file of the fuzzer's corpus goes through its reader again: what was found once stays found, without the fuzzer's compiler.
//! How to look for more: `CONTRIBUTING.md`.

mod readers;

use readers::READERS;
use std::{
    collections::BTreeSet,
    fs,
    panic::catch_unwind,
    path::{Path, PathBuf},
};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz")
}

fn names_in(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let name = |entry: std::io::Result<fs::DirEntry>| {
        let name = entry.unwrap().file_name();
        name.to_string_lossy().into_owned()
    };
    entries.map(name).collect()
}

#[test]
fn no_file_of_the_corpus_makes_a_reader_panic() {
    let mut faults = Vec::new();
    for (name, read) in READERS {
        let corpus = folder().join("corpus").join(name);
        let files = names_in(&corpus);
        assert!(!files.is_empty(), "{name}");
        for file in files {
            let bytes = fs::read(corpus.join(&file)).unwrap();
            if catch_unwind(|| read(&bytes)).is_err() {
                faults.push(format!("{name}/{file}"));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:?}");
}

#[test]
fn every_reader_has_a_corpus_and_a_target() {
    let readers: BTreeSet<String> = READERS.iter().map(|(name, _)| name.to_string()).collect();
    assert_eq!(names_in(&folder().join("corpus")), readers);
    let files = readers.iter().map(|name| format!("{name}.rs")).collect();
    assert_eq!(names_in(&folder().join("targets")), files);
    let manifest = fs::read_to_string(folder().join("Cargo.toml")).unwrap();
    for name in &readers {
        let target = fs::read_to_string(folder().join(format!("targets/{name}.rs"))).unwrap();
        assert!(
            target.contains(&format!("read(\"{name}\", bytes)")),
            "{name}"
        );
        assert!(
            manifest.contains(&format!("path = \"targets/{name}.rs\"")),
            "{name}"
        );
    }
}
