//! Several sets of filters in one file, each for a prior uncertainty of its own.
//!
//! Arrays stand as in the file of a single model, those of a set behind `set.{uncertainty}.`: `set.2m.filter.0.0.weight`,
//! `set.2m.input.mean`, `set.2m.map.activation`. The places are those of all sets: `map.pose`, `map.route`, and besides these
//! `map.run` `[K]` f64, the run that each snapshot is of, counted from 0; where all are of one run,
//! the stretch ([`passes`](crate::recording::split::passes)). The JSON is `{"bank": [header, …]}`.

use super::trained_model::Model;
use crate::{
    belief::{Places, held_apart::HeldApart},
    error::{Error, Result},
};
use std::collections::BTreeSet;

/// Sets of filters that learned from the same snapshots, each for a prior uncertainty of its own: what
/// [`sensor_model::Bank`](crate::localiser::sensor_model::Bank) chooses from.
///
/// ```no_run
/// use ballmark::{localiser::{LiveConfig, LiveLocaliser}, model::ModelBank};
/// let bank = ModelBank::read("corridor.safetensors".as_ref())?; // ballmark train … --uncertainty bank
/// for set in bank.sets() {
///     println!("{}: {} features", set.header.prior, set.features());
/// }
/// let robot = LiveLocaliser::with_bank(&bank, &LiveConfig::default())?;
/// # Ok::<(), ballmark::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ModelBank {
    sets: Vec<Model>,
    /// The run of each training place; none of a single model's file.
    run: Vec<usize>,
}

impl ModelBank {
    /// From its sets, and the run that each training place is of.
    ///
    /// # Errors
    /// Where there is no set, two are for the same uncertainty, they learned from different places, or there is not one run a place.
    pub fn new(sets: Vec<Model>, run: Vec<usize>) -> Result<Self> {
        let Some(first) = sets.first() else {
            return Err(Error::usage("bank: no set; expected one or more"));
        };
        let mut priors = BTreeSet::new();
        for set in &sets {
            let prior = set.header.prior;
            if !priors.insert(prior.to_string()) {
                return Err(Error::usage(format!(
                    "bank: two sets for {prior}; expected an uncertainty of its own for each"
                )));
            }
            if set.pose != first.pose || set.route_m != first.route_m {
                return Err(Error::usage(format!(
                    "bank: the sets for {} and {prior} learned from different places",
                    first.header.prior
                )));
            }
        }
        if run.len() != first.pose.len() {
            return Err(Error::usage(format!(
                "bank: {} runs for {} places",
                run.len(),
                first.pose.len()
            )));
        }
        Ok(Self { sets, run })
    }

    /// The sets, in the order in which they were trained.
    pub fn sets(&self) -> &[Model] {
        &self.sets
    }

    /// The run of each training place, counted from 0.
    pub fn run(&self) -> &[usize] {
        &self.run
    }

    /// What a set promises at some cells, held apart by runs.
    ///
    /// # Errors
    /// Where the cells lie along a route and the places in the plane, or the other way round.
    pub fn held_apart(&self, set: &Model, cells: &Places) -> Result<HeldApart> {
        held_apart(set, &self.run, cells)
    }
}

/// What a set promises at some cells, by the runs that its training places are of.
///
/// # Errors
/// As [`ModelBank::held_apart`].
pub fn held_apart(set: &Model, run: &[usize], cells: &Places) -> Result<HeldApart> {
    let activation = set.activation.mapv(f64::from);
    HeldApart::new(
        &set.places(),
        &activation,
        run,
        &set.header.recipe.map,
        cells,
    )
}
