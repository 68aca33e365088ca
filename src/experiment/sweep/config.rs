//! A sweep as a TOML file says it: a command, what all cells share, and what they differ in.

use super::command::Command;
use crate::{
    error::{Error, Result},
    toml_file::TomlFile,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use toml::{
    Spanned, Table, Value,
    de::{DeTable, DeValue},
};

/// A sweep. File names in it are relative to it, those in `config` to that file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepConfig {
    /// What every cell runs: `train`, `localise`, `compare` or `reproduce`.
    pub command: Command,
    /// Configuration that all cells start from; not said: the command's defaults.
    #[serde(default)]
    pub config: Option<PathBuf>,
    /// Keys of a configuration, put over those of `config`.
    #[serde(default)]
    pub base: Table,
    /// Datasets of `train` and `localise`: a file, or a list of which each is taken in turn; several that count as one stand in a list in
    /// the list.
    #[serde(default)]
    pub data: Option<Value>,
    /// What the command line has besides: of `train` `from`, `map`, `bank`, `device`; of `localise` `model`, `trained_on`, `map`; of
    /// `compare` `toy`; of `reproduce` `paper`, `toy`.
    #[serde(default)]
    pub options: Table,
    /// What cells differ in: a key of the configuration by its path (`train.features`, `system.NAME.spacing_m`), or an option,
    /// with a list of values. Every value is combined with every value of the others.
    #[serde(default)]
    pub keys: Table,
    /// Or keys with a value each, that belong together; each of these tables is combined with every value of `keys`.
    #[serde(default)]
    pub combination: Vec<Table>,
    /// Seeds, each of which every combination runs with; not said: that of the configuration.
    #[serde(default)]
    pub seeds: Option<Vec<u64>>,
    /// Figures for the table, by their paths in a cell's record; not said: the command's headline figures.
    #[serde(default)]
    pub metrics: Vec<String>,
    /// What others are held against: keys with one of their values each. Not said: the first combination on the same data.
    #[serde(default)]
    pub baseline: Table,
}

/// A key with a value, and the line where that stands.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Setting {
    pub key: String,
    pub value: Value,
    pub line: usize,
}

/// A sweep file that was read.
#[derive(Debug)]
pub(super) struct SweepFile {
    pub file: TomlFile,
    /// What names of files are relative to.
    pub folder: PathBuf,
    pub config: SweepConfig,
    /// Values of a key, for every key that has some, in the order of the file.
    pub axes: Vec<Vec<Setting>>,
    pub combinations: Vec<Vec<Setting>>,
}

/// Most cells of a sweep.
const MOST_CELLS: usize = 1_000_000;

