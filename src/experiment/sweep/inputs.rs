//! Files that cells read, by what is in them: a file that changes is another input, wherever it lies.

use crate::{
    error::{Error, Result},
    storage,
};
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeMap,
    path::{Component, Path, PathBuf},
};
use toml::Value;

/// Keys whose words are names of files, in the configurations of commands, in worlds and in options.
const FILE_KEYS: [&str; 8] = [
    "file",
    "world",
    "model",
    "map",
    "answers",
    "data",
    "from",
    "trained_on",
];
/// Digits of a digest that a name has.
const DIGITS: usize = 16;
/// Most files of a folder of answers.
const MOST_FILES: usize = 100_000;
/// Where inputs lie in a cell's scratch folder.
const FOLDER: &str = "data";

/// One file of an input.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InputFile {
    /// Its name in the input's folder: a world's map lies beside the world.
    pub name: PathBuf,
    /// Where it was found, from the root on.
    pub source: PathBuf,
    /// Of its content.
    pub sha256: String,
    /// Its length.
    pub bytes: u64,
}

/// Something that cells read: a dataset, a model, a world with its map, a folder of answers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// What it is called in a cell's configuration: `data/`, the digest of its content, and its own name.
    pub name: String,
    /// Its files, the one that is named first.
    pub files: Vec<InputFile>,
}

impl Input {
    /// Reads a file, those that it names in turn, or all of a folder, for their digests.
    fn read(path: &Path) -> Result<Self> {
        let path = &path
            .canonicalize()
            .map_err(|e| Error::io("cannot find", path, e))?;
        let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else {
            return Err(Error::file(path, "is the root; expected a file"));
        };
        let mut names = vec![PathBuf::from(name)];
        if path.is_dir() {
            names = below(folder, Path::new(name))?;
        }
        let mut files: Vec<InputFile> = Vec::new();
        // A world names a map, a map a picture.
        let mut at = 0;
        while let Some(name) = names.get(at).cloned() {
            at += 1;
            let source = folder.join(&name);
            let content = storage::read_file(&source)?;
            for named in named_in(&source, &content) {
                let name = name.with_file_name("").join(named);
                let is_inside = name
                    .components()
                    .all(|part| matches!(part, Component::Normal(_)));
                if !folder.join(&name).is_file() || names.contains(&name) {
                    continue;
                }
                if !is_inside {
                    return Err(Error::file(
                        &source,
                        format!(
                            "names {}, which lies elsewhere; expected files beside it or below",
                            name.display()
                        ),
                    ));
                }
                names.push(name);
            }
            files.push(InputFile {
                name,
                source,
                sha256: storage::sha256(&content),
                bytes: content.len() as u64,
            });
        }
        let digest = match &files[..] {
            [] => return Err(Error::file(path, "an empty folder; expected files in it")),
            [one] => one.sha256.clone(),
            several => {
                let line = |file: &InputFile| format!("{} {}\n", file.sha256, file.name.display());
                let lines: String = several.iter().map(line).collect();
                storage::sha256(lines.as_bytes())
            }
        };
        let name = name.to_string_lossy();
        Ok(Self {
            name: format!("{FOLDER}/{}/{name}", &digest[..DIGITS]),
            files,
        })
    }

    /// Its own name, without folder and digest.
    pub fn own_name(&self) -> &str {
        own_name(&self.name)
    }

    /// The folder, in a cell's scratch folder, that its files lie in.
    fn folder(&self) -> PathBuf {
        Path::new(&self.name).with_file_name("")
    }

    /// Puts its files into a cell's scratch folder: as links where there are any. They are looked for by their digest in `cache`,
    /// else where they were found at first.
    ///
    /// # Errors
    /// Where a file is gone, or is not what it was: the message names both digests.
    pub(super) fn place(&self, scratch: &Path, cache: Option<&Path>) -> Result<Vec<Placed>> {
        let folder = scratch.join(self.folder());
        let mut placed = Vec::new();
        for file in &self.files {
            let cached = cache.map(|cache| cache.join(&file.sha256));
            let source = cached.filter(|cached| cached.is_file());
            let source = source.unwrap_or_else(|| file.source.clone());
            let before = Stamp::of(&source)?;
            let found = storage::sha256(&storage::read_file(&source)?);
            if found != file.sha256 {
                return Err(Error::file(
                    &source,
                    format!(
                        "has changed since the sweep was planned: SHA-256 {}…, expected {}…; plan it anew (cells that don't read it keep \
                         their results)",
                        &found[..DIGITS],
                        file.sha256.get(..DIGITS).unwrap_or(&file.sha256)
                    ),
                ));
            }
            let target = folder.join(&file.name);
            storage::make_folder(&target.with_file_name(""))?;
            linked(&source, &target)
                .map_err(|e| Error::io("cannot link a cell's data to", &target, e))?;
            placed.push((source, before));
        }
        Ok(placed)
    }
}

