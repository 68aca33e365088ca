//! Several comparisons in one table, where they were measured on the same.

use super::record::{Comparison, ComparisonRecord, LocalisationSection, Outcome, Section};
use crate::{
    error::{Error, Result},
    experiment::localisation,
};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

impl Comparison {
    /// The systems of both, side by side. Differences between systems were tested within each alone, so those tests stay with the first's.
    ///
    /// # Errors
    /// Where they have other datasets or sections, a section was asked otherwise, or records were measured on other protocols
    /// ([`ProtocolRecord`](crate::experiment::protocol_record::ProtocolRecord)): the message names the field that differs. `mixed` lets
    /// all of that pass but other datasets and sections.
    pub fn joined(mut self, other: Comparison, mixed: bool) -> Result<Comparison> {
        let (ours, theirs) = (&mut self.record, other.record);
        let wrong = |fault: String| Error::work(fault);
        let datasets = |record: &ComparisonRecord| -> Vec<String> {
            record
                .datasets
                .iter()
                .map(|dataset| dataset.name.clone())
                .collect()
        };
        if datasets(ours) != datasets(&theirs) {
            return Err(wrong(format!(
                "datasets {}; expected {}",
                datasets(&theirs).join(", "),
                datasets(ours).join(", ")
            )));
        }
        if !mixed {
            for (own, their) in ours.datasets.iter().zip(&theirs.datasets) {
                if let Some(field) = own.protocol.difference(&their.protocol) {
                    return Err(differs(
                        &own.name,
                        field,
                        &own.protocol.hash,
                        &their.protocol.hash,
                    ));
                }
            }
        }
        let before = ours.systems.len();
        let mut names = BTreeMap::new();
        for mut system in theirs.systems {
            let own = system.name.clone();
            let is_taken = |name: &str| ours.systems.iter().any(|system| system.name == name);
            let numbered = (2..).map(|number| format!("{own} ({number})"));
            let mut free = std::iter::once(own.clone()).chain(numbered);
            system.name = free.find(|name| !is_taken(name)).unwrap_or_default(); // one of them is free
            names.insert(own, system.name.clone());
            ours.systems.push(system);
        }
        sections(
            &mut ours.standard,
            theirs.standard,
            "standard",
            before,
            mixed,
        )?;
        sections(
            &mut ours.recognition,
            theirs.recognition,
            "recognition",
            before,
            mixed,
        )?;
        sections(
            &mut ours.error_reduction,
            theirs.error_reduction,
            "error_reduction",
            before,
            mixed,
        )?;
        sections(
            &mut ours.landmarks,
            theirs.landmarks,
            "landmarks",
            before,
            mixed,
        )?;
        match (&mut ours.localisation, theirs.localisation) {
            (None, None) => {}
            (Some(own), Some(their)) => {
                let datasets: Vec<&str> = ours.datasets.iter().map(|d| d.name.as_str()).collect();
                localisations(own, their, &datasets, &names, mixed)?;
            }
            _ => return Err(only_one("localisation")),
        }
        self.timing.seconds += other.timing.seconds;
        for (own, their) in self
            .timing
            .localisation
            .iter_mut()
            .zip(other.timing.localisation)
        {
            own.join(their, &names);
        }
        self.timing
            .seconds_per_match
            .extend(other.timing.seconds_per_match);
        Ok(self)
    }
}

fn only_one(section: &str) -> Error {
    Error::work(format!(
        "[{section}] stands in one record alone; expected the same sections in both"
    ))
}

fn differs(dataset: &str, field: &str, own: &str, their: &str) -> Error {
    Error::work(format!(
        "{dataset}: measured on another protocol: `{field}` differs (protocol {their}; expected {own}); --mixed puts them side by \
         side all the same"
    ))
}

fn no_trials(dataset: &str, why: &str) -> Error {
    Error::work(format!("{dataset}: one record has no trials: {why}"))
}

/// The first key that two configurations have otherwise.
fn other_key(own: &impl Serialize, their: &impl Serialize) -> Option<String> {
    let json = |value: Value| match value {
        Value::Object(keys) => keys,
        _ => serde_json::Map::new(),
    };
    let (own, their) = (
        json(serde_json::to_value(own).ok()?),
        json(serde_json::to_value(their).ok()?),
    );
    let mut keys = own.keys().chain(their.keys());
    keys.find(|key| own.get(*key) != their.get(*key)).cloned()
}

fn sections<C: Serialize, T>(
    own: &mut Option<Section<C, T>>,
    their: Option<Section<C, T>>,
    name: &str,
    before: usize,
    mixed: bool,
) -> Result<()> {
    match (own, their) {
        (None, None) => Ok(()),
        (Some(own), Some(their)) => {
            if let Some(key) = other_key(&own.config, &their.config).filter(|_| !mixed) {
                return Err(Error::work(format!(
                    "[{name}] was asked otherwise: `{key}` differs; --mixed puts them side by side all the same"
                )));
            }
            own.systems
                .extend(their.systems.iter().map(|number| number + before));
            own.cells.extend(their.cells);
            Ok(())
        }
        _ => Err(only_one(name)),
    }
}

/// Who failed on a dataset is named in its place.
fn localisations(
    own: &mut LocalisationSection,
    their: LocalisationSection,
    datasets: &[&str],
    names: &BTreeMap<String, String>,
    mixed: bool,
) -> Result<()> {
    let config = &own.config;
    for ((own, their), dataset) in own.records.iter_mut().zip(their.records).zip(datasets) {
        match (&mut *own, their) {
            (Outcome::Done(own), Outcome::Done(their)) => {
                let unknown = own.protocol.fields.is_empty() || their.protocol.fields.is_empty();
                if unknown && !mixed {
                    return Err(Error::work(format!(
                        "{dataset}: a record without a protocol, of an earlier version; expected records of this one, or --mixed"
                    )));
                }
                let difference = own.protocol.difference(&their.protocol);
                if let Some(field) = difference.filter(|_| !mixed) {
                    return Err(differs(
                        dataset,
                        field,
                        &own.protocol.hash,
                        &their.protocol.hash,
                    ));
                }
                let are_same_trials = !unknown && difference.is_none();
                add(own, their, names);
                own.paired_tests.clear();
                if are_same_trials {
                    own.compare_methods(config.resamples, config.seed());
                }
            }
            (Outcome::NotAsked, Outcome::NotAsked) => {}
            (Outcome::Failed { why }, _) => return Err(no_trials(dataset, why)),
            (_, Outcome::Failed { why }) => return Err(no_trials(dataset, &why)),
            _ => return Err(no_trials(dataset, "nobody was asked")),
        }
    }
    Ok(())
}

fn add(
    own: &mut localisation::Record,
    their: localisation::Record,
    names: &BTreeMap<String, String>,
) {
    let called = |name: &mut String, title: &mut String| {
        if let Some(new) = names.get(name) {
            if title == name {
                title.clone_from(new);
            }
            name.clone_from(new);
        }
    };
    // Kept beliefs are of the systems of one record; its own page plays them.
    own.beliefs = None;
    for mut result in their.results {
        called(&mut result.name, &mut result.title);
        own.results.push(result);
    }
    for mut check in their.more_particles {
        for name in [&mut check.test.name, &mut check.test.against] {
            if let Some(new) = names.get(name) {
                name.clone_from(new);
            }
        }
        own.more_particles.push(check);
    }
    for mut absent in their.left_out {
        called(&mut absent.name, &mut absent.title);
        own.left_out.push(absent);
    }
}