impl SweepFile {
    /// # Errors
    /// A usage error with file and line where the file is no TOML, a key is unknown or of the wrong type, a list is empty, or a value or
    /// seed stands twice.
    pub fn read(path: &Path) -> Result<Self> {
        let text = String::from_utf8(crate::storage::read_file(path)?).map_err(|_| {
            Error::usage(format!("{}: not UTF-8 text; expected TOML", path.display()))
        })?;
        let file = TomlFile::read(path)?;
        let config: SweepConfig = file.parse()?;
        let spans = DeTable::parse(&text).map_err(|e| file.refusal(1, e.message()))?;
        let spans = spans.into_inner();
        let at = |span: &std::ops::Range<usize>| file.line_at(span.start);
        let mut axes: Vec<(usize, Vec<Setting>)> = Vec::new();
        if let Some(data) = &config.data {
            let place = spans.get("data").map_or(0, |value| value.span().start);
            let line = file.line_at(place);
            let values = match data {
                Value::Array(values) => values.clone(),
                one => vec![one.clone()],
            };
            let setting = |value| Setting {
                key: "data".into(),
                value,
                line,
            };
            axes.push((place, values.into_iter().map(setting).collect()));
        }
        let mut leaves = Vec::new();
        if let Some(keys) = spans.get("keys") {
            flatten(keys, "", &Value::Table(config.keys.clone()), &mut leaves);
        }
        for leaf in leaves {
            let (Value::Array(values), DeValue::Array(spans)) = (&leaf.value, leaf.spanned) else {
                let fault = format!("keys.{}: expected a list of values", leaf.key);
                return Err(file.refusal(file.line_at(leaf.place), fault));
            };
            let settings = values
                .iter()
                .zip(spans.iter())
                .map(|(value, place)| Setting {
                    key: leaf.key.clone(),
                    value: value.clone(),
                    line: at(&place.span()),
                });
            axes.push((leaf.place, settings.collect()));
        }
        axes.sort_by_key(|(place, _)| *place);
        let mut combinations = Vec::new();
        let tables = spans.get("combination").map(Spanned::get_ref);
        if let Some(DeValue::Array(tables)) = tables {
            for (table, value) in tables.iter().zip(&config.combination) {
                let mut leaves = Vec::new();
                flatten(table, "", &Value::Table(value.clone()), &mut leaves);
                leaves.sort_by_key(|leaf| leaf.place);
                let settings = leaves.into_iter().map(|leaf| Setting {
                    key: leaf.key,
                    value: leaf.value,
                    line: file.line_at(leaf.place),
                });
                combinations.push(settings.collect());
            }
        }
        let axes: Vec<Vec<Setting>> = axes.into_iter().map(|(_, axis)| axis).collect();
        let seeds = spans.get("seeds").map_or(1, |seeds| at(&seeds.span()));
        let read = Self {
            folder: path.parent().unwrap_or(Path::new("")).to_path_buf(),
            axes,
            combinations,
            config,
            file,
        };
        read.check(seeds)?;
        Ok(read)
    }

    fn check(&self, seeds_line: usize) -> Result<()> {
        let mut seen: Vec<&str> = Vec::new();
        for axis in &self.axes {
            let Some(first) = axis.first() else {
                let fault = "an empty list in [keys] or `data`; expected at least one value";
                return Err(self.file.refusal(1, fault));
            };
            if seen.contains(&first.key.as_str()) {
                let fault = format!("`{}` stands twice", first.key);
                return Err(self.file.refusal(first.line, fault));
            }
            seen.push(&first.key);
            for (number, setting) in axis.iter().enumerate() {
                if axis[..number].iter().any(|s| s.value == setting.value) {
                    let fault = format!("{}: {} stands twice", setting.key, setting.value);
                    return Err(self.file.refusal(setting.line, fault));
                }
            }
        }
        for setting in self.combinations.iter().flatten() {
            if seen.contains(&setting.key.as_str()) {
                let fault = format!(
                    "[[combination]]: `{}` stands in [keys], too; expected one of them",
                    setting.key
                );
                return Err(self.file.refusal(setting.line, fault));
            }
        }
        let mut seeds = self.config.seeds.clone().unwrap_or_default();
        let refused = |fault: String| Err(self.file.refusal(seeds_line, fault));
        if self.config.seeds.as_ref().is_some_and(Vec::is_empty) {
            return refused("seeds: none; expected at least one, or no `seeds`".into());
        }
        seeds.sort_unstable();
        if let Some(twice) = seeds.windows(2).find(|pair| pair[0] == pair[1]) {
            return refused(format!("seeds: {} stands twice", twice[0]));
        }
        let lengths = self.axes.iter().map(Vec::len);
        let lengths = lengths.chain([self.combinations.len().max(1), seeds.len().max(1)]);
        let cells = lengths.fold(1, usize::saturating_mul);
        if cells > MOST_CELLS {
            let fault = format!("{cells} cells; expected at most {MOST_CELLS}");
            return Err(self.file.refusal(1, fault));
        }
        Ok(())
    }
}

