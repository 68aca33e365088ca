//! Constants of systems that can learn, anybody's own among them; and lists of the built-in members that share a trait:
//! one line each, and configurations, names and files follow.

use crate::error::{Error, Result};
use serde::Serialize;
use serde_json::{Map, Value};
use std::{fmt::Debug, path::PathBuf};

/// The constants of one kind of system: what a configuration may set before anything is learned.
///
/// Each room has a trait of its own above this one that says what these constants make: [`RecogniserConfig`],
/// [`LocaliserConfig`], [`DetectorConfig`]. The built-in kinds implement them, and so may any type of another crate that is
/// `Debug`, `Clone` and serde's `Serialize` (its constants are kept in records as JSON): such a kind takes part in
/// comparisons as a built-in one does.
///
/// [`RecogniserConfig`]: crate::recogniser::RecogniserConfig
/// [`LocaliserConfig`]: crate::localiser::LocaliserConfig
/// [`DetectorConfig`]: crate::detector::DetectorConfig
pub trait Constants: Debug + Send + Sync {
    /// The name of the kind, in configurations and records.
    fn kind(&self) -> &str;

    /// What it is, in a sentence, for records.
    fn description(&self) -> &str {
        ""
    }

    /// # Errors
    /// A usage error where a constant makes no sense; the message names its key.
    fn check(&self) -> Result<()> {
        Ok(())
    }

    /// Where the constants name the file of a model that `ballmark train` makes: that name. It may be empty; a comparison
    /// then trains a model on each dataset's mapping part and sets the name.
    fn model(&mut self) -> Option<&mut PathBuf> {
        None
    }

    /// Where the constants name the file of a world whose plan they are given: that name. It may be empty; a comparison then sets the
    /// name of the world that a dataset is simulated in.
    fn world(&mut self) -> Option<&mut PathBuf> {
        None
    }

    /// Its number of particles, where it has a number that may be raised: more of them cost time, and should change nothing else.
    fn particles(&mut self) -> Option<&mut usize> {
        None
    }

    /// Names of all files that the constants name; a configuration's file names are relative to itself.
    fn files(&mut self) -> Vec<&mut PathBuf> {
        self.model().into_iter().collect()
    }
}

/// Constants as a JSON object, with the key `kind`.
pub(crate) fn with_kind(kind: &str, constants: &impl Serialize) -> Result<Value> {
    let json = serde_json::to_value(constants)
        .map_err(|e| Error::work(format!("{kind}: constants as JSON: {e}")))?;
    let mut keys = match json {
        Value::Object(keys) => keys,
        Value::Null => Map::new(), // a type without constants
        other => Map::from_iter([("constants".to_string(), other)]),
    };
    keys.insert("kind".into(), kind.into());
    Ok(Value::Object(keys))
}

/// For a trait above [`Constants`]: its boxed values can be cloned and written as JSON, because every member can.
macro_rules! boxed_config {
    ($trait:ident, $boxed:ident) => {
        #[doc = concat!("What [`", stringify!($trait), "`] needs of `Clone` and `Serialize`; whatever has both has this.")]
        pub trait $boxed {
            /// A copy.
            fn clone_box(&self) -> Box<dyn $trait>;

            /// The constants as a JSON object, with the key `kind`.
            ///
            /// # Errors
            /// Where a constant has no JSON, such as a map whose keys are no words.
            fn to_json(&self) -> crate::error::Result<serde_json::Value>;
        }

        impl<C: $trait + Clone + serde::Serialize + 'static> $boxed for C {
            fn clone_box(&self) -> Box<dyn $trait> {
                Box::new(self.clone())
            }

            fn to_json(&self) -> crate::error::Result<serde_json::Value> {
                crate::registry::with_kind(crate::registry::Constants::kind(self), self)
            }
        }

        impl Clone for Box<dyn $trait> {
            fn clone(&self) -> Self {
                (**self).clone_box()
            }
        }
    };
}

pub(crate) use boxed_config;

