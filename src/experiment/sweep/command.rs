//! Which command a sweep repeats, what its flags are called in a sweep file, and what a configuration means to it.

use crate::{
    error::{Error, Result},
    experiment::{compare::CompareConfig, configuration::Experiment, reproduce::Paper},
};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// A command that a sweep repeats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Command {
    /// `ballmark train`.
    Train,
    /// `ballmark localise`.
    Localise,
    /// `ballmark compare`.
    Compare,
    /// `ballmark reproduce`.
    Reproduce,
}

/// What an option of a command may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OptionKind {
    /// A file's name, or several that count as one value.
    Files,
    /// A file's name, or the word `none`.
    FileOrNone,
    /// `true` or `false`.
    Switch,
    /// A word.
    Word,
}

use OptionKind::{FileOrNone, Files, Switch, Word};

/// Where a cell's model goes, in its scratch folder.
const MODEL: &str = "model.safetensors";
/// A cell's configuration there.
pub(super) const CONFIGURATION: &str = "config.toml";

impl Command {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Command::Train => "train",
            Command::Localise => "localise",
            Command::Compare => "compare",
            Command::Reproduce => "reproduce",
        }
    }

    /// What the command line has besides configuration and seed, by the names that a sweep file gives it.
    pub(super) fn options(self) -> &'static [(&'static str, OptionKind)] {
        match self {
            Command::Train => &[
                ("data", Files),
                ("from", FileOrNone),
                ("map", Files),
                ("bank", Switch),
                ("device", Word),
            ],
            Command::Localise => &[
                ("data", Files),
                ("model", Files),
                ("trained_on", Files),
                ("map", Files),
            ],
            Command::Compare => &[("toy", Switch)],
            Command::Reproduce => &[("paper", Word), ("toy", Switch)],
        }
    }

    /// The kind of an option of this name, where there is one.
    pub(super) fn option(self, name: &str) -> Option<OptionKind> {
        let mut options = self.options().iter();
        options.find(|(known, _)| *known == name).map(|o| o.1)
    }

    /// The option that the command can't do without.
    pub(super) fn needed(self) -> &'static [&'static str] {
        match self {
            Command::Train => &["data"],
            Command::Localise => &["data", "model"],
            Command::Compare => &[],
            Command::Reproduce => &["paper"],
        }
    }

    /// Does it read a configuration?
    pub(super) fn is_configured(self) -> bool {
        self != Command::Reproduce
    }

    /// What a configuration says to this command, to the last default: read and checked as the command does.
    ///
    /// # Errors
    /// As the command's own reader, without a file's name.
    pub(super) fn resolved(self, text: &str) -> Result<Value> {
        let value = match self {
            Command::Train => {
                let experiment = Experiment::parse(text)?;
                let (train, degraded) = (&experiment.train, &experiment.degraded);
                serde_json::to_value((train, degraded))
            }
            Command::Localise => {
                let experiment = Experiment::parse(text)?;
                let (mut localise, degraded) = (experiment.localise, &experiment.degraded);
                localise.seed = Some(localise.seed().0);
                serde_json::to_value((localise, degraded))
            }
            Command::Compare => serde_json::to_value(CompareConfig::parse(text)?),
            Command::Reproduce => Ok(serde_json::json!({})),
        };
        value.map_err(|e| Error::work(format!("configuration: {e}")))
    }

    /// Puts a seed in place of a resolved configuration's own, as the flag `--seed` does.
    pub(super) fn put_seed(self, resolved: &mut Value, seed: u64) {
        match self {
            Command::Train | Command::Localise => resolved[0]["seed"] = seed.into(),
            Command::Compare | Command::Reproduce => resolved["seed"] = seed.into(),
        }
    }

    /// Are the options of a cell of the right kinds, and is none missing?
    ///
    /// # Errors
    /// A usage error that names the option.
    pub(super) fn check_option(self, name: &str, value: &Value) -> Result<()> {
        let expected = match self.option(name) {
            None => {
                let names = self.options().iter().map(|(name, _)| *name);
                let names: Vec<&str> = names.collect();
                return Err(Error::usage(format!(
                    "`{}`: no option of `{}`; expected one of {}",
                    name.escape_debug(),
                    self.name(),
                    names.join(", ")
                )));
            }
            Some(Switch) if value.is_boolean() => return Ok(()),
            Some(Switch) => "true or false",
            Some(Word) if value.is_string() => {
                if name == "paper" {
                    value.as_str().unwrap_or_default().parse::<Paper>()?;
                }
                return Ok(());
            }
            Some(Word) => "a word in quotes",
            Some(FileOrNone) if value.is_string() => return Ok(()),
            Some(FileOrNone) => "a file's name in quotes, or \"none\"",
            Some(Files) => {
                let names = value.as_array();
                let all = names
                    .is_some_and(|names| !names.is_empty() && names.iter().all(Value::is_string));
                if value.is_string() || all {
                    return Ok(());
                }
                "a file's name in quotes, or a list of such names that count as one"
            }
        };
        let fault = format!("`{name}` is {value}; expected {expected}");
        Err(Error::usage(fault))
    }

    /// The arguments of a call that makes a cell, in its scratch folder.
    pub(super) fn arguments(self, options: &Map<String, Value>, seed: Option<u64>) -> Vec<String> {
        let words = |name: &str| -> Vec<String> {
            match options.get(name) {
                Some(Value::String(word)) => vec![word.clone()],
                Some(Value::Array(words)) => {
                    let words = words.iter().filter_map(Value::as_str);
                    words.map(String::from).collect()
                }
                _ => Vec::new(),
            }
        };
        let is_set = |name: &str| options.get(name) == Some(&Value::Bool(true));
        let mut all = vec![self.name().to_string()];
        match self {
            Command::Train => {
                all.extend(words("data"));
                all.extend(["--output", MODEL, "--config", CONFIGURATION].map(String::from));
            }
            Command::Localise => {
                all.extend(words("model"));
                all.extend(words("data"));
                all.extend(["--config", CONFIGURATION].map(String::from));
            }
            Command::Compare => all.push(CONFIGURATION.into()),
            Command::Reproduce => all.extend(words("paper")),
        }
        all.extend(["--json", "--quiet"].map(String::from));
        if let Some(seed) = seed {
            all.extend(["--seed".to_string(), seed.to_string()]);
        }
        for flag in ["from", "map", "device"] {
            for word in words(flag) {
                all.extend([format!("--{flag}"), word]);
            }
        }
        if is_set("bank") {
            all.extend(["--uncertainty", "bank"].map(String::from));
        }
        if is_set("toy") {
            all.push("--toy".into());
        }
        let trained_on = words("trained_on");
        if !trained_on.is_empty() {
            all.push("--trained-on".into());
            all.extend(trained_on);
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_command_does_not_read_is_not_in_its_configuration() {
        let of = |command: Command, text: &str| command.resolved(text).unwrap();
        let mut train = of(
            Command::Train,
            "[train]\nfeatures = 3\n[localise]\ntrials = 7",
        );
        assert_eq!(train[0]["features"], 3);
        assert_eq!(train, of(Command::Train, "[train]\nfeatures = 3"));
        Command::Train.put_seed(&mut train, 4);
        assert_eq!(train, of(Command::Train, "[train]\nfeatures = 3\nseed = 4"));
        let mut localise = of(Command::Localise, "[localise]\ntrials = 7");
        Command::Localise.put_seed(&mut localise, 9);
        assert_eq!(
            localise,
            of(Command::Localise, "[localise]\ntrials = 7\nseed = 9")
        );
        let fault = Command::Train.resolved("[train]\nfeaturs = 3").unwrap_err();
        assert!(fault.is_usage());
    }

    #[test]
    fn options_of_another_kind_are_refused() {
        for (command, name, value, part) in [
            (
                Command::Train,
                "toy",
                serde_json::json!(true),
                "no option of `train`",
            ),
            (
                Command::Train,
                "data",
                serde_json::json!(3),
                "a file's name",
            ),
            (
                Command::Train,
                "data",
                serde_json::json!([]),
                "a file's name",
            ),
            (
                Command::Compare,
                "toy",
                serde_json::json!("yes"),
                "true or false",
            ),
            (
                Command::Reproduce,
                "paper",
                serde_json::json!("thrun1997"),
                "no paper `thrun1997`",
            ),
        ] {
            let fault = command.check_option(name, &value).unwrap_err();
            assert!(
                fault.is_usage() && fault.to_string().contains(part),
                "{fault}"
            );
        }
        Command::Train
            .check_option("data", &serde_json::json!(["a", "b"]))
            .unwrap();
    }

    #[test]
    fn flags_are_those_of_the_command_line() {
        let options =
            serde_json::json!({ "data": ["a.npz", "b.npz"], "from": "none", "bank": true });
        let arguments = Command::Train.arguments(options.as_object().unwrap(), Some(2));
        assert_eq!(
            arguments.join(" "),
            "train a.npz b.npz --output model.safetensors --config config.toml --json --quiet --seed 2 --from none --uncertainty bank"
        );
        let options =
            serde_json::json!({ "data": "a.npz", "model": "m.npz", "trained_on": "t.npz" });
        let arguments = Command::Localise.arguments(options.as_object().unwrap(), None);
        assert_eq!(
            arguments.join(" "),
            "localise m.npz a.npz --config config.toml --json --quiet --trained-on t.npz"
        );
    }
}