/// A value below a table, by its path.
struct Leaf<'a> {
    key: String,
    value: Value,
    spanned: &'a DeValue<'a>,
    place: usize,
}

/// All that is no table below a table, with its path.
fn flatten<'a>(
    spanned: &'a Spanned<DeValue<'a>>,
    path: &str,
    value: &Value,
    leaves: &mut Vec<Leaf<'a>>,
) {
    match (spanned.get_ref(), value) {
        (DeValue::Table(spans), Value::Table(values)) => {
            for (key, inner) in spans.iter() {
                let word = key.get_ref().as_ref();
                let path = match path {
                    "" => word.to_string(),
                    path => format!("{path}.{word}"),
                };
                if let Some(value) = values.get(word) {
                    flatten(inner, &path, value, leaves);
                }
            }
        }
        (other, value) => leaves.push(Leaf {
            key: path.to_string(),
            value: value.clone(),
            spanned: other,
            place: spanned.span().start,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<SweepFile> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.toml");
        std::fs::write(&path, text).unwrap();
        SweepFile::read(&path)
    }

    #[test]
    fn keys_are_in_the_order_of_the_file_however_they_are_written() {
        let read = read(
            "command = 'train'\ndata = ['a', ['b', 'c']]\n[keys]\ntrain.features = [2,\n 4]\n'train.descent.steps' = [9]\nfrom = ['none']\n\
             [[combination]]\ntrain.seed = 3\n[[combination]]\ntrain = { seed = 4, uncertainty = '2m' }",
        )
        .unwrap();
        let shown = |settings: &[Setting]| -> Vec<String> {
            let one = |s: &Setting| format!("{}={}@{}", s.key, s.value, s.line);
            settings.iter().map(one).collect()
        };
        let axes: Vec<Vec<String>> = read.axes.iter().map(|axis| shown(axis)).collect();
        assert_eq!(axes[0], ["data=\"a\"@2", "data=[\"b\", \"c\"]@2"]);
        assert_eq!(axes[1], ["train.features=2@4", "train.features=4@5"]);
        assert_eq!(axes[2], ["train.descent.steps=9@6"]);
        assert_eq!(axes[3], ["from=\"none\"@7"]);
        assert_eq!(shown(&read.combinations[0]), ["train.seed=3@9"]);
        assert_eq!(
            shown(&read.combinations[1]),
            ["train.seed=4@11", "train.uncertainty=\"2m\"@11"]
        );
    }

    #[test]
    fn a_file_at_fault_is_refused_with_the_line() {
        for (text, part) in [
            ("command = 'trane'", "line 1: unknown variant `trane`"),
            ("command = 'train'\nkey = 3", "line 2: unknown field `key`"),
            (
                "command = 'train'\nseeds = [1, -1]",
                "line 2: invalid value",
            ),
            (
                "command = 'train'\nseeds = [3, 1, 3]",
                "line 2: seeds: 3 stands twice",
            ),
            ("command = 'train'\nseeds = []", "line 2: seeds: none"),
            (
                "command = 'train'\n[keys]\ntrain.features = 3",
                "line 3: keys.train.features: expected a list",
            ),
            (
                "command = 'train'\n[keys]\na = [1,\n2,\n1]",
                "line 5: a: 1 stands twice",
            ),
            ("command = 'train'\n[keys]\na = []", "an empty list"),
            (
                "command = 'train'\n[keys]\na = [1]\n[[combination]]\na = 2",
                "line 5: [[combination]]: `a` stands in [keys], too",
            ),
        ] {
            let fault = read(text).unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains(part),
                "{fault}"
            );
        }
        let many: Vec<String> = (0..1001).map(|n| n.to_string()).collect();
        let many = many.join(",");
        let fault = read(&format!(
            "command = 'train'\nseeds = [{many}]\n[keys]\na = [{many}]"
        ));
        assert!(fault.unwrap_err().to_string().contains("1002001 cells"));
    }
}