/// Makes of a list of members the enumerations `Kind` (which), `Config` (its constants) and `Learned` (what it made of a
/// recording), the function `learn`, and reading and writing of files.
///
/// The first line says: the noun for messages, the trait that all members implement, the method that gives it, the name
/// of the file's type and its two keys. Then a member a line: what it is called in code, its file (which is its name),
/// its constants, what it is, and the name that it
/// had in the version before, where it had another one. The room has traits `Learn` with `learn` and `check`, and every type of constants has
/// `check`.
macro_rules! registry {
    (
        $noun:literal, $trait:ident, $as_trait:ident, $file:ident, $version_key:literal, $content_key:literal;
        $($kind:ident, $module:ident, $config:ident, $what:literal $(, formerly $former:literal)?;)*
    ) => {
        #[doc = concat!("All ", $noun, "s there are.")]
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize,
        )]
        #[serde(rename_all = "snake_case")]
        pub enum Kind { $(#[doc = $what] $(#[serde(alias = $former)])? $kind,)* }

        impl Kind {
            /// All of them, in the order of the registry.
            pub const ALL: &[Kind] = &[$(Kind::$kind),*];

            /// The name that configurations, tables and files use.
            pub fn name(self) -> &'static str {
                match self { $(Kind::$kind => stringify!($module),)* }
            }

            /// The name that configurations and files of the version before used, where it was another one.
            pub fn former_name(self) -> Option<&'static str> {
                match self { $(Kind::$kind => [$($former)?].first().copied(),)* }
            }

            /// What it is, in a sentence.
            pub fn what(self) -> &'static str {
                match self { $(Kind::$kind => $what,)* }
            }

            /// Its printed constants.
            pub fn default_config(self) -> Config {
                match self { $(Kind::$kind => Config::$kind(Default::default()),)* }
            }
        }

        impl std::fmt::Display for Kind {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl std::str::FromStr for Kind {
            type Err = crate::error::Error;

            fn from_str(name: &str) -> crate::error::Result<Self> {
                let found = Kind::ALL
                    .iter()
                    .find(|kind| kind.name() == name || kind.former_name() == Some(name));
                found.copied().ok_or_else(|| {
                    let names: Vec<&str> = Kind::ALL.iter().map(|kind| kind.name()).collect();
                    crate::error::Error::usage(format!(
                        concat!("no ", $noun, " `{}`; expected one of {}"),
                        name.escape_debug(),
                        names.join(", ")
                    ))
                })
            }
        }

        #[doc = concat!("The constants of one ", $noun, "; in a file, `kind` says of which. An unknown key is an error.")]
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(tag = "kind", rename_all = "snake_case")]
        pub enum Config { $(#[doc = $what] $(#[serde(alias = $former)])? $kind($module::$config),)* }

        impl Config {
            /// Whose constants these are.
            pub fn kind(&self) -> Kind {
                match self { $(Config::$kind(_) => Kind::$kind,)* }
            }

            /// # Errors
            /// A usage error where a constant makes no sense; the message names its key.
            pub fn check(&self) -> crate::error::Result<()> {
                match self { $(Config::$kind(config) => config.check(),)* }
            }
        }

        #[doc = concat!("A ", $noun, " that has learned, whichever it is: what a file holds.")]
        #[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
        // There is one of these at a time, not thousands side by side.
        #[allow(clippy::large_enum_variant)]
        #[serde(tag = "kind", content = "learned", rename_all = "snake_case")]
        pub enum Learned { $(#[doc = $what] $(#[serde(alias = $former)])? $kind($module::$kind),)* }

        impl Learned {
            /// Whoever it is.
            pub fn $as_trait(&self) -> &dyn $trait {
                match self { $(Learned::$kind(learned) => learned,)* }
            }

            /// The same, alone.
            pub fn boxed(self) -> Box<dyn $trait> {
                match self { $(Learned::$kind(learned) => Box::new(learned),)* }
            }

            /// Checks what may have come from a file.
            pub(crate) fn check(&self) -> crate::error::Result<()> {
                match self { $(Learned::$kind(learned) => learned.check(),)* }
            }

            /// Writes it as JSON, whole or not at all; what is read back gives the same answers to the bit.
            ///
            /// # Errors
            /// Where the file can't be written.
            pub fn write(&self, path: &std::path::Path) -> crate::error::Result<()> {
                let file = $file {
                    version: env!("CARGO_PKG_VERSION").to_string(),
                    content: self,
                };
                crate::storage::write_file(path, |out| Ok(serde_json::to_writer(out, &file)?))
            }

            /// Reads what [`Learned::write`] wrote.
            ///
            /// # Errors
            /// Where the file is none of its kind, or a damaged one.
            pub fn read(path: &std::path::Path) -> crate::error::Result<Self> {
                let bytes = crate::storage::read_file(path)?;
                let file: $file<Self> = serde_json::from_slice(&bytes).map_err(|e| {
                    crate::error::Error::file(
                        path,
                        format!(
                            concat!("{}; expected a ", $noun, " as JSON, whole and of this version"),
                            e
                        ),
                    )
                })?;
                file.content.check().map_err(|e| e.in_file(path))?;
                Ok(file.content)
            }
        }

        #[doc = concat!("The file of a ", $noun, " that has learned.")]
        #[derive(serde::Serialize, serde::Deserialize)]
        #[serde(deny_unknown_fields)]
        struct $file<T> {
            /// Version of this crate that learned it.
            #[serde(rename = $version_key)]
            version: String,
            #[serde(rename = $content_key)]
            content: T,
        }

        #[doc = concat!("The ", $noun, " that these constants ask for learns from some snapshots of a recording: the mapping part, in the order it was driven.")]
        ///
        /// # Errors
        /// A usage error where a constant makes no sense; a work error where the snapshots are none, or not enough to
        /// learn from.
        pub fn learn(
            config: &Config,
            recording: &crate::recording::Recording,
            snapshots: &[usize],
            seed: crate::seed::Seed,
        ) -> crate::error::Result<Learned> {
            config.check()?;
            if snapshots.is_empty() {
                return Err(crate::error::Error::work(format!(
                    "{}: no snapshot to learn from; expected at least one", config.kind()
                )));
            }
            Ok(match config {
                $(Config::$kind(config) => {
                    Learned::$kind($module::$kind::learn(config, recording, snapshots, seed)?)
                })*
            })
        }
    };
}

pub(crate) use registry;

/// Texts of a file that is damaged: cut in half, or without the number that stands first after a bracket, one a bracket.
#[cfg(test)]
pub(crate) fn damaged(whole: &str) -> Vec<String> {
    let mut texts = vec![whole[..whole.len() / 2].to_string()];
    for (at, _) in whole.match_indices('[') {
        let inner = &whole[at + 1..];
        let end = inner.find([',', ']', '[', '{', '"']).unwrap_or(0);
        if inner[end..].starts_with(',') {
            texts.push([&whole[..=at], &inner[end + 1..]].concat());
        }
    }
    texts
}