/// An input's own name, by the one in configurations; other words as they are.
pub(super) fn own_name(name: &str) -> &str {
    let inner = name.strip_prefix(FOLDER).and_then(|n| n.strip_prefix('/'));
    let named = inner.and_then(|inner| inner.split_once('/'));
    match named {
        Some((digest, own)) if digest.len() == DIGITS => own,
        _ => name,
    }
}

/// A file that a cell reads, and its stamp before.
pub(super) type Placed = (PathBuf, Stamp);

/// By what a file that was written meanwhile is known.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Stamp(u64, Option<std::time::SystemTime>);

impl Stamp {
    pub(super) fn of(file: &Path) -> Result<Self> {
        let metadata = std::fs::metadata(file).map_err(|e| Error::io("cannot read", file, e))?;
        Ok(Self(metadata.len(), metadata.modified().ok()))
    }
}

#[cfg(unix)]
fn linked(source: &Path, target: &Path) -> std::io::Result<()> {
    let source = source.canonicalize()?;
    std::os::unix::fs::symlink(source, target)
}

#[cfg(not(unix))]
fn linked(source: &Path, target: &Path) -> std::io::Result<()> {
    std::fs::copy(source, target).map(|_| ())
}

/// All files of a folder and its folders, by their names from `root` on.
fn below(root: &Path, folder: &Path) -> Result<Vec<PathBuf>> {
    let path = root.join(folder);
    let unreadable = |e| Error::io("cannot read", &path, e);
    let mut all = Vec::new();
    let entries = std::fs::read_dir(&path).map_err(unreadable)?;
    let mut entries: Vec<PathBuf> = entries
        .map(|entry| entry.map(|entry| folder.join(entry.file_name())))
        .collect::<std::io::Result<_>>()
        .map_err(unreadable)?;
    entries.sort();
    for entry in entries {
        match root.join(&entry).is_dir() {
            true => all.extend(below(root, &entry)?),
            false => all.push(entry),
        }
        if all.len() > MOST_FILES {
            return Err(Error::file(&path, format!("more than {MOST_FILES} files")));
        }
    }
    Ok(all)
}

/// The names of files that a world or a map has in it.
fn named_in(path: &Path, content: &[u8]) -> Vec<String> {
    let Ok(text) = std::str::from_utf8(content) else {
        return Vec::new();
    };
    match path.extension().and_then(|e| e.to_str()) {
        Some("toml") => {
            let mut names = Vec::new();
            let keys = toml::from_str(text).unwrap_or_default(); // what is no TOML is refused by who reads it
            collect(&Value::Table(keys), "", &mut names);
            names
        }
        Some("yaml" | "yml") => {
            let value = |line: &str| Some(line.strip_prefix("image:")?.trim().to_string());
            let image = text.lines().find_map(value);
            let trimmed = image.map(|image| image.trim_matches(['"', '\'']).to_string());
            trimmed.into_iter().collect()
        }
        _ => Vec::new(),
    }
}

fn collect(value: &Value, key: &str, names: &mut Vec<String>) {
    match value {
        Value::Table(keys) => keys
            .iter()
            .for_each(|(key, value)| collect(value, key, names)),
        Value::Array(values) => values.iter().for_each(|value| collect(value, key, names)),
        Value::String(name) if FILE_KEYS.contains(&key) => names.push(name.clone()),
        _ => {}
    }
}

/// All inputs of a sweep, each once.
#[derive(Debug, Default)]
pub(super) struct Inputs {
    known: BTreeMap<PathBuf, String>,
    all: Vec<Input>,
}

