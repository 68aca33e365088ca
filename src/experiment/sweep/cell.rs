//! A cell: one combination with one seed, and its name, which is a digest of all that decides its result.

use super::{command::Command, key};
use crate::{
    error::{Error, Result},
    storage,
};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// Digits of a cell's name: 64 bits.
const DIGITS: usize = 16;

/// One combination of values with one seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    /// Its name. The first key of its line in `cells.jsonl`, so that a line is found by its beginning.
    #[serde(rename = "cell")]
    pub name: String,
    /// Its place in the order of the sweep file, from 0.
    pub number: usize,
    /// What it has that others have otherwise: keys and options with their values, files by [what they are called](super::Input::name).
    pub keys: Map<String, Value>,
    /// Its seed, where the sweep names some.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub seed: Option<u64>,
    /// Numbers of the inputs that it reads.
    pub data: Vec<usize>,
}

/// What all cells of a sweep start from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Base {
    /// What every cell runs.
    pub command: Command,
    /// Keys of the configuration.
    pub config: toml::Table,
    /// What the command line has besides.
    pub options: Map<String, Value>,
}

/// A call of the command: a configuration's text, and options.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Call {
    pub text: String,
    pub options: Map<String, Value>,
}

impl Base {
    /// The call that some keys make, over what all share.
    ///
    /// # Errors
    /// A usage error where a key leads nowhere, or an option is none of the command's or of another kind.
    pub(super) fn call<'a>(
        &self,
        keys: impl IntoIterator<Item = (&'a str, &'a Value)>,
    ) -> Result<Call> {
        let (mut config, mut options) = (self.config.clone(), self.options.clone());
        for (name, value) in keys {
            let is_option = self.command.option(name).is_some();
            if is_option || !self.command.is_configured() {
                self.command.check_option(name, value)?;
                options.insert(name.to_string(), value.clone());
                continue;
            }
            let value: toml::Value = serde_json::from_value(value.clone())
                .map_err(|e| Error::usage(format!("{name}: {e}")))?;
            key::set(&mut config, name, value).map_err(Error::usage)?;
        }
        for (name, value) in &options {
            self.command.check_option(name, value)?;
        }
        let text = toml::to_string(&config)
            .map_err(|e| Error::work(format!("configuration as TOML: {e}")))?;
        Ok(Call { text, options })
    }
}

/// The name of a cell: 16 digits of the SHA-256 of version, command, options and the configuration as the command reads it. Names of
/// files in these hold digests of what is in the files.
pub(super) fn name(command: Command, resolved: &Value, call: &Call) -> String {
    let all = serde_json::json!({
        "version": VERSION,
        "command": command,
        "options": call.options,
        "config": resolved,
    });
    let mut text = String::new();
    canonical(&all, &mut text);
    storage::sha256(text.as_bytes())[..DIGITS].to_string()
}

/// Version of the program that a result is of.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Is that the name of a cell?
pub(super) fn is_name(word: &str) -> bool {
    word.len() == DIGITS
        && word
            .bytes()
            .all(|b| b.is_ascii_digit() || (b'a'..=b'f').contains(&b))
}

/// JSON with the keys of every object in the order of their letters, whatever order they are kept in.
pub(super) fn canonical(value: &Value, text: &mut String) {
    match value {
        Value::Object(keys) => {
            let mut keys: Vec<(&String, &Value)> = keys.iter().collect();
            keys.sort_by_key(|(key, _)| *key);
            text.push('{');
            for (number, (key, value)) in keys.into_iter().enumerate() {
                if number > 0 {
                    text.push(',');
                }
                text.push_str(&Value::String(key.clone()).to_string());
                text.push(':');
                canonical(value, text);
            }
            text.push('}');
        }
        Value::Array(values) => {
            text.push('[');
            for (number, value) in values.iter().enumerate() {
                if number > 0 {
                    text.push(',');
                }
                canonical(value, text);
            }
            text.push(']');
        }
        other => text.push_str(&other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(config: &str, options: Value) -> String {
        let call = Call {
            text: config.into(),
            options: options.as_object().unwrap().clone(),
        };
        let resolved = Command::Train.resolved(config).unwrap();
        name(Command::Train, &resolved, &call)
    }

    #[test]
    fn a_name_is_of_what_decides_the_result_and_of_nothing_else() {
        let data = serde_json::json!({ "data": "data/0123456789abcdef/a.npz" });
        let first = named("[train]\nfeatures = 2", data.clone());
        assert!(is_name(&first) && !is_name("results") && !is_name("0123456789ABCDEF"));
        assert_eq!(
            first,
            named(
                "[train]\nfeatures = 2\n[localise]\ntrials = 3",
                data.clone()
            )
        );
        let stated = crate::learning::Recipe::default().descent.steps;
        let stated = format!("[train]\nfeatures = 2\ndescent = {{ steps = {stated} }}");
        assert_eq!(first, named(&stated, data.clone()));
        assert_ne!(first, named("[train]\nfeatures = 3", data));
        let data = serde_json::json!({ "data": "data/0123456789abcdee/a.npz" });
        assert_ne!(first, named("[train]\nfeatures = 2", data));
    }

    #[test]
    fn the_order_of_keys_does_not_matter() {
        let mut text = String::new();
        let value = serde_json::json!({ "b": [1, { "z\"": 0.1, "a": null }], "a": {} });
        canonical(&value, &mut text);
        assert_eq!(text, r#"{"a":{},"b":[1,{"a":null,"z\"":0.1}]}"#);
    }
}
