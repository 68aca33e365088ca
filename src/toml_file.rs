//! TOML files: configurations and worlds. Every refusal names the file and, where the text has the key, the line.
//!
//! A text can be wrong in two ways. Its syntax, its keys or the types of their values are wrong: [`TomlFile::parse`] finds
//! that. Or a value makes no sense: the configuration's own check finds that when the text is long gone and names the key
//! (`descent.steps = 0: expected …`, ``[robot]: `speed_m_per_s` is …``), and [`TomlFile::locate`] adds where it stands.

mod location;

use crate::{
    error::{Error, Result},
    storage,
};
use serde::{Serialize, de::DeserializeOwned};
use std::path::{Path, PathBuf};
use toml::Value;

/// The text of a TOML file.
///
/// ```
/// use ballmark::{Error, toml_file::TomlFile};
/// let file = TomlFile::from_text("seed = 7\n[robot]\nspeed = 'fast'");
/// #[derive(Debug, serde::Deserialize)]
/// struct Config { seed: u64, robot: Robot }
/// #[derive(Debug, serde::Deserialize)]
/// struct Robot { speed: f64 }
/// let error = file.parse::<Config>().unwrap_err();
/// assert_eq!(error.to_string(), "line 3: invalid type: string \"fast\", expected f64");
///
/// // Whoever checks values later names the key alone; the file knows its line.
/// let error = file.locate(Error::usage("[robot]: `speed` is -1; expected more than 0"));
/// assert_eq!(error.to_string(), "line 3: [robot]: `speed` is -1; expected more than 0");
/// ```
#[derive(Debug, Clone)]
pub struct TomlFile {
    /// None where the text came from elsewhere: messages then begin with the line.
    path: Option<PathBuf>,
    text: String,
}

impl TomlFile {
    /// Reads the text of a file.
    ///
    /// # Errors
    /// Where it can't be read, or is not UTF-8.
    pub fn read(path: &Path) -> Result<Self> {
        let text = String::from_utf8(storage::read_file(path)?).map_err(|_| {
            Error::usage(format!("{}: not UTF-8 text; expected TOML", path.display()))
        })?;
        Ok(Self {
            path: Some(path.to_path_buf()),
            text,
        })
    }

    /// A text that comes from no file.
    pub fn from_text(text: impl Into<String>) -> Self {
        Self {
            path: None,
            text: text.into(),
        }
    }

    /// The text as a configuration.
    ///
    /// # Errors
    /// A usage error with file and line where the text is no TOML, or a key is unknown, missing or of the wrong type.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T> {
        toml::from_str(&self.text).map_err(|e| {
            let line = self.line_at(e.span().map_or(0, |span| span.start));
            self.refusal(line, e.message().replace('\n', " "))
        })
    }

    /// The line, counted from 1, on which the byte at this offset stands.
    pub fn line_at(&self, offset: usize) -> usize {
        let before = self.text.bytes().take(offset);
        1 + before.filter(|byte| *byte == b'\n').count()
    }

    /// A usage error about a line of this file.
    pub fn refusal(&self, line: usize, fault: impl std::fmt::Display) -> Error {
        self.named(Error::usage(format!("line {line}: {fault}")))
    }

    /// The same error, with this file's name and, where it is a usage error that names a key or a table of the text, with
    /// the line of that. A key is named as ``[table]: `key` …``, ``[[table]] 2: `key` …``, ``table: `key` …`` or
    /// `table.key = …`; a key that stands nowhere in the text is at its default, and its table is named instead.
    pub fn locate(&self, fault: Error) -> Error {
        if !fault.is_usage() {
            return self.named(fault);
        }
        match location::offset(&self.text, &fault.to_string()) {
            Some(offset) => self.named(fault.context(format!("line {}", self.line_at(offset)))),
            None => self.named(fault),
        }
    }

    fn named(&self, fault: Error) -> Error {
        match &self.path {
            Some(path) => fault.in_file(path),
            None => fault,
        }
    }
}

/// Puts the keys of `over` over those of `under`, table by table; all other values are replaced as a whole.
///
/// ```
/// use toml::{Value, toml};
/// let mut keys = Value::Table(toml! { steps = 5 map = { k = 3, reach_m = 1.0 } });
/// ballmark::toml_file::put_over(&mut keys, &Value::Table(toml! { map = { k = 7 } }));
/// assert_eq!(keys, Value::Table(toml! { steps = 5 map = { k = 7, reach_m = 1.0 } }));
/// ```
pub fn put_over(under: &mut Value, over: &Value) {
    match (under, over) {
        (Value::Table(under), Value::Table(over)) => {
            for (key, value) in over {
                match under.get_mut(key) {
                    Some(place) => put_over(place, value),
                    None => {
                        under.insert(key.clone(), value.clone());
                    }
                }
            }
        }
        (under, over) => *under = over.clone(),
    }
}

/// Gives keys of a table, as far as they still have the name of the version before, their name of now: `former` is a list of
/// former and present names. A key that stands there under both keeps the value of the present one.
///
/// ```
/// use toml::toml;
/// let mut descent = toml! { queries = 9 };
/// ballmark::toml_file::rename_keys(&mut descent, &[("queries", "truths_per_step")]);
/// assert_eq!(descent, toml! { truths_per_step = 9 });
/// ```
pub fn rename_keys(table: &mut toml::Table, former: &[(&str, &str)]) {
    for (former, present) in former {
        if let Some(value) = table.remove(*former) {
            table.entry(*present).or_insert(value);
        }
    }
}

/// A usage error about a key of a section whose value makes no sense, such as `localise.trials = 0: expected 1 or more`: names the key
/// and, where that is a number, the value.
pub(crate) fn out_of_range(
    section: &str,
    config: &impl Serialize,
    key: &str,
    expected: &str,
) -> Error {
    let table = toml::Table::try_from(config).unwrap_or_default();
    let value = match table.get(key) {
        Some(Value::Integer(value)) => format!(" = {value}"),
        Some(Value::Float(value)) => format!(" = {value}"),
        _ => String::new(), // not at hand, or of any length
    };
    Error::usage(format!("{section}.{key}{value}: expected {expected}"))
}