impl Inputs {
    /// Puts inputs in place of the names of files in a value that stands under a key; they are relative to `folder`.
    ///
    /// # Errors
    /// Where there is no such file.
    pub(super) fn take(&mut self, value: &mut Value, key: &str, folder: &Path) -> Result<()> {
        let last = key.rsplit('.').next().unwrap_or(key);
        match value {
            Value::Table(keys) => {
                for (key, value) in keys.iter_mut() {
                    self.take(value, key, folder)?;
                }
            }
            Value::Array(values) => {
                for value in values {
                    self.take(value, key, folder)?;
                }
            }
            Value::String(name) if FILE_KEYS.contains(&last) => {
                let is_none = last == "from" && name == "none";
                if !name.is_empty() && !is_none {
                    *name = self.named(&folder.join(&*name))?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn named(&mut self, path: &Path) -> Result<String> {
        if let Some(name) = self.known.get(path) {
            return Ok(name.clone());
        }
        let input = Input::read(path)?;
        let name = input.name.clone();
        self.known.insert(path.to_path_buf(), name.clone());
        if self.all.iter().all(|known| known.name != name) {
            self.all.push(input);
        }
        Ok(name)
    }

    pub(super) fn into_all(self) -> Vec<Input> {
        self.all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_names_elsewhere_does_not_come_along() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(folder.path().join("secret.pgm"), "P5").unwrap();
        std::fs::write(inner.join("m.yaml"), "image: ../secret.pgm\n").unwrap();
        let fault = Input::read(&inner.join("m.yaml")).unwrap_err().to_string();
        assert!(
            fault.contains("m.yaml") && fault.contains("lies elsewhere"),
            "{fault}"
        );
        let fault = Input::read(Path::new("/")).unwrap_err().to_string();
        assert!(fault.contains("is the root"), "{fault}");
    }

    #[test]
    fn an_input_is_called_after_what_is_in_it_and_in_what_it_names() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("maps")).unwrap();
        std::fs::write(
            at("w.toml"),
            "name = \"w\"\nmap = \"maps/m.yaml\"\nnone = \"w.toml\"",
        )
        .unwrap();
        std::fs::write(at("maps/m.yaml"), "image: m.pgm\nresolution: 1\n").unwrap();
        std::fs::write(at("maps/m.pgm"), "picture").unwrap();
        let input = Input::read(&at("w.toml")).unwrap();
        let names: Vec<&str> = input
            .files
            .iter()
            .map(|f| f.name.to_str().unwrap())
            .collect();
        assert_eq!(names, ["w.toml", "maps/m.yaml", "maps/m.pgm"]);
        assert_eq!(input.own_name(), "w.toml");

        let scratch = tempfile::tempdir().unwrap();
        input.place(scratch.path(), None).unwrap();
        let placed = scratch.path().join(input.folder());
        assert_eq!(
            std::fs::read(placed.join("maps/m.pgm")).unwrap(),
            b"picture"
        );

        std::fs::write(at("maps/m.pgm"), "another").unwrap();
        let scratch = tempfile::tempdir().unwrap();
        let fault = input.place(scratch.path(), None).unwrap_err().to_string();
        assert!(fault.contains("m.pgm: has changed since"), "{fault}");
        assert_ne!(Input::read(&at("w.toml")).unwrap().name, input.name);

        // By its digest it is found anywhere.
        let cache = tempfile::tempdir().unwrap();
        std::fs::write(cache.path().join(storage::sha256(b"picture")), "picture").unwrap();
        let scratch = tempfile::tempdir().unwrap();
        input.place(scratch.path(), Some(cache.path())).unwrap();
    }

    #[test]
    fn names_of_files_are_replaced_where_a_key_says_that_they_are_some() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("kernel"), "x").unwrap();
        let mut value = Value::Table(toml::toml! {
            kind = "kernel"
            file = "kernel"
            map = { k = 5 }
            model = ""
        });
        let mut inputs = Inputs::default();
        inputs.take(&mut value, "system", folder.path()).unwrap();
        assert_eq!(value["kind"].as_str(), Some("kernel"));
        let name = value["file"].as_str().unwrap();
        assert_eq!(
            (own_name(name), own_name("data/x"), value["model"].as_str()),
            ("kernel", "data/x", Some(""))
        );
        assert_eq!(inputs.into_all()[0].name, name);
        let mut none = Value::String("none".into());
        Inputs::default()
            .take(&mut none, "from", folder.path())
            .unwrap();
        let fault = Inputs::default().take(&mut none, "system.x.map", folder.path());
        assert!(fault.unwrap_err().is_io());
    }
}
