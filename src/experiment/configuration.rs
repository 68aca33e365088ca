//! The configuration file of training, localising and adapting: one section for each, and one for the sensor that both are given.

use super::{adaptation::AdaptConfig, lifelong::LifelongConfig, localisation::LocaliseConfig};
use crate::{
    error::{Error, Result},
    learning::{
        Recipe,
        pretraining::PretrainingConfig,
        recipe::{FORMER_KEYS, NamedRecipe},
    },
    recording::degraded::Degraded,
    toml_file::{TomlFile, put_over, rename_keys},
};
use serde::Deserialize;
use std::path::Path;
use toml::{Table, Value};

/// An experiment: what is trained how, and how it is localised with. Every key has a default; an unknown one is an error.
///
/// ```
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = folder.path().join("walk.toml");
/// use ballmark::experiment::configuration::Experiment;
/// std::fs::write(&path, "[train]\nfeatures = 8\n[localise]\ntrials = 20\n").unwrap();
/// let experiment = Experiment::read(Some(&path), None)?;
/// assert_eq!((experiment.train.features, experiment.localise.trials), (8, 20));
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Experiment {
    /// What holds for `train` where this is silent.
    pub recipe: NamedRecipe,
    /// For `train`.
    pub train: Recipe,
    /// For `localise`; its `people` are also those of `[degraded]`.
    pub localise: LocaliseConfig,
    /// For `adapt`, and for `lifelong`.
    pub adapt: AdaptConfig,
    /// For `lifelong`, besides `[train]` and `[adapt]`.
    pub lifelong: LifelongConfig,
    /// For whatever reads a dataset: the sensor that it is seen by.
    pub degraded: Degraded,
    /// For `pretrain`, besides `[train]`.
    pub pretrain: PretrainingConfig,
}

impl Experiment {
    /// Reads a configuration; without a file it is the default one. A `recipe` given here overrides the file's own.
    ///
    /// # Errors
    /// Where the file is no TOML, a key is unknown or of the wrong type, or a value makes no sense: the call is wrong. The
    /// message names the file and, where the key stands in it, the line.
    pub fn read(path: Option<&Path>, recipe: Option<NamedRecipe>) -> Result<Self> {
        let Some(path) = path else {
            return Ok(Self {
                train: recipe.unwrap_or_default().recipe(),
                ..Self::default()
            });
        };
        let mut experiment = Self::from_file(&TomlFile::read(path)?, recipe)?;
        experiment.localise = experiment.localise.beside(&path.with_file_name(""));
        Ok(experiment)
    }

    /// The same from a text; files that it names stay as they are.
    ///
    /// # Errors
    /// As [`Experiment::read`], without a file's name.
    pub fn parse(text: &str) -> Result<Self> {
        Self::from_file(&TomlFile::from_text(text), None)
    }

    fn from_file(file: &TomlFile, recipe: Option<NamedRecipe>) -> Result<Self> {
        let mut experiment: Self = file.parse()?;
        let named = recipe.unwrap_or(experiment.recipe);
        // The text is sound: what it says of training is now put over what the named recipe says.
        let mut keys = Value::try_from(named.recipe())
            .map_err(|e| Error::work(format!("recipe as TOML: {e}")))?;
        let mut table: Table = file.parse()?;
        if let Some(train) = table.get_mut("train") {
            if let Some(Value::Table(descent)) = train.get_mut("descent") {
                rename_keys(descent, &FORMER_KEYS);
            }
            put_over(&mut keys, train);
        }
        let recipe: std::result::Result<Recipe, toml::de::Error> = keys.try_into();
        experiment.train =
            recipe.map_err(|e| file.locate(Error::usage(format!("[train]: {}", e.message()))))?;
        let in_train = |fault: Error| file.locate(fault.context("[train]"));
        experiment.train.check().map_err(in_train)?;
        let in_file = |fault: Error| file.locate(fault);
        experiment.localise.check().map_err(in_file)?;
        experiment.adapt.check().map_err(in_file)?;
        experiment.lifelong.check().map_err(in_file)?;
        experiment.pretrain.check().map_err(in_file)?;
        experiment.degraded.check().map_err(in_file)?;
        let people = experiment.localise.people;
        let people = experiment.degraded.people_or(people, "localise.people");
        experiment.localise.people = people.map_err(in_file)?;
        Ok(experiment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Experiment> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("in.toml");
        std::fs::write(&path, text).unwrap();
        Experiment::read(Some(&path), None)
    }

    #[test]
    fn a_value_out_of_range_is_refused_with_file_and_line() {
        for (text, place) in [
            (
                "\n[train.descent]\nlearning_rate = -1",
                "in.toml: line 3: [train]: descent.learning_rate = -1",
            ),
            (
                "[localise]\nlongest_m = -1",
                "in.toml: line 2: localise.longest_m = -1: expected metres, localise.shortest_m = ",
            ),
            (
                "[localise]\nlongest_gap_m = -1",
                "in.toml: line 2: localise.longest_gap_m = -1: expected 0 or more metres",
            ),
            (
                "[localise]\ntrials = 0",
                "in.toml: line 2: localise.trials = 0: expected 1 to 100000",
            ),
            (
                "[degraded]\nreach_m = 0",
                "in.toml: line 2: degraded.reach_m = 0",
            ),
            (
                "[localise]\npeople = 0.2\n[degraded]\npeople = 0.3",
                "in.toml: line 4: degraded.people = 0.3 and localise.people = 0.2",
            ),
        ] {
            let error = read(text).unwrap_err();
            assert!(
                error.is_usage() && error.to_string().contains(place),
                "{error}"
            );
        }
    }

    #[test]
    fn people_are_the_same_by_either_key() {
        let people = |text: &str| read(text).unwrap().localise.people();
        assert_eq!(people(""), 0.0);
        assert_eq!(people("[localise]\npeople = 0.3"), 0.3);
        assert_eq!(people("[degraded]\npeople = 0.3"), 0.3);
        let both = "[localise]\npeople = 0.3\n[degraded]\npeople = 0.3";
        assert_eq!(people(both), 0.3);
    }

    #[test]
    fn names_of_the_version_before_are_still_read() {
        let former = read("[train.descent]\nqueries = 7\nplaces = 70").unwrap();
        let present =
            read("[train.descent]\ntruths_per_step = 7\ncandidates_per_step = 70").unwrap();
        assert_eq!(former.train.descent.truths_per_step, 7);
        assert_eq!(former, present);
    }
}
