//! Several sets of filters in one file, each for a prior uncertainty of its own.
//!
//! Arrays stand as in the file of a single model, those of a set behind `set.{uncertainty}.`: `set.2m.filter.0.0.weight`,
//! `set.2m.input.mean`, `set.2m.map.activation`. The places are those of all sets: `map.pose`, `map.route`, and besides these
//! `map.run` `[K]` f64, the run that each snapshot is of, counted from 0; where all are of one run,
//! the stretch ([`passes`](crate::recording::split::passes)). The JSON is `{"bank": [header, …]}`.

use super::{
    arrays::{Arrays, Values},
    file::{contents, put_down},
    layout,
    trained_model::Model,
};
use crate::{
    belief::{Places, Uncertainty, held_apart::HeldApart},
    error::{Error, Result},
    storage,
};
use ndarray::{Array1, Ix1};
use serde_json::{Value, json};
use std::{collections::BTreeSet, path::Path};

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

/// The JSON's key.
pub(super) const BANK: &str = "bank";

/// Array of the runs.
pub(super) const RUN: &str = "map.run";

/// Is an array one of all sets?
fn is_shared(name: &str) -> bool {
    ["map.pose", "map.route"].contains(&name)
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

    /// Reads a bank; the file of a single model is a bank of one set.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(path, &storage::read_file(path)?)
    }

    /// Reads a bank from the bytes of its file; `path` is for messages only.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_bytes(path: &Path, bytes: &[u8]) -> Result<Self> {
        let (meta, arrays) = contents(path, bytes)?;
        let in_header = |fault: String| Error::input(path, "header", fault);
        let value: Value = serde_json::from_str(&meta)
            .map_err(|e| in_header(format!("{e}; expected the JSON of a model")))?;
        let Some(headers) = value.get(BANK) else {
            let model = layout::model(path, &meta, &arrays)?;
            let run = vec![0; model.pose.len()];
            return Self::new(vec![model], run);
        };
        let headers = headers.as_array().filter(|headers| !headers.is_empty());
        let headers = headers
            .ok_or_else(|| in_header(format!("`{BANK}`: expected the headers of its sets")))?;
        let mut sets = Vec::new();
        let mut ours = BTreeSet::new();
        for header in headers {
            let prior = header.get("prior").and_then(Value::as_str);
            let prior = prior.and_then(|text| text.parse::<Uncertainty>().ok());
            let prior = prior.ok_or_else(|| {
                in_header(format!(
                    "`{BANK}`: a set without `prior`; expected an uncertainty such as `2m`"
                ))
            })?;
            let prefix = prefix(prior);
            let mut of_set = Arrays::new(path);
            for (name, values) in arrays.all() {
                match name.strip_prefix(&prefix) {
                    Some(own) => of_set.put(own, values.clone()),
                    None if is_shared(name) => of_set.put(name, values.clone()),
                    None => continue,
                }
                ours.insert(name.clone());
            }
            let set = layout::model(path, &header.to_string(), &of_set);
            sets.push(set.map_err(|e| e.followed_by(format!("in the bank's set for {prior}")))?);
        }
        if let Some((name, _)) = arrays
            .all()
            .find(|(name, _)| *name != RUN && !ours.contains(*name))
        {
            return Err(arrays.wrong(
                name,
                "of no set of this bank; expected the sets of its header",
            ));
        }
        let run = arrays.f64::<Ix1>(RUN)?;
        let number = |&run: &f64| match run.fract() == 0.0 && (0.0..=1e9).contains(&run) {
            true => Ok(run as usize),
            false => Err(arrays.wrong(RUN, format!("holds {run}; expected whole numbers from 0"))),
        };
        let run = run.iter().map(number).collect::<Result<Vec<_>>>()?;
        Self::new(sets, run).map_err(|e| in_header(e.to_string()))
    }

    /// Writes the bank, whole or not at all; the container follows from the file name's ending. A single set is written as a model.
    ///
    /// # Errors
    /// As [`Model::write`].
    pub fn write(&self, path: &Path) -> Result<()> {
        if let [only] = &self.sets[..] {
            return only.write(path);
        }
        let mut headers = Vec::new();
        let mut arrays = Arrays::new(path);
        for set in &self.sets {
            let header: Value = serde_json::from_str(&set.meta()?)
                .map_err(|e| Error::work(format!("model header: {e}")))?;
            headers.push(header);
            let prefix = prefix(set.header.prior);
            for (name, values) in layout::arrays(set, path).into_all() {
                match is_shared(&name) {
                    true => arrays.put(&name, values),
                    false => arrays.put(&format!("{prefix}{name}"), values),
                }
            }
        }
        let run = self.run.iter().map(|&run| run as f64);
        arrays.put(RUN, Values::F64(Array1::from_iter(run).into_dyn()));
        put_down(path, &json!({ BANK: headers }).to_string(), &arrays)
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

/// How the names of a set's arrays begin.
pub(super) fn prefix(prior: Uncertainty) -> String {
    format!("set.{prior}.")
}
