//! Banks as files: read and written whole.

use super::{
    arrays::{Arrays, Values},
    bank::ModelBank,
    bank_names::{BANK, RUN, is_shared, prefix},
    file::{contents, put_down},
    layout,
};
use crate::{
    belief::Uncertainty,
    error::{Error, Result},
    storage,
};
use ndarray::{Array1, Ix1};
use serde_json::{Value, json};
use std::{collections::BTreeSet, path::Path};

impl ModelBank {
    /// Reads a bank; the file of a single model is a bank of one set.
    ///
    /// # Errors
    /// As [`Model::read`](super::Model::read).
    pub fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(path, &storage::read_file(path)?)
    }

    /// Reads a bank from the bytes of its file; `path` is for messages only.
    ///
    /// # Errors
    /// As [`Model::read`](super::Model::read).
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
    /// As [`Model::write`](super::Model::write).
    pub fn write(&self, path: &Path) -> Result<()> {
        if let [only] = self.sets() {
            return only.write(path);
        }
        let mut headers = Vec::new();
        let mut arrays = Arrays::new(path);
        for set in self.sets() {
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
        let run = self.run().iter().map(|&run| run as f64);
        arrays.put(RUN, Values::F64(Array1::from_iter(run).into_dyn()));
        put_down(path, &json!({ BANK: headers }).to_string(), &arrays)
    }
}
